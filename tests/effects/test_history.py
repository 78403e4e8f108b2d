"""Is what was so long ago still known: forces over any delay, a surface over a turn; and where not, is that said at once?"""

from __future__ import annotations

import numpy as np
import pytest
from asking import OUTSIDE, begun, course
from driving import AMPLITUDE, FREQUENCY, PERIOD, Values
from evat.model import SimulationError
from evat.native.kernel import Contact

FORCES = ("friction_force", "principal_force", "feed_force")
CUT: Values = {"vibration_frequency": FREQUENCY, "amplitude_x": AMPLITUDE, "amplitude_y": AMPLITUDE, "cutting_speed": 0.3}
SAMPLES = np.sort(np.random.default_rng(1).uniform(0, 6 * PERIOD, 150))  # s, from a start at rest on


def delayed(tau: float, tolerance: float, law: str) -> tuple[np.ndarray, np.ndarray]:
    """The measured forces at SAMPLES after the delay, and the forces at SAMPLES themselves, in units of the largest."""
    values = {**CUT, "relative_tolerance": tolerance, "friction_law": law, "sensor_delay.time": tau}
    late = course(begun(values, ["sensor_delay"]), np.append(0.0, tau + SAMPLES), *(f"measured_{name}" for name in FORCES))[:, 1:]
    exact = course(begun({**CUT, "relative_tolerance": 1e-10, "friction_law": law}), np.append(0.0, SAMPLES), *FORCES)[:, 1:]
    size = np.abs(exact).max(axis=1, keepdims=True)
    return late / size, exact / size


def check_delay(tau: float, tolerance: float, law: str) -> None:
    """In tolerances: the worst of the samples no worse than what the campaign allows to forces that are not delayed, beside 3 of the
    parabola through a step."""
    error = np.abs(np.subtract(*delayed(tau, tolerance, law))).max(axis=0) / tolerance
    assert np.median(error) < 0.1
    assert error.max() < 5, f"{error.max():.3g} tolerances, {1e6 * SAMPLES[error.argmax()]:.5g} us after the start"


@pytest.mark.parametrize("law", ["coulomb", "lugre"])
@pytest.mark.parametrize(
    ("tau", "tolerance"), [(1e-6, 1e-4), (1e-6, 1e-6), (3e-4, 1e-4), (3e-4, 1e-5), (3e-4, 1e-6), (1e-3, 1e-6), (1e-2, 1e-4)]
)
def test_a_delayed_force_is_the_force_of_then(tau: float, tolerance: float, law: str) -> None:
    """Of the first cycles after a start at rest, each other than the last; over 200 cycles what is kept has been made room in 40 times.
    As the error goes with the tolerance, so do steps, thinning and cycles that are taken for alike."""
    check_delay(tau, tolerance, law)


@pytest.mark.campaign
@pytest.mark.parametrize("law", ["coulomb", "lugre"])
@pytest.mark.parametrize(("tau", "tolerance"), [(0.1, 1e-4), (0.1, 1e-5), (0.1, 1e-6), (10.0, 1e-4)])
def test_a_force_is_known_ten_seconds_later(tau: float, tolerance: float, law: str) -> None:
    """200 000 cycles."""
    check_delay(tau, tolerance, law)


@pytest.mark.parametrize("tau", [3e-5, 2e-3])
def test_a_copy_goes_on_from_the_same_past(tau: float) -> None:
    """In the middle of it, and after it has been thinned."""
    contact = begun({**CUT, "relative_tolerance": 1e-5, "sensor_delay.time": tau}, ["sensor_delay"])
    contact.advance(1e-3 + 0.3 * PERIOD)
    twin = contact.copy()
    for one in (contact, twin):
        for _ in range(30):
            one.advance(1e-4)
    assert contact.get("mean_measured_principal_force") > 0
    assert contact.state() == twin.state()


def test_a_past_that_does_not_repeat_itself_is_refused_at_once() -> None:
    """A slip like noise, and a second to look back to: within the first 256 corners, and with the names of what does not go together."""
    times = 1e-5 * np.arange(1000)
    slip = np.random.default_rng(2).uniform(0.01, 0.1, len(times))
    contact = begun({**OUTSIDE, "relative_tolerance": 1e-4, "slip_velocity": slip[0], "sensor_delay.time": 1.0}, ["sensor_delay"])
    with pytest.raises(SimulationError, match=r"256 pieces of the past.*kinematics = external.*on: sensor_delay"):
        contact.run(times, {"slip_velocity": slip}, ["friction_force"])
    assert contact.time < times[300]


def on_a_slide(law: str, tolerance: float, times: np.ndarray, tau: float) -> np.ndarray:
    """Forces of a vibration on a slide that moves by 10 um at 1.3 Hz, delayed by tau or not: of each cycle others, (times, forces)."""
    values: Values = {**CUT, "kinematics": "combined", "relative_tolerance": tolerance, "friction_law": law, "sensor_delay.time": tau}
    w, contact = 2 * np.pi * 1.3, begun(values, ["sensor_delay"] if tau else [])
    motion = {"tool_displacement_y": 1e-5 * np.sin(w * times), "tool_velocity_y": 1e-5 * w * np.cos(w * times)}
    return contact.run(times, motion, [f"measured_{name}" for name in FORCES])


def test_cycles_that_drift_are_known_by_the_first_and_the_last_of_them() -> None:
    """180 cycles at 1e-4, of which 57 could be kept one by one; against forces that nobody delays. At which of 200 there is no room left is
    another place at each friction level."""
    tau, tolerance, count = 9e-3, 1e-4, 1351
    times = tau / count * np.arange(2 * count + 1)
    late, exact = on_a_slide("coulomb", tolerance, times, tau)[count:], on_a_slide("coulomb", 1e-8, times[: count + 1], 0.0)
    error = (np.abs(late - exact) / np.abs(exact).max(axis=0)).max(axis=1) / tolerance
    assert np.median(error) < 0.1
    assert error.max() < 5


@pytest.mark.parametrize(("law", "tolerance", "cycles"), [("lugre", 1e-4, 80), ("lugre", 1e-5, 270), ("coulomb", 1e-4, 994)])
def test_a_vibration_on_a_moving_slide_is_kept_for_so_many_cycles(law: str, tolerance: float, cycles: int) -> None:
    """And then refused by name. The guide has the numbers; a compiler may make them a little different."""
    times = 1e-4 * np.arange(501)
    with pytest.raises(SimulationError, match="256 pieces of the past") as refused:
        on_a_slide(law, tolerance, times, 1.0)
    at = float(str(refused.value).split("t = ")[1].split(" s")[0])
    assert at / PERIOD == pytest.approx(cycles, rel=0.2)


def test_slow_forces_are_known_in_few_pieces() -> None:
    """20 000 steps of a host in 2 s, of which 256 could be kept."""
    tau, step = 1.5, 1e-4
    contact = begun({**OUTSIDE, "relative_tolerance": 1e-4, "F_C": 5.0, "sensor_delay.time": tau}, ["sensor_delay"])
    times = step * np.arange(20_001)
    slip = 0.05 + 0.03 * np.sin(2 * np.pi * 1.3 * times)
    late, force = contact.run(times, {"slip_velocity": slip}, ["measured_friction_force", "friction_force"]).T
    assert np.abs(late[15_001:] - force[1:5001]).max() < 2e-4 * force.max()


def test_forces_that_change_slowly_over_thousands_of_cycles_are_known_in_few_pieces() -> None:
    """The slide carries a tool that does not vibrate, so that a step of 0.1 ms is two periods: each is like the one before, nearly."""
    tau, step, w = 0.45, 1e-4, 2 * np.pi * 1.3
    still: Values = {**CUT, "kinematics": "combined", "amplitude_x": 0.0, "amplitude_y": 0.0, "relative_tolerance": 1e-4}
    contact = begun({**still, "sensor_delay.time": tau}, ["sensor_delay"])
    times = step * np.arange(5_001)
    motion = {"tool_displacement_y": 1e-5 * np.sin(w * times), "tool_velocity_y": 1e-5 * w * np.cos(w * times)}
    late, force = contact.run(times, motion, ["measured_principal_force", "principal_force"]).T
    assert np.abs(late[4501:] - force[1:501]).max() < 2e-4 * force.max()
    assert np.ptp(force[1:501]) > 0.01 * force.max()


def test_a_host_whose_slip_is_smooth_may_look_back_over_thousands_of_steps() -> None:
    tau, step = 0.3, 1e-4
    contact = begun({**OUTSIDE, "relative_tolerance": 1e-4, "input_delay.time": tau, "slip_velocity": 0.05}, ["input_delay"])

    def given(t: float) -> float:
        return 0.05 + 0.03 * float(np.sin(2 * np.pi * 0.1 * t))

    for n in range(1, 5000):
        contact.set("slip_velocity", given(n * step))
        contact.advance(step)
    # held over each step, so that half a step late; and to what is left of the largest
    assert contact.get("slip_velocity_used") == pytest.approx(given(contact.time - tau), abs=0.03 * 2 * np.pi * 0.1 * step + 1e-4 * 0.08)


def test_the_surface_is_known_to_the_tolerance_of_the_thickness() -> None:
    """Run-out of a period that is no part of the turn, the work's first turn exact and the second the difference of two sines."""
    turn, feed, size, f, tolerance = 0.02, 1e-4, 2e-5, 173.0, 1e-4
    values: Values = {
        "kinematics": "external", "slip_velocity": 0.1, "uncut_thickness": feed, "feed": feed, "run_out.amplitude": size,
        "run_out.spindle_frequency": f, "regenerative.revolution_time": turn, "relative_tolerance": tolerance,
    }  # fmt: skip
    contact = Contact(values, ("run_out", "regenerative"))
    contact.start()
    times = 1e-4 * np.arange(1, 399)  # before the end of the second turn
    shown = np.empty(len(times))
    for n, time in enumerate(times):
        contact.advance(float(time) - contact.time)
        shown[n] = contact.get("uncut_thickness_used")
    wave = np.where(times > 0, size * np.sin(2 * np.pi * f * times), 0)
    before = np.where(times > turn, size * np.sin(2 * np.pi * f * (times - turn)), 0)
    np.testing.assert_allclose(shown, feed + wave - before, atol=tolerance * feed)
