"""Is a column what its owner declares it to be? An input in another unit, or two channels that changed places, pass for physics.

Where the nominal model is far from what was measured, it is run with inputs as they would be in each usual unit of their kind, and compared
with channels exchanged. What is then so much nearer that no values and no effect do as much was declared wrong.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Trial
from evat.inference.checks import rms
from evat.inference.prediction import Prediction, with_lead_in
from evat.model import EvatError, FloatArray
from evat.units import affine

USUAL_UNITS = {
    "m/s": ("mm/s", "um/s", "m/min", "mm/min"),
    "m": ("mm", "um", "nm"),
    "N": ("kN", "mN"),
    "K": ("degC",),
    "Hz": ("kHz", "1/min"),
    "rad": ("deg",),
    "Pa": ("kPa", "MPa", "GPa"),
}
KIND = {unit: kind for kind, units in USUAL_UNITS.items() for unit in (kind, *units)}


def misdeclared(prediction: Prediction, predicted: FloatArray) -> list[str]:
    """What was declared wrong, a sentence each; empty where the nominal model is not far from what was measured, or nothing brings it much
    nearer. predicted : (N,), by the nominal model."""
    if not _left(prediction, predicted) > CONSTANTS.far_from_nominal:
        return []
    heads = {key: place for place, key in reversed(prediction.alike.items())}
    trials = tuple(prediction.experiment.trials[place].head(CONSTANTS.probed_samples) for place in sorted(heads.values()))
    looked_at = prediction.of(replace(prediction.experiment, trials=trials))
    before = _left(looked_at, _run(looked_at))
    tried = [*_in_other_units(looked_at), *_exchanged(looked_at)]
    if not tried or not before > CONSTANTS.far_from_nominal:
        return []
    after, said = min(tried, key=lambda each: each[0])
    if not after < min(before / CONSTANTS.nearer_by_declaration, CONSTANTS.near_to_nominal):
        return []
    return [f"{said}: so the nominal model leaves {after:.2g} of the rms that was measured, and {before:.2g} as it is declared"]


def _left(prediction: Prediction, predicted: FloatArray) -> float:
    """What a prediction leaves of a channel, in its rms: the most of all channels."""
    shares = []
    for channel in prediction.channels:
        at = prediction.places(channel)
        level = rms(prediction.measured[at])
        shares.append(rms(prediction.measured[at] - predicted[at]) / level if level > 0 else 0.0)
    return max(shares) if all(map(math.isfinite, shares)) else math.inf


def _run(prediction: Prediction) -> FloatArray:
    try:
        return prediction.one()
    except EvatError:
        return np.full(prediction.measured.size, np.inf)


def _in_other_units(prediction: Prediction) -> Iterator[tuple[float, str]]:
    """What is left with each input, and each value of a table, as if it were in another unit."""
    experiment, known = prediction.experiment, {variable.name: variable for variable in prediction.model.variables}
    names = {name for trial in experiment.trials for name in trial.inputs} | set(experiment.means.values if experiment.means else ())
    for name in sorted(names):
        signal = experiment.signals.get(name)
        declared = signal.unit if signal is not None and signal.shown_in else known[name].unit
        for other in (unit for unit, kind in KIND.items() if kind == KIND.get(declared) and unit != declared):
            changed = _changed(experiment, name, _converted(declared, other, of_derivative=signal is not None and bool(signal.of)))
            if all(known[name].min <= column.min() and column.max() <= known[name].max for column in _columns(changed, name)):
                moved = prediction.of(changed)
                yield _left(moved, _run(moved)), f"{name} is declared in {declared}, and looks as if it were in {other}"


def _converted(declared: str, other: str, *, of_derivative: bool) -> Callable[[FloatArray], FloatArray]:
    """From SI as it was read to what it would be, had the same numbers been in the other unit."""
    (own, own_zero), (factor, zero) = affine(declared, KIND[declared]), affine(other, KIND[declared])
    if of_derivative:
        own_zero = zero = 0.0
    return lambda column: (column - own_zero) / own * factor + zero


def _changed(experiment: Experiment, name: str, change: Callable[[FloatArray], FloatArray]) -> Experiment:
    means = experiment.means
    if means is not None and name in means.values:
        means = Means(means.file, means.conditions, {**means.values, name: change(means.values[name])}, means.outputs, means.sd)
    return replace(experiment, trials=tuple(trial.with_input(name, change) for trial in experiment.trials), means=means)


def _columns(experiment: Experiment, name: str) -> list[FloatArray]:
    own = [with_lead_in(trial)[1][name] for trial in experiment.trials if name in trial.inputs]
    return own if experiment.means is None or name not in experiment.means.values else [*own, experiment.means.values[name]]


def _exchanged(prediction: Prediction) -> Iterator[tuple[float, str]]:
    """What is left with two measured channels of one unit exchanged, or a recorded load and a force."""
    experiment, known = prediction.experiment, {variable.name: variable for variable in prediction.model.variables}
    for one, other in combinations(prediction.channels, 2):
        if known[one].unit == known[other].unit:
            moved = _with_columns(prediction, {one: other, other: one})
            if moved is not None:
                yield _left(moved, _run(moved)), f"{one} and {other} look as if they were exchanged"
    for name in sorted({name for trial in experiment.trials for name in trial.inputs}):
        for channel in prediction.channels:
            if known[name].unit == known[channel].unit == "N":
                moved = _with_columns(prediction, {name: channel, channel: name}, known[name].min)
                if moved is not None:
                    yield _left(moved, _run(moved)), f"{name} and {channel} look as if they were exchanged"


def _with_columns(prediction: Prediction, taken: dict[str, str], low: float = -math.inf) -> Prediction | None:
    """Each column with the numbers of another; inputs no less than their bound. None where a trial lacks one of them."""
    experiment, trials = prediction.experiment, list[Trial]()
    for trial in experiment.trials:
        if not set(taken) <= {*trial.inputs, *trial.outputs}:
            return None
        trials.append(_exchanged_in(trial, taken, low))
    means = experiment.means
    if means is not None:
        if not set(taken) <= set(means.outputs):
            return None
        means = replace(means, outputs={name: means.outputs[taken.get(name, name)] for name in means.outputs})
    return prediction.of(replace(experiment, trials=tuple(trials), means=means))


def _exchanged_in(trial: Trial, taken: dict[str, str], low: float) -> Trial:
    """What was recorded just before is exchanged alike, and left out where it lacks an output that an input takes: a long record that was
    compressed has inputs alone there."""
    own, lead = {**trial.inputs, **trial.outputs}, trial.lead_in
    if lead is not None:
        whole = all(taken.get(name, name) in {*lead.inputs, *lead.outputs} for name in trial.inputs)
        lead = _exchanged_in(lead, taken, low) if whole else None
    inputs = {name: np.maximum(own[taken[name]], low) if name in taken else column for name, column in trial.inputs.items()}
    return replace(trial, inputs=inputs, outputs={name: own[taken.get(name, name)] for name in trial.outputs}, lead_in=lead)
