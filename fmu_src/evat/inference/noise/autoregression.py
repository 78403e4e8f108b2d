"""How does noise go on from sample to sample? As an autoregression: Yule and Walker's equations, the order by Schwarz's criterion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from evat.constants import CONSTANTS
from evat.model import FloatArray

WHITE: FloatArray = np.array([1.0])


def robust_sd(row: FloatArray) -> float:
    """Median absolute deviation as a standard deviation, or that of the clipped row (n,) where it is larger (heavy tails)."""
    middle = 1.4826 * float(np.median(np.abs(row)))
    return (
        float(np.sqrt(np.mean(np.clip(row, -CONSTANTS.clipped_at * middle, CONSTANTS.clipped_at * middle) ** 2)))
        if middle > 0
        else float(np.std(row))
    )


def autoregression(rows: Sequence[FloatArray]) -> FloatArray:
    """The whitening filter (1, a_1, ..., a_p) of noise of which each row is a recording; [1] where it is white or too short to tell.

    From pooled autocovariances of clipped rows (Brockwell and Davis 1991, sections 8.1 and 9.3): neither a burst in one row nor the step
    from one row to the next is taken for correlation.
    """
    rows = [row for row in rows if row.size >= CONSTANTS.samples_per_lag]
    count = sum(row.size for row in rows)
    shortest = min((row.size for row in rows), default=0)  # its first samples, whose past is unknown, are lost
    most = min(CONSTANTS.most_lags, count // CONSTANTS.samples_per_lag, max(shortest // CONSTANTS.samples_per_lag, CONSTANTS.usual_lags))
    covariance = np.zeros(most + 1)
    for row in rows:
        limit = CONSTANTS.clipped_at * max(robust_sd(row), 1e-300)
        clipped = np.clip(row, -limit, limit)
        covariance += [float(clipped[lag:] @ clipped[: clipped.size - lag]) / count for lag in range(most + 1)]
    if covariance[0] <= 0:
        return WHITE
    best, whitening = count * np.log(covariance[0]), WHITE
    for order in range(1, most + 1):
        weights = solve_toeplitz(covariance[:order], covariance[1 : order + 1])
        variance = covariance[0] - float(weights @ covariance[1 : order + 1])
        if variance <= 1e-12 * covariance[0]:
            break
        score = count * np.log(variance) + order * np.log(count)
        if score < best:
            best, whitening = score, np.concatenate([[1.0], -weights])
    return whitening


def innovations(whitening: FloatArray, columns: FloatArray) -> FloatArray:
    """Columns (n,) or (n, p) through the filter; the first samples, whose past is unknown, are left out: (n - order, ...)."""
    filtered: FloatArray = lfilter(whitening, [1.0], columns, axis=0)[whitening.size - 1 :]
    return filtered


def innovation_sd(whitening: FloatArray, rows: Sequence[FloatArray]) -> float:
    """Root mean square of the innovations of recordings; one that is too short for the filter counts as it is."""
    shocks = [innovations(whitening, row) if row.size > whitening.size else row for row in rows]
    return float(np.sqrt(np.mean(np.concatenate(shocks) ** 2)))


def correlated(whitening: FloatArray, columns: FloatArray) -> FloatArray:
    """A J of columns J (n, p), where A A' is the correlation matrix of the noise up to a factor: (A J)'(A J) = J' correlation J."""
    coloured: FloatArray = lfilter([1.0], whitening, columns[::-1], axis=0)[::-1]
    return coloured


def impulse_response(whitening: FloatArray, length: int = 400) -> FloatArray:
    """What the noise is after one innovation of size 1: (length,)."""
    impulse = np.zeros(length)
    impulse[0] = 1.0
    response: FloatArray = lfilter([1.0], whitening, impulse)
    return response


def autocovariance(whitening: FloatArray, length: int) -> FloatArray:
    """Of the noise whose innovations have a variance of 1, at lags 0 to length - 1: (length,)."""
    response = impulse_response(whitening, length + 400)
    covariance: FloatArray = np.correlate(response, response, "full")[response.size - 1 :][:length]
    return covariance


def lag_one_correlation(rows: Sequence[FloatArray]) -> float:
    """Correlation of neighbouring samples: 0 for white noise, near 1 where a residual holds something slow."""
    above = sum(float(np.sum(row[1:] * row[:-1])) for row in rows)
    below = sum(float(np.sum(row * row)) for row in rows)
    return above / below if below > 0 else 0.0
