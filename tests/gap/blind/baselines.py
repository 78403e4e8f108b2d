"""How far do simple methods get on the same cases? Three of them, each writing a diagnosis as the format asks.

    python tests/gap/blind/baselines.py OUT RESULTS [--case 001 ...]

RESULTS/residual_bins: t-tests of the recalibrated residual in bins of phase, time or signal, and the library's best on held-out
conditions; RESULTS/bic: forward selection by Schwarz's criterion; RESULTS/held_out: the least held-out error over nominal, recalibrated
and each effect.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from baseline_fits import Bench, Fit
from evat.experiment.read import read_experiment
from evat.models.contact import ContactModel
from radau import Array
from scipy import stats

METHODS = ("residual_bins", "bic", "held_out")
BINS, FALSE_DISCOVERIES = 24, 0.05
COLOUR = 3.0  # by which the mean of neighbours scatters more than white noise would have it: a guess, as a simple method makes it
SECOND = 8  # effects that the forward selection looks at, the best on the training conditions first


def diagnose_all(folder: Path, model: ContactModel) -> dict[str, dict[str, Any]]:
    """All three answers to one experiment; they share the fits."""
    began = time.perf_counter()
    bench = Bench(read_experiment(folder, model), model)
    rng = np.random.default_rng(0)
    train = ~bench.test
    nominal = bench.nominal_fit()
    base, learned = bench.base(bench.all), bench.base(train)
    fitted = {name: fit for name in bench.effects if (fit := bench.with_effect(name, learned, train, rng)) is not None}
    shared = time.perf_counter() - began
    answers = {}
    for method, answer in (("residual_bins", _residual_bins), ("bic", _bic), ("held_out", _held_out)):
        began = time.perf_counter()
        answers[method] = answer(bench, nominal, base, learned, fitted, rng)
        answers[method]["made_by"] = {"version": "baseline", "model": method, "data": "", "seconds": shared + time.perf_counter() - began}
    return answers


def _residual_bins(bench: Bench, nominal: Fit, base: Fit, learned: Fit, fitted: dict[str, Fit], rng: np.random.Generator) -> dict[str, Any]:
    regions = significant_bins(bench, base)
    if not regions:
        return _answer(bench, "no_gap" if not significant_bins(bench, nominal) else "mistuned", [], base, base)
    test = bench.test
    errors = {name: fit.squares(test) for name, fit in fitted.items()}
    best = min(errors, key=lambda name: (errors[name], name), default=None)
    if best is None or errors[best] > 0.9 * learned.squares(test):
        return _answer(bench, "unknown", [], base, base, regions=regions)
    weights: dict[tuple[str, ...], float] = {
        (name,): float(np.exp(-len(errors) * max(np.log(errors[name] / errors[best]), 0.0))) for name in errors
    }
    return _answer(bench, "effect", [best], base, fitted[best], weights=weights, regions=regions)


def _bic(bench: Bench, nominal: Fit, base: Fit, learned: Fit, fitted: dict[str, Fit], rng: np.random.Generator) -> dict[str, Any]:
    n = bench.all.size

    def criterion(fit: Fit) -> float:
        return fit.squares(bench.all) + fit.told * float(np.log(n))

    scores: dict[tuple[str, ...], float] = {(): min(criterion(base), criterion(nominal))}
    best, at = base, scores[()]
    for _ in range(2):
        tried = {}
        for name in sorted(fitted, key=lambda name: (criterion(fitted[name]), name))[:SECOND]:
            if name not in best.on and (fit := bench.with_effect(name, best, bench.all, rng)) is not None:
                tried[name] = fit
                scores[tuple(sorted(fit.on))] = criterion(fit)
        chosen = min(tried, key=lambda name: (criterion(tried[name]), name), default=None)
        if chosen is None or criterion(tried[chosen]) >= at:
            break
        best, at = tried[chosen], criterion(tried[chosen])
    least = min(scores.values())
    weights = {names: float(np.exp(-min((score - least) / 2, 700))) for names, score in scores.items()}
    verdict = "effect" if best.on else "no_gap" if criterion(nominal) <= criterion(base) else "mistuned"
    return _answer(bench, verdict, list(best.on), base, best, weights=weights)


def _held_out(bench: Bench, nominal: Fit, base: Fit, learned: Fit, fitted: dict[str, Fit], rng: np.random.Generator) -> dict[str, Any]:
    errors = {"nominal": nominal.squares(bench.test), "recalibrated": learned.squares(bench.test)}
    errors |= {name: fit.squares(bench.test) for name, fit in fitted.items()}
    best = min(errors, key=lambda name: (errors[name], name))
    if best in ("nominal", "recalibrated"):
        return _answer(bench, "no_gap" if best == "nominal" else "mistuned", [], base, base)
    return _answer(bench, "effect", [best], base, fitted[best])


def significant_bins(bench: Bench, fit: Fit) -> list[dict[str, Any]]:
    """Boxes whose mean residual differs from 0: bins of time, phase and each input, by Benjamini and Hochberg 1995 over all."""
    tests: list[tuple[float, str, str, float, float]] = []
    for channel in bench.experiment.outputs:
        places = [s for s in bench.prediction.segments if s.channel == channel]
        r = np.concatenate([fit.residual[s.at] for s in places])
        for axis, values in _axes(bench, places).items():
            edges = np.unique(np.quantile(values, np.linspace(0, 1, min(BINS, max(r.size // 3, 2)) + 1)))
            at = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, max(edges.size - 2, 0))
            for k in range(edges.size - 1):
                inside = r[at == k]
                if inside.size >= 2:
                    z = float(np.mean(inside)) * np.sqrt(inside.size) / (COLOUR if places[0].trial >= 0 else 1.0)
                    tests.append((float(2 * stats.norm.sf(abs(z))), channel, axis, float(edges[k]), float(edges[k + 1])))
    tests.sort()
    passed = [k for k, test in enumerate(tests) if test[0] <= FALSE_DISCOVERIES * (k + 1) / len(tests)]
    chosen = tests[: passed[-1] + 1] if passed else []
    if not chosen:
        return []
    axis = chosen[0][2]
    return [{"channel": c, "box": {a: [low, high]}, "share": 1 / len(chosen)} for _, c, a, low, high in chosen if a == axis]


def _axes(bench: Bench, places: list[Any]) -> dict[str, Array]:
    if places[0].trial < 0:
        means = bench.experiment.means
        return {name: np.asarray(column) for name, column in means.values.items()} if means is not None else {}
    trials = [bench.experiment.trials[s.trial] for s in places]
    axes = {"time": np.concatenate([trial.times for trial in trials])}
    axes |= {name: np.concatenate([trial.inputs[name] for trial in trials]) for name in trials[0].inputs}
    period = bench.model.cycle_time(bench.prediction.nominal)
    if np.isfinite(period):
        axes["phase"] = np.mod(axes["time"] / period, 1.0)
    return axes


def _answer(bench: Bench, verdict: str, names: list[str], base: Fit, best: Fit, *, weights: dict[tuple[str, ...], float] | None = None,
            regions: list[dict[str, Any]] | None = None) -> dict[str, Any]:  # fmt: skip
    weights = weights or {tuple(names): 1.0}
    total = sum(weights.values())
    ranked = sorted(weights.items(), key=lambda one: (-one[1], one[0]))
    candidates = [{"set": list(k), "probability": w / total} for k, w in ranked if w / total > 1e-6]
    sizes = {}
    for channel in bench.experiment.outputs:
        at = np.concatenate([np.arange(s.at.start, s.at.stop) for s in bench.prediction.segments if s.channel == channel])
        sizes[channel] = {
            "recalibrated": _rms(base.residual[at] * bench.sigma[at]), "corrected": _rms(best.residual[at] * bench.sigma[at]),
            "noise_floor": _rms(bench.sigma[at]),
        }  # fmt: skip
    left, before = best.squares(bench.test), base.squares(bench.test)
    count = int(np.sum(bench.test))
    own = next((w / total for k, w in ranked if sorted(k) == sorted(names)), 1.0)
    share = {"value": (before - left) / max(before - count, 1e-9), "ci90": None}
    p_value = float(stats.chi2.sf(best.squares(bench.all), bench.all.size))
    return {
        "format": 1,
        "verdict": verdict,
        "effects": [{"name": name, "probability": own, "parameters": {}, "not_separable_from": []} for name in names],
        "candidates": candidates,
        "novelty": {"p_value": p_value, "unexplained_share": left / max(before, 1e-300)},
        "where": {"channels": {}, "regions": regions or [], "trials": {}},
        "gap": {"unit": "N rms", "channels": sizes, "held_out_conditions": list(bench.held_out), "closed_share": share},
    }


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("results", type=Path)
    parser.add_argument("--case", action="append", help="only this case (repeatable)")
    given = parser.parse_args(arguments)
    model = ContactModel(threads=1)
    for folder in sorted((given.out / "cases").iterdir()):
        if given.case and folder.name not in given.case:
            continue
        if all((given.results / method / folder.name / "diagnosis.json").is_file() for method in METHODS):
            continue
        for method, answer in diagnose_all(folder, model).items():
            target = given.results / method / folder.name
            target.mkdir(parents=True, exist_ok=True)
            (target / "diagnosis.json").write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
        sys.stdout.write(f"{folder.name}\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    np.seterr(all="ignore")
    raise SystemExit(main())
