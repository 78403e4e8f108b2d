"""Which constants does the judgement weigh by, and where are they kept? Reasoned ones, until simulated cases have told of better ones."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from evat.constants import CONSTANTS, Value
from evat.files.writing import put
from evat.model import EvatError

STORED = Path(__file__).with_name("calibration.json")


def _weight(name: str) -> Any:
    """A field that begins at what the table of constants has."""
    return field(default_factory=lambda: getattr(CONSTANTS, name))


@dataclass(frozen=True)
class Constants:
    """Of the judgement; each is a weight of one of its features in a log-odds. The table of constants says what each means."""

    temperature: float = _weight("temperature")
    sharpness: float = _weight("sharpness")
    form: float = _weight("form")
    effect_cost: float = _weight("effect_cost")
    gap_offset: float = _weight("gap_offset")
    gap_slope: float = _weight("gap_slope")
    structure_offset: float = _weight("structure_offset")
    structure_slope: float = _weight("structure_slope")
    unknown_offset: float = _weight("unknown_offset")
    unknown_slope: float = _weight("unknown_slope")
    evident: float = _weight("evident")
    small_noise: float = _weight("small_noise")
    small_form: float = _weight("small_form")
    irregular: float = _weight("irregular")


def stored() -> tuple[Constants, str]:
    """The constants that a campaign has fitted, or the reasoned ones where none has been kept; and which they are. One that is replaced in
    the table of constants is replaced here, too."""
    if not STORED.is_file():
        return Constants(), "reasoned"
    try:
        held: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
        whole = held.pop("digest") == _digest(held)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        whole = False
    if not whole:
        raise EvatError(
            f"{STORED}: the constants of the diagnosis are damaged, or were changed by hand. Install evat again, or fit them anew with "
            "`evat calibrate --store`."
        )
    known = {each.name for each in fields(Constants)}
    constants = Constants(**{name: CONSTANTS.now(name, float(value)) for name, value in held["constants"].items() if name in known})
    return constants, f"fitted to {sum(held['made']['cases'].values())} simulated cases"


def _digest(held: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(held, sort_keys=True).encode()).hexdigest()


def store(constants: Constants, made: Mapping[str, Any], path: Path = STORED) -> None:
    """Keep constants with how they were fitted."""
    held = {"constants": asdict(constants), "made": dict(made)}
    put(path, json.dumps({**held, "digest": _digest(held)}, indent=1, sort_keys=True) + "\n", "the calibration")


def in_use() -> dict[str, Value]:
    """Every constant by name with the value that a diagnosis takes: of those that were calibrated, what is kept."""
    return {**{name: getattr(CONSTANTS, name) for name in CONSTANTS.declared()}, **asdict(stored()[0])}
