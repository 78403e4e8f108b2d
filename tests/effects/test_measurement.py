"""Do the sensor effects show the true forces as real sensors do? Gain and phase, steps, late waves, straight lines."""

from __future__ import annotations

from math import atan2, exp, pi, sqrt

import numpy as np
import pytest
from asking import CONSTANT, FASTEST, OUTSIDE, VISCOUS, begun, course, follow, line
from driving import PERIOD, Values, read

FORCES = ("friction_force", "principal_force", "feed_force")
MEASURED = tuple(f"measured_{name}" for name in FORCES)
SENSORS = {
    "sensor_delay": {"sensor_delay.time": 7e-6},
    "sensor_gain": {f"sensor_gain.{name}": 1.3 for name in FORCES},
    "sensor_offset": {},
    "sensor_drift": {f"sensor_drift.{name}": 5e3 for name in FORCES},
    "cross_talk": {},
    "sensor_lowpass": {},
    "dynamometer_resonance": {"dynamometer_resonance.natural_period": 2.1e-4, "dynamometer_resonance.damping_ratio": 0.3},
}
CUT: Values = {"cutting_speed": 0.3 * FASTEST, "initial_state": "periodic", "relative_tolerance": 1e-7}


def response(frequency: float, values: dict[str, float], on: str, cycles: int, samples: int = 400) -> np.ndarray:
    """Complex gain from true to measured force of each channel, once `cycles` periods of a sine have passed. The force is straight between
    the samples: what that takes from its line, (sin x/x)^2 with x = pi/samples, is taken from the measured one too."""
    times = np.arange((cycles + 1) * samples) / (samples * frequency)
    speed = 2 + np.sin(2 * pi * frequency * times)
    rows = follow(times, {"slip_velocity": speed}, {**VISCOUS, **values}, [on], *FORCES, *MEASURED)
    true, shown = np.split(line(frequency, times[-samples:], rows[:, -samples:]), 2)
    assert np.abs(true) == pytest.approx(1, rel=1e-5)  # each channel holds the friction force, at no rake
    gain: np.ndarray = shown / true / np.sinc(1 / samples) ** 2
    return gain


def test_resonance_passes_a_second_order_systems_gain_and_phase() -> None:
    """1/(2 zeta) and a quarter turn at f_n; a hundredth and nearly half a turn at 10 f_n; 1 and nothing far below."""
    f_n, zeta = 4e3, 0.2  # a free oscillation is down to e^-19 after 15 periods
    values = {"dynamometer_resonance.natural_period": 1 / f_n, "dynamometer_resonance.damping_ratio": zeta}
    at, above, below = (response(part * f_n, values, "dynamometer_resonance", cycles) for part, cycles in ((1, 15), (10, 150), (1e-3, 1)))
    # the tolerances: 1/samples^2 of the neighbours of the line, of which the resonance passes the more, the higher they lie
    assert np.abs(at) == pytest.approx(1 / (2 * zeta), rel=1e-4)
    assert np.angle(at) == pytest.approx(-pi / 2, abs=1e-4)
    assert np.abs(above) == pytest.approx(1 / sqrt(99**2 + (20 * zeta) ** 2), rel=1e-4)
    assert np.angle(above) == pytest.approx(-pi + atan2(20 * zeta, 99), abs=1e-4)
    assert np.abs(below - 1) == pytest.approx(0, abs=1e-3)  # 2 zeta f/f_n = 4e-4, and the samples


def test_resonance_rings_after_a_step() -> None:
    """A force that sets in overshoots by e^(-pi zeta/sqrt(1 - zeta^2)) half a damped period later, and ends as it is."""
    T, zeta = 3e-4, 0.05
    half = 0.5 * T / sqrt(1 - zeta**2)
    contact = begun({**OUTSIDE, **CONSTANT, "slip_velocity": 1.0, "dynamometer_resonance.natural_period": T}, ["dynamometer_resonance"])
    peaks = course(contact, half * np.array([0, 1, 2, 200]), *MEASURED) / read(contact, *FORCES)[:, None] - 1
    over = exp(-pi * zeta / sqrt(1 - zeta**2))
    assert peaks == pytest.approx(np.tile([-1, over, -(over**2), 0], (3, 1)), abs=1e-9)  # solved exactly; rounding of long swings


def test_lowpass_is_3_db_and_45_degrees_down_at_its_cut_off() -> None:
    """And a tenth per decade above it; a step has 1 - 1/e after one time constant."""
    cut_off = 1e3
    values = {"sensor_lowpass.time_constant": 1 / (2 * pi * cut_off)}
    at, above = (response(part * cut_off, values, "sensor_lowpass", 4 * part, 800) for part in (1, 100))
    assert 20 * np.log10(np.abs(at)) == pytest.approx(-3.0103, abs=1e-4)
    assert np.angle(at, deg=True) == pytest.approx(-45, abs=1e-2)
    assert np.abs(above) == pytest.approx(1e-2, rel=1e-3)
    contact = begun({**OUTSIDE, **CONSTANT, "slip_velocity": 1.0, **values}, ["sensor_lowpass"])
    contact.advance(values["sensor_lowpass.time_constant"])
    assert read(contact, *MEASURED) / read(contact, *FORCES) == pytest.approx(1 - exp(-1), rel=1e-12)


@pytest.mark.parametrize("tau", [0.3e-6, 10e-6, 37.3e-6])
def test_delay_turns_a_sine_and_keeps_its_form(tau: float) -> None:
    """By 2 pi f tau, gain 1; shorter than an internal step, as long as a communication step (10 us) and longer. The force goes straight
    from sample to sample, corners and all, and is the same later; but for the 1e-6 N that a bristle takes a moment to hold at first."""
    frequency, samples = 1e3, 100
    times = np.arange(3 * samples) / (samples * frequency)
    speed = 2 + np.sin(2 * pi * frequency * times) + 0.3 * np.sign(np.sin(6 * pi * frequency * times + 1e-3))
    rows = follow(times, {"slip_velocity": speed}, {**VISCOUS, "sensor_delay.time": tau}, ["sensor_delay"], *FORCES, *MEASURED)
    for true, shown in zip(rows[:3], rows[3:], strict=True):
        assert shown == pytest.approx(np.interp(times - tau, times, true), rel=1e-9, abs=1e-6)  # before the start: the first force
    gain = response(frequency, {"sensor_delay.time": tau}, "sensor_delay", 1, samples)
    exact = np.exp(-2j * pi * frequency * tau)
    # between samples the polyline lacks up to (pi/samples)^2/2 of the sine: none at a whole step, all of it in the middle
    assert np.abs(gain * np.sinc(1 / samples) ** 2 - exact) == pytest.approx(0, abs=0.5 * (pi / samples) ** 2)


@pytest.mark.parametrize("cycles", [0.247, 4.247, 7.913])
def test_delay_across_entries_and_exits(cycles: float) -> None:
    """What a vibrating tool's sensor shows late is what a prompt one has shown cycles before, jumps and all, to 3 tolerances. From the
    start on, which is periodic, and whose past is one cycle for all but the last two."""
    tau, times = cycles * PERIOD, np.linspace(0, 2 * PERIOD, 301)
    late = course(begun({**CUT, "sensor_delay.time": tau}, ["sensor_delay"]), times, *MEASURED)
    prompt = course(begun(CUT), np.append(0, times + np.ceil(cycles) * PERIOD - tau), *FORCES)[:, 1:]
    assert np.ptp(prompt, axis=1).min() > 5
    assert np.abs(late - prompt).max() < 3 * 1e-7 * np.abs(prompt).max()


@pytest.mark.parametrize(
    ("on", "values"),
    [
        ("sensor_delay", {"sensor_delay.time": 1.237e-5}),
        ("sensor_lowpass", {"sensor_lowpass.time_constant": 5e-6}),
        ("dynamometer_resonance", {"dynamometer_resonance.natural_period": 3e-5, "dynamometer_resonance.damping_ratio": 0.1}),
    ],
)
def test_friction_is_heard_as_exactly_beside_a_force_of_fifty_times_its_size(on: str, values: dict[str, float]) -> None:
    """A thick cut by a tool with a rake, whose other channels are so large that an error of the friction is no part of theirs."""
    shown = {}
    for tolerance in (1e-4, 1e-7):
        contact = begun({**CUT, "rake_angle": 0.2, "feed": 1e-3, **values, "relative_tolerance": tolerance}, [on])
        shown[tolerance] = course(contact, np.linspace(0, 2 * PERIOD, 301), "measured_friction_force", "principal_force")
    friction, principal = np.abs(shown[1e-7]).max(axis=1)
    assert principal > 50 * friction
    assert np.abs(shown[1e-4] - shown[1e-7])[0].max() < 3e-4 * friction


@pytest.mark.parametrize("on", [["sensor_lowpass"], ["dynamometer_resonance"]])
def test_the_mean_behind_a_sensor_that_is_faster_than_a_step(on: list[str]) -> None:
    """An internal step holds a hundred time constants or periods. The integral of what is shown follows from the sensor's own equation:
    that of the force, less what the sensor has gained."""
    T, zeta, span = 1e-5, 0.2, 1e-3
    values = {"sensor_lowpass.time_constant": T, "dynamometer_resonance.natural_period": T, "dynamometer_resonance.damping_ratio": zeta}
    contact = begun({**OUTSIDE, **CONSTANT, "slip_velocity": 1.0, **values}, on)
    force, before = read(contact, *FORCES), read(contact, *MEASURED)
    contact.advance(span)
    assert contact.get("step_count") < 20
    delay = T if on == ["sensor_lowpass"] else zeta * T / pi
    impulses = read(contact, *(f"measured_{name.replace('force', 'impulse')}" for name in FORCES))
    assert impulses == pytest.approx(force * span - delay * (read(contact, *MEASURED) - before), rel=1e-9)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_what_one_sensor_rings_is_heard_by_the_next(tolerance: float) -> None:
    """Resonance, then low-pass, of a force that sets in and holds: against their three exponentials."""
    T, lag, zeta = 2e-5, 3e-5, 0.1
    w, damped = 2 * pi / T, sqrt(1 - zeta**2)
    values = {"dynamometer_resonance.natural_period": T, "dynamometer_resonance.damping_ratio": zeta, "sensor_lowpass.time_constant": lag}
    settings = {**OUTSIDE, **CONSTANT, "slip_velocity": 1.0, **values, "relative_tolerance": tolerance}
    contact = begun(settings, ["dynamometer_resonance", "sensor_lowpass"])
    times = np.linspace(0, 1e-3, 41)
    shown = course(contact, times, *MEASURED) / read(contact, *FORCES)[:, None]
    pole = w * complex(-zeta, damped)
    residue = w * w / (pole * complex(0, 2 * w * damped))  # of the step's ringing: y = 1 + 2 Re(residue e^(pole t))
    later = residue / (1 + lag * pole)
    exact = 1 + 2 * (later * np.exp(pole * times)).real
    exact -= exact[0] * np.exp(-times / lag)
    assert np.abs(shown - exact).max() < 3 * tolerance


def mixed(on: list[str], **values: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Matrix, offset and rate that turn the true forces into the measured ones, by least squares on a record in which the three true forces
    are independent of each other (a rake, a flank that wears); and what the three do not explain."""
    times = np.linspace(0, 1, 200)
    inputs = {"slip_velocity": 0.3 + 0.2 * np.sin(20 * times), "uncut_thickness": 1e-4 * (1.2 + np.cos(33 * times))}
    settings = {**VISCOUS, "sigma2": 30.0, "rake_angle": 0.2, "flank_wear.feed_rate": 5e5}
    rows = follow(times, inputs, {**settings, **values}, ["flank_wear", *on], *FORCES, *MEASURED)
    assert np.array_equal(rows[:3], follow(times, inputs, settings, ["flank_wear"], *FORCES))  # the true forces know of no sensor
    causes = np.vstack([rows[:3], np.ones_like(times), times])
    assert np.linalg.cond(causes / np.linalg.norm(causes, axis=1, keepdims=True)) < 1e4
    answer, *_ = np.linalg.lstsq(causes.T, rows[3:].T, rcond=None)
    return answer[:3].T, answer[3], answer[4], rows[3:] - answer.T @ causes


def test_static_sensor_errors_are_linear_algebra() -> None:
    """A diagonal matrix, a matrix with two entries beside its diagonal, an offset, a rate; each that and nothing else."""
    one, three = np.eye(3), np.array([0.7, -1.2, 3.0])
    cases = {"sensor_gain": 1 + 0.1 * three, "sensor_offset": three, "sensor_drift": three}
    expected = {
        "sensor_gain": (np.diag(1 + 0.1 * three), 0 * three, 0 * three),
        "sensor_offset": (one, three, 0 * three),
        "sensor_drift": (one, 0 * three, three),
        "cross_talk": (np.array([[1, 0, 0], [0, 1, 0.3], [0, -0.2, 1]]), 0 * three, 0 * three),
    }
    for name, (matrix, offset, rate) in expected.items():
        given = {f"{name}.{force}": value for force, value in zip(FORCES, cases.get(name, ()), strict=False)}
        given |= {"cross_talk.principal_from_feed": 0.3, "cross_talk.feed_from_principal": -0.2} if name == "cross_talk" else {}
        measured = mixed([name], **given)
        for part, exact in zip(measured, (matrix, offset, rate, 0 * measured[3]), strict=True):
            assert part == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("name", SENSORS)
def test_cycle_means_follow_from_the_same_algebra(name: str) -> None:
    """Over a periodic cut: what is late, filtered or rings keeps its means; gain, offset and cross talk act on them as on the forces, drift
    by its middle. And the true forces are the same, but that what remembers takes other steps: to see what it remembers well enough, and a
    delay to end them where a jump comes late."""
    contact, plain = begun({**CUT, **SENSORS[name]}, [name]), begun(CUT)
    for each in (contact, plain):
        each.advance(PERIOD)
        assert not each.warnings()
    true, shown = (read(contact, *(f"mean_{force}" for force in names)) for names in (FORCES, MEASURED))
    exact = {"sensor_gain": 1.3 * true, "sensor_offset": true + 0.5, "sensor_drift": true + 5e3 * PERIOD / 2}
    exact["cross_talk"] = true + 0.02 * true[[0, 2, 1]] * [0, 1, 1]
    # of late jumps the tolerance is near 1e-5, of filters 1e-6; else rounding
    assert shown == pytest.approx(exact.get(name, true), rel=1e-4)
    contact.advance(0.1 * PERIOD)
    plain.advance(0.1 * PERIOD)
    same = {"sensor_delay": 1e-5, "sensor_lowpass": 1e-7, "dynamometer_resonance": 1e-7}.get(name, 1e-12)
    assert read(plain, *FORCES).min() > 1
    assert read(contact, *FORCES) == pytest.approx(read(plain, *FORCES), rel=same, abs=0)


@pytest.mark.parametrize("thickness", [1e-4, -1e-4])
def test_a_line_stands_in_the_spectrum_whatever_touches(thickness: float) -> None:
    """Amplitude and phase of each channel at 50 Hz and nothing at its neighbours, in contact and in the air; the forces know nothing."""
    sizes, psi = np.array([0.3, 0.7, 1.1]), 0.6
    own = {f"line_disturbance.{name}": float(size) for name, size in zip(FORCES, sizes, strict=True)}
    values: Values = {**OUTSIDE, **CONSTANT, "slip_velocity": 0.1, "uncut_thickness": thickness}
    times = np.arange(400) / 2000
    disturbed = course(begun({**values, **own, "line_disturbance.phase": psi}, ["line_disturbance"]), times, *FORCES, *MEASURED)
    plain = course(begun(values), times, *FORCES, *MEASURED)
    np.testing.assert_array_equal(disturbed[:3], plain[:3])
    added = disturbed[3:] - plain[3:]
    assert line(50, times, added) == pytest.approx(sizes * np.exp(1j * (psi - pi / 2)), rel=1e-12)
    assert np.abs([line(f, times, added) for f in (45, 55, 100)]).max() < 1e-12


def test_the_impulse_of_a_line_is_its_integral() -> None:
    """A (cos psi - cos(2 pi f T + psi))/(2 pi f) over one long step of many periods, where three points of the step would tell nothing."""
    values: Values = {"line_disturbance.friction_force": 2.0, "line_disturbance.frequency": 60.0, "line_disturbance.phase": 0.3}
    contact = begun({**OUTSIDE, **CONSTANT, **values, "slip_velocity": 0.1}, ["line_disturbance"])
    contact.advance(0.33)
    added = read(contact, "measured_friction_impulse")[0] - 9 * 0.33
    assert added == pytest.approx(2 * (np.cos(0.3) - np.cos(2 * pi * 60 * 0.33 + 0.3)) / (2 * pi * 60), rel=1e-4)
