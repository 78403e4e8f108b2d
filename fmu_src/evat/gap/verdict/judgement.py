"""What is to be believed? From what each model explains to probabilities, a verdict, and which effects cannot be told apart.

Evidence alone is far too sure of itself: it takes the form of every effect for exact. So a model is judged by the share of the structural
gap that it leaves, by its evidence at a temperature, and by how many effects it takes. The weights are in evat.gap.verdict.constants.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.compare import Comparison
from evat.gap.verdict.constants import Constants
from evat.gap.verdict.features import Features
from evat.inference.fit import Fit
from evat.inference.hypothesis import NOMINAL, Hypothesis

NO_GAP, MISTUNED, EFFECT, AMBIGUOUS_SETS, UNKNOWN, CANNOT_TELL = "no_gap", "mistuned", "effect", "ambiguous", "unknown", "cannot_tell"
VERDICTS = (NO_GAP, MISTUNED, EFFECT, AMBIGUOUS_SETS, UNKNOWN, CANNOT_TELL)


@dataclass(frozen=True)
class Judgement:
    """`probabilities` of every hypothesis, the nominal model among them, and of `unknown`; the verdict; the hypotheses that hold 90 %; what
    was judged, and by which constants."""

    verdict: str
    chosen: Hypothesis
    probabilities: Mapping[Hypothesis, float]
    unknown: float
    no_gap: float
    likely: tuple[Hypothesis, ...]
    features: Features
    constants: Constants


def _size(structural: Mapping[str, float], features: Features, constants: Constants) -> float:
    """Log of the largest structural rms of a channel over what nobody would look at: little beside the noise, or what few numbers of noise
    may leave."""
    form = max(constants.small_form, CONSTANTS.accuracy_of_laws)
    small = {
        c: constants.small_noise**2 * features.floor[c] + form**2 + CONSTANTS.chance_structure * features.unsure[c] for c in structural
    }
    ratios = [square / small[c] for c, square in structural.items()]
    return 0.5 * math.log(max([*ratios, CONSTANTS.least_gap_size**2]))


@dataclass(frozen=True)
class Steps:
    """The numbers on the way to a judgement; evat.gap.verdict.gates says in words what each did.

    Attributes
    ----------
    size, nominal_size : log of the largest structural rms of a channel over what nobody would look at, recalibrated and nominal.
    lefts, scores : of each hypothesis, the share of the gap that it is held to leave, and its score.
    left, closest, surprise : the hypothesis that speaks most against something unknown, the share that it leaves, where what may be chance
        explains nothing, and the log-odds against it of the nominal values that it needs.
    best, needed, evident : the hypothesis of the best score, the log evidence that makes it evident, and how evident it is (0 to 1).
    by_size : probability of a gap by its size; by_library : share of the probability of a gap that is unknown.
    unknown, structural : probabilities of something unknown and of any gap beyond mis-tuning.
    regular : the same two before what comes and goes by itself was looked at.
    no_gap : probability that the nominal values suffice, where nothing is structural.
    """

    size: float
    nominal_size: float
    lefts: Mapping[Hypothesis, float]
    scores: Mapping[Hypothesis, float]
    left: float
    closest: Hypothesis
    surprise: float
    best: Hypothesis
    needed: float
    evident: float
    by_size: float
    by_library: float
    regular: tuple[float, float]
    unknown: float
    structural: float
    no_gap: float


def steps(features: Features, constants: Constants, reverse: Collection[str] = ()) -> Steps:
    """From features to probabilities. reverse : gates (evat.gap.verdict.gates) that are taken as if they had gone the other way."""
    size, overstated = _size(features.recalibrated, features, constants), features.overstated
    seen = 1.0 if "visible_share" in reverse else _seen(size)
    worse = math.inf if "gap_not_larger" in reverse else CONSTANTS.worse_gap
    shares = dict(features.left) if "held_out" in reverse else {on: features.left_at_least(on) for on in features.left}
    # Values that nobody can have meant are no mis-tuning where an effect does without them: measured by what the nominal values leave.
    strange = (
        0.0 if "credible_values" in reverse else _sigmoid((features.shift - CONSTANTS.credible_shift) * CONSTANTS.credible_shift_slope)
    )
    credible = {on for on in shares if features.shifts.get(on, math.inf) <= CONSTANTS.credible_shift}
    ratio = min(max((after / max(features.nominal[c], after, 1e-300) for c, after in features.recalibrated.items()), default=1.0), 1.0)
    shares = {on: share * (1 - strange * (1 - ratio)) if on in credible else share for on, share in shares.items()}
    lefts = {on: share * seen if share < worse else share for on, share in shares.items()}
    firsts = {on: _first(on, features, constants) if features.one_family.get(on) else None for on in lefts}  # what these leave alone counts
    scores = {on: _score(on, _credited(on, features, constants) / overstated, lefts[firsts[on] or on], constants) for on in features.gain}
    scores = {on: score - CONSTANTS.cost_of_generality * features.general.get(on, 0) for on, score in scores.items()}
    scores = {on: CONSTANTS.score_of_other_forms * score for on, score in scores.items()}
    surprises = {on: 0.0 if "credible_values" in reverse else surprise for on, surprise in _surprises(features).items()}
    scores = {on: score - surprises[on] for on, score in scores.items()}
    # What may be chance explains nothing.
    sure = {on: 1.0 if "beyond_chance" in reverse else _no_chance(gain) for on, gain in features.gain.items()}
    unexplained = {on: 1 - max(1 - lefts[on], 0.0) * sure[on] for on in sure}
    foreign = {on: constants.unknown_slope * _log_odds(share) + surprises[on] for on, share in unexplained.items()}
    closest = min(foreign, key=lambda on: foreign[on], default=NOMINAL)
    left, surprise = unexplained.get(closest, 1.0), surprises.get(closest, 0.0)
    by_size = _sigmoid(constants.structure_offset + CONSTANTS.gap_elsewhere + constants.structure_slope * size)
    if "structural_gap" in reverse:
        by_size = 1 - by_size
    structural, best, needed, evident = by_size, NOMINAL, math.nan, 0.0
    if scores:
        # A gap that is too small to look at is one where an effect has much evidence; the more, the more it leaves of what can be seen.
        best = max(scores, key=lambda on: scores[on])
        glimpsed = math.exp(2 * size) / (math.exp(2 * size) + CONSTANTS.glimpsed_gap_size**2)
        asked = CONSTANTS.evidence_of_other_forms * constants.evident
        needed = asked * (1 + CONSTANTS.evidence_for_what_is_left * glimpsed * shares[best] * overstated)
        needed = overstated * needed + (1 - overstated) * CONSTANTS.chance_evidence
        evident = _sigmoid((features.gain[best] - needed) * 3 / needed)
        if "evident_effect" not in reverse:
            structural = max(structural, evident * max(1 - lefts[best], 0.0))
        if best in credible:
            told = min(sure[best], _no_chance(_told_by_data(best, features)))
            structural = max(structural, strange * told * max(1 - lefts[best], 0.0))
    by_library = _sigmoid(constants.unknown_offset + CONSTANTS.unknown_elsewhere + foreign[closest]) if scores else 1.0
    if "known_to_library" in reverse:
        by_library = 1 - by_library
    unknown = structural * by_library if scores else structural
    regular = unknown, structural
    if "regular" not in reverse:
        unknown, structural = _foreign(features, max(1 - left, 0.0), unknown, structural, constants)
    nominal = _size(features.nominal, features, constants)
    no_gap = 1 - _sigmoid(
        constants.gap_offset + constants.gap_slope * nominal - (features.exact + CONSTANTS.chance_evidence) / constants.evident
    )
    if "nominal_fits" in reverse:
        no_gap = 1 - no_gap
    return Steps(
        size,
        nominal,
        lefts,
        scores,
        left,
        closest,
        surprise,
        best,
        needed,
        evident,
        by_size,
        by_library,
        regular,
        unknown,
        structural,
        no_gap,
    )


def judge(features: Features, constants: Constants, reverse: Collection[str] = ()) -> Judgement:
    """Three questions, one after the other: is there a gap beyond mis-tuning, does the library know it, and which effects are it. Something
    unknown, or nothing, is the verdict where it is likelier than each of the effects, whatever acts beside that: many that are unlikely
    are no reason to name one.

    reverse : gates that are taken as if they had gone the other way, to see which of them moved the verdict.
    """
    step = steps(features, constants, reverse)
    scores, unknown, structural = step.scores, step.unknown, step.structural
    total = np.logaddexp.reduce(list(scores.values())) if scores else 0.0
    probabilities = {on: (structural - unknown) * math.exp(score - total) for on, score in scores.items()}
    probabilities[NOMINAL] = 1 - structural
    ranked = sorted(probabilities, key=lambda on: -probabilities[on])
    likely, held = list[Hypothesis](), 0.0
    for on in ranked:
        if held < CONSTANTS.likely_probability * (1 - unknown):
            likely.append(on)
            held += probabilities[on]

    def judgement(verdict: str, chosen: Hypothesis = NOMINAL) -> Judgement:
        return Judgement(verdict, chosen, probabilities, unknown, step.no_gap, tuple(likely), features, constants)

    most = max(by_part(probabilities).values(), default=0.0)
    if unknown > max(most, 1 - structural):
        return judgement(UNKNOWN)
    if 1 - structural >= most:
        return judgement(NO_GAP if step.no_gap > 0.5 else MISTUNED)
    chosen = next(on for on in ranked if on)
    sure = probabilities[chosen] > least_to_name(CONSTANTS.least_named_probability, unknown, structural) or len(likely) == 1
    if not sure and (in_all := in_most_sets(probabilities, unknown, structural)) in scores:
        chosen, sure = in_all, True
    return judgement(EFFECT if sure and not features.doubts.get(chosen) else AMBIGUOUS_SETS, chosen)


def least_to_name(share: float, unknown: float, structural: float) -> float:
    """Above it an effect is named: a share of what the library knows to act, and no less than of nothing, or of something unknown."""
    return max(share * (structural - unknown), 1 - structural, unknown)


def in_most_sets(probabilities: Mapping[Hypothesis, float], unknown: float, structural: float) -> Hypothesis:
    """The effects that are likely whatever acts beside them: each by the probability of all sets that it is in."""
    least = least_to_name(CONSTANTS.least_effect_probability, unknown, structural)
    return Hypothesis(tuple(name for part, probability in by_part(probabilities).items() if probability > least for name in part.effects))


def by_part(probabilities: Mapping[Hypothesis, float]) -> dict[Hypothesis, float]:
    """The probability of each effect, and of each other base law, in all sets together."""
    total: dict[Hypothesis, float] = {}
    for on, probability in probabilities.items():
        for part in on.parts():
            total[part] = total.get(part, 0.0) + probability
    return total


def _foreign(features: Features, explained: float, unknown: float, structural: float, constants: Constants) -> tuple[float, float]:
    """Probabilities of something unknown and of any gap, where more comes and goes by itself than the effects explain."""
    for channel in unexplained_channels(features, explained):
        foreign = _sigmoid((features.irregular_share[channel] - constants.irregular) * CONSTANTS.irregularity_slope)
        unknown, structural = max(unknown, foreign), max(structural, foreign)
    return unknown, structural


def unexplained_channels(features: Features, explained: float) -> tuple[str, ...]:
    """Where more comes and goes by itself than effects explain. explained : the share of the structural gap that they do."""
    return tuple(c for c, square in features.irregular.items() if square > explained * features.recalibrated[c])


def foreign_channels(features: Features, constants: Constants) -> tuple[str, ...]:
    """Where what comes and goes by itself is something unknown rather than not."""
    unexplained = unexplained_channels(features, max(1 - steps(features, constants).left, 0.0))
    return tuple(channel for channel in unexplained if features.irregular_share[channel] > constants.irregular)


def _seen(size: float) -> float:
    """Which part of what a model leaves says anything; where the gap is too small to look at (log size < 0) evidence alone decides."""
    square = math.exp(2 * size)
    return (square + CONSTANTS.unseen_share) / (square + 1)


def _credited(on: Hypothesis, features: Features, constants: Constants) -> float:
    """Log evidence as far as it counts: what a second effect adds to that of the first, only where it takes a share of what that leaves.
    Else it mends the form of the first, which no effect in the world shares with the library's; as one of its own family does in any case,
    where that is one of the measurement."""
    gain, first = features.gain[on], _first(on, features, constants)
    if first is None:
        return gain
    if features.one_family.get(on):
        return min(gain, features.gain[first])
    taken = 1 - (features.left[on] + constants.form) / (features.left[first] + constants.form)
    credit = min(max(taken / CONSTANTS.second_effect_share, 0.0), 1.0)
    return min(gain, features.gain[first] + credit * max(gain - features.gain[first], 0.0))


def _first(on: Hypothesis, features: Features, constants: Constants) -> Hypothesis | None:
    """Of a set the likelier effect alone, as far as any of it was fitted alone; not one that nominal values make so which nobody can have
    meant."""
    parts = [part for part in on.parts() if part in features.gain] if len(on) > 1 else []
    surprises = _surprises(features)
    return max(parts, key=lambda part: features.gain[part] / constants.temperature - surprises[part], default=None)


def _score(on: Hypothesis, gain: float, left: float, constants: Constants) -> float:
    return gain / constants.temperature - 0.5 * constants.sharpness * math.log(left + constants.form) - constants.effect_cost * len(on)


def _surprises(features: Features) -> dict[Hypothesis, float]:
    """Log-odds against each hypothesis, of the nominal value that it moves most beyond what is credible. In full, unlike evidence: what its
    owner states of a value leans on no form of a law. But owners are too sure at times, and an effect whose form in the world is another
    moves values, too: so by the tails of Student's t, and not of a normal distribution. Where every model moves one further than is
    credible, the owner was too sure by as much as the least of these tells."""
    shifts = {on: features.shifts.get(on, 0.0) for on in features.gain}
    too_sure = max(min([features.shift, *shifts.values()]) / CONSTANTS.credible_shift, 1.0)
    return {on: max(_against(shift / too_sure) - _against(CONSTANTS.credible_shift), 0.0) for on, shift in shifts.items()}


def _against(shift: float) -> float:
    """What a shift of so many standard deviations costs of log probability, by Student's t."""
    return 0.5 * (CONSTANTS.stated_freedom + 1) * math.log1p(shift**2 / CONSTANTS.stated_freedom)


def _told_by_data(on: Hypothesis, features: Features) -> float:
    """Log evidence of a hypothesis without most of what it gains because it leaves stated values where they are: by Student's t, and not
    by a normal distribution, by which values 5 standard deviations off would speak for any effect that takes them back a little."""
    shift, shift_with_it = features.shift, features.shifts.get(on, 0.0)
    normal, tailed = 0.5 * (shift**2 - shift_with_it**2), _against(shift) - _against(shift_with_it)
    return features.gain[on] - max(normal - tailed, 0.0)


def _no_chance(gain: float) -> float:
    """Probability that so much log evidence is none."""
    return _sigmoid((gain - CONSTANTS.chance_evidence) / CONSTANTS.chance_evidence_scale)


def _log_odds(share: float) -> float:
    return math.log(max(share, 1e-3) / max(1 - share, 1e-3))


def _sigmoid(x: float) -> float:
    return 1 / (1 + math.exp(-min(max(x, -40.0), 40.0)))


def fitted(comparison: Comparison, on: Hypothesis) -> Fit:
    return comparison.models[on] if on else comparison.recalibrated
