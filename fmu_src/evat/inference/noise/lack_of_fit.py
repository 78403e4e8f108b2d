"""Does a model miss something that noise does not explain, however little? What repeats share of a residual against what they do not.

The mean of repeats has as much less noise as they are many, and all of what the model misses: an analysis of variance (Fisher 1925), with
so many independent numbers as the noise has once its correlation is counted (Bartlett 1935).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import f, norm

from evat.experiment import Means
from evat.inference.noise.estimate import repeats
from evat.inference.noise.means import between_replicates
from evat.inference.prediction import Prediction
from evat.model import FloatArray


def lack_of_fit(prediction: Prediction, residual: FloatArray) -> dict[str, float]:
    """By channel, how many sd the mean square of what repeats share of a residual (N,) lies above what their noise leaves there; of the
    channels that have repeats."""
    by_channel: dict[str, list[FloatArray]] = {}
    for channel, table in repeats(prediction, residual):
        if table.shape[1] > 1 and np.any(table != table[0]):
            by_channel.setdefault(channel, []).append(table)
    excess = {channel: _of_repeats(tables) for channel, tables in by_channel.items()}
    if (means := prediction.experiment.means) is not None:
        for channel in means.outputs:
            at = np.concatenate([np.arange(s.at.start, s.at.stop) for s in prediction.segments if s.trial < 0 and s.channel == channel])
            if (sds := _of_replicates(means, residual[at])) is not None:
                excess[channel] = max(sds, excess.get(channel, -np.inf))
    return excess


def _of_repeats(tables: Sequence[FloatArray]) -> float:
    """Of motions whose repeats (R, n) differ: how unlikely the mean square of their means is beside that of their noise, in sd. How noise
    goes on from sample to sample is one for all; its size is that of each (degrees of freedom after Satterthwaite 1946)."""
    counts, repeats = np.array([table.shape[::-1] for table in tables]).T
    shared, noise, covariance = np.zeros(len(tables)), np.zeros(len(tables)), np.zeros(int(np.max(counts)))
    weights = counts * (repeats - 1) / float(counts @ (repeats - 1))
    for place, table in enumerate(tables):
        count, middle = counts[place], table.mean(axis=0)
        apart = table - middle
        shared[place], noise[place] = repeats[place] * float(np.sum(middle**2)), float(np.sum(apart**2)) / (repeats[place] - 1)
        spectrum = np.abs(np.fft.rfft(apart, 2 * count, axis=1)) ** 2
        own = np.fft.irfft(spectrum, 2 * count, axis=1)[:, :count].sum(axis=0)
        covariance[:count] += weights[place] * own / own[0]
    # The squares of what correlations white noise shows by chance add up to a half in one recording.
    chance = float(np.sum(weights**2 / (repeats - 1))) / 2
    alike = max(1 + 2 * (float(np.sum(covariance[1:] ** 2)) - chance), 1.0)
    numbers = [float(noise.sum() ** 2 / np.sum(noise**2 / counts / of) / alike) for of in (1, repeats - 1)]
    return _sd(float(f.sf(shared.sum() / noise.sum(), *numbers)))


def _sd(chance: float) -> float:
    """A chance as sd of a normal variable."""
    digits = np.finfo(np.float64)  # beyond these it is no number
    return float(norm.isf(np.clip(chance, digits.tiny, 1 - digits.eps)))


def _of_replicates(means: Means, residual: FloatArray) -> float | None:
    """The same of averages (rows,), which are few: by the chance of their F, as sd of a normal variable; None without replicates that
    differ."""
    conditions, shared = tuple(dict.fromkeys(means.conditions)), 0.0
    within, degrees = between_replicates(means.conditions, residual)
    for condition in conditions:
        own = residual[[each == condition for each in means.conditions]]
        shared += own.size * float(own.mean()) ** 2
    if not within > 0:
        return None
    return _sd(float(f.sf(shared / len(conditions) / (within / degrees), len(conditions), degrees)))
