"""What do values alone reach, and what is the set-up's? Said with figures and units, beside the verdict."""

from __future__ import annotations

import math

from evat.constants import CONSTANTS
from evat.gap.answer import Diagnosis
from evat.gap.report.words import beyond_all, number, percent, set_up_named, shown_unit
from evat.gap.search.compare import Comparison
from evat.gap.set_up import SetUpError
from evat.gap.verdict.judgement import AMBIGUOUS_SETS, EFFECT, MISTUNED, NO_GAP
from evat.inference.prediction import Prediction


def reached(answer: Diagnosis, comparison: Comparison) -> tuple[str, ...]:
    """Lines for the top of a page; none where there is no gap to speak of."""
    taken, verdict = answer.recalibration.notable, answer.verdict
    if verdict not in (NO_GAP, MISTUNED, EFFECT, AMBIGUOUS_SETS) or (verdict == NO_GAP and not taken):
        return ()
    off = "; ".join(_error(comparison.prediction, each) for each in taken)
    return (*((f"Taken to be off: {off}. None of that is in corrected.ssv.",) if taken else ()), *_alone(answer, comparison))


def _error(prediction: Prediction, error: SetUpError) -> str:
    end = ", and this is the most that it may be" if error.bound else ""
    tolerance = _sized(prediction, error, error.tolerance, 2)
    return f"{set_up_named((error,))} by {set_up_size(prediction, error)} (tolerance {tolerance} as a standard deviation{end})"


def set_up_size(prediction: Prediction, error: SetUpError) -> str:
    """Its value with its unit."""
    return _sized(prediction, error, error.value, 3)


def _sized(prediction: Prediction, error: SetUpError, x: float, digits: int) -> str:
    if error.kind == "zero":
        return _size(prediction, error.channel, x, digits)
    return f"{100 * x:.{digits}g} %" if error.kind == "gain" else number(x, digits) + ("" if error.unit == "1" else f" {error.unit}")


def _size(prediction: Prediction, name: str, x: float, digits: int = 4) -> str:
    """A difference of a signal or channel, in the unit of its owner's files."""
    unit, factor, _ = shown_unit(prediction, name)
    return number(factor * x, digits) + ("" if unit == "1" else f" {unit}")


def _alone(answer: Diagnosis, comparison: Comparison) -> tuple[str, ...]:
    """What corrected.ssv leaves by itself, channel by channel."""
    alone, added, closure = answer.closure.alone, bool(answer.judgement.chosen), answer.closure
    if not math.isfinite(alone.share):
        return ()
    whose = "recalibrated" if added else "nominal"
    prediction = comparison.prediction
    each = []
    for channel, row in alone.rms.items():
        own, theirs, noise = (_size(prediction, channel, x) for x in (row["corrected"], row[whose], closure.rms[channel]["noise_floor"]))
        each.append(f"of the {channel.replace('_', ' ')} it leaves {own} rms, they leave {theirs}, and the noise is {noise}")
    beside = "the set-up and a form of the law" if prediction.form_names else "the set-up"
    share = percent(alone.share) if alone.share > CONSTANTS.noise_floor_error else "nothing"
    if beyond := beyond_all(alone.share):
        share = f"{share} ({beyond})"
    return (
        f"By itself corrected.ssv closes {share} of what the {whose} values by themselves leave above the noise: {'; '.join(each)}. "
        f"What was fitted has {beside} beside the values.",
    )
