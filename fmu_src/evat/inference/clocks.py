"""How late is each channel beside a model that moves by itself?

Friction that reverses within a fraction of a sample shows a clock at its jumps only. No slope leads there: so clocks are tried, and the
runs sampled where the channels were; first beside nominal values, then, more finely, beside those of a fit, which follow as far as they do
linearly. Where the motion is an input, force and motion bend together, and slopes do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.fit import Fit
from evat.inference.parameters import Parameter
from evat.inference.prediction import Prediction
from evat.inference.setup.setup_errors import CLOCK, by_channel
from evat.model import FloatArray


def with_clocks(prediction: Prediction, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> Prediction:
    """The same with runs that are sampled where the records tell that their channels were; as it is where the motion is an input, no clock
    may be off, or none does better than that of the record. values, on : of the model by which that is seen."""
    clocks, trials = _clocks(prediction, values), prediction.experiment.trials
    if not clocks:
        return prediction
    heads = tuple(
        trials[place].head(CONSTANTS.probed_samples) for place in {key: place for place, key in prediction.alike.items()}.values()
    )
    looked_at = prediction.sampled_at({}).of(replace(prediction.experiment, trials=heads, means=None))
    held = dict[str, float]()
    for channel, clock in clocks.items():
        reach = CONSTANTS.widest_setup_error * clock.sd
        tried = np.linspace(-reach, reach, CONSTANTS.tried_clocks)
        squares = [_square(looked_at, channel, float(each), values, on) for each in tried]
        best = int(np.argmin(squares))
        if squares[best] < (1 - CONSTANTS.least_gain_of_clock) * squares[tried.size // 2]:
            held[channel] = float(tried[best])
    return prediction.sampled_at(held)


def likeliest_clocks(prediction: Prediction, whitening: BandWhitening, fitted: Fit) -> dict[str, float]:
    """By channel, how late it was [s], to a fraction of what `with_clocks` tells: one after the other, other parameters following each.
    Empty where that tells none."""
    clocks = _clocks(prediction, fitted.values)
    held = {channel: float(fitted.values.get(clock.name, prediction.setup.clocks.get(channel, 0.0))) for channel, clock in clocks.items()}
    names = {clock.name for clock in clocks.values()}
    follow = [place for place, parameter in enumerate(fitted.parameters) if parameter.name not in names]
    tries = CONSTANTS.tried_clocks
    for channel, clock in clocks.items():
        reach = 4 * CONSTANTS.widest_setup_error * clock.sd / (tries - 1)  # two steps of the first search
        tried = np.clip(held[channel] + np.linspace(-reach, reach, tries // 2 + 1), clock.low, clock.high)
        logs = []
        for late in tried:
            own = {**held, channel: float(late)}
            values = {**fitted.values, **{clocks[each].name: at for each, at in own.items()}}
            point = np.array([p.place(float(values[p.name])) for p in fitted.parameters])
            predicted = prediction.sampled_at(own).one(values, fitted.on)
            logs.append(_log_followed(whitening, predicted, fitted.slopes, point, follow))
        held[channel] = float(tried[int(np.argmax(logs))])
    return held


def _clocks(prediction: Prediction, values: Mapping[str, float | str] | None) -> dict[str, Parameter]:
    """By channel, the clocks that may be off where the model moves by itself in every trial; else none."""
    every = [prediction.model.cycle_time({**prediction.nominal, **(values or {}), **t.values}) for t in prediction.experiment.trials]
    if not all(np.isfinite(every)):
        return {}
    return {channel: p for p in prediction.setup.parameters for channel, kind in [by_channel(p.name)] if kind == CLOCK}


def _log_followed(whitening: BandWhitening, predicted: FloatArray, slopes: FloatArray, point: FloatArray, follow: Sequence[int]) -> float:
    """Log likelihood where those parameters that follow have gone to where it is largest, if they enter linearly."""
    if not np.all(np.isfinite(predicted)):
        return -np.inf
    residual, slope = likelihood(whitening, whitening.sums(predicted, slopes), point).squares
    axes, _ = np.linalg.qr(slope[:, follow])
    left = residual - axes @ (axes.T @ residual)
    return -0.5 * float(left @ left)


def _square(prediction: Prediction, channel: str, clock: float, values: Mapping[str, float | str] | None, on: Sequence[str]) -> float:
    """Mean square of what the model leaves of a channel that is so late [s]; infinite where it does not run."""
    left = (prediction.measured - prediction.sampled_at({channel: clock}).one(values, on))[prediction.places(channel)]
    return float(np.mean(left**2)) if np.all(np.isfinite(left)) else np.inf
