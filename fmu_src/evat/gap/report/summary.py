"""What should be read first of a diagnosis? The verdict with its physics, how much of the gap closes, why, and the one thing to do next."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Literal

from evat.constants import CONSTANTS
from evat.gap.answer import Diagnosis
from evat.gap.closure import Closure
from evat.gap.next_step import closes, rivals
from evat.gap.report.reached import reached, set_up_off, set_up_size
from evat.gap.report.words import (
    beyond_all,
    closed_interval,
    likelier_than_not,
    number,
    percent,
    remainder,
    sentence,
    set_up_named,
    sure,
    typed,
)
from evat.gap.search.compare import Comparison
from evat.headline import Headline
from evat.inference.setup.setup_errors import MASS
from evat.units import display

_LOOKS: Mapping[str, tuple[str, Literal["good", "note", "attention", "bad"]]] = {
    "no_gap": ("no gap", "good"),
    "set_up": ("within set-up", "note"),  # no gap, where the set-up takes it up
    "wrong_set_up": ("set-up wrong", "attention"),  # the same, further off than its owner can have meant
    "none": ("no effect named", "note"),  # no gap, beside effects that would do
    "mistuned": ("mis-tuned", "note"),
    "effect": ("cause named", "good"),
    "likely": ("likely cause", "note"),  # an effect, beside another that would do or something that is left
    "unsure": ("cause unsure", "attention"),  # the same, where it is no likelier than not
    "ambiguous": ("ambiguous", "attention"),
    "unknown": ("cause unknown", "attention"),
    "cannot_tell": ("cannot tell", "bad"),
}


def headline(answer: Diagnosis, comparison: Comparison) -> Headline:
    """The answer for the top of a page and of a terminal."""
    status, tone = _LOOKS[_look(answer)]
    judged = answer.verdict != "cannot_tell"
    first = tuple(f"{line[:1].upper()}{line[1:]}." for line in (*filter(None, (answer.later,)), *(answer.shifted if judged else ())))
    share, share_of = _share(answer)
    return Headline(
        status,
        "attention" if (first or remainder(answer) or not closes(answer.verdict, answer.closure)) and tone in ("note", "good") else tone,
        sentence(answer, meanings(comparison), share=False),
        first=first,
        reasons=comparison.audit.refused
        if not judged
        else (*_meanings(answer, comparison), *_doubted(answer), *reached(answer, comparison)),
        share=share,
        share_of=share_of,
        next=_next(answer, comparison),
    )


def _look(answer: Diagnosis) -> str:
    if answer.verdict == "no_gap" and any(answer.judgement.likely):
        return "none"
    if answer.verdict == "no_gap" and answer.recalibration.notable:
        return "set_up" if all(error.credible for error in answer.recalibration.notable) else "wrong_set_up"
    if answer.verdict == "effect" and (rivals(answer.judgement) or remainder(answer)):
        return "likely" if likelier_than_not(answer) else "unsure"
    return answer.verdict


def meanings(comparison: Comparison) -> dict[str, str]:
    """What each effect and each other base law is in the world, as the model declares it."""
    prediction = comparison.prediction
    effects = {effect.name: effect.physics for effect in prediction.model.effects}
    laws = {rival.name: rival.meaning for rival in prediction.model.rival_laws(prediction.nominal)}
    return {name: words for name, words in {**effects, **laws}.items() if words and words != name}


def _meanings(answer: Diagnosis, comparison: Comparison) -> tuple[str, ...]:
    """Of what the sentence names and does not explain itself."""
    known = meanings(comparison)
    named: Iterable[str] = ()
    if answer.verdict == "ambiguous":
        named = [name for on in answer.judgement.likely for name in on.names]
    elif answer.small_effect:
        named = [name for on in answer.small_effect.either for name in on.names]
    return tuple(f"{name}: {known[name]}" for name in dict.fromkeys(named) if name in known)


def _doubted(answer: Diagnosis) -> tuple[str, ...]:
    """Why the likeliest of several is not named; of one alone the sentence says so."""
    judgement = answer.judgement
    reasons = judgement.features.doubts.get(judgement.chosen, ())
    if answer.verdict != "ambiguous" or len(judgement.likely) < 2 or not reasons:
        return ()
    return (f"{judgement.chosen} is doubted: {'; '.join(reasons)}",)


def _share(answer: Diagnosis) -> tuple[str, str]:
    """How much of the gap closes, with its interval: on conditions left out of the fit, or with too few of them on all."""
    closure, held = answer.closure, len(answer.closure.held_out_conditions)
    conditions = f"{held} condition{'s' if held > 1 else ''}, each left out of the fit"
    if answer.judgement.chosen and answer.verdict in ("effect", "ambiguous"):
        (value, (low, high)), what = (
            (closure.closed_share, closure.interval),
            "of what recalibration leaves above the noise is closed by the fit",
        )
    elif answer.verdict == "mistuned":
        (value, (low, high)), what = closure.by_recalibration, "of the gap above the noise is closed by recalibration with the set-up"
    else:
        return "", ""
    if not held:
        value, (low, high) = closure.closed_share_where_fitted
        conditions = "the conditions that it was fitted to"
    if not math.isfinite(value):
        return "No share", f"can be given: on {conditions} there is no gap above the noise"
    interval = closed_interval(low, high) or f"without an interval: {CONSTANTS.fewest_recordings} recordings tell one"
    said = "; ".join(filter(None, (interval, beyond_all(value, low, high))))
    return percent(value), f"{what}, on {conditions} ({said}){_why_fitted(closure)}"


def _why_fitted(closure: Closure) -> str:
    """Why the share is none of conditions left out of the fit."""
    if closure.held_out_conditions:
        return ""
    if closure.unforeseen:
        return f"; none can be held out of the fits: without {', '.join(closure.unforeseen)} the others do not determine the values"
    return f"; with fewer than {CONSTANTS.fewest_conditions} conditions none can be held out of the fits"


def _next(answer: Diagnosis, comparison: Comparison) -> str:
    """The one thing to do, in words."""
    closure, experiment = answer.closure, _experiment(answer, comparison)
    also = f"{experiment[:1].upper()}{experiment[1:]}" if experiment else "Record more conditions."
    match answer.next_step:
        case "put_right":
            return "put right what is said above, and diagnose again."
        case "look_at_all":
            return "diagnose again with --whole, which looks at all samples and takes longer, or cut what follows into trials of their own."
        case "check_set_up":
            return _check(answer, comparison)
        case "check_set_up_then_record":
            return _check(answer, comparison) + (f" If that is right, {experiment}" if experiment else "")
        case "nothing":
            return "nothing; the nominal model is as good as these data can tell."
        case "look_for_disturbance":
            return (
                "look for mains hum, a loose cable, deposits that tear off, starved lubrication or chatter, and record the repeats again."
            )
        case "look_where_gap_lies":
            return f"look at the measurement {_place(answer, comparison)}: the gap lies there, and no known effect makes it."
        case "check_nominal_value":
            return "find out where that nominal value comes from, before the recalibrated one is used: it is further off than was said."
        case "record_first":
            if answer.verdict == "ambiguous":
                return "record more conditions; what is doubted cannot be settled by these."
            return "do not use the recalibrated values yet; record more conditions, and look where the forces reverse or jump."
        case "use_values":
            return _use(answer, comparison, "use the recalibrated values: corrected.ssv holds them.")
        case "record":
            return experiment or "record more conditions, that tell what is likely apart or are tried where no fit has looked."
        case "record_without_trust":
            why = "it does not hold" if math.isfinite(closure.closed_share) else "there is no gap to close"
            return f"do not use the corrected model yet: {why} where no fit has looked. {also}"
        case "record_for_form":
            share = percent(closure.values_with_set_up.closed_share)
            return f"do not use corrected.ssv: it closes {share} without the form of the law that fits have. {also}"
        case "use_corrected":
            return _use(answer, comparison, "use corrected.ssv: it switches the effect on, with the values of this diagnosis.")


def _use(answer: Diagnosis, comparison: Comparison, values: str) -> str:
    """Values by themselves, or first what has to be put right for them to do, or to be looked at."""
    if left := remainder(answer):
        return f"look at what is left before corrected.ssv is used: what it leaves {left}, and something else is not as the model has it."
    closed = answer.closure.values_alone.closed_share
    if closed > CONSTANTS.advised_share or not (off := set_up_off(answer, comparison)):
        return values
    if not math.isfinite(closed):  # where the model is that is compared with, as the set-up shows it, nothing stands above the noise
        return f"put right what the set-up is off by ({off}); then {values}"
    return f"put right what the set-up is off by ({off}), or the values close {percent(closed)} alone; then {values}"


def _check(answer: Diagnosis, comparison: Comparison) -> str:
    """What of the set-up stands in for the gap, to be looked at on the rig."""
    taken = answer.recalibration.notable
    assumed = " and ".join(set_up_size(comparison.prediction, error) for error in taken)
    if [error.kind for error in taken] == [MASS]:
        return f"check the moved mass on the rig ({assumed} more than stated is assumed), and state it as nominal.mass."
    return f"check {set_up_named(taken)} on the rig ({assumed} is assumed), and state by setup_sd how far off it may be."


def _experiment(answer: Diagnosis, comparison: Comparison) -> str:
    """The condition that tells the likely models apart."""
    if answer.next_experiment is None:
        return ""
    signals = comparison.prediction.experiment.signals
    at = ", ".join(
        f"{name} = {display(x, typed(comparison.prediction, name), digits=4)}{' rms' if name in signals else ''}"
        for name, x in answer.next_experiment.values.items()
    )
    one, other = (str(on) for on in answer.next_experiment.separates)
    how = sure(answer.next_experiment.expected_probability)
    like = answer.next_experiment.condition
    return (
        f"record more conditions; by these models best {like!r} once more, with {at}: with a probability of {how} that tells "
        f"{one} from {other}."
    )


def _place(answer: Diagnosis, comparison: Comparison) -> str:
    """Where most of the gap lies, in words."""
    if not answer.where.regions:
        return "itself"
    region, bounds = answer.where.regions[0], []
    for name, ends in region.box.items():
        if name in ("time", "phase"):
            said = [f"{number(x, 3)}{' s' if name == 'time' else ''}" for x in ends]
        else:
            said = [display(x, typed(comparison.prediction, name), digits=3) for x in ends]
        bounds.append(f"{name.replace('_', ' ')} from {' to '.join(said)}")
    return f"of {region.channel.replace('_', ' ')}" + (f" at {' and '.join(bounds)}" if bounds else "")
