"""How is what a document says checked against the model, and how are errors in it worded: file, key, what was found, what is allowed?"""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

from evat.experiment import ExperimentError
from evat.model import Model, ParameterError, Variable

SETTABLE = ("parameter", "input")
MOST = 1e12  # in SI: no measured quantity of a contact is beyond, and squares of what is below can be added up
_short = reprlib.Repr()
_short.maxstring = _short.maxother = 80
_short.maxlong = 30
_short.maxlist = _short.maxdict = 20


class Checks:
    """The document at `path`, the folder `root` that its files lie in, and the names that the model knows."""

    def __init__(self, path: Path, model: Model) -> None:
        self.path, self.root, self.model = path, path.parent.resolve(), model
        self.variables = {variable.name: variable for variable in model.variables}
        self.effects = [effect.name for effect in model.effects]
        self.integrals = {variable.derivative_of for variable in model.variables if variable.derivative_of}

    def error(self, where: str, text: str) -> ExperimentError:
        return ExperimentError(f"{self.path.name}{', ' if where else ''}{where}: {text}")

    def inside(self, where: str, name: str) -> Path:
        """The file of that name beside the document; an error where it is none, or lies elsewhere by its name or by a link."""
        parts = Path(name).parts
        if not name or Path(name).is_absolute() or ".." in parts or "\\" in name or PureWindowsPath(name).drive or "\0" in name:
            raise self.error(
                where, f"{shown(name)}; a file inside the experiment's folder is needed, written like trials/a.csv, without '..'."
            )
        path = self.root / name
        try:
            real = path.resolve()
            if not real.is_relative_to(self.root):
                raise self.error(where, f"{shown(name)} leads out of the experiment's folder; copy the file into it.")
            if not real.is_file():
                raise self.error(where, f"there is no file {shown(name)} in {self.path.parent}.")
        except (OSError, RuntimeError) as error:  # a name too long, links in a circle
            raise self.error(where, f"{shown(name)} cannot be opened: {getattr(error, 'strerror', None) or error}.") from error
        return real

    def variable(self, where: str, name: str) -> Variable:
        if name not in self.variables:
            raise self.error(where, f"the component has no variable {shown(name)}; {near(name, self.variables)}")
        return self.variables[name]

    def settable(self, where: str, name: str) -> Variable:
        known = self.variable(where, name)
        if name in self.effects:
            raise self.error(where, "this is the switch of an effect; name it in nominal.effects.")
        if known.causality not in SETTABLE:
            raise self.error(where, f"{name} is an {known.causality} of the component; only parameters and inputs can be set.")
        return known

    def value(self, where: str, name: str, entry: Any, *, by_place: bool = False) -> float | str:
        """A value as the component takes it, SI; a choice by its name."""
        known = self.settable(where, name)
        if known.type == "choice":
            if not (isinstance(entry, str) or by_place):
                raise self.error(where, f"{shown(entry)}; allowed is one of {', '.join(known.choices)}.")
        elif not is_number(entry):
            raise self.error(where, f"{shown(entry)}; a bare number in {known.unit} is needed.")
        try:
            number = known.check(entry)
        except ParameterError as error:
            raise self.error(where, f"{error} Values are in SI: is the unit right?" if known.type == "real" else str(error)) from error
        return known.choices[int(number)] if known.type == "choice" else number

    def begun_at(self, where: str, entry: Any) -> float:
        """What is integrated from the start, such as the distance slid, as it was at the start."""
        if not is_size(entry):
            raise self.error(where, f"{shown(entry)}; a finite number in SI is needed, of at most {MOST:g}.")
        return float(entry)

    def numbers(self, where: str, entry: Any) -> Iterable[tuple[str, Any]]:
        return _flat(self.table(where, entry))

    def table(self, where: str, entry: Any) -> Mapping[str, Any]:
        if not isinstance(entry, dict):
            raise self.error(where, f"{shown(entry)}; a table is needed.")
        return entry

    def text(self, where: str, entry: Any) -> str:
        if not isinstance(entry, str):
            raise self.error(where, f"{shown(entry)}; a text in quotes is needed.")
        return entry

    def keys(self, where: str, table: Mapping[str, Any], allowed: Collection[str], needed: Collection[str]) -> None:
        for key in table:
            if key not in allowed:
                raise self.error(where, f"key {shown(key)} is not known; {near(key, allowed)}")
        for key in needed:
            if key not in table:
                raise self.error(where, f"key {shown(key)} is missing.")


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    """Entries by their whole names: to TOML, `a.b = 1` without quotes is a table in a table."""
    for key, entry in table.items():
        if isinstance(entry, dict) and entry:
            yield from _flat(entry, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", entry


def is_number(entry: Any) -> bool:
    """A number of TOML that a float can hold; its whole numbers have no bounds."""
    return isinstance(entry, float) or (isinstance(entry, int) and not isinstance(entry, bool) and abs(entry) < 1 << 1023)


def is_size(entry: Any, least: float = -MOST) -> bool:
    """A number from `least` on that a quantity in SI, or a factor to it, may be."""
    return is_number(entry) and least <= entry <= MOST


def shown(entry: Any) -> str:
    """What stands in a document, as an error repeats it: its two ends where it is long."""
    return _short.repr(entry)


def near(name: str, allowed: Collection[str]) -> str:
    similar = [each for each in allowed if each.lower() == name.lower()] or difflib.get_close_matches(name, allowed, n=3)
    return f"did you mean {', '.join(similar)}?" if similar else f"allowed are {', '.join(sorted(allowed)[:40])}."
