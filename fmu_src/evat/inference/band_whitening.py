"""How much does each number of a residual weigh? Residuals and slopes, whitened by the noise, then summed up band by band of frequency.

All that later steps of a diagnosis ask (fits, evidence, held-out conditions, how much is left unexplained) follows from these sums: no step
looks at samples again, as an identification does (sample_whitening). In bands, since what a model lacks is smooth in time where noise, once
whitened, is not; and apart for the harmonics of a periodic motion, since what a model lacks comes back in every cycle where noise does not.
Repeats of one run count as their mean, for the same reason.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.inference.cycles import cycle_samples
from evat.inference.law.initial_state import RANDOM
from evat.inference.noise.autoregression import WHITE, lag_one_correlation
from evat.inference.noise.discontinuities import Discontinuities
from evat.inference.noise.ends import dying_away, unsure_ends
from evat.inference.noise.estimate import Noise, between_trials
from evat.inference.noise.outliers import unsure_outliers
from evat.inference.prediction import Prediction
from evat.model import FloatArray


@dataclass(frozen=True, slots=True)
class Group:
    """Segments that one run predicts: repeats. `at` is where the first of them stands in the long vector."""

    condition: str
    channel: str
    members: tuple[int, ...]
    at: slice
    cycles: float  # of a periodic motion within it, 1 where it is not


@dataclass(frozen=True)
class Sums:
    """`grams` (groups, bands, w, w): inner products of the whitened [slopes (p), residual, what differs between trials (RANDOM)]."""

    grams: FloatArray


class BandWhitening:
    """The covariance of an experiment as a way to sum up residuals, band by band of frequency.

    `jumps[group]` tells what its samples count, less beside jumps; `counts` (groups, bands) is how many numbers a band has; `unexplained`
    (lengths, groups, bands) what a discrepancy of unit size (rms of its channel) and given correlation length would add to the variance 1
    that noise has there; `least` (groups, bands) the variance that every model is granted; `trust` (groups, bands) the share of its
    numbers that a band counts. `sizes` (groups,) is the standard deviation of innovations of a recording: where those of repeats differ,
    of so many as if each had it that their mean is known as well.
    """

    def __init__(
        self,
        prediction: Prediction,
        noise: Noise,
        predicted: FloatArray,
        numerical: FloatArray | None = None,
        by_inputs: FloatArray | None = None,
    ) -> None:
        """predicted : (N,), near the truth: how gain, zero and clock of a trial show; numerical : (N,), the solver's error in it;
        by_inputs : (N,), what the noise of recorded inputs has left in it."""
        self.prediction, self.noise = prediction, noise
        self.groups = self._grouped()
        self.sizes = np.array([_as_if_alike(noise.sizes[list(group.members)]) for group in self.groups])
        self.levels = self._levels()
        self.means = self._means(predicted)
        self.jumps = [self._jumps_of(place, predicted) for place in range(len(self.groups))]
        self._own = [_spectrum(self._between(place, predicted)) for place in range(len(self.groups))]
        bands_of = [self._edges(group) for group in self.groups]
        there = sorted(set().union(*bands_of))  # bands of which any group has numbers
        self._bands = [{there.index(band): own for band, own in bands.items()} for bands in bands_of]
        self._harmonic = np.array([band < CONSTANTS.bands for band in there])
        self.counts = np.zeros((len(self.groups), len(there)))
        for place, bands in enumerate(self._bands):
            for band, (_, weight) in bands.items():
                self.counts[place, band] = weight.sum() * self.jumps[place].share
        wrong = np.zeros(predicted.size) if numerical is None else np.nan_to_num(numerical)
        own = np.array([np.mean(wrong[group.at] ** 2) / self.levels[group.channel] ** 2 for group in self.groups])
        self.least: FloatArray = 1 + (CONSTANTS.least_discrepancy**2 + own[:, None]) * self.unexplained[0]
        if by_inputs is not None:
            self.least = self.least + self._left_by_inputs(np.nan_to_num(by_inputs))
        self.trust: FloatArray = np.ones_like(self.counts)
        self._variances: tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray]] | None = None

    def _left_by_inputs(self, error: FloatArray) -> FloatArray:
        """The variance (groups, bands) of an error (N,) as large and as long-lived in each group as this one."""
        variance = np.zeros_like(self.counts)
        for place, group in enumerate(self.groups):
            own = error[group.at]
            if not np.any(own):
                continue
            correlation = float(np.clip(lag_one_correlation([own]), 1e-3, 0.999))
            lasting = np.abs(np.log(np.array(CONSTANTS.correlation_samples) * -np.log(correlation)))
            variance[place] = np.mean(own**2) / self.levels[group.channel] ** 2 * self.unexplained[int(np.argmin(lasting)), place]
        return variance

    def doubt(self, size: float, length: int) -> None:
        """Count what is known of a band no higher than as if the discrepancy in it were `discrepancy_numbers`, not one for each sample.

        size and length (a place in correlation_samples) are those of the discrepancy. The mean square of a band is known as well as its
        noise, which is independent, and its discrepancy, which is not, allow.
        """
        ratio = size**2 * self.unexplained[length] / self.least
        known = (1 + ratio) ** 2 / ((1 + 2 * ratio) / np.maximum(self.counts, 1.0) + ratio**2 / CONSTANTS.discrepancy_numbers)
        self.trust = np.minimum(known / np.maximum(self.counts, 1.0), 1.0)

    def variances(self, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of noise and discrepancies of these sizes (rms of a channel) and all lengths: one by the variance, and its logarithm (lengths,
        groups, sizes, bands). The same for every residual, so they are kept."""
        known = self._variances
        if known is None or known[0] is not self.least or known[1] is not sizes:
            variance = self.least[:, None] + sizes[:, None] ** 2 * self.unexplained[:, :, None]
            known = self._variances = (self.least, sizes, (1 / variance, np.log(variance)))
        return known[2]

    def forgive(self, size: float, length: int) -> None:
        """From now on count a discrepancy of at least this size and length in every model."""
        self.least = self.least + size**2 * self.unexplained[length]

    def _grouped(self) -> tuple[Group, ...]:
        by_run: dict[tuple[object, str], list[int]] = {}
        for place, segment in enumerate(self.prediction.segments):  # of means, rows of one condition are replicates
            key = self.prediction.alike[segment.trial] if segment.trial >= 0 else segment.condition
            by_run.setdefault((key, segment.channel), []).append(place)
        groups = []
        for (_, channel), members in by_run.items():
            first = self.prediction.segments[members[0]]
            cycles = 1.0
            if first.trial >= 0:
                period = cycle_samples(self.prediction, first.trial)
                cycles = max((first.at.stop - first.at.start) / period, 1.0) if period else 1.0
            groups.append(Group(first.condition, channel, tuple(members), first.at, cycles))
        return tuple(groups)

    def _levels(self) -> dict[str, float]:
        """Root mean square of each channel."""
        levels = {}
        for channel in dict.fromkeys(group.channel for group in self.groups):
            whole = np.concatenate([self.prediction.measured[s.at] for s in self.prediction.segments if s.channel == channel])
            levels[channel] = float(np.sqrt(np.mean(whole**2))) + 1e-12  # of a dead channel, too, something can be divided by it
        return levels

    def _means(self, predicted: FloatArray) -> list[FloatArray]:
        """Mean of the repeats of each group, by inverse variance; a sample that is far off where the others are not counts no
        more than a far one."""
        means, own_start = [], self.prediction.own_start
        for group in self.groups:
            own = [self.prediction.segments[place].at for place in group.members]
            # as if each had begun as the first, of which the prediction is
            rows = np.array([self.prediction.measured[at] - (own_start[at] - own_start[group.at]) for at in own])
            if len(rows) > 1 and group.at.stop - group.at.start > 1:
                rows = _without_outliers(rows, predicted[group.at])
            means.append(_weighted_mean(rows, self.noise.sizes[list(group.members)]))
        return means

    def _jumps_of(self, place: int, predicted: FloatArray) -> Discontinuities:
        """What samples count: less beside jumps, where a mean of repeats is as wrong as each, at ends, and where one stands alone."""
        group = self.groups[place]
        size = self.sizes[place] / math.sqrt(len(group.members))
        own = predicted[group.at]
        unsure = unsure_ends(self.prediction, self.prediction.segments[group.members[0]], own)
        unsure = np.hypot(unsure, unsure_outliers(self.residual(predicted, place), own))
        return Discontinuities(own, self._filter_of(group), float(size), unsure)

    def _filter_of(self, group: Group) -> FloatArray:
        return self.noise.filters[group.channel] if group.at.stop - group.at.start > 1 else WHITE

    def _between(self, place: int, predicted: FloatArray) -> FloatArray:
        """What differs from trial to trial, by its standard deviation, white where the noise is: (numbers, RANDOM)."""
        group = self.groups[place]
        if group.at.stop - group.at.start == 1:
            return np.zeros((1, RANDOM))
        first = self.prediction.segments[group.members[0]]
        changed = between_trials(self.prediction, self.noise, first, predicted)
        start = dying_away(self.prediction, first)
        return self._filter(np.column_stack([changed, start]), place)

    def _filter(self, columns: FloatArray, place: int) -> FloatArray:
        """Innovations of the columns of one segment, by their sd."""
        group = self.groups[place]
        size = self.sizes[place]
        filter_ = self._filter_of(group)
        lost = filter_.size - 1
        white: FloatArray = columns[lost:] * (filter_[0] / size)
        for lag in range(1, filter_.size):
            white = white + columns[lost - lag : -lag] * (filter_[lag] / size)
        return self.jumps[place].whiten(white)

    def _edges(self, group: Group) -> dict[int, tuple[npt.NDArray[np.intp], FloatArray]]:
        """Of each band that a group has: the coefficients of the real Fourier transform in it, and how many numbers each is."""
        length = group.at.stop - group.at.start - self._filter_of(group).size + 1
        last = length // 2 + 1
        weight = np.full(last, 2.0)
        weight[0] = 1.0
        if length % 2 == 0 and last > 1:
            weight[-1] = 1.0
        edges = np.unique(np.concatenate([[0, 1], np.round(np.geomspace(1, max(last, 2), CONSTANTS.bands)).astype(int)]))
        band = np.searchsorted(edges, np.arange(last), side="right") - 1
        if group.cycles > CONSTANTS.cycles_of_a_periodic_motion:
            order = np.arange(last) / group.cycles
            between = np.abs(order - np.round(order)) * group.cycles > CONSTANTS.width_of_a_harmonic
            between[0] = False
            band = band + CONSTANTS.bands * between
        return {int(b): (np.flatnonzero(band == b), weight[band == b]) for b in np.unique(band)}

    def residual(self, predicted: FloatArray, place: int) -> FloatArray:
        """Mean measured minus predicted (N,) of a group."""
        residual: FloatArray = self.means[place] - predicted[self.groups[place].at]
        return residual

    def residual_of_any_start(self, predicted: FloatArray, place: int) -> FloatArray:
        """The same without what another start of the bristles takes in: as far as their bending goes, no start is one model's."""
        group = self.groups[place]
        left, bent = self.residual(predicted, place), self.prediction.bent[group.at]
        size = float(self.sizes[place])
        taken: FloatArray = left - bent * (bent @ left) / (bent @ bent + size**2)
        return taken

    def residuals(self, predicted: FloatArray) -> FloatArray:
        """The same of all groups, (N,), at each of their repeats."""
        residuals = np.zeros_like(predicted)
        for place, group in enumerate(self.groups):
            for member in group.members:
                residuals[self.prediction.segments[member].at] = self.residual_of_any_start(predicted, place)
        return residuals

    def sums(self, predicted: FloatArray, slopes: FloatArray) -> Sums:
        """predicted (N,), slopes (N, p)."""
        width = slopes.shape[1] + 1 + RANDOM
        grams = np.zeros((*self.counts.shape, width, width))
        for place, group in enumerate(self.groups):
            columns = np.column_stack([slopes[group.at], self.residual(predicted, place)])
            white = self._filter(columns, place) * math.sqrt(len(group.members))
            spectrum = np.concatenate([_spectrum(white), self._own[place]], axis=1)
            for band, (rows, _) in self._bands[place].items():
                part = spectrum[rows]
                part = np.concatenate([part.real, part.imag])
                grams[place, band] = part.T @ part
        return Sums(grams)

    @cached_property
    def unexplained(self) -> FloatArray:
        variance = np.zeros((len(CONSTANTS.correlation_samples), *self.counts.shape))
        for place, group in enumerate(self.groups):
            ratio = (self.levels[group.channel] / self.sizes[place]) ** 2 * len(group.members) * self.jumps[place].share
            length = group.at.stop - group.at.start
            if length == 1:
                variance[:, place, 0] = ratio
                continue
            filter_ = self._filter_of(group)
            length -= filter_.size - 1
            omega = 2 * np.pi * np.arange(length // 2 + 1) / length
            gain = np.abs(np.exp(-1j * np.outer(omega, np.arange(filter_.size))) @ filter_) ** 2
            periodic = group.cycles > CONSTANTS.cycles_of_a_periodic_motion
            share = self.counts[place, self._harmonic].sum() / self.counts[place].sum()
            for row, samples in enumerate(CONSTANTS.correlation_samples):
                rho = np.exp(-1 / samples)
                spectrum = (1 - rho**2) / (1 - 2 * rho * np.cos(omega) + rho**2) * gain * ratio
                for band, (rows, _) in self._bands[place].items():
                    factor = (
                        1.0
                        if not periodic
                        else (1 - CONSTANTS.aperiodic_share) / share
                        if self._harmonic[band]
                        else CONSTANTS.aperiodic_share / (1 - share)
                    )
                    variance[row, place, band] = spectrum[rows].mean() * factor
        return np.asarray(np.cumsum(variance, axis=0) / np.arange(1, len(variance) + 1)[:, None, None], dtype=np.float64)


def _spectrum(white: FloatArray) -> npt.NDArray[np.complex128]:
    """Fourier coefficients of columns (L, p), with the numbers that the negative frequencies repeat counted in."""
    coefficients = np.fft.rfft(np.ascontiguousarray(white.T), norm="ortho").T
    coefficients[1 : (white.shape[0] + 1) // 2] *= np.sqrt(2)
    return np.asarray(coefficients)


def _as_if_alike(sizes: FloatArray) -> float:
    """The one standard deviation with which as many repeats would tell their mean as well as these (n,) do."""
    return float(sizes[0]) if np.all(sizes == sizes[0]) else math.sqrt(sizes.size / float(np.sum(1 / sizes**2)))


def _weighted_mean(rows: FloatArray, sizes: FloatArray) -> FloatArray:
    """Mean (m,) of repeats (n, m) whose noise has these standard deviations (n,), by inverse variance."""
    weights = None if np.all(sizes == sizes[0]) else 1 / sizes**2
    return np.asarray(rows.mean(axis=0) if weights is None else np.average(rows, axis=0, weights=weights), dtype=np.float64)


def _without_outliers(rows: FloatArray, predicted: FloatArray) -> FloatArray:
    """Repeats (n, L); a sample far from the others is taken from the middle one, of two from the one that is nearer to the prediction."""
    level = rows - np.median(rows, axis=1, keepdims=True) + np.median(rows)
    apart = level[1:] - level[:-1]
    sd = 1.4826 * float(np.median(np.abs(apart - np.median(apart)))) / np.sqrt(2)
    if len(rows) == 2:
        middle = np.where(np.abs(level[0] - predicted) < np.abs(level[1] - predicted), level[0], level[1])
        far = np.abs(apart) > CONSTANTS.outlying_repeat * np.sqrt(2) * sd
        return np.where(far, middle + (rows - level), rows)
    middle = np.median(level, axis=0)
    return np.where(np.abs(level - middle) > CONSTANTS.outlying_repeat * sd, middle + (rows - level), rows)
