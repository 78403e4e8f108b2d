"""What is understood of a folder of recordings, and what only its owner can tell?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from evat.experiment.begin.files import Recordings
from evat.files.text import TextForm


@dataclass(slots=True)
class Answers:
    """What was told and so is not guessed: columns by signal, units by column, lever arm [m], motor constant (number, unit), and the form
    of the files as far as its fields are `stated`."""

    signals: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    radius: float | None = None
    motor_constant: tuple[float, str] | None = None
    form: TextForm = field(default_factory=TextForm)
    stated: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Question:
    """What cannot be told: the option that answers it, how it is asked, and what may be answered (anything where it is empty)."""

    option: str
    asked: str
    choices: tuple[str, ...] = ()
    key: str = ""


@dataclass(frozen=True, slots=True)
class SignalGuess:
    """A signal's table, and by what it was guessed, "" where it was told."""

    name: str
    table: Mapping[str, Any]
    why: str


@dataclass(frozen=True, slots=True)
class TrialGuess:
    file: str
    condition: str
    values: Mapping[str, float]
    rows: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Begun:
    """What was understood of a folder; `values` (value, relative sd, why) are of the nominal model, `left` is what was not used and why."""

    recorded: Recordings
    signals: tuple[SignalGuess, ...]
    trials: tuple[TrialGuess, ...]
    means: str
    ignored: tuple[str, ...]
    kinematics: str
    values: Mapping[str, tuple[float, float, str]]
    repeats: str
    left: tuple[str, ...]
    look: tuple[str, ...]
