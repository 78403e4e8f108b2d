"""What does a doStep of one internal step cost, from C, through ctypes and through fmpy, and how much of it is the call?"""

from __future__ import annotations

import ctypes as ct
import time
from collections.abc import Callable
from typing import Any

import pytest
from cases import PERIOD, ellipse
from opened import OpenFmu
from report import Summary
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="doStep")

FROM_C, FROM_PYTHON = 20_000, 2_000  # steps in a round
STEP = PERIOD / 200
SLIP = 0.3  # m/s
ROUNDS = 9


def started(fmu: OpenFmu, kinematics: str) -> Any:
    """An instance at time 0 with the start values."""
    return fmu.started({"kinematics": kinematics} | ({"slip_velocity": SLIP} if kinematics == "external" else {}))


def in_c(loops: ct.CDLL, version: int, instance: Any) -> Callable[[], float]:
    """Seconds of a doStep from C; the clock stays in the host."""
    do_step = ct.cast(getattr(instance.dll, f"fmi{version}DoStep"), ct.c_void_p)
    loop, clock = getattr(loops, f"steps_{version}"), ct.c_double(0.0)

    def ours() -> float:
        seconds = loop(do_step, ct.c_void_p(instance.component), ct.byref(clock), ct.c_double(STEP), ct.c_int64(FROM_C))
        assert seconds > 0, "a doStep failed"
        return float(seconds) / FROM_C

    return ours


def bare(loops: ct.CDLL, moving: bool) -> float:
    """Seconds of one step of the bare law from C."""
    law, z = ellipse("lugre-1995").in_c(), ct.c_double(0.0)
    if not moving:
        law.mean = SLIP
    arguments = (ct.c_int(moving), ct.c_double(0.0), ct.c_double(STEP), ct.c_int64(FROM_C), ct.byref(z))
    return min(float(loops.bare_steps(ct.byref(law), *arguments)) for _ in range(ROUNDS)) / FROM_C


@pytest.mark.parametrize("kinematics", ["external", "internal"])
def test_from_c(benchmark: Any, summary: Summary, loops: ct.CDLL, fmi2: OpenFmu, fmi3: OpenFmu, kinematics: str) -> None:
    """Limit: arithmetic, that of one step of the bare law, timed in the same loop; an empty call is nothing beside it. With internal
    kinematics a step of 1/200 cycle is one internal step but for the four events of a cycle."""
    native = {2: started(fmi2, kinematics), 3: started(fmi3, kinematics)}
    before = fmi2.steps(native[2])
    loop = {version: in_c(loops, version, instance) for version, instance in native.items()}
    seconds = {version: min(loop[version]() for _ in range(ROUNDS)) for version in (2, 3)}
    share = (fmi2.steps(native[2]) - before) / (ROUNDS * FROM_C)
    clock = ct.c_double(0.0)
    empty = (
        min(
            loops.steps_2(ct.cast(loops.nothing_2, ct.c_void_p), None, ct.byref(clock), ct.c_double(STEP), ct.c_int64(100 * FROM_C))
            for _ in range(ROUNDS)
        )
        / FROM_C
        / 100
    )
    least_work = bare(loops, kinematics == "internal")
    benchmark.pedantic(loop[2], rounds=5)
    benchmark.extra_info.update(fmi2=seconds[2], fmi3=seconds[3], empty=empty, bare=least_work, internal_steps=share)
    summary.add(
        f"doStep of one internal step from C, {kinematics} kinematics ({share:.2f} steps each)",
        f"FMI 2: {seconds[2] * 1e6:.3f} us, FMI 3: {seconds[3] * 1e6:.3f} us",
        wanted="<= 0.10 us" if kinematics == "external" else "<= 0.15 us",
        limit=f"bare law {least_work * 1e6:.3f} us, empty call {empty * 1e6:.4f} us",
    )
    for instance in native.values():
        instance.freeInstance()


def test_call_overhead(benchmark: Any, summary: Summary, loops: ct.CDLL, fmi2: OpenFmu, fmi3: OpenFmu) -> None:
    """Limit: the call. An empty function with doStep's arguments is called in the same three ways."""
    fmpy2, fmpy3, raw, empty = (started(fmi, "external") for fmi in (fmi2, fmi3, fmi2, fmi2))
    types: Any = [ct.c_void_p, ct.c_double, ct.c_double, ct.c_int]
    nothing = loops.nothing_2
    nothing.argtypes = types
    # fmpy keeps the functions that it calls by their names; there is no FMU without work to load
    empty._functions["fmi2DoStep"] = nothing
    clocks = dict.fromkeys(("fmpy, FMI 2", "fmpy, FMI 3", "raw ctypes", "empty, fmpy", "empty, raw"), 0.0)

    def through_fmpy(name: str, instance: Any) -> None:
        clock, do_step = clocks[name], instance.doStep
        for _ in range(FROM_PYTHON):
            do_step(clock, STEP)
            clock += STEP
        clocks[name] = clock

    def raw_loop(name: str, function: Any, component: Any) -> None:
        clock = clocks[name]
        for _ in range(FROM_PYTHON):
            function(component, clock, STEP, 1)
            clock += STEP
        clocks[name] = clock

    do_step = ct.CDLL(raw.dll._name).fmi2DoStep  # a handle of our own, whose types nobody else changes
    do_step.argtypes = types
    actions: dict[str, Callable[[], object]] = {
        "fmpy, FMI 2": lambda: through_fmpy("fmpy, FMI 2", fmpy2),
        "fmpy, FMI 3": lambda: through_fmpy("fmpy, FMI 3", fmpy3),
        "raw ctypes": lambda: raw_loop("raw ctypes", do_step, raw.component),
        "empty, fmpy": lambda: through_fmpy("empty, fmpy", empty),
        "empty, raw": lambda: raw_loop("empty, raw", nothing, None),
    }
    microseconds = {name: value / FROM_PYTHON * 1e6 for name, value in least(actions, ROUNDS).items()}
    benchmark.pedantic(actions["fmpy, FMI 2"], rounds=5)
    benchmark.extra_info.update(microseconds)
    for name, base in (("fmpy, FMI 2", "empty, fmpy"), ("raw ctypes", "empty, raw")):
        summary.add(
            f"the same doStep through {name}",
            f"{microseconds[name]:.2f} us",
            limit=f"empty: {microseconds[base]:.2f} us, {microseconds[base] / microseconds[name]:.0%}",
        )
    summary.add("the same doStep through fmpy, FMI 3", f"{microseconds['fmpy, FMI 3']:.2f} us")
    for instance in (fmpy2, fmpy3, raw, empty):
        instance.freeInstance()


def test_exchange(benchmark: Any, summary: Summary, loops: ct.CDLL, fmi2: OpenFmu) -> None:
    """What a master does: set the slip, step, get the force; slip and force change with every step. Limit: the outputs are worked out at
    a point of their own, beside the three of a step."""
    from_c, through_fmpy = started(fmi2, "external"), started(fmi2, "external")
    slip, force = fmi2.reference("slip_velocity"), fmi2.reference("friction_force")
    do_step, setter, getter = (ct.cast(getattr(from_c.dll, f"fmi2{name}"), ct.c_void_p) for name in ("DoStep", "SetReal", "GetReal"))
    at, clock = ct.c_double(0.0), 0.0

    def ours() -> float:
        fixed = (ct.c_uint(slip), ct.c_double(SLIP), ct.c_uint(force), ct.byref(at), ct.c_double(STEP), ct.c_int64(FROM_C))
        seconds = loops.exchanges_2(do_step, setter, getter, ct.c_void_p(from_c.component), *fixed)
        assert seconds > 0, "an exchange failed"
        return float(seconds) / FROM_C

    def python() -> None:
        nonlocal clock
        for n in range(FROM_PYTHON):
            through_fmpy.setReal([slip], [SLIP if n % 2 else 0.9 * SLIP])
            through_fmpy.doStep(clock, STEP)
            through_fmpy.getReal([force])
            clock += STEP

    native = min(ours() for _ in range(ROUNDS))
    slow = least({"python": python}, ROUNDS)["python"] / FROM_PYTHON
    benchmark.pedantic(ours, rounds=5)
    benchmark.extra_info.update(from_c=native, fmpy=slow)
    summary.add("set slip, doStep, get force, from C", f"{native * 1e6:.3f} us", limit=f"through fmpy: {slow * 1e6:.1f} us")
    for instance in (from_c, through_fmpy):
        instance.freeInstance()
