"""Is what noise alone leaves of a structural square known as well as is said?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.gap.budget import is_visible, squares, variance_along
from evat.inference.band_whitening import BandWhitening
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import Prediction
from scipy.signal import lfilter
from toy import Toy, measured


@pytest.mark.parametrize("gain", [0.0, 0.01, 0.03])
def test_gains_between_trials_are_no_visible_gap(gain: float) -> None:
    """The true model, noise and spread known: taken as independent from sample to sample, gains were seen as a gap in one of four."""
    made = measured(repeats=3, conditions=2, noise=0.05)
    prediction = Prediction(Toy(), made)
    predicted, draw = prediction.one(), np.random.default_rng(8)
    told = estimate_noise(prediction, predicted)
    noise = replace(
        told,
        filters={"F": np.array([1.0])},
        sizes=np.full(len(prediction.segments), 0.05),
        spread={"F": np.array([gain, 0.0, 0.0])},
    )
    seen, unsure, structural = 0, [], []
    for _ in range(200):
        prediction.measured = predicted + 0.05 * draw.normal(size=predicted.size)
        for segment in prediction.segments:
            prediction.measured[segment.at] += gain * draw.normal() * predicted[segment.at]
        whitening = BandWhitening(prediction, noise, predicted)
        table = squares(whitening, predicted)
        seen += is_visible(table)
        unsure.append(table["F"].unsure)
        # what is cut at nothing: half of a distribution about it
        structural.append(table["F"].structural)
    assert seen <= 4
    assert np.sqrt(2 * np.mean(np.square(structural))) == pytest.approx(np.mean(unsure), rel=0.5)


@pytest.mark.parametrize(("memory", "gain"), [(0.0, 0.0), (0.9, 0.0), (0.9, 0.02)])
def test_what_noise_adds_up_to_along_a_direction_goes_by_its_memory(memory: float, gain: float) -> None:
    """Taken for white, a noise with a memory of 0.9 was four times as surprising as it was: a held-out condition that a true model
    foresaw as well as it can be foreseen was "made worse"."""
    prediction = Prediction(Toy(), measured(repeats=1, conditions=2))
    predicted, draw = prediction.one(), np.random.default_rng(3)
    told = estimate_noise(prediction, predicted)
    filter_ = np.array([1.0, -memory]) if memory else np.array([1.0])
    noise = replace(told, filters={"F": filter_}, sizes=np.full(2, 0.05), spread={"F": np.array([gain, 0.0, 0.0])})
    whitening = BandWhitening(prediction, noise, predicted)
    at = whitening.groups[1].at
    direction = np.sin(np.arange(at.stop - at.start) / 30)
    drawn = lfilter([1.0], filter_, 0.05 * draw.normal(size=(4000, direction.size + 200)))[:, 200:]
    sums = drawn @ direction + gain * draw.normal(size=4000) * (predicted[at] @ direction)
    assert variance_along(whitening, 1, direction, predicted) == pytest.approx(np.var(sums), rel=0.1)
