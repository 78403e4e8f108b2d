"""What do values alone reach, and what is the set-up's? Said with figures and units, beside the verdict."""

from __future__ import annotations

import math

from evat.constants import CONSTANTS
from evat.gap.answer import Diagnosis
from evat.gap.report.words import beyond_all, number, percent, set_up_named, shown_unit
from evat.gap.search.compare import Comparison
from evat.gap.set_up import SetUpError, set_up_errors
from evat.gap.verdict.judgement import AMBIGUOUS_SETS, EFFECT, MISTUNED, NO_GAP, fitted
from evat.inference.prediction import Prediction


def reached(answer: Diagnosis, comparison: Comparison) -> tuple[str, ...]:
    """Lines for the top of a page; none where there is no gap to speak of."""
    taken, verdict = answer.recalibration.notable, answer.verdict
    if verdict not in (NO_GAP, MISTUNED, EFFECT, AMBIGUOUS_SETS) or (verdict == NO_GAP and not taken):
        return ()
    nominal = comparison.prediction.experiment.nominal.effects
    off = "; ".join(_error(comparison.prediction, each) for each in taken)
    forms = [name for name in fitted(comparison, answer.judgement.chosen).on if name not in (*nominal, *answer.judgement.chosen.effects)]
    return (
        *((f"Taken to be off: {off}. None of that is in corrected.ssv.",) if taken else ()),
        *(
            (f"corrected.ssv switches {' and '.join(forms)} on: so little of it is another form of the law, and no effect.",)
            if forms
            else ()
        ),
        *_alone(answer, comparison),
    )


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


def set_up_off(answer: Diagnosis, comparison: Comparison) -> str:
    """What the set-up is off by, the largest first: errors that are surely not 0 and change a channel by half of the noise and more."""
    rms, sizes = answer.closure.rms, list[tuple[float, str]]()
    for error in set_up_errors(comparison, fitted(comparison, answer.judgement.chosen)):
        size = max(error.changes[channel] / max(row["noise_floor"], 1e-300) for channel, row in rms.items())
        if abs(error.value) > CONSTANTS.sure_error * error.sd and size > CONSTANTS.notable_error:
            sizes.append((size, f"{set_up_named((error,))} by {set_up_size(comparison.prediction, error)}"))
    return ", ".join(said for _, said in sorted(sizes, reverse=True))


def _alone(answer: Diagnosis, comparison: Comparison) -> tuple[str, ...]:
    """What corrected.ssv leaves with the set-up put right, and as it is; alone where the set-up leaves nothing to close."""
    closure, prediction = answer.closure, comparison.prediction
    put_right = math.isfinite(closure.values_with_set_up.closed_share)
    values = closure.values_with_set_up if put_right else closure.values_alone
    if not math.isfinite(values.closed_share):
        return ()
    whose = "recalibrated" if answer.judgement.chosen else "nominal"
    each = []
    for channel, row in values.rms.items():
        own, theirs, noise = (_size(prediction, channel, x) for x in (row["corrected"], row[whose], closure.rms[channel]["noise_floor"]))
        if put_right:
            own += f" rms ({_size(prediction, channel, closure.values_alone.rms[channel]['corrected'])} as the set-up is)"
            theirs += f" ({_size(prediction, channel, closure.values_alone.rms[channel][whose])})"
        else:
            own += " rms"
        each.append(f"of the {channel.replace('_', ' ')} it leaves {own}, they leave {theirs}, and the noise is {noise}")
    share = percent(values.closed_share) if values.closed_share > CONSTANTS.noise_floor_error else "nothing"
    if beyond := beyond_all(values.closed_share):
        share = f"{share} ({beyond})"
    how = "With the set-up put right" if put_right else "By itself"
    form = " Fits have a form of the law beside the values, which no parameter set holds." if prediction.form_names else ""
    return (f"{how} corrected.ssv closes {share} of what the {whose} values leave so above the noise: {'; '.join(each)}.{form}",)
