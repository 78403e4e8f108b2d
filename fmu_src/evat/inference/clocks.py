"""How late is each channel beside a model that moves by itself, before anything is fitted?

Friction that reverses within a fraction of a sample shows a clock at its jumps only. No slope leads there: so clocks are tried, and the
runs sampled where the channels were. Where the motion is an input, force and motion bend together, and slopes do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.prediction import Prediction
from evat.inference.setup.setup_errors import CLOCK, by_channel


def with_clocks(prediction: Prediction, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> Prediction:
    """The same with runs that are sampled where the records tell that their channels were; as it is where the motion is an input, no clock
    may be off, or none does better than that of the record. values, on : of the model by which that is seen."""
    clocks = {channel: p for p in prediction.setup.parameters for channel, kind in [by_channel(p.name)] if kind == CLOCK}
    trials = prediction.experiment.trials
    moving = [np.isfinite(prediction.model.cycle_time({**prediction.nominal, **(values or {}), **trial.values})) for trial in trials]
    if not clocks or not all(moving):
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


def _square(prediction: Prediction, channel: str, clock: float, values: Mapping[str, float | str] | None, on: Sequence[str]) -> float:
    """Mean square of what the model leaves of a channel that is so late [s]; infinite where it does not run."""
    left = (prediction.measured - prediction.sampled_at({channel: clock}).one(values, on))[prediction.places(channel)]
    return float(np.mean(left**2)) if np.all(np.isfinite(left)) else np.inf
