"""Is what is small and certain told as such, and what is chance not?"""

from __future__ import annotations

import json
import re

import pytest
from evat.gap import Diagnosis, diagnose_with
from evat.gap.report import sentence
from toy import Toy, measured


def told(a: float, seed: int = 1) -> Diagnosis:
    return diagnose_with(measured(["lean"], {"lean.a": a}, conditions=5, seed=seed), Toy())[0]


def test_certain_and_small_beside_no_gap() -> None:
    """0.05 N/m of lean beside a spring of 10 N/m: a quarter of a percent of the force, at 28 of log evidence."""
    answer = told(0.05)
    assert answer.verdict == "no_gap"
    assert not answer.effects
    assert answer.small_effect is not None
    assert [on.names for on in answer.small_effect.either] == [("lean",)]
    assert pytest.approx(0.0027, abs=0.001) == answer.small_effect.share_of_rms
    assert re.search(r"Beside that, the data ask for lean \(log evidence \d\d\), 0\.27\d* %", sentence(answer))
    assert "too small to be named as a cause" in sentence(answer)
    assert json.loads(answer.json())["small_effect"]["either"] == [["lean"]]


def test_certain_and_small_as_the_verdict() -> None:
    answer = told(0.12)
    assert (answer.verdict, [effect.name for effect in answer.effects]) == ("effect", ["lean"])
    assert "; it is small, 0.6" in sentence(answer)


def test_large_is_not_called_small() -> None:
    answer = told(1.0)
    assert answer.verdict == "effect"
    assert answer.small_effect is None
    assert "small" not in sentence(answer)


@pytest.mark.parametrize(("a", "seed"), [(0.0, 1), (0.0, 2), (0.03, 1)])
def test_chance_is_not_certain(a: float, seed: int) -> None:
    """Nor is nine of log evidence."""
    answer = told(a, seed)
    assert answer.small_effect is None
    assert sentence(answer) == "No gap beyond noise and repeatability."
