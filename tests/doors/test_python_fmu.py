"""Is the Python FMU a good FMU: a clean description, the answers of reference.py, exact states, and a host that survives bad calls?"""

from __future__ import annotations

import ctypes as ct
import math
import shutil
import subprocess
import sys
import threading
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import evidence
import fmpy
import pytest
from evat.fmu.description.model_description import FIRST_REFERENCE
from evat.fmu.fmu_facts import BuildError
from evat.fmu.part_model import fmu_facts_of
from evat.fmu.python_fmu import build_python_fmu
from evat.model import FIRST_ITEM
from evat.models import reference as reference_model
from evat.models.reference import ReferenceContact
from evat.native import kernel
from fmpy import fmi2
from fmpy.validation import validate_fmu
from lxml import etree

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
SIZE = 1.7e-6  # no divisor of the 50 us vibration: the steps end anywhere in the cycle [s]
WATCHED = ("friction_force", "principal_force", "bristle_deflection", "mean_feed_force", "dissipated_energy", "shear_angle")
FUNCTIONS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "choice": "Integer"}


@pytest.fixture(scope="module")
def fmu(python_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy: it is unpacked beside itself."""
    return Path(shutil.copy(python_fmu, tmp_path_factory.mktemp("python")))


@pytest.fixture(scope="module")
def description(fmu: Path) -> Any:
    with zipfile.ZipFile(fmu) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))


class Instance:
    """One instance, called as a C host does: statuses come back, log lines gather in `lines`."""

    def __init__(self, fmu: Path) -> None:
        self.lines: list[tuple[int, str]] = []
        folder = fmu.with_suffix("")
        if not folder.exists():
            fmpy.extract(str(fmu), unzipdir=str(folder))
        self.slave = fmi2.FMU2Slave(guid="", unzipDirectory=str(folder), modelIdentifier="EvatContactPython", instanceName="one")
        self._logger = fmi2.fmi2CallbackLoggerTYPE(lambda _e, _n, status, _c, text: self.lines.append((status, text.decode())))
        callbacks = fmi2.fmi2CallbackFunctions(
            self._logger, fmi2.fmi2CallbackAllocateMemoryTYPE(fmi2.calloc), fmi2.fmi2CallbackFreeMemoryTYPE(fmi2.free)
        )
        self.slave.instantiate(callbacks=callbacks, loggingOn=True)

    def call(self, name: str, *arguments: Any) -> int:
        return int(getattr(self.slave.dll, f"fmi2{name}")(self.slave.component, *arguments))

    def set_as(self, kind: str, reference: int, value: float) -> int:
        item = {"Real": ct.c_double}.get(kind, ct.c_int)
        return self.call(f"Set{kind}", (ct.c_uint * 1)(reference), 1, (item * 1)(value))

    def set(self, **values: float) -> int:
        """By name, with _ for a dot; a choice by its place in FMI."""
        by_fmi_name = {name.replace(".", "_"): variable for name, variable in kernel.by_name().items()}
        return max(
            self.set_as(FUNCTIONS[by_fmi_name[name].type], by_fmi_name[name].index + FIRST_REFERENCE, value)
            for name, value in values.items()
        )

    def get(self, *names: str) -> list[float]:
        values = []
        for name in names:
            variable = kernel.variable(name)
            kind = FUNCTIONS[variable.type]
            value = (ct.c_double if kind == "Real" else ct.c_int)()
            assert self.call(f"Get{kind}", (ct.c_uint * 1)(variable.index + FIRST_REFERENCE), 1, ct.byref(value)) == OK
            values.append(value.value)
        return values

    def start(self, stop: float | None = None, **values: float) -> Instance:
        if values:
            assert self.set(**values) == OK
        assert self.call("SetupExperiment", 0, 0.0, 0.0, int(stop is not None), stop or 0.0) == OK
        assert self.call("EnterInitializationMode") == OK
        assert self.call("ExitInitializationMode") == OK
        return self

    def step(self, n: int, size: float = SIZE) -> int:
        return self.call("DoStep", n * SIZE, size, 1)

    def run(self, first: int, last: int) -> list[float]:
        answers = []
        for n in range(first, last):
            assert self.step(n) == OK, self.lines
            answers += self.get(*WATCHED)
        return answers

    def said(self) -> str:
        """The one line that was logged since the last time, at status Error."""
        assert [status for status, _ in self.lines] == [ERROR], self.lines
        text = self.lines.pop()[1]
        assert "\n" not in text
        return text

    def save(self) -> ct.c_void_p:
        state = ct.c_void_p()
        assert self.call("GetFMUstate", ct.byref(state)) == OK
        return state

    def serialized(self) -> bytes:
        state, size = self.save(), ct.c_size_t()
        assert self.call("SerializedFMUstateSize", state, ct.byref(size)) == OK
        data = ct.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, data, size) == OK
        assert self.call("FreeFMUstate", ct.byref(state)) == OK
        return data.raw

    def deserialized(self, data: bytes) -> int:
        state = ct.c_void_p()
        status = self.call("DeSerializeFMUstate", ct.create_string_buffer(data, len(data)), len(data), ct.byref(state))
        return max(status, self.call("SetFMUstate", state), self.call("FreeFMUstate", ct.byref(state)))


@pytest.fixture
def one(fmu: Path) -> Iterator[Instance]:
    instance = Instance(fmu)
    yield instance
    instance.slave.freeInstance()


def place(name: str, word: str) -> int:
    return kernel.variable(name).choices.index(word) + FIRST_ITEM


# ---- the archive -------------------------------------------------------------------------------------------------------------------------


def test_fmpy_finds_nothing_to_complain_about(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []


def test_description_states_what_pythonfmu_leaves_out(description: Any) -> None:
    shown = description.findall("ModelVariables/ScalarVariable")
    assert [element.get("name") for element in shown] == [variable.name for variable in kernel.variables()]
    for element, variable in zip(shown, kernel.variables(), strict=True):
        if variable.type == "real":
            assert element.find("Real").get("unit") == variable.unit
            assert element.find("Real").get("displayUnit") == variable.display_unit
    outputs = [element.get("name") for element in shown if element.get("causality") == "output"]
    assert sorted(outputs) == sorted(fmu_facts_of().connected)
    assert len(description.findall("ModelStructure/Outputs/Unknown[@dependencies]")) == len(outputs)
    assert len(description.findall("ModelStructure/InitialUnknowns/Unknown[@dependencies]")) >= len(outputs)
    assert description.get("generationDateAndTime").endswith("Z")
    slave = description.find("CoSimulation")
    assert slave.get("needsExecutionTool") == "false"
    assert slave.get("canGetAndSetFMUstate") == slave.get("canSerializeFMUstate") == "true"
    assert description.find("ModelExchange") is None


def test_same_input_gives_the_same_bytes_and_another_law_another_guid(fmu: Path, description: Any, tmp_path: Path) -> None:
    again = build_python_fmu(tmp_path / "again.fmu")
    assert again.read_bytes() == fmu.read_bytes()
    changed = tmp_path / "reference.py"
    changed.write_text(Path(reference_model.__file__).read_text() + "\n# my law\n")
    other = fmpy.read_model_description(str(build_python_fmu(tmp_path / "other.fmu", changed)), validate=False)
    assert other.guid != description.get("guid")


def test_laws_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(BuildError, match=r"nowhere\.py: the laws cannot be read"):
        build_python_fmu(tmp_path / "x.fmu", tmp_path / "nowhere.py")


def test_it_runs_with_the_standard_library_alone(fmu: Path, tmp_path: Path) -> None:
    """No site-packages, no evat, no numpy; and libpython is named as what a C host has to bring."""
    fmpy.extract(str(fmu), unzipdir=str(tmp_path))
    resources = str(tmp_path / "resources")
    code = f"""if True:
        import sys
        sys.path.insert(0, {resources!r})
        from evat_contact_python import EvatContactPython
        slave = EvatContactPython(instance_name="one", resources={resources!r})
        slave.setup_experiment(0.0)
        slave.enter_initialization_mode()
        slave.exit_initialization_mode()
        assert slave.do_step(0.0, 1e-6)
        reference = {kernel.variable("friction_force").index + FIRST_REFERENCE}
        print(slave.get_real([reference])[0], "evat" in sys.modules or "numpy" in sys.modules)
    """
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    force, foreign = done.stdout.split()
    assert float(force) > 1
    assert foreign == "False"
    assert "libpython" in (tmp_path / "documentation" / "externalDependencies.txt").read_text()


# ---- the answers -------------------------------------------------------------------------------------------------------------------------


def complete(values: Mapping[str, Any]) -> dict[str, Any]:
    starts = {
        v.name: v.choices[int(v.start)] if v.choices else v.start for v in kernel.variables() if v.causality in ("input", "parameter")
    }
    return {**starts, **dict.fromkeys(kernel.states(), 0.0), **values}


def test_answers_are_those_of_reference_to_the_last_bit_and_of_the_kernel_to_1e_9(one: Instance) -> None:
    values = {"friction_law": "lugre", "shear_angle_principle": "minimum_energy", "rake_angle": 0.1, "relative_tolerance": 1e-12}
    words = {name: place(name, word) for name, word in values.items() if isinstance(word, str)}
    one.start(**{**values, **words}, thermal_damping=1)
    python, c = ReferenceContact(complete({**values, "thermal_damping": True})), kernel.Contact(values, ["thermal_damping"])
    python.start(0.0)
    c.start()
    assert one.get(*WATCHED) == [python.get(name) for name in WATCHED]
    answers = one.run(0, 40)
    rows = []
    for n in range(40):
        for contact in (python, c):
            contact.advance(SIZE)
            contact.time = n * SIZE + SIZE
        assert answers[6 * n : 6 * n + 6] == [python.get(name) for name in WATCHED]
        rows.append([c.get(name) for name in WATCHED])
    off = 0.0
    for k in range(len(WATCHED)):
        largest = max(abs(row[k]) for row in rows)
        assert answers[k::6] == pytest.approx([row[k] for row in rows], abs=1e-9 * largest)
        off = max(off, *(abs(answer - row[k]) / largest for answer, row in zip(answers[k::6], rows, strict=True)))
    evidence.hold("python_twin", max(100 * off, 1e-7))  # what is less is rounding


def test_inputs_and_tunable_parameters_change_between_steps(one: Instance) -> None:
    one.start(kinematics=place("kinematics", "external"), friction_law=place("friction_law", "coulomb"), slip_velocity=0.2)
    assert one.get("friction_force", "mean_contact_ratio") == [9.0, 1.0]
    assert one.step(0) == OK
    one.set(slip_velocity=-0.2, F_C=4.0)
    assert one.get("friction_force") == [-4.0]
    one.set(uncut_thickness=0.0)
    assert one.get("friction_force", "in_contact") == [0.0, 0.0]
    assert one.step(1) == OK
    assert one.get("time") == [2 * SIZE]


def test_tolerance_of_the_experiment_is_taken_unless_one_was_set(one: Instance, fmu: Path) -> None:
    for values, expected in (({}, 1e-7), ({"relative_tolerance": 1e-5}, 1e-5)):
        instance = Instance(fmu)
        if values:
            instance.set(**values)
        assert instance.call("SetupExperiment", 1, 1e-7, 0.0, 0, 0.0) == OK
        assert instance.call("EnterInitializationMode") == OK
        assert instance.get("relative_tolerance") == [expected]
        instance.slave.freeInstance()


def test_two_fmus_with_different_laws_live_in_one_process(fmu: Path, tmp_path: Path) -> None:
    """pythonfmu imports the script once per process; the laws of the second FMU are its own all the same."""
    changed = tmp_path / "reference.py"
    text = Path(reference_model.__file__).read_text()
    assert text.count('return x.direction * float(x.p["F_C"]) if x.v != 0 else 0.0') == 1
    changed.write_text(text.replace('return x.direction * float(x.p["F_C"])', 'return 2 * x.direction * float(x.p["F_C"])', 1))
    doubled = build_python_fmu(tmp_path / "doubled.fmu", changed)
    forces = []
    for path in (fmu, doubled, fmu):
        instance = Instance(path).start(friction_law=place("friction_law", "coulomb"))
        forces += instance.get("friction_force")
        instance.slave.freeInstance()
    assert forces == [9.0, 18.0, 9.0]


def test_a_law_that_is_no_python_is_refused_with_its_line(fmu: Path, tmp_path: Path) -> None:
    broken = tmp_path / "reference.py"
    broken.write_text("def force(:\n")
    instance = Instance(build_python_fmu(tmp_path / "broken.fmu", broken))
    assert instance.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0) == OK
    assert instance.call("EnterInitializationMode") == OK
    assert "reference.py: SyntaxError" in instance.said()
    assert instance.call("ExitInitializationMode") == OK
    assert "reference.py could not be loaded" in instance.said()
    assert instance.step(0) == DISCARD
    instance.slave.freeInstance()


def test_two_instances_in_two_threads_do_not_know_each_other(fmu: Path) -> None:
    answers: dict[float, list[float]] = {}

    def run(friction: float) -> None:
        instance = Instance(fmu).start(F_C=friction)
        answers[friction] = instance.run(0, 12)
        instance.slave.freeInstance()

    run(5.0)
    alone = answers.pop(5.0)
    threads = [threading.Thread(target=run, args=(friction,)) for friction in (5.0, 6.0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers[5.0] == alone != answers[6.0]


# ---- states ------------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["coulomb", "lugre", "dahl", "karnopp", "reset_integrator"])
def test_a_state_brings_the_run_back_to_the_last_bit(one: Instance, law: str) -> None:
    one.start(friction_law=place("friction_law", law), thermal_softening=1, release_time=1e-5)
    one.run(0, 20)
    state, data = one.save(), one.serialized()
    first = one.run(20, 55)
    assert one.call("SetFMUstate", state) == OK
    assert one.run(20, 55) == first
    assert one.deserialized(data) == OK
    assert one.serialized() == data
    assert one.run(20, 55) == first
    assert one.call("FreeFMUstate", ct.byref(state)) == OK


def test_a_state_goes_into_another_instance(one: Instance, fmu: Path) -> None:
    one.start(F_C=4.0, initial_state=place("initial_state", "periodic"))
    one.run(0, 9)
    data, other = one.serialized(), Instance(fmu)
    assert other.deserialized(data) == OK
    assert other.get("F_C") == [4.0]
    assert other.run(9, 30) == one.run(9, 30)
    other.slave.freeInstance()


def test_foreign_bytes_are_refused_and_reset_helps(one: Instance) -> None:
    one.start()
    one.run(0, 3)
    data = one.serialized()
    for bad in (b"", data[:-1], data[:64], b"x" + data[1:], data.replace(b'"F_C": 9', b'"F_C": 8')):
        assert one.deserialized(bad) == OK  # this door has no other answer: the log line and the refused step are the error
        assert "no state of this FMU" in one.said()
        assert one.step(3) == DISCARD
    assert one.deserialized(data) == OK
    one.run(3, 5)
    assert one.call("Reset") == OK
    one.start()
    one.run(0, 3)
    assert one.serialized() == data


# ---- bad calls ---------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "bad", "good", "text"),
    [
        ("slip_velocity", math.nan, 0.1, "slip_velocity: nan is no finite number in m/s"),
        ("cutting_speed", math.inf, 0.1, "cutting_speed: inf is no finite number"),
        ("cutting_speed", -1.0, 0.1, "cutting_speed: -1 m/s lies outside 0 to 100 m/s"),
        ("F_C", 0.0, 9.0, "F_C: 0 N lies outside 1e-06"),
    ],
)
def test_bad_value_is_refused_until_a_good_one_comes(one: Instance, name: str, bad: float, good: float, text: str) -> None:
    one.start()
    before = one.get(name)
    assert one.set(**{name: bad}) == OK  # the wrapper knows only OK and Fatal here
    assert text in one.said()
    assert one.get(name) == before
    assert one.step(0) == DISCARD
    assert one.set(**{name: good}) == OK
    assert one.step(0) == OK
    assert one.lines == []


@pytest.mark.parametrize("law", [0, len(kernel.laws()) + 1, -1])
def test_unknown_friction_law_is_refused(one: Instance, law: int) -> None:
    one.set(friction_law=law)
    assert f"friction_law: {law} is none of 1 coulomb, 2 lugre, " in one.said()
    one.start()
    assert math.isnan(one.get("friction_force")[0])
    assert one.step(0) == DISCARD
    assert one.call("Reset") == OK
    assert one.start().step(0) == OK


def test_law_that_is_not_written_is_refused_at_the_start(one: Instance) -> None:
    one.start(friction_law=place("friction_law", "bristle"))
    assert "friction_law = bristle: not written here" in one.said()
    assert math.isnan(one.get("friction_force")[0])
    assert one.step(0) == DISCARD
    assert one.call("Reset") == OK
    assert one.start().step(0) == OK


def test_fixed_parameters_outputs_and_wrong_references_are_refused(one: Instance) -> None:
    one.start()
    for name, value, text in (
        ("vibration_frequency", 1e4, "vibration_frequency: it cannot be set now"),
        ("bristle_deflection", 1e-6, "bristle_deflection: it cannot be set now"),
        ("friction_force", 1.0, "friction_force: it is calculated, not set"),
    ):
        one.set(**{name: value})
        assert text in one.said()
    references = [kernel.variable(name).index + FIRST_REFERENCE for name in ("F_C", "friction_law")]
    for kind, reference in (("Real", 999), ("Real", 0), ("Integer", references[0]), ("Boolean", references[1])):
        one.set_as(kind, reference, 1)
        assert f"there is no {kind} variable with this value reference" in one.said()
        value = (ct.c_double if kind == "Real" else ct.c_int)()
        assert one.call(f"Get{kind}", (ct.c_uint * 1)(reference), 1, ct.byref(value)) == OK
        assert one.lines.pop()[0] == ERROR
    assert one.step(0) == DISCARD


@pytest.mark.parametrize(
    ("time", "size", "text"),
    [
        (3 * SIZE, 0.0, "its length is 0 s"),
        (3 * SIZE, -SIZE, "a positive finite number is needed"),
        (3 * SIZE, math.nan, "a positive finite number is needed"),
        (2 * SIZE, SIZE, "it begins at"),
        (math.nan, SIZE, "it begins at"),
        (3 * SIZE, 1.0, "after the stop time"),
    ],
)
def test_bad_step_is_refused_and_changes_nothing(one: Instance, time: float, size: float, text: str) -> None:
    one.start(stop=1e-3)
    one.run(0, 3)
    state = one.save()
    expected = one.run(3, 6)
    assert one.call("SetFMUstate", state) == OK
    assert one.call("DoStep", time, size, 1) == DISCARD
    assert text in one.said()
    assert one.run(3, 6) == expected


def test_step_before_initialisation_is_refused(one: Instance) -> None:
    assert one.step(0) == DISCARD
    assert "steps come after the initialization mode" in one.said()
    assert one.start().step(0) == OK


def test_a_clamped_value_is_said_once(one: Instance) -> None:
    one.start(thermal_softening=1, thermal_softening_k_Q=1e4)
    one.run(0, 6)
    assert [status for status, _ in one.lines] == [WARNING]
    assert "clamped_count" in one.lines[0][1]
    assert one.get("clamped_count")[0] > 0
