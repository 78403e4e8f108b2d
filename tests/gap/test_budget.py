"""Is what noise alone leaves of a structural square known as well as is said?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.gap.budget import is_visible, squares
from evat.inference.band_whitening import BandWhitening
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import Prediction
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
