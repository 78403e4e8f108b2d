"""Is the noise of means found where nobody stated it?"""

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.inference.noise.means import nugget, replicate_sd


def smooth(conditions: np.ndarray) -> np.ndarray:
    """What a wrong model leaves: 8 % of the rms, slowly over two conditions."""
    return 0.08 * np.sin(2.0 * conditions[:, 0]) + 0.05 * conditions[:, 1] ** 2


@pytest.mark.parametrize("noise", [0.003, 0.01, 0.04])
def test_noise_is_what_does_not_vary_smoothly(noise: float) -> None:
    ratios = []
    for seed in range(12):
        draw = np.random.default_rng(seed)
        conditions = draw.uniform(0.2, 1.0, (30, 2))
        ratios.append(nugget(conditions, smooth(conditions) + noise * draw.normal(size=30)) / noise)
    assert 0.75 < np.median(ratios) < 1.25
    assert max(ratios) < 2
    assert min(ratios) > 0.5


def test_a_single_mean_says_little() -> None:
    assert 0.3 * CONSTANTS.usual_noise_of_means < nugget(np.ones((1, 1)), np.array([0.05])) < 3 * CONSTANTS.usual_noise_of_means


def test_replicates_tell_their_own() -> None:
    draw = np.random.default_rng(3)
    conditions = [f"c{place // 4}" for place in range(400)]
    column = np.repeat(draw.normal(size=100), 4) + 0.02 * draw.normal(size=400)
    sd, degrees = replicate_sd(conditions, column)
    assert degrees == 300
    assert pytest.approx(0.02, rel=0.1) == sd
    assert replicate_sd(["a", "b"], np.array([1.0, 2.0]))[1] == 0
