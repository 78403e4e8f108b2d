"""Is the noise of recordings right that nobody repeated, though it goes on from sample to sample and a model lacks something beside it?"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from evat.gap.budget import squares
from evat.inference.band_whitening import BandWhitening
from evat.inference.noise.autoregression import autocovariance
from evat.inference.noise.calm_windows import autoregression_where_calm
from evat.inference.noise.estimate import estimate_noise
from evat.inference.noise.synchronous_average import without_synchronous_average
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from known_rigs import MODEL, STEP, TO_AND_FRO, TRUTH, experiment, force, trial
from scipy.signal import lfilter

CONDITIONS, SD = 4, 0.1
MOTIONS = [scale * TO_AND_FRO for scale in np.linspace(0.7, 1.6, CONDITIONS)]


def coloured(memory: float, seed: int, count: int) -> FloatArray:
    white = np.random.default_rng(seed).standard_normal(count + 200)
    noise: FloatArray = SD * np.sqrt(1 - memory**2) * lfilter([1.0], [1.0, -memory], white)[200:]
    return noise


def recorded(
    memory: float, lacks: Callable[[FloatArray], FloatArray] = np.zeros_like, motions: Sequence[FloatArray] = MOTIONS
) -> Prediction:
    """A recording of each motion; lacks : from a velocity what no law has of the force [N]."""
    trials = []
    for place, motion in enumerate(motions):
        clean = force(motion) + lacks(motion) + coloured(memory, place, motion.size)
        trials.append(trial(motion, f"c{place}", noise=0.0, measured=clean))
    return Prediction(MODEL, experiment(*trials, nominal=TRUTH))


def level(prediction: Prediction) -> float:
    """The standard deviation of its noise as it is estimated."""
    noise = estimate_noise(prediction, prediction.one())
    filter_ = noise.filters["friction_force"]
    return float(np.median(noise.sizes) * np.sqrt(autocovariance(filter_, 1)[0]))


@pytest.mark.parametrize("memory", [-0.3, 0.0, 0.3, 0.6, 0.7])
def test_noise_that_goes_on_is_as_large_as_it_is(memory: float) -> None:
    """By second differences of white noise it would be 1.2 to 0.4 times as large."""
    assert level(recorded(memory)) == pytest.approx(SD, rel=0.12)


@pytest.mark.parametrize(
    "lacks",
    [
        lambda v: 3.0 * np.tanh(v / 0.02) * (np.abs(v) < 0.02),  # at each reversal, thirty times the noise
        lambda v: 0.4 * np.sin(2 * np.pi * 31.0 * STEP * np.arange(v.size)),  # a line, four times the noise
        lambda v: 1.0 * np.cumsum(v) / np.max(np.abs(np.cumsum(v))),  # slow
    ],
    ids=["reversals", "line", "slow"],
)
@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_what_a_model_lacks_is_no_noise(memory: float, lacks: Callable[[FloatArray], FloatArray]) -> None:
    assert level(recorded(memory, lacks)) == pytest.approx(SD, rel=0.2)


FAST = {
    "at each reversal": lambda v: 0.5 * np.sign(v),  # ten times the noise between neighbours
    "over half a cycle": lambda v: 1.0 * np.maximum(v, 0.0) / np.max(v),
    "as something slow turns": lambda v: 0.5 * np.sign(v) * (1.0 + 0.5 * np.sin(2 * np.pi * 1.3 * np.arange(v.size) / v.size)),
    "as something wears": lambda v: 1.0 * np.sign(v) * np.arange(v.size) / v.size,
}


@pytest.mark.parametrize("lacks", FAST.values(), ids=FAST.keys())
@pytest.mark.parametrize(("samples", "size"), [(16.0, 1500), (24.3, 1500), (90.0, 1500), (66.0, 264)])
@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_what_a_model_lacks_in_each_cycle_of_a_fast_motion_is_no_noise(
    memory: float, samples: float, size: int, lacks: Callable[[FloatArray], FloatArray]
) -> None:
    """No window of such a recording is calm. By second differences of white noise it would be 0.6 to 2.4 times as large."""
    places = np.arange(size)
    motions = [scale * np.sin(2 * np.pi * places / samples + 0.1) for scale in (0.04, 0.05, 0.06, 0.08)]
    assert level(recorded(memory, lacks, motions)) == pytest.approx(SD, rel=0.25)


@pytest.mark.parametrize(("size", "samples"), [(160, 50.0), (1500, 24.3), (1500, 119.3), (20000, 7.7)])
def test_noise_keeps_its_size_without_synchronous_average(size: int, samples: float) -> None:
    row = SD * np.random.default_rng(1).standard_normal(size)
    without = without_synchronous_average(row, samples)
    assert np.std(without) == pytest.approx(SD, rel=4 / np.sqrt(2 * size))
    assert not np.allclose(without, row, rtol=0.0, atol=0.01 * SD)


def test_a_model_that_is_right_leaves_no_structure_beside_noise_that_goes_on() -> None:
    prediction = recorded(0.6)
    predicted = prediction.one()
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    own = squares(whitening, predicted)["friction_force"]
    assert own.structural < 3 * own.unsure
    assert own.structural < 0.1 * own.noise


def test_what_is_smoother_than_a_sensor_tells_nothing_of_noise() -> None:
    """A model may lack it everywhere: then second differences count, as if they were white."""
    slow = np.cumsum(np.cumsum(np.random.default_rng(2).standard_normal((4, 2000)), axis=1), axis=1)
    assert autoregression_where_calm(list(slow)) is None
    assert autoregression_where_calm([slow[0, :100]]) is None
    assert autoregression_where_calm([np.zeros(2000)]) is None
