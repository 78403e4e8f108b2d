"""Which starts of an effect are fitted to their end, what does a shape of the law do to a prediction that is linear in it, and where are
both held?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import SetupSd
from evat.gap.search import recalibration
from evat.gap.search.compare import compare
from evat.gap.search.recalibration import _likeliest_zeros, _linearised, _trusted_again, farthest_shift, must, nominal_place
from evat.gap.search.singles import _apart
from evat.inference.band_whitening import BandWhitening
from evat.inference.fit import fit
from evat.inference.noise.estimate import estimate_noise
from evat.inference.parameters import Parameter, nominal_parameters
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run, Variable
from toy import Toy, measured

FAR = 1.1 * CONSTANTS.starts_apart


def test_starts_are_the_best_and_those_that_are_elsewhere() -> None:
    """In one coordinate at least, from all that were chosen before; no more than so many."""
    places = ([0.0, 0.0], [0.5 * FAR, -0.5 * FAR], [0.1, FAR], [0.1, 1.5 * FAR], *([n * FAR, -FAR] for n in range(1, 9)))
    starts: Any = [SimpleNamespace(point=np.array(place)) for place in places]
    chosen = [start.point.tolist() for start in _apart(starts)]
    assert chosen == [places[0], places[2], *places[4:]][: CONSTANTS.starts_of_an_effect]
    assert 1 < len(chosen) < len(places)


class Linear:
    """F = 2 a - 300 b + 7 c over three samples, `a` a shape of the law, `b` a zero of an input, which is one for all lanes."""

    setup_names = ("b",)
    setup = SimpleNamespace(names=("d",))

    def linearise(self, columns: Any) -> Any:
        return columns if columns else self

    def one(self, sets: dict[str, Any], on: Any) -> np.ndarray:
        assert "d" not in sets
        return np.array([1.0, 2.0, 3.0]) * (2 * sets["a"] - 300 * sets["b"] + 7 * sets["c"])

    def many(self, sets: dict[str, Any], on: Any) -> np.ndarray:
        return np.array([self.one({**sets, "a": a, "c": c}, on) for a, c in zip(sets["a"], sets["c"], strict=True)])


def test_a_shape_is_told_by_its_slope_where_it_stands() -> None:
    def form(name: str, sd: float) -> Any:
        return SimpleNamespace(name=name, value=lambda u: 1 + sd * u)

    prediction: Any = Linear()
    forms = [form("a", 0.1), form("b", 0.001), form("c", 1e-3)]
    told: Any = _linearised(prediction, {"a": 9.0, "d": 1.0}, (), forms, np.array([0.3, -0.2, 0.0]))
    assert [(one.parameter.name, one.at) for one in told] == [("a", 0.3), ("b", -0.2), ("c", 0.0)]
    for one, slope in zip(told, (0.2, -0.3, 7e-3), strict=True):
        assert one.column == pytest.approx(slope * np.array([1.0, 2.0, 3.0]), rel=1e-6)


class Powered(Toy):
    """F = k |x|^e sign x: the exponent is a shape of the law, 1 unless somebody knows better."""

    variables = (*Toy.variables, Variable("e", "1", 1.0, 0.01, 100.0, "exponent of the spring", "toy", neutral=1.0))

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        x = values["x"]
        return {"F": super().formula(times, {**values, "x": np.sign(x) * np.abs(x) ** values["e"]}, on)["F"]}


@pytest.mark.parametrize(("sds", "times"), [(0.0, 1), (0.5, 1), (1.5, 2)])
def test_a_shape_is_held_elsewhere_only_where_it_is_far_from_where_it_began(
    sds: float, times: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within the range of one linearisation there is no second one, which would cost runs of a law that may take ten times as long."""
    at = list[list[float]]()

    def counting(prediction: Prediction, values: Any, on: Any, forms: Any, where: FloatArray) -> Prediction:
        if len(forms):
            at.append(where.tolist())
        return _linearised(prediction, values, on, forms, where)

    monkeypatch.setattr(recalibration, "_linearised", counting)
    made, exponent = measured(), float(np.exp(CONSTANTS.law_shape_sd * sds))
    trials = []
    for trial in made.trials:
        run = Run(trial.times, trial.inputs, ("F",))
        more = Powered().simulate_many(run, (), {"k": 10.0, "e": exponent})["F"][0] - Toy().simulate_many(run, (), {"k": 10.0})["F"][0]
        trials.append(replace(trial, outputs={"F": trial.outputs["F"] + more}))
    comparison = compare(Prediction(Powered(), replace(made, trials=tuple(trials))))
    assert len(at) == times
    assert comparison.recalibrated.values["e"] == pytest.approx(exponent, rel=0.1)


class Damped(Toy):
    """A damper that is moved, d v; nothing of v is seen where d is 0."""

    variables = (
        *Toy.variables,
        Variable("slip_velocity", "m/s", 0.0, -10.0, 10.0, "velocity", "toy", causality="input"),
        Variable("d", "N.s/m", 0.0, 0.0, 1e6, "damping", "toy"),
    )

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        return {"F": super().formula(times, values, on)["F"] + values["d"] * values["slip_velocity"]}


@pytest.mark.parametrize(("d", "expected"), [(0.0, 0.0), (20.0, -1.5)])
def test_the_zero_of_a_velocity_is_looked_for_where_it_is_likely(d: float, expected: float) -> None:
    """Where the record tells nothing of it, that is where its owner believes it to be; else where the record has it."""
    made, off, trials = measured(), 0.02, []
    for trial in made.trials:
        v = np.gradient(trial.inputs["x"], trial.times) * (trial.times > 0.5)
        read = v + off * expected + 1e-5 * np.cos(300 * trial.times)
        trials.append(replace(trial, inputs={**trial.inputs, "slip_velocity": read}, outputs={"F": trial.outputs["F"] + d * v}))
    nominal = replace(made.nominal, values={"k": 10.0, "d": d})
    made = replace(made, trials=tuple(trials), nominal=nominal, setup_sd={"slip_velocity": SetupSd(zero=off)})
    prediction = Prediction(Damped(), made)
    predicted = prediction.one()
    assert len(prediction.input_zeros) == 1
    assert _likeliest_zeros(prediction, BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)) == pytest.approx(
        [expected], abs=1e-3
    )


@pytest.mark.parametrize(("explained", "again"), [(True, False), (False, True)])
def test_where_no_effect_explains_what_is_seen_all_are_tried_beside_the_nominal_values(explained: bool, again: bool) -> None:
    """Recalibration may have moved values and clocks to where no step leads back to what a true effect needs."""
    stranger = None if explained else 0.6 * np.sin(2 * np.pi * 1.7 * np.arange(400) * 0.01)
    told = list[str]()
    made = measured(["bend"], {"bend.c": 0.4}, extra=stranger)
    compare(Prediction(Toy(), made), lambda doing, share: told.append(doing))
    assert any("beside the nominal values" in doing for doing in told) is again


def test_before_recalibration_values_are_nominal_and_clocks_those_of_the_runs() -> None:
    """A gain or a zero stands in for no motion, and stays where it was fitted."""
    prediction = Prediction(Toy(), measured(["bend"], {"bend.c": 0.4})).sampled_at({"F": 0.003})
    own = {parameter.name: parameter for parameter in prediction.setup.parameters}
    clock, gain = own["setup.F.clock"], own["setup.F.gain"]
    k = Parameter("k", "N/m", 10.0, 0.1, 1.0, 100.0, True)
    assert nominal_place(prediction, k, 0.7) == 0.0
    assert nominal_place(prediction, gain, 0.7) == 0.7
    assert clock.value(nominal_place(prediction, clock, 0.7)) == pytest.approx(0.003)


def test_fits_of_the_law_are_compared_as_far_as_both_are_trusted(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a better fit leaves smaller is trusted in more numbers, and its log likelihood is the lower: a form of the law that gained 394
    was said to lose 41, and the worse fit was kept."""
    made = measured(["bend"], {"bend.c": 0.05}, noise=0.5, conditions=6)
    prediction = Prediction(Toy(), made)
    noise = estimate_noise(prediction, prediction.one())
    whitening, own = BandWhitening(prediction, noise, prediction.one()), nominal_parameters(prediction.model, made)
    better = must(fit(prediction, whitening, own, np.zeros(1)))
    worse = must(fit(prediction, whitening, own, better.point + 1.0, most_steps=0))
    worse, better = _trusted_again(whitening, worse), _trusted_again(whitening, better)
    assert better.likelihood.evidence < worse.likelihood.evidence  # of two trusts
    answers = iter([worse, better])
    monkeypatch.setattr(recalibration, "_trusted", lambda *_: _trusted_again(whitening, next(answers)))
    monkeypatch.setattr(recalibration, "_linearised", lambda prediction, *_: prediction)
    _, kept = recalibration._shaped(prediction, whitening, worse, own, [replace(own[0], name="shape")], np.array([9.0]))
    assert np.array_equal(kept.point, better.point)


def test_the_farthest_shift_is_that_of_a_stated_value() -> None:
    """An effect's amplitude of 4 standard deviations, beside values that all stood within 0.2, passed for a value that is not credible."""
    made = measured(["bend"], {"bend.c": 0.5})
    prediction = Prediction(Toy(), made)
    (stiffness,) = nominal_parameters(prediction.model, made)
    amplitude, shape = (replace(stiffness, name=name) for name in ("bend.c", "lugre.presliding_exponent"))
    fitted: Any = SimpleNamespace(parameters=(amplitude, stiffness, shape), point=np.array([4.0, -0.2, 3.6]))
    assert farthest_shift(prediction, fitted) == 0.2
