"""Which experiment would tell more? A condition recorded once more with something set otherwise, where the likely models differ most.

What a model takes up by its own values, known as they are only as well as the data tell them, tells nothing: models differ by as much as in
the spread of what both predict (Box and Hill 1967), at the temperature that the judgement takes evidence at. The condition advised leaves
the least chance of an error (bound of Bhattacharyya: Kailath 1967).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Trial
from evat.gap.search.compare import Comparison
from evat.gap.verdict.judgement import Judgement
from evat.inference.fit import Fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction, with_lead_in
from evat.model import EvatError, FloatArray, Variable

Base = TypeVar("Base", Trial, int)


@dataclass(frozen=True)
class Advice:
    """`condition`: the one to be recorded once more, with `values` set otherwise, SI, of an input its rms; `separates`: the two likeliest
    hypotheses; `expected_probability` of the true one after it, if one of those that are likely is."""

    condition: str
    values: Mapping[str, float]
    separates: tuple[Hypothesis, Hypothesis]
    expected_probability: float


@dataclass(frozen=True)
class Option:
    """An experiment of one trial, or one row of means, that differs in `values` from a condition that was recorded."""

    condition: str
    values: Mapping[str, float]
    experiment: Experiment


def next_experiment(comparison: Comparison, judgement: Judgement) -> Advice | None:
    """Of one more condition, between the likeliest sets, however sure the first is; None where there are no two models."""
    ranked = sorted(judgement.probabilities, key=lambda on: (-judgement.probabilities[on], on))
    rivals = ranked[: max(2, min(len(judgement.likely), CONSTANTS.next_experiment_hypotheses))]
    if len(rivals) < 2:
        return None
    shares = np.array([max(judgement.probabilities[on], CONSTANTS.least_candidate) for on in rivals])
    shares /= np.sum(shares)
    fits = [comparison.models[on] if on else comparison.recalibrated for on in rivals]
    temperature = judgement.constants.temperature
    plain = [
        (_bound(apart, shares), option)
        for option in options(comparison)
        if (apart := _apart(comparison, option, fits, temperature)) is not None
    ]
    best: tuple[float, Option, FloatArray] | None = None
    for least, option in sorted(plain, key=lambda one: one[0]):  # parameters that are not known better only bring models nearer
        if best is not None and least >= best[0]:
            break
        apart = _apart(comparison, option, fits, temperature, uncertain=True)
        if apart is not None and (best is None or _bound(apart, shares) < best[0]):
            best = (_bound(apart, shares), option, apart)
    if best is None:
        return None
    _, option, apart = best
    expected = float(np.sum(shares**2 / (np.exp(-apart / 2) @ shares)))
    return Advice(option.condition, option.values, (rivals[0], rivals[1]), expected)


def _bound(apart: FloatArray, shares: FloatArray) -> float:
    """Log of the most by which the likeliest after it may be the wrong one, of squared distances (K, K)."""
    pairs = combinations(range(shares.size), 2)
    return float(np.logaddexp.reduce([0.5 * math.log(shares[i] * shares[j]) - apart[i, j] / 8 for i, j in pairs]))


def options(comparison: Comparison) -> Iterator[Option]:
    """What of a recorded condition could be set otherwise, one thing at a time."""
    experiment = comparison.prediction.experiment
    bounds = {variable.name: variable for variable in comparison.prediction.model.variables}
    firsts = {trial.condition: trial for trial in reversed(experiment.trials)}
    for trial in _spread([firsts[condition] for condition in dict.fromkeys(trial.condition for trial in experiment.trials)]):
        for name in sorted({*trial.inputs, *trial.values}):
            for factor in CONSTANTS.next_experiment_factors:
                other = scaled(trial, bounds[name], factor)
                if other is not None:
                    size = other.values[name] if name in other.values else float(np.sqrt(np.mean(other.inputs[name] ** 2)))
                    yield Option(trial.condition, {name: size}, replace(experiment, trials=(other,), means=None))
    means = experiment.means
    if means is None:
        return
    places = {condition: place for place, condition in reversed(list(enumerate(means.conditions)))}
    for place in _spread([places[condition] for condition in dict.fromkeys(means.conditions)]):
        at = slice(place, place + 1)
        row = {name: column[at] for name, column in means.values.items()}
        outputs = {channel: column[at] for channel, column in means.outputs.items()}
        for name, value in row.items():
            for factor in CONSTANTS.next_experiment_factors:
                changed = _zero(bounds[name]) + factor * (value - _zero(bounds[name]))
                if bounds[name].min <= changed[0] <= bounds[name].max and changed[0] != value[0]:
                    one = Means(means.file, means.conditions[at], {**row, name: changed}, outputs, {})
                    yield Option(means.conditions[place], {name: float(changed[0])}, replace(experiment, trials=(), means=one))


def _spread(bases: Sequence[Base]) -> list[Base]:
    """As many as are looked at, from the first to the last."""
    places = np.unique(np.linspace(0, len(bases) - 1, min(len(bases), CONSTANTS.next_experiment_conditions)).round().astype(int))
    return [bases[place] for place in places]


def _zero(variable: Variable) -> float:
    """What a quantity is multiplied from: of a temperature that at which everything stands when nothing happens."""
    return variable.start if variable.unit == "K" else 0.0


def scaled(trial: Trial, variable: Variable, factor: float) -> Trial | None:
    """The head of a trial with an input or a value of its condition multiplied; None where that is out of bounds or nothing."""
    cut, name, zero = trial.head(CONSTANTS.next_experiment_samples), variable.name, _zero(variable)
    if name in trial.values:
        value = zero + factor * (trial.values[name] - zero)
        return replace(cut, values={**trial.values, name: value}) if variable.min <= value <= variable.max and value != 0 else None
    other = cut.with_input(name, lambda column: zero + factor * (column - zero))
    column, led = other.inputs[name], with_lead_in(other)[1][name]
    if (np.ptp(column) == 0 and column[0] == 0) or led.min() < variable.min or led.max() > variable.max:
        return None
    return other


def _apart(comparison: Comparison, option: Option, fits: Sequence[Fit], temperature: float, uncertain: bool = False) -> FloatArray | None:
    """Squared distances (K, K) of what models predict there, in variances of noise and of the discrepancy that models of this kind have, at
    a temperature; None where one does not run.

    uncertain : what the data leave open of the models' parameters counts, too.
    """
    prediction = comparison.prediction.of(option.experiment).running_the_law()
    weights = _weights(comparison, prediction, min(fit.likelihood.size for fit in fits))
    rows, open_ = list[FloatArray](), list[FloatArray]()
    for fit in fits:
        try:
            if uncertain:
                scales = {p.name: p.slope(float(u)) for p, u in zip(fit.parameters, fit.point, strict=True)}
                row, slopes = prediction.jacobian(fit.values, list(scales), scales, fit.on)
                open_.append(weights[:, None] * (np.nan_to_num(slopes) @ _root(fit.likelihood.covariance, temperature)))
            else:
                row = prediction.one(fit.values, fit.on)
        except EvatError:
            return None
        if not np.all(np.isfinite(row)):
            return None
        rows.append(weights * row)
    apart = np.zeros((len(fits), len(fits)))
    for i, j in combinations(range(len(fits)), 2):
        between = rows[i] - rows[j]
        square = float(between @ between)
        if uncertain:  # between' (T I + A A' / 2)^-1 between, of the columns A of both
            columns = np.hstack([open_[i], open_[j]])
            along = columns.T @ between
            square -= float(along @ np.linalg.solve(columns.T @ columns + 2 * temperature * np.eye(along.size), along))
        apart[i, j] = apart[j, i] = max(square, 0.0) / temperature
    return apart


def _weights(comparison: Comparison, prediction: Prediction, form: float) -> FloatArray:
    """One over the standard deviation (N,) by which each number of a new condition counts: noise averages out, errors of form do not."""
    whitening, weights = comparison.whitening, np.empty(prediction.measured.size)
    for segment in prediction.segments:
        floors = [float(size) for size, g in zip(whitening.sizes, whitening.groups, strict=True) if g.channel == segment.channel]
        noise = float(np.mean(floors)) ** 2 / CONSTANTS.averaged_samples
        variance = noise + (max(form, CONSTANTS.least_form_in_advice) * whitening.levels[segment.channel]) ** 2
        weights[segment.at] = 1 / math.sqrt((segment.at.stop - segment.at.start) * variance)
    return weights


def _root(covariance: FloatArray, temperature: float) -> FloatArray:
    """A square root (p, p) of the covariance that the data leave at a temperature; the prior, of standard deviation 1, counts in full."""
    variances, axes = np.linalg.eigh(covariance)
    told = 1 / np.clip(variances, 1e-12, 1.0) - 1
    root: FloatArray = axes / np.sqrt(told / temperature + 1)
    return root
