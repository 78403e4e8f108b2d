"""How does the noise of a recording that nobody repeated go on from sample to sample? It is read where the residual of a model is calm.

What a model lacks is smooth within some samples, or comes with an event: a reversal, an entry, a jump. So the residual is cut into short
windows, a parabola is taken out of each, and the calmest of them tell the correlation of neighbouring samples. What that is of a
first-order autoregression, less its parabolas, where it is as calm, is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from scipy.linalg import toeplitz

from evat.constants import CONSTANTS
from evat.inference.noise.autoregression import autocovariance, robust_sd
from evat.model import BoolArray, FloatArray


def autoregression_where_calm(rows: Sequence[FloatArray]) -> FloatArray | None:
    """The whitening filter (1, a_1) of noise that stands in each row (n,) beside what a model lacks; None where the rows are too short to
    tell, and where what they hold is smoother than the noise of a sensor, which a model may lack everywhere."""
    if window_count(rows) < CONSTANTS.fewest_calm_windows:
        return None
    width = int(CONSTANTS.calm_window)
    windows = np.concatenate([np.lib.stride_tricks.sliding_window_view(row, width)[:: width // 2] for row in rows if row.size >= width])
    correlation = _correlation_where_calm(windows @ _without_parabola(width))
    coefficients, expected = _expected(width, CONSTANTS.memory_of_sensors)
    if not correlation <= expected[-1]:
        return None
    return np.array([1.0, -float(np.interp(correlation, expected, coefficients))])


def window_count(rows: Sequence[FloatArray]) -> int:
    """How many windows there are in rows (n,), each half in the next."""
    width = int(CONSTANTS.calm_window)
    return sum((row.size - width) // (width // 2) + 1 for row in rows if row.size >= width)


def innovation_sd_where_calm(filter_: FloatArray, row: FloatArray, beside_jumps: BoolArray | None = None) -> float:
    """Standard deviation of the innovations of noise in a row (n,) whose filter is known, by its second differences: these are next to free
    of what a model lacks, but where it has a jump at another place: the samples of `beside_jumps` (n,), which are left out unless there are
    few others."""
    lags, second = autocovariance(filter_, 3), np.diff(row, 2)
    if beside_jumps is not None:
        clear = ~(beside_jumps[:-2] | beside_jumps[1:-1] | beside_jumps[2:])
        second = second[clear] if np.mean(clear) > CONSTANTS.least_clear_share else second
    return robust_sd(second) / float(np.sqrt(6 * lags[0] - 8 * lags[1] + 2 * lags[2]))


def _correlation_where_calm(windows: FloatArray) -> float:
    """Lag-one correlation in the calmest of the windows (n, width); nan where nothing moves in them."""
    squares = np.sum(windows**2, axis=1)
    calm = windows[squares <= CONSTANTS.calm_squares * np.quantile(squares, CONSTANTS.calm_quantile)]
    square = float(np.sum(calm**2))
    return float(np.sum(calm[:, 1:] * calm[:, :-1])) / square if square > 0 else np.nan


def _without_parabola(width: int) -> FloatArray:
    """Projection (width, width) of a window onto what no parabola has."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, width), 3))
    projection: FloatArray = np.eye(width) - basis @ basis.T
    return projection


@cache
def _expected(width: int, ends: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Coefficients of first-order autoregressions (n,) between these ends, and the lag-one correlation that their calm windows have: of as
    many as make it sure to 0.005, the same at every call."""
    coefficients, white = np.linspace(*ends, 29), np.random.default_rng(0).standard_normal((10000, width))
    ways = [np.linalg.cholesky(toeplitz(a ** np.arange(width))).T @ _without_parabola(width) for a in coefficients]
    return coefficients, np.array([_correlation_where_calm(white @ way) for way in ways])
