"""Which recordings repeat each other, and at what were they made? By the names of their files: run_50N_rep2.csv."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from evat.experiment.begin.words import plain
from evat.files.spelling import unit_meant

# What counts repeats, and what may as well count conditions.
_WORDS = (
    "rep|repeat|repetition|replicate|nr|no|wdh|wiederholung|lauf|durchlauf|durchgang|take|pass|passage|passata|pasada|essai|ensayo|prova|"
    "trial|try"
)
_REPEAT = re.compile(rf"(?:{_WORDS}|r|n|run|mess|messung|versuch|test|meas)?[#.]?(\d{{1,3}})|[a-z]", re.IGNORECASE)
_WORD = re.compile(rf"(?:{_WORDS})[#.]?\d{{1,3}}", re.IGNORECASE)
_APART = re.compile(rf"(?<![^\W_])({_WORDS})[\s_.-]+(?=\d{{1,3}}(?:[\s_]|$))", re.IGNORECASE)  # "rep 1", "trial_2"
_VALUE = re.compile(r"(?P<name>[a-z]*?)_?(?P<number>\d+(?:[.,p]\d+)?)(?P<unit>[a-zµμ%°][a-zµμ/%°-]*)?", re.IGNORECASE)
# What stands before a number in a name, where the unit is left out: the variable, and the unit that is usual.
_SHORT = {"vc": ("cutting_speed", "m/min"), "f": ("feed", "mm"), "ap": ("width", "mm"), "b": ("width", "mm"), "fn": ("normal_load", "N")}


@dataclass(frozen=True, slots=True)
class FromName:
    """What a file's name tells: the condition, and numbers with units, as (variable, number, unit)."""

    condition: str
    values: tuple[tuple[str, float, str], ...]


def named(files: Sequence[str]) -> tuple[dict[str, FromName], str]:
    """Of each file, and by what repeats were told, in words ("" where none were)."""
    parts = {file: _parts(file) for file in files}
    place, words = _repeat_place(parts)
    shared = set.intersection(*(set(each) for each in parts.values())) if len(parts) > 1 else set()
    told = {}
    for file, each in parts.items():
        rest = [part for at, part in enumerate(each) if place is None or at != len(each) + place]
        own = [part for part in rest if part not in shared] or rest or [PurePosixPath(file).stem]
        told[file] = FromName("_".join(own), tuple(value for part in rest if (value := _value(part)) is not None))
    return told, words


def _parts(file: str) -> list[str]:
    path = PurePosixPath(file)
    stem = re.sub(r"\s*\((\d+)\)$", r"_\1", path.stem)
    folders = (_APART.sub(r"\1", folder) for folder in (*path.parent.parts, stem))
    return [part for folder in folders for part in re.split(r"[_\s]+|-(?=\D)|(?<=\D)-", folder) if part]


def _repeat_place(parts: dict[str, list[str]]) -> tuple[int | None, str]:
    """The place, from the end, of the part that counts repeats: one such that files which differ there alone are at least two."""
    longest = max(map(len, parts.values()))
    best: tuple[tuple[bool, int, int], int] | None = None
    for place in range(-1, -longest - 1, -1):
        groups = defaultdict(list)
        for each in parts.values():
            if len(each) >= -place and _REPEAT.fullmatch(each[place]):
                groups[tuple(part for at, part in enumerate(each) if at != len(each) + place)].append(each[place])
        counted = [group for group in groups.values() if len(group) > 1]
        if not counted or sum(map(len, groups.values())) != len(parts):
            continue
        word = all(_WORD.fullmatch(each) for group in counted for each in group)
        # One number that counts all files says nothing: that may as well be the number of the condition.
        if not word and len(groups) == 1:
            continue
        score = (word, len(counted), place)
        if best is None or score > best[0]:
            best = (score, place)
    if best is None:
        return None, ""
    example = next(iter(parts.values()))[best[1]]
    return best[1], f"parts of the files' names like {example!r} count repeats"


def _value(part: str) -> tuple[str, float, str] | None:
    """A number with a unit in a part of a name."""
    match = _VALUE.fullmatch(part)
    if match is None:
        return None
    number, name = float(re.sub("[,p]", ".", match["number"])), plain(match["name"])
    unit = unit_meant(match["unit"]) if match["unit"] else ""
    if unit in ("N", "kN", "mN"):
        return ("normal_load", number, unit)
    if not match["unit"] and name in _SHORT:
        variable, unit = _SHORT[name]
        return (variable, number, unit)
    return None


def by_what_they_share(names: Mapping[str, str], groups: Mapping[str, str]) -> dict[str, str]:
    """The group of each file, named by the parts that the names of all its files have, where that tells groups apart; else as it was."""
    shared = {group: _shared([names[file] for file in groups if groups[file] == group]) for group in groups.values()}
    if not all(shared.values()) or len(set(shared.values())) < len(shared):
        return dict(groups)
    return {file: shared[group] for file, group in groups.items()}


def _shared(names: Sequence[str]) -> str:
    """The parts that all of the names have, as they stand in the first."""
    first, *others = (name.split("_") for name in names)
    return "_".join(part for part in first if all(part in other for other in others))
