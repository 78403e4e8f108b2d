"""How is a diagnosis said in plain words? One sentence for the verdict, and how sets of effects and numbers are written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from evat.constants import CONSTANTS
from evat.experiment import as_typed
from evat.gap.answer import Diagnosis
from evat.gap.next_step import closes, rivals
from evat.gap.set_up import SetUpError
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.inference.noise.irregularity import Irregularity
from evat.inference.prediction import Prediction
from evat.inference.setup.setup_errors import called
from evat.model import Variable
from evat.units import affine

SENTENCES = {
    "no_gap": "No gap beyond noise and repeatability.",
    "mistuned": "Only mis-tuned: recalibrating the nominal parameters closes the gap.",
    "unknown": "A gap that none of the known effects explains.",
    "cannot_tell": "These data cannot tell.",
}

HARDLY_CLOSES = "No effect is needed beside other nominal values, but recalibrating these hardly closes the gap."


def sentence(answer: Diagnosis, meanings: Mapping[str, str] = MappingProxyType({}), *, share: bool = True) -> str:
    """The verdict in one sentence. meanings : of effects and laws, what each is in the world; share : say how much of the gap it closes."""
    if answer.verdict == "unknown" and answer.foreign:
        return _foreign(answer.foreign)
    if answer.verdict in SENTENCES:
        return _without_effects(answer) + _left(answer) + (f" Beside that, {_small(answer)}." if answer.small_effect else "")
    if answer.verdict == "ambiguous":
        likely, reasons = answer.judgement.likely, answer.judgement.features.doubts.get(answer.judgement.chosen, ())
        if len(likely) == 1:
            return f"The gap may be caused by {likely[0]}, but {'; '.join(reasons)}."
        return _of_one_family(answer, likely) or _ambiguous(likely)
    each = [f"another base law ({e.name})" if e.is_law else e.name for e in answer.effects]
    known = [meanings.get(e.name, "") for e in answer.effects]
    if len(each) == 1:
        names = f"{each[0]}: {known[0]}" if known[0] else each[0]
    else:
        names = " and ".join(f"{name} ({what})" if what else name for name, what in zip(each, known, strict=True))
    probabilities = answer.judgement.probabilities
    others = " or ".join(f"{on} ({sure(probabilities[on])})" for on in rivals(answer.judgement))
    how, also = sure(probability_of(answer)), f"{_beside(answer)}{_far(answer) if share else ''}{_size(answer)}"
    if others and not likelier_than_not(answer):
        return (
            f"The likeliest cause of the gap, and no likelier than not, is {names} (probability {how}); it may be {others} instead{also}."
            f"{_left(answer)}"
        )
    most, unless = ("most likely ", f", if not by {others}") if others else ("", "")
    return f"The gap is {most}caused by {names} (probability {how}){unless}{also}.{_left(answer)}"


def _without_effects(answer: Diagnosis) -> str:
    """Where no effect is named: whether the set-up takes up most of the gap, and what else is likely."""
    taken, others = answer.recalibration.notable, [on for on in answer.judgement.likely if on]
    if answer.verdict not in ("no_gap", "mistuned") or not (taken or others):
        return SENTENCES[answer.verdict] if closes(answer.verdict, answer.closure) else HARDLY_CLOSES
    if taken:
        within = "within" if all(error.credible for error in taken) else "beyond"
        said = f"No effect is named: {set_up_named(taken)}, {within} the tolerance of the set-up, takes up most of the gap"
        said += " beside other nominal values." if answer.verdict == "mistuned" else "."
    else:
        said = (
            "No effect is named."
            if answer.verdict == "no_gap"
            else SENTENCES["mistuned"]
            if closes(answer.verdict, answer.closure)
            else HARDLY_CLOSES
        )
    if not others:
        return said
    probabilities = answer.judgement.probabilities
    rest = " or ".join(f"{on} ({sure(probabilities[on])})" for on in others)
    return f"{said} That no effect acts is likeliest ({sure(probabilities[NOMINAL])}), if it is not {rest}."


def set_up_named(errors: Sequence[SetUpError]) -> str:
    """Errors of the set-up in words."""
    return " and ".join(called(error.channel, error.kind) for error in errors)


def remainder(answer: Diagnosis) -> str:
    """What the corrected model, or recalibration, leaves of a channel, where that is far more than noise; "" where it is not."""
    if answer.verdict not in ("mistuned", "effect"):
        return ""
    floors = {channel: row["corrected"] / row["noise_floor"] for channel, row in answer.closure.rms.items() if row["noise_floor"] > 0}
    most = max(floors, key=lambda channel: floors[channel], default="")
    if not most or not floors[most] > CONSTANTS.notable_remainder:
        return ""
    return f"of the {most.replace('_', ' ')} is {floors[most]:.2g} times the noise"


def _left(answer: Diagnosis) -> str:
    left = remainder(answer)
    return f" What it leaves {left}: look at it before you trust the values." if left else ""


def _beside(answer: Diagnosis) -> str:
    """What may act beside what is named, each with its probability, where that is worth a word."""
    chosen, acts = set(answer.judgement.chosen), dict[str, float]()
    for on, probability in answer.judgement.probabilities.items():
        for name in set(on) - chosen if chosen < set(on) else ():
            acts[name] = acts.get(name, 0.0) + probability
    likely = sorted((name for name, probability in acts.items() if probability > CONSTANTS.notable_second), key=lambda name: -acts[name])
    if not likely:
        return ""
    return f"; beside it, perhaps, {' or '.join(f'{name} ({sure(acts[name])})' for name in likely)}"


def probability_of(answer: Diagnosis) -> float:
    """That what is named acts, alone or with others."""
    return sum(p for on, p in answer.judgement.probabilities.items() if set(answer.judgement.chosen) <= set(on))


def likelier_than_not(answer: Diagnosis) -> bool:
    """Whether what is named has even odds at least."""
    return probability_of(answer) >= 0.5


def _foreign(foreign: Mapping[str, Irregularity]) -> str:
    each = [f"in the {channel.replace('_', ' ')} {comes}" for channel, comes in foreign.items()]
    return f"Something comes and goes by itself that none of the known effects does: {'; '.join(each)} of what repeats do not share."


def _size(answer: Diagnosis) -> str:
    if answer.small_effect is None:
        return ""
    return f"; it is small, {percent(answer.small_effect.share_of_rms)} of the {answer.small_effect.channel.replace('_', ' ')}"


def _small(answer: Diagnosis) -> str:
    """An effect that the data ask for and that is small, where the verdict names none."""
    small = answer.small_effect
    if small is None:
        return ""
    which, share = " or ".join(map(str, small.either)), percent(small.share_of_rms)
    return (
        f"the data ask for {which} (log evidence {small.log_evidence:.0f}), {share} of the {small.channel.replace('_', ' ')}: "
        "too small to be named as a cause"
    )


def _of_one_family(answer: Diagnosis, likely: Sequence[Hypothesis]) -> str:
    """Where all that is likely is one effect of a family."""
    for family, probability in answer.families.items():
        if all(len(on) == 1 and set(on) <= set(answer.members.get(family, ())) for on in likely):
            which = " or ".join(on.names[0] for on in likely)
            how = sure(probability)
            return f"The gap is caused by an effect of the family {family} (probability {how}): {which}, which the data cannot tell apart."
    return ""


def _ambiguous(likely: Sequence[Hypothesis]) -> str:
    """What all likely hypotheses have in common is sure, the rest is open."""
    common = [name for name in likely[0] if all(name in on for on in likely)] if likely else []
    rest = [[name for name in on if name not in common] for on in likely]
    if not common:
        return f"One of these, which the data cannot tell apart: {'; '.join(' + '.join(on) or 'no effect' for on in rest)}."
    sets = "; ".join(" + ".join(on) for on in rest if on)
    also = "perhaps also" if not all(rest) else "also"
    return f"The gap is caused by {' and '.join(common)}, and {also} by one of these, which the data cannot tell apart: {sets}."


def sure(probability: float) -> str:
    """A probability as a person reads it."""
    return "above 99 %" if probability > 0.99 else f"{100 * probability:.0f} %"


def _far(answer: Diagnosis) -> str:
    closed, them = answer.closure.closed_share, "them" if len(answer.effects) > 1 else "it"
    if not math.isfinite(closed):
        return ""
    if closed <= 0:
        return f"; but on conditions left out of the fit adding {them} closes nothing of what recalibration leaves"
    return f"; on conditions left out of the fit adding {them} closes {100 * closed:.0f} % of what recalibration leaves"


def number(value: float | None, digits: int = 4) -> str:
    """As a person reads it; what is not known is a dash."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def with_unit(value: float | None, unit: str, digits: int = 4) -> str:
    return number(value, digits) + ("" if unit == "1" or value is None or not math.isfinite(value) else f" {unit}")


def typed(prediction: Prediction, name: str) -> Variable:
    """A variable of the model, shown as the files of the experiment have it."""
    variable = next(each for each in prediction.model.variables if each.name == name)
    return as_typed(variable, prediction.experiment.signals)


def shown_unit(prediction: Prediction, name: str) -> tuple[str, float, float]:
    """The unit in which a signal or channel is shown; value in it = factor * value in SI + offset."""
    if name in ("time", "phase"):
        return ("s" if name == "time" else "1"), 1.0, 0.0
    variable = typed(prediction, name)
    unit = variable.display_unit or variable.unit
    return unit, *affine(variable.unit, unit)


def beyond_all(*shares: float | None) -> str:
    """What it means that a share of the gap or an end of its interval is above 1; "" where none is."""
    above = any(share is not None and math.isfinite(share) and float(f"{share:.3g}") > 1 for share in shares)
    return "above 100 % less is left than the noise was estimated at, by chance or by a correction that goes too far" if above else ""


def closed_interval(low: float, high: float) -> str:
    """The 90 % interval of a share of the gap; "" where there is none."""
    return f"90 % interval {percent(low)} to {percent(high)}" if math.isfinite(low) else ""


def percent(share: float | None) -> str:
    """Of a share."""
    if share is None or not math.isfinite(share):
        return "-"
    return "< 0.01 %" if 0 < share < 1e-4 else f"{100 * share:.3g} %"
