"""How large is the gap, and what of it is noise, repeatability, mis-tuning, an effect, unexplained? Mean squares, channel by channel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.band_whitening import BandWhitening
from evat.inference.noise.autoregression import correlated, impulse_response
from evat.inference.noise.estimate import between_trials
from evat.model import FloatArray


@dataclass(frozen=True)
class Squares:
    """Mean squares of one channel [unit squared], of single recordings: what a model leaves, what noise and repeatability leave, and the
    structural part of what is left: that of the mean of the repeats, less what noise leaves of it, jumps left out; `unsure` is the standard
    deviation of that where there is no gap, by noise alone."""

    left: float
    noise: float
    repeatability: float
    structural: float
    unsure: float

    @property
    def floor(self) -> float:
        return self.noise + self.repeatability


def squares(whitening: BandWhitening, predicted: FloatArray, conditions: set[str] | None = None) -> dict[str, Squares]:
    """Of each channel; over some conditions only, where they are given."""
    noise, prediction = whitening.noise, whitening.prediction
    sums: dict[str, FloatArray] = {}
    for place, group in enumerate(whitening.groups):
        if conditions is not None and group.condition not in conditions:
            continue
        size, repeats, alike = group.at.stop - group.at.start, len(group.members), 1.0
        within, changed = np.full(size, float(whitening.sizes[place]) ** 2), np.zeros((size, 0))
        if size > 1:
            response = impulse_response(noise.filters[group.channel])
            within *= float(np.sum(response**2))
            alike = _alike(response)
            first = prediction.segments[group.members[0]]
            changed = between_trials(prediction, noise, first, predicted)
        between = np.sum(changed**2, axis=1)
        residual = whitening.residual_of_any_start(predicted, place)
        by_start = whitening.residual(predicted, place) - residual
        alone = sum(
            float(np.sum((prediction.measured[at] - predicted[at] - by_start) ** 2))
            for at in (prediction.segments[member].at for member in group.members)
        )
        # Beside a jump the clock's spread alone makes large squares: there a structural gap cannot be seen.
        counted = whitening.jumps[place].weights ** 2
        clear = float(np.sum(counted * (residual**2 - (within + between) / repeats)))
        scatter = _scatter(counted / repeats, within, changed, alike)
        row = np.array([alone / repeats, float(within.sum()), float(between.sum()), size, clear, float(counted.sum()), scatter])
        sums[group.channel] = sums.get(group.channel, np.zeros(row.size)) + row
    return {
        channel: Squares(
            float(row[0] / row[3]),
            float(row[1] / row[3]),
            float(row[2] / row[3]),
            max(float(row[4] / row[5]), 0.0),
            math.sqrt(row[6]) / row[5],
        )
        for channel, row in sums.items()
    }


def variance_along(whitening: BandWhitening, place: int, direction: FloatArray, predicted: FloatArray) -> float:
    """Variance of the sum of one recording of a group times `direction` (n,): by its noise, which goes on from sample to sample, and by
    what differs from recording to recording. predicted : (N,), near the truth."""
    group, noise = whitening.groups[place], whitening.noise
    if direction.size == 1:
        return float((whitening.sizes[place] * direction[0]) ** 2)
    of_noise = whitening.sizes[place] * correlated(noise.filters[group.channel], direction)
    changed = between_trials(whitening.prediction, noise, whitening.prediction.segments[group.members[0]], predicted)
    return float(of_noise @ of_noise + np.sum((changed.T @ direction) ** 2))


def _scatter(weights: FloatArray, within: FloatArray, changed: FloatArray, alike: float) -> float:
    """Variance of a weighted sum of squares (weights (n,)) of noise of variance `within` (n,), of which `alike` samples tell as much as one
    that is independent, and of what differs from recording to recording by `changed` (n, k) a standard deviation: each of these is one
    number for a whole recording, however many samples show it."""
    by_number = changed.T @ (weights[:, None] * changed)
    of_noise = np.sum((weights * within) ** 2) + 2 * np.sum(weights**2 * within * np.sum(changed**2, axis=1))
    return 2 * (alike * float(of_noise) + float(np.sum(by_number**2)))


def _alike(response: FloatArray) -> float:
    """How many samples of noise with this impulse response tell of its mean square as much as one that is independent: the sum of its
    squared autocorrelations."""
    spectrum = np.abs(np.fft.rfft(response, 2 * response.size)) ** 2
    correlations = np.fft.irfft(spectrum)[: response.size]
    return float(2 * np.sum((correlations / correlations[0]) ** 2) - 1)


def is_visible(table: Mapping[str, Squares]) -> bool:
    """Is a structural gap left in any channel, beyond what noise alone makes?"""
    sd, share = CONSTANTS.visible_structure, CONSTANTS.noise_floor_error
    return any(own.structural > sd * own.unsure + share * own.floor for own in table.values())


def structural(whitening: BandWhitening, predicted: FloatArray) -> float:
    """Structural mean square of all channels, each in that of its rms."""
    return sum(own.structural / whitening.levels[channel] ** 2 for channel, own in squares(whitening, predicted).items())


def structural_share(whitening: BandWhitening, predicted: FloatArray, reference: FloatArray, conditions: set[str] | None = None) -> float:
    """The structural mean square that one prediction leaves, in that of another; channels weighed by their rms. A channel in which the
    other leaves nothing but noise has no say, unless all are so."""
    left, before, levels = squares(whitening, predicted, conditions), squares(whitening, reference, conditions), whitening.levels
    unsure = {channel: CONSTANTS.noise_floor_error * own.floor for channel, own in before.items()}
    telling = [channel for channel, own in before.items() if own.structural > unsure[channel]] or list(before)
    above, below = (sum((table[c].structural + unsure[c]) / levels[c] ** 2 for c in telling) for table in (left, before))
    return above / below
