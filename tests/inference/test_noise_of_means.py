"""Is the noise of means found where nobody stated it, and does each mean and repeat count by its own where somebody did?"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Nominal
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.noise.estimate import estimate_noise
from evat.inference.noise.means import nugget, replicate_sd
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from evat.models.contact import ContactModel
from toy import Toy, measured

LAW = {"kinematics": "external", "friction_law": "lugre", "F_C": 10.0, "F_S": 14.0, "v_s": 0.02, "sigma0": 1e6, "sigma2": 3.0}
SPEEDS = np.array([0.01, 0.01, 0.1, 1.0, 0.3])


def whitened(model: Toy | ContactModel, experiment: Experiment) -> tuple[BandWhitening, FloatArray]:
    prediction = Prediction(model, experiment)
    predicted = prediction.one()
    return BandWhitening(prediction, estimate_noise(prediction, predicted), predicted), predicted


def table(away: list[float], sd: list[float], order: list[int]) -> tuple[BandWhitening, FloatArray]:
    """Mean friction at five speeds, the first two replicates, so far [N] from what the law says."""
    model = ContactModel(1)
    force = model.settled(("friction_force",), (), {**LAW, "slip_velocity": SPEEDS})["friction_force"] + np.array(away)
    names = tuple("aabcd"[place] for place in order)
    rows = {"friction_force": force[order]}, {"friction_force": np.array(sd)[order]}
    means = Means("means.csv", names, {"slip_velocity": SPEEDS[order]}, *rows)
    return whitened(model, Experiment(Path(), "table", "", Nominal({**LAW}, (), {}), {}, (), means, ""))


def log_likelihood(whitening: BandWhitening, predicted: FloatArray) -> float:
    return likelihood(whitening, whitening.sums(predicted, np.empty((predicted.size, 0))), np.empty(0)).log


def test_of_replicates_each_counts_by_its_own_standard_deviation() -> None:
    """One known to 5 N lay 4 N off beside one known to 0.02 N: the true law was 200 of its standard deviations off, or within one, by which
    of them came first."""
    first = table([0, 4.0, 0, 0, 0], [0.02, 5.0, 0.1, 0.1, 0.1], [0, 1, 2, 3, 4])
    second = table([0, 4.0, 0, 0, 0], [0.02, 5.0, 0.1, 0.1, 0.1], [1, 0, 2, 3, 4])
    assert log_likelihood(*first) == pytest.approx(log_likelihood(*second))
    whitening, predicted = first
    assert abs(whitening.residual(predicted, 0)[0]) < 1e-3
    assert whitening.sizes[0] / np.sqrt(2) == pytest.approx(0.02, rel=1e-3)


def test_of_repeats_each_counts_by_its_own_standard_deviation() -> None:
    made = measured(repeats=2, conditions=2, noise=0.01)
    loud = 1.0 * np.random.default_rng(4).normal(size=made.trials[0].times.size)
    logs = []
    for order in ((0, 1), (1, 0)):
        pairs = [made.trials[first : first + 2] for first in (0, 2)]
        trials = [
            replace(pair[n], outputs={"F": pair[n].outputs["F"] + n * loud}, noise_sd={"F": (0.01, 1.0)[n]})
            for pair in pairs
            for n in order
        ]
        whitening, predicted = whitened(Toy(), replace(made, trials=tuple(trials)))
        logs.append(log_likelihood(whitening, predicted))
        assert np.std(whitening.residual(predicted, 0)) == pytest.approx(0.01, rel=0.3)
    assert logs[0] == pytest.approx(logs[1])


def test_a_standard_deviation_of_nothing_is_none() -> None:
    """As a spreadsheet writes it where a condition was measured once; it counted as a millionth of the force."""
    whitening, _ = table([0, 0.2, 0, 0.5, -0.3], [0.3, 0.3, 0.3, 0.0, 0.3], [0, 1, 2, 3, 4])
    assert list(whitening.noise.sizes[[0, 1, 2, 4]]) == [0.3] * 4
    assert 0.05 < whitening.noise.sizes[3] < 2.0


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
