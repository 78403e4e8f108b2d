"""Is a sample that lies far from its repeats taken from the others, and one far from its neighbours left unsure, in whatever unit?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.inference.band_whitening import BandWhitening, _without_outliers
from evat.inference.discrepancy import likelihood
from evat.inference.noise.estimate import estimate_noise
from evat.inference.noise.outliers import unsure_outliers
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from known_rigs import MODEL, TO_AND_FRO, TRUTH, experiment, force, trial

LUCK = np.random.default_rng(3)
TRUE = 5 + np.sin(np.linspace(0, 20, 400))


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_far_sample_is_taken_from_the_others(count: int, unit: float) -> None:
    """40 sd off in one repeat: within a few sd of the truth afterwards, the other samples as they were, the repeats' own levels kept."""
    rows = TRUE + 0.01 * LUCK.normal(size=(count, TRUE.size)) + 0.3 * np.arange(count)[:, None]
    spoilt = rows.copy()
    spoilt[1, 77] += 0.4
    cleaned = _without_outliers(unit * spoilt, unit * TRUE) / unit
    assert cleaned[1, 77] == pytest.approx(rows[1, 77], abs=0.06)
    changed = np.abs(cleaned - spoilt) > 1e-9
    assert changed[1, 77]
    assert not changed[:, np.arange(TRUE.size) != 77].any()


def noisy(spoilt: tuple[int, ...] = (), unit: float = 1.0) -> FloatArray:
    noise = 0.01 * np.random.default_rng(4).normal(size=TRUE.size)
    noise[list(spoilt)] += 0.2
    return unit * noise


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_a_sample_far_from_its_neighbours_is_as_unsure_as_it_is_far(unit: float) -> None:
    unsure = unsure_outliers(noisy((77, 300), unit), unit * TRUE) / unit
    assert np.flatnonzero(unsure).tolist() == [77, 300]
    assert unsure[[77, 300]] == pytest.approx(0.2, abs=0.05)
    assert not np.any(unsure_outliers(noisy(unit=unit), unit * TRUE))


def test_what_is_beside_a_jump_or_lasts_or_comes_often_is_none() -> None:
    jump = TRUE + (np.arange(TRUE.size) >= 77)
    assert not np.any(unsure_outliers(noisy((77,)), jump))
    assert not np.any(unsure_outliers(noisy((77,)), TRUE + 0.1 * np.clip(np.arange(TRUE.size) - 74, 0, 6)))  # within two samples' rise
    assert not np.any(unsure_outliers(noisy(tuple(range(77, 87))), TRUE))
    assert not np.any(unsure_outliers(noisy(tuple(range(20, 380, 20))), TRUE))


def test_the_middle_of_a_rise_of_two_samples_is_unsure_where_it_stands_apart() -> None:
    """There a part of a sample in time is as much as the rise, in every cycle; where it does not stand apart it tells of the rise."""
    middles = tuple(range(20, 380, 20))
    rises = TRUE + sum(np.clip((np.arange(TRUE.size) - first + 1) / 2, 0, 1) for first in middles)
    unsure = unsure_outliers(noisy(middles), rises)
    assert np.flatnonzero(unsure).tolist() == list(middles)
    assert unsure[list(middles)] == pytest.approx(0.2, abs=0.05)
    assert not np.any(unsure_outliers(noisy(), rises))


def test_a_spark_is_no_discrepancy_of_the_model() -> None:
    """One sample of 500 that is 30 sd off, in a record that the model explains: no more is left, and no more unsure, than without it."""
    measured = force(TO_AND_FRO)
    sparked = measured.copy()
    sparked[222] += 0.3 * float(np.sqrt(np.mean(measured**2)))
    sizes = []
    for row in (measured, sparked):
        prediction = Prediction(MODEL, experiment(trial(TO_AND_FRO, seed=1, measured=row, noise=0.01), nominal=TRUTH))
        predicted = prediction.one()
        whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
        told = likelihood(whitening, whitening.sums(predicted, np.empty((predicted.size, 0))), np.empty(0))
        sizes.append(told)
    assert sizes[1].size == sizes[0].size
    assert sizes[1].log == pytest.approx(sizes[0].log, abs=30)  # unguarded 300 less
