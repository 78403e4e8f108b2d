"""What does a communication step of a system cost, and what a plain loop over fmpy takes for the same?"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import pytest
from evat.systems.couple import NO_INPUTS, Coupled, Plan, plan
from evat.systems.model import System
from evat.systems.ssp.read import read
from python_master import PythonMaster
from report import Summary

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="systems")

COMPILED, PLAIN, ROUNDS = 10_000, 500, 5  # steps of a run


def steps_of(system: System, count: int) -> Plan:
    assert system.step is not None
    return plan(system, stop=count * system.step, every=50)


def compiled(system: System) -> float:
    """Processor seconds of a step; loading is not timed."""
    with Coupled(system) as coupled:
        begin = time.process_time()
        coupled.run(steps_of(system, COMPILED))
        return (time.process_time() - begin) / COMPILED


def plain(system: System, folder: Path) -> float:
    master = PythonMaster(system, NO_INPUTS, folder, steps_of(system, PLAIN))
    begin = time.process_time()
    master.run()
    took = (time.process_time() - begin) / PLAIN
    master.close()
    return took


@pytest.mark.parametrize("name", ["stick_slip", "hunting", "feed_drive", "circular_path", "emps", "evat_turning"])
def test_a_step_of_a_system(benchmark: Any, summary: Summary, systems: dict[str, Path], tmp_path: Path, name: str) -> None:
    """tests/systems/test_compiled_steps.py holds both to the same bits."""
    system, seconds = read(systems[name], tmp_path / "read"), {"compiled": math.inf, "plain": math.inf}
    for n in range(ROUNDS):
        for kind, took in (("compiled", compiled(system)), ("plain", plain(system, tmp_path / str(n)))):
            seconds[kind] = min(seconds[kind], took)
    benchmark.pedantic(lambda: compiled(system), rounds=1)
    ratio = seconds["plain"] / seconds["compiled"]
    benchmark.extra_info.update(seconds)
    summary.add(
        f"{name}: a step of {len(system.components)} components",
        f"{seconds['compiled'] * 1e6:.1f} us, {ratio:.0f} times cheaper than in Python",
        wanted="<= 2 us" if name == "stick_slip" else "",
        limit=f"loop over fmpy: {seconds['plain'] * 1e6:.0f} us",
    )
    assert ratio >= 10
