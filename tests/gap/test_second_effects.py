"""When is a second effect named beside the first? Only where it takes a share of what that leaves, and was tried on held-out conditions."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import evat.gap as gap
import pytest
from evat.gap.verdict.constants import Constants
from evat.gap.verdict.judgement import judge
from evat.inference.hypothesis import Hypothesis
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
