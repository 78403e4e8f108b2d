"""When is a second effect named beside the first? Only where it takes a share of what that leaves, and was tried on held-out conditions."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import evat.gap as gap
import numpy as np
import pytest
from evat.gap.search import pairs
from evat.gap.search.candidates import best_pairs
from evat.gap.verdict.constants import Constants
from evat.gap.verdict.judgement import judge
from evat.inference.hypothesis import Hypothesis
from evat.models.contact import ContactModel
from test_calibration import _features as features

FIRST, BOTH, OTHER = Hypothesis(("a",)), Hypothesis(("a", "b")), Hypothesis(("a", "c"))


def test_evidence_that_closes_nothing_more_is_form() -> None:
    """A second effect with 180 more of log evidence, after which as much is left, mends the first one's form."""
    judgement = judge(features(30, {"a": (260, 0.03), "a+b": (440, 0.03)}, exact=-300), Constants())
    assert (judgement.verdict, judgement.chosen) == ("effect", FIRST)


def test_a_second_effect_that_closes_what_is_left_counts_whole() -> None:
    judgement = judge(features(30, {"a": (260, 0.3), "a+b": (440, 0.03)}, exact=-300), Constants())
    assert (judgement.verdict, judgement.chosen) == ("effect", BOTH)


def test_none_is_named_that_was_not_tried_on_held_out_conditions(monkeypatch: pytest.MonkeyPatch) -> None:
    """The likeliest fail there one after the other; of those that follow, none is spared."""
    names = ["a", *(f"a+{letter}" for letter in "bcdefgh")]
    fitted = {name: (195 - 0.5 * place, 0.012) for place, name in enumerate(names)}
    monkeypatch.setattr(gap, "features", lambda _: features(30, fitted, exact=-300))
    monkeypatch.setattr(gap, "doubts", lambda *_: ())
    tried: list[Any] = []
    held: Any = SimpleNamespace(left=lambda model: tried.append(model) or 0.95)
    comparison: Any = SimpleNamespace(
        models={Hypothesis(tuple(name.split("+"))): name for name in names}, audit=SimpleNamespace(refused=())
    )
    judgement = gap._judged(comparison, held, Constants())
    assert set(tried) == set(names)
    assert judgement.verdict == "unknown"
    assert math.isclose(judgement.features.left_at_least(OTHER), 0.95)


def test_a_second_effect_is_looked_for_beside_the_first_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wear beside a slack looked like nothing while the slack was not there; what it may do beside it was taken from then, too, so that the
    pair was never fitted."""
    seen = {"b": 5.0, "c": 50.0}
    alone, point = SimpleNamespace(likelihood=SimpleNamespace(evidence=100.0), predicted=None, point=np.zeros(2)), np.ones(1)

    def starts(base: Any, effect: Any) -> list[Any]:
        assert base is alone
        return [SimpleNamespace(evidence=100.0 + seen[effect.name], point=point)]

    offered = [SimpleNamespace(name=name, rivals=()) for name in "abcd"]
    rough = {Hypothesis((name,)): 0.0 for name in "abc"}  # d lacks an input
    candidates: Any = SimpleNamespace(
        models={FIRST: alone}, offered=offered, rough=rough, tell=lambda *_: None, screen=SimpleNamespace(starts=starts), whitening=None,
        prediction=SimpleNamespace(model=SimpleNamespace(effects=offered)),
    )  # fmt: skip
    linear: Any = {BOTH: (110.0, alone, None, np.zeros(3)), OTHER: (101.0, alone, None, np.zeros(3))}
    monkeypatch.setattr(pairs, "squares", lambda *_: {})
    monkeypatch.setattr(pairs, "is_visible", lambda _: True)
    promising = pairs._screened_beside_the_best(candidates, linear)
    assert {on: merit[0] for on, merit in promising.items()} == {BOTH: 110.0, OTHER: 150.0}
    assert promising[OTHER][3].tolist() == [0.0, 0.0, 1.0]
    monkeypatch.setattr(pairs, "is_visible", lambda _: False)
    assert pairs._screened_beside_the_best(candidates, linear) == linear


def test_two_sensors_of_one_chain_take_no_place_of_pairs_that_are_named() -> None:
    """A delay beside a low-pass is one filter: one such pair is fitted beside the best of the others, since it tells what the library
    knows."""
    chain, other, own = ("input_delay", "sensor_lowpass"), ("sensor_delay", "sensor_lowpass"), ("sensor_delay", "sensor_offset")
    ranked = [Hypothesis(names) for names in (chain, other, own, ("input_delay", "sensor_offset"), ("sensor_gain", "sensor_offset"))]
    assert best_pairs(ContactModel(threads=1), ranked, 2) == [ranked[0], ranked[2], ranked[3]]


def test_either_of_two_pairs_that_lead_is_asked_what_could_stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a hair the second is behind, and the truth is that with another in the place of one of its effects."""
    evidence = {("a", "b"): 100.0, ("a", "c"): 99.0, ("a", "d"): 80.0, ("a",): 50.0}
    models = {Hypothesis(names): SimpleNamespace(likelihood=SimpleNamespace(evidence=value)) for names, value in evidence.items()}
    model = SimpleNamespace(effects=[SimpleNamespace(name=name, rivals=(), family=name, stage="friction") for name in "abcd"])
    candidates: Any = SimpleNamespace(
        prediction=SimpleNamespace(model=model), models=models, offered=model.effects, without_effects=0.0,
        rough={Hypothesis((name,)): 0.0 for name in "abcd"},
    )  # fmt: skip
    asked = list[Hypothesis]()
    monkeypatch.setattr(pairs, "_in_place_of", lambda _, pair, kept, other, effects: asked.append(pair) or {})
    pairs._swap(candidates)
    assert asked == [BOTH, BOTH, OTHER, OTHER]
