"""What is a gap made of? Mean squares of each channel: noise, repeatability, numerical error, mis-tuning, effects, unexplained."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from evat.gap.budget import squares
from evat.gap.search.compare import Comparison
from evat.inference.fit import Fit

TITLES = {
    "noise": "noise",
    "repeatability": "repeatability",
    "numerical": "numerical error",
    "mistuning": "mis-tuning",
    "effect": "named effects",
    "unexplained": "unexplained",
}


@dataclass(frozen=True, slots=True)
class Parts:
    """Mean squares [unit squared] whose sum is that of measured less nominal, in a single recording."""

    noise: float
    repeatability: float
    numerical: float
    mistuning: float
    effect: float
    unexplained: float

    @property
    def total(self) -> float:
        return float(sum(getattr(self, name) for name in TITLES))

    def rms(self, name: str) -> float:
        """A part alone; parts add up in squares."""
        return math.sqrt(getattr(self, name))

    def share(self, name: str) -> float:
        return float(getattr(self, name) / self.total) if self.total > 0 else 0.0


def parts(comparison: Comparison, chosen: Fit) -> dict[str, Parts]:
    """Of each channel, over all conditions; a part that a fit has made larger in one channel, for the sake of another, counts as 0.

    Mis-tuning and effects are parts of what the chosen model changes, each as far as it goes the way of the whole change: what
    recalibration alone would take up in place of an effect that is named is no mis-tuning.
    """
    whitening = comparison.whitening
    nominal, corrected = (squares(whitening, fit.predicted) for fit in (comparison.nominal, chosen))
    wrong, effects = numerical_error(comparison, chosen), _share_of_effects(comparison, chosen)
    by_channel = {}
    for channel, start in nominal.items():
        left = corrected[channel].structural
        numerical = min(left, wrong.get(channel, 0.0))
        explained = max(start.structural - left, 0.0)
        structure = {
            "numerical": numerical,
            "mistuning": (1 - effects[channel]) * explained,
            "effect": effects[channel] * explained,
            "unexplained": left - numerical,
        }
        # Structure is measured away from jumps; here it is brought to all samples.
        size, rest = sum(structure.values()), max(start.left - start.floor, 0.0)
        scale = rest / size if size > 0 else 0.0
        by_channel[channel] = Parts(start.noise, start.repeatability, **{name: scale * part for name, part in structure.items()})
    return by_channel


def _share_of_effects(comparison: Comparison, chosen: Fit) -> dict[str, float]:
    """Of what the chosen model changes in each channel, the share that its effects, or its other base law, do: 0 to 1."""
    prediction = comparison.prediction
    if not chosen.on and not chosen.fixed:
        return dict.fromkeys(prediction.channels, 0.0)
    own = {variable.name for effect in prediction.model.effects if effect.name in chosen.on for variable in effect.variables}
    without = prediction.one({name: value for name, value in chosen.values.items() if name not in chosen.fixed and name not in own}, ())
    shares = {}
    for channel in prediction.channels:
        at = prediction.places(channel)
        whole, part = chosen.predicted[at] - comparison.nominal.predicted[at], chosen.predicted[at] - without[at]
        size = float(whole @ whole)
        share = float(part @ whole) / size if size > 0 else 0.0
        shares[channel] = min(max(share, 0.0), 1.0) if math.isfinite(share) else 1.0
    return shares


def numerical_error(comparison: Comparison, chosen: Fit) -> dict[str, float]:
    """Mean square that a finer solver changes [unit squared]; nothing where the model has no tolerance to set."""
    prediction = comparison.prediction
    change = np.nan_to_num(prediction.numerical_error(chosen.values, chosen.on))
    sums, counts = dict[str, float](), dict[str, int]()
    for segment in prediction.segments:
        sums[segment.channel] = sums.get(segment.channel, 0.0) + float(np.sum(change[segment.at] ** 2))
        counts[segment.channel] = counts.get(segment.channel, 0) + segment.at.stop - segment.at.start
    return {channel: total / counts[channel] for channel, total in sums.items()}
