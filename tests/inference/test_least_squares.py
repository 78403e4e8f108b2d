"""Does the one search for an optimum end where it should: at a bound, where a model runs, where the likelihood is largest?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.fit import fit
from evat.inference.least_squares import least_squares
from evat.inference.noise.estimate import estimate_noise
from evat.inference.parameters import nominal_parameters
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from toy import Toy, measured

HOW = {"most": 50, "gain": 1e-10, "step": 1e-10}


def valley(point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rosenbrock's, least at (1, 1)."""
    x, y = point
    return np.array([10 * (y - x**2), 1 - x]), np.array([[-20 * x, 10.0], [-1.0, 0.0]])


def test_a_bound_is_kept_and_reached() -> None:
    """At x = 0.5 the least is y = 0.25, exactly."""
    inside = least_squares(valley, np.array([-1.0, 1.0]), (-2.0, 2.0), **HOW)  # type: ignore[arg-type]
    assert inside.x == pytest.approx([1, 1], abs=1e-8)
    bounds = np.array([-2.0, -2.0]), np.array([0.5, 2.0])
    at_bound = least_squares(valley, np.array([-1.0, 1.0]), bounds, method="dogbox", **HOW)  # type: ignore[arg-type]
    assert at_bound.x == pytest.approx([0.5, 0.25], abs=1e-9)
    assert at_bound.x[0] == 0.5


@pytest.mark.parametrize("method", ["trf", "dogbox"])
def test_each_point_is_looked_at_once_and_none_is_taken_that_does_not_run(method: str) -> None:
    """Of an arc tangent a step by its slope goes far beyond where it is nought."""
    looked = list[float]()

    def look(point: FloatArray) -> tuple[FloatArray, FloatArray]:
        (x,) = point
        looked.append(x)
        return np.array([np.arctan(3 * (x - 1)) if x < 1.02 else np.inf]), np.array([[3 / (1 + 9 * (x - 1) ** 2)]])

    ended = least_squares(look, np.array([-2.0]), (-9.0, 9.0), method=method, **HOW)  # type: ignore[arg-type]
    assert ended.x == pytest.approx([1], abs=1e-6)
    assert max(looked) >= 1.02
    assert len(set(looked)) == len(looked) <= ended.nfev


@pytest.fixture(scope="module")
def weighed() -> tuple[Prediction, BandWhitening]:
    prediction = Prediction(Toy(), measured(["bend"], {"bend.c": 0.2}, conditions=2, repeats=2))
    predicted = prediction.one()
    return prediction, BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)


def test_the_likelihood_is_a_sum_of_squares_with_its_slopes(weighed: tuple[Prediction, BandWhitening]) -> None:
    prediction, whitening = weighed
    parameters = nominal_parameters(prediction.model, prediction.experiment)
    start = np.full(len(parameters), 0.5)
    here = fit(prediction, whitening, parameters, start, most_steps=0)
    assert here is not None
    row, slopes = here.likelihood.squares
    assert row @ row == pytest.approx(-2 * here.likelihood.log, rel=1e-12)
    for place in range(start.size):
        beside = list[float]()
        for step in (-1e-3, 1e-3):
            point = start + step * np.eye(start.size)[place]
            there = fit(prediction, whitening, parameters, point, most_steps=0)
            assert there is not None
            beside.append(likelihood(whitening, there.sums, point, like=here.likelihood).log)
        assert 2 * (row @ slopes)[place] == pytest.approx(-2 * (beside[1] - beside[0]) / 2e-3, rel=1e-3)


def test_a_fit_ends_at_the_likeliest_point_and_within_bounds(weighed: tuple[Prediction, BandWhitening]) -> None:
    """Wherever it starts; where a bound lies before it, at the bound."""
    prediction, whitening = weighed
    parameters = nominal_parameters(prediction.model, prediction.experiment)
    ends = [fit(prediction, whitening, parameters, np.full(len(parameters), u)) for u in (-1.5, 0.0, 2.5)]
    best = max(end.likelihood.log for end in ends if end is not None)
    assert all(end is not None and end.likelihood.log > best - 0.06 for end in ends)
    free = ends[1]
    assert free is not None
    place = int(np.argmax(np.abs(free.point)))
    bound = parameters[place].value(0.5 * float(free.point[place]))
    closer = replace(parameters[place], **{"high" if free.point[place] > 0 else "low": bound})
    held = fit(prediction, whitening, [*parameters[:place], closer, *parameters[place + 1 :]], np.zeros(len(parameters)))
    assert held is not None
    assert held.values[closer.name] == pytest.approx(bound, rel=1e-9)
