"""How far apart are two recordings of the same thing? Noise within a trial, and what changes from trial to trial.

Within a trial noise is autoregressive; its shape belongs to the channel, its size to channel and condition. From trial to trial gain, zero
and clock differ; their spread belongs to the channel. Both are read off the differences between repeats, which no model error can enter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Means
from evat.inference.cycles import cycle_samples
from evat.inference.noise.autoregression import (
    WHITE,
    autoregression,
    impulse_response,
    innovation_sd,
    innovations,
    robust_sd,
)
from evat.inference.noise.calm_windows import autoregression_where_calm, innovation_sd_where_calm
from evat.inference.noise.discontinuities import bends
from evat.inference.noise.irregularity import Irregularity, bursts, irregular, without_lines
from evat.inference.noise.means import nugget, replicate_sd
from evat.inference.noise.synchronous_average import without_synchronous_average
from evat.inference.prediction import Prediction, Segment
from evat.inference.recorded_inputs import comparable
from evat.model import BoolArray, FloatArray

RANDOM_EFFECTS = ("gain", "zero", "clock")  # between trials
BETWEEN = len(RANDOM_EFFECTS)


@dataclass(frozen=True)
class Noise:
    """What an experiment says of its noise.

    `filters[channel]` turns noise within a trial into innovations; `sizes[place]` is their sd in each segment [unit of the channel].
    `spread[channel]` (BETWEEN,) are the standard deviations of the random effects between trials: gain [1], zero [unit of the channel],
    clock [sampling intervals]; `degrees[channel]` from how many differences between repeats they were estimated, 0 where from none.
    `irregular[channel]` tells what repeats do not share and is no noise.
    """

    filters: Mapping[str, FloatArray]
    sizes: FloatArray
    spread: Mapping[str, FloatArray]
    degrees: Mapping[str, int]
    irregular: Mapping[str, Irregularity]

    @property
    def repeated(self) -> bool:
        """Whether anything was recorded twice."""
        return any(self.degrees.values())


def differing(predicted: FloatArray, times: FloatArray) -> FloatArray:
    """How gain, zero and clock of a trial show in it: (n, 3). The clock in sampling intervals, of which a trigger misses some part."""
    if predicted.size < 2:
        return np.column_stack([predicted, np.ones_like(predicted), np.zeros_like(predicted)])
    slope = np.gradient(predicted, times) * float(np.median(np.diff(times)))
    return np.column_stack([predicted, np.ones_like(predicted), -slope])


def between_trials(prediction: Prediction, noise: Noise, segment: Segment, predicted: FloatArray) -> FloatArray:
    """What gain, zero and clock of a trial change in a segment of it, each by its standard deviation: (L, BETWEEN)."""
    changes: FloatArray = _basis(prediction, segment, predicted) * noise.spread[segment.channel]
    return changes


def estimate_noise(prediction: Prediction, predicted: FloatArray, *, prior: bool = True, from_residual: bool = False) -> Noise:
    """Noise within trials and random effects between them, from repeats where there are any.

    Parameters
    ----------
    predicted : (N,), of a model near the truth. Of repeats only its shape is used.
    prior : whether the random effects have the priors above, which count as prior_trials repeats and are all there is without repeats. A
        diagnosis needs them, lest a change of the gain pass for an effect; an interval that is to cover the truth as often as it says
        counts what these data show, and nothing else.
    from_residual : a channel without repeats has the noise that the residual of `predicted` shows, whatever the model lacks in it, each
        recording of enough samples its own; beside repeats, a recording of a condition without has theirs, or what its second differences
        show, where that is more. Else the size of a channel without repeats is that of the second differences of each recording, which are
        next to free of what a model lacks, and how it goes on from sample to sample is told where the residual is calm.
    """
    residual = prediction.measured - predicted
    groups: dict[tuple[str, str], list[int]] = {}
    for place, segment in enumerate(prediction.segments):
        groups.setdefault((segment.channel, segment.condition), []).append(place)
    recorded = tuple(dict.fromkeys(s.channel for s in prediction.segments if s.trial >= 0))
    sizes = np.full(len(prediction.segments), np.nan)
    filters, spread, degrees, irregulars = dict[str, FloatArray](), dict[str, FloatArray](), dict[str, int](), dict[str, Irregularity]()
    for channel in recorded:
        own = {
            condition: [place for place in places if prediction.segments[place].trial >= 0]
            for (name, condition), places in groups.items()
            if name == channel
        }
        left, shown, slopes, degrees[channel] = (
            dict[int, FloatArray](),
            dict[int, FloatArray](),
            list[tuple[FloatArray, FloatArray, float]](),
            0,
        )
        for places in own.values():
            trials = [prediction.experiment.trials[prediction.segments[place].trial] for place in places]
            for group in comparable(trials, CONSTANTS.shortest_repeat):
                alike = [(places[each], at) for each, at in group]
                rows = np.array([residual[prediction.segments[place].at][at] for place, at in alike])
                rows = (rows - rows.mean(axis=0)) * np.sqrt(len(alike) / (len(alike) - 1))
                together = np.array([predicted[prediction.segments[place].at][at] for place, at in alike])
                degrees[channel] += len(alike) - 1
                for (place, at), row in zip(alike, rows, strict=True):
                    segment = prediction.segments[place]
                    basis, shown[place] = _basis(prediction, segment, predicted)[at], predicted[segment.at][at]
                    coefficients, calm = random_effects(basis, row, together)
                    slopes.append((coefficients, basis[calm], (len(alike) - 1) / len(alike)))  # R repeats have R - 1 differences
                    fewer = np.sqrt(row.size / (row.size - BETWEEN))  # numbers than samples, once these were fitted
                    left[place] = without_jumps(fewer * (row - basis @ coefficients), together)
        rows_of = {place: residual[prediction.segments[place].at] for places in own.values() for place in places}
        steps = [_step(prediction, place) for place in left]
        conditions = [prediction.segments[place].condition for place in left]
        irregulars[channel] = irregular(list(left.values()), steps, [shown[place] for place in left], conditions)
        if left:
            filters[channel] = _of_repeats(left, own.values(), sizes)
            if from_residual:
                for place in _single(left, own.values()):
                    sizes[place] = max(sizes[place], _size_where_calm(prediction, predicted, place, filters[channel], rows_of[place]))
        else:
            filters[channel] = _unrepeated(prediction, predicted, rows_of, sizes, from_residual)
        _stated(prediction, channel, filters[channel], sizes)
        spread[channel] = _spread(prediction, channel, predicted, slopes, filters[channel], sizes, prior)
    _means(prediction, residual, sizes, from_residual)
    floor = 1e-9 * float(np.sqrt(np.mean(prediction.measured**2))) + 1e-300
    return Noise(filters, np.maximum(sizes, floor), spread, degrees, irregulars)


def repeat_deviations(prediction: Prediction) -> dict[str, list[FloatArray]]:
    """Deviations of repeats of one motion from their mean, channel by channel, scaled to the sd of one of them: with all that differs."""
    deviations: dict[str, list[FloatArray]] = {}
    for channel, table in repeats(prediction, prediction.measured - prediction.own_start):
        deviations.setdefault(channel, []).extend((table - table.mean(axis=0)) * np.sqrt(len(table) / (len(table) - 1)))
    return deviations


def repeats(prediction: Prediction, row: FloatArray) -> list[tuple[str, FloatArray]]:
    """Of a long vector (N,) what recordings of one motion have: a channel and a table (R, n) for each motion that was repeated, of the
    samples that all R of them have."""
    segments = {(segment.trial, segment.channel): segment for segment in prediction.segments if segment.trial >= 0}
    trials, tables = prediction.experiment.trials, list[tuple[str, FloatArray]]()
    for condition in dict.fromkeys(trial.condition for trial in trials):
        places = [place for place, trial in enumerate(trials) if trial.condition == condition]
        for group in comparable([trials[place] for place in places]):
            for channel in dict.fromkeys(channel for _, channel in segments):
                own = [(segments[places[each], channel], at) for each, at in group if (places[each], channel) in segments]
                if len(own) > 1:
                    tables.append((channel, np.array([row[segment.at][at] for segment, at in own])))
    return tables


def repeatability(prediction: Prediction) -> dict[str, float]:
    """Standard deviation of one recording of a condition about the mean of all, noise and random effects together [unit of the channel];
    of the channels that were recorded more than once. A recording whose owner stated its noise counts with that."""
    level, stated = dict[str, float](), stated_sd(prediction)
    for channel, rows in repeat_deviations(prediction).items():
        own = [stated[s.at] for s in prediction.segments if s.channel == channel and s.trial >= 0]
        known = np.concatenate([np.zeros(0), *(sd[np.isfinite(sd)] for sd in own)])  # of recordings without repeats
        level[channel] = float(np.sqrt(np.mean(np.concatenate([*rows, known]) ** 2)))
    return {channel: sd for channel, sd in level.items() if sd > 0}


def noise_level(prediction: Prediction, residual: FloatArray) -> dict[str, float]:
    """Standard deviation of a sample as repeats show it (`repeatability`), by channel. A recording of a condition without repeats counts
    with what the second differences of its residual (N,), calculated less measured, show, where that is more."""
    level, trials = repeatability(prediction), prediction.experiment.trials
    by_condition = {c: [trial for trial in trials if trial.condition == c] for c in dict.fromkeys(trial.condition for trial in trials)}
    single = {condition for condition, own in by_condition.items() if not comparable(own)}
    if not level or not single:
        return level
    predicted = prediction.measured + residual
    noise, stated = estimate_noise(prediction, predicted, prior=False, from_residual=True), stated_sd(prediction)
    for channel, sd in level.items():
        growth = float(np.sqrt(np.sum(impulse_response(noise.filters[channel]) ** 2)))
        squares = np.full(prediction.measured.size, sd**2)
        for place, segment in enumerate(prediction.segments):
            if segment.channel == channel and segment.trial >= 0 and segment.condition in single and np.isnan(stated[segment.at][0]):
                row = residual[segment.at]
                own = growth * _size_where_calm(prediction, predicted, place, noise.filters[channel], row)
                squares[segment.at] = max(sd, own) ** 2
        level[channel] = float(np.sqrt(np.mean(squares[prediction.places(channel)])))
    return level


def stated_sd(prediction: Prediction) -> FloatArray:
    """Standard deviations that came with means and of samples, (N,); nan where none did."""
    sd, means, rows = np.full(prediction.measured.size, np.nan), prediction.experiment.means, dict[str, int]()
    for segment in prediction.segments:
        if segment.trial >= 0:
            sd[segment.at] = prediction.experiment.trials[segment.trial].noise_sd.get(segment.channel, np.nan)
        elif means is not None:
            row = rows[segment.channel] = rows.get(segment.channel, -1) + 1
            if segment.channel in means.sd:
                sd[segment.at] = means.sd[segment.channel][row] or np.nan
    return sd


def without_jumps(row: FloatArray, predicted: FloatArray) -> FloatArray:
    """What a repeat does not share with others (n,), with lines drawn across the jumps of their predictions (n,) or (repeats, n): there a
    clock that differs leaves what is no noise, and comes back in every cycle."""
    unsure = _beside_jumps(row, predicted)
    unsure[[0, -1]] = False
    places = np.arange(row.size)
    return np.where(unsure, np.interp(places, places[~unsure], row[~unsure]), row)


def _beside_jumps(row: FloatArray, predicted: FloatArray) -> BoolArray:
    steepest = np.max([bends(each) for each in np.atleast_2d(predicted)], axis=0)  # one that jumps a sample later jumps in the row, too
    beside: BoolArray = CONSTANTS.bend_error * steepest > robust_sd(row)
    return beside


def random_effects(basis: FloatArray, row: FloatArray, predicted: FloatArray) -> tuple[FloatArray, BoolArray]:
    """What a repeat has of each random effect (BETWEEN,), and the samples that tell so: not those beside jumps, where a clock that differs
    by a part of a sample leaves what is as large as the jump, and neither gain nor zero. predicted : of it, or of each repeat, (n,)."""
    scale, calm = _scale(basis), np.ones(row.size, dtype=bool)
    coefficients = np.zeros(BETWEEN)
    for _ in range(3):  # once more for what the first look took for noise
        coefficients = np.linalg.lstsq(basis[calm] / scale, row[calm], rcond=CONSTANTS.least_told_apart)[0] / scale
        beside = _beside_jumps(row - basis @ coefficients, predicted)
        if row.size - np.sum(beside) < CONSTANTS.shortest_repeat or np.array_equal(calm, ~beside):
            break
        calm = ~beside
    return coefficients, calm


def _of_repeats(left: Mapping[int, FloatArray], conditions: Iterable[Sequence[int]], sizes: FloatArray) -> FloatArray:
    """The filter of a channel, and into `sizes` the innovations' sd in each condition, from what repeats do not share."""
    calm = {place: np.where(bursts(row), np.nan, without_lines(row)) for place, row in left.items()}
    filter_ = autoregression([np.nan_to_num(row) for row in calm.values()])
    for places in conditions:
        repeated = [place for place in places if place in left]
        shocks = np.concatenate([innovations(filter_, calm[place]) for place in repeated or left])
        sizes[places] = robust_sd(shocks[np.isfinite(shocks)])
    return filter_


def _unrepeated(
    prediction: Prediction, predicted: FloatArray, rows: Mapping[int, FloatArray], sizes: FloatArray, from_residual: bool
) -> FloatArray:
    """The filter of a channel that nothing was recorded twice of, and into `sizes` the innovations' sd of each recording."""
    if from_residual:
        filter_ = autoregression(list(rows.values()))
        sizes[list(rows)] = innovation_sd(filter_, list(rows.values()))
        for place, row in rows.items():
            if row.size >= CONSTANTS.samples_of_own_noise:
                sizes[place] = innovation_sd(filter_, [row])
        return filter_
    regular, calm = dict[int, FloatArray](), list[FloatArray]()
    for place, row in rows.items():
        samples = _cycle(prediction, place)
        fast = 0 < samples < CONSTANTS.windows_per_cycle * CONSTANTS.calm_window  # none of its windows is calm
        several = fast and CONSTANTS.fewest_cycles * samples <= row.size
        regular[place] = without_lines(without_synchronous_average(row, samples) if several else row)
        if several or not fast:
            calm.append(regular[place])
    told = autoregression_where_calm(calm)
    filter_ = WHITE if told is None else told
    for place, row in regular.items():
        sizes[place] = _size_where_calm(prediction, predicted, place, filter_, row)
    return filter_


def _size_where_calm(prediction: Prediction, predicted: FloatArray, place: int, filter_: FloatArray, row: FloatArray) -> float:
    """The innovations' sd in a residual (n,) of a recording, by its second differences; of very few samples their own sd."""
    if row.size <= 4:
        return float(np.std(row))
    return innovation_sd_where_calm(filter_, row, _beside_jumps(row, predicted[prediction.segments[place].at]))


def _single(left: Mapping[int, FloatArray], conditions: Iterable[Sequence[int]]) -> list[int]:
    """Places of the recordings in conditions of which nothing was recorded twice."""
    return [place for places in conditions if not any(each in left for each in places) for place in places]


def _cycle(prediction: Prediction, place: int) -> float:
    return cycle_samples(prediction, prediction.segments[place].trial)


def _stated(prediction: Prediction, channel: str, filter_: FloatArray, sizes: FloatArray) -> None:
    """Into `sizes` the innovations' sd of the recordings of a channel whose owner stated the noise of a sample."""
    growth = float(np.sqrt(np.sum(impulse_response(filter_) ** 2)))
    for place, segment in enumerate(prediction.segments):
        if segment.channel == channel and segment.trial >= 0:
            sd = prediction.experiment.trials[segment.trial].noise_sd.get(channel)
            sizes[place] = sizes[place] if sd is None else sd / growth


def _step(prediction: Prediction, place: int) -> float:
    return prediction.experiment.trials[prediction.segments[place].trial].sampling_interval


def _basis(prediction: Prediction, segment: Segment, predicted: FloatArray) -> FloatArray:
    return differing(predicted[segment.at], prediction.experiment.trials[segment.trial].times)


def _scale(basis: FloatArray) -> FloatArray:
    scale: FloatArray = np.maximum(np.sqrt(np.mean(basis**2, axis=0)), CONSTANTS.no_signal)
    return scale


def _spread(
    prediction: Prediction,
    channel: str,
    predicted: FloatArray,
    slopes: Sequence[tuple[FloatArray, FloatArray, float]],
    filter_: FloatArray,
    sizes: FloatArray,
    prior: bool,
) -> FloatArray:
    """Standard deviations of the random effects, (BETWEEN,): the variance of their estimates less what noise alone gives these."""
    own = [place for place, segment in enumerate(prediction.segments) if segment.channel == channel and segment.trial >= 0]
    level = float(np.sqrt(np.mean(np.concatenate([predicted[prediction.segments[place].at] for place in own]) ** 2)))
    usual = np.array([CONSTANTS.prior_trial_gain, CONSTANTS.prior_trial_zero * level, CONSTANTS.prior_trial_clock])
    size = float(np.median(sizes[own]))
    excess, weight = np.zeros(BETWEEN), np.zeros(BETWEEN)
    for coefficients, basis, share in slopes:
        white = np.column_stack([innovations(filter_, column) for column in basis.T]) / size
        errors = np.where(_scale(white) > CONSTANTS.no_signal, _variances(basis, white), np.inf)
        # A clock cannot be read off a force that stands still: what seems to be one there is what noise alone gives.
        known = (errors < 100 * usual**2) | (coefficients**2 > CONSTANTS.clear_difference**2 * errors)
        # What together make up a drift of one repeat beside another are none of the three.
        known &= np.all(np.abs(coefficients[errors < np.inf]) <= CONSTANTS.largest_difference * usual[errors < np.inf])
        beyond = coefficients**2 - errors
        excess += share * np.where(known, np.maximum(beyond, 0.0) if prior else beyond, 0.0)
        weight += share * known
    if prior:
        excess, weight = excess + CONSTANTS.prior_trials * usual**2, weight + CONSTANTS.prior_trials
    spread: FloatArray = np.sqrt(np.maximum(excess, 0.0) / np.maximum(weight, 1.0))
    return spread


def _variances(basis: FloatArray, white: FloatArray) -> FloatArray:
    """Of coefficients that least squares tell, (BETWEEN,): in the directions that are told apart by `basis`, and in none but these.

    white : (n, BETWEEN), the basis in the noise's innovations, where one that is not told apart there may look as if it were.
    """
    scale = _scale(basis)
    _, singular, directions = np.linalg.svd(basis / scale, full_matrices=False)
    told = directions[singular > CONSTANTS.least_told_apart * singular[0]].T
    normal = told.T @ ((white / scale).T @ (white / scale)) @ told
    variances: FloatArray = np.diag(told @ np.linalg.pinv(normal, hermitian=True) @ told.T) / scale**2
    return variances


def _means(prediction: Prediction, residual: FloatArray, sizes: FloatArray, from_residual: bool) -> None:
    means, stated, of_channel = prediction.experiment.means, stated_sd(prediction), dict[str, float]()
    for place, segment in enumerate(prediction.segments):
        if segment.trial >= 0 or means is None:
            continue
        level = float(np.sqrt(np.mean(means.outputs[segment.channel] ** 2)))
        sd = float(stated[segment.at][0])
        if np.isfinite(sd):  # not of a single measurement, to which 0 is written
            sizes[place] = max(sd, 1e-6 * level)
            continue
        if segment.channel not in of_channel:
            alike = [s.at for s in prediction.segments if s.trial < 0 and s.channel == segment.channel]
            of_channel[segment.channel] = _mean_sd(means, segment.channel, np.concatenate([residual[at] for at in alike]), from_residual)
        sizes[place] = of_channel[segment.channel]


def _mean_sd(means: Means, channel: str, residual: FloatArray, from_residual: bool) -> float:
    """Of a channel of means (rows,) that came without: from replicates, counted as prior_trials more of what is usual."""
    sd, degrees = replicate_sd(means.conditions, means.outputs[channel])
    level = float(np.sqrt(np.mean(means.outputs[channel] ** 2)))
    if from_residual:
        return sd if sd > 0 else float(np.sqrt(np.mean(residual**2)))  # of replicates that read alike, too
    if degrees:
        return float(
            np.sqrt(
                (degrees * sd**2 + CONSTANTS.prior_trials * (CONSTANTS.usual_noise_of_means * level) ** 2)
                / (degrees + CONSTANTS.prior_trials)
            )
        )
    values = np.column_stack(list(means.values.values())) if means.values else np.zeros((residual.size, 1))
    return level * nugget(values, residual / level) if level > 0 else 0.0
