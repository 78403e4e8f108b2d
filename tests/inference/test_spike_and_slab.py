"""Is the evidence that of a law which may have its textbook form exactly? Against integrals in closed form."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.inference.parameters import Parameter
from evat.inference.spike_and_slab import log_evidence_of_spikes
from evat.model import FloatArray
from scipy.stats import multivariate_normal

SPIKES = ("", "stribeck", "form", "form")


def parameters(spikes: tuple[str, ...] = SPIKES) -> list[Parameter]:
    return [Parameter(f"p{k}", "1", 0.0, 1.0, -math.inf, math.inf, spike=spike) for k, spike in enumerate(spikes)]


def log_evidence(columns: FloatArray, measured: FloatArray) -> float:
    """Of measured = columns u + noise of 1, u standard normal."""
    return float(multivariate_normal(cov=np.eye(measured.size) + columns @ columns.T).logpdf(measured))


@pytest.mark.parametrize("truth", [(1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 1.5, -1.0), (0.0, 2.0, 0.0, 0.0)])
def test_it_is_the_mean_over_all_that_may_be_usual(truth: tuple[float, ...]) -> None:
    random = np.random.default_rng(1)
    columns = random.normal(size=(30, 4))
    measured = columns @ np.array(truth) + random.normal(size=30)
    covariance = np.linalg.inv(np.eye(4) + columns.T @ columns)
    mean = covariance @ columns.T @ measured
    each = []
    for usual in itertools.product((False, True), repeat=2):
        gone = {name for name, chosen in zip(("stribeck", "form"), usual, strict=True) if chosen}
        prior = math.prod(CONSTANTS.usual_form if chosen else 1 - CONSTANTS.usual_form for chosen in usual)
        kept = [k for k, spike in enumerate(SPIKES) if spike not in gone]
        each.append(math.log(prior) + log_evidence(columns[:, kept], measured))
    right = float(np.logaddexp.reduce(each)) - log_evidence(columns, measured)
    assert log_evidence_of_spikes(parameters(), mean, covariance) == pytest.approx(right, abs=1e-9)


def test_what_the_data_say_nothing_of_adds_nothing() -> None:
    assert log_evidence_of_spikes(parameters(), np.zeros(4), np.eye(4)) == pytest.approx(0, abs=1e-12)
    assert log_evidence_of_spikes(parameters(("", "")), np.ones(2), np.eye(2)) == 0
