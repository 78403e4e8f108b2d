"""How much faster is our FMU in Co-Simulation than the same FMU under fmpy and CVode in Model Exchange, at one error in z?"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from cases import PERIOD, Case, ellipse
from evat.model import FloatArray
from opened import OpenFmu, opened
from report import Summary
from solvers import loosest
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="model exchange")

ERROR = 1e-4
CYCLES = 8  # fmpy lets CVode step a fiftieth of the run: with more cycles it would leap over whole cuts
POINTS = 400  # a cycle, where the error is looked at


def simulate(fmu: OpenFmu, instance: Any, kind: str, case: Case, tolerance: float, interval: float) -> Any:
    """fmpy.simulate_fmu on an instance that is there already: neither unpacking nor loading counts."""
    instance.reset()
    values = case.values | ({"relative_tolerance": tolerance} if kind == "CoSimulation" else {})
    return fmpy.simulate_fmu(
        fmu.folder,
        model_description=fmu.description,
        fmu_instance=instance,
        fmi_type=kind,
        validate=False,
        start_time=case.start,
        stop_time=case.start + CYCLES * PERIOD,
        start_values=values,
        relative_tolerance=tolerance,
        output_interval=interval,
        output=["bristle_deflection", "mean_friction_force", "mean_principal_force"],
        record_events=False,
    )


def times_in_cuts(case: Case) -> FloatArray:
    """Where z is compared; not at the very ends, where it depends on the last digit of entry and exit."""
    grid = case.start + np.arange(1, CYCLES * POINTS) * PERIOD / POINTS
    entry, leave = case.spans[0]
    into = np.mod(grid - entry, PERIOD)
    return grid[(into > 1e-3 * PERIOD) & (into < leave - entry - 1e-3 * PERIOD)]


def tight(case: Case, times: FloatArray) -> FloatArray:
    """z by the kernel at 1e-10."""
    contact = case.contact(1e-10)
    deflections = []
    for t in times:
        contact.advance(t - contact.time)
        deflections.append(contact.get("bristle_deflection"))
    return np.array(deflections)


@pytest.mark.parametrize("set_name", ["regularised/copper", "regularised/al-6061", "lugre-1995"])
def test_co_simulation_against_cvode(benchmark: Any, summary: Summary, fmi2: OpenFmu, set_name: str) -> None:
    """Limit: call overhead. CVode comes back to Python for every right-hand side, fmpy makes some four calls for each. In one doStep the
    co-simulation makes one call for all; what remains of it through fmpy is its start. The outputs of both: one row a cycle."""
    case, me, cs = ellipse(set_name), fmi2.instance("ModelExchange"), fmi2.instance()
    times = times_in_cuts(case)
    true = tight(case, times)

    def exchange_error(tolerance: float) -> float:
        trace = simulate(fmi2, me, "ModelExchange", case, tolerance, PERIOD / POINTS)
        z = np.interp(times, trace["time"], trace["bristle_deflection"])
        return float(np.max(np.abs(z - true)) / np.max(np.abs(true)))

    of_cvode = loosest(exchange_error, ERROR, a_decade=2)
    own = loosest(lambda given: case.error(case.of_kernel(given)), ERROR)
    assert of_cvode is not None, "CVode does not reach the error"
    assert own is not None, "the kernel does not reach the error"
    begun, clock = fmi2.started({**case.values, "relative_tolerance": own}, case.start), case.start

    def ours() -> None:
        nonlocal clock
        begun.doStep(clock, CYCLES * PERIOD)
        clock += CYCLES * PERIOD

    actions: dict[str, Callable[[], object]] = {
        "CVode": lambda: simulate(fmi2, me, "ModelExchange", case, of_cvode, PERIOD),
        "fmpy": lambda: simulate(fmi2, cs, "CoSimulation", case, own, PERIOD),
        "doStep": ours,
    }
    seconds = {name: value / CYCLES for name, value in least(actions, 7).items()}
    benchmark.pedantic(ours, rounds=10, warmup_rounds=1)
    ratios = {name: seconds["CVode"] / seconds[name] for name in ("fmpy", "doStep")}
    benchmark.extra_info.update(ratios, tolerance=own, tolerance_of_cvode=of_cvode)
    summary.add(f"{case.name}: fmpy + CVode on the Model Exchange FMU, one cycle", f"{seconds['CVode'] * 1e6:.0f} us")
    summary.add(
        f"    the same FMU in Co-Simulation through fmpy: {seconds['fmpy'] * 1e6:.0f} us", f"{ratios['fmpy']:.0f} x", wanted=">= 20 x"
    )
    in_one_step = f"{seconds['doStep'] * 1e6:.0f} us"
    summary.add(f"    in one doStep: {in_one_step}", f"{ratios['doStep']:.0f} x", limit="the integration alone, no start and no outputs")
    for instance in (me, cs, begun):
        instance.freeInstance()


LOOSE = 0.3  # a relative tolerance at which CVode does no more than it has to
ASKED = {"getDerivatives": "rates", "getEventIndicators": "indicators", "enterEventMode": "events"}


def counted(instance: Any, run: Callable[[], Any]) -> tuple[Any, dict[str, float]]:
    """What a run gives, and how often a cycle it asks for what."""
    asked: Counter[str] = Counter()

    def counting(name: str) -> Callable[..., Any]:
        function = getattr(instance, name)

        def count(*arguments: Any) -> Any:
            asked[name] += 1
            return function(*arguments)

        return count

    for name in ASKED:
        setattr(instance, name, counting(name))
    trace = run()
    for name in ASKED:
        delattr(instance, name)
    return trace, {word: asked[name] / CYCLES for name, word in ASKED.items()}


def test_what_restarts_alone_cost(benchmark: Any, summary: Summary, fmus: dict[str, Path], tmp_path: Path) -> None:
    """Limit: an FMU of 5 states and a tolerance that asks for nothing. A solver starts anew at each of five events a cycle, and each start
    takes steps of its own, whose calls are Python's."""
    cut = opened(fmus["evat_cut-fmi2"], tmp_path)
    me, cs, case = cut.instance("ModelExchange"), cut.instance(), ellipse("lugre-1995")

    def exchange() -> Any:
        return simulate(cut, me, "ModelExchange", case, LOOSE, PERIOD)

    trace, asked = counted(me, exchange)
    true = simulate(cut, cs, "CoSimulation", case, 1e-8, PERIOD)
    off = abs(trace["mean_principal_force"][-1] / true["mean_principal_force"][-1] - 1)
    seconds = least({"CVode": exchange, "fmpy": lambda: simulate(cut, cs, "CoSimulation", case, 1e-4, PERIOD)}, 7)
    benchmark.pedantic(exchange, rounds=5)
    ratio = seconds["CVode"] / seconds["fmpy"]
    benchmark.extra_info.update(asked, ratio=ratio, off=off)
    summary.add(
        f"EvatCut, {case.name}: fmpy + CVode at a tolerance of {LOOSE}, the mean force {off:.1%} off, beside CS through fmpy",
        f"{ratio:.0f} x",
        limit=", ".join(f"{count:.0f} {word}" for word, count in asked.items()) + " a cycle",
    )
    assert asked["rates"] > 10 * asked["events"]  # so few are asked for at no tolerance
    for instance in (me, cs):
        instance.freeInstance()
