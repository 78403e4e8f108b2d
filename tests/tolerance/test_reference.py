"""Is the reference of the campaign right? Against exact solutions, scipy, itself and the kernel at tight tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from draws import draw
from evat.model import FloatArray
from evat.native import kernel
from judged import FORCES, MEASURED, Care, Case, Jump, Motion, Reference, answer, errors, library, outputs, reference
from scipy.integrate import solve_ivp

GIVEN = {"kinematics": "external"}
PRESLIDING = {**GIVEN, "sigma0": 2e5, "sigma1": 0.0, "sigma2": 0.0, "F_C": 2.0, "F_S": 2.0}


def given(times: FloatArray, slip: FloatArray, values: Mapping[str, Any], on: tuple[str, ...] = (), **others: FloatArray) -> Case:
    return Case("test", values, on, Motion.record(times, {"slip_velocity": slip, **others}), 1e-4)


def column(case: Case, name: str, solved: Reference | None = None) -> FloatArray:
    solved = solved or reference(case)
    assert solved.verdict == "done"
    return solved.rows[:, outputs(case).index(name)]


# ---- exact ----


def test_held_slip_is_an_exponential() -> None:
    times, v = np.array([0, 1e-5, 5e-5, 2e-4, 1e-3, 1.0]), 3e-3
    values = {**GIVEN, "sigma0": 3e5, "F_C": 1.0, "F_S": 1.5, "v_s": 2e-3, "lugre.stribeck_exponent": 1.3}
    g = 1 + 0.5 * math.exp(-((v / 2e-3) ** 1.3))
    z = column(given(times, np.full(6, v), values), "bristle_deflection")
    np.testing.assert_allclose(z, g / 3e5 * (1 - np.exp(-3e5 * v / g * times)), rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize("law", ["lugre", "dahl"])
def test_without_a_stribeck_curve_deflection_follows_the_path(law: str) -> None:
    """dz/dx = 1 - sigma0 sgn(v) z/F_C: over any motion an exponential in the path from reversal to reversal."""
    corners = np.array([0.0, 0.05, 0.0, 0.0, -0.02, -0.02, 0.0, 3e-4, 3e-4, -1e-5])
    times = np.cumsum([0, 1e-3, 2e-2, 0.1, 1e-4, 1e-3, 1e-3, 1e-2, 1e-2, 0.31])
    z, right, settled = 0.0, [0.0], 2.0 / 2e5
    for a, b, h in zip(corners[:-1], corners[1:], np.diff(times), strict=True):
        parts = [(a, b, h)] if a * b >= 0 else [(a, 0, h * a / (a - b)), (0, b, h * b / (b - a))]
        for u, w, part in parts:
            path = 0.5 * (u + w) * part
            z = math.copysign(settled, path) + (z - math.copysign(settled, path)) * math.exp(-abs(path) / settled) if path else z
        right.append(z)
    deflection = column(given(times, corners, {**PRESLIDING, "friction_law": law}), "bristle_deflection")
    np.testing.assert_allclose(deflection, right, atol=1e-10 * settled)


def test_a_reset_integrator_sticks_slides_and_turns() -> None:
    """Stiffness sigma0 F_S/F_C up to z_0 = F_C/sigma0, then F_C, and the bristle back from z_0 when the slip turns round."""
    values = {**GIVEN, "friction_law": "reset_integrator", "sigma0": 1e5, "sigma1": 0.0, "F_C": 2.0, "F_S": 3.0}
    times = np.array([0, 1e-3, 3e-3, 4e-3, 4.5e-3])
    slip = np.array([1e-2, 1e-2, 1e-2, -1e-2, -1e-2])  # 10 um, 30 um; +2.5 - 2.5 um; -5 um
    force = column(given(times, slip, values), "friction_force")
    np.testing.assert_allclose(force[1:], [1.5, 2.0, 1.5e5 * 17.5e-6, 1.5e5 * 12.5e-6], rtol=1e-9)


def test_a_bristle_under_a_limit_that_grows_from_nothing() -> None:
    """As a chip begins sticking_limit is L = r t from 1e-4 of F_C on, so that dz/dt = v - sigma0 v z/L has powers of the time for
    its solution, and before that an exponential: rates change by their own size within 1e-9 to 1e-13 s, which is no jump."""
    bears = 0.5 * kernel.variable("shear_stress").start * kernel.variable("width").start
    own = {"friction_law": "dahl", "release_time": 1e3, "sticking_limit.exponent": 0.0, "sticking_limit.contact_length": 0.5}
    for v, rise in ((1.0, 3e-2), (1.0, 3.0), (10.0, 30.0)):  # of the thickness [m/s]
        entry, last = 1.2e-3, 1.2e-3 + 1e-6 / rise
        times = np.array([0, 1e-3, 1.1e-3, entry - 1e-6 / rise, *(entry + 1e-6 / rise * np.array([1e-3, 1e-2, 0.1, 0.5, 1]))])
        thickness = np.interp(times, [0, 1e-3, 1.1e-3, entry - 1e-6 / rise, last], [1e-4, 1e-4, -1e-6, -1e-6, 1e-6])
        case = given(times, np.full(times.shape, v), {**PRESLIDING, **own}, ("sticking_limit",), uncut_thickness=thickness)
        z = column(case, "bristle_deflection")
        rate, least = bears * rise, 2e-4
        power, first = 2e5 * v / rate, least / rate
        at_first = least / 2e5 + (z[3] - least / 2e5) * math.exp(-power)
        steady = power / (power + 1) * rate / 2e5
        t = times[4:] - entry
        np.testing.assert_allclose(z[4:], (at_first - steady * first) * (t / first) ** -power + steady * t, rtol=1e-4)


def test_a_lagging_proxy_and_an_ageing_contact() -> None:
    """Linear states that are driven by a ramp: theta = v - T dv/dt (1 - exp(-t/T)), and an age that nothing renews."""
    times = np.linspace(0, 0.1, 11)
    case = given(times, times, GIVEN, ("proxy_lag", "thermal_viscosity"))
    case = replace(case, values={**GIVEN, "proxy_lag.time_constant": 0.02, "thermal_viscosity.beta": 0.4, "sigma1": 0.0, "sigma2": 2.0})
    z, force = (column(case, name) for name in ("bristle_deflection", "friction_force"))
    theta = times - 0.02 * (1 - np.exp(-times / 0.02))
    viscous = 2.0 * np.exp(-0.4 * theta / kernel.variable("theta_ref").start) * times
    np.testing.assert_allclose(force, 1e6 * z + viscous, atol=1e-9)
    aged = {**GIVEN, "dwell_strengthening.t_ref": 0.01, "dwell_strengthening.beta": 0.3, "v_s": 10.0}
    stand = np.array([0, 0.5, 0.5 + 1e-7])  # slip too short to renew anything, and slow against v_s
    creep = Case("test", aged, ("dwell_strengthening",), Motion.held(stand, {"slip_velocity": np.array([0, 1e-3, 1e-3])}), 1e-4)
    g = 10.0 * (1 + 0.3 * math.log1p(0.5 / 0.01))
    assert column(creep, "bristle_deflection")[-1] == pytest.approx(1e-10 * (1 - 1e6 * 1e-3 / g * 0.5e-7), rel=1e-7)


def test_a_second_turn_meets_what_the_first_left() -> None:
    """Thickness = given + e sin(wt) - share e sin(w(t - T)); the principal force is 2 k, k = tau_s w h, where nothing rubs."""
    values = {
        **GIVEN, "friction_law": "coulomb", "regenerative.revolution_time": 0.02, "regenerative.share": 0.7, "run_out.amplitude": 4e-6,
        "run_out.spindle_frequency": 130.0,
    }  # fmt: skip
    times = np.linspace(1.3e-4, 0.07, 138)
    force = column(given(times, np.zeros_like(times), values, ("run_out", "regenerative")), "principal_force")
    start = times[0]

    def rise(t: FloatArray) -> FloatArray:
        return 4e-6 * np.sin(2 * math.pi * 130.0 * t)

    thickness = 1e-4 + rise(times) - np.where(times > start + 0.02, 0.7 * rise(times - 0.02), 0)
    np.testing.assert_allclose(force, 2 * 4e8 * 1e-3 * thickness, rtol=1e-9)


def test_a_delay_is_a_shift() -> None:
    """The delayed run at t shows what the undelayed one shows at t - tau, and before the start its first force."""
    times, late = np.linspace(0, 0.02, 41), 3.3e-3
    slip = np.interp(times, [0, 0.004, 0.01, 0.02], [2e-3, 2e-2, -1e-2, 0])
    values = {**GIVEN, "sensor_lowpass.time_constant": 1e-3, "sensor_delay.time": late}
    delayed = given(times, slip, values, ("sensor_delay", "sensor_drift"))
    both = np.unique(np.concatenate([times, times[times > late] - late]))
    plain = given(both, np.interp(both, times, slip), values)
    shown, before = column(delayed, "measured_friction_force"), column(plain, "friction_force")
    drift = kernel.variable("sensor_drift.friction_force").start * times
    right = np.where(times > late, before[np.searchsorted(both, np.maximum(times - late, 0) - 1e-12)], before[0])
    np.testing.assert_allclose(shown, right + drift, atol=1e-9)
    filtered = replace(delayed, on=("sensor_delay", "sensor_lowpass"))  # at first it fills with the first force
    ready = (times <= late) & (times > 0)
    np.testing.assert_allclose(
        column(filtered, "measured_friction_force")[ready], before[0] * -np.expm1(-times[ready] / 1e-3), rtol=1e-8, atol=1e-12
    )


def test_a_step_is_of_order_nine() -> None:
    """y' = k t^(k-1) and its integral: exact in one step from 0 to 1 up to k = 9, and not beyond."""
    ffi, loaded = library()
    power = 9

    @ffi.callback("Rates")  # type: ignore[untyped-decorator]
    def rates(_: Any, t: float, y: Any, f: Any, g: Any) -> int:
        f[0] = g[0] = power * t ** (power - 1)
        return 0

    method, step = ffi.new("struct Radau *"), ffi.new("struct Step *")
    method.states = method.integrals = 1
    method.scale[0] = method.integral_scale[0] = 1
    method.tolerance, method.rates = 1e-12, rates
    loaded.radau_begin(method)
    assert loaded.radau_step(method, 0.0, 1.0, [0.0], [0.0], [0.0], step)
    assert (step.node[4][0], step.gain[0]) == pytest.approx((1, 1), rel=1e-13)
    power = 10
    assert loaded.radau_step(method, 0.0, 1.0, [0.0], [0.0], [0.0], step)
    assert 1e-6 < abs(step.node[4][0] - 1) < 1e-3


# ---- another solver ----


def by_scipy(case: Case) -> FloatArray:
    """SHOWN at the samples, by scipy's LSODA from corner to corner and from reversal to reversal of the given slip."""
    contact = kernel.Contact({**case.values, "relative_tolerance": 1e-4}, case.on)
    motion, states = (
        case.motion,
        [name for name in kernel.states() if name.partition(".")[0] in (*case.on, "bristle_deflection", "sliding_distance")],
    )
    rates = {variable.derivative_of: variable.name for variable in kernel.variables() if variable.derivative_of}
    for name, values in motion.begin.items():
        contact.set(name, values[0])
    contact.start(motion.times[0])
    y = np.array([contact.get(name) for name in states])
    rows = [[contact.get(name) for name in SHOWN]]
    for n in range(len(motion.times) - 1):
        t_0, t_1 = motion.times[n : n + 2]

        def put(t: float, y: FloatArray, n: int = n, t_0: float = t_0, t_1: float = t_1) -> None:
            contact.time = t
            for name in motion.begin:
                a, b = motion.begin[name][n], motion.end[name][n]
                contact.set(name, a + (b - a) * (t - t_0) / (t_1 - t_0))
            for name, value in zip(states, y, strict=True):
                contact.set(name, float(value))
            contact.evaluate()

        def rate(t: float, y: FloatArray) -> list[float]:
            put(t, y)
            return [contact.get(rates[name]) for name in states]

        a, b = motion.begin["slip_velocity"][n], motion.end["slip_velocity"][n]
        stops = [t_0, t_0 + (t_1 - t_0) * a / (a - b), t_1] if a * b < 0 else [t_0, t_1]
        for begin, end in pairwise(stops):
            v_s = float(case.values.get("v_s", kernel.variable("v_s").start))
            pieces = np.linspace(begin, end, 1 + min(400, 1 + int(abs(b - a) * (end - begin) / (t_1 - t_0) / (0.2 * v_s))))
            scale = np.array([1e-6 if name == "bristle_deflection" else 1.0 for name in states])
            for low, high in pairwise(pieces):
                y = solve_ivp(rate, (low, high), y, method="LSODA", rtol=1e-12, atol=1e-13 * scale).y[:, -1]
            contact.event()
        put(t_1, y)
        rows.append([contact.get(name) for name in SHOWN])
    return np.array(rows)


SHOWN = ("friction_force", "bristle_deflection", "measured_friction_force")
ON = [
    (), ("stribeck", "direction_asymmetry"), ("dwell_strengthening",), ("elasto_plastic",), ("friction_wear", "thermal_softening"),
    ("proxy_lag", "thermal_damping"), ("holder_compliance",), ("sensor_lowpass", "dynamometer_resonance"),
]  # fmt: skip
AGAIN = (ON[1], ON[4])  # in the campaign: their like, without a state and with heat, are among the others


@pytest.mark.parametrize(
    ("law", "on"),
    [*(pytest.param("lugre", on, marks=pytest.mark.campaign if on in AGAIN else ()) for on in ON), ("dahl", ())],
)
def test_scipy_finds_the_same(law: str, on: tuple[str, ...]) -> None:
    """LSODA at 1e-12: 3e-7 of the friction level, where 1e-5 is judged."""
    times = np.array([0, 0.002, 0.004, 0.01, 0.012, 0.015])
    slip = np.array([0.0, 0.03, 0.0, 0.0, -0.01, 0.005])
    values = {
        **GIVEN, "friction_law": law, "sigma0": 3e5, "F_C": 2.0, "F_S": 3.0, "v_s": 3e-3, "friction_wear.s_0": 1e-4,
        "dynamometer_resonance.natural_period": 8e-3, "holder_compliance.natural_frequency": 400.0, "sensor_lowpass.time_constant": 1e-3,
    }  # fmt: skip
    case = given(times, slip, values, on)
    solved, other = reference(case), by_scipy(case)
    for place, size in enumerate((3, 3 / 3e5, 3)):
        np.testing.assert_allclose(column(case, SHOWN[place], solved), other[:, place], rtol=0, atol=3e-7 * size)


# ---- itself, and the kernel where it is run tightly ----


def largest(case: Case, rows: FloatArray, right: Reference, tolerance: float) -> float:
    names = outputs(case)
    judged = [place for place, name in enumerate(names) if name != "in_contact"]
    return float(np.max(errors(replace(case, relative_tolerance=tolerance), rows, right, names)[:, judged]))


@pytest.mark.parametrize("count", [15, pytest.param(40, marks=pytest.mark.campaign)])
def test_twice_the_steps_and_a_tenth_of_the_tolerance_change_nothing(count: int) -> None:
    """Of any output less than a twentieth of the tightest tolerance but one that is judged, 1e-5."""
    changes = []
    for number in range(count):
        case = draw(11, number)
        plain, tight = reference(case), reference(case, Care(1e-10, 0.5))
        if (plain.verdict, tight.verdict) == ("done", "done"):
            changes.append(largest(case, plain.rows, tight, 1e-5))
    assert len(changes) >= 0.95 * count - 1
    assert max(changes) < 0.05


@pytest.mark.parametrize("law", ["lugre", "dahl", "coulomb", "karnopp", "bristle", "reset_integrator", "amontons"])
def test_the_kernel_at_a_tight_tolerance_tends_to_the_reference(law: str) -> None:
    """Ellipses, where no other solver of ours finds entries and exits: two methods that share only the rates."""
    values = {
        "friction_law": law, "vibration_frequency": 2e3, "amplitude_x": 8e-6, "amplitude_y": 8e-6, "feed": 2e-5, "sigma0": 3e5, "F_C": 2.0,
        "F_S": 3.0, "sigma1": 5.0, "phase_x": -1.5, "bristle.seed": 3.0,
    }  # fmt: skip
    times = np.arange(0, 3, 0.0473) / 2e3
    columns = {"cutting_speed": np.full_like(times, 0.04), "applied_force": np.full_like(times, 1.0)}
    case = Case("ellipse", values, (), Motion.record(times, columns), 1e-9)
    right = reference(case)
    assert right.verdict == "done"
    assert largest(case, answer(case).rows, right, 1e-5) < 0.1


def test_a_periodic_start_is_as_tight_as_one_is_found() -> None:
    """To a thousandth of the tolerance none is, where stiff damping moves the tool: the reference began at rest, 1 700 tolerances off."""
    values = {
        "kinematics": "internal", "sigma0": 9.966e6, "sigma1": 8940.0, "sigma2": 31.38, "F_C": 0.1127, "F_S": 0.1135, "v_s": 3.3167e-4,
        "vibration_frequency": 16242.0, "amplitude_x": 8.513e-6, "amplitude_y": 9.561e-6, "feed": 1.255e-4,
        "chip_flow_shear_angle": 0.8276, "phase_x": -1.4585, "phase_y": 3.2038, "initial_state": "periodic",
        "chip_flow_angle": "current_shear_angle", "release_time": 4.978e-5, "holder_compliance.compliance_x": 1.83e-8,
        "holder_compliance.compliance_y": 2.22e-8, "holder_compliance.natural_frequency": 1749.2,
        "holder_compliance.damping_ratio": 0.03725,
    }  # fmt: skip
    times = np.linspace(0, 2e-5, 5)
    motion = Motion.record(times, {"cutting_speed": np.full(5, 0.9578)})
    case = Case("test", values, ("holder_compliance",), motion, 1e-5)
    solved = reference(case)
    assert largest(case, answer(case).rows, solved, 1e-5) < 1


# ---- the measure ----


def test_an_error_of_three_tolerances_counts_as_three() -> None:
    case = given(np.array([0, 0.1, 0.2]), np.array([0.1, 0.1, 0.1]), GIVEN)
    right, names = reference(case), outputs(case)
    rows = right.rows.copy()
    rows[1, 0] += 3e-4 * max(10.0, np.max(np.abs(right.rows[:, 0])))
    in_tolerances = errors(case, rows, right, names)
    assert in_tolerances[1, 0] == pytest.approx(3, rel=1e-9)
    assert np.max(np.delete(in_tolerances.ravel(), 1 * len(names))) == 0


def test_a_late_jump_counts_by_how_late_it_is() -> None:
    """Forces that jump from 10 to 0 N at 0.1 s and are shown 2e-4 patiences too long: two tolerances, not 10 N."""
    case = given(np.array([0, 0.1 + 2e-6, 0.2]), np.array([0.1, 0.1, 0.1]), GIVEN)
    names = outputs(case)
    right_rows = np.tile([[10.0], [0.0], [0.0]], (1, len(names)))
    jump = Jump(0.1, 1e-2, np.full(len(names), 10.0), np.zeros(len(names)))
    rows = right_rows.copy()
    rows[1] = 10.0
    assert errors(case, rows, Reference("done", right_rows, [jump]), names)[1, 0] == pytest.approx(2, rel=1e-6)
    assert errors(case, rows, Reference("done", right_rows, []), names)[1, 0] == pytest.approx(1e4, rel=1e-6)


def test_both_doors_of_the_kernel_are_driven() -> None:
    """The same motion as a record and stepped by a host: the same answer to the tolerance."""
    times = np.linspace(0, 0.01, 21)
    case = given(times, 0.01 * np.sin(600 * times) + 0.02, {**GIVEN, "sigma0": 1e5})
    stepped = replace(case, motion=replace(case.motion, stepped=True))
    one, other = answer(case), answer(stepped)
    assert one.status == other.status == "done"
    place = [outputs(case).index(name) for name in (*FORCES, *MEASURED)]
    np.testing.assert_allclose(one.rows[:, place], other.rows[:, place], atol=1e-3)
