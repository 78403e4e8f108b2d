"""How is a contact identified? Check, search, polish, profile, judge: one function that does all of it."""

from __future__ import annotations

import importlib.metadata
import os
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from evat.experiment import Experiment, ExperimentError
from evat.identify.check import check_clocks, check_influence, check_signs, suspicious_scales
from evat.identify.covariance import Optimum
from evat.identify.fits import fit_doubts, fits_of, held_out_fits
from evat.identify.journal import Journal
from evat.identify.objective import Kind, Objective
from evat.identify.polish import polish
from evat.identify.profile import BetterPoint, Profile, profile
from evat.identify.result import Identification
from evat.identify.search import Found, Search, check_size, search
from evat.identify.space import space
from evat.identify.verdict import correlation, estimates
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Model, ParameterError

Spread = Callable[[Objective, FloatArray], FloatArray]
RESTARTS = 4  # of the polish, from better points that profiles came across


def identify(
    experiment: Experiment,
    free: Sequence[str],
    *,
    model: Model,
    on: Sequence[str] = (),
    values: Mapping[str, float | str] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    objective: Kind = "least_squares",
    search_by: Search = "de",
    population: int = 64,
    generations: int = 100,
    seed: int = 0,
    whiten: bool = True,
    profiles: bool = True,
    hold_out: Sequence[str] = (),
    journal: Path | None = None,
    resume: bool = False,
    spread: Spread | None = None,
    progress: Callable[[str, float], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Identification:
    """Find the free parameters of a model from an experiment, and what the experiment says about each.

    Parameters
    ----------
    free : names of the parameters to find; on : effects beside the nominal ones; values : others to hold, SI, in place of the nominal ones.
    bounds : SI, by name; without them from a twentieth to twenty times the nominal value.
    objective : least_squares, huber, or relative (the paper's eq. 9); see evat.identify.objective.
    search_by : ga (genetic algorithm), de (differential evolution), none (polish from the nominal values).
    whiten : least_squares takes the noise's correlation from sample to sample into account.
    profiles : make profile intervals; without them the standard errors decide.
    hold_out : conditions that the fit does not see, on which it is judged.
    journal : file that holds the generations, so that a search that was cut off can go on with `resume`.
    spread : evaluates a generation elsewhere; see evat.identify.cluster.
    progress : told what is done and its share; cancelled : asked between generations and runs whether to stop with the best so far.

    Raises
    ------
    ParameterError and ExperimentError for what would be a nonsense fit: names, bounds, a clock that jumps, signs, a force of zero.
    """
    begin = time.perf_counter()
    check_size(population, generations, seed)
    fitted, kept = _split(experiment, hold_out)
    check_clocks(experiment)
    values = dict(values or {})
    chosen = space(model, {**fitted.nominal.values, **values}, (*fitted.nominal.effects, *on), free, bounds or {})
    if clash := sorted(set(free) & set(values)):
        raise ParameterError(f"{', '.join(clash)}: held at a value and free at once; choose one.")
    if stated := [
        name for name in free if any(name in trial.values for trial in fitted.trials) or (fitted.means and name in fitted.means.values)
    ]:
        raise ParameterError(f"{', '.join(stated)}: the experiment states this for its trials, so it cannot be free.")
    aim = Objective(Prediction(model, fitted), chosen, on, objective, values)
    check_signs(aim)
    check_influence(aim, seed)
    book = _journal(journal, resume, aim, search_by, population, generations, seed)
    found = search(
        search_by,
        aim.costs if spread is None else lambda points: spread(aim, points),
        chosen.start,
        population=population,
        generations=generations,
        seed=seed,
        journal=book,
        progress=None if progress is None else lambda done, most, best: progress(f"search, best {best:.4g}", done / most),
        cancelled=cancelled,
    )
    optimum, curves, calls = _judged(aim, found, whiten, profiles and not found.stopped, progress, cancelled)
    complete = {**experiment.nominal.values, **values, **chosen.at(optimum.point)}
    fits = fits_of(aim.prediction, optimum.residual)
    stopped = found.stopped or bool(cancelled is not None and cancelled())
    return Identification(
        experiment=fitted,
        estimates=estimates(aim, optimum, curves),
        correlation=correlation(optimum.covariance),
        values=complete,
        effects=tuple(dict.fromkeys((*experiment.nominal.effects, *on))),
        objective=objective,
        search=search_by,
        cost=aim.cost(optimum.residual),
        fits=fits,
        held_out=held_out_fits(model, kept, {**values, **chosen.at(optimum.point)}, on),
        held_out_conditions=tuple(hold_out),
        predicted=aim.prediction.measured + optimum.residual,
        units={variable.name: variable.unit for variable in model.variables if variable.name in fits},
        history=found.history,
        evaluations=(found.history[-1].evaluations if found.history else 0) + calls,
        seconds=time.perf_counter() - begin,
        stopped=stopped,
        doubts=(*suspicious_scales(aim), *fit_doubts(aim, fits, whiten)),
        made_by={
            "evat": importlib.metadata.version("evat"),
            "model": model.digest,
            "data": experiment.data_hash,
            "seed": seed,
            "population": population,
            "generations": generations,
            "search": search_by,
            "objective": objective,
            "whiten": whiten,
        },
    )


def _split(experiment: Experiment, hold_out: Sequence[str]) -> tuple[Experiment, Experiment | None]:
    if not hold_out:
        return experiment, None
    kept = experiment.only(hold_out)
    left = [condition for condition in experiment.conditions if condition not in hold_out]
    if not left:
        raise ExperimentError(f"{experiment.title!r}: all conditions are held out; leave at least one to fit.")
    return experiment.only(left), kept


def _journal(path: Path | None, resume: bool, aim: Objective, kind: Search, population: int, generations: int, seed: int) -> Journal | None:
    if path is None:
        return None
    experiment: Experiment = aim.prediction.experiment
    facts = {
        "evat": importlib.metadata.version("evat"),
        "model": aim.prediction.model.digest,
        "data": experiment.data_hash,
        "conditions": list(experiment.conditions),
        "nominal": {name: value for name, value in sorted(aim.prediction.nominal.items())},
        "values": {name: value for name, value in sorted(aim.values.items())},
        "effects": [*experiment.nominal.effects, *aim.on],
        "bounds": {one.name: [one.low, one.high] for one in aim.space.free},
        "objective": aim.kind,
        "search": kind,
        "population": population,
        "seed": seed,
        "generations": generations,
    }
    return Journal(path, facts, resume)


def _judged(
    aim: Objective,
    found: Found,
    whiten: bool,
    profiles: bool,
    progress: Callable[[str, float], None] | None,
    cancelled: Callable[[], bool] | None,
) -> tuple[Optimum, list[Profile | None], int]:
    """The optimum, and the profiles of its parameters; from a better point again, where a profile comes across one."""
    tell = progress or (lambda what, share: None)
    points, names, calls = (found.point, *found.others), aim.space.names, 0
    for attempt in range(RESTARTS + 1):
        tell("polish", 0.0)
        optimum = polish(aim, points, whiten, None if not found.stopped else lambda: True)
        calls += optimum.calls
        curves: list[Profile | None] = []
        if not profiles or (cancelled is not None and cancelled()):
            return optimum, [None] * len(names), calls
        strict = attempt < RESTARTS
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            waiting = [pool.submit(profile, aim, optimum, place, strict) for place in range(len(names))]
            try:
                for place, name in enumerate(names):  # in their order, so that the first better point is the same every time
                    tell(f"profile of {name}", place / len(names))
                    if cancelled is not None and cancelled():
                        pool.shutdown(cancel_futures=True)
                    curves.append(None if waiting[place].cancelled() else waiting[place].result())
            except BetterPoint as better:
                pool.shutdown(cancel_futures=True)
                points = (better.point,)
                continue
        return optimum, curves, calls
    raise AssertionError("the last attempt is not strict")
