"""Does the contact answer to a slip that comes late, or early, as to one that was recorded in time? By shifted records of our own."""

from __future__ import annotations

import numpy as np
import pytest
from asking import OUTSIDE, begun, follow
from driving import Values, read
from evat.model import Run, SimulationError
from evat.native.batch import run_many

ON = ("input_delay",)
F_C, SIGMA0 = 6.0, 1e6
LEVEL: Values = {**OUTSIDE, "sigma0": SIGMA0, "F_C": F_C, "F_S": 8.0, "v_s": 5e-3, "sigma1": 30.0, "sigma2": 2.0}
NAMES = ("friction_force", "bristle_deflection", "slip_velocity_used", "measured_friction_force")
TIMES = np.linspace(0.3, 0.4, 101)
SLIP = 2e-2 * np.sin(2 * np.pi * 23 * TIMES) + 5e-3 * np.sin(2 * np.pi * 61 * TIMES)
THICK = 1e-4 * (1 + 0.3 * np.sin(2 * np.pi * 17 * TIMES))


def delayed(tau: float, values: Values = LEVEL) -> np.ndarray:
    """What is shown at TIMES with the effect."""
    columns = {"slip_velocity": SLIP, "uncut_thickness": THICK}
    return follow(TIMES, columns, {**values, "input_delay.time": tau}, ON, *NAMES, "principal_force")


def shifted(tau: float) -> np.ndarray:
    """The same of a record whose slip has been shifted before: straight between its own corners, held before and after."""
    times = np.unique(np.concatenate([TIMES, np.clip(TIMES + tau, TIMES[0], TIMES[-1])]))
    slip = np.interp(times - tau, TIMES, SLIP)
    rows = follow(times, {"slip_velocity": slip, "uncut_thickness": np.interp(times, TIMES, THICK)}, LEVEL, (), *NAMES, "principal_force")
    return rows[:, np.searchsorted(times, TIMES)]


# Parts of a sample, samples, and so late or early that most of the record is gone.
@pytest.mark.parametrize("tau", [3.7e-4, 1e-3, 1.23e-2, 8e-2, -3.7e-4, -1e-3, -1.23e-2, -8e-2])
def test_a_late_or_early_slip_is_a_shifted_record(tau: float) -> None:
    sizes = np.array([[F_C], [F_C / SIGMA0], [2e-2], [F_C], [F_C]])
    np.testing.assert_allclose(delayed(tau) / sizes, shifted(tau) / sizes, atol=1e-6)
    assert np.abs(delayed(tau)[0] - delayed(0.0)[0]).max() > 0.1 * F_C


def test_a_late_slip_makes_late_forces_and_an_early_one_early_forces() -> None:
    """Where nothing but the slip changes a delay of the input is one of the forces, with its sign; an early force no sensor could have."""
    late = 7e-3
    plain = follow(TIMES, {"slip_velocity": SLIP}, LEVEL, (), NAMES[0])[0]
    for tau in (late, -late):
        force = follow(TIMES, {"slip_velocity": SLIP}, {**LEVEL, "input_delay.time": tau}, ON, NAMES[0])[0]
        np.testing.assert_allclose(force[27:73], plain[20:66] if tau > 0 else plain[34:80], atol=2e-6 * F_C)
    loose: Values = {**LEVEL, "relative_tolerance": 1e-5}  # a sensor remembers no more than 256 steps
    # and before the first sample stood still, where the input moved on as it first did
    by_sensor = follow(TIMES, {"slip_velocity": SLIP}, {**loose, "sensor_delay.time": late}, ("sensor_delay",), NAMES[3])[0]
    by_input = follow(TIMES, {"slip_velocity": SLIP}, {**loose, "input_delay.time": late}, ON, NAMES[3])[0]
    np.testing.assert_allclose(by_input[35:], by_sensor[35:], atol=1e-4 * F_C)


def test_a_host_that_holds_its_inputs_finds_each_jump_late() -> None:
    """Steps of 1 ms, each with its own slip, through zero and back; felt 2.5 steps later, and of the first nothing before."""
    tau, held = 2.5e-3, np.array([0.02, 0.02, -0.01, 0.0, 0.0, 0.03, -0.02, 0.01, 0.01, 0.01])
    one = begun({**LEVEL, "input_delay.time": tau, "slip_velocity": held[0]}, ON)
    other = begun({**LEVEL, "slip_velocity": held[0]})
    computed, right = [], []
    for n in range(len(held)):
        one.set("slip_velocity", held[n])
        one.advance(1e-3)
        computed.append(read(one, *NAMES[:3], "dissipated_energy"))
        for half in range(2):  # 2.5 steps before: the second half of one step, and the first of the next
            other.set("slip_velocity", held[max(n - 3 + half, 0)])
            other.advance(0.5e-3)
        right.append(read(other, *NAMES[:3], "dissipated_energy"))
    scale = np.array([F_C, F_C / SIGMA0, 0.02, F_C * 1e-4])
    np.testing.assert_allclose(computed / scale, right / scale, atol=2e-6)


def test_a_host_of_model_exchange_is_shown_the_late_slip() -> None:
    """Straight between the ends of its steps."""
    contact = begun({**LEVEL, "input_delay.time": 2.4e-3, "slip_velocity": 0.01}, ON)
    rng = np.random.default_rng(1)
    given = np.append(0.01, rng.uniform(-0.02, 0.02, 12))
    for n in range(1, len(given)):
        contact.time = n * 1e-3
        contact.set("slip_velocity", float(given[n]))
        contact.evaluate()
        wanted = np.interp(n - 2.4, np.arange(len(given)), given)
        assert contact.get("slip_velocity_used") == pytest.approx(wanted, abs=1e-12)
        contact.event()  # what a host tells where it stops


def test_a_step_cannot_know_what_comes_later() -> None:
    contact = begun({**LEVEL, "input_delay.time": -1e-3, "slip_velocity": 0.01}, ON)
    with pytest.raises(SimulationError, match=r"comes later .*follow a record, or shift the forces"):
        contact.advance(1e-3)


def test_a_record_has_all_its_corners_and_a_host_the_last_256() -> None:
    times = np.arange(600) * 1e-4
    slip = 1e-2 * np.cos(1e3 * times) ** 3
    for tau in (4e-2, -4e-2):
        delayed = follow(times, {"slip_velocity": slip}, {**LEVEL, "input_delay.time": tau}, ON, NAMES[2])[0]
        np.testing.assert_allclose(delayed, np.interp(times - tau, times, slip), atol=1e-12)
    contact = begun({**LEVEL, "input_delay.time": 4e-2, "relative_tolerance": 1e-4}, ON)

    def driven() -> None:
        for v in slip:
            contact.set("slip_velocity", float(v))
            contact.advance(1e-4)

    with pytest.raises(SimulationError, match="corners of an input"):
        driven()


def test_a_record_goes_on_where_another_has_ended() -> None:
    """In one piece and in two, of which the second looks back into the first."""
    values = {**LEVEL, "input_delay.time": 1.23e-2}
    whole = follow(TIMES, {"slip_velocity": SLIP}, values, ON, NAMES[0])[0]
    contact = begun({**values, "slip_velocity": float(SLIP[0])}, ON, float(TIMES[0]))
    parts = [contact.run(TIMES[at], {"slip_velocity": SLIP[at]}, NAMES[:1])[:, 0] for at in (slice(0, 51), slice(50, 101))]
    np.testing.assert_allclose(np.concatenate([parts[0], parts[1][1:]]), whole, atol=1e-6 * F_C)


def test_each_of_many_contacts_has_its_own_delay() -> None:
    """Early, late and none side by side give the bits of each alone."""
    delays = np.array([-2e-2, -3.3e-3, -1e-3, 0.0, 2e-4, 1e-3, 5.5e-3, 3e-2, -7e-4, 0.01])
    run = Run(TIMES, {"slip_velocity": SLIP, "uncut_thickness": THICK}, ("friction_force", "measured_friction_force"))
    many = run_many(run, {**LEVEL, "input_delay.time": delays}, ON)
    for n, tau in enumerate(delays):
        columns = {"slip_velocity": SLIP, "uncut_thickness": THICK}
        alone = follow(TIMES, columns, {**LEVEL, "input_delay.time": float(tau)}, ON, *run.outputs)
        for name, column in zip(run.outputs, alone, strict=True):
            np.testing.assert_array_equal(many.rows[name][n], column)
