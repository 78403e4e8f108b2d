"""Is an amplitude probed to where it does what is plausible, and is a point of the design given the evidence that it has?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap.search.pairs import _beside_the_best
from evat.gap.search.starts.design import points_over
from evat.gap.search.starts.linear import expected_evidence, linear_fit
from evat.gap.search.starts.plausible import plausible_amplitudes
from evat.gap.search.starts.screen import Screen, _spread
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.fit import fit
from evat.inference.hypothesis import NOMINAL
from evat.inference.noise.estimate import estimate_noise
from evat.inference.parameters import Parameter, Scales
from evat.inference.prediction import Prediction
from evat.model import Effect, FloatArray, Variable
from evat.native import kernel
from scipy.stats import multivariate_normal, qmc
from toy import Toy, measured


@pytest.mark.parametrize("slope", [0.02, 0.727, 3.1, 40.0])
@pytest.mark.parametrize("rounding", [-1e-12, 0.0, 1e-12])
def test_a_linear_response_is_met_but_for_rounding(slope: float, rounding: float) -> None:
    spreads = plausible_amplitudes(lambda tried, rows: slope * tried * (1 + rounding * tried), 1e-4, 1e6, 1)
    assert spreads == pytest.approx([CONSTANTS.plausible_effect / slope], rel=1e-6)


@pytest.mark.parametrize("slope", [1e-3, 0.03, 0.1, 1.0, 10.0, 300.0])
@pytest.mark.parametrize("error", [-1e-3, -1e-5, 0.0, 1e-5, 1e-3, 0.3])
def test_a_response_that_is_a_little_larger_than_expected_is_met_as_well(slope: float, error: float) -> None:
    """The first guess is far below; what runs at the second may be off by the solver's error, or curved, to either side."""
    spreads = plausible_amplitudes(lambda tried, rows: slope * tried * (1 + error * (slope * tried > 1e-2)), 1e-4, 1e6, 1)
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
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
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


def test_an_amplitude_is_as_wide_as_rigs_have_it() -> None:
    """Cross talk of 29 % stood in for friction that follows the load: a tenth of a small force was plausible."""
    toy = Toy()
    own = replace(Toy.effects[2].variables[0], prior_sd=0.05)
    toy.effects = (*Toy.effects[:2], replace(Toy.effects[2], variables=(own,)))
    toy.variables = (*Toy.variables[:-1], own)
    prediction = Prediction(toy, measured(["lean"], {"lean.a": 0.1}))
    predicted = prediction.one()
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    base = fit(prediction, whitening, (), np.empty(0))
    assert base is not None
    starts = Screen(prediction, whitening, Scales(toy, prediction.experiment)).starts(base, toy.effects[2])
    assert {start.parameters[0].sd for start in starts} == {0.05}
    assert kernel.variable("cross_talk.feed_from_principal").prior_sd == 0.05


@pytest.mark.parametrize(("count", "most", "chosen"), [(5, 8, [0, 1, 2, 3, 4]), (21, 3, [0, 10, 20]), (4, 3, [0, 2, 3])])
def test_conditions_to_probe_are_spread_over_all(count: int, most: int, chosen: list[int]) -> None:
    names = [f"c{k}" for k in range(count) for _ in range(2)]
    assert _spread(names, most) == [f"c{k}" for k in chosen]


def test_points_of_a_design_stand_in_the_order_of_the_first_shape() -> None:
    """So that those that run side by side take about as many steps; all of the same design."""
    unknown = [Parameter(name, "1", 1.0, 0.5, 0.1, 10.0, True) for name in ("frequency", "damping")]
    points, shuffled = points_over(unknown), qmc.Sobol(2, scramble=False).random(16) * 3.4 - 1.7
    assert np.all(np.diff(points[:, 0]) > 0)
    assert not np.all(np.diff(shuffled[:, 0]) > 0)
    assert {tuple(point) for point in points} == {tuple(point) for point in shuffled}


def test_what_never_shows_has_no_amplitude() -> None:
    assert np.isnan(plausible_amplitudes(lambda tried, rows: 0 * tried, 1e-4, 1e6, 3)).all()


def test_the_evidence_of_a_linear_model_is_that_of_the_normal_distribution_of_its_data() -> None:
    """Data = slopes u + unit noise with u standard normal are normal with covariance 1 + slopes slopes'. Both orders of two candidates."""
    draw = np.random.default_rng(4)
    data, evidences, exact = draw.normal(size=30) * 3, [], []
    for _ in range(2):
        slopes = draw.normal(size=(30, 3))
        columns = np.column_stack([slopes, data])
        evidences.append(expected_evidence(columns.T @ columns, np.zeros(3), ()))
        exact.append(multivariate_normal(cov=np.eye(30) + slopes @ slopes.T).logpdf(data))
    assert evidences[1] - evidences[0] == pytest.approx(exact[1] - exact[0], rel=1e-9)


def test_a_parameter_that_would_leave_its_bounds_stays_on_them() -> None:
    """Of one slope a and a bound of b: -((y - a b)^2 + b^2)/2, whatever lies beyond."""
    slope, data, bound = np.array([1.0, 2.0, -1.0]), np.array([5.0, 9.0, -4.0]), 0.5
    columns = np.column_stack([slope, data])
    evidence = expected_evidence(columns.T @ columns, np.zeros(1), (Parameter("a", "1", 0.0, 1.0, -bound, bound),))
    assert evidence == pytest.approx(-0.5 * (np.sum((data - slope * bound) ** 2) + bound**2), rel=1e-12)


class Late(Toy):
    """F = k x(t - T), of a sine."""

    effects = (Effect("late", "late", "toy", "toy", (Variable("late.T", "s", 0.01, 0.0, 10.0, "lag", "toy", neutral=0.0),), ()),)
    variables = (*Toy.variables[:3], *effects[0].variables)
    turn = 2 * np.pi * 0.4

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        x = values["x"] + np.zeros(times.shape)
        if "late" not in on:
            return {"F": values["k"] * x}
        before = np.gradient(x, times, axis=-1) / self.turn if times.size > 1 else np.zeros_like(x)
        return {"F": values["k"] * (np.cos(self.turn * values["late.T"]) * x - np.sin(self.turn * values["late.T"]) * before)}


def test_a_second_effect_promises_no_more_than_it_holds_where_its_slope_was_taken() -> None:
    """A force that falls by three times its size with the velocity looks like a lag, as long as lags are taken as linear."""
    given = measured(conditions=1)
    falls = -3 * 10 * np.gradient(given.trials[0].inputs["x"], given.trials[0].times) / Late.turn
    experiment = replace(given, trials=tuple(replace(trial, outputs={"F": trial.outputs["F"] + falls}) for trial in given.trials))
    prediction = Prediction(Late(), experiment)
    predicted, (effect,) = prediction.one(), Late.effects
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    base = fit(prediction, whitening, (), np.empty(0))
    assert base is not None
    start = Screen(prediction, whitening, Scales(prediction.model, experiment)).starts(base, effect)[0]
    candidates = SimpleNamespace(
        models={NOMINAL: base},
        fronts={"late": (start, start.point)},
        offered=[effect],
        prediction=prediction,
        whitening=whitening,
        rough={},
    )
    ((merit, _, _, point),) = _beside_the_best(candidates).values()  # type: ignore[arg-type]
    assert start.reach[0] / 2 <= point[0] <= start.reach[0] * 2
    lags = [start.parameters[0].value(u) for u in np.linspace(0.0, 4.0, 200) * start.reach[0]]
    held = max(
        likelihood(whitening, whitening.sums(row, np.empty((row.size, 0))), np.empty(0)).log
        for row in prediction.many({"late.T": np.array(lags)}, ["late"])
    )
    sums = whitening.sums(base.predicted, start.slopes)
    taken_as_linear = linear_fit(whitening, sums, base, start.parameters)[0]
    gains = [value - base.likelihood.evidence for value in (merit, held, taken_as_linear)]
    assert gains[0] < 1.5 * gains[1] < 0.5 * gains[2]


def test_ten_delays_of_a_sample_are_no_delay_of_ten() -> None:
    prediction = Prediction(Late(), measured(conditions=1))
    predicted, (effect,) = prediction.one(), Late.effects
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    base = fit(prediction, whitening, (), np.empty(0))
    assert base is not None
    for start in Screen(prediction, whitening, Scales(prediction.model, prediction.experiment)).starts(base, effect):
        (lag,), (reach,) = start.straight, start.reach
        assert (lag.low, lag.high) == pytest.approx((lag.value(reach) / 2, lag.value(reach) * 2))
        force = replace(start, parameters=(replace(lag, unit="N", low=-1e9, high=1e9),)).straight[0]
        assert (force.low, force.high) == pytest.approx((-2 * lag.sd * reach, 2 * lag.sd * reach))
        two = replace(start, parameters=(lag, lag), reach=np.array([1.0, 1.0]))
        assert two.straight == (lag, lag)


def test_a_second_effect_is_weighed_as_what_it_stands_beside() -> None:
    """What a spike adds to the evidence of a fit counted for the fit alone: a pair had to make up for it, and was not fitted."""
    prediction = Prediction(Toy(), measured(values={"k": 11.0}))
    predicted = prediction.one()
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    stiffness = Parameter("k", "N/m", 10.0, 1.0, 0.0, 1e6, spike="spring")
    base = fit(prediction, whitening, (stiffness,), np.zeros(1))
    assert base is not None
    plain = likelihood(whitening, base.sums, base.point).evidence
    assert base.likelihood.evidence < plain - 0.5
    evidence, point = linear_fit(whitening, base.sums, base, ())
    assert evidence == pytest.approx(base.likelihood.evidence, abs=0.05)
    assert point == pytest.approx(base.point, abs=1e-3)


def test_an_amplitude_at_its_bound_leaves_the_others_where_they_are_best_without_it() -> None:
    """They stood where they were best beside what it wanted, and were taken back when the rounds were over: 79 of log evidence less."""
    experiment = measured(["bend"], {"bend.c": 1.0}, noise=0.02)
    prediction = Prediction(Toy(), experiment)
    predicted = prediction.one()
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    base = fit(prediction, whitening, (), np.empty(0))
    assert base is not None
    x = np.concatenate([trial.inputs["x"] for trial in experiment.trials])
    own, alike = Parameter("own", "N", 0.0, 1.0, -1e9, 1e9), Parameter("alike", "N", 0.0, 1.0, 0.0, 1e9)
    slopes = np.column_stack([10 * x**2, 9 * x**2 + 2 * x**3])
    alone, (best,) = linear_fit(whitening, whitening.sums(base.predicted, slopes[:, :1]), base, (own,))
    evidence, point = linear_fit(whitening, whitening.sums(base.predicted, slopes), base, (own, alike))
    assert point == pytest.approx([best, 0.0], rel=0.01)
    assert evidence == pytest.approx(alone, abs=1)
