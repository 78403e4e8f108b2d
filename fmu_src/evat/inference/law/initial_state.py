"""How did a recording begin? In the midst of a vibration that goes on; else with bristles that are bent anyhow, a nuisance of each trial.

A model starts relaxed. One that vibrates by itself has done so before a record of some cycles begins, and starts periodic, unless the
record says otherwise. A rig that has moved before does not start relaxed either, and until the contact has slid a few deflections the force
shows it. In the deflection at its start a law of bristles is linear, so one more run with another one tells how it shows. A priori it is
anything between the steady deflections of either direction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.noise.autoregression import robust_sd
from evat.inference.noise.estimate import BETWEEN
from evat.inference.prediction import BRISTLE, Prediction
from evat.model import FloatArray
from evat.required_inputs import MOTION

START, PERIODIC = "initial_state", "periodic"  # a model's variable, and how it begins a cycle that comes back to itself
SETTLED = "steady"  # how it begins with all that lags (a temperature, a filter) where it has long been
RANDOM = BETWEEN + 2  # what differs from trial to trial: gain, zero, clock, how its bristles were bent, and how fast that dies away


def in_motion(prediction: Prediction, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> Prediction:
    """The same from a vibration that went on before the records began, where the model vibrates by itself and they look so. Where they do
    not, or the motion is given, what follows with a lag (a temperature, a sensor's filter) has been where it is for long.

    What the owner says counts first: `initial_state` among the nominal values, or bristles that begin relaxed. `slid_in` says that it did;
    else the start is what fits the first cycle of the trials better. values, on : of the model by which that is seen.
    """
    experiment, values = prediction.experiment, {**prediction.nominal, **(values or {})}
    believed = experiment.nominal.initial_bristle
    starts = next((variable.choices for variable in prediction.model.variables if variable.name == START), ())
    if START in values or believed == "relaxed" or not experiment.trials:
        return prediction

    def beginning(start: str) -> Prediction:
        nominal = replace(experiment.nominal, values={**experiment.nominal.values, START: start})
        return Prediction(prediction.model, replace(experiment, nominal=nominal))

    cycles = [prediction.model.cycle_time({**values, **trial.values}) for trial in experiment.trials]
    if not all(np.isfinite(cycles)):
        return beginning(SETTLED) if SETTLED in starts else prediction
    if PERIODIC not in starts:
        return prediction
    resting = beginning(SETTLED) if SETTLED in starts else prediction
    moving = beginning(PERIODIC)
    if believed == "slid_in":
        return moving
    misses = []
    for each in (resting, moving):
        residual, square = each.measured - each.one(values, on), 0.0
        for segment in each.segments:
            if segment.trial >= 0:
                times, own = experiment.trials[segment.trial].times, residual[segment.at]
                first = own[times - times[0] <= cycles[segment.trial]]
                square += float(first @ first) / max(float(np.mean(each.measured[each.places(segment.channel)] ** 2)), 1e-300)
        misses.append(square)
    return resting if np.isfinite(misses[0]) and not misses[1] <= misses[0] else moving


def with_initial_state(prediction: Prediction, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> Prediction:
    """The same with what an unknown start changes in it, by the model with these values; as it is where bristles start as the owner says,
    there are none, or the motion is not given from outside."""
    believed = prediction.experiment.nominal.initial_bristle
    if believed == "relaxed" or not any(variable.name == BRISTLE for variable in prediction.model.variables):
        return prediction
    values = values or {}
    steady = steady_deflections(prediction, values, on)
    if not any(steady.values()):
        return prediction
    if believed == "slid_in" and not prediction.starts:
        ways = {trial.file: float(np.sign(trial.inputs[MOTION][0])) for trial in prediction.experiment.trials if MOTION in trial.inputs}
        prediction = prediction.starting({file: way * steady[file] for file, way in ways.items() if way}, None)
    elsewhere = {file: prediction.starts.get(file, 0.0) + deflection for file, deflection in steady.items()}
    change = prediction.starting(elsewhere, None).one(values, on) - prediction.starting(prediction.starts, None).one(values, on)
    return prediction.starting(prediction.starts, np.nan_to_num(change), steady)


def begun(prediction: Prediction, predicted: FloatArray) -> Prediction:
    """The same from the deflections that what `predicted` (N,) leaves tells of, where these are not relaxed.

    Noise is taken from second differences, not from repeats: these begin each in its own way.
    """
    starts = dict(prediction.starts)
    for number, (away, information) in _away(prediction, prediction.measured - predicted).items():
        trial = prediction.experiment.trials[number]
        steady = prediction.steady[trial.file]
        if abs(away) > max(CONSTANTS.sure_start / np.sqrt(information), CONSTANTS.least_start):
            widest = CONSTANTS.widest_start * steady
            starts[trial.file] = float(np.clip(prediction.starts.get(trial.file, 0.0) + away * steady, -widest, widest))
    return prediction.starting(starts, prediction.bent, prediction.steady)


def without_starts(prediction: Prediction, residual: FloatArray) -> FloatArray:
    """A residual (N,), calculated less measured, without what bristles that were bent at the start of a trial most likely leave in it: that
    is no noise, and nothing that the model misses."""
    left = residual.copy()
    for number, (away, _) in _away(prediction, -residual).items():
        for segment in prediction.segments:
            if segment.trial == number:
                left[segment.at] += away * prediction.bent[segment.at]
    return left


def _away(prediction: Prediction, left: FloatArray) -> dict[int, tuple[float, float]]:
    """By the number of each trial whose start shows: by how many steady deflections bristles were bent more there, by what is left (N,),
    measured less calculated, and how much that tells, one over its variance."""
    told = dict[int, tuple[float, float]]()
    for number in range(len(prediction.experiment.trials)):
        places = [s.at for s in prediction.segments if s.trial == number and np.any(prediction.bent[s.at]) and s.at.stop - s.at.start > 4]
        if not places:
            continue
        sds = [robust_sd(np.diff(left[at], 2)) / np.sqrt(6) + 1e-12 * float(np.max(np.abs(prediction.bent[at]))) for at in places]
        column = np.concatenate([prediction.bent[at] / sd for at, sd in zip(places, sds, strict=True)])
        residual = np.concatenate([left[at] / sd for at, sd in zip(places, sds, strict=True)])
        information = 1 + float(column @ column)
        told[number] = float(column @ residual) / information, information
    return told


def beginnings(prediction: Prediction) -> tuple[str, ...]:
    """Which trials began with bent bristles, in a sentence."""
    bent = {file: z for file, z in prediction.starts.items() if abs(z) > CONSTANTS.least_start * prediction.steady.get(file, np.inf)}
    if not bent:
        return ()
    file = max(bent, key=lambda each: abs(bent[each]))
    others = f" and {len(bent) - 1} more" if len(bent) > 1 else ""
    most, steady = 1e6 * bent[file], 1e6 * prediction.steady[file]  # um
    return (
        f"{file}{others} began with bent bristles, up to {most:.3g} um of the {steady:.3g} um of steady slip: "
        "taken in as a nuisance of each trial",
    )


def steady_deflections(prediction: Prediction, values: Mapping[str, float | str], on: Sequence[str]) -> dict[str, float]:
    """By the trial's file: the largest deflection [m] of bristles in steady slip; 0 where it moves otherwise. Empty without bristles."""
    if not any(variable.name == BRISTLE for variable in prediction.model.variables):
        return {}
    effects = tuple(dict.fromkeys((*prediction.experiment.nominal.effects, *on)))
    own = prediction.of_model_alone(values)
    of_run, steady = dict[bytes, float](), dict[str, float]()
    for place, trial in enumerate(prediction.experiment.trials):
        key = prediction.alike[place]
        if key not in of_run:
            fastest = float(np.max(np.abs(trial.inputs[MOTION]))) if MOTION in trial.inputs else 0.0
            held = {name: float(column[0]) for name, column in trial.inputs.items()}
            sets = {**prediction.nominal, **own, **trial.values, **held, MOTION: fastest * np.array(CONSTANTS.settling_speeds)}
            settled = prediction.model.settled((BRISTLE,), effects, sets)[BRISTLE] if fastest > 0 else np.zeros(1)
            of_run[key] = float(np.max(np.abs(np.nan_to_num(settled))))
        steady[trial.file] = of_run[key]
    return steady
