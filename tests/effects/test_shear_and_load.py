"""Do the effects on shear stress and edge change forces as cutting tests show? Intercepts, powers, logarithms, wear, a one-sided damper."""

from __future__ import annotations

from math import log, pi

import numpy as np
import pytest
from asking import CONSTANT, FASTEST, OUTSIDE, begun, course, follow
from driving import AMPLITUDE, FREQUENCY, PERIOD, Values, read
from evat.native import kernel

WIDTH, SHEAR_STRESS = 1e-3, 4e8  # m, Pa
CHIP = ("principal_force", "feed_force")
BARE = {**CONSTANT, "F_C": 1e-6}  # as good as no friction: then the principal force is 2 tau_s w h
TURNING = {"amplitude_x": 0.0, "amplitude_y": 0.0}  # no vibration: one long cut


def at(on: list[str], values: dict[str, float | str], *names: str) -> np.ndarray:
    contact = begun(values, on)
    contact.evaluate()
    return read(contact, *names)


def over_thickness(thickness: np.ndarray, on: list[str], **values: float | str) -> np.ndarray:
    """Principal and feed force at each uncut thickness."""
    given = {**OUTSIDE, **CONSTANT, "slip_velocity": 0.5, **values}
    return np.array([at(on, {**given, "uncut_thickness": float(h)}, *CHIP) for h in thickness]).T


@pytest.mark.parametrize("width", [1e-3, 4e-3])
def test_edge_force_is_the_intercept_of_force_over_thickness(width: float) -> None:
    """In proportion to the width, on a slope that stays; nothing where nothing is cut."""
    thickness = np.linspace(2e-5, 2e-4, 7)
    own = {"edge_force.K_ep": 7e3, "edge_force.K_ef": 1.1e4}
    sharp, blunt = (over_thickness(thickness, on, width=width, rake_angle=0.15, **own) for on in ([], ["edge_force"]))
    lines = [np.polyfit(thickness, forces.T, 1) for forces in (sharp, blunt)]
    for (slope, intercept), forces in zip(lines, (sharp, blunt), strict=True):
        assert np.outer(slope, thickness).T + intercept == pytest.approx(forces.T, rel=1e-12)
    assert lines[1][0] == pytest.approx(lines[0][0], rel=1e-10)  # slopes of 1e6 N/m, forces rounded at 1e-13 N
    assert lines[1][1] - lines[0][1] == pytest.approx([7e3 * width, 1.1e4 * width], rel=1e-10)
    assert np.all(over_thickness(np.array([0, -1e-5]), ["edge_force"], **own) == 0)


def edge(under: float, radius: float, stress: float, mu: float) -> np.ndarray:
    """Forces of a round edge up to a height: its pressure and friction on 20 000 pieces of the arc, psi from its lowest point."""
    psi = (np.arange(20_000) + 0.5) / 20_000 * np.arccos(1 - under / radius)
    pushed = np.array([np.sin(psi), np.cos(psi)])  # on the tool: back and up
    dragged = np.array([np.cos(psi), -np.sin(psi)])  # the work flows down along the arc and out behind
    return np.mean(pushed + mu * dragged, axis=1) * np.arccos(1 - under / radius) * radius * stress * WIDTH


@pytest.mark.parametrize(("radius", "share"), [(1e-5, 0.4), (3e-5, 0.2), (6e-6, 1.0)])
def test_what_is_thinner_than_the_minimum_is_ploughed_and_only_what_lies_above_is_sheared(radius: float, share: float) -> None:
    """Force over thickness is that of the plain tool, moved by h_min = share r, beside a constant; below h_min all flows under the edge.
    Both constants are those of the arc: an edge of twice the radius ploughs with twice the force."""
    h_min, stress, mu, name = share * radius, 7e8, 0.25, "minimum_chip_thickness"
    own = {f"{name}.edge_radius": radius, f"{name}.share": share, f"{name}.stress": stress, f"{name}.friction": mu}
    thickness, on = np.linspace(1e-5, 2e-4, 7) + h_min, [name]
    ploughed, chip = over_thickness(thickness, on, **own), over_thickness(thickness - h_min, [])
    assert ploughed - chip == pytest.approx(np.outer(edge(h_min, radius, stress, mu), np.ones(7)), rel=1e-7)
    thin = np.linspace(0.1, 0.9, 5) * h_min
    rubbed = over_thickness(thin, on, **BARE, **own)
    assert rubbed == pytest.approx(np.array([edge(h, radius, stress, mu) for h in thin]).T, abs=1e-5)  # friction of 1e-6 N beside 0.3 N
    assert np.all(over_thickness(np.array([0, -1e-5]), on, **own) == 0)
    bend = over_thickness(np.array([h_min * (1 - 1e-9), h_min * (1 + 1e-9)]), on, **BARE, **own)
    assert np.diff(bend)[:, 0] == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("m", [0.15, 0.3])
def test_size_effect_is_a_power_of_the_thickness(m: float) -> None:
    """log F over log h has the slope 1 - m and passes the plain tool's force at h_ref; no intercept: force vanishes with the chip."""
    h_ref, thickness = 8e-5, np.geomspace(1e-6, 1e-3, 13)
    own = {"size_effect.exponent": m, "size_effect.h_ref": h_ref}
    F_p = over_thickness(thickness, ["size_effect"], **BARE, **own)[0]
    slopes = np.diff(np.log(F_p)) / np.diff(np.log(thickness))
    assert slopes == pytest.approx(1 - m, abs=1e-5)  # friction of 1e-6 N beside 1 N at the thinnest
    there, plain = (over_thickness(np.array([h_ref]), on, **own) for on in (["size_effect"], []))
    assert there == pytest.approx(plain, rel=1e-12)
    specific = F_p / (WIDTH * thickness)
    assert np.all(np.diff(specific) < 0)
    assert over_thickness(np.array([1e-12]), ["size_effect"], **BARE, **own)[0, 0] < 1e-3


@pytest.mark.parametrize("law", ["coulomb", "lugre", "amontons"])
@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
def test_kienzle_s_exponent_is_that_of_the_specific_cutting_force(law: str, principle: str) -> None:
    """k_c = F_p/(w h) over h has the slope -m whatever the friction, passes the shear plane's own at h_ref, and vanishes with the chip as
    h^(1 - m). The power of the shear stress alone (size_effect) has a lesser one, as friction of 9 N does not follow the load."""
    m, h_ref, thickness = 0.26, 8e-5, np.geomspace(1e-6, 1e-3, 13)
    given = {"friction_law": law, "F_C": 9.0, "F_S": 9.0, "shear_angle_principle": principle, "normal_load": 10.0}
    own = {"kienzle_force.exponent": m, "kienzle_force.h_ref": h_ref, "size_effect.exponent": m, "size_effect.h_ref": h_ref}
    specific = over_thickness(thickness, ["kienzle_force"], **given, **own)[0] / (WIDTH * thickness)
    assert np.diff(np.log(specific)) / np.diff(np.log(thickness)) == pytest.approx(-m, abs=1e-9)
    there, plain = (over_thickness(np.array([h_ref]), on, **given, **own) for on in (["kienzle_force"], []))
    assert there == pytest.approx(plain, rel=1e-12)
    by_stress = over_thickness(thickness, ["size_effect"], **given, **own)[0] / (WIDTH * thickness)
    exponents = -np.diff(np.log(by_stress)) / np.diff(np.log(thickness))
    assert np.ptp(exponents) > 0.05
    halfway = over_thickness(thickness, ["kienzle_force"], **given, **own, **{"kienzle_force.severity": 0.5})[0]
    none = over_thickness(thickness, [], **given)[0]
    assert halfway == pytest.approx(0.5 * (specific * WIDTH * thickness + none), rel=1e-12)


def test_kienzle_s_force_stands_normal_to_the_rake() -> None:
    """At a rake the difference to the shear plane's own forces lies along the rake's normal; friction and its slip stay."""
    alpha, names = 0.2, ("principal_force", "feed_force", "normal_force", "friction_force")
    given = {**OUTSIDE, **CONSTANT, "slip_velocity": 0.5, "rake_angle": alpha, "uncut_thickness": 3e-5}
    on, off = (at(which, given, *names) for which in (["kienzle_force"], []))
    change = on - off
    assert change[2] > 1
    assert change[:2] == pytest.approx([change[2] * np.cos(alpha), -change[2] * np.sin(alpha)], rel=1e-9)
    assert change[3] == 0


def stress(theta: float, speed: float, **own: float) -> float:
    """Shear stress over the plain one, of a long cut at a speed and a temperature proxy."""
    values = {**BARE, **TURNING, "cutting_speed": speed, "proxy_source": "proxy_speed", "proxy_speed": theta, "theta_ref": 2.0}
    named = {f"flow_stress_softening.{name}": value for name, value in own.items()}
    return float(at(["flow_stress_softening"], {**values, **named}, "principal_force")[0]) / (2 * SHEAR_STRESS * WIDTH * 1e-4)


def test_flow_stress_rises_with_the_logarithm_of_speed() -> None:
    """Johnson and Cook's rate term: the same step C ln 10 for each decade, far above v_ref; the plain stress at rest."""
    C, v_ref = 0.03, 1e-6
    stresses = [stress(0, speed, C=C, v_ref=v_ref, softening=0.2) for speed in (1e-2, 1e-1, 1, 10)]
    assert np.diff(stresses) == pytest.approx(C * log(10), rel=1e-4)  # 1 + u/v_ref for u/v_ref
    assert stress(0, 1e-9, C=C, v_ref=v_ref, softening=0.2) == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("m", [0.6, 1.0, 2.0])
def test_flow_stress_falls_with_the_temperature_proxy(m: float) -> None:
    """Johnson and Cook's thermal term: all at theta = 0, a loss that is a power of theta and is `softening` at theta_ref; and the two terms
    multiply, so that the relative loss is the same at every speed."""
    own = {"C": 0.03, "softening": 0.3, "exponent": m}
    proxies = np.array([0.25, 0.5, 1.0, 2.0])
    cases = (([0.0], 0.1), (proxies, 0.1), (proxies, 5.0))
    cold, slow, fast = (np.array([stress(theta, speed, **own) for theta in thetas]) for thetas, speed in cases)
    lost = 1 - slow / cold
    assert cold[0] > 1
    assert np.diff(np.log(lost)) / log(2) == pytest.approx(m, rel=1e-6)
    assert lost[-1] == pytest.approx(0.3, rel=1e-6)
    assert fast / fast[0] == pytest.approx(slow / slow[0], rel=1e-6)  # and friction of 1e-6 N beside 80 N
    assert stress(50.0, 0.1, **own) > 0  # molten, yet no chip pulls


def test_flank_wear_grows_with_the_distance_slid() -> None:
    """To and fro at the same motion: friction is the same each time, feed and principal force climb with the distance, whichever way; the
    way through the air wears nothing and a worn flank out of contact bears nothing."""
    turns = np.arange(601) / 100
    speed, in_air = 0.4 * np.sin(2 * pi * turns), (turns > 4) & (turns < 5)
    inputs = {"slip_velocity": speed, "uncut_thickness": np.where(in_air, -1e-4, 1e-4)}
    own = {"flank_wear.feed_rate": 2e4, "flank_wear.principal_rate": 5e3, "width": 2e-3}
    names = ("friction_force", *CHIP)
    worn, sharp = (follow(turns, inputs, {**CONSTANT, **own}, on, *names) for on in (["flank_wear"], []))
    friction, principal, feed = worn - sharp
    assert np.all(friction == 0)
    assert np.all((worn - sharp)[:, in_air] == 0)
    # speed is straight between the samples, and so is distance by the trapezoidal rule but where it reverses
    slid = np.append(0, np.cumsum(0.5 * np.abs(speed[1:] + speed[:-1]) * np.diff(turns)))
    slid -= np.where(turns > 4, slid[np.searchsorted(turns, np.minimum(turns, 5))] - slid[400], 0)
    cut = ~in_air & (turns > 0)
    close = 2 * 0.4 * 2 * pi / 100 / 100 / 4  # two halves of a sample's way, as the tool leaves the material and comes back
    assert feed[cut] / (2e4 * 2e-3) == pytest.approx(slid[cut], abs=close)
    assert principal[cut] / (5e3 * 2e-3) == pytest.approx(slid[cut], abs=close)
    assert np.diff(feed[:401:50]) == pytest.approx(feed[50], rel=1e-9)  # forth or back


@pytest.mark.parametrize("break_in", [0.05, 0.5, 1e4])
def test_forces_end_their_growth_once_the_edge_has_broken_in(break_in: float) -> None:
    """At first as fast as without a break-in, and in the end as far as on that distance; one far beyond the record is none."""
    times = np.linspace(0, 5, 501)
    own = {"flank_wear.feed_rate": 2e4, "flank_wear.principal_rate": 5e3, "width": 2e-3, "flank_wear.break_in": break_in}
    inputs = {"slip_velocity": np.full(times.size, 0.4), "uncut_thickness": np.full(times.size, 1e-4)}
    worn, sharp = (follow(times, inputs, {**CONSTANT, **own}, on, *CHIP) for on in (["flank_wear"], []))
    principal, feed = worn - sharp
    assert feed[1:] == pytest.approx(-2e4 * 2e-3 * break_in * np.expm1(-0.4 * times[1:] / break_in), rel=1e-6)
    assert principal[1:] == pytest.approx(feed[1:] / 4, rel=1e-6)
    assert (feed[-1] / feed[1] > 499) == (break_in > 1e3)


def pressed(on: list[str], times: np.ndarray, *names: str, **values: float | str) -> np.ndarray:
    return course(begun({**CONSTANT, "cutting_speed": 1.5 * FASTEST, **values}, on), times, *names)


def test_process_damping_is_half_a_damper() -> None:
    """A force only while the tool moves into the surface, against that motion. Of a small wave in a fast cut, half of what a viscous
    damper c = C w/V takes, pi c omega b^2: the coefficient over the cutting speed (Kurata, Altintas and Shamoto). It grows with the width
    and not with the thickness."""
    C, omega, times = 2e3, 2 * pi * FREQUENCY, np.linspace(0, PERIOD, 2001)
    small = {"amplitude_x": 0.0, "amplitude_y": 0.1 * AMPLITUDE}
    for width, feed, speed in ((1e-3, 1e-4, 2.0), (3e-3, 1e-4, 2.0), (1e-3, 2e-4, 2.0), (1e-3, 1e-4, 6.0)):
        values = {"process_damping.C": C, "width": width, "feed": feed, **small, "cutting_speed": speed}
        force = np.subtract(*(pressed(on, times, "feed_force", **values)[0] for on in (["process_damping"], [])))
        u_y = 0.1 * AMPLITUDE * omega * np.sin(2 * pi * FREQUENCY * times)  # y = -b cos(w t)
        assert np.all(force >= 0)
        assert np.all(force[u_y > 1e-9] == 0)
        assert np.all(force[u_y < -1e-6] > 0)
        taken = -np.trapezoid(force * u_y, times)
        assert taken == pytest.approx(0.5 * pi * C * width / speed * omega * (0.1 * AMPLITUDE) ** 2, rel=1e-6)


def test_a_flank_that_is_pressed_rubs() -> None:
    """Along the cut, in proportion to the force that presses: its friction coefficient is C_p over C."""
    times = np.linspace(0, PERIOD, 2001)
    values = {"process_damping.C": 2e3, "process_damping.C_p": 600.0, "amplitude_x": 0.0, "cutting_speed": 2.0}
    principal, feed = np.subtract(*(pressed(on, times, *CHIP, **values) for on in (["process_damping"], [])))
    assert feed.max() > 0.01
    assert principal == pytest.approx(0.3 * feed, rel=1e-9, abs=1e-9)
    rubbed = np.subtract(*(pressed(on, times, *CHIP, **{**values, "process_damping.C": 0.0}) for on in (["process_damping"], [])))
    assert rubbed[0] == pytest.approx(principal, abs=1e-9)
    assert np.all(rubbed[1] == 0)


def test_process_damping_grows_no_more_beyond_the_steepest_slope() -> None:
    """The law is one of small waves: where the path dives, the force stays at C w times the steepest slope."""
    times = np.linspace(0, PERIOD, 2001)
    values = {"process_damping.C": 2e3, "process_damping.steepest": 0.3, "amplitude_x": 0.0, "cutting_speed": 0.5}
    force = np.subtract(*(pressed(on, times, "feed_force", **values)[0] for on in (["process_damping"], [])))
    assert force.max() == pytest.approx(2e3 * WIDTH * 0.3, rel=1e-9)
    assert np.sum(force > 0.999 * force.max()) > 500  # of 1000 samples on the way down


def test_a_flank_is_pressed_where_the_path_goes_down_steeper_than_its_clearance() -> None:
    """Between entry and the place where the slope of the path has fallen to tan(clearance_angle); tan over there, C w above it."""
    times = np.linspace(0.5 * PERIOD, 1.5 * PERIOD, 2001)
    values: Values = {"process_damping.C": 2e3, "initial_state": "periodic", **CONSTANT}
    on = ["process_damping"]

    def force(clearance: float, ratio: float = 0.3) -> np.ndarray:
        given = {**values, "cutting_speed": ratio * FASTEST, "clearance_angle": clearance}
        return np.subtract(*(course(begun(given, names, float(times[0])), times, "feed_force")[0] for names in (on, [])))

    psi = 2 * pi * FREQUENCY * times - 2 * pi
    slope = -np.sin(psi) / (0.3 + np.cos(psi))  # of a round ellipse, b = a
    touching = (psi > -0.785) & (psi < 0)  # after entry, on the way down
    for clearance in (0.1, 0.3):
        pressed_down = np.where(touching, 2e3 * WIDTH * np.maximum(slope - np.tan(clearance), 0), 0)
        assert force(clearance)[np.abs(psi + 0.7852) > 0.01] == pytest.approx(pressed_down[np.abs(psi + 0.7852) > 0.01], abs=1e-9)
        assert 0 < np.count_nonzero(force(clearance)) < 250  # of 2000 samples a cycle
    assert np.any(force(0.14, ratio=0.05))  # the path at its entry goes down by 0.1429 rad
    assert np.all(force(0.15, ratio=0.05) == 0)


def test_process_damping_is_early_in_a_vibrating_cut() -> None:
    """With separation: between entry and the bottom of the path, the force largest at the entry, where the path is steepest, nothing later
    and nothing in the air; and the chip's own forces stay."""
    times = np.linspace(0.5 * PERIOD, 1.5 * PERIOD, 2001)  # the bottom of the path in the middle
    own: Values = {"process_damping.C": 2e3, "cutting_speed": 0.3 * FASTEST, "initial_state": "periodic"}
    names = ("feed_force", "in_contact", "principal_force", "friction_force", "bristle_deflection")
    damped, plain = (course(begun({**CONSTANT, **own}, on, float(times[0])), times, *names) for on in (["process_damping"], []))
    force, phase = damped[0] - plain[0], 2 * pi * FREQUENCY * times - 2 * pi
    assert np.array_equal(damped[1:], plain[1:])
    assert np.all(force[(damped[1] == 0) | (phase > 1e-9)] == 0)
    entry = phase[np.argmax(force > 0)]
    assert entry == pytest.approx(-0.7852, abs=2 * pi / 2000 + 1e-4)  # of this speed ratio, in closed form
    slope = 0.7069 / (0.3 + 0.7073)  # b w sin over v_c + a w cos, at 0.7852
    assert force.max() == pytest.approx(2e3 * WIDTH * slope, rel=1e-2)  # to a sample


def test_a_shear_stress_that_heat_would_take_away_is_said_to_be_held() -> None:
    """At its first start value the effect had held it at a hundredth in four fifths of the contact, without a word."""
    for softening, held in ((0.01, False), (0.1, True)):
        contact = begun({"flow_stress_softening.softening": softening}, ["flow_stress_softening"])
        contact.advance(2 * PERIOD)
        assert any("less than a hundredth of the shear stress" in said for said in contact.warnings()) == held
        assert (contact.get("clamped_count") > 0) == held
    assert kernel.variable("flow_stress_softening.softening").start == 0.01
