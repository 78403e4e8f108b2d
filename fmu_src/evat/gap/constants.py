"""Which constants does the judgement weigh by, and where are they kept? Reasoned ones, until simulated cases have told of better ones."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from evat.files.writing import put
from evat.model import EvatError

STORED = Path(__file__).with_name("calibration.json")


@dataclass(frozen=True)
class Constants:
    """Of the judgement; each is a weight of one of the features below in a log-odds."""

    temperature: float = 20.0  # of the evidence
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
    irregular: float = 0.3  # share of what repeats do not share, in bursts and lines: makes something foreign as likely as not


def stored() -> tuple[Constants, str]:
    """The constants that a campaign has found, or the reasoned ones where none has been kept; and which they are."""
    if not STORED.is_file():
        return Constants(), "reasoned"
    try:
        held: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
        whole = held.pop("digest") == _digest(held)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        whole = False
    if not whole:
        raise EvatError(
            f"{STORED}: the constants of the diagnosis are damaged, or were changed by hand. Install evat again, or find them anew with "
            "`evat calibrate --store`."
        )
    known = {field.name for field in fields(Constants)}
    constants = Constants(**{name: float(value) for name, value in held["constants"].items() if name in known})
    return constants, f"found on {sum(held['made']['cases'].values())} simulated cases"


def _digest(held: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(held, sort_keys=True).encode()).hexdigest()


def store(constants: Constants, made: Mapping[str, Any], path: Path = STORED) -> None:
    """Keep constants with how they were found."""
    held = {"constants": asdict(constants), "made": dict(made)}
    put(path, json.dumps({**held, "digest": _digest(held)}, indent=1, sort_keys=True) + "\n", "the calibration")
