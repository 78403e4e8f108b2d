"""How much faster are many sets in one call than one at a time, what do threads add, and what does each effect cost?"""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np
import pytest
from evat.model import FloatArray, Run
from evat.native import kernel
from evat.native.batch import run_many
from evat.native.compile import MANY_LANES
from evat.native.kernel import Contact
from report import Summary
from timing import least

COUNT, SAMPLES = 64, 2000
TIMES: FloatArray = np.arange(SAMPLES, dtype=np.float64) * 2.5e-7
RIG = Run(TIMES, {"slip_velocity": 0.3 * np.cos(2 * np.pi * 20e3 * TIMES)}, ("friction_force",))
LEVELS: FloatArray = np.linspace(5.0, 12.0, COUNT)
VALUES: dict[str, float | str | FloatArray] = {"kinematics": "external", "F_C": LEVELS}


def one_at_a_time() -> None:
    for level in LEVELS:
        contact = Contact({"kinematics": "external", "F_C": float(level), "slip_velocity": 0.3})
        contact.start()
        contact.run(RIG.times, RIG.inputs, RIG.outputs)


@pytest.mark.benchmark(timer=time.process_time, group="batch")
def test_batch_against_one_at_a_time(benchmark: Any, summary: Summary) -> None:
    """Limit: fields of a point go through memory between stages, and some twenty quotients a step, which wide vectors take no faster than
    narrow ones; a loop of even steps for this one law, written by hand, would take half. One contact alone has been made faster, too."""
    seconds = least({"alone": one_at_a_time, "batch": lambda: run_many(RIG, VALUES, threads=1)}, rounds=5)
    benchmark.pedantic(run_many, args=(RIG, VALUES), kwargs={"threads": 1}, rounds=3)
    ratio, each = seconds["alone"] / seconds["batch"], seconds["batch"] / (COUNT * SAMPLES)
    benchmark.extra_info.update(ratio=ratio, seconds_each=each)
    summary.add(
        f"{MANY_LANES} lanes against one set at a time, slip given",
        f"{ratio:.1f} times faster",
        wanted=">= 3.2 with vectors of 4, 7 of 8",
        limit=f"{each * 1e9:.0f} ns a sample and set",
    )


@pytest.mark.benchmark(timer=time.perf_counter, group="batch")
def test_two_threads_against_one(benchmark: Any, summary: Summary) -> None:
    """Wall time; on a machine that is busy otherwise the second thread waits."""
    if (os.cpu_count() or 1) < 2:
        pytest.skip("one processor only")
    walls: dict[int, float] = {1: np.inf, 2: np.inf}
    many: dict[str, float | str | FloatArray] = {**VALUES, "F_C": np.tile(LEVELS, 8)}
    for _ in range(4):
        for threads in walls:
            begin = time.perf_counter()
            run_many(RIG, many, give="sums", threads=threads)
            walls[threads] = min(walls[threads], time.perf_counter() - begin)
    benchmark.pedantic(run_many, args=(RIG, many), kwargs={"threads": 2, "give": "sums"}, rounds=1)
    summary.add("two threads against one", f"{walls[1] / walls[2]:.2f} times faster", wanted=">= 1.8", limit="2")


@pytest.mark.benchmark(timer=time.process_time, group="batch")
@pytest.mark.parametrize("kinematics", ["external", "internal"])
def test_what_an_effect_costs(benchmark: Any, summary: Summary, kinematics: str) -> None:
    """Against the base law on the same motion, one contact. Effects that change the motion or the forces take other internal steps."""
    values: dict[str, float | str] = (
        {"kinematics": kinematics, "slip_velocity": 0.3} if kinematics == "external" else {"cutting_speed": 0.2}
    )
    inputs = RIG.inputs if kinematics == "external" else {}

    def with_effects(*on: str) -> Any:
        def action() -> None:
            contact = Contact(values, on)
            contact.start()
            contact.run(TIMES, inputs, RIG.outputs)

        return action

    fastest = least({"": with_effects(), **{e.name: with_effects(e.name) for e in kernel.effects()}}, rounds=3)
    benchmark.pedantic(with_effects(), rounds=1)
    costs = {name: seconds / fastest[""] - 1 for name, seconds in fastest.items() if name}
    dear = sorted((name for name in costs if costs[name] > 0.3), key=lambda name: -costs[name])
    benchmark.extra_info.update(costs)
    summary.add(
        f"cost of an effect, {kinematics}",
        f"median {np.median(list(costs.values())):.0%}; above 30 %: {', '.join(f'{name} {costs[name]:.0%}' for name in dear) or 'none'}",
        wanted="median 10 %, none above 60 %",
        limit="states that feed back are solved by iteration",
    )
