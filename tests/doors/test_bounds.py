"""Does everything compute at the bounds that the tables declare, and next to 0, where 0 stands for off? Finite numbers, or a refusal."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Iterator

import numpy as np
import pytest
from evat import ContactModel
from evat.experiment.column import Column
from evat.experiment.document import ExperimentError
from evat.model import ParameterError, Run, SimulationError, Variable
from evat.native import kernel, machine
from evat.native.batch import run_many
from raw_fmi import ERROR, OK, WARNING, Door, Instance

ffi, library = kernel.library()
SHOWN = [v for v in kernel.variables() if v.causality in ("output", "local")]
OWNER = {v.name: effect.name for effect in kernel.effects() for v in effect.variables}
# Beside the variable in question: every law, every source of motion and of the proxy, both principles and modes; no two alike.
CASES: dict[str, dict[str, float | str]] = {
    "internal": {},
    "periodic": {"initial_state": "periodic", "release_time": 1e-5, "shear_angle_principle": "minimum_energy", "rake_angle": 0.1},
    "external": {
        "kinematics": "external",
        "slip_velocity": 0.1,
        "proxy_source": "contact_temperature",
        "contact_temperature": 500.0,
        "averaging_window": 1e-5,
    },
    "combined": {"kinematics": "combined", "proxy_source": "proxy_speed", "proxy_speed": 0.2, "friction_law": "dahl"},
    "bristle": {"friction_law": "bristle"},
    "reset": {"friction_law": "reset_integrator", "cutting_speed": 0.9},
    "karnopp": {"friction_law": "karnopp", "kinematics": "external", "slip_velocity": 0.1},
    "published": {"damping_mode": "as_published", "rate_stiffness": "thermal", "proxy_source": "cutting_speed"},
    "own angle": {"chip_flow_angle": "current_shear_angle", "relative_tolerance": 1e-3},
    "cycle": {"averaging": "cycle"},
}
TINY = (5e-324, 1e-310, 1e-250, 1e-160, 1e-100, 1e-30, 1e-11)
# What a run may answer beside "done". Too many steps: of the 2000 that a run has here; the others name what does not go together.
WORDS = ("internal steps", "must lie above ambient_temperature", "looks back further")


def near_the_bounds(v: Variable) -> Iterator[float]:
    values = [v.min, v.max, math.nextafter(v.min, math.inf), math.nextafter(v.max, -math.inf), 0.0, *TINY, *(-x for x in TINY)]
    yield from (x for x in dict.fromkeys(values) if v.min <= x <= v.max)


def followed(base: dict[int, float], changed: dict[int, float]) -> tuple[str, np.ndarray]:
    """Six samples of 10 us: how it ended, and what every sample showed."""
    contact, times, rows = ffi.new("struct Contact *"), np.arange(7) * 1e-5, np.full((7, len(SHOWN)), 0.0)
    library.kernel_reset(contact)
    for index, value in {**base, **changed}.items():
        assert library.kernel_set(contact, index, 0, value) == library.STATUS_OK
    status = library.kernel_start(contact, 0.0)
    if status == library.STATUS_OK:
        record, answer = ffi.new("struct Record *"), ffi.new("struct Yield *")
        wanted, none = ffi.new("int[]", [v.index for v in SHOWN]), ffi.new("int[]", 1)
        record.count, record.times, record.input_index, record.most_steps = 7, ffi.from_buffer("double[]", times), none, 2000
        answer.output_count, answer.output_index, answer.rows = len(SHOWN), wanted, ffi.from_buffer("double[]", rows)
        status = library.kernel_run_record(contact, record, answer, ffi.NULL)
        rows = rows[: answer.rows_done]
    return kernel.status_text(status), rows


@pytest.mark.parametrize("case", CASES)
def test_the_contact_computes_at_every_bound_and_next_to_zero(case: str) -> None:
    base = {kernel.variable(name).index: number for name, number in kernel.check_values(CASES[case]).items()}
    wrong, runs, done = [], 0, 0
    for v in kernel.variables():
        if v.causality not in ("parameter", "input") or v.type != "real":
            continue
        switch = {kernel.variable(OWNER[v.name]).index: 1.0} if v.name in OWNER else {}
        for value in near_the_bounds(v):
            text, rows = followed(base, {**switch, v.index: value})
            lost = [SHOWN[j].name for j in np.nonzero(~np.isfinite(rows).all(axis=0))[0]]
            runs, done = runs + 1, done + (text == "done")
            if lost or not (text == "done" or any(words in text for words in WORDS)):
                wrong.append(f"{v.name} = {value:g}: {text} {lost}")
    assert wrong == []
    assert runs > 800
    assert done > 0.97 * runs


@pytest.mark.parametrize("part", machine.names())
def test_a_partner_computes_at_every_bound_and_next_to_zero(part: str) -> None:
    wrong = []
    for v in machine.variables(part):
        for value in near_the_bounds(v) if v.causality in ("parameter", "input") and v.type == "real" else ():
            one = machine.Machine(part, {v.name: value})
            try:
                one.start()
                for _ in range(3):
                    one.advance(1e-3)
            except SimulationError as error:
                if (part, v.name) != ("feed_drive", "motor_inertia"):  # an elastic screw needs a motor with inertia
                    wrong.append(f"{v.name} = {value:g}: {error}")
            else:
                if not np.isfinite(one.values()).all():
                    wrong.append(f"{v.name} = {value:g}")
    assert wrong == []


# ---- what is too small to mean anything is off ----


@pytest.mark.parametrize(
    ("name", "on", "tiny"),
    [
        ("release_time", (), 9e-13),
        ("averaging_window", (), 9e-10),
        ("amplitude_x", (), 9e-13),
        ("proxy_lag.time_constant", ("proxy_lag", "thermal_softening"), 9e-13),
        ("sensor_lowpass.time_constant", ("sensor_lowpass",), 9e-13),
        ("dynamometer_resonance.natural_period", ("dynamometer_resonance",), 9e-13),
        ("sensor_delay.time", ("sensor_delay",), 9e-13),
    ],
)
def test_below_its_smallest_meaning_a_value_is_off(name: str, on: tuple[str, ...], tiny: float) -> None:
    shown = []
    for value in (0.0, 5e-324, tiny, 1e7 * tiny):
        contact = kernel.Contact({name: value}, on)
        contact.start()
        for _ in range(4):
            contact.advance(1.3e-5)
        kept = [i for i, v in enumerate(kernel.variables()) if v.name != name]
        shown.append(contact.values()[kept])
        assert contact.get(name) == value  # what was set is what is shown
    np.testing.assert_array_equal(shown[1], shown[0])
    np.testing.assert_array_equal(shown[2], shown[0])
    assert not np.array_equal(shown[3], shown[0])


# ---- steps ----


@pytest.mark.parametrize("case", CASES)
def test_the_shortest_steps_move_the_time_and_tell_no_nonsense(case: str) -> None:
    contact = kernel.Contact(CASES[case], ("sensor_lowpass", "sensor_delay", "proxy_lag", "amplitude_loss"))
    contact.start()
    for step in (5e-324, 1e-320, 1e-308, 1e-200, 1e-100, 1e-31, 1e-29, 1e-20, 1e-15):
        before = contact.time
        contact.advance(step)
        assert contact.time == before + step
        assert np.isfinite(contact.values()).all(), step
    contact.advance(1e-5)
    assert np.isfinite(contact.values()).all()


@pytest.mark.parametrize("step", [1.0001e9, 1e300, math.inf, math.nan, 0.0, -1e-9])
def test_a_step_that_is_none_is_refused(step: float) -> None:
    contact = kernel.Contact({"kinematics": "external", "slip_velocity": 0.1})
    contact.start()
    with pytest.raises(SimulationError, match="above 0 and up to 1e9 s"):
        contact.advance(step)
    partner = machine.Machine("spindle")
    partner.start()
    with pytest.raises(SimulationError, match="above 0 and up to 1e9 s"):
        partner.advance(step)
    contact.advance(1e9)
    assert np.isfinite(contact.values()).all()


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_takes_a_subnormal_step_from_time_0(version: int, request: pytest.FixtureRequest, tmp_path) -> None:
    one = Instance(Door(request.getfixturevalue(f"fmi{version}_fmu"), tmp_path))
    one.start({"sensor_lowpass": 1})
    time = 0.0
    for size in (1e-320, 1e-300, 1e-40, 1e-6):
        assert one.step(time, size) == OK
        time += size
        assert one.get("time") == [time]
        assert all(map(math.isfinite, one.get("friction_force", "bristle_rate", "measured_friction_force", "mean_friction_force")))
    assert one.step(time, 1e-23) == ERROR  # a host whose clock stands still would call for ever
    assert "too small" in one.said()
    one.free()


# ---- inputs that miss a bound by a hair ----

EXTERNAL = {"kinematics": "external", "slip_velocity": 0.1, "relative_tolerance": 1e-6}
HAIRS = [  # how the contact is set, the input, what misses its bound by a hair, the bound
    ({}, "cutting_speed", -1e-15, 0.0),
    ({**EXTERNAL, "friction_law": "amontons"}, "normal_load", -1e-12, 0.0),
    ({**EXTERNAL, "proxy_source": "proxy_speed", "thermal_softening": 1.0}, "proxy_speed", -1e-18, 0.0),
    ({}, "cutting_speed", 1e2 + 9e-7, 1e2),
]


@pytest.mark.parametrize(("values", "name", "value", "bound"), HAIRS)
@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_holds_an_input_on_the_bound_that_it_misses_by_a_hair(
    version: int, values: dict[str, float | str], name: str, value: float, bound: float, request: pytest.FixtureRequest, tmp_path
) -> None:
    door = Door(request.getfixturevalue(f"fmi{version}_fmu"), tmp_path)
    numbers = {key: number + (kernel.variable(key).type == "choice") for key, number in kernel.check_values(values).items()}
    ends = []
    for given in (value, bound):
        one = Instance(door)
        one.start(numbers)
        assert one.step(0.0, 1e-5) == OK
        assert one.set({name: given}) == (WARNING if given != bound and version == 3 else OK)
        if given != bound:
            line = one.said()
            assert f"{name} = " in line
            assert "is held at" in line
            assert one.set({name: given}) == OK  # said once
        assert one.get(name) == [bound]
        steps = one.get("step_count")[0]
        assert one.step(1e-5, 1e-5) == OK
        ends.append(one.get("friction_force", "dissipated_energy", "mean_friction_force", "bristle_deflection"))
        held = one.get("step_count")[0] - steps if given != bound else 0
        assert one.get("clamped_count") == [held]
        assert one.set({name: kernel.variable(name).start}) == OK
        assert one.step(2e-5, 1e-5) == OK
        assert one.get("clamped_count") == [held]  # what is given within the bounds is not clamped
        one.lines = [line for line in one.lines if "clearance face" not in line[2] and "turns back" not in line[2]]
        assert not one.lines
        one.free()
    assert ends[0] == ends[1]  # the same bits


@pytest.mark.parametrize(("values", "name", "value", "bound"), HAIRS)
def test_python_and_its_records_hold_such_an_input_too(values: dict[str, float | str], name: str, value: float, bound: float) -> None:
    times = np.arange(5) * 1e-5
    outputs = ("friction_force", "dissipated_energy", "clamped_count", "step_count")
    column, on_bound = np.full((2, 5), kernel.variable(name).start)
    column[2:4], on_bound[2:4] = value, bound
    lawful = {k: v for k, v in values.items() if k != "thermal_softening"}
    on = [k for k in values if k == "thermal_softening"]
    model = ContactModel()
    extra = {"normal_load": 10.0} if name != "normal_load" else {}
    traces = [model.simulate(Run(times, {name: given}, outputs), on, {**lawful, **extra}) for given in (column, on_bound)]
    for output in outputs[:2]:
        np.testing.assert_array_equal(traces[0][output], traces[1][output])
    clamped, steps = traces[0]["clamped_count"] - traces[1]["clamped_count"], traces[0]["step_count"]
    # counted: the steps that begin or end beyond the bound, 1 -> 4
    np.testing.assert_array_equal(np.diff(clamped) > 0, [False, True, True, True])
    assert clamped[-1] == steps[-1] - steps[1]
    assert "a hair outside its bounds" in traces[0].made_by["warnings"]
    assert "a hair outside its bounds" not in traces[1].made_by["warnings"]
    many = run_many(Run(times, {name: np.stack([column] * 5)}, outputs), {**lawful, **extra}, on).rows
    for output in outputs:
        np.testing.assert_array_equal(many[output], np.broadcast_to(traces[0][output], (5, 5)))
    held = kernel.Contact({**values, name: value})
    assert held.get(name) == bound
    held.set(name, value)
    assert held.get(name) == bound
    assert any("a hair outside" in line for line in held.warnings())


def test_what_misses_a_bound_by_more_is_refused_everywhere(fmi2_fmu, fmi3_fmu, tmp_path) -> None:
    known, doors = kernel.variable("cutting_speed"), [Door(fmu, tmp_path) for fmu in (fmi2_fmu, fmi3_fmu)]
    assert known.slack == 1e-6  # a millionth of its nominal 1 m/s
    assert kernel.variable("normal_load").slack == pytest.approx(1e-5, rel=1e-15)
    assert kernel.variable("F_C").slack == 0.0  # a parameter is typed, not computed
    for value in (-1.1e-6, math.nan, -math.inf, 101.0):
        with pytest.raises(ParameterError, match="cutting_speed"):
            kernel.Contact({"cutting_speed": value})
        with pytest.raises(ParameterError, match="cutting_speed"):
            ContactModel().simulate(Run(np.array([0.0, 1e-5]), {"cutting_speed": np.array([0.1, value])}, ("feed_force",)), (), {})
        with pytest.raises(ExperimentError, match=r"cutting_speed|no finite number"):
            Column.of("v", "cutting_speed", "m/s", known).checked("a.csv", np.array([1, 2]), np.array([0.1, value]))
        for door in doors:
            one = Instance(door)
            assert one.set({"cutting_speed": value}) == ERROR
            assert "cutting_speed" in one.said()
            one.free()
    with pytest.raises(ParameterError, match="F_C"):
        kernel.Contact({"F_C": 1e-6 - 1e-15})
    column = Column.of("v", "cutting_speed", "m/s", known).checked("a.csv", np.array([1, 2]), np.array([0.1, -1e-15]))
    np.testing.assert_array_equal(column, [0.1, -1e-15])  # the record is kept as it is; the model holds it on the bound


def test_a_partner_holds_such_an_input_too() -> None:
    ends = []
    for speed in (-1e-15, 0.0):
        heat = machine.Machine("tool_heat", {"cutting_speed": speed, "shear_power": 50.0})
        assert heat.get("cutting_speed") == 0.0
        heat.start()
        heat.advance(0.1)
        ends.append(heat.values())
    np.testing.assert_array_equal(*ends)
    with pytest.raises(ParameterError, match="cutting_speed"):
        machine.Machine("tool_heat", {"cutting_speed": -1e-5})


def test_a_ramp_that_misses_a_bound_by_a_hair_ends_on_it(fmi2_fmu, tmp_path) -> None:
    one = Instance(Door(fmi2_fmu, tmp_path))
    one.start({"cutting_speed": 0.3})
    reference, first, count = (ct.c_uint * 1)(one.door.reference["cutting_speed"]), (ct.c_int * 1)(1), ct.c_size_t(1)
    for time, ends_at, said in ((0.0, 0.0, 0), (1e-5, -1e-12, 1), (2e-5, -1e-12, 0)):  # meant to end at 0; a hair below
        assert one.set({"cutting_speed": 0.3}) == OK
        slope = (ct.c_double * 1)((ends_at - 0.3) / 1e-5)
        assert one.call("SetRealInputDerivatives", reference, count, first, slope) == OK
        assert one.step(time, 1e-5) == OK
        assert one.get("cutting_speed")[0] == pytest.approx(0.0, abs=1e-16)
        assert one.get("cutting_speed")[0] >= 0.0
        assert len(one.lines) == said
        one.lines.clear()
    one.free()


def test_an_input_stands_still_behind_its_record() -> None:
    """Its last slope is that of the last two samples, and ends with them."""
    contact, times, slip = ffi.new("struct Contact *"), np.array([0.0, 1e-3]), np.array([0.1, 0.3])
    library.kernel_reset(contact)
    index = {name: kernel.variable(name).index for name in ("kinematics", "slip_velocity", "sliding_distance")}
    assert library.kernel_set(contact, index["kinematics"], 0, 1.0) == library.STATUS_OK
    assert library.kernel_start(contact, 0.0) == library.STATUS_OK
    record, answer = ffi.new("struct Record *"), ffi.new("struct Yield *")
    led = ffi.new("int *", index["slip_velocity"])
    record.count, record.times, record.input_count, record.input_index = 2, ffi.from_buffer("double[]", times), 1, led
    record.inputs = ffi.from_buffer("double[]", slip)
    assert library.kernel_run_record(contact, record, answer, ffi.NULL) == library.STATUS_OK
    before = contact.value[index["sliding_distance"]][0]
    assert library.kernel_advance(contact, 1.0, 0, ffi.new("double *")) == library.STATUS_OK
    assert contact.value[index["slip_velocity"]][0] == 0.3
    assert contact.value[index["sliding_distance"]][0] - before == pytest.approx(0.3, rel=1e-12)
