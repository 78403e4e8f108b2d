"""How is a model identified? Check, search, polish, profile, judge: one function that does all of it."""

from __future__ import annotations

import hashlib
import importlib.metadata
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from threadpoolctl import threadpool_limits

from evat.experiment import Experiment, ExperimentError
from evat.identification.check import check_frequency, check_influence, check_signs, suspicious_scales
from evat.identification.covariance import Optimum
from evat.identification.fits import fit_doubts, fits_of, held_out_fits, misfits
from evat.identification.held import DAMPING
from evat.identification.objective import Objective
from evat.identification.polish import polish
from evat.identification.profile import BetterPoint, Profile, profile
from evat.identification.result import Identification
from evat.identification.searching.excerpts import excerpts
from evat.identification.searching.journal import Journal
from evat.identification.searching.search import SearchResult, check_size, search
from evat.identification.settings import Execution, Settings
from evat.identification.space import space
from evat.identification.verdicts.verdict import correlation, estimates
from evat.inference.checks import check_clocks
from evat.inference.clocks import with_clocks
from evat.inference.law.initial_state import beginnings, begun, in_motion, with_initial_state
from evat.inference.prediction import Prediction
from evat.inference.setup.setup_errors import GAIN, by_channel, called
from evat.model import Model, ParameterError
from evat.required_inputs import unread_inputs

RESTARTS = 4  # of the polish, from better points that profiles came across
DEFAULT, HERE = Settings(), Execution()


def identify(
    experiment: Experiment, model: Model, free: Sequence[str], settings: Settings = DEFAULT, *, execution: Execution = HERE
) -> Identification:
    """What `evat.identify` says, of any model; see evat.answers."""
    # Threads of algebra wait for each other over some thousand rows of a few columns, for most of the time.
    with threadpool_limits(1):
        return _identified(experiment, model, free, settings, execution)


def _identified(experiment: Experiment, model: Model, free: Sequence[str], settings: Settings, execution: Execution) -> Identification:
    begin = time.perf_counter()
    check_size(settings.population, settings.generations, settings.seed)
    fitted, kept = _split(experiment, settings.hold_out)
    check_clocks(experiment)
    objective = _objective(model, fitted, free, settings)
    check_frequency(objective)
    check_signs(objective)
    check_influence(objective, settings.seed)
    spread, some = execution.spread, excerpts(fitted, model, settings.on) if settings.search != "none" else None
    searched = objective if some is None else _objective(model, some, free, settings)
    best = search(
        settings.search,
        searched.costs if spread is None else lambda points: spread(searched, points),
        objective.space.start,
        population=settings.population,
        generations=settings.generations,
        seed=settings.seed,
        journal=_journal(execution, objective, settings),
        progress=lambda done, most, cost: execution.report(f"search, best {cost:.4g}", done / most),
        cancelled=execution.cancelled,
    )
    optimum, profiles, calls = _optimum(objective, searched, best, settings, execution)
    identified = objective.space.at(optimum.point)
    fits = fits_of(objective.at(optimum.point), optimum.residual)
    stopped = best.stopped or execution.stopped()
    return Identification(
        experiment=fitted,
        estimates=estimates(objective, optimum, profiles, list(misfits(fits).values()), stopped),
        correlation=correlation(optimum.covariance),
        values={**objective.prediction.experiment.nominal.values, **settings.values, **identified},
        effects=tuple(dict.fromkeys((*experiment.nominal.effects, *settings.on))),
        objective=settings.objective,
        search=settings.search,
        searched_points=searched.prediction.measured.size,
        cost=objective.cost(optimum.residual),
        fits=fits,
        held_out=held_out_fits(model, kept, {**settings.values, **identified}, settings.on),
        held_out_conditions=tuple(settings.hold_out),
        predicted=objective.prediction.measured + optimum.residual,
        units={variable.name: variable.unit for variable in model.variables if variable.name in fits},
        history=best.history,
        evaluations=(best.history[-1].evaluations if best.history else 0) + calls,
        seconds=time.perf_counter() - begin,
        stopped=stopped,
        doubts=(
            *(remark.text for remark in experiment.remarks if remark.doubt),
            *unread_inputs(model, {**objective.prediction.nominal, **settings.values}, fitted.recorded, fitted.stated),
            *suspicious_scales(objective),
            *fit_doubts(objective, fits, settings.whiten),
            *_held(objective, optimum),
            *_begun(objective, optimum),
            *_late(objective, identified),
            *_clocks(objective, optimum),
            *_damping(objective, optimum),
        ),
        made_by={
            "evat": importlib.metadata.version("evat"),
            "model": model.digest,
            "data": experiment.data_hash,
            "seed": settings.seed,
            "population": settings.population,
            "generations": settings.generations,
            "search": settings.search,
            "objective": settings.objective,
            "whiten": settings.whiten,
        },
    )


CHOICE_MATTERS = 1.0  # standard errors that a choice nobody has made moves an estimate, from which on it is told
CLOCK_MATTERS = 2.0  # standard errors that a lag moves an estimate, from which on it is told
CLOCK_TOLD = 3  # parameters that it moves most
SETUP_DOMINATES = 0.5  # of an estimate's variance, from which it is told that a set-up error gives it
HELD_MATTERS = 0.3  # sd by which a nominal value that is held moves an estimate, from where it is told


def _held(objective: Objective, optimum: Optimum) -> tuple[str, ...]:
    """Nominal values that are held, known to a share only, and in the intervals; set-up errors that are most of them."""
    names, prediction = objective.space.names, objective.prediction
    setup = {parameter.name: parameter for parameter in (*prediction.setup.parameters, *prediction.input_zeros)}
    shapes = {shape.name for shape in objective.shapes}
    told, most, doubts = list[str](), list[str](), list[str]()
    for name, moved in optimum.held.items():
        if name in setup:
            sd = f"{100 * setup[name].sd:.3g} %" if by_channel(name)[1] == GAIN else f"{setup[name].sd:.3g} {setup[name].unit}"
            if mostly := [own for own, by in zip(names, moved, strict=True) if by**2 > SETUP_DOMINATES]:
                most.append(f"{called(*by_channel(name))} (known to {sd}) in {', '.join(mostly)}")
            continue
        if np.any(np.isnan(moved)):
            doubts.append(f"{name} is held, and the model runs at neither end of what it may be: intervals leave that out")
        if widened := [own for own, by in zip(names, moved, strict=True) if abs(by) > HELD_MATTERS]:
            known = (
                "a shape of the law, held as in textbooks" if name in shapes else f"held, known to {100 * objective.known_to(name):.3g} %"
            )
            told.append(f"{name} ({known}) in {', '.join(widened)}")
    if told:
        doubts.insert(0, f"intervals are wider by what nominal values may be off, as nominal.relative_sd says: {'; '.join(told)}")
    if most:
        doubts.append(
            f"most of an interval is what the set-up may be off in all trials alike, as setup_sd says: {'; '.join(most)}. No more trials "
            "narrow that: calibrate the sensor, and state setup_sd"
        )
    return tuple(doubts)


def _objective(model: Model, fitted: Experiment, free: Sequence[str], settings: Settings) -> Objective:
    """What is minimised; ParameterError where a parameter is both free and known."""
    values, means = settings.values, fitted.means
    chosen = space(model, {**fitted.nominal.values, **values}, (*fitted.nominal.effects, *settings.on), free, settings.bounds)
    if clash := sorted(set(free) & set(values)):
        raise ParameterError(f"{', '.join(clash)}: held at a value and free at once; choose one.")
    stated = {name for trial in fitted.trials for name in trial.values} | set(means.values if means is not None else ())
    if both := [name for name in free if name in stated]:
        raise ParameterError(f"{', '.join(both)}: the experiment states this for its trials, so it cannot be free.")
    prediction = with_initial_state(in_motion(Prediction(model, fitted), values, settings.on), values, settings.on)
    return Objective(prediction, chosen, settings.on, settings.objective, dict(values))


def _begun(objective: Objective, optimum: Optimum) -> tuple[str, ...]:
    """Which trials did not begin relaxed."""
    prediction = objective.at(optimum.point)
    predicted = prediction.measured + optimum.residual
    return beginnings(begun(prediction, predicted))


def _clocks(objective: Objective, optimum: Optimum) -> tuple[str, ...]:
    """Parameters for which a lag of a channel that nobody would notice stands in, and which intervals do not hold."""
    setup, doubts = {parameter.name: parameter for parameter in objective.prediction.setup.parameters}, list[str]()
    for name, moved in optimum.clocks.items():
        far = {own: abs(by) for own, by in zip(objective.space.names, moved, strict=True) if abs(by) > CLOCK_MATTERS}
        if far:
            channel = by_channel(name)[0].replace("_", " ")
            most = sorted(far, key=lambda own: -far[own])[:CLOCK_TOLD]
            by = ", ".join(f"{own} by {far[own]:.2g}" for own in most)
            doubts.append(
                f"intervals take the clock of {channel} for exact: one that is off, by {setup[name].sd:.3g} s as setup_sd says and as "
                f"far as these data leave it open, moves {by} standard errors. Know the lag of the channels, and state setup_sd"
            )
    return tuple(doubts)


def _damping(objective: Objective, optimum: Optimum) -> tuple[str, ...]:
    """Whether estimates hang on how damping acts where a bristle yields, which nobody has stated."""
    other, moved = optimum.damping
    far = {name: abs(by) for name, by in zip(objective.space.names, moved, strict=False) if abs(by) > CHOICE_MATTERS}
    if not far:
        return ()
    by = ", ".join(f"{name} by {sds:.2g}" for name, sds in far.items())
    return (
        f"nobody has stated {DAMPING}: with {other} in place of what the component starts with estimates move, in standard errors by noise "
        f"alone, {by}. State in [nominal] which law is meant",
    )


def _late(objective: Objective, identified: Mapping[str, float]) -> tuple[str, ...]:
    """Which channels do better by another clock, which no value of the model is to stand in for."""
    prediction, values = objective.prediction, {**objective.values, **identified}
    clocks = with_clocks(prediction, values, objective.on).setup.clocks
    way = {channel: "later" if late > 0 else "earlier" for channel, late in clocks.items()}
    return tuple(
        f"the model meets {channel.replace('_', ' ')} better {1e6 * abs(late):.3g} us {way[channel]} than it was recorded: values may "
        "stand in for a clock that is off; shift its times, and identify again"
        for channel, late in clocks.items()
    )


def _split(experiment: Experiment, hold_out: Sequence[str]) -> tuple[Experiment, Experiment | None]:
    if not hold_out:
        return experiment, None
    kept = experiment.only(hold_out)
    left = [condition for condition in experiment.conditions if condition not in hold_out]
    if not left:
        raise ExperimentError(f"{experiment.title!r}: all conditions are held out; leave at least one to fit.")
    return experiment.only(left), kept


def _journal(execution: Execution, objective: Objective, settings: Settings) -> Journal | None:
    """The generations, kept with all that decides the course of the search."""
    if execution.journal is None:
        return None
    prediction = objective.prediction
    facts = {
        "evat": importlib.metadata.version("evat"),
        "model": prediction.model.digest,
        "data": prediction.experiment.data_hash,
        "recorded": _digest(objective),
        "conditions": list(prediction.experiment.conditions),
        "nominal": {name: value for name, value in sorted(prediction.nominal.items())},
        "values": {name: value for name, value in sorted(objective.values.items())},
        "effects": [*prediction.experiment.nominal.effects, *objective.on],
        "bounds": {one.name: [one.low, one.high] for one in objective.space.free},
        "objective": objective.kind,
        "search": settings.search,
        "population": settings.population,
        "seed": settings.seed,
        "generations": settings.generations,
    }
    return Journal(execution.journal, facts, execution.resume)


def _digest(objective: Objective) -> str:
    """Of what was measured and how it weighs, and along what: an experiment that was made in memory, or compressed in another way, has no
    file that tells."""
    experiment = objective.prediction.experiment
    digest = hashlib.sha256(np.ascontiguousarray(objective.prediction.measured).tobytes())
    digest.update(np.ascontiguousarray(objective.weights).tobytes())
    for trial in experiment.trials:
        lead = (trial.lead_in.times, *trial.lead_in.inputs.values()) if trial.lead_in is not None else ()
        for column in (trial.times, *trial.inputs.values(), *lead):
            digest.update(np.ascontiguousarray(column).tobytes())
    means = {name: column.tolist() for name, column in experiment.means.values.items()} if experiment.means is not None else {}
    stated = [sorted(trial.values.items()) for trial in experiment.trials], sorted(experiment.setup_sd.items())
    digest.update(repr((stated, sorted(means.items()), experiment.nominal.initial_bristle)).encode())
    return digest.hexdigest()


def _optimum(
    objective: Objective, searched: Objective, best: SearchResult, settings: Settings, execution: Execution
) -> tuple[Optimum, list[Profile | None], int]:
    """The optimum, the profiles of its parameters and the number of runs; from a better point again, where a profile comes across one."""
    points, names, calls = (best.point, *best.others), objective.space.names, 0
    for attempt in range(RESTARTS + 1):
        execution.report("polish", 0.0)
        cancelled = execution.cancelled if not best.stopped else lambda: True
        optimum = polish(objective, points, settings.whiten, cancelled, searched if searched is not objective else None)
        calls += optimum.calls
        curves: list[Profile | None] = []
        if not settings.profiles or best.stopped or execution.stopped():
            return optimum, [None] * len(names), calls
        strict = attempt < RESTARTS
        with ThreadPoolExecutor(objective.side_by_side) as pool:
            waiting = [pool.submit(profile, objective, optimum, place, strict) for place in range(len(names))]
            try:
                for place, name in enumerate(names):  # in their order, so that the first better point is the same every time
                    execution.report(f"profile of {name}", place / len(names))
                    if execution.stopped():
                        pool.shutdown(cancel_futures=True)
                    curves.append(None if waiting[place].cancelled() else waiting[place].result())
            except BetterPoint as better:
                pool.shutdown(cancel_futures=True)
                points = (better.point,)
                continue
        return optimum, curves, calls
    raise AssertionError("the last attempt is not strict")
