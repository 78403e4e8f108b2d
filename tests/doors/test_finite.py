"""Does a number that is no number ever leave an instance with OK? Not to a host of FMI, and not to Python."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from evat.model import SimulationError
from evat.native import kernel
from raw_fmi import DISCARD, ERROR, OK, REAL, Door, Instance

Make = Callable[..., Instance]
HUGE = 1.7e308
STATES = kernel.states()


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI2", "FMI3"])
def door(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Door:
    fmu: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return Door(fmu, tmp_path_factory.mktemp("door"))


def one_value(one: Instance, name: str) -> tuple[int, float]:
    status, (value,) = one.get_as(REAL, [one.door.reference[name]])
    return status, value


def test_a_start_out_of_reach_is_an_error_that_says_so(make: Make) -> None:
    """A filter that starts at 1e308 N: its rate overflows. What is finite can still be read, for whoever looks for the cause."""
    one = make()
    assert one.set({"sensor_lowpass": 1, "sensor_lowpass.friction_force": -HUGE}) == OK
    assert one.set_up() == OK
    assert one.call("ExitInitializationMode") == ERROR
    assert "no longer a finite number" in one.said()
    status, _ = one_value(one, "sensor_lowpass.friction_force_rate")
    assert status == ERROR
    line = one.said()
    assert "sensor_lowpass.friction_force_rate is inf" in line
    assert "restore an FMU state" in line
    assert one_value(one, "F_C") == (OK, 9.0)


def test_a_solver_that_strays_is_told_to_discard_and_comes_back(make: Make) -> None:
    one = make(model_exchange=True)
    one.start({"sensor_lowpass": 1})
    assert one.update()[0] == OK
    assert one.call("EnterContinuousTimeMode") == OK
    count = ct.c_size_t(len(STATES))
    far = (ct.c_double * len(STATES))()
    far[STATES.index("sensor_lowpass.friction_force")] = HUGE
    assert one.call("SetContinuousStates", far, count) == OK
    rates = "GetDerivatives" if one.door.version == 2 else "GetContinuousStateDerivatives"
    for name in (rates, "GetEventIndicators"):
        assert one.call(name, (ct.c_double * len(STATES))(), count if name == rates else ct.c_size_t(4)) == DISCARD
        assert "finite" in one.said()
    assert one_value(one, "friction_force")[0] == DISCARD
    assert one.said()
    assert one.call("SetContinuousStates", (ct.c_double * len(STATES))(), count) == OK
    assert all(map(math.isfinite, one.get("friction_force", "sensor_lowpass.friction_force_rate")))


@pytest.mark.parametrize("seed", [math.nan, math.inf, HUGE])
def test_derivatives_take_and_give_finite_numbers(make: Make, seed: float) -> None:
    """d dissipated_power / d slip_velocity is above 1: times 1.7e308 it is none."""
    one = make()
    one.start({"kinematics": 2, "slip_velocity": 0.5})
    unknown = (ct.c_uint * 1)(one.door.reference["dissipated_power"])
    known = (ct.c_uint * 1)(one.door.reference["slip_velocity"])
    count, result = ct.c_size_t(1), (ct.c_double * 1)()
    tail: list[object] = [result] if one.door.version == 2 else [count, result, count]
    assert one.call("GetDirectionalDerivative", unknown, count, known, count, (ct.c_double * 1)(seed), *tail) == ERROR
    line = one.said()
    assert ("dissipated_power" in line) if seed == HUGE else ("seed" in line)


def test_a_derivative_of_an_output_is_a_finite_number(fmi2_fmu: Path, tmp_path: Path) -> None:
    """A viscous force of 10 N s/m, whose slip grows by 1.7e308 m/s in a second: by more than there is a number for."""
    one = Instance(Door(fmi2_fmu, tmp_path))
    one.start({"kinematics": 2, "slip_velocity": 0.5, "sigma2": 10.0})
    slip, force = ((ct.c_uint * 1)(one.door.reference[name]) for name in ("slip_velocity", "friction_force"))
    count, first = ct.c_size_t(1), (ct.c_int * 1)(1)
    for slope, status in ((1e300, OK), (HUGE, ERROR)):
        result = (ct.c_double * 1)()
        assert one.call("SetRealInputDerivatives", slip, count, first, (ct.c_double * 1)(slope)) == OK
        assert one.call("GetRealOutputDerivatives", force, count, first, result) == status, one.lines
        assert status == ERROR or math.isfinite(result[0])
    assert "friction_force" in one.said()
    one.free()


def test_a_record_in_which_a_number_is_lost_breaks_off() -> None:
    contact = kernel.Contact({"kinematics": "external", "slip_velocity": 0.1}, ("dynamometer_resonance",))
    contact.start()
    contact.set("dynamometer_resonance.friction_force_speed", HUGE)
    with pytest.raises(SimulationError, match="no longer a finite number"):
        contact.run(np.array([0.0, 1e-6, 2e-6]), {}, ["friction_force", "dynamometer_resonance.friction_force_acceleration"])
    fresh = kernel.Contact({"kinematics": "external", "slip_velocity": 0.1}, ("dynamometer_resonance",))
    fresh.start()
    fresh.set("dynamometer_resonance.friction_force_speed", HUGE)
    with pytest.raises(SimulationError, match="no longer a finite number"):
        fresh.evaluate()
