"""How noisy is a mean for which nobody stated it? From means of one condition where there are several, else from how smoothly they vary.

What a model lacks varies smoothly from condition to condition, noise does not: in a Gaussian process over the conditions noise is the
nugget (Rasmussen and Williams 2006, section 2.3). It is integrated over its prior, which few means leave as it was.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.model import FloatArray


def replicate_sd(conditions: Sequence[str], column: FloatArray) -> tuple[float, int]:
    """Standard deviation of one mean (rows,) about others of its condition, pooled, and its degrees of freedom; nan and 0 without
    replicates. 0 where all replicates read alike, as on a display of few digits: these tell no noise."""
    total, degrees = between_replicates(conditions, column)
    return (float(np.sqrt(total / degrees)), degrees) if degrees else (float("nan"), 0)


def between_replicates(conditions: Sequence[str], column: FloatArray) -> tuple[float, int]:
    """The squares of what means (rows,) differ by from the mean of their condition, added up, and their degrees of freedom."""
    total, degrees = 0.0, 0
    for condition in dict.fromkeys(conditions):
        own = column[[each == condition for each in conditions]]
        apart = own - own[0]  # just 0 where they read alike, which the mean of three may round
        total += float(np.sum((apart - apart.mean()) ** 2))
        degrees += own.size - 1
    return total, degrees


def nugget(conditions: FloatArray, residual: FloatArray) -> float:
    """Standard deviation of the noise in `residual` (rows,) [rms of the channel] over `conditions` (rows, d), as its posterior median."""
    apart = _distances(conditions)
    rows = residual.size
    sizes = np.geomspace(*CONSTANTS.smooth_size_range, CONSTANTS.smooth_sizes)
    lengths = np.geomspace(*CONSTANTS.smooth_length_range, CONSTANTS.smooth_lengths)
    nuggets = np.geomspace(*CONSTANTS.nugget_range, CONSTANTS.nuggets)
    prior = -0.5 * (np.log(nuggets / CONSTANTS.usual_noise_of_means) / CONSTANTS.noise_of_means_sd) ** 2
    logs = np.full((sizes.size, lengths.size, nuggets.size), -np.inf)
    for place, length in enumerate(lengths):
        smooth = np.exp(-0.5 * apart / length**2)
        for row, size in enumerate(sizes):
            values, vectors = np.linalg.eigh(size**2 * (smooth + 1.0))  # with a mean of its own
            turned = vectors.T @ residual
            variance = np.maximum(values, 0.0)[:, None] + nuggets**2
            logs[row, place] = -0.5 * (np.log(variance).sum(axis=0) + (turned[:, None] ** 2 / variance).sum(axis=0)) + prior
    weights = np.exp(logs - logs.max()).sum(axis=(0, 1)) if rows else np.exp(prior)
    below = np.cumsum(weights) / weights.sum()
    return float(np.exp(np.interp(0.5, below, np.log(nuggets))))


def _distances(conditions: FloatArray) -> FloatArray:
    """Squared distances (rows, rows), each condition in its range."""
    total = np.zeros((len(conditions), len(conditions)))
    for values in conditions.T:
        column = np.log(values) if values.min() > 0 and values.max() / values.min() > CONSTANTS.logarithmic_range else values
        reach = float(np.ptp(column))
        if reach > 0:
            total += np.subtract.outer(column, column) ** 2 / reach**2
    return total
