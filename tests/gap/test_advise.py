"""Is what is advised something that can be set, and does it tell what is likely apart?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Nominal, Trial
from evat.gap import Diagnosis, diagnose_with
from evat.gap.advise import _apart, _bound, next_experiment, options, scaled
from evat.gap.search.compare import Comparison
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.inference.prediction import with_lead_in
from evat.model import Variable
from evat.models.contact import ContactModel
from toy import Toy, measured

KNOWN: dict[str, Variable] = {variable.name: variable for variable in ContactModel(1).variables}


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0, 4.0])
def test_a_temperature_rises_more_or_less_above_the_ambient_one(factor: float) -> None:
    """A quarter of 340 K is no temperature of a rig."""
    warm = np.linspace(293.15, 340.0, 50)
    trial = Trial("a", "a", {}, np.arange(50.0), {"contact_temperature": warm}, {"friction_force": np.ones(50)})
    other = scaled(trial, KNOWN["contact_temperature"], factor)
    assert other is not None
    assert other.inputs["contact_temperature"] == pytest.approx(293.15 + factor * (warm - 293.15))


def test_a_speed_is_multiplied_and_a_bound_is_a_bound() -> None:
    trial = Trial(
        "a", "a", {"rake_angle": 0.6}, np.arange(3.0), {"slip_velocity": np.array([1.0, -1.0, 2.0])}, {"friction_force": np.ones(3)}
    )
    other = scaled(trial, KNOWN["slip_velocity"], 2.0)
    assert other is not None
    assert other.inputs["slip_velocity"].tolist() == [2.0, -2.0, 4.0]
    assert scaled(trial, KNOWN["rake_angle"], 4.0) is None


def test_what_was_recorded_before_is_multiplied_alike() -> None:
    """A lead-in kept its speed: twice as fast from the first sample on is a step, and a slow sensor showed 8.7 N of 13 there."""
    speed = np.linspace(0.1, 0.2, 50)
    whole = Trial("a", "a", {}, np.arange(50.0), {"slip_velocity": speed}, {"friction_force": np.ones(50)})
    other = scaled(replace(whole.between(20, 50), lead_in=whole.between(0, 20)), KNOWN["slip_velocity"], 2.0)
    assert other is not None
    assert with_lead_in(other)[1]["slip_velocity"] == pytest.approx(2 * speed)
    most = KNOWN["slip_velocity"].max
    faster = whole.with_input("slip_velocity", lambda column: np.where(column < 0.11, 0.9 * most, column))
    assert scaled(replace(whole.between(20, 50), lead_in=faster.between(0, 20)), KNOWN["slip_velocity"], 2.0) is None


@pytest.mark.parametrize(("name", "zero"), [("contact_temperature", 293.15), ("slip_velocity", 0.0)])
def test_means_are_multiplied_from_the_same_zero(name: str, zero: float) -> None:
    """Each factor of each condition's value, the others as they are there; what would be out of bounds is left out."""
    sizes = {"contact_temperature": (340.0, 310.0), "slip_velocity": (0.4, 0.8)}[name]
    values = {name: np.array(sizes), "rake_angle": np.array([0.1, 0.2])}
    means = Means("m.csv", ("a", "b"), values, {"friction_force": np.array([1.0, 2.0])}, {})
    rig = Experiment(Path(), "means", "", Nominal({}, (), {}), {}, (), means, "hash of no file")
    compared: Any = SimpleNamespace(prediction=SimpleNamespace(model=SimpleNamespace(variables=tuple(KNOWN.values())), experiment=rig))
    told = list(options(compared))
    for condition, size, angle in zip(means.conditions, sizes, (0.1, 0.2), strict=True):
        own = [option for option in told if option.condition == condition]
        at = [(option.values[name], option.experiment.means) for option in own if name in option.values]
        assert [value for value, _ in at] == pytest.approx([zero + factor * (size - zero) for factor in CONSTANTS.next_experiment_factors])
        for value, changed in at:
            assert changed is not None
            assert changed.conditions == (condition,)
            assert changed.values[name].tolist() == [value]
            assert changed.values["rake_angle"].tolist() == [angle]
        angles = [option.values["rake_angle"] for option in own if "rake_angle" in option.values]
        most = KNOWN["rake_angle"].max
        assert angles == pytest.approx([angle * f for f in CONSTANTS.next_experiment_factors if angle * f <= most])


@pytest.fixture(scope="module")
def bent() -> tuple[Diagnosis, Comparison]:
    return diagnose_with(measured(("bend",), {"bend.c": 0.05}, conditions=9, repeats=2), Toy())


def test_an_advice_starts_from_any_condition_from_the_first_to_the_last(bent: tuple[Diagnosis, Comparison]) -> None:
    """Of one alone, that of the first trial, no thickness was reached that tells an edge force from a least chip thickness."""
    _, comparison = bent
    conditions = list(dict.fromkeys(option.condition for option in options(comparison)))
    assert len(conditions) == CONSTANTS.next_experiment_conditions
    assert (conditions[0], conditions[-1]) == ("c0", "c8")


def test_what_a_model_may_take_up_tells_nothing(bent: tuple[Diagnosis, Comparison]) -> None:
    """Two springs that differ by five prior standard deviations of stiffness: where they may be as stiff as each other, little tells
    them apart, however far apart they are."""
    _, comparison = bent
    option, fit = list(options(comparison))[-1], comparison.models[Hypothesis(("bend",))]
    shifted = fit.point + 5 * np.array([parameter.name == "k" for parameter in fit.parameters])
    pair = [
        replace(each, likelihood=replace(each.likelihood, covariance=np.eye(fit.point.size))) for each in (fit, replace(fit, point=shifted))
    ]
    plain, open_ = (_apart(comparison, option, pair, 1.0, uncertain=uncertain) for uncertain in (False, True))
    assert plain is not None
    assert open_ is not None
    assert plain[0, 1] > 100
    assert open_[0, 1] < 5**2
    assert np.array_equal(open_, open_.T)
    known = [replace(each, likelihood=replace(each.likelihood, covariance=1e-9 * np.eye(fit.point.size))) for each in pair]
    same = _apart(comparison, option, known, 1.0, uncertain=True)
    assert same is not None
    assert same[0, 1] == pytest.approx(plain[0, 1], rel=0.01)


def test_the_best_of_all_options_is_advised(bent: tuple[Diagnosis, Comparison]) -> None:
    answer, comparison = bent
    likely = (Hypothesis(("bend",)), Hypothesis(("lean",)), NOMINAL)
    shares = {likely[0]: 0.5, likely[1]: 0.3, NOMINAL: 0.2}
    judgement = replace(answer.judgement, probabilities=shares, likely=likely)
    fits = [comparison.models[on] if on else comparison.recalibrated for on in likely]
    bounds = {}
    for option in options(comparison):
        apart = _apart(comparison, option, fits, judgement.constants.temperature, uncertain=True)
        assert apart is not None
        bounds[option.condition, tuple(option.values.items())] = _bound(apart, np.array([0.5, 0.3, 0.2]))
    advice = next_experiment(comparison, judgement)
    assert advice is not None
    assert bounds[advice.condition, tuple(advice.values.items())] == min(bounds.values())
    assert advice.separates == likely[:2]
    assert 0.5 < advice.expected_probability <= 1
    sure = replace(judgement, probabilities={likely[0]: 1.0}, likely=likely[:1])
    assert next_experiment(comparison, sure) is None
