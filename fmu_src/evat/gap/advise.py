"""Which experiment would tell more? The one at which the likely models differ most, in units of the noise (T-optimal: Atkinson and
Fedorov 1975)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Trial
from evat.gap.search.compare import Comparison
from evat.inference.fit import Fit
from evat.inference.hypothesis import Hypothesis
from evat.model import EvatError, FloatArray, Variable


@dataclass(frozen=True)
class Advice:
    """`values`: what to set, SI, of an input its rms; `separates`: the two hypotheses; `expected_probability` to be right after it."""

    values: Mapping[str, float]
    separates: tuple[Hypothesis, Hypothesis]
    expected_probability: float


def next_experiment(comparison: Comparison, probabilities: Mapping[Hypothesis, float]) -> Advice | None:
    """Of one more condition, between the two likeliest sets, however sure the first is; None where there are no two models."""
    ranked = sorted(probabilities, key=lambda on: (-probabilities[on], on))
    if len(ranked) < 2:
        return None
    pair = (ranked[0], ranked[1])
    both = [comparison.models[on] if on else comparison.recalibrated for on in pair]
    experiment = comparison.prediction.experiment
    best: tuple[float, dict[str, float]] | None = None
    for values, changed in _options(comparison, experiment):
        apart = _distance(comparison, changed, both)
        if apart is not None and (best is None or apart > best[0]):
            best = (apart, values)
    if best is None:
        return None
    odds = abs(math.log(max(probabilities[pair[0]], 1e-6) / max(probabilities[pair[1]], 1e-6)))
    return Advice(best[1], pair, 1 / (1 + math.exp(-min(odds + 0.5 * best[0] / 10, 30.0))))


def _options(comparison: Comparison, experiment: Experiment) -> list[tuple[dict[str, float], Experiment]]:
    options = []
    bounds = {variable.name: variable for variable in comparison.prediction.model.variables}
    for trial in experiment.trials[:1]:
        for name in sorted({*trial.inputs, *trial.values}):
            for factor in CONSTANTS.next_experiment_factors:
                other = scaled(trial, bounds[name], factor)
                if other is not None:
                    size = other.values[name] if name in other.values else float(np.sqrt(np.mean(other.inputs[name] ** 2)))
                    options.append(({name: size}, replace(experiment, trials=(other,), means=None)))
    means = experiment.means
    if means is not None:
        for name, column in means.values.items():
            for factor in CONSTANTS.next_experiment_factors:
                changed = _zero(bounds[name]) + factor * (column[:1] - _zero(bounds[name]))
                row = {other: values[:1] for other, values in means.values.items()} | {name: changed}
                if bounds[name].min <= float(row[name][0]) <= bounds[name].max:
                    outputs = {channel: values[:1] for channel, values in means.outputs.items()}
                    one = Means(means.file, means.conditions[:1], row, outputs, {})
                    options.append(({name: float(row[name][0])}, replace(experiment, trials=(), means=one)))
    return options


def _zero(variable: Variable) -> float:
    """What a quantity is multiplied from: of a temperature that at which everything stands when nothing happens."""
    return variable.start if variable.unit == "K" else 0.0


def scaled(trial: Trial, variable: Variable, factor: float) -> Trial | None:
    """The head of a trial with an input or a value of its condition multiplied; None where that is out of bounds or nothing."""
    cut, name, zero = trial.head(CONSTANTS.next_experiment_samples), variable.name, _zero(variable)
    if name in trial.values:
        value = zero + factor * (trial.values[name] - zero)
        return replace(cut, values={**trial.values, name: value}) if variable.min <= value <= variable.max and value != 0 else None
    column = zero + factor * (cut.inputs[name] - zero)
    if (np.ptp(column) == 0 and column[0] == 0) or column.min() < variable.min or column.max() > variable.max:
        return None
    return replace(cut, inputs={**cut.inputs, name: column})


def _distance(comparison: Comparison, changed: Experiment, models: Sequence[Fit]) -> float | None:
    """Squared distance of two models' outputs there, in variances of noise and of the discrepancy that models of this kind have."""
    prediction = comparison.prediction.of(changed)
    rows: list[FloatArray] = []
    for model in models:
        try:
            rows.append(prediction.one(model.values, model.on))
        except EvatError:
            return None
    if not all(np.all(np.isfinite(row)) for row in rows):
        return None
    total = 0.0
    whitening = comparison.whitening
    form = min(model.likelihood.size for model in models)
    for segment in prediction.segments:
        floors = [float(whitening.noise.sizes[g.members[0]]) for g in whitening.groups if g.channel == segment.channel]
        level = whitening.levels[segment.channel]
        apart = float(np.mean((rows[0][segment.at] - rows[1][segment.at]) ** 2))
        noise = float(np.mean(floors)) ** 2 / CONSTANTS.averaged_samples
        total += apart / (noise + (max(form, CONSTANTS.least_form_in_advice) * level) ** 2)
    return total
