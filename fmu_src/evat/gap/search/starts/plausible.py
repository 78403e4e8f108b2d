"""How large is an amplitude where it does what is plausible? Probed from small to large."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.model import FloatArray


def plausible_amplitudes(
    sizes: Callable[[FloatArray, npt.NDArray[np.intp]], FloatArray], least: float, most: float, rows: int
) -> FloatArray:
    """The amplitudes (rows,) at which responses have the plausible size, from one that is near it or else from the largest that has less;
    nan where nothing shows.

    sizes : of responses to amplitudes in some of the rows; from small to large, since what is too large may be slow to simulate.
    """
    amplitude, spreads = np.full(rows, min(least, most)), np.full(rows, np.nan)
    low, high = np.zeros(rows), np.full(rows, np.inf)  # amplitudes that are known to do less and more than what is plausible
    enough, near_enough = CONSTANTS.plausible_effect, CONSTANTS.near_plausible
    going = np.arange(rows)
    for _ in range(CONSTANTS.probes):
        tried = amplitude[going]
        size = sizes(tried, going)
        shows = np.isfinite(size) & (size > CONSTANTS.least_effect)
        less = shows & (size <= enough)
        first = shows & ~less & ~(low[going] > 0)  # too large, and nothing smaller is known to show
        near = shows & (size > enough / near_enough) & (size < enough * near_enough)  # on either side: runs have errors of their own
        with np.errstate(divide="ignore", invalid="ignore"):
            wanted = tried * enough / size
        spreads[going] = np.where(less | first | near, np.minimum(wanted, 10 * tried), spreads[going])
        below = np.isfinite(size) & (size <= enough)
        low[going] = np.where(below, tried, low[going])
        high[going] = np.where(below, high[going], tried)
        onward = np.where(
            shows & below,
            np.minimum(wanted, CONSTANTS.largest_probe_ratio * tried),
            np.where(below, CONSTANTS.largest_probe_ratio * tried, tried / CONSTANTS.largest_probe_ratio),
        )
        between = np.sqrt(low[going] * high[going])
        onward = np.where((low[going] > 0) & (onward >= high[going]) | ~below & (low[going] > 0), between, onward)
        amplitude[going] = np.minimum(onward, most)
        going = going[~near & (amplitude[going] != tried)]
        if not going.size:
            break
    return spreads
