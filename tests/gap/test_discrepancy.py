"""Is the covariance that the likelihood sums up the one that is meant? Against the same likelihood with the whole matrix written out."""

from __future__ import annotations

import numpy as np
import pytest
from evat.gap.search.starts.linear import moved
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import Likelihood, known, likelihood
from evat.inference.law.initial_state import RANDOM
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import Prediction
from toy import Toy, measured


def _whitened() -> tuple[BandWhitening, Prediction]:
    prediction = Prediction(Toy(), measured(["bend"], {"bend.c": 0.2}, conditions=2, repeats=2))
    predicted = prediction.one()
    return BandWhitening(prediction, estimate_noise(prediction, predicted), predicted), prediction


def test_what_differs_between_trials_is_integrated_out() -> None:
    """Gaussian, with covariance 1 + L L' in each group: log density and information by dense matrices."""
    draw = np.random.default_rng(1)
    numbers, slopes, groups = 50, 2, 3
    columns = [np.column_stack([draw.normal(size=(numbers, slopes + 1)), 4 * draw.normal(size=(numbers, RANDOM))]) for _ in range(groups)]
    grams = np.array([[column.T @ column] for column in columns])
    covariances = [np.eye(numbers) + column[:, -RANDOM:] @ column[:, -RANDOM:].T for column in columns]
    wanted = sum(c[:, : slopes + 1].T @ np.linalg.solve(s, c[:, : slopes + 1]) for c, s in zip(columns, covariances, strict=True))
    assert known(grams, np.ones((groups, 1))) == pytest.approx(wanted, rel=1e-9)


def test_the_log_likelihood_is_that_of_the_dense_covariance() -> None:
    whitening, prediction = _whitened()
    sums = whitening.sums(prediction.one(), np.empty((prediction.measured.size, 0)))
    for _ in range(2):
        banded = likelihood(whitening, sums, np.empty(0))
        variance = 1 / banded.weights
        total = 0.0
        for place in range(len(whitening.groups)):
            gram = np.einsum("b,bij->ij", 1 / variance[place], sums.grams[place])
            inner = np.eye(RANDOM) + gram[1:, 1:]
            chi = gram[0, 0] - gram[0, 1:] @ np.linalg.solve(inner, gram[1:, 0])
            total -= 0.5 * (float(whitening.counts[place] @ np.log(variance[place])) + chi + np.linalg.slogdet(inner)[1])
        assert banded.log == pytest.approx(total - np.log1p((banded.size / 0.02) ** 2), rel=1e-9)
        whitening.forgive(0.1, 2)  # what is kept for the next residual goes by this


def test_a_gain_that_no_trial_differs_by_is_no_repeatability() -> None:
    """A model that is off by a tenth in its gain must not come out better than one that is right, however large the discrepancy."""
    whitening, prediction = _whitened()
    right = prediction.one({"k": 10.0, "bend.c": 0.2}, ["bend"])
    none = np.empty((prediction.measured.size, 0))
    logs = [likelihood(whitening, whitening.sums(gain * right, none), np.empty(0)).log for gain in (1.0, 1.1, 1.5)]
    assert logs[0] > logs[1] + 20
    assert logs[1] > logs[2]


def test_the_solvers_error_is_granted_to_every_model() -> None:
    """An error of 5 % of the rms counts as a discrepancy of that size; where there is none, one of 0.2 % is granted."""
    plain, prediction = _whitened()
    predicted = prediction.one()
    error = 0.05 * np.sqrt(np.mean(prediction.measured**2)) * np.where(np.arange(predicted.size) % 2, 1.0, -1.0)
    noise = estimate_noise(prediction, predicted)
    wrong = BandWhitening(prediction, noise, predicted, error)
    assert wrong.least - 1 == pytest.approx((plain.least - 1) * (1 + (0.05 / 0.002) ** 2), rel=1e-9)
    none = np.empty((predicted.size, 0))
    logs = [likelihood(each, each.sums(prediction.measured + error, none), np.empty(0)).log for each in (plain, wrong)]
    assert logs[1] > logs[0]


def test_where_the_discrepancy_dominates_a_band_counts_a_few_numbers() -> None:
    whitening, _ = _whitened()
    assert whitening.trust == pytest.approx(1.0)
    whitening.doubt(0.0, 2)
    assert whitening.trust == pytest.approx(1.0)
    whitening.doubt(100.0, 0)
    counted = (whitening.trust * whitening.counts)[whitening.counts > 5]
    assert np.all(counted < 2.2)
    assert np.all(counted > 1.8)


def test_sums_after_a_step_are_those_taken_there() -> None:
    whitening, prediction = _whitened()
    slopes = np.random.default_rng(1).normal(size=(prediction.measured.size, 3))
    step = np.array([0.3, -0.1, 0.2])
    shifted = moved(whitening.sums(prediction.one(), slopes).grams, step)
    there = whitening.sums(prediction.one() + slopes @ step, slopes).grams
    assert np.allclose(shifted, there, rtol=1e-9, atol=1e-9 * np.max(np.abs(there)))


def test_a_direction_that_roundings_take_for_less_than_exact_has_squares() -> None:
    """A law a thousand times the noise away fixes one direction to 1e-8 of the others; its variance came out at -8e-17."""
    turned = np.array([[0.6, 0.8], [-0.8, 0.6]])
    covariance = turned @ np.diag([1.0, -8e-17]) @ turned.T
    at = Likelihood(1.0, 0, -1e8, -1e8, 0.1 * turned[:, 0], covariance, np.ones((1, 1)))
    row, slopes = at.squares
    assert np.all(np.isfinite(row))
    assert row @ row == pytest.approx(2e8)
    assert turned[:, 0] @ slopes[:-1].T @ slopes[:-1] @ turned[:, 0] == pytest.approx(1.0)
