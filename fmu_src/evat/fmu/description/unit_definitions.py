"""Which units does the description define? Every unit of the tables in SI exponents, with the display units used beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from evat.model import Variable
from evat.units import affine, base_unit


@dataclass(frozen=True, slots=True)
class DisplayUnit:
    """display value = factor * value + offset."""

    name: str
    factor: float
    offset: float


@dataclass(frozen=True, slots=True)
class Unit:
    """SI value = factor * value + offset; exponents by FMI's names of the base units."""

    name: str
    exponents: dict[str, int]
    factor: float
    offset: float
    displays: tuple[DisplayUnit, ...]


def definition(name: str, displays: Sequence[str]) -> Unit:
    """A unit of the tables with its display units."""
    base = base_unit(name)
    display_units = tuple(DisplayUnit(display, *affine(name, display)) for display in displays)
    return Unit(name, base.exponents, float(base.factor), float(base.offset), display_units)


def definitions(variables: Sequence[Variable]) -> tuple[Unit, ...]:
    """Every unit of the real variables, in the order of first use."""
    displays: dict[str, list[str]] = {}
    for variable in variables:
        if variable.type == "real":
            names = displays.setdefault(variable.unit, [])
            if variable.display_unit and variable.display_unit not in names:
                names.append(variable.display_unit)
    return tuple(definition(name, names) for name, names in displays.items())
