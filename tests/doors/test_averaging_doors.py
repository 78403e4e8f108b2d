"""Does averaging = cycle answer alike through every door: C in many lanes, Python, FMI 2, FMI 3? And who refuses it?"""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from evat.model import Run
from evat.native import kernel
from evat.native.batch import run_many
from evat.native.kernel import Contact
from fmpy.fmi2 import FMU2Slave
from raw_fmi import ERROR, OK, Door, Instance

CYCLE = kernel.variable("averaging").choices.index("cycle")
STEPS = (1e-3, 1e-4, 5e-3, 3.3e-4)
SPEEDS = (0.15, 0.25, 0.3, 0.2)
SHOWN = tuple(v.name for v in kernel.variables() if v.causality in ("output", "local"))
Make = Callable[..., Instance]


@pytest.fixture(scope="module", params=["fmi2", "fmi3"])
def door(request: pytest.FixtureRequest, fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Door:
    return Door(fmus[request.param], tmp_path_factory.mktemp("door"))


def of_kernel(values: dict[str, float], on: tuple[str, ...]) -> list[list[float]]:
    contact = Contact({**values, "averaging": "cycle"}, on)
    contact.start()
    rows = []
    for step, speed in zip(STEPS, SPEEDS, strict=True):
        contact.set("cutting_speed", speed)
        contact.advance(step)
        rows.append([contact.get(name) for name in SHOWN])
    return rows


def of_instance(one: Instance, begin: float, values: dict[str, float] | None = None, on: tuple[str, ...] = ()) -> list[list[float]]:
    if values is not None:
        one.start({**values, **dict.fromkeys(on, 1.0), "averaging": CYCLE + 1})
    rows, time = [], begin
    for step, speed in zip(STEPS, SPEEDS, strict=True):
        assert one.set({"cutting_speed": speed}) == OK
        assert one.step(time, step) == OK, one.lines
        time = one.get("time")[0]
        rows.append(one.get(*SHOWN))
    return rows


@pytest.mark.parametrize("on", [(), ("holder_compliance", "sensor_lowpass", "regenerative")])
def test_an_fmu_answers_as_the_kernel_does(make: Make, on: tuple[str, ...]) -> None:
    """To the last bit."""
    values = {"release_time": 1e-5}
    assert of_instance(make(), 0.0, values, on) == of_kernel(values, on)


def test_a_state_brings_back_the_run(make: Make) -> None:
    """Serialised, into another instance."""
    one, other = make(), make()
    of_instance(one, 0.0, {}, ("sensor_delay", "holder_compliance"))
    data, begin = one.serialize(), one.get("time")[0]
    other.start()
    assert other.deserialize(data) == OK
    assert of_instance(other, begin) == of_instance(one, begin)


def test_a_ramped_input_is_taken_at_the_middle_of_the_step(make: Make) -> None:
    """FMI 2 by the derivative of the input, which is good to second order; held inputs lag by half a step."""
    if make().door.version == 3:
        pytest.skip("FMI 3 has no input derivatives")
    ramped, held = make(), make()
    for one, speed in ((ramped, 0.2), (held, 0.25)):
        one.start({"averaging": CYCLE + 1, "cutting_speed": speed})
    reference, orders, slopes = one.door.reference["cutting_speed"], (1,), (100.0,)
    assert ramped.call("SetRealInputDerivatives", (ct.c_uint * 1)(reference), 1, (ct.c_int * 1)(*orders), (ct.c_double * 1)(*slopes)) == OK
    assert (ramped.step(0.0, 1e-3), held.step(0.0, 1e-3)) == (OK, OK)
    assert ramped.get("mean_principal_force") == pytest.approx(held.get("mean_principal_force"), rel=1e-12)
    assert ramped.get("cutting_speed")[0] == pytest.approx(0.3, rel=1e-12)


def test_model_exchange_refuses_it(make: Make) -> None:
    one = make(model_exchange=True)
    assert one.set({"averaging": CYCLE + 1}) == OK
    assert one.set_up() == OK
    assert one.call("ExitInitializationMode") == ERROR
    assert "averaging = resolved" in one.said()


def test_external_kinematics_refuse_it(make: Make) -> None:
    one = make()
    assert one.set({"averaging": CYCLE + 1, "kinematics": 2}) == OK
    assert one.set_up() == OK
    assert one.call("ExitInitializationMode") == ERROR
    assert "kinematics = internal or combined" in one.said()


def test_the_python_fmu_refuses_it(python_fmu: Path, tmp_path: Path) -> None:
    """It follows every cycle; every step is then refused, and the log says why."""
    lines: list[str] = []
    fmpy.extract(str(python_fmu), str(tmp_path))
    description = fmpy.read_model_description(str(python_fmu), validate=False)
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=str(tmp_path), modelIdentifier=description.coSimulation.modelIdentifier, instanceName="one"
    )
    callbacks = fmpy.fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda _e, _n, _s, _c, text: lines.append(text.decode()))
    callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
    slave.instantiate(callbacks=callbacks, loggingOn=True)
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    reference = next(v.valueReference for v in description.modelVariables if v.name == "averaging")
    slave.setInteger([reference], [CYCLE + 1])
    slave.exitInitializationMode()
    with pytest.raises(Exception, match="fmi2DoStep"):
        slave.doStep(0.0, 1e-5)
    assert any("averaging = cycle: not written here" in line for line in lines)
    slave.terminate()
    slave.freeInstance()


@pytest.mark.parametrize(("law", "release"), [("lugre", 0.0), ("lugre", 1e-4), ("bristle", 1e-4)])
@pytest.mark.parametrize("start", ["at_rest", "periodic"])
def test_eight_lanes_average_like_eight_contacts(law: str, release: float, start: str) -> None:
    """Each to the last bit what it gives alone, though some run a second cycle of a step and others do not, each begins its cycles where
    its own ellipse is highest, and its surface runs out in its own turns."""
    speeds = np.linspace(0.05, 0.9, 8)
    times = 1e-3 * np.arange(11)
    names = (
        "mean_principal_force",
        "averaging_error",
        "dissipated_energy",
        "bristle_deflection",
        "step_count",
        "slip_velocity_used",
        "sensor_lowpass.feed_force",
    )
    values: dict[str, Any] = {"averaging": "cycle", "friction_law": law, "initial_state": start, "release_time": release}
    own = {"cutting_speed": speeds, "F_S": np.linspace(5, 12, 8), "ellipse_phase_error.delta": np.linspace(-1.1, 0.9, 8)}
    own |= {"run_out.amplitude": np.repeat([0.0, 2e-6], 4), "run_out.spindle_frequency": np.geomspace(10, 1000, 8)}
    on = ("sensor_lowpass", "amplitude_loss", "ellipse_phase_error", "run_out")
    batch = run_many(Run(times, {}, names), {**values, **own}, on)
    assert not batch.failed
    for place in range(8):
        alone = Contact({**values, **{name: each[place] for name, each in own.items()}}, on)
        alone.start()
        rows = alone.run(times, {}, names)
        for column, name in enumerate(names):
            assert (batch.rows[name][place] == rows[:, column]).all(), (place, name)
