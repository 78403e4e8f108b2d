"""Does a trial repeat itself, and after how many samples? From the model's own cycle, or from the inputs."""

from __future__ import annotations

import math

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.prediction import Prediction
from evat.model import FloatArray


def cycle_time(prediction: Prediction, place: int) -> float:
    """Period [s] of the motion in a trial; nan where it has none, or fewer than two."""
    trial = prediction.experiment.trials[place]
    own = prediction.model.cycle_time({**prediction.nominal, **trial.values})
    if math.isfinite(own):
        return own
    step = float(np.median(np.diff(trial.times)))
    columns = [column - column.mean() for column in trial.inputs.values() if np.ptp(column) > 0]
    if not columns or trial.times.size < 16:
        return math.nan
    lag = max(_period(column) for column in columns)
    return lag * step if lag > 0 else math.nan


def cycle_samples(prediction: Prediction, place: int) -> float:
    """The same in samples; 0 where there is none."""
    trial = prediction.experiment.trials[place]
    period = cycle_time(prediction, place)
    if not math.isfinite(period) or trial.times.size < 16:
        return 0.0
    samples = period / float(np.median(np.diff(trial.times)))
    return samples if 2 < samples <= trial.times.size / 1.5 else 0.0


def _period(column: FloatArray) -> float:
    """Lag in samples at which a column comes back, 0 where it never does; from the mean square of differences at each lag."""
    size = column.size
    most = size * 2 // 3
    squares = np.concatenate([[0.0], np.cumsum(column**2)])
    spectrum = np.fft.rfft(column, 2 * size)
    products = np.fft.irfft(np.abs(spectrum) ** 2)[: most + 1]
    lags = np.arange(most + 1)
    apart = (squares[size - lags] + squares[size] - squares[lags] - 2 * products) / (size - lags)
    level = squares[size] / size
    away = np.flatnonzero(apart > 0.2 * level)
    if away.size == 0:
        return 0.0
    lows = [n for n in range(int(away[0]) + 1, most) if apart[n] <= apart[n - 1] and apart[n] <= apart[n + 1] and apart[n] < 0.05 * level]
    for n in lows:
        before, here, after = apart[n - 1 : n + 2]
        bend = before - 2 * here + after
        shift = 0.5 * (before - after) / bend if bend > 0 else 0.0
        if here - 0.25 * (before - after) * shift < CONSTANTS.alike_cycles * level + 0.02 * bend:
            return float(n + shift)
    return 0.0
