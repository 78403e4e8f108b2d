"""How large is the gap, and what of it is noise, repeatability, mis-tuning, an effect, unexplained? Mean squares, channel by channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evat.gap.noise import differing, impulse_response
from evat.gap.whitening import Whitening
from evat.model import FloatArray

UNSURE = 0.02  # of the noise floor: no structural square is known better


@dataclass(frozen=True)
class Squares:
    """Mean squares of one channel [unit squared], of single recordings: what a model leaves, what noise and repeatability leave, and the
    structural part of what is left: that of the mean of the repeats, less what noise leaves of it, jumps left out."""

    left: float
    noise: float
    repeatability: float
    structural: float

    @property
    def floor(self) -> float:
        return self.noise + self.repeatability


def squares(whitening: Whitening, predicted: FloatArray, conditions: set[str] | None = None) -> dict[str, Squares]:
    """Of each channel; over some conditions only, where they are given."""
    noise, prediction = whitening.noise, whitening.prediction
    sums: dict[str, FloatArray] = {}
    for place, group in enumerate(whitening.groups):
        if conditions is not None and group.condition not in conditions:
            continue
        size, repeats = group.at.stop - group.at.start, len(group.members)
        within, between = np.full(size, float(noise.sizes[group.members[0]]) ** 2), np.zeros(size)
        if size > 1:
            within *= float(np.sum(impulse_response(noise.filters[group.channel]) ** 2))
            times = prediction.experiment.trials[prediction.segments[group.members[0]].trial].times
            between = np.sum((differing(predicted[group.at], times) * noise.spread[group.channel]) ** 2, axis=1)
        alone = sum(
            float(np.sum((prediction.measured[prediction.segments[member].at] - predicted[group.at]) ** 2)) for member in group.members
        )
        # Beside a jump the clock's spread alone makes large squares: there a structural gap cannot be seen.
        counted = whitening.jumps[place].weights ** 2
        clear = float(np.sum(counted * (whitening.residual(predicted, place) ** 2 - (within + between) / repeats)))
        row = np.array([alone / repeats, float(within.sum()), float(between.sum()), size, clear, float(counted.sum())])
        sums[group.channel] = sums.get(group.channel, np.zeros(row.size)) + row
    return {
        channel: Squares(float(row[0] / row[3]), float(row[1] / row[3]), float(row[2] / row[3]), max(float(row[4] / row[5]), 0.0))
        for channel, row in sums.items()
    }


def structural(whitening: Whitening, predicted: FloatArray) -> float:
    """Structural mean square of all channels, each in that of its rms."""
    return sum(found.structural / whitening.levels[channel] ** 2 for channel, found in squares(whitening, predicted).items())


def structural_share(whitening: Whitening, predicted: FloatArray, reference: FloatArray) -> float:
    """The structural mean square that one prediction leaves, in that of another; channels weighed by their rms. A channel in which the
    other leaves nothing but noise has no say, unless all are so."""
    left, before, levels = squares(whitening, predicted), squares(whitening, reference), whitening.levels
    unsure = {channel: UNSURE * found.floor for channel, found in before.items()}
    telling = [channel for channel, found in before.items() if found.structural > unsure[channel]] or list(before)
    above, below = (sum((table[c].structural + unsure[c]) / levels[c] ** 2 for c in telling) for table in (left, before))
    return above / below
