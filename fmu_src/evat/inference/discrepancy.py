"""How large is what a model leaves unexplained, and how likely are the data then? The likelihood with a smooth discrepancy of unknown size.

Kennedy and O'Hagan 2001: measured = model + discrepancy + noise. Size and correlation length of the discrepancy are found for each model;
one whose form is a little wrong is not punished beyond what it leaves, and one that explains more leaves less.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.band_whitening import BandWhitening, Sums
from evat.inference.law.initial_state import RANDOM
from evat.model import BoolArray, FloatArray


@dataclass(frozen=True)
class Likelihood:
    """`size` (of the rms) and `length` (place in correlation_samples) of the discrepancy; `log` the penalised log likelihood, `evidence`
    its integral over the parameters (Laplace); `step` (p,) to the best parameters from here; `covariance` (p, p) of the parameters;
    `weights` (groups, bands): what a whitened square counts."""

    size: float
    length: int
    log: float
    evidence: float
    step: FloatArray
    covariance: FloatArray
    weights: FloatArray

    @property
    def squares(self) -> tuple[FloatArray, FloatArray]:
        """Numbers (p + 1,) whose squares add up to -2 `log`, and their slopes (p + 1, p) by the parameters, whose information they
        are a factor of."""
        factor = _factor_of_inverse(self.covariance)
        short = -factor @ self.step
        rest = np.sqrt(max(-2 * self.log - float(short @ short), 0.0))
        return np.append(short, rest), np.vstack([factor, np.zeros(self.step.size)])


def _factor_of_inverse(covariance: FloatArray) -> FloatArray:
    """L (p, p) with L' L the inverse. Where a law lies a thousand times the noise away, roundings may leave directions that the data fix
    most with a variance of just below 0: they have as much as roundings let one tell."""
    try:
        factor: FloatArray = np.linalg.cholesky(np.linalg.inv(covariance)).T
    except np.linalg.LinAlgError:
        variances, directions = np.linalg.eigh(covariance)
        factor = (directions / np.sqrt(np.maximum(variances, np.finfo(float).eps * variances[-1]))).T
    return factor


def likelihood(
    whitening: BandWhitening,
    sums: Sums,
    point: FloatArray,
    *,
    held_out: BoolArray | None = None,
    like: Likelihood | None = None,
) -> Likelihood:
    """The best discrepancy for a residual.

    point : (p,), parameters in prior standard deviations from their prior mean; held_out : (groups,), true where not to look; like : take
    its discrepancy.
    """
    kept = slice(None) if held_out is None else np.logical_not(held_out)
    trust, grams = whitening.trust[kept], sums.grams[kept]
    counts = whitening.counts[kept] * trust
    tail = (grams[..., point.size :, point.size :] * trust[..., None, None]).reshape(
        *trust.shape, -1
    )  # residual, and what trials have apart
    # Size and length from the residual as it stands; slopes do not enter, which keeps the search cheap.
    if like is None:
        sizes, lengths = _sizes(*CONSTANTS.discrepancy_range, CONSTANTS.discrepancy_sizes), range(whitening.unexplained.shape[0])
        reciprocal, logarithm = (of[:, kept] for of in whitening.variances(sizes))
    else:
        sizes, lengths = np.array([like.size]), range(like.length, like.length + 1)
        variance = whitening.least[kept] + like.size**2 * whitening.unexplained[like.length][kept]
        reciprocal, logarithm = (of[None, :, None] for of in (1 / variance, np.log(variance)))
    chi, spread = _between_trials(reciprocal @ tail)  # (lengths, groups, sizes)
    logs = -0.5 * ((logarithm @ counts[..., None])[..., 0] + chi + spread).sum(axis=1) - 0.5 * float(point @ point)
    logs -= np.log1p((sizes / CONSTANTS.usual_discrepancy) ** 2)
    logs[np.isnan(logs)] = -np.inf  # of what cannot be computed no data are likely
    best = np.unravel_index(np.argmax(logs), logs.shape)
    log, length, size = float(logs[best]), lengths[int(best[0])], float(sizes[best[1]])
    weights = 1 / (whitening.least + size**2 * whitening.unexplained[length])
    total = known(grams, weights[kept] * trust)
    normal = total[:-1, :-1] + np.eye(point.size)
    step = np.asarray(np.linalg.solve(normal, total[:-1, -1] - point), dtype=np.float64)
    covariance = np.asarray(np.linalg.inv(normal), dtype=np.float64)
    evidence = log - 0.5 * float(np.linalg.slogdet(normal)[1])
    return Likelihood(size, length, log, evidence, step, covariance, weights)


@cache
def _sizes(low: float, high: float, count: int) -> FloatArray:
    """Of a discrepancy, in the rms of a channel, as they are tried: (1 + count,)."""
    return np.concatenate([[0.0], np.geomspace(low, high, count)])


def _between_trials(tail: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of weighted products (..., (1 + RANDOM)^2): the residual's square where what differs between trials is integrated out, and the log
    determinant of that (Woodbury). By elimination, all matrices at once; they are positive definite."""
    # Which matrix is the last index, so that each step runs over all of them in one go.
    products = np.moveaxis(tail.reshape(*tail.shape[:-1], 1 + RANDOM, 1 + RANDOM), (-2, -1), (0, 1)).copy()
    log_determinant = np.zeros(tail.shape[:-1])
    for way in range(RANDOM, 0, -1):
        pivot = 1 + products[way, way]
        row = products[way, :way]
        products[:way, :way] -= row[:, None] * (row / pivot)
        log_determinant += np.log(pivot)
    return products[0, 0], log_determinant


def known(grams: FloatArray, weights: FloatArray) -> FloatArray:
    """Information on [slopes, residual] (p + 1, p + 1), from grams (groups, bands, w, w) and what their squares count (groups, bands)."""
    products = (weights[:, None, :] @ grams.reshape(*weights.shape, -1))[:, 0].reshape(len(grams), *grams.shape[-2:])
    first = products.shape[-1] - RANDOM
    inner, across = np.eye(RANDOM) + products[:, first:, first:], products[:, first:, :first]
    information: FloatArray = (products[:, :first, :first] - across.transpose(0, 2, 1) @ np.linalg.solve(inner, across)).sum(axis=0)
    return information
