"""Is an amplitude probed to where it does what is plausible, and is a point of the design given the evidence that it has?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap.search.screen import Screen, _expected, _spread, _spreads_of
from evat.inference.fit import fit
from evat.inference.noise.estimate import estimate_noise
from evat.inference.parameters import Parameter, Scales
from evat.inference.prediction import Prediction
from evat.inference.whitening import Whitening
from scipy.stats import multivariate_normal
from toy import Toy, measured


@pytest.mark.parametrize("slope", [0.02, 0.727, 3.1, 40.0])
@pytest.mark.parametrize("rounding", [-1e-12, 0.0, 1e-12])
def test_a_linear_response_is_met_but_for_rounding(slope: float, rounding: float) -> None:
    spreads = _spreads_of(lambda tried, rows: slope * tried * (1 + rounding * tried), 1e-4, 1e6, 1)
    assert spreads == pytest.approx([CONSTANTS.plausible_effect / slope], rel=1e-6)


@pytest.mark.parametrize("slope", [1e-3, 0.03, 0.1, 1.0, 10.0, 300.0])
@pytest.mark.parametrize("error", [-1e-3, -1e-5, 0.0, 1e-5, 1e-3, 0.3])
def test_a_response_that_is_a_little_larger_than_expected_is_met_as_well(slope: float, error: float) -> None:
    """The first guess is far below; what runs at the second may be off by the solver's error, or curved, to either side."""
    spreads = _spreads_of(lambda tried, rows: slope * tried * (1 + error * (slope * tried > 1e-2)), 1e-4, 1e6, 1)
    assert spreads == pytest.approx([CONSTANTS.plausible_effect / slope], rel=1.01 * abs(error) + 1e-6)


def bounded() -> Toy:
    """The toy whose lean has a bound below what is tried."""
    toy = Toy()
    toy.effects = tuple(
        replace(effect, variables=tuple(replace(own, max=0.5) for own in effect.variables)) if effect.name == "lean" else effect
        for effect in Toy.effects
    )
    toy.variables = (*Toy.variables[:3], *(own for effect in toy.effects for own in effect.variables))
    return toy


def test_slopes_are_those_of_the_amplitude_that_was_tried_where_its_bound_is_near() -> None:
    """An effect that is exactly linear: a|x|, of which 10 % of the rms is a = 1 and 0.5 is allowed. All trials start at one amplitude."""
    prediction = Prediction(bounded(), measured(["lean"], {"lean.a": 0.4}))
    predicted = prediction.one()
    whitening = Whitening(prediction, estimate_noise(prediction, predicted), predicted)
    base = fit(prediction, whitening, (), np.empty(0))
    assert base is not None
    starts = Screen(prediction, whitening, Scales(prediction.model, prediction.experiment)).starts(base, prediction.model.effects[2])
    size = np.abs(np.concatenate([trial.inputs["x"] for trial in prediction.experiment.trials]))
    assert len(starts) == len(CONSTANTS.trial_amplitudes)
    for start in starts:
        (a,) = start.parameters
        assert a.sd > 0.6
        assert start.slopes[:, 0] == pytest.approx(a.sd * size, rel=1e-6, abs=1e-9)
        assert a.value(start.point[0]) == pytest.approx(0.4, rel=0.2)


@pytest.mark.parametrize(("count", "most", "chosen"), [(5, 8, [0, 1, 2, 3, 4]), (21, 3, [0, 10, 20]), (4, 3, [0, 2, 3])])
def test_conditions_to_probe_are_spread_over_all(count: int, most: int, chosen: list[int]) -> None:
    names = [f"c{k}" for k in range(count) for _ in range(2)]
    assert _spread(names, most) == [f"c{k}" for k in chosen]


def test_what_never_shows_has_no_amplitude() -> None:
    assert np.isnan(_spreads_of(lambda tried, rows: 0 * tried, 1e-4, 1e6, 3)).all()


def test_the_evidence_of_a_linear_model_is_that_of_the_normal_distribution_of_its_data() -> None:
    """Data = slopes u + unit noise with u standard normal are normal with covariance 1 + slopes slopes'. Both orders of two candidates."""
    draw = np.random.default_rng(4)
    data, evidences, exact = draw.normal(size=30) * 3, [], []
    for _ in range(2):
        slopes = draw.normal(size=(30, 3))
        columns = np.column_stack([slopes, data])
        evidences.append(_expected(columns.T @ columns, np.zeros(3), ()))
        exact.append(multivariate_normal(cov=np.eye(30) + slopes @ slopes.T).logpdf(data))
    assert evidences[1] - evidences[0] == pytest.approx(exact[1] - exact[0], rel=1e-9)


def test_a_parameter_that_would_leave_its_bounds_stays_on_them() -> None:
    """Of one slope a and a bound of b: -((y - a b)^2 + b^2)/2, whatever lies beyond."""
    slope, data, bound = np.array([1.0, 2.0, -1.0]), np.array([5.0, 9.0, -4.0]), 0.5
    columns = np.column_stack([slope, data])
    evidence = _expected(columns.T @ columns, np.zeros(1), (Parameter("a", "1", 0.0, 1.0, -bound, bound),))
    assert evidence == pytest.approx(-0.5 * (np.sum((data - slope * bound) ** 2) + bound**2), rel=1e-12)
