"""Does an instance live as the standard says, whatever its host does to it? Instantiation, states, logging, memory, threads."""

from __future__ import annotations

import ctypes as ct
import gc
import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from evat.native import kernel
from raw_fmi import DISCARD, ERROR, OK, WARNING, Door, Instance

PERIOD = 5e-5  # of the 20 kHz vibration that the contact starts with [s]


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI2", "FMI3"])
def door(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Door:
    fmu: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return Door(fmu, tmp_path_factory.mktemp("door"))


@pytest.fixture
def one(door: Door) -> Iterator[Instance]:
    instance = Instance(door)
    yield instance
    instance.free()


def run(instance: Instance, first: int, last: int, size: float = 1e-6) -> list[float]:
    """Steps number first to last, and what they lead to."""
    outputs = []
    for n in range(first, last):
        assert instance.step(n * size, size) == OK, instance.lines
        outputs += instance.get("friction_force", "bristle_deflection", "dissipated_energy", "mean_feed_force")
    return outputs


def test_every_function_of_the_standard_is_there_and_nothing_else(door: Door) -> None:
    assert len(door.functions) == {2: 44, 3: 75}[door.version]
    for name in door.functions:
        assert getattr(door.library, name)
    for name in ("kernel_advance", "model_step", "component_new", "report"):
        assert not hasattr(door.library, name)
    assert door.text("GetVersion") == f"{door.version}.0"


def test_no_component_is_an_error_of_every_function_and_no_crash(door: Door) -> None:
    without = {"GetVersion", "GetTypesPlatform", "FreeInstance"}
    for name in door.functions:
        short = name[len("fmi2") :]
        if short in without or short.startswith("Instantiate"):
            continue
        assert getattr(door.library, name)(*[None] * 11) == ERROR, name
    getattr(door.library, f"fmi{door.version}FreeInstance")(None)


@pytest.mark.parametrize("logging", [True, False])
def test_a_foreign_token_is_refused_in_one_line_that_names_both(door: Door, logging: bool) -> None:
    foreign = b"{00000000-%s-0000-0000-000000000000}#1#"  # what a printf or an FMI logger would stumble over
    refused = Instance(door, token=foreign, logging=logging)
    assert refused.pointer is None
    line = refused.said()
    assert door.token in line
    assert "{00000000-?s-0000-0000-000000000000}?1?" in line


def test_an_instance_needs_a_token_and_a_name(door: Door) -> None:
    for wrong in (Instance(door, token=None), Instance(door, name=None), Instance(door, name=b" \t")):
        assert wrong.pointer is None
        assert wrong.said()
    if door.version == 2:
        wrong = Instance(door, kind=7)
        assert wrong.pointer is None
        assert "type 7" in wrong.said()
        make = door.library.fmi2Instantiate
        assert make(b"one", 1, door.token.encode(), None, None, 0, 1) is None  # no callbacks at all
    else:
        instance = Instance(door)
        make = door.library.fmi3InstantiateScheduledExecution
        make.restype = ct.c_void_p
        assert make(b"one", door.token.encode(), None, False, True, None, instance._logger, None, None, None) is None
        assert "Scheduled Execution" in instance.said()
        instance.free()


def test_a_call_in_the_wrong_state_is_one_line_and_reset_mends_it(one: Instance) -> None:
    before_start = [("ExitInitializationMode",), ("Terminate",), ("EnterEventMode",), ("EnterContinuousTimeMode",)]
    for name, *arguments in before_start:
        assert one.call(name, *arguments) == ERROR
        line = one.said()
        assert name in line
        assert "Instantiated" in line
        assert one.call("Reset") == OK
    assert one.step(0.0, 1e-6) == ERROR
    assert "Instantiated; allowed in: Step Mode" in one.said()
    assert one.step(0.0, 1e-6) == ERROR  # the error stays until it is mended
    assert "reset" in one.said()
    assert one.call("Reset") == OK
    one.start()
    assert one.set_up() == ERROR
    assert one.call("Reset") == OK
    one.lines.clear()
    one.start()
    assert run(one, 0, 3)
    assert one.call("Terminate") == OK
    one.get("friction_force")  # the final values can be had
    assert one.step(3e-6, 1e-6) == ERROR
    assert "Terminated" in one.said()


def test_reset_is_a_fresh_instance(one: Instance) -> None:
    one.start({"F_C": 7.0, "kinematics": 1, "initial_state": 2})
    first = run(one, 0, 60)
    assert one.call("Reset") == OK
    assert one.get("F_C", "kinematics", "initial_state") == [9.0, 1.0, 1.0]
    assert one.get("step_count", "dissipated_energy") == [0.0, 0.0]
    one.start({"F_C": 7.0, "kinematics": 1, "initial_state": 2})
    assert run(one, 0, 60) == first


@pytest.mark.parametrize(
    ("time", "size", "words"),
    [
        (0.0, 0.0, "above 0"),
        (0.0, -1e-6, "above 0"),
        (0.0, float("nan"), "above 0"),
        (0.0, float("inf"), "above 0"),
        (float("nan"), 1e-6, "communication point"),
        (-1e-6, 1e-6, "FMU state"),  # back in time
        (1e-6, 1e-6, "communication point"),  # a gap
        (1e-11, 1e-6, "communication point"),  # 1e-5 of the step: no rounding error
        (0.0, 1.1e-3, "stop time"),
        (0.0, 1.5, "end at 1.5 s, after the stop time"),
    ],
)
def test_a_step_that_cannot_be(one: Instance, time: float, size: float, words: str) -> None:
    one.start(stop=1e-3)
    assert one.step(time, size) == ERROR
    assert words in one.said()
    assert one.get("step_count", "time") == [0.0, 0.0]
    assert one.call("Reset") == OK
    one.start(stop=1e-3)
    assert one.step(0.0, 1e-3) == OK


def test_a_step_too_small_to_move_time_is_an_error(one: Instance) -> None:
    one.start(start=1.0)
    assert one.step(1.0, 1e-17) == ERROR
    assert "too small" in one.said()


def test_rounding_of_the_clock_never_adds_up(one: Instance) -> None:
    """1e5 steps of 0.1 us from 10 s on: added one by one they would be off by 1e-11 s, a hundred times what may be."""
    one.start({"kinematics": 2, "slip_velocity": 0.1}, start=10.0)
    steps, size = 100_000, 1e-7
    step = one.door.function("DoStep")
    tail: list[object] = [1] if one.door.version == 2 else [True, *(ct.byref(ct.c_double()) for _ in range(4))]
    for n in range(steps):
        status = step(ct.c_void_p(one.pointer), ct.c_double(10.0 + n * size), ct.c_double(size), *tail)
        assert status == OK, (n, one.lines)
    (time,) = one.get("time")
    assert abs(time - (10.0 + steps * size)) <= 4e-15  # two units in the last place of 10 s
    assert one.get("step_count")[0] >= steps


def test_start_and_stop_times_and_tolerance_are_checked(one: Instance) -> None:
    for facts in ({"start": float("nan")}, {"start": 1.0, "stop": 0.5}, {"stop": float("nan")}, {"tolerance": -1.0}, {"tolerance": 0.5}):
        assert one.set_up(**facts) == ERROR
        assert one.lines
        one.lines.clear()
        assert one.call("Reset") == OK
    assert one.set_up(tolerance=1e-7) == OK
    assert one.get("relative_tolerance") == [1e-7]
    assert one.call("Reset") == OK
    assert one.set({"relative_tolerance": 1e-3}) == OK
    assert one.set_up(tolerance=1e-7) == OK
    assert one.get("relative_tolerance") == [1e-3]  # what is set as a parameter is the more particular wish


def test_fmi2_wants_its_start_time(fmi2_fmu: Path, tmp_path: Path) -> None:
    one = Instance(Door(fmi2_fmu, tmp_path))
    assert one.call("EnterInitializationMode") == ERROR
    assert "fmi2SetupExperiment" in one.said()
    one.free()


def test_log_lines_come_as_the_host_has_asked(door: Door) -> None:
    quiet = Instance(door, logging=False)
    assert quiet.step(0.0, 1.0) == ERROR
    assert len(quiet.lines) == 1  # an error is always told: what would a host with loggingOn = false else know of it?
    quiet.lines.clear()
    off, names = ct.c_int(0), (ct.c_char_p * 2)(b"logStatusError", b"logAll")
    assert quiet.call("Reset") == OK
    assert quiet.call("SetDebugLogging", off, ct.c_size_t(0), None) == OK
    assert quiet.step(0.0, 1.0) == ERROR
    assert quiet.lines == []
    assert quiet.call("Reset") == OK
    assert quiet.call("SetDebugLogging", ct.c_int(1), ct.c_size_t(1), names) == OK
    assert quiet.step(0.0, 1.0) == ERROR
    assert [(status, category) for status, category, _ in quiet.lines] == [(ERROR, "logStatusError")]
    quiet.lines.clear()
    assert quiet.call("SetDebugLogging", ct.c_int(1), ct.c_size_t(1), (ct.c_char_p * 1)(b"logNonsense")) == ERROR
    assert "logStatusDiscard" in quiet.said()  # the line lists what is allowed
    quiet.free()


def test_a_warning_is_told_once_in_a_run(one: Instance) -> None:
    """The slip velocity is given, but the contact moves by its own ellipse."""
    warned = {2: OK, 3: WARNING}[one.door.version]  # FMI 3 wants the status to say it, too; hosts of FMI 2 take that for a failure
    for _ in range(2):
        assert max(one.set({"slip_velocity": 0.1}), one.set_up()) == OK
        assert one.call("ExitInitializationMode") == warned
        assert "kinematics" in one.said()
        run(one, 0, 5)
        assert one.set({"slip_velocity": 0.2}) == OK
        assert one.step(5e-6, 1e-6) == OK
        assert one.lines == []
        assert one.call("Reset") == OK


def test_the_host_sees_all_memory_and_gets_all_of_it_back(fmi2_fmu: Path, tmp_path: Path) -> None:
    """FMI 2 lends its memory: an instance and its states take less than 18.5 kB beside what each keeps of the past, and a thousand of them
    leave nothing behind."""
    door, held = Door(fmi2_fmu, tmp_path), dict[int, ct.Array[ct.c_char]]()
    peak = 0

    def allocate(count: int, size: int) -> int:
        nonlocal peak
        block = ct.create_string_buffer(count * size + 16)
        address = ct.addressof(block) + 15 & ~15
        held[address] = block
        peak = max(peak, sum(map(len, held.values())))
        return address

    def release(address: int) -> None:
        del held[address]

    for _ in range(1000):
        one = Instance(door, allocator=(allocate, release))
        one.start()
        assert one.step(0.0, 1e-6) == OK
        other = one.save()
        assert one.drop(other) == OK
        one.free()
        assert held == {}
    ffi, _ = kernel.library()
    fields = dict(ffi.typeof("struct Contact").fields)
    past = sum(ffi.sizeof(field.type) for name, field in fields.items() if name.startswith(("past", "surface", "slip_time", "slip_given")))
    copies = 3  # of a contact: the instance's own, what it shows while it is initialized, and the state that is kept
    assert 2_000 < peak - copies * past < 18_500


def test_an_instance_without_memory_is_refused(fmi2_fmu: Path, tmp_path: Path) -> None:
    blocks: list[object] = []

    def allocate(count: int, size: int) -> int:
        if blocks:
            return 0  # the second request fails
        blocks.append(ct.create_string_buffer(count * size + 16))
        return ct.addressof(blocks[0]) + 15 & ~15  # type: ignore[arg-type]

    one = Instance(Door(fmi2_fmu, tmp_path), allocator=(allocate, lambda _address: blocks.clear()))
    assert one.pointer is None
    assert "memory" in one.said()
    assert blocks == []


@pytest.mark.parametrize("lent", ["allocateMemory", "freeMemory"])
def test_a_host_that_lends_half_of_its_memory_lends_none(fmi2_fmu: Path, tmp_path: Path, lent: str) -> None:
    """What one of the two has given only the other could take back: then the instance lives in memory of its own."""
    asked: list[str] = []

    def allocate(_count: int, _size: int) -> int:
        asked.append("allocateMemory")
        return 0

    half: tuple[Any, Any] = (allocate, None) if lent == "allocateMemory" else (None, lambda _address: asked.append("freeMemory"))
    one = Instance(Door(fmi2_fmu, tmp_path), allocator=half)
    assert one.pointer is not None
    one.start()
    assert one.step(0.0, 1e-6) == OK
    assert one.drop(one.save()) == OK
    one.free()
    assert asked == []


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads the memory of the process from /proc")
@pytest.mark.skipif("asan" in os.environ.get("LD_PRELOAD", ""), reason="AddressSanitizer keeps freed memory back")
def test_a_thousand_instances_leave_nothing_behind(door: Door) -> None:
    def resident() -> int:
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

    def life() -> None:
        one = Instance(door)
        one.start()
        one.drop(one.save())
        one.free()

    for _ in range(200):
        life()
    before = resident()
    for _ in range(1000):
        life()
    assert abs(resident() - before) < 1_000_000  # 1000 leaked instances would be 6 MB


def test_two_threads_do_not_hear_each_other(door: Door) -> None:
    """Each of four instances gives the same bits beside the others as alone."""
    settings = [{"F_C": 5.0 + n, "initial_state": 2.0, "friction_law": 1.0 + n} for n in range(4)]

    def life(values: dict[str, float]) -> list[float]:
        one = Instance(door)
        outputs = run(one.start(values), 0, 400)
        one.free()
        return outputs

    alone = [life(values) for values in settings]
    together: list[list[float]] = [[] for _ in settings]
    threads = [threading.Thread(target=lambda n=n: together[n].extend(life(settings[n]))) for n in range(4)]  # type: ignore[misc]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone
    assert alone[0] != alone[1]


def test_a_step_that_ends_halfway_can_be_taken_back_and_made_shorter(one: Instance) -> None:
    """Bristles that break at a micronewton break every few picoseconds at 0.5 m/s: too often for a step of 1 ms."""
    one.start({"kinematics": 2, "friction_law": 5, "slip_velocity": 0.5, "F_C": 1e-6, "F_S": 1e-6})
    state = one.save()
    if one.door.version == 2:
        reached = ct.c_double()
        assert one.step(0.0, 1e-3) == DISCARD
        assert one.call("GetRealStatus", 2, ct.byref(reached)) == OK
        last = reached.value
    else:
        status, _, _, last = one.step3(0.0, 1e-3)
        assert status == ERROR  # FMI 3 knows no half step: discard would mean that nothing has happened
    assert "internal steps" in one.said()
    assert 0 < last < 1e-3
    assert one.get("time") == [last]
    assert one.step(last, 1e-9) == ERROR
    one.lines.clear()
    assert one.restore(state) == OK
    assert one.step(0.0, 1e-9) == OK
    assert one.drop(state) == OK


def test_after_a_discarded_step_values_are_those_of_the_time_that_was_reached(fmi2_fmu: Path, tmp_path: Path) -> None:
    """In FMI 2 a step that ends halfway leaves an instance that may be read: F = sigma0 z holds there, not at the step's start."""
    one = Instance(Door(fmi2_fmu, tmp_path))
    one.start({"kinematics": 2, "friction_law": 5, "slip_velocity": 0.5, "F_C": 1e-6, "F_S": 1e-6})
    assert one.step(0.0, 1e-3) == DISCARD
    z, force, stiffness = one.get("bristle_deflection", "friction_force", "sigma0")
    assert z != 0
    assert force == pytest.approx(stiffness * z, rel=1e-12)
    one.free()


def test_parameters_that_contradict_each_other_stop_the_run_before_it_starts(one: Instance) -> None:
    proxy = {"proxy_source": 4, "contact_temperature": 450.0, "ambient_temperature": 400.0, "reference_temperature": 300.0}
    assert one.set(proxy) == OK
    assert one.set_up() == OK
    assert one.call("ExitInitializationMode") == ERROR
    assert "ambient_temperature" in one.said()
    assert one.call("Reset") == OK
    one.start({**proxy, "reference_temperature": 500.0})
    assert one.set({"reference_temperature": 300.0}) == OK
    assert one.step(0.0, 1e-6) == ERROR
    assert "ambient_temperature" in one.said()
    assert one.get("time", "step_count") == [0.0, 0.0]


def test_status_functions_of_fmi2(fmi2_fmu: Path, tmp_path: Path) -> None:
    one = Instance(Door(fmi2_fmu, tmp_path)).start()
    assert one.step(0.0, 1e-6) == OK
    time, flag, number = ct.c_double(), ct.c_int(5), ct.c_int()
    assert one.call("GetRealStatus", 2, ct.byref(time)) == OK
    assert time.value == 1e-6
    assert one.call("GetBooleanStatus", 3, ct.byref(flag)) == OK
    assert flag.value == 0
    for name in ("GetStatus", "GetIntegerStatus", "GetStringStatus", "GetRealStatus", "GetBooleanStatus"):
        assert one.call(name, 0, ct.byref(number)) == DISCARD
        assert one.said()
    assert one.step(1e-6, 1e-6) == OK  # a discarded question does no harm
    assert one.call("CancelStep") == ERROR
    assert "in progress" in one.said()
    one.free()
