"""Which single samples stand apart from their neighbours as noise does not?

A spark, a lost bit, a bump of the table: one of them weighs as much as a hundred samples in a sum of squares, and passes for a discrepancy
of the model. A sample that stands alone is as unsure as it is far off. Where a prediction jumps or is steep one may stand apart for its
time, as in a break-away; and what does so often is no accident, but a part of what goes on. But in the middle of a rise that takes two
samples, as where a tool enters the work, a part of a sample in time is as much, and comes back in every cycle.
"""

from __future__ import annotations

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.noise.autoregression import robust_sd
from evat.inference.noise.discontinuities import bends, rises
from evat.model import FloatArray


def unsure_outliers(residual: FloatArray, predicted: FloatArray) -> FloatArray:
    """How far each sample of a recording is off that stands alone, 0 for the others: (L,), as `residual` and `predicted` are."""
    unsure = np.zeros_like(residual)
    if residual.size < CONSTANTS.samples_to_see_an_outlier:
        return unsure
    apart = residual[2:-2] - np.array([residual[place : residual.size - 4 + place] for place in (0, 1, 3, 4)])  # from each neighbour
    off = np.where(np.all(apart > 0, axis=0) | np.all(apart < 0, axis=0), np.min(np.abs(apart), axis=0), 0.0)
    noise = robust_sd(np.diff(residual)) / np.sqrt(2)
    beside = np.convolve(CONSTANTS.bend_error * bends(predicted) > noise, np.ones(3), "same")[2:-2] > 0
    around = np.array([predicted[place : predicted.size - 4 + place] for place in range(5)])
    risen = (off > CONSTANTS.outlying_sample * noise) & (CONSTANTS.bend_error * rises(predicted)[2:-2] > noise)
    unsure[2:-2][risen] = off[risen]
    alone = (off > CONSTANTS.outlying_sample * noise) & (off > np.ptp(around, axis=0)) & ~beside
    if 0 < np.count_nonzero(alone) <= CONSTANTS.most_outliers * residual.size + 1:
        unsure[2:-2][alone] = off[alone]
    return unsure
