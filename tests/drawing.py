"""What do the tests draw at random?"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as some


def between(low: float, high: float) -> some.SearchStrategy[float]:
    """Any order of magnitude from low to high."""
    return some.floats(np.log10(low), np.log10(high)).map(lambda power: float(10**power))
