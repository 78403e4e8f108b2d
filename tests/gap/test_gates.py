"""Do the gates tell how the verdict came about: in order, with the numbers that were compared, and which of them moved it?"""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from evat.gap import diagnose
from evat.gap.report import explain_verdict
from evat.gap.report.words import number
from evat.gap.verdict.constants import Constants
from evat.gap.verdict.gates import Gate, gates
from evat.gap.verdict.judgement import CANNOT_TELL, VERDICTS, Judgement, judge
from evat.inference.hypothesis import NOMINAL, Hypothesis
from hypothesis import given, settings
from hypothesis import strategies as st
from test_calibration import _features as features
from toy import Toy, measured

CHAIN = ("known_is_likelier", "effects_over_none", "nominal_suffices", "one_is_likely", "one_stands_out", "one_is_in_most", "credible")
POSITIVE = st.floats(0.001, 100)


def told(judgement: Judgement) -> dict[str, Gate]:
    return {gate.name: gate for gate in gates(judgement)}


def verdict_of(by_name: dict[str, Gate]) -> str:
    """From the chain alone."""
    if not by_name["known_is_likelier"].passed:
        return "unknown"
    if not by_name["effects_over_none"].passed:
        return "no_gap" if by_name["nominal_suffices"].passed else "mistuned"
    one = any(by_name[name].passed for name in ("one_is_likely", "one_stands_out", "one_is_in_most") if name in by_name)
    return "effect" if one and ("credible" not in by_name or by_name["credible"].passed) else "ambiguous"


@settings(max_examples=300, deadline=None)
@given(
    gap=POSITIVE,
    before=POSITIVE,
    exact=st.floats(-800, 50),
    foreign=st.floats(0, 1),
    gains=st.lists(st.tuples(st.floats(-20, 400), st.floats(0.001, 1.2)), max_size=3),
    doubted=st.sets(st.sampled_from(("a", "b"))),
    held_out=st.floats(0.001, 1.5),
)
def test_the_gates_give_the_verdict(
    gap: float,
    before: float,
    exact: float,
    foreign: float,
    gains: list[tuple[float, float]],
    doubted: set[str],
    held_out: float,
) -> None:
    """Whatever was seen: who reads the chain comes to the verdict, its last gate is the one that gave it, and no other of the chain is."""
    seen = features(gap, dict(zip(("a", "b", "a+b"), gains, strict=False)), exact=exact, before=before, foreign=foreign)
    hypotheses = {name: Hypothesis((name,)) for name in ("a", "b")}
    seen = replace(
        seen,
        doubts={hypotheses[name]: ("too large",) for name in doubted},
        held_out={on: held_out for on in hypotheses.values() if on in seen.left},
    )
    judgement = judge(seen, Constants())
    by_name = told(judgement)
    assert verdict_of(by_name) == judgement.verdict
    chain = [gate for gate in by_name.values() if gate.name in CHAIN]
    assert [gate.moved for gate in chain] == [False] * (len(chain) - 1) + [True]
    assert list(by_name)[-len(chain) :] == [gate.name for gate in chain]
    assert judge(seen, Constants(), ()) == judgement


def test_an_effect_that_is_in_most_sets_is_named_whatever_acts_beside_it() -> None:
    """No set stands out; a is in nearly all of them. Of b nothing is sure."""
    seen = features(30, {"a": (300, 0.03), "a+b": (360, 0.005), "a+c": (359, 0.005), "b": (90, 0.6)}, exact=-50)
    judgement = judge(seen, Constants())
    by_name = told(judgement)
    a = sum(p for on, p in judgement.probabilities.items() if "a" in on)
    assert (judgement.verdict, judgement.chosen) == ("effect", Hypothesis(("a",)))
    assert not by_name["one_stands_out"].passed
    assert by_name["one_is_in_most"].value == pytest.approx(a)
    assert a > 0.9
    assert by_name["one_is_in_most"].moved
    without = replace(seen, gain={on: gain for on, gain in seen.gain.items() if on != Hypothesis(("a",))})
    assert judge(without, Constants()).verdict == "ambiguous"  # what was not fitted cannot be told
    doubted = replace(seen, doubts={Hypothesis(("a",)): ("too large",)})
    assert judge(doubted, Constants()).verdict == "ambiguous"


def test_an_effect_stands_out_among_what_the_library_knows() -> None:
    """Whether anything acts at all is a question of its own: a is nearly six in ten of what may, and likelier than nothing."""
    judgement = judge(features(4, {"a": (50, 0.05), "b": (44, 0.05)}, exact=-50), Constants())
    a, structural = judgement.probabilities[Hypothesis(("a",))], 1 - judgement.probabilities[NOMINAL]
    assert a < 0.55 < a / structural
    assert (judgement.verdict, judgement.chosen) == ("effect", Hypothesis(("a",)))
    assert told(judgement)["one_stands_out"].threshold == pytest.approx(0.55 * (structural - judgement.unknown))
    small = judge(
        features(0.6, {"a": (38, 0.05), "b": (32, 0.05)}, exact=-50), Constants()
    )  # as far before b, but less likely than nothing
    assert small.probabilities[Hypothesis(("a",))] > 0.55 * (1 - small.probabilities[NOMINAL])
    assert small.verdict == "mistuned"


def test_many_that_are_unlikely_are_no_reason_to_name_one() -> None:
    """Six effects of a tenth each were named `ambiguous`, the first of them told, where nothing at all was three times as likely as it."""
    judgement = judge(features(2, {name: (12, 0.3) for name in "abcdef"}, exact=-50), Constants())
    none, each = judgement.probabilities[NOMINAL], judgement.probabilities[Hypothesis(("a",))]
    assert 6 * each > none > each
    assert judgement.verdict == "mistuned"
    asked = told(judgement)["effects_over_none"]
    assert (asked.value, asked.threshold, asked.passed) == (pytest.approx(each), pytest.approx(none), False)


@pytest.mark.parametrize(
    ("seen", "verdict", "name", "passed"),
    [
        (features(0.04, {"a": (200, 0.9)}, exact=-50), "effect", "evident_effect", True),
        (features(30, {"a": (3, 0.4), "b": (1, 0.6)}, exact=-50), "unknown", "beyond_chance", False),
        (features(30, {"a": (300, 0.97)}, exact=-50), "unknown", "known_to_library", False),
        (features(30, {"a": (300, 0.01)}, exact=-50), "effect", "known_to_library", True),
        (features(0.01, {"a": (-2, 1.0)}, exact=15, foreign=0.9), "unknown", "regular, F", False),
        (features(30, {}, exact=-50), "unknown", "structural_gap", True),
        (features(0.01, {}, exact=15), "no_gap", "structural_gap", False),
        (features(0.01, {"a": (-2, 1.0)}, exact=-500, before=30), "mistuned", "nominal_fits", False),
    ],
)
def test_the_gate_that_moved_the_verdict_says_so(seen: object, verdict: str, name: str, passed: bool) -> None:
    judgement = judge(seen, Constants())  # type: ignore[arg-type]
    gate = told(judgement)[name]
    assert judgement.verdict == verdict
    assert (gate.passed, gate.moved) == (passed, True)
    assert judge(seen, Constants(), (name.partition(",")[0],)).verdict != verdict  # type: ignore[arg-type]


def test_a_gate_that_moved_nothing_says_so() -> None:
    by_name = told(judge(features(30, {"a": (300, 0.01), "b": (40, 0.8)}, exact=-50, foreign=0.1), Constants()))
    assert not any(by_name[name].moved for name in ("evident_effect", "beyond_chance", "regular, F", "gap_not_larger", "data_suffice"))


def test_data_that_carry_nothing_come_first() -> None:
    judgement = judge(features(30, {"a": (300, 0.01)}, exact=-50), Constants())
    first, *others = gates(judgement, ("a sensor was dead",))
    assert (first.name, first.value, first.passed, first.moved) == ("data_suffice", 1, False, True)
    assert CANNOT_TELL in first.consequence
    assert not others[-1].moved


@pytest.mark.parametrize("verdict", VERDICTS)
def test_every_verdict_can_be_asked_for(verdict: str) -> None:
    """On the toy with an effect: each gate on a line of its own, in order, with its numbers; the JSON has the same."""
    answer = diagnose(measured(["bend"], {"bend.c": 0.2}), Toy())
    first, _, *lines = explain_verdict(answer, verdict).splitlines()
    assert ("this is the verdict" in first) == (verdict == answer.verdict == "effect")
    entries = json.loads(answer.json())["gates"]
    assert len(lines) == len(answer.gates) == len(entries)
    for place, (line, gate, entry) in enumerate(zip(lines, answer.gates, entries, strict=True), 1):
        assert line.strip().startswith(f"{place}. {gate.name}: {'passed' if gate.passed else 'not passed'}; ")
        assert f": {number(gate.value)}, wanted is {gate.wanted} {number(gate.threshold)}. " in line
        assert line.endswith("This moved the verdict.") == gate.moved == entry["moved"]
        assert entry["value"] == pytest.approx(gate.value, rel=1e-5)
        assert entry["passed"] == gate.passed


def test_a_gate_at_its_threshold() -> None:
    gate = Gate("any", "what", 1.0, "above", 1.0, "", False)
    assert not gate.passed
    assert replace(gate, wanted="at most").passed


def test_values_that_nobody_can_have_meant_are_no_mistuning() -> None:
    """The same small gap: mis-tuned while values stay credible, an effect where they do not and with it would."""
    seen = features(0.04, {"a": (30, 0.5)}, exact=-400)
    on = Hypothesis(("a",))
    assert judge(seen, Constants()).verdict == "mistuned"
    strange = replace(seen, shift=8.0, shifts={on: 1.0})
    assert judge(strange, Constants()).verdict == "effect"
    assert told(judge(strange, Constants()))["credible_values"].moved
    assert judge(replace(strange, shift=3.0), Constants()).verdict == "mistuned"
    assert judge(replace(strange, shifts={on: 7.0}), Constants()).verdict == "mistuned"


def test_an_effect_that_only_takes_values_back_a_little_is_none() -> None:
    """Values misstated by 4 standard deviations were told as rate and state: 7 of log evidence, most of it for a value 3.0 off, not 4.9."""
    seen, on = features(0.04, {"a": (7, 0.1)}, exact=-400), Hypothesis(("a",))
    assert judge(replace(seen, shift=4.9, shifts={on: 3.0}), Constants()).verdict == "mistuned"
    by_data = features(0.04, {"a": (20, 0.1)}, exact=-400)
    assert judge(replace(by_data, shift=4.9, shifts={on: 3.0}), Constants()).verdict == "effect"
