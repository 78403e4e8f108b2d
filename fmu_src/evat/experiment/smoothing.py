"""How is a recorded column freed of its noise, or differentiated? By local polynomials, each as wide as the record
allows.

The window is, at each sample, the widest whose estimate contradicts no narrower one (intersection of confidence intervals: Goldenshluger
and Nemirovski 1997, Katkovnik 1999): wide at rest and in sliding, narrow at a corner.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import savgol_filter

from evat.constants import CONSTANTS
from evat.model import FloatArray


def noise_sd(column: FloatArray) -> float:
    """Standard deviation of the white noise in a column (n,), 0 where it has none that could be told from its motion."""
    if column.size < CONSTANTS.fewest_input_samples:
        return 0.0
    third = np.diff(column, 3)
    size = 1.4826 * float(np.median(np.abs(third)))
    if not size > _rounding(column, CONSTANTS.least_input_noise):
        return 0.0
    inside = np.abs(third) <= 3 * size  # corners of the motion have no say
    both = inside[1:] & inside[:-1]
    one, next_one = third[:-1][both], third[1:][both]
    correlation = float(one @ next_one) / (float(np.sqrt((one @ one) * (next_one @ next_one))) or 1.0)
    return float(size / np.sqrt(20.0)) if correlation < CONSTANTS.white_third_differences else 0.0  # of white noise of sd 1


def quantum(column: FloatArray) -> float:
    """Step of a quantised column (n,), such as an encoder's; 0 where it is not quantised."""
    steps = np.abs(np.diff(column))
    steps = steps[steps > _rounding(column, CONSTANTS.least_quantum)]
    if column.size < CONSTANTS.fewest_input_samples or steps.size == 0:
        return 0.0
    least = float(steps.min())
    if steps.size < CONSTANTS.fewest_input_samples:  # that few tell of counts only if they are alike, and nothing moves between them
        return least if np.ptp(steps) < CONSTANTS.quantum_error * least and 2 * steps.size < column.size else 0.0
    multiples = steps / least
    whole = float(np.mean(np.abs(multiples - np.round(multiples)) < CONSTANTS.quantum_error))
    is_quantised = whole > CONSTANTS.quantised_share and np.median(multiples) < CONSTANTS.largest_quantised_difference
    return least if is_quantised else 0.0


def _rounding(column: FloatArray, share: float) -> float:
    """What differences of a column (n,) are by rounding: a share of its half range, wherever the zero of its scale lies, but no less than
    floating point leaves beside its values."""
    eps = 8 * float(np.finfo(np.float64).eps)
    return max(0.5 * share * float(np.ptp(column)), eps * float(np.max(np.abs(column)))) if column.size else 0.0


def smoothed(column: FloatArray, sd: float) -> FloatArray:
    """A column (n,) whose white noise has this standard deviation, without it; runs of zeros stay, and no value leaves the range."""
    best = _by_widest_windows(column, sd, 0, 1.0)
    zero = column == 0
    zero[1:-1] &= (column[:-2] == 0) | (column[2:] == 0)
    best[zero] = 0.0
    return np.clip(best, column.min(), column.max())


def position_noise(column: FloatArray) -> float:
    """Standard deviation by which a recorded position is off, its noise or what it is rounded to."""
    return max(noise_sd(column), quantum(column) / math.sqrt(12))


def derivative(column: FloatArray, step: float, order: int = 1, sd: float | None = None) -> FloatArray:
    """Of a column (n,) whose samples are `step` [s] apart, the first or second derivative, at the samples; as much smoothed as its noise or
    its quantum asks for, or one of this `sd`."""
    sd = position_noise(column) if sd is None else sd
    if sd > 0:
        return _by_widest_windows(column, sd, order, step)
    window = CONSTANTS.exact_window
    if column.size >= window:  # of 12 samples a period plain differences lose 4 %, and the first of them comes half a sample late
        exact: FloatArray = savgol_filter(column, window, window - 1, deriv=order, delta=step, mode="interp")
        return exact
    for _ in range(order):
        column = np.gradient(column, step)
    return column


def mean_step(times: FloatArray) -> float:
    """The sampling interval [s] of a clock (n,), n > 1: the mean of its steps, for one that is written in whole microseconds may have no
    step that long; without those in which samples were lost."""
    steps = np.diff(times)
    return float(np.mean(steps[steps < CONSTANTS.lost_samples * np.median(steps)]))


def _by_widest_windows(column: FloatArray, sd: float, deriv: int, step: float) -> FloatArray:
    """The surest of what each kind of window tells; of those that are as sure their mean, or a motion would lag by what looks ahead."""
    told, sds = (np.array(rows) for rows in zip(*(_by_widest(column, sd, deriv, step, *kind) for kind in _kinds(deriv)), strict=True))
    surest: FloatArray = np.average(told, axis=0, weights=sds <= (1 + CONSTANTS.as_sure) * sds.min(axis=0))
    return surest


def _kinds(deriv: int) -> tuple[tuple[int, float], ...]:
    """What is fitted: the order of a polynomial, and the place of the sample in its window."""
    if deriv == 0:
        return ((2, 0.5),)
    if deriv == 2:  # an acceleration comes and goes: a polynomial of fourth order has a window in which that fits
        return (2, 0.5), (4, 0.5)
    # A parabola tells the slope at its middle no better than a line does; a cubic follows a reversal, and swings where a motion stops:
    # there lines to either side know more.
    return (3, 0.5), (2, 0.5), (1, 0.0), (1, 1.0)


def _by_widest(column: FloatArray, sd: float, deriv: int, step: float, order: int, place: float) -> tuple[FloatArray, FloatArray]:
    """By windows of one kind, and how far off that may be as a standard deviation in that of the noise. place : of the sample in its
    window, 0 at the begin and 1 at the end."""
    own = CONSTANTS.sample_confidence * sd if deriv == 0 else np.inf  # a sample tells by itself where a corner is, and no slope
    low, high = column - own, column + own
    counted = np.concatenate([[0], np.cumsum(np.diff(column) != 0)])  # how often it has changed before each sample
    best, sds, going = column.copy(), np.full(column.size, np.inf), np.ones(column.size, dtype=bool)
    for half in CONSTANTS.smoothing_windows:
        window = 2 * half + 1
        if window > column.size:
            break
        weights = _weights(window, max(min(order, window - 2), deriv), deriv) / ((window - 1) * step) ** deriv
        before = round(place * (window - 1))
        after = window - 1 - before  # at the ends of the record the sample has another place in the first and the last window
        places = np.repeat(np.arange(window), np.where(np.arange(window) == before, column.size - window + 1, 1))
        fitted = np.concatenate(
            [weights[:before] @ column[:window], np.correlate(column, weights[before]), weights[window - after :] @ column[-window:]]
        )
        own_sds = np.sqrt(np.sum(weights**2, axis=1))[places]
        if deriv > 0:
            own_sds = own_sds * _by_counts(counted, window)
        reach = CONSTANTS.smoothing_confidence * sd * own_sds
        low, high = np.maximum(low, fitted - reach), np.minimum(high, fitted + reach)
        going &= low <= high
        best[going], sds[going] = fitted[going], own_sds[going]
    return best, sds


def _by_counts(counted: FloatArray, window: int) -> FloatArray:
    """By how much less sure (n,) a window is than where noise is new in every sample: a counted position stands between its counts, and
    tells as many independent numbers as counts pass. Else a slow motion, of many samples a count, would stand still.

    By the counts that pass within its length to either side, alike for all kinds of windows: those that happen to see one are no surer."""
    place = np.arange(counted.size)
    first, last = np.maximum(place - (window - 1), 0), np.minimum(place + (window - 1), counted.size - 1)
    passed = (window - 1) * (counted[last] - counted[first]) / (last - first)
    factor: FloatArray = np.sqrt(window / (passed + 1))
    return factor


def _weights(window: int, order: int, deriv: int) -> FloatArray:
    """Of the samples of a window (n, n), by which a polynomial through them tells the derivative at each of its places, for a window from 0
    to 1."""
    at = np.linspace(0.0, 1.0, window)
    derived = np.array([np.polyval(np.polyder(power, deriv), at) for power in np.eye(order + 1)])
    weights: FloatArray = derived.T @ np.linalg.pinv(np.vander(at, order + 1))
    return weights
