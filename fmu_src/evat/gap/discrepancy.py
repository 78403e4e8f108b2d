"""How large is what a model leaves unexplained, and how likely are the data then? The likelihood with a smooth discrepancy of unknown size.

Kennedy and O'Hagan 2001: measured = model + discrepancy + noise. Size and correlation length of the discrepancy are found for each model;
one whose form is a little wrong is not punished beyond what it leaves, and one that explains more leaves less.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evat.gap.whitening import Sums, Whitening
from evat.model import BoolArray, FloatArray

SIZES = np.concatenate([[0.0], np.geomspace(5e-4, 1.0, 23)])  # of the rms of a channel
USUAL = 0.02  # a discrepancy of this size is nothing special


@dataclass(frozen=True)
class Likelihood:
    """`size` (of the rms) and `length` (place in CORRELATION_SAMPLES) of the discrepancy; `log` the penalised log likelihood, `evidence`
    its integral over the parameters (Laplace); `step` (p,) to the best parameters from here; `covariance` (p, p) of the parameters;
    `weights` (groups, BANDS): what a whitened square counts."""

    size: float
    length: int
    log: float
    evidence: float
    step: FloatArray
    covariance: FloatArray
    weights: FloatArray


def likelihood(
    whitening: Whitening, sums: Sums, point: FloatArray, *, damping: float = 0.0, held_out: BoolArray | None = None
) -> Likelihood:
    """The best discrepancy for a residual.

    point : (p,), parameters in prior standard deviations from their prior mean; held_out : (groups,), true where not to look.
    """
    kept = np.ones(len(whitening.groups), dtype=bool) if held_out is None else np.logical_not(held_out)
    trust = whitening.trust[kept]
    counts, grams = whitening.counts[kept] * trust, sums.grams[kept] * trust[..., None, None]
    chi = grams[..., -1, -1]
    log, size, length = -np.inf, 0.0, 0
    squares = float(point @ point)
    # Size and length from the residual as it stands; slopes do not enter, which keeps the search cheap.
    for place in range(whitening.unexplained.shape[0]):
        variance = whitening.least[kept] + SIZES[:, None, None] ** 2 * whitening.unexplained[place][kept]
        logs = -0.5 * np.sum(counts * np.log(variance) + chi / variance, axis=(1, 2)) - 0.5 * squares
        logs -= np.log1p((SIZES / USUAL) ** 2)
        if logs.max() > log:
            log, size, length = float(logs.max()), float(SIZES[int(np.argmax(logs))]), place
    weights = 1 / (whitening.least + size**2 * whitening.unexplained[length])
    total = np.einsum("sb,sbij->ij", weights[kept], grams, optimize=True)
    normal = total[:-1, :-1] + np.eye(point.size)
    step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), total[:-1, -1] - point)
    covariance = np.linalg.inv(normal)
    evidence = log - 0.5 * float(np.linalg.slogdet(normal)[1])
    return Likelihood(size, length, log, evidence, step, covariance, weights)
