"""What is the work made of? Thermal constants of the paper's materials, typed once in parameters/work/thermal.toml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from evat.files.read_toml import read_toml
from evat.model import ParameterError
from evat.paper.tables import materials

FILE = Path(__file__).resolve().parents[1] / "parameters" / "work" / "thermal.toml"


@dataclass(frozen=True, slots=True)
class MaterialConstant:
    """One constant of one material, in the unit of the variable that it sets."""

    variable: str
    value: float
    unit: str
    source: str


@lru_cache(maxsize=1)
def _rows() -> dict[str, Any]:
    return dict(read_toml(FILE)["rows"])


def constants(material: str) -> Mapping[str, MaterialConstant]:
    """The constants of a material by the variable that they set: of the part that the work's heat flows in, or of the contact."""
    if material not in materials():
        raise ParameterError(f"there is no material {material!r}; allowed are {', '.join(materials())}.")
    column = list(materials()).index(material)
    return {
        row["variable"]: MaterialConstant(row["variable"], float(row["values"][column]), row["unit"], row["source"])
        for row in _rows().values()
    }


def material_of(set_name: str) -> str | None:
    """The material that a parameter set is of; None where it is of none."""
    material = set_name.rpartition("/")[2]
    return material if "/" in set_name and material in materials() else None
