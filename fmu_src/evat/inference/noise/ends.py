"""What may be wrong where a record begins and ends?

How bristles were bent before is a nuisance of each trial, whose course is that of one model: other parameters or an effect let it die
away faster or slower, which is a nuisance, too. And a clock that is off shows, at the ends, what moved before and after, which nobody
recorded. Either takes a few samples, and is many times the noise: a break-away from rest is the steepest that friction has, and where
forces jump, as the tool enters the work and leaves it, one such jump may be just beyond.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import xlogy

from evat.constants import CONSTANTS
from evat.inference.prediction import Prediction, Segment
from evat.model import FloatArray


def dying_away(prediction: Prediction, segment: Segment) -> FloatArray:
    """What differs in a segment by how an unknown start dies away, (L, 2): as it is, and faster, by a standard deviation of that rate.

    c = c_0 exp(-rate x) at another rate: c rate x = -c log(c / c_0).
    """
    changed = prediction.bent[segment.at]
    size = np.abs(changed)
    faster = np.sign(changed) * xlogy(size, size / max(float(np.max(size)), 1e-300))
    return np.column_stack([changed, CONSTANTS.rate_of_start * faster])


def unsure_ends(prediction: Prediction, segment: Segment, predicted: FloatArray) -> FloatArray:
    """Standard deviation in each sample of a segment (L,) of what a clock brings in, [unit of the channel]; predicted : (L,), near the
    truth."""
    unsure = np.zeros_like(predicted)
    trial = prediction.experiment.trials[segment.trial] if segment.trial >= 0 else None
    if trial is None or predicted.size < 2:
        return unsure
    shift = prediction.setup.widest_clock(segment.channel) / trial.sampling_interval  # samples
    reached = min(math.ceil(shift), predicted.size // CONSTANTS.least_samples_per_end)
    change = np.abs(np.diff(predicted))
    for end in (slice(None, reached), slice(-reached, None)) if reached else ():
        unsure[end] = np.max(change) if prediction.jumps else shift * np.max(change[end])
    return unsure
