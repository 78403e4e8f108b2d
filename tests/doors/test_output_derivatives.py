"""How fast do outputs change, as an FMU tells a master that extrapolates? Held to the FMU's own short steps."""

from __future__ import annotations

import ctypes as ct
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from evat.fmu.part_model import model_of
from evat.native import kernel
from evat.native.kernel import Contact
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from raw_fmi import ERROR, OK, Door, Instance

BOTH = pytest.mark.parametrize("version", [2, 3], ids=["FMI2", "FMI3"])
NAME = {2: "GetRealOutputDerivatives", 3: "GetOutputDerivatives"}


def asked(one: Instance, references: list[int], orders: list[int] | None = None) -> tuple[int, list[float]]:
    """Status and derivatives, by value reference."""
    count, slopes = len(references), (ct.c_double * len(references))()
    arrays = (ct.c_uint * count)(*references), ct.c_size_t(count), (ct.c_int * count)(*(orders or [1] * count)), slopes
    status = one.call(NAME[one.door.version], *arrays, *([ct.c_size_t(count)] if one.door.version == 3 else []))
    return status, list(slopes)


def told(one: Instance, names: list[str]) -> np.ndarray:
    status, slopes = asked(one, [one.door.reference[name] for name in names])
    assert status == OK, one.lines
    return np.array(slopes)


def give_slopes(one: Instance, slopes: Mapping[str, float]) -> None:
    """FMI 3 knows none: there inputs stand still."""
    count = len(slopes)
    if one.door.version == 2:
        references = (ct.c_uint * count)(*(one.door.reference[name] for name in slopes))
        arrays = ct.c_size_t(count), (ct.c_int * count)(*([1] * count)), (ct.c_double * count)(*slopes.values())
        assert one.call("SetRealInputDerivatives", references, *arrays) == OK, one.lines


EXTERNAL = {"kinematics": 2, "slip_velocity": 0.3, "uncut_thickness": 8e-5, "normal_load": 12.0}
MOVING = {"slip_velocity": -4e3, "uncut_thickness": 0.1, "normal_load": 100.0}
# Values, slopes of the inputs, communication step and the short one [s]. Every part of the machine, and the contact in each kinematics.
CASES: Mapping[str, tuple[Mapping[str, float], Mapping[str, float], float, float]] = {
    "contact": ({}, {}, 1.7e-6, 1e-9),
    "contact in motion": (
        {"kinematics": 3, "holder_compliance": 1, "sensor_lowpass": 1, "thermal_softening": 1, "tool_velocity_x": 0.01},
        {"tool_displacement_y": 5e-3, "tool_velocity_x": 5.0, "cutting_speed": 10.0},
        1.7e-6,
        1e-9,
    ),
    "contact that is given": ({**EXTERNAL, "load_dependence": 1, "dwell_strengthening": 1, "friction_law": 5}, MOVING, 1.7e-6, 1e-9),
    "evat_guideway": ({"slip_velocity": 0.01}, {"slip_velocity": -20.0}, 1e-5, 1e-8),
    "evat_slip": ({"slip_velocity": 0.2}, {"slip_velocity": -4e3, "uncut_thickness": 0.1}, 1.7e-6, 1e-9),
    "evat_cut": ({"cutting_speed": 0.15}, {"cutting_speed": 10.0}, 1.7e-6, 1e-9),
    "evat_turning": ({}, {"tool_velocity_y": 5.0}, 1.7e-6, 1e-9),
    "feed_drive": ({"position_reference": 1e-3}, {"position_reference": 0.02, "friction_force": 500.0}, 1e-3, 1e-6),
    "path_reference": ({}, {}, 1e-2, 1e-5),
    "spindle": ({"principal_force": 50.0}, {"principal_force": 1e3}, 1e-3, 1e-5),
    "tool_heat": ({"dissipated_power": 1.0, "cutting_speed": 0.3}, {"dissipated_power": 50.0, "cutting_speed": 10.0}, 1e-3, 1e-6),
    "tool_structure": ({"force_x": -30.0}, {"force_x": 1e4, "force_y": 2e4}, 1e-4, 1e-7),
}


@BOTH
@pytest.mark.parametrize("case", CASES)
def test_they_are_those_of_a_short_step(case: str, version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    """By the trapezoidal rule: what an output gains in a short step is the mean of its derivatives at both ends. Steps that an event falls
    into are left out, and a point in ten may lie where an output bends as steeply as at a chip's surface."""
    values, slopes, step, short = CASES[case]
    part = "evat_contact" if case.startswith("contact") else case
    names = [v.name for v in model_of(part).variables if v.causality == "output" and v.variability == "continuous" and v.type == "real"]
    door = Door(fmus[f"fmi{version}" if part == "evat_contact" else f"{part}-fmi{version}"], tmp_path)
    one = Instance(door)
    one.start(values)
    sides = [name for name in ("contact_indicator", "surface_indicator", "slip_indicator", "law_indicator") if name in door.reference]
    time, errors, sizes = 0.0, [], []
    for _ in range(40):
        give_slopes(one, slopes)
        assert one.step(time, step) == OK, one.lines
        time += step
        state = one.save()
        before, slope, held = np.array(one.get(*names)), told(one, names), np.sign(one.get(*sides))
        give_slopes(one, slopes)
        assert one.step(time, short) == OK, one.lines
        after, next_slope = np.array(one.get(*names)), told(one, names)
        if (held == np.sign(one.get(*sides))).all():
            errors.append(np.abs((after - before) / short - 0.5 * (slope + next_slope)))
            sizes.append(np.abs(slope))
        assert one.restore(state) == OK
        assert (told(one, names) == slope).all()  # what is restored is as it was saved, slopes of the inputs among it
        assert one.drop(state) == OK
    largest = np.max(sizes, axis=0)
    noise = 1e-14 * np.array([1.0 if v == 0 else abs(v) for v in before]) / short  # rounding of the outputs
    assert len(errors) > 30
    assert np.count_nonzero(largest) > 0.2 * len(names)
    worst = np.quantile(errors, 0.9, axis=0) / (largest + noise / 1e-4)
    assert (worst < 1e-4).all(), {name: float(w) for name, w in zip(names, worst, strict=True) if w >= 1e-4}
    one.free()


@BOTH
def test_fmpy_extrapolates_by_them(version: int, fmus: dict[str, Path]) -> None:
    """A master that has last values only is one step behind; with derivatives it is behind by the square of the step."""
    path = fmus[f"tool_structure-fmi{version}"]
    description, folder = read_model_description(str(path)), extract(str(path))
    references = {v.name: v.valueReference for v in description.modelVariables}
    assert description.coSimulation.maxOutputDerivativeOrder == 1
    slave = (FMU2Slave if version == 2 else FMU3Slave)(
        guid=description.guid if version == 2 else description.instantiationToken,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    slave.instantiate()
    if version == 2:
        slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    shown, get = [references["velocity_y"]], (slave.getReal if version == 2 else slave.getFloat64)
    (slave.setReal if version == 2 else slave.setFloat64)([references["force_y"]], [50.0])
    step, held, ahead = 2e-5, [], []
    for n in range(50):
        (now,) = get(shown)
        (slope,) = slave.getRealOutputDerivatives(shown, [1]) if version == 2 else slave.getOutputDerivatives(shown, [1])
        slave.doStep(n * step, step)
        (then,) = get(shown)
        held.append(abs(then - now))
        ahead.append(abs(then - now - slope * step))
    assert max(ahead) < 0.1 * max(held)
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(folder)


@pytest.fixture(params=[2, 3], ids=["FMI2", "FMI3"])
def one(request: pytest.FixtureRequest, fmus: dict[str, Path], tmp_path: Path) -> Iterator[Instance]:
    instance = Instance(Door(fmus[f"fmi{request.param}"], tmp_path))
    yield instance
    instance.free()


def test_inputs_go_on_as_in_the_last_step_or_as_they_are_told_to(fmus: dict[str, Path], tmp_path: Path) -> None:
    one = Instance(Door(fmus["evat_guideway-fmi2"], tmp_path)).start({"slip_velocity": 0.1, "friction_law": 1})
    give_slopes(one, {"slip_velocity": 7.0})
    assert told(one, ["sliding_speed"]) == pytest.approx(7.0, rel=1e-9)
    assert one.step(0.0, 1e-3) == OK
    assert told(one, ["sliding_speed"]) == pytest.approx(7.0, rel=1e-9)
    assert told(one, ["sliding_distance"]) == one.get("sliding_speed")
    other = Instance(one.door)  # in any process
    assert other.deserialize(one.serialize()) == OK
    assert told(other, ["sliding_speed", "friction_force"]).tolist() == told(one, ["sliding_speed", "friction_force"]).tolist()
    other.free()
    give_slopes(one, {"normal_load": 1.0})  # and no other is given any more
    assert told(one, ["sliding_speed"]) == [0.0]
    give_slopes(one, {"slip_velocity": -3.0})
    assert one.step(1e-3, 1e-3) == OK
    assert told(one, ["sliding_speed"]) == pytest.approx(-3.0, rel=1e-9)
    assert one.step(2e-3, 1e-3) == OK  # none is given: the input is held
    assert told(one, ["sliding_speed"]) == [0.0]
    one.free()


def test_a_reversal_at_the_point_is_not_smoothed_over(fmus: dict[str, Path], tmp_path: Path) -> None:
    """At v = 0 the speed |v| has one slope on the side that is held and another beyond, and Coulomb's force jumps."""
    one = Instance(Door(fmus["evat_guideway-fmi2"], tmp_path)).start({"slip_velocity": 0.125, "friction_law": 1})
    give_slopes(one, {"slip_velocity": -125.0})
    assert one.step(0.0, 1e-3) == OK
    assert one.get("slip_velocity") == [0.0]
    assert told(one, ["sliding_speed", "friction_force"]) == pytest.approx([-125.0, 0.0], rel=1e-6, abs=1e-6)
    one.free()


def slope_of_friction(contact: Contact) -> float:
    """d friction_force / d time [N/s] where the contact stands, asked of the kernel itself."""
    ffi, loaded = kernel.library()
    slope, asked_for = ffi.new("double *"), ffi.new("int *", kernel.variable("friction_force").index)
    assert loaded.kernel_time_derivatives(contact._contact, ffi.new("struct Contact *"), 1, asked_for, slope) == loaded.STATUS_OK
    return float(slope[0])


@pytest.mark.parametrize("side", [-1, 1])
def test_just_beside_a_reversal_they_are_those_of_that_side(side: int) -> None:
    """The law's curve has a kink there: differences that reach across it would mix both slopes, a fifth apart."""

    def after(time: float) -> Contact:
        contact = Contact()
        contact.start()
        contact.advance(time)
        return contact

    reversal = Contact()
    reversal.start()
    while abs(reversal.get("slip_velocity_used")) > 1e-6:
        reversal.advance(5e-5, stop_at_events=True)
        reversal.event()
    near, far = (slope_of_friction(after(reversal.time + side * away)) for away in (1e-12, 1e-10))
    assert near == pytest.approx(far, rel=1e-3)


def test_means_are_constant_between_the_ends_of_windows(one: Instance) -> None:
    one.start()
    assert one.step(0.0, 7.3e-5) == OK
    assert one.get("mean_principal_force")[0] > 1
    assert told(one, ["mean_principal_force", "mean_contact_ratio"]).tolist() == [0.0, 0.0]


def test_means_over_steps_go_on_to_those_of_another(one: Instance) -> None:
    """Where averaging = cycle: to the means that the next step shows, if inputs go on as they do."""
    one.start({"kinematics": 3, "averaging": 2, "sensor_lowpass": 1, "sensor_lowpass.time_constant": 5e-3})
    names = ["principal_force", "mean_feed_force", "measured_principal_force", "speed_ratio"]
    for n in range(3):
        give_slopes(one, {"cutting_speed": 20.0})
        assert one.step(n * 1e-3, 1e-3) == OK, one.lines
    before, slopes = np.array(one.get(*names)), told(one, names)
    assert told(one, ["dissipated_energy"]) == one.get("dissipated_power")
    give_slopes(one, {"cutting_speed": 20.0})
    assert one.step(3e-3, 1e-3) == OK
    gained = np.array(one.get(*names)) - before
    assert np.abs(gained[2]) > 1e-3
    assert slopes * 1e-3 == pytest.approx(gained, rel=1e-6, abs=1e-9)


def test_what_has_none_is_refused_in_one_line(one: Instance) -> None:
    of = one.door.reference
    names = {name: v.causality for name, v in one.door.variables.items()}
    assert names["bristle_rate"] == "local"
    for reference, order, words in (
        (of["friction_force"], 2, ["order 2", "friction_force", "allowed is order 1"]),
        (of["friction_force"], 0, ["order 0"]),
        (of["slip_velocity"], 1, ["slip_velocity", "an input", "only outputs"]),
        (of["bristle_rate"], 1, ["bristle_rate", "a local variable"]),
        (of["F_C"], 1, ["F_C", "a parameter"]),
        (of["step_count"], 1, ["step_count", "an integer"]),
        (of["in_contact"], 1, ["in_contact", "a Boolean"]),
        (0, 1, ["value reference 0"]),
        (99_999, 1, ["value reference 99999"]),
    ):
        for turn in (1, -1):  # wherever it stands among others
            one.start()
            assert one.step(0.0, 1e-6) == OK
            status, _ = asked(one, [of["friction_force"], reference][::turn], [1, order][::turn])
            assert status == ERROR
            line = one.said()
            assert all(word in line for word in words), line
            assert one.call("Reset") == OK


def test_they_are_refused_before_the_start_and_without_arrays(one: Instance) -> None:
    friction = [one.door.reference["friction_force"]]
    assert asked(one, friction)[0] == ERROR
    assert "Step Mode" in one.said()
    assert asked(one, friction)[0] == ERROR  # the instance has failed before it began
    assert "not initialised" in one.said()
    assert one.call("Reset") == OK
    assert one.set_up() == OK
    assert asked(one, friction)[0] == ERROR
    assert "Initialization Mode" in one.said()
    assert one.call("Reset") == OK
    one.start()
    for missing in range(3):
        arrays: list[object] = [(ct.c_uint * 1)(*friction), (ct.c_int * 1)(1), (ct.c_double * 1)()]
        arrays[missing] = None
        arguments = [arrays[0], ct.c_size_t(1), *arrays[1:], *([ct.c_size_t(1)] if one.door.version == 3 else [])]
        assert one.call(NAME[one.door.version], *arguments) == ERROR
        assert "NULL" in one.said()
        assert one.call("Reset") == OK
        one.start()
    assert asked(one, []) == (OK, [])
    assert one.step(0.0, 1e-6) == OK
    assert one.call("Terminate") == OK
    assert asked(one, friction)[0] == OK


def test_a_solver_is_told_to_ask_for_rates(one: Instance) -> None:
    solver = Instance(one.door, model_exchange=True).start()
    assert solver.call("Terminate") == OK
    assert asked(solver, [solver.door.reference["friction_force"]])[0] == ERROR
    assert "Model Exchange" in solver.said()
    solver.free()
