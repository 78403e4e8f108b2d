"""How is a recorded column freed of its noise, or differentiated? By local parabolas, each as wide as the record allows.

The window is, at each sample, the widest whose estimate contradicts no narrower one (intersection of confidence intervals: Goldenshluger
and Nemirovski 1997, Katkovnik 1999): wide at rest and in sliding, narrow at a corner.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from evat.constants import CONSTANTS
from evat.model import FloatArray


def noise_sd(column: FloatArray) -> float:
    """Standard deviation of the white noise in a column (n,), 0 where it has none that could be told from its motion."""
    if column.size < CONSTANTS.fewest_input_samples:
        return 0.0
    third = np.diff(column, 3)
    size = 1.4826 * float(np.median(np.abs(third)))
    if not size > CONSTANTS.least_input_noise * float(np.max(np.abs(column))):
        return 0.0
    held = np.clip(third, -3 * size, 3 * size)  # corners of the motion have no say
    correlation = float(held[1:] @ held[:-1] / (held @ held))
    return float(size / np.sqrt(20.0)) if correlation < CONSTANTS.white_third_differences else 0.0  # of white noise of sd 1


def quantum(column: FloatArray) -> float:
    """Step of a quantised column (n,), such as an encoder's; 0 where it is not quantised."""
    steps = np.abs(np.diff(column))
    steps = steps[steps > CONSTANTS.least_quantum * float(np.max(np.abs(column), initial=0.0))]
    if steps.size < CONSTANTS.fewest_input_samples:
        return 0.0
    least = float(steps.min())
    multiples = steps / least
    whole = float(np.mean(np.abs(multiples - np.round(multiples)) < CONSTANTS.quantum_error))
    is_quantised = whole > CONSTANTS.quantised_share and np.median(multiples) < CONSTANTS.largest_quantised_difference
    return least if is_quantised else 0.0


def smoothed(column: FloatArray, sd: float) -> FloatArray:
    """A column (n,) whose white noise has this standard deviation, without it; runs of zeros stay, and no value leaves the range."""
    best = _by_widest_windows(column, sd, 0, 1.0)
    zero = column == 0
    zero[1:-1] &= (column[:-2] == 0) | (column[2:] == 0)
    best[zero] = 0.0
    return np.clip(best, column.min(), column.max())


def derivative(column: FloatArray, step: float, order: int = 1) -> FloatArray:
    """Of a column (n,) whose samples are `step` [s] apart, the first or second derivative; as much smoothed as its noise or its quantum
    asks for."""
    sd = max(noise_sd(column), quantum(column) / np.sqrt(12))
    if sd == 0:
        for _ in range(order):
            column = np.gradient(column, step)
        return column
    return _by_widest_windows(column, sd, order, step)


def _by_widest_windows(column: FloatArray, sd: float, deriv: int, step: float) -> FloatArray:
    low, high = np.full(column.size, -np.inf), np.full(column.size, np.inf)
    best, going = column.copy(), np.ones(column.size, dtype=bool)
    for half in CONSTANTS.smoothing_windows:
        window = 2 * half + 1
        if window > column.size:
            break
        order = max(min(2, window - 2), deriv)
        fitted = savgol_filter(column, window, order, deriv=deriv, delta=step, mode="interp")
        weights = savgol_coeffs(window, order, deriv=deriv, delta=step)
        reach = CONSTANTS.smoothing_confidence * sd * float(np.sqrt(np.sum(weights**2)))
        low, high = np.maximum(low, fitted - reach), np.minimum(high, fitted + reach)
        going &= low <= high
        best[going] = fitted[going]
    return best
