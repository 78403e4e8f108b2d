"""Does everything that calls itself a Model keep what evat.model promises of one? Contact, FMU, axis, and the models of the tests."""

from __future__ import annotations

import ast
import inspect
import math
import shutil
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_type_hints

import evat
import numpy as np
import pytest
from evat.gap import diagnose
from evat.model import FloatArray, Model, ParameterError, Run, SimulationError
from evat.models.axis import AxisModel
from evat.models.contact import ContactModel
from evat.models.fmu import FmuModel
from evat.native import kernel
from test_hypothesis import TwoLaws
from test_location import Turning
from test_objective import Level
from test_screen import Late
from test_starts import Damped, Powered
from test_toy_model import Twice
from test_valleys import TwoValleys, identified
from toy import Loud, Toy, measured

Values = Mapping[str, float | str]
TIMES: FloatArray = np.arange(60, dtype=np.float64) * 2e-3
SLIP: FloatArray = 0.02 * np.sin(2 * np.pi * 7 * TIMES)
SLIDING: Values = {"kinematics": "external", "F_C": 5.0, "F_S": 7.0, "sigma0": 1e5, "sigma1": 200.0}
LEANING: Values = {**SLIDING, "direction_asymmetry.a": 0.1}
HOT: Values = {"proxy_source": "contact_temperature", "contact_temperature": 350.0}  # K, above the reference temperature below
MEMBERS = [name for name, member in vars(Model).items() if inspect.isfunction(member) and not name.startswith("_")]


@dataclass(frozen=True)
class Case:
    """How one Model is asked.

    values, run, on : an ordinary run; vary : a parameter and values of it; steady : constant conditions with what settles in them;
    failing : values whose run breaks off; needy : an effect and the input without which it says nothing.
    """

    make: Callable[[Path], Model]
    values: Values
    run: Run
    on: tuple[str, ...]
    vary: tuple[str, tuple[float, ...]]
    steady: tuple[str, Values]
    failing: Values | None = None
    needy: tuple[str, str] | None = None
    rivals: int = 0


def friction(make: Callable[[Path], Model]) -> Case:
    return Case(
        make, LEANING, Run(TIMES, {"slip_velocity": SLIP}, ("friction_force", "bristle_deflection")), ("direction_asymmetry",),
        ("F_C", (3.0, 4.0, 5.0, 6.0, 6.5)), ("friction_force", {**SLIDING, "slip_velocity": 0.1}), {**HOT, "reference_temperature": 200.0},
        ("load_dependence", "normal_load"), 2,
    )  # fmt: skip


def axis(make: Callable[[Path], Model]) -> Case:
    run = Run(TIMES, {"slip_velocity": SLIP, "axis_acceleration": np.gradient(SLIP, TIMES)}, ("motor_force", "friction_force"))
    return Case(
        lambda fmu: AxisModel(make(fmu)), {**LEANING, "axis_mass": 3.0}, run, ("direction_asymmetry",),
        ("axis_mass", (1.0, 2.0, 3.0, 4.0, 5.0)), ("motor_force", {**SLIDING, "slip_velocity": 0.1, "axis_acceleration": 2.0}),
        {**HOT, "reference_temperature": 200.0}, ("load_dependence", "normal_load"), 2,
    )  # fmt: skip


CASES = {
    "contact": friction(lambda _: ContactModel(threads=1)),
    "FMU": friction(FmuModel),
    "axis of the contact": axis(lambda _: ContactModel(threads=1)),
    "axis of the FMU": axis(FmuModel),
    "toy": Case(lambda _: Toy(), {"k": 9.0, "bend.c": 0.3}, Run(TIMES, {"x": SLIP}, ("F",)), ("bend",), ("k", (1.0, 9.0, 11.0)),
                ("F", {"k": 9.0, "x": 0.5})),
    "toy with a cycle": Case(lambda _: Turning(), {"k": 9.0, "lean.a": 0.3}, Run(TIMES, {"x": SLIP}, ("F",)), ("lean",),
                             ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5})),
    "toy of two laws": Case(lambda _: TwoLaws(), {"k": 9.0, "bend.c": 0.3}, Run(TIMES, {"x": SLIP}, ("F",)), ("bend",),
                            ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5}), rivals=1),
    "toy that amplifies": Case(lambda _: Loud(), {"k": 9.0, "amplify.gain": 0.2}, Run(TIMES, {"x": SLIP}, ("F",)), ("amplify",),
                               ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5})),
    "toy of a power": Case(lambda _: Powered(), {"k": 9.0, "e": 1.2, "bend.c": 0.3}, Run(TIMES, {"x": SLIP}, ("F",)), ("bend",),
                           ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5})),
    "toy with a damper": Case(lambda _: Damped(), {"k": 9.0, "d": 2.0, "bend.c": 0.3},
                              Run(TIMES, {"x": SLIP, "slip_velocity": SLIP}, ("F",)), ("bend",),
                              ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5, "slip_velocity": 0.1})),
    "toy with a lag": Case(lambda _: Late(), {"k": 9.0, "late.T": 0.01}, Run(TIMES, {"x": SLIP}, ("F",)), ("late",),
                           ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5})),
    "toy of two sensors": Case(lambda _: Twice(), {"k": 9.0, "bend.c": 0.3}, Run(TIMES, {"x": SLIP}, ("F", "G")), ("bend",),
                               ("k", (1.0, 9.0, 11.0)), ("F", {"k": 9.0, "x": 0.5})),
    "two valleys": Case(lambda _: TwoValleys(), {"p": 1.5}, Run(TIMES, {}, ("F",)), (), ("q", (1.0, 5.0, 9.0)), ("F", {"p": 1.0})),
    "force and torque": Case(lambda _: Level(), {"q": 4.0}, Run(TIMES, {}, ("F", "M")), (), ("q", (1.0, 5.0, 9.0)), ("F", {"q": 4.0})),
}  # fmt: skip


@pytest.fixture(params=CASES)
def case(request: pytest.FixtureRequest) -> Case:
    return CASES[request.param]


@pytest.fixture
def model(case: Case, fmi2_fmu: Path) -> Model:
    return case.make(fmi2_fmu)


def test_every_model_is_here(fmi2_fmu: Path) -> None:
    """All classes of the package and of the tests that have simulate_many, or whose base has: but the protocol and the base of toys."""
    bases, models = dict[str, set[str]](), set[str]()
    for folder in (Path(evat.__file__).parent, Path(__file__).parents[1]):
        for path in folder.rglob("*.py"):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef):
                    bases.setdefault(node.name, set()).update(base.id for base in node.bases if isinstance(base, ast.Name))
                    if any(isinstance(own, ast.FunctionDef) and own.name == "simulate_many" for own in node.body):
                        models.add(node.name)
    models.remove("Model")
    while more := {name for name, own in bases.items() if own & models} - models:
        models |= more
    assert models - {"PlainModel"} == {type(case.make(fmi2_fmu)).__name__ for case in CASES.values()}


@pytest.mark.parametrize("name", MEMBERS)
def test_every_method_has_the_protocols_signature(model: Model, name: str) -> None:
    own, wanted = getattr(type(model), name), getattr(Model, name)
    assert str(inspect.signature(own)) == str(inspect.signature(wanted))
    assert get_type_hints(own) == get_type_hints(wanted)


def test_the_tables_are_whole(model: Model) -> None:
    names = [variable.name for variable in model.variables]
    assert len(set(names)) == len(names)
    for effect in model.effects:
        assert {variable.name for variable in effect.variables} <= set(names)
        assert set(effect.rivals) <= {other.name for other in model.effects}


def test_one_and_many_and_again_agree(model: Model, case: Case, fmi2_fmu: Path) -> None:
    """To the last bit: a set alone, among others, a second time, and in another instance of the model."""
    name, column = case.vary
    values = {**case.values, name: np.array(column)}
    many = model.simulate_many(case.run, case.on, values)
    again = case.make(fmi2_fmu).simulate_many(case.run, case.on, values)
    for output in case.run.outputs:
        assert many[output].shape == (len(column), TIMES.size)
        assert np.all(np.isfinite(many[output]))
        assert np.array_equal(many[output], again[output])
        for place, value in enumerate(column):
            alone = model.simulate(case.run, case.on, {**case.values, name: value})
            assert np.array_equal(alone[output], many[output][place])
    assert np.ptp(many[case.run.outputs[0]], axis=0).max() > 0  # the parameter is felt
    single = model.simulate_many(case.run, case.on, dict(case.values))
    assert all(single[output].shape == (1, TIMES.size) for output in case.run.outputs)


def test_inputs_may_be_each_sets_own_or_constant(model: Model, case: Case) -> None:
    for name, column in case.run.inputs.items():
        both = np.stack([column, 0.5 * column])
        rows = model.simulate_many(Run(TIMES, {**case.run.inputs, name: both}, case.run.outputs), case.on, dict(case.values))
        held = {other: given for other, given in case.run.inputs.items() if other != name}
        constant = model.simulate_many(Run(TIMES, held, case.run.outputs), case.on, {**case.values, name: np.array([0.01, 0.02])})
        for output in case.run.outputs:
            for place in (0, 1):
                alone = model.simulate(Run(TIMES, {**case.run.inputs, name: both[place]}, case.run.outputs), case.on, case.values)
                assert np.array_equal(rows[output][place], alone[output])
                still = {**held, name: np.full(TIMES.size, 0.01 * (place + 1))}
                alone = model.simulate(Run(TIMES, still, case.run.outputs), case.on, case.values)
                assert constant[output][place] == pytest.approx(alone[output], rel=1e-9, abs=1e-9)


def test_a_trace_has_what_was_asked_for_with_units_and_its_maker(model: Model, case: Case) -> None:
    known = {variable.name: variable for variable in model.variables}
    trace = model.simulate(case.run, case.on, case.values)
    assert set(case.run.outputs) <= set(trace.columns)
    assert {name: known[name].unit for name in trace.columns} == dict(trace.units)
    assert all(column.shape == TIMES.shape for column in trace.columns.values())
    assert np.array_equal(trace.times, TIMES)
    assert trace.made_by["model"] == model.digest
    every = model.simulate(Run(TIMES, case.run.inputs), case.on, case.values)
    assert set(every.columns) == {name for name, variable in known.items() if variable.causality == "output"}
    for name in case.run.outputs:
        assert np.array_equal(every[name], trace[name])


def test_what_has_settled_is_where_a_long_run_ends(model: Model, case: Case) -> None:
    """Constant conditions over one second: a tenth of a millimetre of bristle or less, so that to 1e-6 nothing is left of the start."""
    output, values = case.steady
    name, column = case.vary
    settled = model.settled((output,), (), {**values, name: np.array(column)})[output]
    assert settled.shape == (len(column),)
    inputs = {variable.name for variable in model.variables if variable.causality == "input"}
    times: FloatArray = np.linspace(0.0, 1.0, 101)
    held = {other: np.full(times.size, float(value)) for other, value in values.items() if other in inputs}
    parameters = {other: value for other, value in values.items() if other not in inputs}
    for place, value in enumerate(column):
        run = model.simulate(Run(times, held, (output,)), (), {**parameters, name: value})
        assert run[output][-1] == pytest.approx(settled[place], rel=1e-6)


def test_a_set_that_fails_is_nan_and_spoils_no_other(model: Model, case: Case) -> None:
    if case.failing is None:
        pytest.skip("there are no values at which this formula fails")
    (name, bad), values = list(case.failing.items())[-1], {**case.values, **case.failing}
    rows = model.simulate_many(case.run, case.on, {**values, name: np.array([400.0, float(bad), 400.0])})
    alone = model.simulate(case.run, case.on, {**values, name: 400.0})
    for output in case.run.outputs:
        assert np.all(np.isnan(rows[output][1]))
        assert np.array_equal(rows[output][0], alone[output])
        assert np.array_equal(rows[output][2], alone[output])
    with pytest.raises(SimulationError):
        model.simulate(case.run, case.on, values)
    output, steady = case.steady
    settled = model.settled((output,), (), {**steady, **case.failing, name: np.array([400.0, float(bad)])})[output]
    assert np.isfinite(settled).tolist() == [True, False]


def test_what_the_tables_do_not_allow_is_refused(model: Model, case: Case) -> None:
    real = next(v for v in model.variables if v.name == case.vary[0])
    wrong: list[tuple[Run, tuple[str, ...], dict[str, float | str]]] = [
        (case.run, (), {**case.values, "no_such_parameter": 1.0}),
        (case.run, ("no_such_effect",), {**case.values}),
        (case.run, (), {**case.values, real.name: 2 * real.max}),
        (case.run, (), {**case.values, real.name: math.nan}),
        (Run(TIMES, case.run.inputs, ("no_such_output",)), (), {**case.values}),
        (Run(TIMES, {**case.run.inputs, "no_such_input": TIMES}, case.run.outputs), (), {**case.values}),
    ]
    wrong += [(Run(TIMES, {**case.run.inputs, name: TIMES[1:]}, case.run.outputs), (), {**case.values}) for name in case.run.inputs]
    for run, on, values in wrong:
        with pytest.raises(ParameterError):
            model.simulate(run, on, values)
        with pytest.raises(ParameterError):
            model.simulate_many(run, on, dict(values))
    with pytest.raises(ParameterError):
        model.simulate_many(Run(TIMES, case.run.inputs), (), dict(case.values))
    other = next(v.name for v in model.variables if v.type == "real" and v.causality == "parameter" and v.name != real.name)
    start = {v.name: v.start for v in model.variables}
    with pytest.raises(ParameterError, match="different numbers of sets"):
        model.simulate_many(case.run, (), {**case.values, real.name: np.full(2, case.vary[1][0]), other: np.full(3, float(start[other]))})


def test_an_effect_is_off_unless_it_is_on(model: Model, case: Case) -> None:
    """Its parameters alone say nothing."""
    if not case.on:
        pytest.skip("this model has no effect")
    own = {variable.name for effect in model.effects for variable in effect.variables}
    without = {name: value for name, value in case.values.items() if name not in own}
    (off, bare, on) = (
        model.simulate(case.run, some, values) for some, values in (((), case.values), ((), without), (case.on, case.values))
    )
    output = case.run.outputs[0]
    assert np.array_equal(off[output], bare[output])
    assert not np.array_equal(off[output], on[output])
    if case.on[0] in {variable.name for variable in model.variables}:  # a switch is a value, too
        switched = model.simulate(case.run, (), {**case.values, case.on[0]: 1.0})
        assert np.array_equal(switched[output], on[output])


def test_what_an_effect_lacks_is_told_and_refused(model: Model, case: Case) -> None:
    assert dict(model.missing_inputs(case.on, case.values, case.run.inputs)) == {}
    if case.needy is None:
        assert not any(effect.needs for effect in model.effects)
        return
    effect, name = case.needy
    assert {key: list(row) for key, row in model.missing_inputs([effect], case.values, case.run.inputs).items()} == {name: [effect]}
    assert dict(model.missing_inputs([effect], case.values, {*case.run.inputs, name})) == {}
    assert dict(model.missing_inputs([effect], {**case.values, name: 10.0}, case.run.inputs)) == {}
    for simulate in (model.simulate, model.simulate_many):
        with pytest.raises(ParameterError, match=name):
            simulate(case.run, [effect], dict(case.values))


def test_rivals_are_other_laws_that_run(model: Model, case: Case) -> None:
    rivals = model.rival_laws(case.values)
    assert len(rivals) == len({rival.name for rival in rivals})
    assert len(rivals) >= case.rivals  # laws that are added come on top
    own = model.simulate(case.run, case.on, case.values)
    output = case.run.outputs[0]
    for rival in rivals:
        assert {variable.name for variable in rival.variables} <= {variable.name for variable in model.variables}
        row = model.simulate_many(case.run, case.on, {**case.values, **rival.values})[output][0]
        assert np.all(np.isfinite(row))
        assert not np.array_equal(row, own[output])
        assert rival.name not in {other.name for other in model.rival_laws({**case.values, **rival.values})}


def test_a_cycle_takes_a_time_or_there_is_none(model: Model, case: Case) -> None:
    duration = model.cycle_time(case.values)
    assert math.isnan(duration) or duration > 0
    if any(variable.name == "vibration_frequency" for variable in model.variables):
        moving = {**case.values, "kinematics": "internal"}
        assert model.cycle_time({**moving, "vibration_frequency": 1e4}) == pytest.approx(1e-4, rel=1e-12)
        assert math.isnan(model.cycle_time({**moving, "amplitude_x": 0.0, "amplitude_y": 0.0}))  # conventional turning
        assert math.isfinite(model.cycle_time({**moving, "amplitude_x": 0.0}))


def test_nothing_that_is_given_is_changed(model: Model, case: Case) -> None:
    values = {**case.values, case.vary[0]: np.array(case.vary[1])}
    before = {name: np.copy(value) for name, value in values.items()}, {name: column.copy() for name, column in case.run.inputs.items()}
    model.simulate_many(case.run, case.on, values)
    assert all(np.array_equal(values[name], value) for name, value in before[0].items())
    assert all(np.array_equal(case.run.inputs[name], column) for name, column in before[1].items())


def test_a_digest_is_a_models_own(fmi2_fmu: Path) -> None:
    one, other = ([case.make(fmi2_fmu).digest for case in CASES.values()] for _ in (1, 2))
    assert one == other
    assert all(one)
    assert len(set(one)) == len(CASES)
    assert ContactModel().digest == kernel.token()


def test_a_choice_by_its_place_is_the_same_in_the_library_and_in_the_fmu(fmi2_fmu: Path) -> None:
    """FMI counts them from 1."""
    run = Run(np.array([0.0, 1e-3]), {"slip_velocity": np.array([0.1, 0.1])}, ("friction_force",))
    values = {"kinematics": "external", "F_C": 3.0, "friction_law": float(kernel.variable("friction_law").choices.index("coulomb"))}
    assert FmuModel(fmi2_fmu).simulate(run, (), values)["friction_force"] == pytest.approx(3.0)
    assert ContactModel().simulate(run, (), values)["friction_force"] == pytest.approx(3.0)


def test_an_fmu_takes_a_text_with_a_unit(fmi2_fmu: Path) -> None:
    run = Run(np.array([0.0, 1e-3]), {}, ("friction_force",))
    values = {"friction_law": "coulomb", "F_C": "0.003 kN", "kinematics": "external", "slip_velocity": "6 m/min"}
    assert FmuModel(fmi2_fmu).simulate(run, (), values)["friction_force"] == pytest.approx(3.0)


def test_an_fmus_digest_is_of_what_runs(fmi2_fmu: Path, tmp_path: Path) -> None:
    """One bit of a binary changes it; how and when the archive was packed does not."""

    def packed(name: str, flip: bool) -> Path:
        with zipfile.ZipFile(fmi2_fmu) as source, zipfile.ZipFile(tmp_path / name, "w", zipfile.ZIP_DEFLATED) as target:
            for entry in reversed(source.namelist()):
                content = bytearray(source.read(entry))
                if flip and entry.startswith("binaries/"):
                    content[-1] ^= 1
                target.writestr(entry, bytes(content))
        return tmp_path / name

    copied = shutil.copy(fmi2_fmu, tmp_path / "copied.fmu")
    assert FmuModel(copied).digest == FmuModel(packed("again.fmu", False)).digest == FmuModel(fmi2_fmu).digest
    assert FmuModel(packed("flipped.fmu", True)).digest != FmuModel(fmi2_fmu).digest


def test_what_is_found_names_its_model() -> None:
    """identify and diagnose stamp the model that they were given, not the component."""
    assert identified(0.0).made_by["model"] == TwoValleys().digest
    assert diagnose(measured(), Toy()).made_by["model"] == Toy().digest
