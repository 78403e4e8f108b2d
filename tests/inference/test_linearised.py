"""Do shapes of the base law enter linearly, near enough to where they are held, and with the nominal law alone?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.gap import diagnose_with
from evat.inference.hypothesis import Hypothesis
from evat.inference.parameters import at_usual_references, form_parameters
from evat.inference.prediction import Linearised, Prediction
from evat.models.contact import ContactModel
from rig import MODEL, STILL, VALUES, measured

EXPONENT = "lugre.stribeck_exponent"


def held_at(at: float) -> Prediction:
    made = measured()
    plain = Prediction(MODEL, made)
    form = next(form for form in form_parameters(MODEL, made) if form.name == EXPONENT)
    rows = plain.many({EXPONENT: np.array([form.value(at - 0.05), form.value(at + 0.05)])})
    return plain.linearise([Linearised(form, at, (rows[1] - rows[0]) / 0.1)])


@pytest.mark.parametrize("at", [0.0, 1.5])
def test_near_where_it_is_held_it_is_the_model(at: float) -> None:
    prediction = held_at(at)
    (form,) = (each.parameter for each in prediction.linearised)
    plain = prediction.linearise(())
    here = plain.one({EXPONENT: form.value(at)})
    assert np.array_equal(prediction.one({EXPONENT: form.value(at)}), here)
    for away in (-0.3, 0.3):
        exact = plain.one({EXPONENT: form.value(at + away)})
        assert np.linalg.norm(prediction.one({EXPONENT: form.value(at + away)}) - exact) < 0.2 * np.linalg.norm(exact - here)


def test_its_slope_is_its_column() -> None:
    prediction = held_at(1.5)
    (each,) = prediction.linearised
    value = each.parameter.value(1.2)
    row, slopes = prediction.jacobian(
        {EXPONENT: value, "F_C": VALUES["F_C"]}, ["F_C", EXPONENT], {"F_C": 1.0, EXPONENT: each.parameter.slope(1.2)}
    )
    assert pytest.approx(each.column, abs=1e-12) == slopes[:, 1]
    assert np.array_equal(row, prediction.one({EXPONENT: value, "F_C": VALUES["F_C"]}))


def test_another_law_has_no_such_shape() -> None:
    prediction = held_at(1.5)
    other = {"friction_law": "dahl"}
    assert np.array_equal(prediction.one(other), prediction.linearise(()).one(other))


def test_a_law_of_another_form_is_no_effect() -> None:
    """A Stribeck curve of nearly Tustin's form: no effect, and what is left is small."""
    shapes: dict[str, float | str] = {EXPONENT: 1.2}
    made = measured(truth=shapes)
    nominal = {name: value for name, value in made.nominal.values.items() if name not in shapes}
    answer, comparison = diagnose_with(replace(made, nominal=replace(made.nominal, values=nominal)), STILL)
    assert not answer.effects
    assert answer.verdict in ("no_gap", "mistuned")
    assert float(comparison.recalibrated.values[EXPONENT]) < 1.7


def test_a_power_of_viscous_friction_is_said_at_the_speed_of_the_record() -> None:
    """Strokes of some cm/s: with 1 m/s for reference this exponent would take 6 times the sigma2 that its owner believes in to 10 %."""
    slow = {"lugre.viscous_exponent": 0.6, "lugre.viscous_reference": 0.03, "sigma2": 60.0}
    made = measured(truth=slow, nominal={"sigma2": 60.0})
    few = ContactModel(threads=1)
    few.effects = tuple(effect for effect in few.effects if effect.name in ("direction_asymmetry", "stribeck", "viscous_friction"))
    answer, comparison = diagnose_with(made, few)
    assert answer.verdict in ("no_gap", "mistuned")
    assert float(comparison.recalibrated.values["lugre.viscous_exponent"]) == pytest.approx(0.6, abs=0.1)
    assert 0.01 < float(comparison.prediction.experiment.nominal.values["lugre.viscous_reference"]) < 0.06
    assert "lugre.viscous_reference" not in comparison.recalibrated.values
    stated = replace(made, nominal=replace(made.nominal, values={**made.nominal.values, "lugre.viscous_reference": 0.5}))
    assert at_usual_references(MODEL, stated).nominal.values["lugre.viscous_reference"] == 0.5


def test_a_power_of_viscous_friction_acts_once_that_is_there() -> None:
    """Nominal: none, and its power does nothing. Where that was held at 1, friction of a lower power was said to follow rate and state."""
    made = measured(truth={"lugre.viscous_exponent": 0.55, "lugre.viscous_reference": 0.03, "sigma2": 90.0}, nominal={"sigma2": 0.0})
    few = ContactModel(threads=1)
    few.effects = tuple(effect for effect in few.effects if effect.name in ("direction_asymmetry", "rate_and_state", "viscous_friction"))
    answer, comparison = diagnose_with(made, few)
    exponent = "lugre.viscous_exponent"
    assert exponent not in comparison.recalibrated.values
    assert exponent not in {each.parameter.name for each in comparison.prediction.linearised}
    assert [effect.name for effect in answer.effects] == ["viscous_friction"]
    assert float(comparison.models[Hypothesis(("viscous_friction",))].values[exponent]) == pytest.approx(0.55, abs=0.1)
    assert exponent not in comparison.models[Hypothesis(("rate_and_state",))].values


def test_bristles_that_yield_late_are_another_form_of_the_law() -> None:
    made = measured(truth={"lugre.presliding_exponent": 1.8})
    few = ContactModel(threads=1)
    few.effects = tuple(effect for effect in few.effects if effect.name in ("direction_asymmetry", "rate_and_state", "dwell_strengthening"))
    answer, comparison = diagnose_with(made, few)
    assert answer.verdict in ("no_gap", "mistuned")
    assert float(comparison.recalibrated.values["lugre.presliding_exponent"]) == pytest.approx(1.8, abs=0.3)
