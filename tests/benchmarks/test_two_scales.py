"""What does averaging save over a cut of 2 s with a changing cutting speed, and is following every cycle faster than real time?"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from cases import PERIOD
from evat.model import FloatArray
from evat.native.kernel import Contact
from evat.studies.two_scales.study import changing_speed, compare
from opened import OpenFmu
from report import Summary
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="two time scales")

CUT = 2.0  # s, 40 000 cycles


def clock(step: float) -> FloatArray:
    return np.arange(round(CUT / step) + 1, dtype=np.float64) * step


@pytest.mark.parametrize("step", [1e-4, 1e-3, 5e-3])
def test_a_cut_of_two_seconds(benchmark: Any, summary: Summary, step: float) -> None:
    """Limit: the cycles of a step, of which one is run; below it lie the outputs, the error and the start of each step."""
    times = clock(step)
    cut = compare(times, changing_speed(times), rounds=3)
    benchmark.pedantic(lambda: compare(times[:11], changing_speed(times[:11])), rounds=1)
    error = 100 * cut.relative_error
    summary.add(
        f"2 s of cut at 20 kHz, steps of {1e3 * step:g} ms: averaged",
        f"{1e3 * cut.seconds['cycle']:.0f} ms, {cut.cheaper:.1f} times cheaper; mean force to {error:.3f} %",
        wanted=">= 10 times, < 1 %" if step == 1e-3 else "",
        limit=f"{step * 20e3:.0f} times",
    )
    summary.add("    resolved, one core", f"{cut.seconds['resolved']:.2f} s", wanted="< 2 s")
    assert cut.seconds["resolved"] < CUT
    if step == 1e-3:
        assert cut.cheaper >= 10
        assert cut.relative_error < 0.01


@pytest.mark.parametrize("effect", ["", "maxwell_slip", "sticking_limit"])
def test_an_averaged_step_at_a_constant_speed(benchmark: Any, summary: Summary, effect: str) -> None:
    """Limit: the cycle that it runs, as one of many that follow one another."""

    def begun(averaging: str) -> Contact:
        contact = Contact({"averaging": averaging, "initial_state": "periodic"}, (effect,) if effect else ())
        contact.start()
        return contact

    averaged, resolved = begun("cycle"), begun("resolved")

    def hundred_steps() -> None:
        for _ in range(100):
            averaged.advance(1e-3)

    def hundred_cycles() -> None:
        for _ in range(25):
            resolved.advance(4 * PERIOD)  # so few that none is skipped

    seconds = least({"averaged": hundred_steps, "resolved": hundred_cycles}, rounds=5)
    benchmark.pedantic(hundred_steps, rounds=1)
    summary.add(
        f"an averaged step at a constant speed, {effect or 'no effect'}",
        f"{1e4 * seconds['averaged']:.1f} us",
        limit=f"a cycle of many: {1e4 * seconds['resolved']:.1f} us",
    )


def test_two_seconds_through_an_fmu(benchmark: Any, summary: Summary, fmi2: OpenFmu) -> None:
    """Limit: what fmpy takes for a call, which is soon more than the cycle. The speed is held for 1 ms; in doSteps of four cycles each
    cycle is run, and in those of 1 ms three of 20."""
    reference, times = fmi2.reference("cutting_speed"), clock(1e-3)
    speed = changing_speed(times)

    def run(averaging: str, parts: int) -> None:
        instance = fmi2.started({"averaging": averaging})
        for begin, value in zip(times[:-1], speed[:-1], strict=True):
            instance.setReal([reference], [value])
            for part in range(parts):
                instance.doStep(begin + part * 1e-3 / parts, 1e-3 / parts)
        instance.freeInstance()

    seconds = least({"resolved": lambda: run("resolved", 5), "long": lambda: run("resolved", 1), "cycle": lambda: run("cycle", 1)}, 2)
    benchmark.pedantic(lambda: run("cycle", 1), rounds=1)
    ratio = seconds["resolved"] / seconds["cycle"]
    summary.add(
        "    through fmpy, 2000 doSteps of 1 ms: averaged",
        f"{1e3 * seconds['cycle']:.0f} ms, {ratio:.1f} times cheaper",
        wanted=">= 10 times",
    )
    summary.add("    the same, resolved", f"{1e3 * seconds['long']:.0f} ms", limit="3 of 20 cycles")
    assert ratio >= 10
