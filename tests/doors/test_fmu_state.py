"""Can a run be taken back, carried over and carried on, to the last bit? And is every other byte string refused?"""

from __future__ import annotations

import ctypes as ct
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from evat.native import kernel
from raw_fmi import ERROR, OK, Door, Instance

SIZE = 1.7e-6  # no divisor of the 50 us vibration: the steps end anywhere in the cycle [s]


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI2", "FMI3"])
def fmu(request: pytest.FixtureRequest) -> Path:
    path: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return path


@pytest.fixture(scope="module")
def door(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Door:
    return Door(fmu, tmp_path_factory.mktemp("door"))


@pytest.fixture
def one(door: Door) -> Iterator[Instance]:
    instance = Instance(door)
    yield instance
    instance.free()


def run(instance: Instance, first: int, last: int) -> list[float]:
    outputs = []
    for n in range(first, last):
        assert instance.step(n * SIZE, SIZE) == OK, instance.lines
        outputs += instance.get("friction_force", "bristle_deflection", "principal_force", "dissipated_energy", "mean_feed_force")
    return outputs


@pytest.mark.parametrize("law", range(1, 7))
def test_a_state_brings_the_run_back_to_the_last_bit(one: Instance, law: int) -> None:
    one.start({"friction_law": law, "thermal_softening": 1})
    run(one, 0, 45)
    state = one.save()
    first = run(one, 45, 120)
    assert one.restore(state) == OK
    assert run(one, 45, 120) == first
    assert one.step(0.0, SIZE) == ERROR  # an error, too, is taken back
    assert one.restore(state) == OK
    assert run(one, 45, 120) == first
    assert one.drop(state) == OK


def test_a_serialised_state_is_a_sealed_contact(one: Instance) -> None:
    """Whatever it has on: the size that the guide shows, and a seal."""
    one.start({"sensor_delay": 1})
    run(one, 0, 12)
    assert 0 < len(one.serialize()) - kernel.Contact().nbytes < 512


def test_a_state_goes_into_another_instance(door: Door, one: Instance) -> None:
    one.start({"F_C": 4.0, "friction_law": 5})
    run(one, 0, 33)
    state, other = one.save(), Instance(door)
    assert other.restore(state) == OK
    assert run(other, 33, 90) == run(one, 33, 90)
    assert other.get("F_C") == [4.0]
    assert other.drop(state) == OK  # whoever is asked to free it
    other.free()


def test_a_state_can_be_saved_again_in_the_same_place(one: Instance) -> None:
    one.start()
    state = one.save()
    run(one, 0, 10)
    assert one.save(state).value == state.value
    first = run(one, 10, 20)
    assert one.restore(state) == OK
    assert run(one, 10, 20) == first
    assert one.drop(state) == OK


def test_initialisation_can_be_taken_back(one: Instance) -> None:
    assert one.set({"kinematics": 2, "friction_law": 1, "slip_velocity": 0.1, "F_C": 5.0}) == OK
    assert one.set_up() == OK
    assert one.get("friction_force") == [5.0]
    state = one.save()
    assert one.set({"F_C": 6.0}) == OK
    assert one.get("friction_force") == [6.0]
    assert one.call("ExitInitializationMode") == OK
    first = run(one, 0, 10)
    assert one.restore(state) == OK
    assert one.get("F_C", "friction_force") == [5.0, 5.0]
    assert one.set({"F_C": 6.0}) == OK
    assert one.call("ExitInitializationMode") == OK
    assert run(one, 0, 10) == first
    assert one.drop(state) == OK


ELSEWHERE = """
import sys
from pathlib import Path
from raw_fmi import Door, Instance
from test_fmu_state import run
fmu, folder, data = map(Path, sys.argv[1:])
one = Instance(Door(fmu, folder))
assert one.deserialize(data.read_bytes()) == 0, one.lines
print(repr(run(one, 50, 100)))
"""


def test_a_serialised_state_is_good_in_another_process(fmu: Path, one: Instance, tmp_path: Path) -> None:
    one.start({"initial_state": 2, "F_S": 11.5})
    run(one, 0, 50)
    data = tmp_path / "state"
    data.write_bytes(one.serialize())
    (tmp_path / "library").mkdir()
    command = [sys.executable, "-c", ELSEWHERE, str(fmu), str(tmp_path / "library"), str(data)]
    elsewhere = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, check=False)
    assert elsewhere.returncode == 0, elsewhere.stderr
    assert elsewhere.stdout.strip() == repr(run(one, 50, 100))


def test_equal_states_have_equal_bytes(door: Door) -> None:
    written = []
    for _ in range(2):
        one = Instance(door)
        one.start({"F_C": 8.0})
        run(one, 0, 20)
        written.append(one.serialize())
        one.free()
    assert written[0] == written[1]


def test_bytes_that_are_cut_short_or_changed_or_foreign_are_refused(one: Instance) -> None:
    one.start()
    run(one, 0, 20)
    good = one.serialize()
    one.lines.clear()
    bad = {
        "empty": b"",
        "cut short": good[: len(good) // 2],
        "one byte less": good[:-1],
        "one byte more": good + b"\0",
        "foreign": bytes(len(good)),
        "text": (b"<html>" * len(good))[: len(good)],
    }
    for place in range(0, len(good), 53):  # in the header, the life cycle and the values
        changed = bytearray(good)
        changed[place] ^= 0x10
        bad[f"byte {place}"] = bytes(changed)
    for what, data in bad.items():
        assert one.deserialize(data) == ERROR, what
        assert one.said(), what
    assert one.deserialize(good) == OK
    assert run(one, 20, 22)


def _sealed(data: bytes, checksum: slice) -> bytes:
    """With the checksum that belongs to it: FNV-1a over all bytes, its own place as 0."""
    plain = bytearray(data)
    plain[checksum] = bytes(8)
    hashed = 14695981039346656037
    for byte in plain:
        hashed = (hashed ^ byte) * 1099511628211 % 2**64
    plain[checksum] = hashed.to_bytes(8, sys.byteorder)
    return bytes(plain)


def test_a_well_sealed_state_with_values_out_of_bounds_is_refused(one: Instance) -> None:
    """Bytes from outside must not choose a law that is not there, or bring in what the host itself could not have set."""
    one.start({"F_C": 3.7654321})
    good, seal = one.serialize(), SEAL
    assert _sealed(good, seal) == good
    at = good.index(ct.string_at(ct.byref(ct.c_double(3.7654321)), 8))
    law = at + 8 * (one.door.reference["friction_law"] - one.door.reference["F_C"])
    for place, value, words in (
        (law, 1e9, "friction_law"),
        (law, -1.0, "friction_law"),
        (law, 0.5, "friction_law"),
        (at, float("nan"), "F_C"),
    ):
        data = bytearray(good)
        data[place : place + 8] = ct.string_at(ct.byref(ct.c_double(value)), 8)
        assert one.deserialize(_sealed(bytes(data), seal)) == ERROR
        assert words in one.said()
        assert one.call("Reset") == OK


# ---- bytes that are forged and sealed anew ----

SEAL, LIFE = slice(64, 72), 72  # of a serialised state: its checksum, and where the life cycle begins
MODEL = LIFE + 56
FFI, KERNEL = kernel.library()


def _in_life(field: str) -> int:
    """Where a field of struct Life lies: three times, then 32-bit numbers."""
    times, flags = (
        ("start", "stop", "last_time"),
        ("mode", "interface", "stale", "set_up", "tolerance_set", "event_pending", "slope_set", "slope_kept"),
    )
    return LIFE + (8 * times.index(field) if field in times else 24 + 4 * flags.index(field))


def _in_model(field: str, number: int = 0) -> int:
    return MODEL + FFI.offsetof("struct Contact", field) + 8 * number


NAN = float("nan")
INTEGRATING, STEPPING, CONFIGURING, ASKING, TERMINATED = 16, 32, 2, 1024, 128
COUNT, FIRST, LENGTH = (FFI.offsetof("struct Ring", field) // 8 for field in ("count", "first", "length"))
FORGED: dict[str, tuple[int, str, float, str]] = {
    "no mode": (_in_life("mode"), "I", 0, "no such state"),
    "two modes": (_in_life("mode"), "I", STEPPING | TERMINATED, "no such state"),
    "a mode far off": (_in_life("mode"), "I", 2**31 + STEPPING, "no such state"),
    "a mode of the other interface": (_in_life("mode"), "I", INTEGRATING, "no such state"),
    "a mode within a step": (_in_life("mode"), "I", ASKING, "no such state"),
    "a mode before the start": (_in_life("mode"), "I", 1, "begun before"),
    "no interface": (_in_life("interface"), "I", 2, "no such state"),
    "a flag": (_in_life("stale"), "I", 7, "neither 0 nor 1"),
    "slopes that are kept and given": (_in_life("slope_kept"), "I", 7, "neither 0 nor 1"),
    "never set up": (_in_life("set_up"), "I", 0, "never set up"),
    "a start time": (_in_life("start"), "d", NAN, "a time is no number"),
    "a stop time": (_in_life("stop"), "d", -1.0, "stop time"),
    "another last time": (_in_life("last_time"), "d", 0.5, "last step"),
    "a time": (_in_model("value"), "d", 1e300, "last step"),
    "a slope": (_in_model("slope", 3), "d", 1.0, "derivative that was not given"),
    "a memory": (_in_model("memory", 5), "d", NAN, "no finite number"),
    "a side": (_in_model("sign", 1), "d", 0.0, "neither +1 nor -1"),
    "a next step": (_in_model("next_step"), "d", 0.0, "not above 0"),
    "a next step that is none": (_in_model("next_step"), "d", NAN, "not above 0"),
    "a breakpoint to come": (_in_model("breakpoint_next"), "d", 1e9, "no such place"),
    "half a breakpoint": (_in_model("breakpoint_next"), "d", 0.5, "no such place"),
    "breakpoints without end": (_in_model("breakpoint_count"), "d", 1e15, "no such place"),
    "a breakpoint at no time": (_in_model("breakpoint", 7), "d", NAN, "no finite number"),
    "a tolerance": (_in_model("largest_difference"), "d", 1e-12, "relative_tolerance"),
    "windows behind": (_in_model("window"), "d", -1e15, "whole number"),
    "a window long ago": (_in_model("window_origin"), "d", -1e6, "lies in the past"),
    "half a window": (_in_model("window"), "d", 0.5, "whole number"),
    "a warning": (_in_model("warnings"), "I", 2**20, "flag"),
    "not begun": (_in_model("started"), "I", 0, "begun"),
    "effects": (_in_model("effects_on"), "I", 2**3, "switched on"),
    "a count of the past": (_in_model("past", COUNT), "d", 1e9, "no such place"),
    "a first of the past": (_in_model("past", FIRST), "d", 0.5, "no such place"),
    "a length of the past": (_in_model("past", LENGTH + 7), "d", -1.0, "shorter than 0"),
    "a force of the past": (_in_model("past_force", 100), "d", float("inf"), "the past"),
    "a surface": (_in_model("surface", COUNT), "d", NAN, "no such place"),
}


@pytest.mark.parametrize("what", FORGED)
def test_a_well_sealed_state_that_no_instance_can_come_to_is_refused(one: Instance, what: str) -> None:
    """It would choose a mode that is not there, run for minutes, or show what is no number."""
    one.start()
    run(one, 0, 40)
    place, form, value, words = FORGED[what]
    good = one.serialize()
    assert _sealed(good, SEAL) == good
    data = bytearray(good)
    data[place : place + struct.calcsize(form)] = struct.pack(f"={form}", int(value) if form == "I" else value)
    begun = time.process_time()
    assert one.deserialize(_sealed(bytes(data), SEAL)) == ERROR
    assert time.process_time() - begun < 0.5
    line = one.said()
    assert "refused" in line
    assert words in line
    assert one.deserialize(good) == OK
    assert run(one, 40, 42)


def test_a_mode_that_only_fmi_3_has_is_refused_by_fmi_2(one: Instance) -> None:
    data = bytearray(one.serialize())
    data[_in_life("mode") : _in_life("mode") + 4] = struct.pack("=I", CONFIGURING)
    assert one.deserialize(_sealed(bytes(data), SEAL)) == (ERROR if one.door.version == 2 else OK)


def test_solvers_and_stepped_instances_with_effects_are_restored_from_bytes(door: Door) -> None:
    """What an instance has come to by itself is never taken for forged: looking back, meeting again, averaging, every law."""
    effects = {"sensor_delay": 1, "regenerative": 1, "regenerative.revolution_time": 1e-4, "holder_compliance": 1, "dwell_strengthening": 1}
    for values in (*({**effects, "friction_law": law} for law in range(1, 7)), {"averaging": 2, "sensor_lowpass": 1}):
        one = Instance(door)
        one.start(values)
        run(one, 0, 70)
        assert one.deserialize(one.serialize()) == OK, one.lines
        run(one, 70, 75)
        one.free()
    solver = Instance(door, model_exchange=True)
    solver.start(effects)
    for time_now in (3e-4, 1e-4, 2e-3):  # a solver may go back, and past the ends of averaging windows
        if door.version == 2 or solver.call("EnterContinuousTimeMode") == OK:
            assert solver.call("SetTime", time_now) == OK
        if door.version == 3:
            assert solver.call("EnterEventMode") == OK
        assert solver.update()[0] == OK
        assert solver.deserialize(solver.serialize()) == OK, solver.lines
    solver.free()


@pytest.mark.parametrize("end", ["terminated", "a step that ended halfway"])
def test_where_a_run_has_ended_is_a_state_as_well(door: Door, end: str) -> None:
    """It goes into a new instance as bytes: values are as they were, and as little can be done from there."""
    one, other = Instance(door), Instance(door)
    one.start({"kinematics": 2, "friction_law": 5, "slip_velocity": 0.5, "F_C": 1e-6, "F_S": 1e-6})
    if end == "terminated":
        assert one.step(0.0, 1e-9) == OK
        assert one.call("Terminate") == OK
    else:
        assert one.step(0.0, 1e-3) != OK  # bonds break every few picoseconds, see test_life_cycle.py
    assert other.deserialize(one.serialize()) == OK, other.lines
    names = ("time", "step_count", "bristle_deflection", "friction_force", "sliding_distance")
    assert other.get(*names) == one.get(*names)
    for each in (one, other):
        assert each.step(each.get("time")[0], 1e-9) == ERROR
        each.free()


def test_an_event_that_waits_at_the_end_of_a_run_is_in_its_state(fmi3_fmu: Path, tmp_path: Path) -> None:
    """The host ends a run where it would have had to handle an event: that state, too, is one that an instance comes to by itself."""
    door = Door(fmi3_fmu, tmp_path)
    one, other = (Instance(door, event_mode=True, early_return=True) for _ in range(2))
    one.start()
    assert one.update()[0] == OK
    assert one.call("EnterStepMode") == OK
    assert one.step3(0.0, 5e-5)[1]
    assert one.call("Terminate") == OK
    assert other.deserialize(one.serialize()) == OK, other.lines
    assert other.get("time", "friction_force") == one.get("time", "friction_force")
    for each in (one, other):
        each.free()


def test_a_state_of_the_other_interface_is_refused(door: Door, one: Instance) -> None:
    solver = Instance(door, model_exchange=True)
    solver.start()
    assert one.deserialize(solver.serialize()) == ERROR
    assert "Model Exchange" in one.said()
    solver.free()


def test_no_state_is_an_error(one: Instance) -> None:
    one.start()
    for name in ("GetFMUState", "SetFMUState"):
        assert one.call(one.state_function(name), None) == ERROR
        assert "NULL" in one.said()
        assert one.call("Reset") == OK
    size = ct.c_size_t()
    assert one.call(one.state_function("SerializedFMUStateSize"), None, ct.byref(size)) == ERROR
    assert "NULL" in one.said()
    assert one.call("Reset") == OK
    none = ct.c_void_p()
    assert one.call(one.state_function("FreeFMUState"), ct.byref(none)) == OK
