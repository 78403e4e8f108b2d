"""How much faster than scipy and CVode is the kernel's integrator at one error in the bristle deflection, 1e-4 of its largest value?

For each solver the loosest tolerance is sought that reaches the error, and not by luck. Against the kernel: it also finds reversals,
entry and exit (scipy is told the last two), thickness, forces and their means; the others integrate z alone.
"""

from __future__ import annotations

import ctypes as ct
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from cases import CYCLES, PERIOD, Case, ellipse, sinusoid
from evat.model import FloatArray
from evat.native.kernel import Contact
from report import Summary
from solvers import CompiledCVode, Solve, loosest, lsoda, odeint_lsoda, radau
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="other integrators")

ERROR = 1e-4
SETS = ("regularised/copper", "regularised/al-6061", "lugre-1995")  # a P|v|/F_C of 6e7, 2e4 and 6e4 1/s
Action = Callable[[], object]


def error_of(solve: Solve, case: Case, tolerance: float) -> float:
    return case.error(solve(case, tolerance, True))


def in_steps(case: Case, loops: ct.CDLL) -> tuple[float, int] | None:
    """The bare law by even steps from C: processor seconds of a cycle at the error, and its steps; None where 1e5 are not enough."""
    (begin, end), law = case.spans[0], case.in_c()
    share = (end - begin) / PERIOD
    true = case.truth[0]
    checks = case.checks(case.spans[0])
    for count in np.unique((checks.size + 1) * 2 ** np.arange(0, 10)):
        h, z, deflections = (end - begin) / int(count), ct.c_double(0.0), []
        every = int(count) // (checks.size + 1)
        for n in range(checks.size):
            loops.bare_steps(ct.byref(law), 1, ct.c_double(begin + n * every * h), ct.c_double(h), ct.c_int64(every), ct.byref(z))
            deflections.append(z.value)
        if np.max(np.abs(np.array(deflections) - true)) <= ERROR * np.max(np.abs(true)):
            repeat = 200_000 // int(count) + 1
            begin_c = ct.c_double(begin)
            seconds = min(
                sum(loops.bare_steps(ct.byref(law), 1, begin_c, ct.c_double(h), ct.c_int64(int(count)), ct.byref(z)) for _ in range(repeat))
                for _ in range(5)
            )
            cycles = share if share > 1 else 1.0
            return seconds / repeat / cycles, int(count / cycles)
    return None


@pytest.mark.parametrize("set_name", SETS)
@pytest.mark.parametrize("motion", [sinusoid, ellipse])
def test_other_integrators(benchmark: Any, summary: Summary, loops: ct.CDLL, motion: Callable[[str], Case], set_name: str) -> None:
    """Limit: arithmetic, on both sides. Ours cannot be less than the exponential midpoint rule on the bare law in C, timed beside it;
    theirs is Python's right-hand side, which CVode with a compiled one shows."""
    case = motion(set_name)
    tolerance = loosest(lambda given: case.error(case.of_kernel(given)), ERROR)
    assert tolerance is not None, "the kernel does not reach the error at 1e-11"
    contact = case.contact(tolerance)
    begin = contact.state()

    def ours() -> None:
        contact.restore(begin)
        contact.advance(CYCLES * PERIOD)

    actions: dict[str, Action] = {"kernel": ours}
    others: dict[str, Solve] = {
        "LSODA": lsoda,
        "LSODA (odeint)": odeint_lsoda,
        "Radau": radau,
        "CVode, compiled rate": CompiledCVode(loops),
    }
    for name, solve in others.items():
        own = loosest(partial(error_of, solve, case), ERROR)
        assert own is not None, f"{name} does not reach the error at 1e-11"
        actions[name] = partial(solve, case, own, dense=False)
    seconds = {name: value / CYCLES for name, value in least(actions, 5).items()}
    benchmark.pedantic(ours, rounds=10, warmup_rounds=1)

    steps = contact.get("step_count") / CYCLES
    ratios = {name: value / seconds["kernel"] for name, value in seconds.items() if name != "kernel"}
    benchmark.extra_info.update(ratios, tolerance=tolerance, steps=steps)
    bare = in_steps(case, loops)
    near = f"bare law in C: {bare[0] * 1e6:.1f} us in {bare[1]} even steps" if bare else "bare law in C: 1e5 even steps are not enough"
    summary.add(f"{case.name}: one cycle at an error of {ERROR:g}", f"{seconds['kernel'] * 1e6:.1f} us, {steps:.0f} steps", limit=near)
    for name, ratio in ratios.items():
        summary.add(f"    {name}: {seconds[name] * 1e6:.0f} us", f"{ratio:.1f} x", wanted=">= 80 x" if name == "LSODA" else "")
    at_default = case.error(case.of_kernel(1e-4))
    summary.add("    error at relative_tolerance 1e-4, the default", f"{at_default:.1e}")


@pytest.mark.parametrize("set_name", SETS)
def test_sampled_slip(benchmark: Any, summary: Summary, set_name: str) -> None:
    """The same sinusoid as a record of external slip. Limit: what is linear between samples is no sinusoid; as many samples are needed as
    this costs, and each is a communication step with all outputs."""
    case = sinusoid(set_name)
    checks = case.checks(case.spans[0])
    for refined in 2 ** np.arange(0, 7):
        times = np.linspace(*case.spans[0], (checks.size + 1) * int(refined) + 1)
        slips = np.array([case.slip(t) for t in times])
        contact = Contact({**case.values, "kinematics": "external", "relative_tolerance": 1e-4})
        contact.start(0.0)
        begin = contact.state()

        def ours() -> FloatArray:
            contact.restore(begin)  # noqa: B023 (used within its round)
            return contact.run(times, {"slip_velocity": slips}, ["bristle_deflection"])  # noqa: B023

        if case.error([ours()[int(refined) : -1 : int(refined), 0]]) <= ERROR:
            break
    else:
        pytest.fail("no record of 12800 samples a cycle is fine enough")
    own = loosest(partial(error_of, lsoda, case), ERROR)
    assert own is not None, "LSODA does not reach the error at 1e-11"
    seconds = {name: value / CYCLES for name, value in least({"ours": ours, "LSODA": partial(lsoda, case, own, dense=False)}, 5).items()}
    benchmark.pedantic(ours, rounds=10, warmup_rounds=1)
    samples = times.size // CYCLES
    benchmark.extra_info.update(ratio=seconds["LSODA"] / seconds["ours"], samples=samples)
    summary.add(
        f"{case.name}, as a record of external slip: {seconds['ours'] * 1e6:.1f} us a cycle",
        f"LSODA takes {seconds['LSODA'] / seconds['ours']:.1f} x",
        limit=f"{samples} samples a cycle, {seconds['ours'] / samples * 1e9:.0f} ns each",
    )
