"""What is to be believed? From what each model explains to probabilities, a verdict, and which effects cannot be told apart.

Evidence alone is far too sure of itself: it takes the form of every effect for exact. So a model is judged by the share of the structural
gap
that it leaves, by its evidence at a temperature, and by how many effects it takes; the constants come from simulated cases whose forms
differ
from the model's (`evat calibrate`), and are stored with how they were found.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from evat.gap.budget import squares, structural_share
from evat.gap.compare import Comparison
from evat.gap.fit import Fit

NO_GAP, MISTUNED, UNKNOWN = "no_gap", "mistuned", "unknown"
STORED = Path(__file__).with_name("calibration.json")
SURE = 0.9  # of the probability: what the listed sets hold
EVIDENT = 5.0  # of log evidence: less is chance
AMBIGUOUS = 0.55  # of what is not unknown: a set with less is one of several


@dataclass(frozen=True)
class Constants:
    """Of the judgement; each is a weight of one of the features below in a log-odds."""

    temperature: float = 15.0  # of the evidence
    sharpness: float = 6.0  # per factor e^-2 in the share of the gap that is left
    form: float = 0.05  # share of the gap that may be left by an effect of a slightly other form
    effect_cost: float = 4.0  # of each further effect
    gap_offset: float = 0.0
    gap_slope: float = 2.0  # nominal gap over what nobody would look at
    structure_offset: float = 0.0
    structure_slope: float = 2.0  # the same of what recalibration leaves
    unknown_offset: float = -0.5
    unknown_slope: float = 3.0  # share that the best model leaves
    evident: float = 15.0  # log evidence that makes an effect as likely as not where the gap itself is too small to look at
    small_noise: float = 0.5  # of the noise's rms: a structural gap of this size is nothing to look at
    small_form: float = 0.01  # of the rms of a channel: the same

    @staticmethod
    def stored() -> Constants:
        if not STORED.is_file():
            return Constants()
        held: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))["constants"]
        return Constants(**{field.name: float(held[field.name]) for field in fields(Constants) if field.name in held})


@dataclass(frozen=True)
class Features:
    """What is judged. By channel, in its mean square: structural squares of the nominal and of the recalibrated model, and the noise floor;
    `exact`, log evidence of the nominal over the recalibrated model; `gain[set]`, the same of a set of effects; `left[set]`, its share of
    the
    recalibrated model's structural squares."""

    nominal: Mapping[str, float]
    recalibrated: Mapping[str, float]
    floor: Mapping[str, float]
    exact: float
    gain: Mapping[tuple[str, ...], float]
    left: Mapping[tuple[str, ...], float]

    def without(self, effect: str) -> Features:
        """As if the model did not have that effect: its sets are gone."""
        kept = [on for on in self.gain if effect not in on]
        return replace(self, gain={on: self.gain[on] for on in kept}, left={on: self.left[on] for on in kept})


@dataclass(frozen=True)
class Judgement:
    """`probabilities` of every set of effects, () standing for none, and of `unknown`; the verdict; the sets that hold 90 %."""

    verdict: str
    chosen: tuple[str, ...]
    probabilities: Mapping[tuple[str, ...], float]
    unknown: float
    no_gap: float
    likely: tuple[tuple[str, ...], ...]
    features: Features


def _size(structural: Mapping[str, float], floor: Mapping[str, float], constants: Constants) -> float:
    """Log of the largest structural rms of a channel over what nobody would look at."""
    ratios = [square / (constants.small_noise**2 * floor[c] + constants.small_form**2) for c, square in structural.items()]
    return 0.5 * math.log(max([*ratios, 1e-6]))


def features(comparison: Comparison) -> Features:
    whitening, reference = comparison.whitening, comparison.recalibrated.predicted
    base, levels = comparison.recalibrated.found.evidence, whitening.levels
    before, after = squares(whitening, comparison.nominal.predicted), squares(whitening, reference)
    return Features(
        nominal={c: before[c].structural / levels[c] ** 2 for c in levels},
        recalibrated={c: after[c].structural / levels[c] ** 2 for c in levels},
        floor={c: after[c].floor / levels[c] ** 2 for c in levels},
        exact=comparison.nominal.found.evidence - base,
        gain={on: found.found.evidence - base for on, found in comparison.models.items()},
        left={on: structural_share(whitening, found.predicted, reference) for on, found in comparison.models.items()},
    )


def judge(found: Features, constants: Constants) -> Judgement:
    """Three questions, one after the other: is there a gap, is it more than mis-tuning, and which effects are it."""
    size = _size(found.nominal, found.floor, constants)
    no_gap = 1 - _sigmoid(constants.gap_offset + constants.gap_slope * size - (found.exact + EVIDENT) / constants.evident)
    structural = _sigmoid(constants.structure_offset + constants.structure_slope * _size(found.recalibrated, found.floor, constants))
    scores = {on: _score(on, found, constants) for on in found.gain}
    best = max(scores, key=lambda on: scores[on]) if scores else ()
    if scores and found.gain[best] > 0:
        # A small gap that an effect explains well and with much evidence is one, however small.
        structural = max(structural, _sigmoid((found.gain[best] - constants.evident) * 3 / constants.evident) * (1 - found.left[best]))
    left = min((found.left[on] for on in scores), default=1.0)
    unknown = structural * _sigmoid(
        constants.unknown_offset + constants.unknown_slope * math.log(max(left, 1e-3) / (1.0 - min(left, 0.999)))
    )
    named = structural - unknown
    total = np.logaddexp.reduce(list(scores.values())) if scores else 0.0
    probabilities = {on: named * math.exp(score - total) for on, score in scores.items()} if scores else {}
    if not scores:
        unknown = structural
    probabilities[()] = 1 - structural
    ranked = sorted(probabilities, key=lambda on: -probabilities[on])
    likely, held = list[tuple[str, ...]](), 0.0
    for on in ranked:
        if held < SURE * (1 - unknown):
            likely.append(on)
            held += probabilities[on]
    chosen = ranked[0]
    if unknown > probabilities[chosen]:
        verdict, chosen = UNKNOWN, ()
    elif chosen == ():
        verdict = NO_GAP if no_gap > 0.5 else MISTUNED
    else:
        verdict = "effect" if probabilities[chosen] > AMBIGUOUS * (1 - unknown) or len(likely) == 1 else "ambiguous"
    return Judgement(verdict, chosen, probabilities, unknown, no_gap, tuple(likely), found)


def _score(on: tuple[str, ...], found: Features, constants: Constants) -> float:
    return (
        found.gain[on] / constants.temperature
        - 0.5 * constants.sharpness * math.log(found.left[on] + constants.form)
        - constants.effect_cost * len(on)
    )


def _sigmoid(x: float) -> float:
    return 1 / (1 + math.exp(-min(max(x, -40.0), 40.0)))


def store(constants: Constants, made: Mapping[str, Any], path: Path = STORED) -> None:
    """Keep constants with how they were found."""
    path.write_text(json.dumps({"constants": asdict(constants), "made": dict(made)}, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def fitted(comparison: Comparison, on: tuple[str, ...]) -> Fit:
    return comparison.models[on] if on else comparison.recalibrated
