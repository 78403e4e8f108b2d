"""Do 90 % intervals cover the truth nine times in ten? Fifty truths, each with noise of its own; parameters that are called identified."""

from __future__ import annotations

import numpy as np
import pytest
from evat.identification import Settings, identify
from known_rigs import FREE, MODEL, TIMES, TRUTH, experiment, trial

TRUTHS = 50
NAMES = ("F_C", "F_S", "sigma0", "sigma2", "v_s")


def covered(count: int, first: int = 0) -> tuple[int, int]:
    """How many of how many intervals of identified parameters hold the truth. Truths within a factor of two of the usual one, 1 % noise."""
    inside = whole = 0
    for place in range(first, first + count):
        rng = np.random.default_rng(1000 + place)
        truth = {**TRUTH, **{name: float(TRUTH[name]) * 2 ** rng.uniform(-1, 1) for name in FREE}}
        truth["F_S"] = float(truth["F_C"]) * rng.uniform(1.1, 1.6)
        slip = 0.05 * np.sin(2 * np.pi * TIMES) + 0.002 * np.sin(2 * np.pi * rng.uniform(5, 9) * TIMES)
        nominal = {**truth, **{name: float(truth[name]) * rng.uniform(0.8, 1.25) for name in NAMES}}
        rig = experiment(trial(slip, values=truth, seed=place), nominal={**nominal, "sigma1": truth["sigma1"]})
        found = identify(rig, MODEL, NAMES, Settings(search="de", population=24, generations=25, seed=place))
        for estimate in found.estimates:
            if estimate.verdict == "identified":
                whole += 1
                inside += estimate.low <= float(truth[estimate.name]) <= estimate.high
    return inside, whole


def test_intervals_cover_the_truth_of_a_few() -> None:
    """Eight truths, some 40 intervals, of which those of one truth go together: fewer than 24 of 40 would be far from 90 %."""
    inside, whole = covered(8)
    assert whole >= 32
    assert inside / whole > 0.6


@pytest.mark.campaign
def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    inside, whole = covered(TRUTHS)
    assert whole > 4 * TRUTHS
    assert 0.85 <= inside / whole <= 0.95
