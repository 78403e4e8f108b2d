"""Which variables share a type? One per quantity, unit and display unit, and one enumeration per choice."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from evat.model import Law, Variable


@dataclass(frozen=True, slots=True)
class RealType:
    """A measurable quantity."""

    name: str
    quantity: str
    unit: str
    display_unit: str | None
    difference: bool


@dataclass(frozen=True, slots=True)
class Item:
    """One choice of an enumeration."""

    name: str
    value: int
    description: str


@dataclass(frozen=True, slots=True)
class Enumeration:
    """The choices of one variable."""

    name: str
    description: str
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True)
class SimpleTypes:
    """All types of a model and the type of each variable by the variable's name."""

    reals: tuple[RealType, ...]
    enumerations: tuple[Enumeration, ...]
    of: Mapping[str, str]


def _identifier(text: str) -> str:
    return re.sub(r"\W+", "_", text.replace("/", "_per_")).strip("_")


def _camel(name: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[_.\W]+", name))


def _item_description(variable: Variable, choice: str, laws: Mapping[str, str]) -> str:
    """What a choice means: the law of that name, else the words behind it in the variable's meaning."""
    if set(variable.choices) <= laws.keys():
        return laws[choice]
    others = "|".join(re.escape(name) for name in variable.choices)
    described = re.search(rf"(?:^|[\s;,:]){re.escape(choice)}: (.*?)(?=[;,] (?:{others}): |$)", variable.meaning)
    return described[1] if described else f"{variable.meaning}: {choice.replace('_', ' ')}"


def simple_types(variables: Sequence[Variable], laws: Sequence[Law], quantities: Mapping[str, str]) -> SimpleTypes:
    """The types of a variable table."""
    reals: dict[str, RealType] = {}
    enumerations: list[Enumeration] = []
    of: dict[str, str] = {}
    meanings = {law.name: law.meaning for law in laws}
    for variable in variables:
        if variable.type == "real" and variable.unit in quantities:
            quantity, display = quantities[variable.unit], variable.display_unit
            name = f"{quantity}_{_identifier(display)}" if display else quantity
            name += "Difference" if variable.difference else ""
            reals.setdefault(name, RealType(name, quantity, variable.unit, display, variable.difference))
            of[variable.name] = name
        elif variable.type == "choice":
            items = tuple(Item(choice, number, _item_description(variable, choice, meanings)) for choice, number in variable.items.items())
            enumerations.append(Enumeration(_camel(variable.name), variable.meaning, items))
            of[variable.name] = _camel(variable.name)
    return SimpleTypes(tuple(reals[name] for name in sorted(reals)), tuple(enumerations), of)
