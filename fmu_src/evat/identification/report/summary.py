"""What should be read first of an identification? Which values the data tell, or why none is to be believed; what to do next."""

from __future__ import annotations

import math

from evat.headline import Headline
from evat.identification.fits import misfits
from evat.identification.result import Identification


def headline(identification: Identification) -> Headline:
    """The answer in one sentence."""
    share, share_of = _share(identification)
    if identification.stopped:
        return Headline(
            "stopped",
            "bad",
            "The search was stopped: these are the best values so far, and no verdict on any of them.",
            share=share,
            share_of=share_of,
            next="go on with --resume.",
        )
    names = {word: [each.name for each in identification.estimates if each.verdict == word] for word in _WORDS}
    missed = misfits(identification.fits)
    if missed:
        repeated = all(math.isfinite(identification.fits[channel].repeated) for channel in missed)
        return Headline(
            "withheld",
            "bad",
            "No value can be believed yet, however narrow its interval: the model does not follow what was measured.",
            reasons=tuple(missed.values()),
            share=share,
            share_of=share_of,
            next="evat diagnose names the effect that the model lacks; identify again with it on."
            if repeated
            else "record a condition a second time: repeats tell noise from what the model lacks. Then evat diagnose names it.",
        )
    poor = [each for each in identification.estimates if each.verdict != "identified"]
    told = f"These data tell {_joined(names['identified'])}" if names["identified"] else "These data tell none of the free parameters"
    rest = [f"{_joined(names[word])} {_WORDS[word]}" for word in ("weak", "withheld", "not identifiable") if names[word]]
    first = next((each for each in poor if each.verdict == "withheld"), poor[0] if poor else None)
    advised = next((each for each in poor if each.advice), None)
    return Headline(
        "identified" if not poor else "in part" if names["identified"] else "not identified",
        "good" if not poor else "attention" if names["identified"] else "bad",
        "; ".join([told, *rest]) + ".",
        reasons=(f"{first.name}: {first.why}",) if first else (),
        share=share,
        share_of=share_of,
        next="use identified.ssv: it loads into the FMU."
        if not poor
        else f"widen the bound, or switch on what the model lacks (evat diagnose); {first.name} stands and falls with it."
        if first and first.verdict == "withheld"
        else f"for {advised.name}, measure {advised.advice}."
        if advised
        else f"hold {poor[0].name} at a value that is known from elsewhere, and identify the others again.",
    )


_WORDS = {
    "identified": "",
    "weak": "only roughly",
    "withheld": "stands open",
    "not identifiable": "not at all",
}


def _joined(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _share(identification: Identification) -> tuple[str, str]:
    """What the identified model leaves of the channel that it follows worst, where it can be on conditions that no fit saw."""
    fits, where = (
        (identification.held_out, "on conditions that were held out")
        if identification.held_out
        else (identification.fits, "of the data that it was fitted to")
    )
    if not fits:
        return "", ""
    channel = max(fits, key=lambda name: fits[name].share)
    noise = fits[channel].noise if math.isfinite(fits[channel].noise) else identification.fits[channel].noise
    floor = f"; the repeats' noise is {noise / fits[channel].rms * 100 * fits[channel].share:.2g} %" if math.isfinite(noise) else ""
    return f"{100 * fits[channel].share:.2g} %", f"of the rms of {channel.replace('_', ' ')} is what the model leaves {where}{floor}"
