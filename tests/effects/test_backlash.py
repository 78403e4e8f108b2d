"""Does a motion that turns round cross the gap before it moves the contact? Ways that are counted, and an equation of our own by scipy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from asking import OUTSIDE, begun, follow
from driving import Values, read
from evat.native.kernel import Contact
from scipy.integrate import solve_ivp

ON = ("backlash",)
GAP, F_C, SIGMA0 = 4e-5, 6.0, 5e7
ROUNDED = 0.1  # kernel/effects/stop_operator.h
LEVEL: Values = {**OUTSIDE, "sigma0": SIGMA0, "F_C": F_C, "F_S": F_C, "sigma1": 0.0, "sigma2": 0.0, "backlash.gap": GAP}


@pytest.mark.parametrize("speed", [1e-4, 1e-1])
def test_after_each_reversal_the_contact_stands_still_over_the_gap(speed: float) -> None:
    """From the middle half a gap is lost, at each reversal a whole one; at any speed. Force and slip wait for it."""
    contact = begun({**LEVEL, "slip_velocity": speed}, ON)
    contact.advance(10 * GAP / speed)
    assert read(contact, "sliding_distance", "friction_force") == pytest.approx([9.5 * GAP, F_C], rel=1e-4)
    for turn in range(3):
        sign = -((-1.0) ** turn)
        contact.set("slip_velocity", sign * speed)
        before = read(contact, "sliding_distance")[0]
        contact.advance(0.9 * GAP / speed)
        waits = read(contact, "sliding_distance", "friction_force", "slip_velocity_used")
        assert waits[0] - before == pytest.approx(0, abs=1e-3 * GAP)
        assert waits[1] == pytest.approx(-sign * F_C, rel=1e-3)
        assert waits[2] == pytest.approx(0, abs=2e-6 * speed)
        contact.advance(9.1 * GAP / speed)
        moved = read(contact, "sliding_distance", "friction_force", "slip_velocity_used")
        assert moved - [before, 0, 0] == pytest.approx([9 * GAP, sign * F_C, sign * speed], rel=1e-4)


def test_small_motions_within_the_gap_move_nothing() -> None:
    times = np.linspace(0, 0.1, 501)
    slip = 0.4 * GAP * 2 * np.pi * 40 * np.cos(2 * np.pi * 40 * times)
    way, force = follow(times, {"slip_velocity": slip}, LEVEL, ON, "sliding_distance", "friction_force")
    assert np.abs(way).max() < 2e-5 * GAP  # of 6 gaps that the motion goes to and fro
    assert np.abs(force).max() < 1e-2 * F_C


def test_an_uneven_motion_is_that_of_the_equation() -> None:
    """The gap, the contact's bristle and its way by LSODA at 1e-11, from corner to corner and reversal to reversal."""
    values: Values = {**LEVEL, "sigma0": 2e6, "sigma2": 4.0}
    corners, speeds = np.array([0, 0.01, 0.02, 0.03, 0.035, 0.06]), np.array([1e-3, 2e-2, -1e-2, -3e-3, 6e-3, 1e-2])
    times = np.linspace(0, 0.06, 121)
    names = ("friction_force", "backlash.place", "sliding_distance")
    computed = follow(times, {"slip_velocity": np.interp(times, corners, speeds)}, values, ON, *names)

    def passed(v: float, y: float) -> float:
        return 1 - (1 - 1e-6) * min(1.0, (1 - np.sign(v) * y) / ROUNDED)

    def rates(t: float, state: np.ndarray) -> list[float]:
        v = float(np.interp(t, corners, speeds))
        slip = v * passed(v, state[1])
        return [slip - 2e6 * abs(slip) / F_C * state[0], 2 * v / GAP * min(1.0, (1 - np.sign(v) * state[1]) / ROUNDED), abs(slip)]

    turns = [0.01 + 0.01 * 2 / 3, 0.03 + 0.005 / 3]
    y, rows = np.zeros(3), [[0.0, 0.0, 0.0]]
    for low, high in pairwise(np.unique(np.concatenate([times, corners, turns]))):
        inside = 1e-12 * (high - low)
        y = solve_ivp(rates, (low + inside, high - inside), y, "LSODA", rtol=1e-11, atol=[1e-16, 1e-13, 1e-15]).y[:, -1]
        if np.min(np.abs(times - high)) < 1e-12:
            v = float(np.interp(high, corners, speeds))
            rows.append([2e6 * y[0] + 4.0 * v * passed(v, y[1]), y[1], y[2]])
    right = np.array(rows).T
    for got, wanted, size in zip(computed, right, (F_C, 1.0, GAP), strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-5 * size)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-7, 1e-9])
def test_a_slip_that_is_solved_for_behind_a_gap_takes_few_steps(tolerance: float) -> None:
    """Where force and load both begin at 0 the slip moves by some thousandths in any step, and that was asked to be less in each."""
    values = {
        "backlash.gap": 6.6724804522756e-07, "friction_law": "dahl", "chip_flow_angle": "current_shear_angle", "sigma0": 478103.0,
        "F_C": 6.0425799762286, "release_time": 1e-05, "cutting_speed": 0.20908509346357512, "amplitude_y": 8.929979150023057e-06,
        "feed": 2.0601060538364908e-05, "relative_tolerance": tolerance,
    }  # fmt: skip
    contact = Contact(values, ["backlash"])
    contact.start()
    contact.advance(6.3 / 20e3)
    assert contact.get("step_count") < 10_000
    assert contact.get("dissipated_energy") == pytest.approx(4.45700e-5, rel=3e-6 + 3 * tolerance)
