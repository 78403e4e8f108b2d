"""When does the tool cut, how thick is the chip, and which way does it slip? Shamoto's geometry, from the kernel's own events."""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt, tan

import numpy as np
import pytest
from driving import AMPLITUDE, ELLIPSE, OMEGA, PERIOD, at_angle, at_speed_ratio, events, read, started
from evat.model import SimulationError
from evat.native import kernel
from scipy.optimize import brentq

# Printed to four digits (five for the cusp): half a unit of the last.
TABLE = {  # HSR: entry, exit [rad], duty, cusp over amplitude
    0.05: (0.1501, 1.6208, 0.2819, 0.01125),
    0.1: (0.2893, 1.6710, 0.3120, 0.04154),
    0.2: (0.5459, 1.7722, 0.3689, 0.14532),
    0.3: (0.7852, 1.8755, 0.4235, 0.29272),
    0.5: (1.2461, 2.0944, 0.5317, 0.68098),
}
FORCES = ("friction_force", "principal_force", "feed_force", "normal_force")


def entry_and_exit(values: dict[str, float | str]) -> tuple[float, float]:
    """Angles w t of entry (counted before the bottom) and exit in the second cycle."""
    contact = started(values)
    contact.advance(PERIOD / 2)
    turned = {bool(after[0]): OMEGA * t for t, before, after in events(contact, PERIOD, "in_contact") if before[0] != after[0]}
    return 2 * pi - turned[True], turned[False] - 2 * pi


@pytest.mark.parametrize("r", TABLE)
def test_entry_exit_and_duty(r: float) -> None:
    theta_s, theta_e, duty, _ = TABLE[r]
    entry, exit_ = entry_and_exit(at_speed_ratio(r))
    assert (entry, exit_) == pytest.approx((theta_s, theta_e), abs=5.1e-5)
    contact = started(at_speed_ratio(r))
    contact.advance(3 * PERIOD)
    assert contact.get("mean_contact_ratio") == pytest.approx(duty, abs=5.1e-5)
    assert contact.get("speed_ratio") == pytest.approx(r, rel=1e-14)


@pytest.mark.parametrize("r", TABLE)
def test_entry_and_exit_solve_their_equations(r: float) -> None:
    """Far below the table's digits: an event is closed to a thousandth of the tolerance of a step."""
    entry, exit_ = entry_and_exit(at_speed_ratio(r))
    assert r * (pi - entry) == pytest.approx(sin(entry), abs=1e-10)
    assert exit_ == pytest.approx(acos(-r), abs=1e-10)


@pytest.mark.parametrize("r", TABLE)
def test_cusp_is_where_the_nominal_surface_begins_to_bind(r: float) -> None:
    """A nominal surface just above the cusps leaves the entry alone; just below them the tool enters where it dips under it."""
    cusp = TABLE[r][3]
    theta_s = entry_and_exit(at_speed_ratio(r))[0]
    above = entry_and_exit(at_speed_ratio(r, feed=(cusp + 5.1e-6) * AMPLITUDE))[0]
    below = entry_and_exit(at_speed_ratio(r, feed=(cusp - 5.1e-6) * AMPLITUDE))[0]
    assert above == pytest.approx(theta_s, abs=1e-9)
    assert below < theta_s - 1e-7
    assert below == pytest.approx(acos(1 - cusp + 5.1e-6), abs=1e-9)


def surface_by_sweeping(r: float, psi: np.ndarray, lead: float, cycles: int = 3) -> np.ndarray:
    """Lowest height over the centre, in amplitudes, that any earlier cycle reached at the place of each psi; infinity where none did."""
    turns = np.linspace(-pi, pi, 400001)
    x, y = r * turns + np.sin(turns), -np.cos(turns + lead)
    forward = np.flatnonzero(np.cos(turns) > -r)
    place = r * psi + np.sin(psi)
    lowest = np.full(psi.shape, np.inf)
    for n in range(1, cycles + 1):
        height = np.interp(place, x[forward] - 2 * pi * n * r, y[forward], left=np.inf, right=np.inf)
        lowest = np.minimum(lowest, height)
    return lowest


@pytest.mark.parametrize("feed", [1e-2, 1.2e-6])
@pytest.mark.parametrize("r", [0.02, 0.3, 0.9])
def test_thickness_is_what_a_sweep_of_the_earlier_paths_leaves(r: float, feed: float) -> None:
    """Every earlier cycle of the tool removes what it passes; three of them, on a fine grid, without the kernel's formulas."""
    values = at_speed_ratio(r, feed=feed)
    theta_s, theta_e = entry_and_exit(values)
    psi = np.linspace(-theta_s, theta_e, 203)[1:-1]
    top = np.minimum(surface_by_sweeping(r, psi, 0) * AMPLITUDE, feed - AMPLITUDE)
    expected = top + AMPLITUDE * np.cos(psi)
    thickness = np.array([at_angle(angle % (2 * pi), values, "uncut_thickness_used")[0] for angle in psi])
    assert thickness == pytest.approx(expected, abs=1e-7 * AMPLITUDE + 1e-13 * feed)  # grid of the sweep, at its wall


def test_thickness_jumps_where_only_the_nominal_surface_stands() -> None:
    """Past the farthest place of the cycle before, x = r acos(-r) + sqrt(1 - r^2), the tool meets the full feed."""
    r, feed = 0.3, 1e-4
    last = acos(-r)
    place = brentq(lambda psi: r * psi + sin(psi) - (r * (last - 2 * pi) + sqrt(1 - r * r)), -acos(-r), last)
    jumps = [
        (t, before[0], after[0])
        for t, before, after in events(started(at_speed_ratio(r, feed=feed)), PERIOD, "uncut_thickness_used")
        if before[0] > 0 and after[0] > 2 * before[0]
    ]
    assert len(jumps) == 1
    time, before, after = jumps[0]
    assert OMEGA * time == pytest.approx(2 * pi + place, abs=1e-9)
    assert before == pytest.approx(AMPLITUDE * (r + cos(place)), rel=1e-7)  # the wall where the cycle before left, at a height of a r
    assert after == pytest.approx(feed - AMPLITUDE + AMPLITUDE * cos(place), rel=1e-12)


@pytest.mark.parametrize("phi", [0.3, pi / 6, 0.9])
@pytest.mark.parametrize("r", [0.1, 0.5])
def test_friction_reverses_where_the_tool_rises_faster_than_the_chip(r: float, phi: float) -> None:
    """u_y = u_x tan(phi): sin(psi) = (r + cos(psi)) tan(phi), which is r sin(phi) = sin(psi - phi)."""
    contact = started(at_speed_ratio(r, chip_flow_shear_angle=phi))
    names = ("slip_velocity_used", "in_contact", "friction_force")
    reversals = [(t, before) for t, before, after in events(contact, PERIOD / 2, *names) if after[1] and abs(before[0]) < 1e-9]
    assert len(reversals) == 1
    expected = phi + np.arcsin(r * sin(phi))
    assert OMEGA * reversals[0][0] == pytest.approx(expected, abs=1e-9)
    for angle, sign in ((expected - 0.01, 1), (expected + 0.01, -1)):
        assert np.sign(at_angle(angle, at_speed_ratio(r, chip_flow_shear_angle=phi), "slip_velocity_used")[0]) == sign


@pytest.mark.parametrize("alpha", [-0.3, 0.0, 0.2])
def test_slip_is_that_of_a_rigid_chip_on_one_shear_plane(alpha: float) -> None:
    phi, r = 0.5, 0.3
    values = at_speed_ratio(r, rake_angle=alpha, chip_flow_shear_angle=phi)
    for angle in np.linspace(0, 2 * pi, 12):
        u_x, u_y = AMPLITUDE * OMEGA * np.array([r + cos(angle), sin(angle)])
        V_s = (u_x * cos(alpha) + u_y * sin(alpha)) / cos(phi - alpha)
        expected = V_s * sin(phi - alpha) + u_x * sin(alpha) - u_y * cos(alpha)
        assert at_angle(angle, values, "slip_velocity_used")[0] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("r", [1.0, 1.5, 4.0])
def test_contact_is_continuous_from_a_speed_ratio_of_one(r: float) -> None:
    feed = 1e-4
    contact = started(at_speed_ratio(r, feed=feed))
    contact.advance(2 * PERIOD)
    assert contact.get("mean_contact_ratio") == pytest.approx(1, abs=1e-12)
    for angle in (0.1, 2.0, 4.0):
        thickness = at_angle(angle, at_speed_ratio(r, feed=feed), "uncut_thickness_used")[0]
        assert thickness == pytest.approx(feed - AMPLITUDE + AMPLITUDE * cos(angle), rel=1e-12)


def test_without_vibration_it_is_conventional_turning() -> None:
    v_c, feed, phi = 0.2, 1e-4, 0.5
    values = {**ELLIPSE, "amplitude_x": 0.0, "amplitude_y": 0.0, "cutting_speed": v_c, "feed": feed, "chip_flow_shear_angle": phi}
    contact = started(values)
    contact.advance(50 * PERIOD)  # 30 time constants g/(sigma0 v)
    names = ("uncut_thickness_used", "slip_velocity_used", "mean_contact_ratio", "speed_ratio")
    assert read(contact, *names) == pytest.approx([feed, v_c * tan(phi), 1, 0], rel=1e-12)
    before = read(contact, *FORCES)
    assert read(contact, *[f"mean_{name}" for name in FORCES]) == pytest.approx(before, rel=1e-9)
    contact.advance(10.3 * PERIOD)
    assert read(contact, *FORCES) == pytest.approx(before, rel=1e-9)


@pytest.mark.parametrize("exponent", [1.0, 1.2])
def test_a_tool_that_does_not_vibrate_is_followed_by_its_speed(exponent: float) -> None:
    """At 200 samples of the cutting speed a second: a step to the end of each averaging window was a hundred to a sample, and a law whose
    rate goes by its deflection took two thousand, a twentieth of a cycle each."""
    values = {"amplitude_x": 0.0, "amplitude_y": 0.0, "feed": 1e-4, "cutting_speed": 0.2, "lugre.presliding_exponent": exponent}
    names = ("principal_force", "mean_principal_force", "mean_measured_feed_force", "mean_friction_force")
    times = np.arange(41) * 5e-3
    fine = np.arange(4001) * PERIOD
    speed = 0.2 + 0.05 * np.sin(40 * times)
    contact = started(values)
    rows = contact.run(times, {"cutting_speed": speed}, names)
    assert contact.get("step_count") < 10 * times.size
    each = started(values).run(fine, {"cutting_speed": np.interp(fine, times, speed)}, names)
    assert rows[1:] == pytest.approx(each[100::100], rel=2e-5)


def test_means_go_on_after_a_step_that_has_ended_early() -> None:
    """Where the step has no end: windows to which it had not come were taken for passed, and the mean stood still for half a second."""
    bonds = {"friction_law": "bristle", "amplitude_x": 0.0, "amplitude_y": 0.0, "feed": 1e-4, "cutting_speed": 0.5}
    contact = started(bonds)
    contact.advance(1e-3)
    before = contact.get("mean_friction_force")
    with pytest.raises(SimulationError, match="without end"):
        contact.advance(1.0)
    means = []
    for _ in range(40):
        contact.advance(PERIOD)
        means.append(contact.get("mean_friction_force"))
    assert np.unique(means).size == len(means)
    assert np.ptp([before, *means]) < before


@pytest.mark.parametrize("shift", [0.7, 2.5, -1.9])
def test_a_phase_shift_of_both_axes_is_a_shift_in_time(shift: float) -> None:
    plain, shifted = at_speed_ratio(0.3), at_speed_ratio(0.3, phase_x=-pi / 2 + shift, phase_y=pi + shift)
    first, second = started(plain, time=0), started(shifted, time=-shift / OMEGA)
    for step in (0.13 * PERIOD, 0.4 * PERIOD, 0.77 * PERIOD, 5.03 * PERIOD):
        first.advance(step)
        second.advance(step)
        assert read(second, *FORCES) == pytest.approx(read(first, *FORCES), rel=1e-6, abs=1e-5)  # both to their tolerance of 1e-8


@pytest.mark.parametrize("lead", [-0.6, 0.4])
def test_a_tilted_ellipse_meets_the_surface_that_it_left(lead: float) -> None:
    """The phase between the axes off 90 degrees: against the sweep."""
    r = 0.3
    values = at_speed_ratio(r, phase_y=pi + lead)
    for angle in np.linspace(-0.4, 1.5, 20):
        thickness, cutting = at_angle(angle % (2 * pi), values, "uncut_thickness_used", "in_contact")
        left = surface_by_sweeping(r, np.array([angle]), lead)[0]
        expected = min(AMPLITUDE * left, 1e-2 - AMPLITUDE) + AMPLITUDE * cos(angle + lead)
        assert cutting == (expected > 0)
        assert thickness == pytest.approx(max(expected, 0), abs=1e-7 * AMPLITUDE + 1e-15)


def test_a_machine_that_moves_the_tool_adds_its_velocity() -> None:
    """Slip of an ellipse carried at a constant velocity = slip at the sum of the speeds."""
    v_c, extra, lift = 0.1, 0.05, 0.02
    carried = {**at_speed_ratio(0.0), "cutting_speed": v_c, "kinematics": "combined", "tool_velocity_x": extra, "tool_velocity_y": lift}
    faster = {**at_speed_ratio(0.0), "cutting_speed": v_c + extra}
    for angle in np.linspace(0, 2 * pi, 9):
        moved, plain = (at_angle(angle, values, "slip_velocity_used")[0] for values in (carried, faster))
        assert moved == pytest.approx(plain - lift, abs=1e-14)


def test_a_machine_that_lifts_the_tool_thins_the_chip() -> None:
    """Where the nominal surface stands the chip gets thinner by the displacement, and the cut ends when it is used up."""
    values = {**at_speed_ratio(1.5), "feed": 1e-4, "kinematics": "combined"}
    full = at_angle(0.3, values, "uncut_thickness_used")[0]
    for rise in (1e-5, 6e-5):
        assert at_angle(0.3, {**values, "tool_displacement_y": rise}, "uncut_thickness_used")[0] == pytest.approx(full - rise, rel=1e-12)
    assert at_angle(0.3, {**values, "tool_displacement_y": 1.1e-4}, "in_contact")[0] == 0


def test_a_displacement_along_the_cut_has_no_effect_and_its_table_says_so() -> None:
    """The work is the same all along the cut: not a bit changes, and nobody has to give the input."""
    values = {**at_speed_ratio(0.3, feed=1e-5), "kinematics": "combined"}
    shown = []
    for place in (0.0, 3e-6):
        contact = started({**values, "tool_displacement_x": place})
        contact.advance(1.7 * PERIOD)
        shown.append(read(contact, "uncut_thickness_used", "mean_contact_ratio", *FORCES).tobytes())
    assert shown[0] == shown[1]
    told = kernel.variable("tool_displacement_x")
    assert "has no effect" in told.meaning
    assert told.required_with == ()
    assert kernel.variable("tool_displacement_y").required_with == ("combined",)


def test_out_of_contact_there_is_no_force() -> None:
    values = at_speed_ratio(0.3)
    for angle in (2.0, pi, 5.0):
        assert not at_angle(angle, values, "in_contact", "uncut_thickness_used", *FORCES, "dissipated_power").any()


def test_frequency_and_amplitude_only_scale_the_ellipse() -> None:
    """Entry and exit depend on the speed ratio alone: another frequency and size, the same angles."""
    r, f, a = 0.3, 137.0, 2e-4
    values = {**at_speed_ratio(r), "vibration_frequency": f, "amplitude_x": a, "amplitude_y": 3 * a, "cutting_speed": r * a * 2 * pi * f}
    contact = started(values)
    turned = [2 * pi * f * t for t, before, after in events(contact, 1 / f, "in_contact") if before[0] != after[0]]
    assert turned == pytest.approx([TABLE[r][1], 2 * pi - TABLE[r][0]], abs=5.1e-5)
