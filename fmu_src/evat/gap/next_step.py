"""What is to be done next, after a diagnosis? One decision, that words and diagnosis.json are made of."""

from __future__ import annotations

from typing import Literal

from evat.constants import CONSTANTS
from evat.gap.closure import Closure
from evat.gap.verdict.judgement import AMBIGUOUS_SETS, CANNOT_TELL, MISTUNED, NO_GAP, UNKNOWN, Judgement
from evat.inference.hypothesis import Hypothesis

Step = Literal[
    "put_right",  # what makes the data unfit
    "look_at_all",  # samples
    "check_set_up",
    "check_set_up_then_record",
    "nothing",
    "look_for_disturbance",
    "look_where_gap_lies",
    "check_nominal_value",
    "record_first",  # more conditions, before recalibrated values are used
    "use_values",
    "record",  # the condition that tells the two likeliest models apart
    "record_without_trust",  # the same, as the corrected model does not hold elsewhere
    "record_for_form",  # the same, as it is not the values that close the gap
    "use_corrected",
]
RECORDED = {"check_set_up_then_record", "record", "record_without_trust", "record_for_form"}


def closes(verdict: str, closure: Closure) -> bool:
    """Whether recalibration, where nothing else is named, closes as much of the gap as a corrected model is advised for: as it was fitted,
    and by its values with the set-up put right."""
    share, _ = closure.by_recalibration if closure.held_out_conditions else closure.closed_share_where_fitted
    by_values = closure.values_with_set_up.closed_share
    return verdict != MISTUNED or not (share <= CONSTANTS.advised_share or by_values <= CONSTANTS.advised_share)


def rivals(judgement: Judgement) -> tuple[Hypothesis, ...]:
    """What may be behind the gap in place of the effects that are named: the other likely hypotheses that do without them."""
    return tuple(on for on in judgement.likely if not set(judgement.chosen) <= set(on))


def next_step(
    verdict: str,
    judgement: Judgement,
    closure: Closure,
    *,
    set_up: bool = False,
    later: bool = False,
    foreign: bool = False,
    far: bool = False,
) -> Step:
    """set_up : it takes up most of the gap; later : samples that were not looked at leave more; foreign : something comes and goes by
    itself; far : a nominal value is further off than its owner believes."""
    others = any(judgement.likely)
    if verdict == CANNOT_TELL:
        return "put_right"
    if later:
        return "look_at_all"
    if verdict in (NO_GAP, MISTUNED) and set_up:
        return "check_set_up_then_record" if others else "check_set_up"
    if verdict == NO_GAP:
        return "record" if others else "nothing"
    if verdict == UNKNOWN:
        return "look_for_disturbance" if foreign else "look_where_gap_lies"
    if verdict == MISTUNED:
        return "check_nominal_value" if far else "use_values" if closes(verdict, closure) else "record_first"
    if verdict == AMBIGUOUS_SETS:
        doubted = bool(judgement.features.doubts.get(judgement.chosen))
        return "record_first" if doubted and len(judgement.likely) < 2 else "record"
    if not closure.held_out_conditions:
        return "record"
    if not closure.closed_share > CONSTANTS.advised_share:
        return "record_without_trust"
    if closure.values_with_set_up.closed_share <= CONSTANTS.advised_share:
        return "record_for_form"
    return "record" if rivals(judgement) else "use_corrected"
