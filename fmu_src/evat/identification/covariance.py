"""How well is an optimum known? The loss and its noise, and the covariance that they give.

Noise that goes on from sample to sample widens what was not whitened: a sandwich of the slopes around the residual's correlation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import chi2

from evat.identification.fits import fits_of, unexplained
from evat.identification.held import moved_by_clocks, moved_by_damping, moved_by_held
from evat.identification.objective import Objective
from evat.identification.result import ChannelFit
from evat.inference.noise.autoregression import WHITE, autoregression, correlated, innovation_sd
from evat.inference.sample_whitening import SampleWhitening
from evat.model import FloatArray

LOOSE = 1e3  # sd, in widths of the bounds, that a parameter without any influence gets
CHANCE = 0.02  # how often recordings that differ by noise alone are taken to differ by more
MANY = 1e9  # degrees of freedom of what needs no repeats to be known


@dataclass(frozen=True, eq=False)
class Weights:
    """Residuals and slopes over the sd (N,) of each number, as if these were independent."""

    weights: FloatArray

    def __call__(self, columns: FloatArray) -> FloatArray:
        weighted: FloatArray = columns * (self.weights if columns.ndim == 1 else self.weights[:, None])
        return weighted


@dataclass(frozen=True, eq=False)
class Loss:
    """What is summed up: `weigh` makes residuals or slopes those of unit variance, `sd[channel]` is the usual sd of a number [its unit],
    `bend` the scale from which the loss is no square any more (inf: none), `magnitudes` whether it is a rounded-off magnitude there."""

    weigh: Weights | SampleWhitening
    sd: Mapping[str, float]
    bend: float = np.inf
    magnitudes: bool = False

    @property
    def whitened(self) -> bool:
        return isinstance(self.weigh, SampleWhitening)

    def __call__(self, residual: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """rho, psi = rho', psi' of weighted residuals; rho is r^2/2 near zero."""
        if self.magnitudes:
            root = np.sqrt(1 + (residual / self.bend) ** 2)
            return self.bend**2 * (root - 1), residual / root, 1 / root**3
        inside = np.abs(residual) <= self.bend
        rho = np.where(inside, residual**2 / 2, 0.0 if np.isinf(self.bend) else self.bend * (np.abs(residual) - self.bend / 2))
        return rho, np.clip(residual, -self.bend, self.bend), inside.astype(np.float64)


@dataclass(frozen=True, eq=False)
class Optimum:
    """The optimum in the cube with what is needed to judge its surroundings.

    residual : (N,), calculated less measured, SI; least : sum of rho there; unit : the loss's rise that is one sd, squared, over 2 (`2 *
    (loss - least) / unit` is chi-squared with 1 degree of freedom); stretch : (p,) the factor of a parameter's variance by which
    correlated noise exceeds white one; covariance : of the point of the cube; degrees : (p,) of freedom from which a parameter's sd is
    known; pull : (p,) how steeply the loss falls beyond the point, in sd of each parameter alone: about 0 but on a bound; held[name] :
    (p,) by how much each parameter is likely to be another because a nominal value that is held is, or the gain or the zero of a channel
    is off in all trials alike, in sd of the parameter; nan where the model runs at neither end of what that value may be; clocks[name] :
    (p,) by how much a clock may move each, as far as its sd and these data leave it open, in sd of the parameter, which do not hold it;
    damping : the way of damping that nobody has chosen, "" where somebody has, and by how much that would, in sd by noise alone.
    """

    point: FloatArray
    residual: FloatArray
    loss: Loss
    least: float
    unit: float
    stretch: FloatArray
    covariance: FloatArray
    degrees: FloatArray
    pull: FloatArray
    calls: int
    held: Mapping[str, FloatArray]
    clocks: Mapping[str, FloatArray] = field(default_factory=dict)
    damping: tuple[str, FloatArray] = ("", np.zeros(0))


@dataclass(frozen=True, eq=False)
class _Spread:
    """The covariance of an optimum and its `stretch`, as in `Optimum`, while one cause after the other widens them."""

    covariance: FloatArray
    stretch: FloatArray

    @property
    def variances(self) -> FloatArray:
        return np.diag(self.covariance)

    def widened(self, factors: FloatArray) -> _Spread:
        """With each standard deviation this many times as large, (p,); correlations stay."""
        return _Spread(_scaled(self.covariance, factors), self.stretch * factors**2)

    def beside(self, other: FloatArray) -> _Spread:
        """With the covariance (p, p) of another cause, which moves parameters together: a gain all that are forces."""
        return _Spread(self.covariance + other, self.stretch * (1 + np.diag(other) / self.variances))


def _scaled(covariance: FloatArray, factors: FloatArray) -> FloatArray:
    scaled: FloatArray = np.asarray(covariance * factors[:, None] * factors[None, :], dtype=np.float64)
    return scaled


def optimum_at(objective: Objective, loss: Loss, point: FloatArray, least: float, calls: int) -> Optimum:
    """The optimum with its covariance."""
    predicted, table = objective.jacobian(point)
    residual = predicted - objective.prediction.measured
    scaled, slopes = loss.weigh(residual), loss.weigh(table)
    _, psi, curve = loss(scaled)
    count = max(scaled.size - point.size, 1)
    unit = float(np.sum(psi**2) / count / max(float(np.mean(curve)), 1e-12))
    if objective.kind == "least_squares" and all(objective.has_sd(channel) for channel in objective.channels):
        unit = max(unit, 1.0)  # few averages may lie closer to the model than their sd, by chance: that makes nothing better known
    information = slopes.T @ slopes * float(np.mean(curve)) / unit
    plain = _inverse(information)
    pull: FloatArray = -(slopes.T @ psi) / unit / np.sqrt(np.diag(information) + 1 / LOOSE**2)
    spread = _Spread(plain, np.ones(point.size))
    if not loss.whitened:
        filters = {channel: autoregression(rows) for channel, rows in objective.prediction.recordings(psi).items()}
        meat = _correlated(objective, filters, slopes * _innovation_sd(objective, filters, psi)[:, None])
        sandwich = plain @ (meat.T @ meat) @ plain / unit**2
        # correlated noise that happens to suit a parameter is no reason to believe in less than white noise
        stretch = np.maximum(np.diag(sandwich) / np.diag(plain), 1.0)
        spread = _Spread(_scaled(plain, np.sqrt(stretch)), stretch)
    degrees = _degrees(objective, loss, table, spread.covariance, unit)
    apart, recordings = _between_recordings(objective, slopes * psi[:, None], plain / unit)
    inverse = _inverse(slopes.T @ slopes)
    moved, shift, explained = moved_by_held(objective, loss.weigh, slopes, table, psi, unit, point, predicted, inverse, False)
    begun, misses = objective.at(point), False
    for left in (residual, residual + explained):  # what held values and the set-up explain is not missed
        fits = fits_of(begun, left)
        if not (misses := any(map(unexplained, fits.values()))):
            break
    if misses:  # then the shape of the law is in question, too
        moved, shift, _ = moved_by_held(objective, loss.weigh, slopes, table, psi, unit, point, predicted, inverse, True)
    spread = spread.beside(shift)
    spread = spread.widened(np.sqrt(1 + _astray(objective, fits, table) / spread.variances))
    ratio = apart / spread.variances
    if recordings and np.max(ratio) > chi2.ppf(1 - CHANCE / point.size, recordings) / recordings:
        # What pulls recordings apart beyond their noise, be it a gain or what the model lacks, is known from so few recordings only.
        spread = spread.widened(np.sqrt(np.maximum(ratio, 1.0)))
        degrees = np.minimum(degrees, recordings)
    held = {name: steps / np.sqrt(spread.variances) for name, steps in moved.items()}
    clocks = {
        name: steps / np.sqrt(spread.variances)
        for name, steps in moved_by_clocks(objective, loss.weigh, slopes, unit, predicted, inverse).items()
    }
    other, away = moved_by_damping(objective, loss.weigh, slopes, point, predicted, inverse)
    damping, calls = (other, away / np.sqrt(np.diag(plain))), calls + 1 + point.size  # be it what the model is seen to miss
    return Optimum(point, residual, loss, least, unit, spread.stretch, spread.covariance, degrees, pull, calls, held, clocks, damping)


def _astray(objective: Objective, fits: Mapping[str, ChannelFit], table: FloatArray) -> FloatArray:
    """Variances (p,) of the parameters by what the model misses: as far as a curve of that rms, which no number of samples averages out,
    can lead them astray at most (Cauchy and Schwarz)."""
    missed = np.zeros(len(table))
    for channel, fit in fits.items():
        missed[objective.prediction.places(channel)] = unexplained(fit)
    if not np.any(missed):
        return np.zeros(table.shape[1])
    scaled = table * objective.weights[:, None]
    steps = _inverse(scaled.T @ scaled) @ (scaled * (objective.weights * missed)[:, None]).T
    variances: FloatArray = np.count_nonzero(missed) * np.sum(steps**2, axis=1)
    return variances


def _between_recordings(objective: Objective, scores: FloatArray, covariance: FloatArray) -> tuple[FloatArray, int]:
    """Variances (p,) of the parameters as recordings scatter among themselves (a sandwich over clusters: Liang and Zeger 1986), and its
    degrees of freedom; zeros where there are not two. scores : (N, p), slopes times residual; covariance : over the loss's unit."""
    by_trial: dict[int, FloatArray] = {}
    for segment in objective.prediction.segments:
        if segment.trial >= 0:
            by_trial[segment.trial] = by_trial.get(segment.trial, 0.0) + scores[segment.at].sum(axis=0)
    count = len(by_trial)
    if count < 2:
        return np.zeros(scores.shape[1]), 0
    steps = np.array(list(by_trial.values())) @ covariance
    variances: FloatArray = np.var(steps, axis=0, ddof=1) * count
    return variances, count - 1


def _inverse(information: FloatArray) -> FloatArray:
    inverse: FloatArray = np.asarray(np.linalg.inv(information + np.eye(len(information)) / LOOSE**2), dtype=np.float64)
    return inverse


def _degrees(objective: Objective, loss: Loss, table: FloatArray, covariance: FloatArray, unit: float) -> FloatArray:
    """Effective degrees of freedom of each parameter's variance, (p,): what differs between trials is known from few repeats only (Welch
    and Satterthwaite; GUM, annex G.4)."""
    size, channels = objective.prediction.measured.size, objective.channels
    count = size - covariance.shape[0]
    if not all(objective.has_sd(channel) for channel in channels):
        # the scale of the noise is estimated from the residual, of each channel apart: that with the fewest numbers knows it worst
        count = int(count / size * min(objective.prediction.places(channel).size for channel in channels))
    within = float(max(count, 1))
    if not isinstance(loss.weigh, SampleWhitening) or not loss.weigh.mixed:
        return np.full(covariance.shape[0], within)
    slopes = loss.weigh.within()(table)
    noise = np.diag(_inverse(slopes.T @ slopes / unit))
    whole = np.diag(covariance)
    between = np.clip(whole - noise, 0.0, None)
    repeats = min((degrees for degrees in loss.weigh.noise.degrees.values() if degrees), default=MANY)
    degrees: FloatArray = whole**2 / (np.minimum(noise, whole) ** 2 / within + between**2 / repeats)
    return degrees


def _correlated(objective: Objective, filters: Mapping[str, FloatArray], columns: FloatArray) -> FloatArray:
    """Every recording of the columns (N, p) with the correlation of its channel's noise."""
    changed = np.array(columns, dtype=np.float64)
    for segment in objective.prediction.segments:
        if segment.trial >= 0:
            changed[segment.at] = correlated(filters[segment.channel], changed[segment.at])
    return changed


def _innovation_sd(objective: Objective, filters: Mapping[str, FloatArray], psi: FloatArray) -> FloatArray:
    """sd of the innovations of each number, (N,)."""
    rows, sd = objective.prediction.recordings(psi), np.ones(psi.size)
    for channel in objective.channels:
        places = objective.prediction.places(channel)
        sd[places] = innovation_sd(filters.get(channel, WHITE), rows.get(channel, [psi[places]]))
    return sd
