"""Beside a jump, is the covariance the one it claims to be? Errors of just that kind are drawn, and looked at once they are whitened."""

from __future__ import annotations

import numpy as np
from evat.constants import CONSTANTS
from evat.inference.noise.discontinuities import Discontinuities

FILTER = np.array([1.0, -0.6, 0.2])
SQUARE_WAVE = np.where(np.arange(400) % 40 < 20, 1.0, -1.0)


def errors(size: float, draws: int) -> np.ndarray:
    """Noise that the filter whitens, and an error of each sample beside a jump: (400, draws)."""
    luck = np.random.default_rng(0)
    innovations = luck.normal(size=(400, draws))
    noise = np.zeros_like(innovations)
    for n in range(400):
        noise[n] = innovations[n] - sum(FILTER[lag] * noise[n - lag] for lag in (1, 2) if n >= lag)
    bend = np.zeros(400)
    bend[1:-1] = np.abs(np.diff(SQUARE_WAVE, 2))
    return np.asarray(size * noise + CONSTANTS.bend_error * bend[:, None] * luck.normal(size=(400, draws)))


def whitened(rows: np.ndarray, size: float) -> np.ndarray:
    innovations = sum(FILTER[lag] * rows[2 - lag : 400 - lag] for lag in range(3)) / size
    return Discontinuities(SQUARE_WAVE, FILTER, size).whiten(innovations)


def test_errors_beside_jumps_become_white_with_the_noise() -> None:
    white = whitened(errors(0.1, 4000), 0.1)
    covariance = white @ white.T / 4000
    # 4000 draws know a variance to 2 %, and 398 of them scatter by four times that.
    assert np.max(np.abs(covariance - np.eye(398))) < 0.11


def test_far_from_jumps_nothing_is_lost() -> None:
    jumps = Discontinuities(SQUARE_WAVE, FILTER, 0.1)
    beside = np.isin(np.arange(400) % 20, (0, 19))
    assert np.all(jumps.weights[np.logical_not(beside)] == 1.0)
    assert np.all(jumps.weights[beside][1:-1] < 0.2)
    assert 0.6 < jumps.share < 0.95


def test_a_smooth_curve_is_no_jump() -> None:
    curve = 100 * np.sin(np.arange(400) / 8)
    assert Discontinuities(curve, FILTER, 0.1).share > 0.97
