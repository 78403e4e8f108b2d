"""Are slopes coloured as the noise is, and is a torn line of a journal known from a whole one?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.identification.searching.journal import _checked, _with_sum
from evat.inference.noise.autoregression import correlated, innovations
from scipy.linalg import toeplitz

TAPS = np.array([1.0, -1.1, 0.3])  # e_t = 1.1 e_(t-1) - 0.3 e_(t-2) + white


def test_coloured_slopes_have_the_correlation_of_the_noise() -> None:
    """(A J)'(A J) = J' C J with C = L L', where L^-1 is the filter that makes the noise white, as a matrix."""
    J = np.random.default_rng(2).normal(size=(60, 3))
    whitens = toeplitz(np.r_[TAPS, np.zeros(57)], np.r_[1.0, np.zeros(59)])
    L = np.linalg.inv(whitens)
    slopes = correlated(TAPS, J)
    assert slopes.T @ slopes == pytest.approx(J.T @ L @ L.T @ J, rel=1e-10)
    assert innovations(TAPS, J) == pytest.approx((whitens @ J)[2:], rel=1e-10)


def test_a_torn_line_is_none() -> None:
    line = _with_sum('{"point": [0.5, 1.0]}')
    assert _checked(line) == '{"point": [0.5, 1.0]}'
    assert all(_checked(line[:n]) is None for n in range(len(line)))
    assert all(_checked(line[:n] + b"?" + line[n + 1 :]) is None for n in range(len(line)))
