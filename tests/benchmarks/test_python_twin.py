"""How much cheaper is an internal step of the native FMU than one of its twin in plain Python?"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest
from cases import PERIOD, ellipse
from evat.models import reference
from evat.native import kernel
from evat.native.kernel import Contact
from opened import OpenFmu
from report import Summary
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="Python twin")

CYCLES = 2


def in_words(values: dict[str, float | str]) -> dict[str, Any]:
    """All inputs, parameters and states as reference.ReferenceContact takes them."""
    known = {v.name: v.start for v in kernel.variables() if v.causality in ("parameter", "input") or v.name in kernel.states()}
    return kernel.by_choice({**known, **kernel.check_values(values)})


@pytest.mark.parametrize("set_name", ["regularised/al-6061", "lugre-1995"])
def test_python_twin(benchmark: Any, summary: Summary, fmi2: OpenFmu, twin: OpenFmu, set_name: str) -> None:
    """Limit: the interpreter. A Python step is a Radau step of five stages with two halves for its error, so it is also worth more: the
    cost of a cycle is given beside it. Same set, same relative_tolerance of 1e-4, steps of two cycles, so that no call counts."""
    values = ellipse(set_name).values
    native, python = fmi2.started(values), twin.started(values)
    own, plain = Contact(values), reference.ReferenceContact(in_words(values))
    own.start(0.0)
    plain.start(0.0)
    clocks = dict.fromkeys(("native FMU", "Python FMU"), 0.0)

    def stepped(name: str, instance: Any) -> None:
        instance.doStep(clocks[name], CYCLES * PERIOD)
        clocks[name] += CYCLES * PERIOD

    def ours() -> None:
        stepped("native FMU", native)

    actions: dict[str, Callable[[], object]] = {
        "native FMU": ours,
        "kernel": lambda: own.advance(CYCLES * PERIOD),
        "Python FMU": lambda: stepped("Python FMU", python),
        "reference.py": lambda: plain.advance(CYCLES * PERIOD),
    }
    counts: dict[str, Callable[[], float]] = {
        "native FMU": lambda: fmi2.steps(native),
        "kernel": lambda: own.get("step_count"),
        "Python FMU": lambda: twin.steps(python),
        "reference.py": lambda: float(plain.get("step_count")),
    }
    steps = {}
    for name, action in actions.items():  # the first cycles begin with shorter steps
        action()
        before = counts[name]()
        action()
        steps[name] = counts[name]() - before
    seconds = least(actions, 3)
    each = {name: seconds[name] / steps[name] for name in actions}
    benchmark.pedantic(ours, rounds=10)
    ratios = {"Python FMU": each["Python FMU"] / each["native FMU"], "reference.py": each["reference.py"] / each["kernel"]}
    benchmark.extra_info.update(ratios)
    for other, base in (("Python FMU", "native FMU"), ("reference.py", "kernel")):
        summary.add(
            f"{set_name}: an internal step of the {base} {each[base] * 1e6:.2f} us, of {other} {each[other] * 1e6:.0f} us",
            f"{ratios[other]:.0f} x",
            wanted=">= 100 x",
            limit=f"a cycle: {seconds[other] / seconds[base]:.0f} x",
        )
    native.freeInstance()
    python.freeInstance()
