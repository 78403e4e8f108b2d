"""What do the data say about each parameter? identified, weak, not identifiable from these data, or nothing yet; why; what would tell it.

identified       : the profile closes on both sides, within BROAD of the estimate
weak             : it closes on one side only, or wider than that, or has a second valley, or the estimate lies on a bound
not identifiable : up to both bounds the data do not object
withheld         : the search was stopped, the model misses what was measured, or another parameter is kept by its bound from where the
                   data want it: an interval counts noise, and says nothing of these
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from evat.experiment import as_typed
from evat.identification.covariance import LOOSE, Optimum
from evat.identification.objective import Objective
from evat.identification.profile import Profile
from evat.identification.result import Curve, Estimate, Word
from evat.identification.verdicts.advice import advise
from evat.identification.verdicts.reasons import facts, reason
from evat.model import FloatArray
from evat.units import display

BROAD = 0.5  # half the interval over the estimate
COUPLED = 0.9  # correlation from which two parameters are told as one
EDGE = 1e-4  # of the unit interval, and a standard error: an estimate that is nearer to a bound lies on it
PULL = 3.0  # sd: how steeply the loss falls beyond a bound, from which the bound decides and not the data


def correlation(covariance: FloatArray) -> FloatArray:
    sd = np.sqrt(np.diag(covariance))
    return np.clip(covariance / sd[:, None] / sd[None, :], -1.0, 1.0)


def estimates(
    objective: Objective, optimum: Optimum, profiles: Sequence[Profile | None], missed: Sequence[str] = (), stopped: bool = False
) -> tuple[Estimate, ...]:
    """Each free parameter, judged. Without a profile (none were asked for) the standard error decides.

    missed : what shows that the model misses what was measured; stopped : the search was ended before it came to its end.
    """
    values = {**objective.prediction.nominal, **objective.values, **objective.space.at(optimum.point)}
    known = facts(objective.prediction.experiment, values)
    related = correlation(optimum.covariance)
    words = [_word(objective, optimum, place, profile) for place, profile in enumerate(profiles)]
    against = _against(objective, optimum, words, missed, stopped)
    poor = [name for name, word in zip(objective.space.names, words, strict=True) if word != "identified" and not stopped]
    untold = [
        name
        for place, (name, word) in enumerate(zip(objective.space.names, words, strict=True))
        if word == "not identifiable" or _edge(optimum, place)
    ]
    advices = advise(objective, optimum, poor, untold)
    verdicts, signals = [], objective.prediction.experiment.signals
    for place, (one, told, curve) in enumerate(zip(objective.space.free, words, profiles, strict=True)):
        u = float(optimum.point[place])
        sd_u = float(np.sqrt(optimum.covariance[place, place]))
        edge = _edge(optimum, place)
        why = "" if told == "identified" else _why(objective, related, place, edge, curve, reason(one.name, known))
        word: Word = "withheld" if against[place] else told
        why = "; ".join([*against[place], *([why] if why and not stopped else [])])
        verdicts.append(
            Estimate(
                variable=as_typed(one.variable, signals),
                nominal=one.start,
                bounds=(one.low, one.high),
                value=one.value(u),
                sd=float(np.inf) if sd_u > LOOSE / 10 or told == "not identifiable" else sd_u * one.slope(u),
                low=float("nan") if curve is None else one.value(curve.low),
                high=float("nan") if curve is None else one.value(curve.high),
                open_below=curve is not None and curve.open_below,
                open_above=curve is not None and curve.open_above,
                at_bound=edge,
                verdict=word,
                why=why,
                advice=advices.get(one.name, ""),
                profile=None if curve is None else Curve(one.values(curve.u), curve.rise, curve.threshold),
            )
        )
    return tuple(verdicts)


def _edge(optimum: Optimum, place: int) -> Literal["", "lower", "upper"]:
    """On which of its bounds an estimate lies. The bounds may be so far apart that an estimate well inside is near to one beside that."""
    u, near = float(optimum.point[place]), min(EDGE, float(np.sqrt(optimum.covariance[place, place])))
    return "lower" if u < near else "upper" if u > 1 - near else ""


def _against(objective: Objective, optimum: Optimum, words: Sequence[Word], missed: Sequence[str], stopped: bool) -> list[list[str]]:
    """Of each parameter what speaks against any verdict on it."""
    names, outward = objective.space.names, {"lower": -optimum.pull, "upper": optimum.pull, "": np.zeros(optimum.pull.size)}
    kept = [name for place, name in enumerate(names) if outward[_edge(optimum, place)][place] > PULL]
    against = []
    for name, word in zip(names, words, strict=True):
        others = [other for other in kept if other != name]
        if stopped:
            against.append(["the search was stopped: this is the best so far, and nothing is known of its surroundings"])
        elif word == "not identifiable":  # the data say nothing of it: that needs no model that fits
            against.append([])
        else:
            bound = [f"it holds only if {', '.join(others)} belongs on its bound, beyond which the data want it"] if others else []
            against.append([*missed, *bound])
    return against


def _word(objective: Objective, optimum: Optimum, place: int, profile: Profile | None) -> Word:
    one, u = objective.space.free[place], float(optimum.point[place])
    value = one.value(u)
    if profile is None:
        half = 1.645 * float(np.sqrt(optimum.covariance[place, place])) * one.slope(u)
        return "identified" if half < BROAD * abs(value) else "weak" if half < one.high - one.low else "not identifiable"
    if profile.open_below and profile.open_above:
        return "not identifiable"
    half = 0.5 * (one.value(profile.high) - one.value(profile.low))
    closed = not (profile.open_below or profile.open_above or profile.valleys)
    scale = abs(value) if one.low > 0 or one.high < 0 else one.high - one.low  # where zero is inside, a relative width says nothing
    return "identified" if closed and half <= BROAD * scale and not _edge(optimum, place) else "weak"


def _why(objective: Objective, related: FloatArray, place: int, edge: str, profile: Profile | None, sentence: str) -> str:
    names, one = objective.space.names, objective.space.free[place]
    parts = [sentence] if sentence else []
    if edge:
        parts.append(f"the estimate lies on its {edge} bound; the data want it further out, or the model is not the right one")
    partners = [names[other] for other in np.argsort(-np.abs(related[place])) if other != place and abs(related[place, other]) > COUPLED]
    if partners:
        numbers = ", ".join(f"{name} ({related[place, names.index(name)]:+.4f})" for name in partners[:3])
        parts.append(f"only together with others is it seen: correlation with {numbers}")
    if profile is not None and profile.valleys:
        parts.append("a second set of values, apart from this one, fits almost as well; the interval holds both")
    if profile is not None:
        if profile.open_below and profile.open_above:
            flat = float(np.max(profile.rise)) < 0.1 * profile.threshold
            parts.append(
                "its profile is flat: within the bounds hardly anything that was measured depends on it"
                if flat
                else "the data object at neither bound once the other parameters have followed"
            )
        elif profile.open_above != profile.open_below:
            side = "above" if profile.open_below else "below"
            end = one.value(profile.high if profile.open_below else profile.low)
            shown = as_typed(one.variable, objective.prediction.experiment.signals)
            parts.append(f"the data limit it from {side} only, by {display(end, shown, digits=4)}")
    return "; ".join(parts) or "the noise is too large for these data to tell it within half its value"
