"""After how many samples does a column come back to itself?"""

from __future__ import annotations

import numpy as np

from evat.constants import CONSTANTS
from evat.model import FloatArray


def period(column: FloatArray) -> float:
    """Lag in samples at which a column comes back, 0 where it never does; from the mean square of differences at each lag."""
    size = column.size
    most = size * 2 // 3
    squares = np.concatenate([[0.0], np.cumsum(column**2)])
    spectrum = np.fft.rfft(column, 2 * size)
    products = np.fft.irfft(np.abs(spectrum) ** 2)[: most + 1]
    lags = np.arange(most + 1)
    apart = (squares[size - lags] + squares[size] - squares[lags] - 2 * products) / (size - lags)
    level = squares[size] / size
    away = np.flatnonzero(apart > 0.2 * level)
    if away.size == 0:
        return 0.0
    here = apart[1:most]
    low = (here <= apart[: most - 1]) & (here <= apart[2 : most + 1]) & (here < 0.05 * level)
    for n in 1 + np.flatnonzero(low[away[0] :]) + away[0]:
        before, here, after = apart[n - 1 : n + 2]
        bend = before - 2 * here + after
        shift = 0.5 * (before - after) / bend if bend > 0 else 0.0
        if here - 0.25 * (before - after) * shift < CONSTANTS.alike_cycles * level + 0.02 * bend:
            return float(n + shift)
    return 0.0
