"""Under which process conditions were the paper's tests made? It prints none: bounds with sources, and what its table 2 lets infer.

Both stand in parameters/paper/conditions.toml; `evat.studies.paper.study` is how the inferred ones were made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from evat.files.read_toml import read_toml
from evat.native import kernel
from evat.paper.tables import FOLDER, materials
from evat.units import to_si

SHEAR_STRESS = "shear_stress"


@dataclass(frozen=True, slots=True)
class ProcessCondition:
    """One variable of the component: bounds of what it may have been in the tests, what is inferred, SI, and where the bounds come from."""

    variable: str
    low: float
    high: float
    inferred: float
    source: str


@dataclass(frozen=True, slots=True)
class Inference:
    """How the inferred conditions were made: parameter sets, the unit of their speeds, the paper's model and principle that were fitted."""

    how: str
    family: str
    speed_unit: str
    model: str
    principle: str


@lru_cache(maxsize=1)
def _read() -> dict[str, Any]:
    return read_toml(FOLDER / "conditions.toml")


def _condition(variable: str, entry: Mapping[str, Any], unit: str, source: str) -> ProcessCondition:
    known = kernel.variable(variable)
    low, high, inferred = (known.check(to_si(f"{entry[key]!r} {unit}", known.unit, name=variable)) for key in ("low", "high", "inferred"))
    return ProcessCondition(variable, low, high, inferred, source)


@lru_cache(maxsize=1)
def conditions() -> tuple[ProcessCondition, ...]:
    """What all four materials have in common."""
    return tuple(_condition(name, entry, entry["unit"], entry["source"]) for name, entry in _read()["conditions"].items())


@lru_cache(maxsize=1)
def shear_stresses() -> Mapping[str, ProcessCondition]:
    """The shear flow stress of each material, in the order of table 1."""
    table = _read()[SHEAR_STRESS]
    return {name: _condition(SHEAR_STRESS, table["materials"][name], table["unit"], table["source"]) for name in materials()}


def inference() -> Inference:
    """How the inferred conditions were made."""
    return Inference(**_read()["inferred"])


def inferred(material: str) -> dict[str, float | str]:
    """The inferred conditions of one material's test, as values of the component."""
    values: dict[str, float | str] = {one.variable: one.inferred for one in (*conditions(), shear_stresses()[material])}
    return values | {"shear_angle_principle": inference().principle}
