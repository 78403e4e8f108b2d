"""How is what a document says checked against the model, and how are errors in it worded: file, key, what was found, what is allowed?"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

from evat.experiment import ExperimentError
from evat.model import Model, ParameterError, Variable

SETTABLE = ("parameter", "input")


class Checks:
    """The document at `path`, the folder `root` that its files lie in, and the names that the model knows."""

    def __init__(self, path: Path, model: Model) -> None:
        self.path, self.root, self.model = path, path.parent.resolve(), model
        self.variables = {variable.name: variable for variable in model.variables}
        self.effects = [effect.name for effect in model.effects]

    def error(self, where: str, text: str) -> ExperimentError:
        return ExperimentError(f"{self.path.name}{', ' if where else ''}{where}: {text}")

    def inside(self, where: str, name: str) -> Path:
        """The file of that name beside the document; an error where it is none, or lies elsewhere by its name or by a link."""
        parts = Path(name).parts
        if not name or Path(name).is_absolute() or ".." in parts or "\\" in name or PureWindowsPath(name).drive or "\0" in name:
            raise self.error(where, f"{name!r}; a file inside the experiment's folder is needed, written like trials/a.csv, without '..'.")
        path = self.root / name
        try:
            real = path.resolve()
            if not real.is_relative_to(self.root):
                raise self.error(where, f"{name!r} leads out of the experiment's folder; copy the file into it.")
            if not real.is_file():
                raise self.error(where, f"there is no file {name!r} in {self.path.parent}.")
        except (OSError, RuntimeError) as error:  # a name too long, links in a circle
            raise self.error(where, f"{name[:80]!r} cannot be opened: {error}.") from error
        return real

    def variable(self, where: str, name: str) -> Variable:
        if name not in self.variables:
            raise self.error(where, f"the component has no variable {name!r}; {near(name, self.variables)}")
        return self.variables[name]

    def settable(self, where: str, name: str) -> Variable:
        known = self.variable(where, name)
        if name in self.effects:
            raise self.error(where, "this is the switch of an effect; name it in nominal.effects.")
        if known.causality not in SETTABLE:
            raise self.error(where, f"{name} is an {known.causality} of the component; only parameters and inputs can be set.")
        return known

    def value(self, where: str, name: str, found: Any, *, by_place: bool = False) -> float | str:
        """A value as the component takes it, SI; a choice by its name."""
        known = self.settable(where, name)
        if known.type == "choice":
            if not (isinstance(found, str) or by_place):
                raise self.error(where, f"{found!r}; allowed is one of {', '.join(known.choices)}.")
        elif not is_number(found):
            raise self.error(where, f"{found!r}; a bare number in {known.unit} is needed.")
        try:
            number = known.check(found)
        except ParameterError as error:
            raise self.error(where, f"{error} Values are in SI: is the unit right?" if known.type == "real" else str(error)) from error
        return known.choices[int(number)] if known.type == "choice" else number

    def numbers(self, where: str, found: Any) -> Iterable[tuple[str, Any]]:
        return _flat(self.table(where, found))

    def table(self, where: str, found: Any) -> Mapping[str, Any]:
        if not isinstance(found, dict):
            raise self.error(where, f"{found!r}; a table is needed.")
        return found

    def text(self, where: str, found: Any) -> str:
        if not isinstance(found, str):
            raise self.error(where, f"{found!r}; a text in quotes is needed.")
        return found

    def keys(self, where: str, found: Mapping[str, Any], allowed: Collection[str], needed: Collection[str]) -> None:
        for key in found:
            if key not in allowed:
                raise self.error(where, f"key {key!r} is not known; {near(key, allowed)}")
        for key in needed:
            if key not in found:
                raise self.error(where, f"key {key!r} is missing.")


def _flat(found: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    """Entries by their whole names: to TOML, `a.b = 1` without quotes is a table in a table."""
    for key, entry in found.items():
        if isinstance(entry, dict) and entry:
            yield from _flat(entry, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", entry


def is_number(found: Any) -> bool:
    """A number of TOML that a float can hold; its whole numbers have no bounds."""
    return isinstance(found, float) or (isinstance(found, int) and not isinstance(found, bool) and abs(found) < 1 << 1023)


def near(name: str, allowed: Collection[str]) -> str:
    found = [each for each in allowed if each.lower() == name.lower()] or difflib.get_close_matches(name, allowed, n=3)
    return f"did you mean {', '.join(found)}?" if found else f"allowed are {', '.join(sorted(allowed)[:40])}."
