"""What may be wrong where a record of a given motion begins and ends?

How bristles were bent before is a nuisance of each trial, whose course is that of one model: where other parameters or an effect let it
die away faster, it is as wrong as they differ. And a clock that is off shows, at the ends, what moved before and after, which nobody
recorded. Either takes a few samples, and is many times the noise: a break-away from rest is the steepest that friction has.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import xlogy

from evat.constants import CONSTANTS
from evat.inference.prediction import Prediction, Segment
from evat.model import FloatArray


def unsure_ends(prediction: Prediction, segment: Segment, predicted: FloatArray) -> FloatArray:
    """Standard deviation of it in each sample of a segment (L,), [unit of the channel]; predicted : (L,), near the truth."""
    changed = np.abs(prediction.bent[segment.at])
    # c = c_0 exp(-rate x), size and rate wrong by a share each: c (1 + rate x), and rate x is log(c_0 / c)
    unsure: FloatArray = CONSTANTS.unsure_start * (changed - xlogy(changed, changed / max(float(np.max(changed)), 1e-300)))
    if segment.trial < 0 or not prediction.experiment.trials[segment.trial].inputs or predicted.size < 2:
        return unsure
    step = float(np.median(np.diff(prediction.experiment.trials[segment.trial].times)))
    shift = prediction.setup.widest_clock(segment.channel) / step  # samples
    reached = min(math.ceil(shift), predicted.size // CONSTANTS.least_samples_per_end)
    change = np.abs(np.diff(predicted))
    for end in (slice(None, reached), slice(predicted.size - reached, None)):
        unsure[end] = np.hypot(unsure[end], shift * np.max(change[end], initial=0.0))
    return unsure
