"""How fast, how frugal and how sure is the search, beside scipy's over a plain Python model and beside CMA-ES?"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Trial
from evat.identification import Settings, identify
from evat.identification.objective import Objective
from evat.identification.polish import polish
from evat.identification.searching.search import Search, search
from evat.identification.space import space
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel
from report import Summary
from scipy.integrate import solve_ivp
from scipy.optimize import differential_evolution

TRUTH: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 300.0, "sigma2": 40.0, "v_s": 1e-2,
}  # fmt: skip
GUESS = {**TRUTH, "F_C": 5.0, "F_S": 20.0, "sigma0": 3e4, "sigma1": 100.0, "sigma2": 10.0, "v_s": 2e-2}
SIX = ("F_C", "F_S", "sigma0", "sigma1", "sigma2", "v_s")
SIGNED = {"sensor_offset.friction_force": (-2.0, 2.0), "direction_asymmetry.a": (-0.5, 0.5)}
EIGHT, ON = (*SIX, *SIGNED), ("sensor_offset", "direction_asymmetry")
POPULATION, GENERATIONS, SEEDS = 64, 100, range(5)


def rig(samples: int, threads: int | None = None) -> tuple[Prediction, FloatArray]:
    """To and fro, 1 % noise."""
    model, times = ContactModel(threads), np.arange(samples) * 2e-3
    slip = 0.05 * np.sin(2 * np.pi * times) + 0.002 * np.sin(2 * np.pi * 7.3 * times)
    run = Run(times, {"slip_velocity": slip}, ("friction_force",))
    force = model.simulate(run, (), TRUTH)["friction_force"]
    noisy = force + 0.01 * np.sqrt(np.mean(force**2)) * np.random.default_rng(1).standard_normal(samples)
    trial = Trial("a.csv", "a", {}, times, {"slip_velocity": slip}, {"friction_force": noisy})
    return Prediction(model, Experiment(Path(), "rig", "", Nominal(GUESS, (), {}), {}, (trial,), None, "")), slip


def objective(samples: int, names: tuple[str, ...] = SIX, on: tuple[str, ...] = (), threads: int | None = None) -> Objective:
    prediction, _ = rig(samples, threads)
    bounds = {name: SIGNED[name] for name in names if name in SIGNED}
    return Objective(prediction, space(prediction.model, GUESS, on, names, bounds), on, "least_squares", {})


def lsoda(values: dict[str, float], times: FloatArray, slip: FloatArray) -> FloatArray:
    """The same contact as one writes it down first: LuGre, right-hand side in Python, LSODA from sample to sample."""

    def rate(t: float, z: FloatArray) -> list[float]:
        v = float(np.interp(t, times, slip))
        g = values["F_C"] + (values["F_S"] - values["F_C"]) * np.exp(-((v / values["v_s"]) ** 2))
        return [v - values["sigma0"] * abs(v) / g * z[0]]

    z = solve_ivp(rate, (times[0], times[-1]), [0.0], "LSODA", times, rtol=1e-6, atol=1e-10, max_step=float(times[1] - times[0])).y[0]
    g = values["F_C"] + (values["F_S"] - values["F_C"]) * np.exp(-((slip / values["v_s"]) ** 2))
    force: FloatArray = values["sigma0"] * z + values["sigma1"] * (slip - values["sigma0"] * np.abs(slip) / g * z) + values["sigma2"] * slip
    return force


def by_cma(aim: Objective, seed: int) -> tuple[FloatArray, int]:
    import cma

    strategy = cma.CMAEvolutionStrategy(
        aim.space.start.tolist(),
        0.25,
        {"bounds": [0.0, 1.0], "seed": seed + 1, "popsize": POPULATION, "maxiter": GENERATIONS, "verbose": -9},
    )
    while not strategy.stop():
        points = strategy.ask()
        strategy.tell(points, aim.costs(np.array(points)).tolist())
    return np.array(strategy.result.xbest), int(strategy.result.evaluations)


def by_scipy(aim: Objective, seed: int) -> tuple[FloatArray, int]:
    count = len(aim.space.free)
    solution = differential_evolution(
        lambda u: float(aim.costs(u[None, :])[0]),
        [(0.0, 1.0)] * count,
        popsize=POPULATION // count,
        maxiter=GENERATIONS,
        rng=seed,
        polish=False,
    )
    return solution.x, int(solution.nfev)


@pytest.mark.benchmark(group="identify")
def test_which_search_reaches_the_optimum(benchmark: Any, summary: Summary) -> None:
    """Five seeds each, six parameters, 1000 samples: how often within 0.1 % of the least cost, before and after the polish, runs, and
    processor seconds.

    What a plain Python model under scipy would take is the time of one run of it times scipy's own evaluations."""
    aim = objective(1000)

    def ours(kind: Search) -> Callable[[int], tuple[list[FloatArray], int]]:
        def run(seed: int) -> tuple[list[FloatArray], int]:
            searched = search(kind, aim.costs, aim.space.start, population=POPULATION, generations=GENERATIONS, seed=seed)
            return [searched.point, *searched.others], searched.history[-1].evaluations

        return run

    searches: dict[str, Callable[[int], tuple[list[FloatArray], int]]] = {
        "GA (pymoo), lanes": ours("ga"),
        "DE (scipy), lanes": ours("de"),
        "CMA-ES (cma), lanes": lambda seed: (lambda point, count: ([point], count))(*by_cma(aim, seed)),
        "DE (scipy), one by one": lambda seed: (lambda point, count: ([point], count))(*by_scipy(aim, seed)),
    }
    results = {}
    for name, run in searches.items():
        rows = []
        for seed in SEEDS if "one by one" not in name else (0,):
            begin = time.process_time()
            points, evaluations = run(seed)
            seconds = time.process_time() - begin
            end = polish(aim, points, whiten=True)
            rows.append(
                (
                    float(aim.costs(points[0][None, :])[0]),
                    aim.cost(end.residual),
                    evaluations,
                    seconds,
                    time.process_time() - begin - seconds,
                )
            )
        results[name] = rows
    least = min(row[1] for rows in results.values() for row in rows)
    for name, rows in results.items():
        reached, polished = (sum(row[place] < 1.001 * least for row in rows) for place in (0, 1))
        seconds, more, runs = (statistics.median(row[place] for row in rows) for place in (3, 4, 2))
        summary.add(
            f"{name}: optimum from {len(rows)} seeds",
            f"{reached} alone, {polished} polished; {runs:.0f} runs, {seconds:.2f} + {more:.2f} s",
        )
    times = np.arange(1000) * 2e-3
    begin = time.process_time()
    lsoda({name: float(TRUTH[name]) for name in SIX}, times, rig(1000)[1])
    once = time.process_time() - begin
    summary.add("scipy DE over LSODA in Python (one run, times its evaluations)", f"{once * results['DE (scipy), one by one'][0][2]:.0f} s")
    benchmark.pedantic(aim.costs, args=(np.random.default_rng(0).random((POPULATION, len(SIX))),), rounds=5)
    for name in ("GA (pymoo), lanes", "DE (scipy), lanes"):
        assert all(row[1] < 1.001 * least for row in results[name])


@pytest.mark.benchmark(group="identify")
def test_a_long_record(benchmark: Any, summary: Summary) -> None:
    """Eight parameters, 100 000 samples, 64 members: the identification, whose search looks at excerpts, and whose polish at all. Over all
    samples some generations of the GA, extrapolated to 100; LSODA on 2000 samples, to 100 000. Processor seconds; two free cores share
    those of the members, which run in two threads, but not those of a Python loop."""
    samples, some = 100_000, 4
    aim = objective(samples, EIGHT, ON)
    begin = time.process_time()
    search("ga", aim.costs, aim.space.start, population=POPULATION, generations=some, seed=1)
    whole = (time.process_time() - begin) / some * GENERATIONS / 2
    times = np.arange(2000) * 2e-3
    _, slip = rig(2000)
    begin = time.process_time()
    lsoda({name: float(TRUTH[name]) for name in SIX}, times, slip)
    plain = (time.process_time() - begin) * samples / 2000 * POPULATION * GENERATIONS
    benchmark.pedantic(aim.costs, args=(np.random.default_rng(0).random((POPULATION, len(EIGHT))),), rounds=1)
    settings = Settings(on=ON, bounds=SIGNED, search="ga", population=POPULATION, generations=GENERATIONS, seed=1, profiles=False)
    begin = time.process_time()
    identify(aim.prediction.experiment, aim.prediction.model, EIGHT, settings)
    identified = (time.process_time() - begin) / 2
    summary.add("8 parameters, 100 000 samples, 64 x 100, search and polish", f"{identified:.1f} s", wanted="<= 10 s on two cores")
    summary.add("    a search over all samples alone", f"{whole:.1f} s")
    summary.add("    the same over LSODA in Python", f"{plain / whole:.0f} times slower", wanted=">= 200")
    assert plain / whole > 200


MEMORY = """
import sys
sys.path.insert(0, sys.argv[1])
from evat.identification import Settings, identify
from peak_memory import peak
from test_identify import EIGHT, ON, SIGNED, rig
prediction, _ = rig(100_000)
identify(prediction.experiment, prediction.model, EIGHT, Settings(on=ON, bounds=SIGNED, search="ga", generations=2, seed=1, profiles=False))
print(peak() / 2**20)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="peak memory is asked of Linux")
def test_memory_of_a_long_record(summary: Summary) -> None:
    here = str(Path(__file__).resolve().parent)
    most = float(subprocess.run([sys.executable, "-c", MEMORY, here], capture_output=True, text=True, check=True).stdout)
    summary.add("peak memory of that search and its polish, Python and all", f"{most:.0f} MB", wanted="< 300 MB")
    assert most < 300
