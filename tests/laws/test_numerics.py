"""Does the integrator find the solution, at the order and to the tolerance that it claims, whatever the steps it is asked for?"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import acos, log2, pi

import numpy as np
import pytest
from driving import AMPLITUDE, ELLIPSE, OMEGA, PERIOD, at_speed_ratio, cycle_by_runge_kutta, read, slide, started
from scipy.integrate import solve_ivp

STATES = ("bristle_deflection", "friction_impulse", "principal_impulse", "feed_impulse", "normal_impulse", "dissipated_energy")
SOFT = {"sigma0": 1e6, "F_C": 9.0, "F_S": 10.0, "v_s": 1e-2, "sigma2": 1.0, "sigma1": 0.0}
STRIBECK_DIPS = {  # narrow and deep ones: the paper's table 1 with speeds in m/min, and 1995
    "copper": {"sigma0": 9.966e6, "F_C": 0.1127, "F_S": 0.1135, "v_s": 0.0199 / 60, "sigma2": 0.523, "sigma1": 0.0},
    "Al 6061": {"sigma0": 3.5e5, "F_C": 9.97, "F_S": 0.1309, "v_s": 0.00978 / 60, "sigma2": 0.405, "sigma1": 0.0},
    "Al 7075": {"sigma0": 9.628e5, "F_C": 8.97, "F_S": 7.49, "v_s": 0.00987 / 60, "sigma2": 0.0159, "sigma1": 0.0},
    "Inconel": {"sigma0": 4.822e5, "F_C": 0.7379, "F_S": 2.56, "v_s": 0.00468 / 60, "sigma2": 0.523, "sigma1": 0.0},
    "1995": {"sigma0": 1e5, "F_C": 1.0, "F_S": 1.5, "v_s": 1e-3, "sigma2": 0.4, "sigma1": 0.0},
}


def unexplained(tolerance: float) -> float:
    """The change that one step may leave unexplained, relative to the largest bristle deflection: the kernel's own rule. Where the
    motion is smooth over a step its error is the tenth part of the 5/3rd power, a tolerance; where it is not, this much."""
    return (10 * tolerance) ** 0.6


def cut(values: Mapping[str, float], r: float, angles: np.ndarray, tolerance: float) -> np.ndarray:
    """The same as cycle_by_runge_kutta, by the kernel."""
    contact = started({**at_speed_ratio(r), **values, "relative_tolerance": tolerance}, time=PERIOD / 2)
    rows = []
    for stop in PERIOD * (1 + angles / (2 * pi)):
        contact.advance(stop - contact.time)
        rows.append(read(contact, "bristle_deflection", "friction_impulse", "dissipated_energy"))
    return np.array(rows)


def error(values: Mapping[str, float], tolerance: float, r: float = 0.27) -> float:
    """Largest error over a cut, relative to the largest value of each."""
    angles = np.linspace(-0.5, acos(-r) - 1e-3, 9)
    exact = cycle_by_runge_kutta(values, r, pi / 6, angles)
    return float(np.max(np.abs(cut(values, r, angles, tolerance) - exact) / np.abs(exact).max(axis=0)))


def test_error_follows_the_tolerance() -> None:
    tolerances = 10.0 ** np.arange(-4, -12.5, -1)
    errors = np.array([error(SOFT, tolerance) for tolerance in tolerances])
    assert np.all(errors < 0.3 * unexplained(tolerances))
    slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
    assert 0.7 < slope < 1.1  # measured: 0.82


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-4, 6e-4), (1e-6, 6e-6), (1e-8, 4e-6)])
@pytest.mark.parametrize("name", STRIBECK_DIPS)
def test_a_narrow_stribeck_dip_is_not_jumped_over(name: str, tolerance: float, bound: float) -> None:
    """On the ellipse, where the slip passes a dip in a thousandth of a cycle; read nine times in a cut, and once at any angle of it."""
    values, angles = STRIBECK_DIPS[name], np.linspace(-0.5, acos(-0.27) - 1e-3, 9)
    exact = cycle_by_runge_kutta(values, 0.27, pi / 6, angles)
    once = np.concatenate([cut(values, 0.27, angles[n : n + 1], tolerance) for n in range(9)])
    for rows in (cut(values, 0.27, angles, tolerance), once):
        error = np.max(np.abs(rows - exact) / np.abs(exact).max(axis=0))
        assert error < bound  # measured at 1e-4 and 1e-6: 0.2 to 4.2 tolerances; at 1e-8 up to 250, for the dip takes the order away


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize(("begin", "end"), [(0.2, -0.01), (0.2, 0.0), (0.1, -0.05)])
def test_a_deep_stribeck_dip_is_not_jumped_over(begin: float, end: float, tolerance: float) -> None:
    """Slip that falls steadily to rest or through it within 1 ms, where friction drops to a seventieth and the bristle's rate rises."""
    P, F_C, F_S, v_s, length = 1e6, 9.97, 0.1309, 1e-2, 1e-3

    def rate(t: float, z: np.ndarray) -> np.ndarray:
        v = begin + (end - begin) * t / length
        return v - P * abs(v) / (F_C + (F_S - F_C) * np.exp(-((v / v_s) ** 2))) * z

    z = [F_C / P]
    for bounds in pairwise(sorted({0, length * begin / (begin - end), length})):
        z = solve_ivp(rate, bounds, z, "DOP853", rtol=1e-13, atol=1e-22, max_step=length / 500).y[:, -1]
    values = {"sigma0": P, "F_C": F_C, "F_S": F_S, "v_s": v_s, "bristle_deflection": F_C / P, "relative_tolerance": tolerance}
    deflection = slide(np.array([0, length]), np.array([begin, end]), values, "bristle_deflection")[-1, 0]
    assert deflection == pytest.approx(z[0], abs=unexplained(tolerance) * F_C / P)


@pytest.mark.parametrize(("sigma0", "lowest", "highest"), [(1e4, 3.9, 4.1), (1e6, 3.9, 4.1), (1e7, 3.9, 4.1), (1e9, 1.6, 2.5)])
def test_order(sigma0: float, lowest: float, highest: float) -> None:
    """One internal step each communication step, where the slip keeps its sign. Fourth order while a step is shorter than g/(sigma0 v),
    second where it is a hundred times longer."""
    r, b, phi, count = 3.0, 2e-6, 0.6, 40
    values = {**ELLIPSE, **SOFT, "amplitude_y": b, "cutting_speed": r * AMPLITUDE * OMEGA, "feed": 1e-4, "chip_flow_shear_angle": phi}
    values |= {"sigma0": sigma0, "v_s": 0.5, "F_S": 12.0, "relative_tolerance": 1e-1}
    start, length = 0.05 * PERIOD, 0.4 * PERIOD

    def speed(t: float) -> float:
        return AMPLITUDE * OMEGA * (r + np.cos(OMEGA * t)) * np.tan(phi) - b * OMEGA * np.sin(OMEGA * t)

    def rate(t: float, z: np.ndarray) -> np.ndarray:
        v = speed(t)
        return v - sigma0 * v / (9 + 3 * np.exp(-((v / 0.5) ** 2))) * z

    def solution(z: float, begin: float, end: float) -> float:
        return float(solve_ivp(rate, (begin, end), [z], "Radau", rtol=1e-13, atol=1e-24).y[0, -1])

    z_start = solution(9 / sigma0, start - 0.2 * PERIOD, start)  # past the first transient, which no long step resolves
    exact = solution(z_start, start, start + length)
    errors = []
    for n in (count, 2 * count):
        contact = started({**values, "bristle_deflection": z_start}, time=start - 0.2 * PERIOD)
        contact.advance(0.2 * PERIOD)
        contact.set("bristle_deflection", z_start)
        before = contact.get("step_count")
        for _ in range(n):
            contact.advance(length / n)
        assert contact.get("step_count") - before == n
        errors.append(abs(contact.get("bristle_deflection") / exact - 1))
    assert lowest < log2(errors[0] / errors[1]) < highest


@pytest.mark.parametrize("step", [1e-9, 1e-7, 1e-5, 1e-3])
def test_stiff_slip_is_right_at_any_step(step: float) -> None:
    """sigma0 1e8 N/m, F_C 0.1 N, up to 1 m/s: rates to 1e9 1/s. The bristle sits on the Stribeck curve, the force with it."""
    values = {"kinematics": "external", "sigma0": 1e8, "F_C": 0.1, "F_S": 0.15, "v_s": 1e-2, "sigma2": 0.01, "sigma1": 1e-4}
    contact = started({**values, "slip_velocity": 1.0})
    contact.advance(1e-6)
    times = contact.time + step * np.arange(21)
    speed = 1 - 0.02 * np.arange(21)
    rows = contact.run(times, {"slip_velocity": speed}, ["bristle_deflection", "friction_force"])
    assert rows[:, 0] == pytest.approx(1e-9, rel=1e-6)
    assert rows[:, 1] == pytest.approx(0.1 + 0.01 * speed, rel=1e-6)


@pytest.mark.parametrize(
    ("law", "tolerance"), [("lugre", 1e-4), ("lugre", 1e-6), ("lugre", 1e-8), ("bristle", 1e-6), ("reset_integrator", 1e-6)]
)
def test_how_a_communication_step_is_split_does_not_matter(law: str, tolerance: float) -> None:
    """20 cycles: as one step of 1 ms, in 57 uneven parts, in 10 000 steps of 0.1 us."""
    values = {**ELLIPSE, "cutting_speed": 0.2, "relative_tolerance": tolerance, "friction_law": law}
    values |= {"release_time": 1e-5} if law == "lugre" else {"sigma0": 1e7}
    uneven = np.random.default_rng(57).dirichlet(np.full(57, 0.5)) * 1e-3
    rows = []
    for steps in ([1e-3], uneven, np.full(10_000, 1e-7)):
        contact = started(values)
        for step in steps:
            contact.advance(step)
        assert contact.time == pytest.approx(1e-3, rel=1e-13)
        rows.append(read(contact, *STATES))
    assert rows[1] == pytest.approx(rows[0], rel=0.3 * unexplained(tolerance))
    assert rows[2] == pytest.approx(rows[0], rel=0.3 * unexplained(tolerance))


def test_the_same_run_gives_the_same_bits() -> None:
    def run() -> bytes:
        contact = started({**ELLIPSE, "cutting_speed": 0.2, "chip_flow_angle": "current_shear_angle"})
        for step in (1e-5, 3.3e-5, 1e-4):
            contact.advance(step)
        return contact.state()

    assert run() == run()


@pytest.mark.parametrize("law", ["lugre", "bristle", "reset_integrator"])
@pytest.mark.parametrize("angle", [0.3, 0.7, 1.9, 5.9])
def test_a_state_taken_in_mid_cycle_goes_on_to_the_last_bit(law: str, angle: float) -> None:
    """In contact before and after reversal, out of contact, just entered; the rest of the run is the same to the bit."""
    values = {**at_speed_ratio(0.3), "friction_law": law, "release_time": 2e-6}
    first = started(values)
    first.advance(PERIOD + angle / OMEGA)
    state, twin = first.state(), started({**values, "friction_law": "coulomb"}, time=3.0)
    first.advance(1.7 * PERIOD)
    twin.restore(state)
    assert twin.state() == state
    twin.advance(1.7 * PERIOD)
    assert twin.state() == first.state()


@pytest.mark.parametrize("t_0", [1.0, 1e3, 1e5])
def test_time_far_from_zero_changes_nothing_but_its_rounding(t_0: float) -> None:
    """A start after a whole number of cycles. A time of 1e5 s is rounded to 1.5e-11 s, 2e-6 of a turn: the forces lie as close."""
    near, far = (started({**ELLIPSE, "cutting_speed": 0.2}, time=time) for time in (0.0, t_0))
    names = ("friction_force", "principal_force", "uncut_thickness_used", "slip_velocity_used")
    steps = np.full(8, 1.3e-5)
    near_by, far_off = [], []
    for step in steps:
        near.advance(step)
        far.advance(step)
        near_by.append(read(near, *names))
        far_off.append(read(far, *names))
    largest = np.abs(near_by).max(axis=0)
    turn = OMEGA * np.spacing(t_0)
    assert np.all(np.abs(np.subtract(far_off, near_by)).max(axis=0) <= (5 * turn + 1e-10) * largest)
    assert far.get("mean_friction_force") == pytest.approx(near.get("mean_friction_force"), rel=5 * turn + 1e-8)


@pytest.mark.parametrize("start", [0.0, 0.31, 0.93])
@pytest.mark.parametrize(("law", "release"), [("lugre", 1e-5), ("lugre", 1e-4), ("dahl", 1e-4), ("reset_integrator", 1e-4)])
def test_a_periodic_start_is_periodic(law: str, release: float, start: float) -> None:
    """Bristles that do not relax fully remember the cycle before: the start is what a hundred cycles lead to, and one cycle keeps it."""
    values = {**ELLIPSE, "cutting_speed": 0.2, "release_time": release, "sigma0": 3e5, "friction_law": law, "relative_tolerance": 1e-7}
    periodic = started({**values, "initial_state": "periodic"}, time=start * PERIOD)
    z, scale = periodic.get("bristle_deflection"), 10 / 3e5
    from_rest = started(values, time=start * PERIOD)
    first = from_rest.get("bristle_deflection")
    for contact, cycles in ((periodic, 1), (from_rest, 100)):
        for _ in range(cycles):
            contact.advance(PERIOD)
        assert contact.get("bristle_deflection") == pytest.approx(z, abs=0.3 * unexplained(1e-7) * scale)
    assert abs(first - z) > 1e-3 * scale  # and it was not so from the beginning
