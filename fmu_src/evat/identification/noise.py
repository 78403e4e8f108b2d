"""How does the noise go on from sample to sample? An autoregression per channel, by which residual and slopes are whitened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from evat.inference.prediction import Prediction
from evat.model import FloatArray

MOST = 6  # order
SHORTEST = 20  # samples per coefficient; a shorter segment is left as it is
Colour = Mapping[str, FloatArray]  # channel -> 1, -a1, -a2, ...: the filter that whitens


def colour(rows: Sequence[FloatArray]) -> FloatArray:
    """The whitening filter of noise that these rows are samples of; [1] where it is white. Yule-Walker, order by Bayes' criterion."""
    rows = [row for row in rows if row.size >= SHORTEST]
    count = sum(row.size for row in rows)
    most = min(MOST, count // SHORTEST)
    if not rows or not most:
        return np.ones(1)
    power = [sum(float(np.sum(row[lag:] * row[: row.size - lag])) for row in rows) / count for lag in range(most + 1)]
    if power[0] <= 0:
        return np.ones(1)
    best, least = np.ones(1), count * np.log(power[0])
    for order in range(1, most + 1):
        a = solve_toeplitz(power[:order], power[1 : order + 1])
        left = power[0] - float(np.dot(a, power[1 : order + 1]))
        if left <= 0:
            break
        score = count * np.log(left) + order * np.log(count)
        if score < least:
            best, least = np.concatenate([[1.0], -a]), score
    return best


def rows_of(prediction: Prediction, residual: FloatArray) -> dict[str, list[FloatArray]]:
    """A residual, channel by channel, a row per recording; means have no neighbours and are left out."""
    found: dict[str, list[FloatArray]] = {}
    for segment in prediction.segments:
        if segment.trial >= 0:
            found.setdefault(segment.channel, []).append(residual[segment.at])
    return found


def whitened(prediction: Prediction, colours: Colour, columns: FloatArray) -> FloatArray:
    """A residual (N,) or slopes (N, p) through the whitening filters. The first samples of a recording, whose past is unknown, are dropped
    (zero)."""
    found = np.array(columns, dtype=np.float64)
    for segment in prediction.segments:
        taps = colours.get(segment.channel, np.ones(1))
        length = segment.at.stop - segment.at.start
        if taps.size > 1 and segment.trial >= 0 and length >= SHORTEST * taps.size:
            found[segment.at] = lfilter(taps, [1.0], found[segment.at], axis=0)
            found[segment.at.start : segment.at.start + taps.size - 1] = 0.0
    return found


def coloured(prediction: Prediction, colours: Colour, columns: FloatArray) -> FloatArray:
    """Slopes J (N, p) as A J with A A' the correlation of the noise up to a factor: (A J)'(A J) = J' correlation J."""
    found = np.array(columns, dtype=np.float64)
    for segment in prediction.segments:
        taps = colours.get(segment.channel, np.ones(1))
        if taps.size > 1 and segment.trial >= 0:
            found[segment.at] = lfilter([1.0], taps, found[segment.at][::-1], axis=0)[::-1]
    return found


def follows_itself(rows: Sequence[FloatArray]) -> float:
    """Correlation of neighbouring samples: 0 for white noise, near 1 where the model misses something slow."""
    above = sum(float(np.sum(row[1:] * row[:-1])) for row in rows)
    below = sum(float(np.sum(row * row)) for row in rows)
    return above / below if below > 0 else 0.0
