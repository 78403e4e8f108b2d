"""Does the tool meet the surface that it left a turn before: does run-out fade, and does the cut waver where theory says so?"""

from __future__ import annotations

from math import atan2, pi, sqrt

import numpy as np
import pytest
from evat.native.kernel import Contact

FEED, TURN = 1e-4, 0.02  # [m], [s]


def thickness(contact: Contact, times: np.ndarray) -> np.ndarray:
    thicknesses = []
    for time in times:
        contact.advance(float(time) - contact.time)
        thicknesses.append(contact.get("uncut_thickness_used"))
    return np.array(thicknesses)


@pytest.mark.parametrize("split", [1, 7])
def test_run_out_is_cut_away_in_one_turn(split: int) -> None:
    """Work that is clamped out of its middle is round about the spindle once it has been cut all round."""
    values = {"run_out.amplitude": 2e-5, "run_out.spindle_frequency": 1 / TURN, "regenerative.revolution_time": TURN}
    contact = Contact({"kinematics": "external", "slip_velocity": 0.1, "uncut_thickness": FEED, **values}, ("run_out", "regenerative"))
    contact.start()
    h = thickness(contact, TURN * np.arange(1, 150 * split) / (50 * split))
    first, later = h[: 50 * split - 1], h[52 * split :]
    assert np.ptp(first) == pytest.approx(4e-5, rel=2e-3)
    assert np.abs(later - FEED).max() < 2e-3 * 2e-5  # straight lines between 200 places of a turn


def test_a_tool_in_the_air_leaves_the_surface_to_the_next_turn() -> None:
    """Over a step deeper than the feed nothing is cut; the next turn meets the feeds of both."""
    values = {"run_out.amplitude": 6e-5, "run_out.spindle_frequency": 0.5 / TURN, "regenerative.revolution_time": TURN}
    contact = Contact(
        {"kinematics": "external", "slip_velocity": 0.1, "uncut_thickness": 1e-5, "feed": 1e-5, **values}, ("run_out", "regenerative")
    )
    contact.start()
    h = thickness(contact, TURN * np.arange(1, 400) / 50)
    assert np.any(h == 0)  # the surface sinks by more than the feed: in the air
    assert h.max() > 1.5e-5


def grown(width_share: float) -> float:
    """How much the waver of a cut grows over ten turns at a share of the width that theory allows, at the speed where it allows least.

    Tlusty 1963, Tobias and Fishwick 1958: k_cut_lim = -1/(2 min Re G), at the frequency w sqrt(1 + 2 zeta).
    """
    compliance, frequency, zeta, rake, tau = 1e-7, 150.0, 0.04, -0.3, 4e8
    w = 2 * pi * frequency
    per_width = (
        2 * tau * np.sin(-rake) / (np.cos(rake) + np.sin(rake))
    )  # feed force over width and thickness: -N sin(rake), constant friction
    limit = 2 * zeta * (1 + zeta) / compliance / per_width
    w_c = w * sqrt(1 + 2 * zeta)
    answer = 1 / (1 - (w_c / w) ** 2 + 2j * zeta * w_c / w)
    turn = (2 * pi * 2 + 3 * pi + 2 * atan2(answer.imag, answer.real)) / w_c
    values = {
        "kinematics": "external",
        "friction_law": "coulomb",
        "slip_velocity": 0.1,
        "uncut_thickness": FEED,
        "feed": FEED,
        "rake_angle": rake,
        "shear_stress": tau,
        "width": width_share * limit,
        "F_C": 1e-3,
        "holder_compliance.compliance_x": 0.0,
        "holder_compliance.compliance_y": compliance,
        "holder_compliance.natural_frequency": frequency,
        "holder_compliance.damping_ratio": zeta,
        "regenerative.revolution_time": turn,
    }
    contact = Contact(values, ("holder_compliance", "regenerative"))
    contact.start()
    h = thickness(contact, turn * np.arange(1, 1600) / 80)
    early, late = h[6 * 80 : 8 * 80], h[16 * 80 : 18 * 80]
    return float(np.ptp(late) / np.ptp(early))


def test_chatter_sets_in_at_the_width_of_theory() -> None:
    assert grown(0.85) < 0.8
    assert grown(1.15) > 1.2


def test_the_surface_is_part_of_the_state() -> None:
    contact = Contact(
        {"kinematics": "external", "uncut_thickness": FEED, "run_out.spindle_frequency": 50.0, "regenerative.revolution_time": TURN},
        ("run_out", "regenerative"),
    )
    contact.start()
    thickness(contact, TURN * np.arange(1, 60) / 50)
    twin = contact.copy()
    times = contact.time + TURN * np.arange(1, 60) / 50
    assert np.array_equal(thickness(contact, times), thickness(twin, times))


def test_a_vibrating_tool_on_a_soft_holder_meets_what_it_left_a_turn_before() -> None:
    """Run-out lets no two vibration cycles leave the same; 1200 of them lie in a turn. Against the same cut without the effect, which is
    led along what the holder's motion, kept by the test, has left."""
    turn, frequency, tolerance, each = 0.06, 20e3, 1e-4, 8  # samples a cycle
    values: dict[str, float | str] = {
        "kinematics": "combined", "vibration_frequency": frequency, "amplitude_x": 5e-6, "amplitude_y": 5e-6, "cutting_speed": 1 / 6,
        "feed": FEED, "relative_tolerance": tolerance, "run_out.spindle_frequency": 7.3, "regenerative.revolution_time": turn,
    }  # fmt: skip
    count = round(turn * frequency * each)
    times = turn / count * np.arange(2 * count + 1)
    contact = Contact(values, ("run_out", "holder_compliance", "regenerative"))
    contact.start()
    shown = contact.run(times, {}, ["uncut_thickness_used"])[:, 0]
    wave = 5e-6 * np.sin(2 * pi * 7.3 * times)

    def led(along: np.ndarray) -> np.ndarray:
        twin = Contact({**values, "tool_displacement_y": float(along[0])}, ("run_out", "holder_compliance"))
        twin.start()
        names = ["uncut_thickness_used", "holder_compliance.displacement_y"]
        return twin.run(times[: len(along)], {"tool_displacement_y": along}, names)

    first = led(np.zeros(count + 1))
    left = first[:, 1] - wave[: count + 1]
    both = led(np.append(np.zeros(count), -left))
    error = np.abs(shown - both[:, 0]) / (tolerance * FEED)
    assert np.quantile(error, 0.99) < 1
    assert np.abs(both[count:, 0] - first[:, 0]).max() > 100 * tolerance * FEED
