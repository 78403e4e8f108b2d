"""Does a trial repeat itself, and after how many samples? From the model's own cycle, or from the inputs."""

from __future__ import annotations

import math

import numpy as np

from evat.experiment.periods import period
from evat.inference.prediction import Prediction


def cycle_time(prediction: Prediction, place: int) -> float:
    """Period [s] of the motion in a trial; nan where it has none, or fewer than two."""
    trial = prediction.experiment.trials[place]
    own = prediction.model.cycle_time({**prediction.nominal, **trial.values})
    if math.isfinite(own):
        return own
    step = trial.sampling_interval
    columns = [column - column.mean() for column in trial.inputs.values() if np.ptp(column) > 0]
    if not columns or trial.times.size < 16:
        return math.nan
    lag = max(period(column) for column in columns)
    return lag * step if lag > 0 else math.nan


def cycle_samples(prediction: Prediction, place: int) -> float:
    """The same in samples; 0 where there is none."""
    trial = prediction.experiment.trials[place]
    cycle = cycle_time(prediction, place)
    if not math.isfinite(cycle) or trial.times.size < 16:
        return 0.0
    samples = cycle / trial.sampling_interval
    return samples if 2 < samples <= trial.times.size / 1.5 else 0.0
