"""How far apart are two recordings of the same thing? Noise within a trial, and what changes from trial to trial.

Within a trial noise is autoregressive; its shape belongs to the channel, its size to channel and condition. From trial to trial gain, zero
and clock differ; their spread belongs to the channel. Both are read off the differences between repeats, which no model error can enter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.inference.bursts_and_lines import Irregular, bursts, irregular
from evat.inference.discontinuities import SHARPNESS, bends
from evat.inference.prediction import Prediction
from evat.model import FloatArray

MOST_LAGS = 6
CLIP = 4.0  # robust standard deviations, beyond which a sample counts as no more than that
PRIOR_TRIALS = 2.0  # what the priors below weigh, in repeats
PRIOR_GAIN, PRIOR_OFFSET, PRIOR_DELAY = 0.003, 0.003, 0.1  # spread: of the gain, of the zero in rms, of the clock in samples
MEANS_SD = 0.03  # of a mean that nobody has repeated or given a standard deviation for
NO_SIGNAL = 1e-100
WHITE = np.array([1.0])


@dataclass(frozen=True)
class Noise:
    """What repeats say. `filters[channel]` turns noise into innovations; `sizes[place]` is their sd in each segment [unit of the channel].

    `spread[channel]` are standard deviations from trial to trial of gain [1], zero [unit of the channel] and clock [s];
    `irregular[channel]` tells what repeats do not share and is no noise.
    """

    filters: Mapping[str, FloatArray]
    sizes: FloatArray
    spread: Mapping[str, FloatArray]
    repeated: bool
    irregular: Mapping[str, Irregular]


def impulse_response(filter_: FloatArray, length: int = 400) -> FloatArray:
    """What the inverse of an autoregressive filter answers to one innovation."""
    found = np.zeros(length)
    found[0] = 1.0
    for n in range(1, length):
        past = found[max(0, n - filter_.size + 1) : n][::-1]
        found[n] = -float(filter_[1 : past.size + 1] @ past)
    return found


def differing(predicted: FloatArray, times: FloatArray) -> FloatArray:
    """How gain, zero and clock of a trial show in it: (n, 3)."""
    slope = np.gradient(predicted, times) if predicted.size > 1 else np.zeros_like(predicted)
    return np.column_stack([predicted, np.ones_like(predicted), -slope])


def estimate_noise(prediction: Prediction, predicted: FloatArray) -> Noise:
    """From repeats where there are any; else from the second differences of each recording, with no more than priors from trial to trial.

    predicted : (N,), of a model near the truth; only its shape is used.
    """
    residual = prediction.measured - predicted
    groups: dict[tuple[str, str], list[int]] = {}
    for place, segment in enumerate(prediction.segments):
        groups.setdefault((segment.channel, segment.condition), []).append(place)
    recorded = tuple(dict.fromkeys(s.channel for s in prediction.segments if s.trial >= 0))
    sizes = np.full(len(prediction.segments), np.nan)
    filters, spread, repeated, comes = dict[str, FloatArray](), dict[str, FloatArray](), False, dict[str, Irregular]()
    for channel in recorded:
        own = {condition: places for (name, condition), places in groups.items() if name == channel}
        left, slopes = dict[int, FloatArray](), list[tuple[FloatArray, FloatArray]]()
        for places in own.values():
            for alike in _same_length(prediction, places):
                rows = np.array([residual[prediction.segments[place].at] for place in alike])
                rows = (rows - rows.mean(axis=0)) * np.sqrt(len(alike) / (len(alike) - 1))
                for place, row in zip(alike, rows, strict=True):
                    basis = _basis(prediction, predicted, place)
                    coefficients, *_ = np.linalg.lstsq(basis / _scale(basis), row, rcond=None)
                    slopes.append((coefficients / _scale(basis), basis))
                    left[place] = without_jumps(row - basis / _scale(basis) @ coefficients, predicted[prediction.segments[place].at])
        repeated = repeated or bool(left)
        comes[channel] = irregular(list(left.values()), [_step(prediction, place) for place in left])
        calm = {place: np.where(bursts(row), np.nan, row) for place, row in left.items()}
        filters[channel] = _autoregression([np.nan_to_num(row) for row in calm.values()]) if calm else WHITE
        for places in own.values():
            with_repeats = [place for place in places if place in left]
            if left:
                innovations = np.concatenate([_filtered(filters[channel], calm[place]) for place in with_repeats or left])
                sizes[places] = _robust_sd(innovations[np.isfinite(innovations)])
            else:
                for place in places:
                    row = residual[prediction.segments[place].at]
                    sizes[place] = _robust_sd(np.diff(row, 2)) / np.sqrt(6) if row.size > 4 else np.std(row)
        spread[channel] = _spread(prediction, channel, predicted, slopes, filters[channel], sizes)
    _means(prediction, groups, sizes)
    floor = 1e-9 * float(np.sqrt(np.mean(prediction.measured**2))) + 1e-300
    return Noise(filters, np.maximum(sizes, floor), spread, repeated, comes)


def without_jumps(row: FloatArray, predicted: FloatArray) -> FloatArray:
    """What repeats do not share, with lines drawn across the jumps of the prediction: there a clock that differs leaves what is no noise,
    and comes back in every cycle."""
    unsure = SHARPNESS * bends(predicted) > _robust_sd(row)
    unsure[[0, -1]] = False
    places = np.arange(row.size)
    return np.where(unsure, np.interp(places, places[~unsure], row[~unsure]), row)


def _step(prediction: Prediction, place: int) -> float:
    return float(np.median(np.diff(prediction.experiment.trials[prediction.segments[place].trial].times)))


def _same_length(prediction: Prediction, places: Sequence[int]) -> list[list[int]]:
    """Repeats that can be compared sample by sample."""
    by_length: dict[int, list[int]] = {}
    for place in places:
        at = prediction.segments[place].at
        by_length.setdefault(at.stop - at.start, []).append(place)
    return [some for length, some in by_length.items() if len(some) > 1 and length > 20]


def _basis(prediction: Prediction, predicted: FloatArray, place: int) -> FloatArray:
    segment = prediction.segments[place]
    return differing(predicted[segment.at], prediction.experiment.trials[segment.trial].times)


def _scale(basis: FloatArray) -> FloatArray:
    scale: FloatArray = np.sqrt(np.mean(basis**2, axis=0)) + 1e-300
    return scale


def _filtered(filter_: FloatArray, row: FloatArray) -> FloatArray:
    return np.convolve(row, filter_, mode="valid")


def _robust_sd(row: FloatArray) -> float:
    """Median absolute deviation as a standard deviation, or that of the clipped row where it is larger (heavy tails)."""
    middle = 1.4826 * float(np.median(np.abs(row)))
    return float(np.sqrt(np.mean(np.clip(row, -CLIP * middle, CLIP * middle) ** 2))) if middle > 0 else float(np.std(row))


def _autoregression(rows: Sequence[FloatArray]) -> FloatArray:
    """Coefficients (1, a_1, ...) of the order that Schwarz's criterion prefers, from pooled autocovariances of clipped rows."""
    covariance, count = np.zeros(MOST_LAGS + 1), 0
    for row in rows:
        limit = CLIP * max(_robust_sd(row), 1e-300)
        clipped = np.clip(row, -limit, limit)
        for lag in range(MOST_LAGS + 1):
            covariance[lag] += float(clipped[lag:] @ clipped[: clipped.size - lag])
        count += row.size
    if covariance[0] <= 0:
        return WHITE
    best, found = np.inf, WHITE
    for order in range(MOST_LAGS + 1):
        matrix = covariance[np.abs(np.subtract.outer(np.arange(order), np.arange(order)))]
        weights = np.linalg.solve(matrix + 1e-9 * covariance[0] * np.eye(order), covariance[1 : order + 1]) if order else np.empty(0)
        variance = max(covariance[0] - float(weights @ covariance[1 : order + 1]), 1e-12 * covariance[0])
        score = count * np.log(variance) + order * np.log(count)
        if score < best:
            best, found = score, np.concatenate([[1.0], -weights])
    return found


def _spread(
    prediction: Prediction,
    channel: str,
    predicted: FloatArray,
    slopes: Sequence[tuple[FloatArray, FloatArray]],
    filter_: FloatArray,
    sizes: FloatArray,
) -> FloatArray:
    """Standard deviations of gain, zero and clock from trial to trial, beyond what noise alone would show."""
    own = [place for place, segment in enumerate(prediction.segments) if segment.channel == channel]
    level = float(np.sqrt(np.mean(np.concatenate([predicted[prediction.segments[place].at] for place in own]) ** 2)))
    steps = [_step(prediction, place) for place in own]
    prior = np.array([PRIOR_GAIN, PRIOR_OFFSET * level, PRIOR_DELAY * float(np.median(steps))])
    size = float(np.median(sizes[own]))
    total, weight = PRIOR_TRIALS * prior**2, np.full(3, PRIOR_TRIALS)
    for coefficients, basis in slopes:
        white = np.column_stack([_filtered(filter_, column) for column in basis.T]) / size
        scale = _scale(white)
        normal = (white / scale).T @ (white / scale)
        errors = np.where(scale > NO_SIGNAL, np.diag(np.linalg.pinv(normal)) / np.maximum(scale, NO_SIGNAL) ** 2, np.inf)
        known = errors < 100 * prior**2 + coefficients**2  # a clock cannot be read off a force that stands still
        share = 0.5  # two repeats share one difference
        total += np.where(known, np.maximum(coefficients**2 - errors, 0.0) * share, 0.0)
        weight += np.where(known, share, 0.0)
    found: FloatArray = np.sqrt(total / weight)
    return found


def _means(prediction: Prediction, groups: Mapping[tuple[str, str], Sequence[int]], sizes: FloatArray) -> None:
    means = prediction.experiment.means
    if means is None:
        return
    seen: dict[str, int] = {}
    for place, segment in enumerate(prediction.segments):
        if segment.trial >= 0:
            continue
        row = seen.get(segment.channel, 0)
        seen[segment.channel] = row + 1
        column = means.outputs[segment.channel]
        if segment.channel in means.sd:
            sizes[place] = max(float(means.sd[segment.channel][row]), 1e-6 * float(np.sqrt(np.mean(column**2))))
        else:
            sizes[place] = MEANS_SD * float(np.sqrt(np.mean(column**2)))
