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
    """Of each channel, over all conditions; a part that a fit has made larger in one channel, for the sake of another, counts as 0."""
    whitening = comparison.whitening
    nominal, recalibrated, corrected = (squares(whitening, fit.predicted) for fit in (comparison.nominal, comparison.recalibrated, chosen))
    wrong = numerical_error(comparison, chosen)
    by_channel = {}
    for channel, start in nominal.items():
        left = corrected[channel].structural
        numerical = min(left, wrong.get(channel, 0.0))
        structure = {
            "numerical": numerical,
            "mistuning": max(start.structural - recalibrated[channel].structural, 0.0),
            "effect": max(recalibrated[channel].structural - left, 0.0),
            "unexplained": left - numerical,
        }
        # Structure is measured away from jumps; here it is brought to all samples.
        size, rest = sum(structure.values()), max(start.left - start.floor, 0.0)
        scale = rest / size if size > 0 else 0.0
        by_channel[channel] = Parts(start.noise, start.repeatability, **{name: scale * part for name, part in structure.items()})
    return by_channel


def numerical_error(comparison: Comparison, chosen: Fit) -> dict[str, float]:
    """Mean square that a finer solver changes [unit squared]; nothing where the model has no tolerance to set."""
    prediction = comparison.prediction
    change = np.nan_to_num(prediction.numerical_error(chosen.values, chosen.on))
    sums, counts = dict[str, float](), dict[str, int]()
    for segment in prediction.segments:
        sums[segment.channel] = sums.get(segment.channel, 0.0) + float(np.sum(change[segment.at] ** 2))
        counts[segment.channel] = counts.get(segment.channel, 0) + segment.at.stop - segment.at.start
    return {channel: total / counts[channel] for channel, total in sums.items()}
