"""Which steps led to the verdict, and which of them moved it? Gates with a value and a threshold, in the order in which they are asked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from evat.constants import CONSTANTS
from evat.gap.verdict.judgement import (
    MISTUNED,
    NO_GAP,
    Judgement,
    by_part,
    in_most_sets,
    judge,
    least_to_name,
    steps,
    unexplained_channels,
)
from evat.inference.hypothesis import NOMINAL


@dataclass(frozen=True, slots=True)
class Gate:
    """One question of the judgement: `quantity` says what `value` is, which passes where it is above `threshold`, or at most that.

    consequence : what the answer did to the verdict; moved : whether another answer had led to another verdict or another hypothesis, and
    for the gates that hand out verdicts, whether it was the one that did.
    """

    name: str
    quantity: str
    value: float
    wanted: Literal["above", "at most"]
    threshold: float
    consequence: str
    moved: bool

    @property
    def passed(self) -> bool:
        return self.value > self.threshold if self.wanted == "above" else self.value <= self.threshold

    def document(self) -> dict[str, Any]:
        """As in diagnosis.json: six digits, null for what is not known."""
        value, threshold = (float(f"{x:.6g}") if math.isfinite(x) else None for x in (self.value, self.threshold))
        return {
            "name": self.name,
            "quantity": self.quantity,
            "value": value,
            "wanted": self.wanted,
            "threshold": threshold,
            "passed": self.passed,
            "consequence": self.consequence,
            "moved": self.moved,
        }


def gates(judgement: Judgement, refused: Sequence[str] = ()) -> tuple[Gate, ...]:
    """In the order in which they are asked. refused : why the data can carry no verdict at all."""
    audit = Gate(
        "data_suffice", "reasons for which these data carry no verdict", len(refused), "at most", 0,
        "the verdict is cannot_tell, whatever the gates below say" if refused else "the data are judged", bool(refused),
    )  # fmt: skip
    return (audit, *_evidence(judgement), *_verdicts(judgement, not refused))


class _Asked:
    """The gates of a judgement, each of which is tried with the other answer, too."""

    def __init__(self, judgement: Judgement) -> None:
        self.judgement, self.features, self.constants = judgement, judgement.features, judgement.constants
        self.step = steps(judgement.features, judgement.constants)

    def gate(
        self,
        name: str,
        quantity: str,
        value: float,
        wanted: Literal["above", "at most"],
        threshold: float,
        yes: str,
        no: str,
        asks: str = "",
    ) -> Gate:
        """yes, no : the consequences; asks : the question of the judgement, where the gate is called otherwise."""
        passed = value > threshold if wanted == "above" else value <= threshold
        other = judge(self.features, self.constants, (asks or name,))
        moved = (other.verdict, other.chosen) != (self.judgement.verdict, self.judgement.chosen)
        return Gate(name, quantity, value, wanted, threshold, yes if passed else no, moved)


def _evidence(judgement: Judgement) -> Iterator[Gate]:
    """What goes into the probabilities."""
    asked = _Asked(judgement)
    step, constants = asked.step, asked.constants
    yield asked.gate(
        "structural_gap", "largest structural rms that recalibration leaves in a channel, over what nobody would look at",
        math.exp(step.size), "above", math.exp(-(constants.structure_offset + CONSTANTS.gap_elsewhere) / constants.structure_slope),
        f"a gap beyond mis-tuning: probability {step.by_size:.3g} by its size",
        f"nothing to look at: probability {step.by_size:.3g} of a gap by its size",
    )  # fmt: skip
    if asked.features.gain:
        yield from _shares(asked)
        yield from _hypotheses(asked)
    yield from _irregular(asked)
    yield asked.gate(
        "nominal_fits", "log evidence of the nominal over the recalibrated model, of which a larger nominal gap asks more",
        asked.features.exact, "above",
        constants.evident * (constants.gap_offset + constants.gap_slope * step.nominal_size) - CONSTANTS.chance_evidence,
        f"without an effect the nominal values suffice: probability {step.no_gap:.3g}",
        f"without an effect the nominal values are mis-tuned: they suffice with a probability of {step.no_gap:.3g}",
    )  # fmt: skip


def _shares(asked: _Asked) -> Iterator[Gate]:
    """What a hypothesis is held to leave of the gap."""
    features, step = asked.features, asked.step
    leader = max(features.gain, key=lambda on: features.gain[on])
    yield asked.gate(
        "gap_not_larger", f"share of the structural gap that {leader} leaves, the likeliest by evidence alone",
        features.left[leader], "at most", CONSTANTS.worse_gap, "its evidence counts",
        "a model that makes the gap larger is held to leave all of that, however small the gap",
    )  # fmt: skip
    closest = step.closest
    if closest in features.held_out:
        yield asked.gate(
            "held_out", f"share of the structural gap that {closest} leaves at least on conditions left out of its fit",
            features.held_out[closest], "at most", features.left[closest], "it holds there, too",
            f"it leaves more there than where it was fitted: {features.held_out[closest]:.3g} of the gap counts as left, not "
            f"{features.left[closest]:.3g}",
        )  # fmt: skip
    yield asked.gate(
        "visible_share", f"share of the structural gap that {closest} leaves, as far as it can be seen",
        step.lefts[closest], "at most", features.left_at_least(closest),
        f"of the {features.left_at_least(closest):.3g} that it leaves, {step.lefts[closest]:.3g} can be seen and count",
        "all that it leaves counts",
    )  # fmt: skip
    yield asked.gate(
        "beyond_chance", f"log evidence of {closest} over the recalibrated model", features.gain[closest], "above",
        CONSTANTS.chance_evidence, "what it explains is no chance",
        f"it may be chance, so that {step.left:.3g} of the gap count as unexplained",
    )  # fmt: skip


def _hypotheses(asked: _Asked) -> Iterator[Gate]:
    """What makes one of the hypotheses likely, or something that none of them is."""
    features, constants, step = asked.features, asked.constants, asked.step
    yield asked.gate(
        "evident_effect", f"log evidence of {step.best}, the best hypothesis", features.gain[step.best], "above", step.needed,
        f"a gap even if it is too small to look at: probability {step.regular[1]:.3g} with its evidence, {step.by_size:.3g} without",
        "too little to make a gap of one that is too small to look at",
    )  # fmt: skip
    yield asked.gate(
        "credible_values", "largest shift of a nominal value by recalibration, in its standard deviations", features.shift, "at most",
        CONSTANTS.credible_shift, "the nominal values may be mis-tuned",
        f"no mis-tuning moves a value so far, and with {step.best} none moves by more than "
        f"{features.shifts.get(step.best, math.nan):.3g}: it counts for a gap",
    )  # fmt: skip
    even = -(constants.unknown_offset + CONSTANTS.unknown_elsewhere + step.surprise) / constants.unknown_slope  # log-odds of a share
    yield asked.gate(
        "known_to_library",
        f"share of the gap that {step.closest} leaves, chance counted, the less of it allowed the less credible the values that it needs",
        step.left, "at most", 1 / (1 + math.exp(-even)),
        f"the library knows it: {step.by_library:.3g} of the probability of a gap is unknown",
        f"no hypothesis explains it: {step.by_library:.3g} of the probability of a gap is unknown",
    )  # fmt: skip


def _irregular(asked: _Asked) -> Iterator[Gate]:
    """What comes and goes from repeat to repeat, channel by channel."""
    features, step = asked.features, asked.step
    foreign = unexplained_channels(features, max(1 - step.left, 0.0))
    for channel, share in features.irregular_share.items():
        unexplained = channel in foreign
        yield asked.gate(
            f"regular, {channel}", "share of what repeats do not share that is bursts, lines and wander"
            + ("" if unexplained else "; no more of it than the effects explain, so any share will do"),
            share, "at most", asked.constants.irregular if unexplained else 1.0, "nothing foreign comes and goes",
            f"something foreign comes and goes: probability of unknown {step.regular[0]:.3g} without it, {step.unknown:.3g} with all of it",
            "regular",
        )  # fmt: skip


def _verdicts(judgement: Judgement, counts: bool) -> list[Gate]:
    """The chain that hands out the verdict; it ends at the gate that did. counts : whether the data carry it."""
    step = steps(judgement.features, judgement.constants)
    unknown, none, each = step.unknown, 1 - step.structural, by_part(judgement.probabilities)
    likeliest, first = max(each.items(), key=lambda own: own[1], default=(NOMINAL, 0.0))
    count, most = len(judgement.likely), max((p for on, p in judgement.probabilities.items() if on), default=0.0)
    is_unknown, acts = unknown > max(first, none), first > none
    sure = least_to_name(CONSTANTS.least_named_probability, unknown, step.structural)
    common = in_most_sets(judgement.probabilities, unknown, step.structural) in step.scores
    chain = [
        Gate(
            "known_is_likelier", "probability of something unknown", unknown, "at most", max(first, none),
            "the verdict is unknown" if is_unknown else "it is nothing unknown", False,
        )
    ]  # fmt: skip
    if not is_unknown:
        word = "an effect or another base law acts" if acts else "no effect is named"
        quantity = f"probability of {likeliest}, whatever acts beside it"
        chain.append(Gate("effects_over_none", quantity, first, "above", none, word, False))
    if not is_unknown and not acts:
        word = f"the verdict is {NO_GAP if step.no_gap > 0.5 else MISTUNED}"
        chain.append(Gate("nominal_suffices", "probability that the nominal values suffice", step.no_gap, "above", 0.5, word, False))
    if not is_unknown and acts:
        word = "the verdict is effect: no other hypothesis is likely" if count <= 1 else "several hypotheses are likely"
        chain.append(Gate("one_is_likely", "hypotheses that hold 90 % of what is not unknown", count, "at most", 1, word, False))
        if count > 1:
            word = (
                "the verdict is effect: it stands out among all that are known, and is likelier than none and than something unknown"
                if most > sure
                else "none is far before the others"
            )
            chain.append(Gate("one_stands_out", "probability of the likeliest hypothesis", most, "above", sure, word, False))
        if count > 1 and most <= sure:
            word = (
                f"the verdict is effect: {judgement.chosen}, whatever acts beside"
                if common
                else "the verdict is ambiguous: these data cannot tell them apart"
            )
            quantity = f"probability of {likeliest} in all hypotheses together"
            least = least_to_name(CONSTANTS.least_effect_probability, unknown, step.structural)
            chain.append(Gate("one_is_in_most", quantity, first, "above", least, word, False))
    reasons = judgement.features.doubts.get(judgement.chosen, ())
    if not is_unknown and acts and reasons and (count <= 1 or most > sure or common):
        word = f"the verdict is ambiguous: {'; '.join(reasons)}"
        chain.append(Gate("credible", "reasons to doubt the likeliest hypothesis", len(reasons), "at most", 0, word, False))
    return [*chain[:-1], replace(chain[-1], moved=counts)]
