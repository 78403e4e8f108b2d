"""Is a misfit told from noise by as many sd as it is, whatever the noise's correlation?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Experiment, Means
from evat.inference.noise.lack_of_fit import lack_of_fit
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from evat.models.contact import ContactModel
from evat.studies.orthogonal import orthogonal
from scipy.signal import lfilter

RIG = orthogonal({"friction_law": "coulomb", "F_C": 8.0}, motion="reversal", repeats=3, speeds=[0.1, 0.5], rate=500.0)
PREDICTION = Prediction(ContactModel(threads=1), RIG)


def noise(seed: int, correlation: float) -> FloatArray:
    draws = np.random.default_rng(seed).standard_normal((len(RIG.trials), RIG.trials[0].times.size))
    return np.concatenate(list(lfilter([np.sqrt(1 - correlation**2)], [1.0, -correlation], draws, axis=1)))


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_noise_alone_is_a_standard_normal_number(correlation: float) -> None:
    """To a third, over 60 draws: a spread of 1 has a standard error of 9 %, and the correlation is an estimate."""
    sds = [lack_of_fit(PREDICTION, noise(seed, correlation))["friction_force"] for seed in range(60)]
    assert abs(np.mean(sds)) < 0.4
    assert 0.67 < np.std(sds) < 1.33


def test_a_curve_that_repeats_share_is_told() -> None:
    """A third of the noise, in a residual that is 5 % more than the noise for it; a zero of each trial for itself is none."""
    curve = np.concatenate([np.sin(20 * trial.times / trial.times[-1]) for trial in RIG.trials])
    zeros = np.repeat(np.random.default_rng(1).standard_normal(len(RIG.trials)), RIG.trials[0].times.size)
    assert lack_of_fit(PREDICTION, noise(1, 0.0) + 0.45 * curve)["friction_force"] > 5
    assert lack_of_fit(PREDICTION, noise(1, 0.0) + zeros)["friction_force"] < 3


def test_few_replicates_tell_by_their_chance() -> None:
    """Averages of four conditions, two of each: by F of 4 and 4 degrees of freedom."""
    conditions = tuple("aabbccdd")
    means = Means("m.csv", conditions, {"cutting_speed": 0.1 * np.ones(8)}, {"mean_feed_force": np.ones(8)}, {})
    prediction = Prediction(ContactModel(threads=1), replace(RIG, trials=(), means=means))
    apart = np.tile([1.0, -1.0], 4)
    assert lack_of_fit(prediction, apart)["mean_feed_force"] < 0
    # F = 2 * 3^2 / 2 = 9: a chance of 0.028, 1.91 sd
    assert lack_of_fit(prediction, apart + 3.0)["mean_feed_force"] == pytest.approx(1.91, abs=0.01)


def test_what_was_recorded_once_tells_nothing() -> None:
    once: Experiment = replace(RIG, trials=RIG.trials[:1])
    assert lack_of_fit(Prediction(ContactModel(threads=1), once), np.ones(once.samples)) == {}
