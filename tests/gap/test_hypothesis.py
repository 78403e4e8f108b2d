"""Is a hypothesis one value whatever the order of its effects, does it go through JSON, and is each fitted as what it is called?"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap import diagnose_with
from evat.gap.report import explain
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.model import FloatArray, ParameterError, Rival, Variable
from toy import Toy, measured

HARDENING = Variable("law", "1", 0.0, 0.0, 1.0, "law of the spring", "toy", type="choice", choices=("linear", "hardening"))
LAW = "law=hardening"


class TwoLaws(Toy):
    """The toy whose spring may harden: F = 4 k x^3 in place of k x."""

    variables = (*Toy.variables, HARDENING)

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        hard = values["law"] > 0
        force = super().formula(times, {**values, "k": values["k"] * np.where(hard, 4 * values["x"] ** 2, 1.0)}, on)
        return force

    def rival_laws(self, values: Mapping[str, float | str]) -> Sequence[Rival]:
        if HARDENING.check(values.get("law", 0.0)) > 0:
            return ()
        return (Rival(LAW, {"law": "hardening"}, tuple(v for v in self.variables if v.name == "k")),)


def test_the_order_of_effects_is_no_difference() -> None:
    assert Hypothesis(("b", "a")) == Hypothesis(("a", "b", "a")) == Hypothesis(("a",)).beside("b")
    assert hash(Hypothesis(("b", "a"))) == hash(Hypothesis(("a", "b")))
    assert Hypothesis(("m", "a"), "f").names == ("a", "f", "m")
    assert [len(one) for one in (NOMINAL, Hypothesis(law="f"), Hypothesis(("a",), "f"))] == [0, 1, 2]
    assert not NOMINAL
    assert "" not in NOMINAL
    assert "f" in Hypothesis(("a",), "f")
    assert sorted([Hypothesis(("b",)), Hypothesis(law="ab"), NOMINAL, Hypothesis(("a",))]) == [
        NOMINAL, Hypothesis(("a",)), Hypothesis(law="ab"), Hypothesis(("b",)),
    ]  # fmt: skip


def test_a_law_is_no_effect_of_its_name() -> None:
    assert Hypothesis(law="dahl") != Hypothesis(("dahl",))
    assert (Hypothesis(("dahl",)) < Hypothesis(law="dahl")) != (Hypothesis(law="dahl") < Hypothesis(("dahl",)))
    assert Hypothesis(("a",), "dahl").parts() == (Hypothesis(("a",)), Hypothesis(law="dahl"))


@pytest.mark.parametrize(
    ("hypothesis", "text"), [(NOMINAL, "no effect"), (Hypothesis(("b", "a")), "a + b"), (Hypothesis(("a",), "law=dahl"), "a + law=dahl")]
)
def test_it_is_read_by_people_and_by_programs(hypothesis: Hypothesis, text: str) -> None:
    assert str(hypothesis) == text
    assert Hypothesis.read(json.loads(json.dumps(hypothesis.document()))) == hypothesis


def test_each_hypothesis_is_fitted_as_what_it_is_called() -> None:
    """Of a world with another law and an effect: no fit with the law stands under the name of effects alone. One pair is fitted at first,
    and whatever may stand in for one of its parts."""
    experiment = measured(["lean"], {"lean.a": 2.0}, noise=0.02)
    trials = tuple(
        replace(trial, outputs={"F": trial.outputs["F"] + 10 * (4 * trial.inputs["x"] ** 3 - trial.inputs["x"])})
        for trial in experiment.trials
    )
    with CONSTANTS.replaced(pair_fits=1, error_of_linear_gain=10.0):
        answer, comparison = diagnose_with(replace(experiment, trials=trials), TwoLaws())
    assert answer.judgement.chosen == Hypothesis(("lean",), LAW)
    assert [(effect.name, effect.is_law) for effect in answer.effects] == [(LAW, True), ("lean", False)]
    assert answer.document()["candidates"][0]["set"] == [LAW, "lean"]
    for hypothesis, fit in comparison.models.items():
        assert tuple(fit.on) == hypothesis.effects
        assert dict(fit.fixed) == ({"law": "hardening"} if hypothesis.law else {})
    text = explain(comparison, answer, LAW)
    assert "number 1 of" in text
    assert "k = " in text
    assert "setup." not in text  # errors of the set-up, which were fitted beside it, are no part of the law


def test_a_law_that_was_not_tried_is_said_to_be_none_and_why() -> None:
    """It was called unknown, after all the work."""
    answer, comparison = diagnose_with(measured(noise=0.05), TwoLaws())
    assert not any(on.law for on in comparison.models)
    assert "It was not tried: the recalibrated model leaves 0." in explain(comparison, answer, LAW)
    left = replace(comparison.recalibrated, likelihood=replace(comparison.recalibrated.likelihood, size=2 * CONSTANTS.laws_from))
    assert "No fit with it was kept" in explain(replace(comparison, recalibrated=left), answer, LAW)
    refused = replace(comparison, audit=replace(comparison.audit, refused=("9 samples",)))
    assert "It was not tried: of these data nothing was judged, 9 samples." in explain(refused, answer, LAW)
    with pytest.raises(ParameterError, match=f"no effect 'softening' to explain; .*{LAW}"):
        explain(comparison, answer, "softening")
