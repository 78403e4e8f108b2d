"""Does the verdict listen to conditions left out of the fit, and to fits that are not credible?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from evat.experiment import Experiment
from evat.gap import closure, diagnose, diagnose_with
from evat.gap.budget import structural_share
from evat.gap.closure import HeldOut
from evat.gap.report.summary import _share
from evat.gap.report.words import sentence
from evat.gap.search.compare import compare
from evat.gap.verdict import credibility
from evat.gap.verdict.constants import Constants, stored
from evat.gap.verdict.credibility import doubts
from evat.gap.verdict.features import features as observed
from evat.gap.verdict.judgement import judge
from evat.inference.fit import fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run, Variable
from test_calibration import _features as features
from toy import Loud, Toy, measured

BEND, LEAN = Hypothesis(("bend",)), Hypothesis(("lean",))


def only_where_fitted(made: Experiment, bend: float = 0.8, others: Collection[str] = ("c1", "c4")) -> Experiment:
    """The same records; on two conditions, which are held out together, the force bends the other way."""
    trials = tuple(
        replace(trial, outputs={"F": trial.outputs["F"] - (bend if trial.condition in others else 0.0) * 10 * trial.inputs["x"] ** 2})
        for trial in made.trials
    )
    return replace(made, trials=trials)


def in_order(experiment: Experiment, _: object) -> tuple[tuple[str, ...], ...]:
    """Folds as the conditions come."""
    return tuple(tuple(experiment.conditions[place::3]) for place in range(3))


def test_what_does_not_hold_elsewhere_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closure, "folds", in_order)
    made = measured(["bend"], {"bend.c": 0.4}, conditions=6)
    assert [effect.name for effect in diagnose(made, Toy()).effects] == ["bend"]
    answer, comparison = diagnose_with(only_where_fitted(made), Toy())
    assert answer.verdict == "unknown"
    assert not answer.effects
    held = HeldOut(comparison)
    assert ("c1", "c4") in held.folds
    assert held.left(comparison.models[BEND]) > 0.9


def test_each_condition_is_predicted_by_a_fit_that_has_not_seen_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closure, "folds", in_order)
    comparison = compare(Prediction(Toy(), measured(["bend"], {"bend.c": 0.4}, conditions=7)))
    held, model = HeldOut(comparison), comparison.models[BEND]
    assert held.folds == (("c0", "c3", "c6"), ("c1", "c4"), ("c2", "c5"))
    assert held.conditions == tuple(f"c{n}" for n in range(7))
    predicted = held.predicted(model)
    for fold in held.folds:
        mask = np.array([group.condition in fold for group in comparison.whitening.groups])
        again = fit(
            comparison.prediction,
            comparison.whitening,
            model.parameters,
            model.point,
            model.on,
            fixed=model.fixed,
            held_out=mask,
            most_steps=5,
        )
        assert again is not None
        for segment in comparison.prediction.segments:
            if segment.condition in fold:
                assert np.array_equal(predicted[segment.at], again.predicted[segment.at])
    assert not np.array_equal(predicted, model.predicted)


def test_one_fold_alone_does_not_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    """An effect that closes the gap in two of three folds is named, though in the third it closes next to nothing: there the gap is hardly
    to be seen."""
    monkeypatch.setattr(closure, "folds", in_order)
    made, draw = measured(["bend"], {"bend.c": 0.4}, conditions=6), np.random.default_rng(4)
    small = {"c1", "c4"}
    trials = []
    for trial in made.trials:
        x = trial.inputs["x"] * (0.3 if trial.condition in small else 1.0)
        more = 0.6 * np.sign(x) if trial.condition in small else 0.0
        force = Toy().simulate_many(Run(trial.times, {"x": x}, ("F",)), ["bend"], {"k": 10.0, "bend.c": 0.4})["F"][0]
        trials.append(replace(trial, inputs={"x": x}, outputs={"F": force + more + 0.1 * draw.normal(size=x.size)}))
    answer, comparison = diagnose_with(replace(made, trials=tuple(trials)), Toy())
    held, model = HeldOut(comparison), comparison.models[BEND]
    before, after = held.predicted(comparison.recalibrated), held.predicted(model)
    assert structural_share(comparison.whitening, after, before, small) > 0.8
    assert held.left(model) < 0.2
    assert [effect.name for effect in answer.effects] == ["bend"]


def test_a_fit_is_not_taken_for_one_that_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python gives a new object the number of one that nobody holds."""
    experiment = measured(conditions=6)
    monkeypatch.setattr(closure, "_again", lambda comparison, whole, mask: SimpleNamespace(of=whole.name))
    held = HeldOut(
        SimpleNamespace(
            prediction=SimpleNamespace(experiment=experiment, model=Toy()),
            whitening=SimpleNamespace(groups=[SimpleNamespace(condition=name) for name in experiment.conditions]),
        )
    )  # type: ignore[arg-type]
    for n in range(50):
        assert held.fitted(SimpleNamespace(name=n), "c1").of == n  # type: ignore[arg-type,attr-defined]


@pytest.mark.parametrize("size", [1.0, 0.05])
def test_a_condition_that_gets_worse_is_told(size: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where gap and noise are a twentieth of that beside the same force."""
    monkeypatch.setattr(closure, "folds", in_order)
    made = measured(["bend"], {"bend.c": 0.4 * size}, noise=0.1 * size, conditions=6)
    comparison = compare(Prediction(Toy(), only_where_fitted(made, 0.8 * size)))
    (reason,) = (reason for reason in doubts(comparison, BEND, HeldOut(comparison)) if "c4" in reason)
    assert "worse" in reason


def test_an_effect_that_is_no_better_known_than_its_size_is_doubted() -> None:
    """And one that is there is not."""
    comparison = compare(Prediction(Toy(), measured(["bend"], {"bend.c": 0.4}, conditions=6)))
    held, base = HeldOut(comparison), comparison.recalibrated
    assert doubts(comparison, BEND, held) == ()
    parameters = (*base.parameters, *(p for p in comparison.models[BEND].parameters if p.name == "bend.c"))
    small = fit(comparison.prediction, comparison.whitening, parameters, np.zeros(len(parameters)), ("bend",), most_steps=0)
    assert small is not None
    comparison.models[BEND] = small
    assert any("no better known than its size" in reason for reason in doubts(comparison, BEND, held))


def test_an_effect_with_which_more_is_left_than_without_is_doubted() -> None:
    """Where nothing is held out by what is left of all conditions, else of those left out of the fit; evidence alone may be for it."""
    comparison = compare(Prediction(Toy(), measured(["bend"], {"bend.c": 0.4}, conditions=2)))
    assert doubts(comparison, BEND, HeldOut(comparison)) == ()
    model = comparison.models[BEND]
    away = np.where([p.name == "bend.c" for p in model.parameters], -model.point, model.point)
    other = fit(comparison.prediction, comparison.whitening, model.parameters, away, ("bend",), most_steps=0)
    assert other is not None
    comparison.models[BEND] = other
    first, second = doubts(comparison, BEND, HeldOut(comparison))
    assert "it leaves more of the gap than without it on the conditions that it was fitted to" in first
    assert "takes that back" in second

    elsewhere = compare(Prediction(Toy(), only_where_fitted(measured(["bend"], {"bend.c": 0.4}, conditions=6))))
    assert any("on the conditions left out of its fit" in reason for reason in doubts(elsewhere, BEND, HeldOut(elsewhere)))


@pytest.mark.parametrize(("conditions", "doubted"), [(6, False), (2, True)])
def test_a_form_of_the_law_that_holds_on_conditions_left_out_is_no_doubt(
    conditions: int, doubted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An effect with 0.97, which closed 99 % of the gap of what no fit saw, was `ambiguous` because its values alone do not."""
    monkeypatch.setattr(credibility, "values_alone", lambda *_, **__: SimpleNamespace(closed_share=-1.2))
    comparison = compare(Prediction(Toy(), measured(["bend"], {"bend.c": 0.4}, conditions=conditions)))
    held = HeldOut(comparison)
    assert bool(held.foreseen(comparison.models[BEND])) != doubted
    assert any("takes that back" in reason for reason in doubts(comparison, BEND, held)) == doubted


def test_an_effect_that_may_close_nothing_is_doubted() -> None:
    """It closes some of the gap on all conditions together; but drawn anew these may well be such that it closes none."""
    for bend, is_sure in ((0.5, True), (0.7, False)):
        comparison = compare(Prediction(Toy(), only_where_fitted(measured(["bend"], {"bend.c": 0.4}, conditions=6), bend, ["c3"])))
        said = [reason for reason in doubts(comparison, BEND, HeldOut(comparison)) if "not sure that it closes any of the gap" in reason]
        assert len(said) == (not is_sure)


def test_what_a_clock_leaves_beside_jumps_is_no_doubt() -> None:
    """Where friction reversed between samples a right wear left as much as it closed elsewhere, and was "not sure to close any of the
    gap"; away from there it closes all."""
    comparison = compare(Prediction(Toy(), measured(["bend"], {"bend.c": 0.4}, conditions=2)))
    whitening, held, model = comparison.whitening, HeldOut(comparison), comparison.models[BEND]
    for place, group in enumerate(whitening.groups):
        beside = np.arange(group.at.stop - group.at.start) % 50 == 0
        whitening.jumps[place] = SimpleNamespace(weights=np.where(beside, 0.0, 1.0))
        for member in group.members:
            comparison.prediction.measured[comparison.prediction.segments[member].at][beside] += 20.0
    share, _ = held.where_fitted(model)
    clear, (low, _) = held.where_fitted(model, away=True)
    assert share < 0.5 < 0.9 < low < clear
    assert not any("closes any of the gap" in reason for reason in doubts(comparison, BEND, held))


def test_a_condition_that_the_others_do_not_foresee_tests_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second spring is mis-tuned, and nothing tells so where the condition that meets it is held out."""

    class Stiffer(Toy):
        """Beyond a way that one condition alone goes, a second spring meets."""

        variables = (*Toy.variables, Variable("h", "N/m", 5.0, 0.0, 1e6, "stiffness of the second spring", "toy"))

        def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
            force, x = super().formula(times, values, on)["F"], values["x"]
            return {"F": force + values["h"] * np.sign(x) * np.maximum(np.abs(x) - 1.5, 0.0)}

    made, draw = measured(["lean"], {"lean.a": 1.0}, conditions=6), np.random.default_rng(2)
    trials = []
    for trial in made.trials:
        x = trial.inputs["x"] * (3.0 if trial.condition == "c4" else 1.0)
        force = Stiffer().simulate_many(Run(trial.times, {"x": x}, ("F",)), ["lean"], {"k": 10.0, "h": 9.0, "lean.a": 1.0})["F"][0]
        trials.append(replace(trial, inputs={"x": x}, outputs={"F": force + 0.1 * draw.normal(size=x.size)}))
    nominal = replace(made.nominal, values={"k": 10.0, "h": 5.0}, relative_sd={"h": 0.5})
    monkeypatch.setattr(closure, "folds", in_order)
    answer, comparison = diagnose_with(replace(made, trials=tuple(trials), nominal=nominal), Stiffer())
    held, model = HeldOut(comparison), comparison.models[LEAN]
    assert ("c1", "c4") in held.folds
    assert structural_share(comparison.whitening, held.predicted(model), comparison.recalibrated.predicted, {"c4"}) > 0.3
    assert held.left(model) < 0.1
    assert [effect.name for effect in answer.effects] == ["lean"]
    assert "c1" in answer.closure.held_out_conditions
    assert "c4" in answer.closure.unforeseen
    assert answer.closure.closed_share > 0.9
    assert any("c4" in sentence.partition("holds on ")[2].partition(":")[0] for sentence in answer.cannot_tell)


def test_where_no_condition_is_foreseen_the_share_is_that_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(HeldOut, "foreseen", lambda *_: ())
    answer, _ = diagnose_with(measured(["bend"], {"bend.c": 0.4}, conditions=6), Toy())
    assert np.isnan(answer.closure.closed_share)
    assert answer.closure.closed_share_where_fitted[0] > 0.9
    assert answer.closure.unforeseen == tuple(f"c{n}" for n in range(6))
    told = " ".join(_share(answer))
    assert "on the conditions that it was fitted to" in told
    assert "none can be held out of the fits: without c0, c1, c2, c3, c4, c5 the others do not determine the values" in told


def test_a_second_effect_counts_where_the_first_alone_is_not_credible() -> None:
    """What it adds is what the first has a nominal value pay, and leaves no less."""
    both, leans = Hypothesis(("bend", "lean")), Hypothesis(("lean",))
    seen = features(30, {"bend": (300, 0.05), "lean": (20, 0.9), "bend+lean": (420, 0.05)}, exact=-50)
    assert judge(replace(seen, shifts={BEND: 1.0, leans: 1.0, both: 1.0}), Constants()).chosen == BEND
    assert judge(replace(seen, shifts={BEND: 12.0, leans: 1.0, both: 1.0}), Constants()).chosen == both


def test_a_second_effect_earns_nothing_by_a_value_that_is_hardly_less_credible() -> None:
    """Beside a resonance that left 0.2 % of the gap an elasto-plastic contact was named, for a value that moved by 3.9 instead of 2.1."""
    both, leans = Hypothesis(("bend", "lean")), Hypothesis(("lean",))
    seen = features(30, {"bend": (1751, 0.002), "lean": (8, 0.98), "bend+lean": (1853, 0.001)}, exact=-50)
    assert judge(replace(seen, shifts={BEND: 3.9, leans: 1.5, both: 2.1}), Constants()).chosen == BEND


def test_what_explains_nothing_is_not_named_where_what_explains_is_not_credible() -> None:
    """With 0.7, for an effect that left all of the gap, since the one that explained it needs a value 11 standard deviations off."""
    leans = Hypothesis(("lean",))
    seen = replace(features(30, {"bend": (160, 0.1), "lean": (1, 1.0)}, exact=-380), shift=3.0, shifts={BEND: 11.0, leans: 3.0})
    assert judge(seen, Constants()).verdict == "unknown"


@pytest.mark.parametrize(("shift", "left", "verdict"), [(3.81, 0.002, "effect"), (11.0, 0.002, "unknown"), (5.0, 0.2, "unknown")])
def test_a_value_that_is_hardly_credible_leaves_the_cause_known(shift: float, left: float, verdict: str) -> None:
    """A damping that grew with temperature otherwise, with 470 of log evidence, left 0.2 % of the gap; since a value stood 3.8 standard
    deviations off, half of it counted as unexplained, and the cause was `unknown`."""
    seen = replace(features(30, {"bend": (470, left), "lean": (1, 1.0)}, exact=-580), shift=3.0, shifts={BEND: shift})
    assert judge(seen, stored()[0]).verdict == verdict


def test_where_every_model_moves_a_value_far_the_owner_was_too_sure() -> None:
    """By as much as the least tells; a tenth more than that is no reason against what explains the gap."""
    leans = Hypothesis(("lean",))
    seen = features(30, {"bend": (300, 0.2), "lean": (420, 0.02)}, exact=-50)
    judged = judge(replace(seen, shift=12.0, shifts={BEND: 9.0, leans: 10.0}), Constants())
    assert (judged.verdict, judged.chosen) == ("effect", leans)
    assert judge(replace(seen, shift=12.0, shifts={BEND: 1.0, leans: 10.0}), Constants()).chosen == BEND


def test_an_effect_of_a_size_that_rigs_do_not_have_is_as_little_credible() -> None:
    """Cross talk of 25 % was named for an edge force beside friction that follows the load."""
    toy = Toy()
    own = replace(Toy.effects[0].variables[0], prior_sd=0.05)
    toy.effects = (replace(Toy.effects[0], variables=(own,)), *Toy.effects[1:])
    toy.variables = (*Toy.variables[:3], own, *Toy.variables[4:])
    _, comparison = diagnose_with(measured(["bend"], {"bend.c": 0.4}), toy)
    seen = observed(comparison)
    assert seen.shifts[BEND] == pytest.approx(8.0, rel=0.1)
    assert seen.shifts[Hypothesis(("lean",))] < 2


def test_a_special_case_is_named_where_the_general_effect_shows_no_more() -> None:
    """An edge force had as much probability as a least chip thickness that no cut came near, and neither was named."""
    seen = features(30, {"bend": (402, 0.02), "lean": (400, 0.02)}, exact=-50)
    assert judge(seen, Constants()).verdict == "ambiguous"
    judged = judge(replace(seen, general={BEND: 1}), Constants())
    assert (judged.verdict, judged.chosen) == ("effect", Hypothesis(("lean",)))
    clear = features(30, {"bend": (480, 0.02), "lean": (400, 0.02)}, exact=-50)
    assert judge(replace(clear, general={BEND: 1}), Constants()).chosen == BEND


def test_an_effect_is_general_where_a_special_case_of_it_was_compared() -> None:
    toy = Toy()
    toy.effects = tuple(replace(effect, special_cases=("lean",) if effect.name == "bend" else ()) for effect in Toy.effects)
    _, comparison = diagnose_with(measured(["bend"], {"bend.c": 0.4}), toy)
    assert Hypothesis(("lean",)) in comparison.models
    general = observed(comparison).general
    assert general[BEND] == 1
    assert general[Hypothesis(("lean",))] == 0
    assert general.get(Hypothesis(("bend", "lean")), 0) == 0


@pytest.mark.parametrize(("shift", "named"), [(3.0, "bend"), (5.0, "lean")])
def test_a_value_that_is_not_credible_counts_in_full_against_what_needs_it(shift: float, named: str) -> None:
    """Evidence that leans on forms of laws is taken at a temperature; what the owner states of a value is not."""
    leans = Hypothesis(("lean",))
    seen = features(30, {"bend": (540, 0.02), "lean": (490, 0.03)}, exact=-50)
    judged = judge(replace(seen, shifts={BEND: shift, leans: 1.0}), Constants())
    assert judged.chosen == Hypothesis((named,))
    assert judged.verdict == "effect"


def test_a_value_that_an_effect_of_another_form_moves_is_no_proof_against_it() -> None:
    """Process damping that grew with the square of the speed was told as a holder's compliance of a sixth of its evidence, for a viscous
    friction 6.3 standard deviations off where recalibration alone moved it by 5.4."""
    leans = Hypothesis(("lean",))
    seen = features(2, {"bend": (263, 0.5), "lean": (47, 0.6)}, exact=-3400)
    judged = judge(replace(seen, shift=5.4, shifts={BEND: 6.3, leans: 3.3}), Constants())
    assert (judged.verdict, judged.chosen) == ("effect", BEND)
    assert judge(replace(seen, shift=5.4, shifts={BEND: 16.0, leans: 3.3}), Constants()).chosen != BEND


@pytest.mark.parametrize(("left", "verdict"), [(0.05, "effect"), (0.97, "unknown")])
def test_the_share_that_counts_is_that_of_held_out_conditions(left: float, verdict: str) -> None:
    seen = replace(features(30, {"bend": (300, 0.02)}, exact=-50), held_out={BEND: left})
    assert judge(seen, Constants()).verdict == verdict


def test_a_fit_that_is_not_credible_is_ambiguous() -> None:
    seen = replace(features(30, {"bend": (300, 0.02)}, exact=-50), doubts={BEND: ("it is far too large",)})
    assert judge(seen, Constants()).verdict == "ambiguous"
    assert judge(replace(seen, doubts={LEAN: ("it is far too large",)}), Constants()).verdict == "effect"


def test_the_sentence_says_why() -> None:
    answer, _ = diagnose_with(measured(["bend"], {"bend.c": 0.4}, conditions=6), Toy())
    judgement = replace(answer.judgement, features=replace(answer.judgement.features, doubts={BEND: ("it is far too large",)}))
    doubted = replace(answer, verdict="ambiguous", judgement=judgement)
    assert sentence(doubted) == "The gap may be caused by bend, but it is far too large."


def test_a_nominal_value_that_is_not_credible_is_said_first() -> None:
    made = measured(values={"k": 14.0})
    answer = diagnose(replace(made, nominal=replace(made.nominal, relative_sd={"k": 0.02})), Toy())
    assert answer.cannot_tell[0].startswith("the nominal k is not credible: 10 N/m has to become 1")


def test_members_that_cannot_be_told_apart_are_named_by_their_family() -> None:
    """Probability and sentence of the family, where no member stands out."""
    answer, _ = diagnose_with(measured(["bend"], {"bend.c": 0.4}, conditions=6), Toy())
    assert answer.document()["families"][0] == {"name": "bend", "probability": pytest.approx(answer.effects[0].probability, rel=1e-5)}
    two = replace(answer.judgement, likely=(BEND, LEAN))
    likely = replace(answer, verdict="ambiguous", judgement=two, families={"shape": 0.97}, members={"shape": ("bend", "lean")})
    assert sentence(likely) == (
        "The gap is caused by an effect of the family shape (probability 97 %): bend or lean, which the data cannot tell apart."
    )


def test_an_effect_that_does_not_apply_is_no_candidate() -> None:
    class Elsewhere(Toy):
        effects = tuple(replace(effect, applies_to=("internal",)) if effect.name == "lean" else effect for effect in Toy.effects)

    _, comparison = diagnose_with(measured(["bend"], {"bend.c": 0.4}), Elsewhere())
    assert LEAN not in comparison.rough
    assert BEND in comparison.rough


@pytest.mark.parametrize(("relative_sd", "away"), [(0.02, "60"), (0.1, "12")])
def test_a_nominal_value_that_nobody_can_have_meant_is_no_effect(relative_sd: float, away: str) -> None:
    """Ten of a stiffness that its owner believes to be three. Whatever could stand in for it is dearer than not to believe the owner."""
    made = measured(noise=0.02)
    made = replace(made, nominal=replace(made.nominal, values={"k": 3.0}, relative_sd={"k": relative_sd}))
    answer, comparison = diagnose_with(made, Loud())
    assert (answer.verdict, answer.effects) == ("mistuned", ())
    assert comparison.recalibrated.values["k"] == pytest.approx(10.0, rel=0.02)
    (reason,) = (reason for reason in answer.cannot_tell if "credible" in reason)
    assert reason.startswith("the nominal k is not credible: 3 N/m has to become 9.99")
    assert f"{away} of its standard deviations away" in reason


def test_an_amplifier_that_is_wrong_is_named_where_the_nominal_value_is_right() -> None:
    made = measured(noise=0.02)
    louder = tuple(replace(trial, outputs={"F": 1.4 * trial.outputs["F"]}) for trial in made.trials)
    known = replace(made, trials=louder, nominal=replace(made.nominal, relative_sd={"k": 0.005}))
    answer = diagnose(known, Loud())
    assert [effect.name for effect in answer.effects] == ["amplify"]
