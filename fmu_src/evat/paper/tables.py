"""What does the paper print? Its tables 1 to 3, typed once in parameters/paper/, and how far its own models lie from its measurements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from evat.files.read_toml import read_toml

FOLDER = Path(__file__).resolve().parents[1] / "parameters" / "paper"


@dataclass(frozen=True, slots=True)
class Coefficient:
    """One cell of table 1: the variable it sets, the number as printed, its unit, in which "speed" is the unit of speed left open."""

    row: str
    variable: str
    printed: float
    unit: str


@dataclass(frozen=True, slots=True)
class MeasuredForce:
    """One row of table 2 [N]; `calculated` by the paper's model and shear-angle principle."""

    material: str
    force: str
    mean: float
    sd_of_peaks: float
    calculated: Mapping[str, Mapping[str, float]]


@lru_cache(maxsize=2)
def _read(name: str) -> dict[str, Any]:
    return read_toml(FOLDER / name)


def materials() -> dict[str, str]:
    """The four materials in the order of table 1: name of the parameter set -> name in the paper."""
    return dict(_read("table-1.toml")["materials"])


def table_1(material: str) -> tuple[Coefficient, ...]:
    """The column of `material` in table 1."""
    column = list(materials()).index(material)
    rows = _read("table-1.toml")["rows"]
    return tuple(Coefficient(name, row["variable"], row["printed"][column], row["unit"]) for name, row in rows.items())


def table_1_source() -> str:
    return str(_read("table-1.toml")["source"])


def table_2() -> tuple[MeasuredForce, ...]:
    """Measured mean forces of the EVAT tests beside the paper's calculated ones."""
    table = _read("table-2.toml")
    return tuple(
        MeasuredForce(
            material=row["material"],
            force=row["force"],
            mean=float(row["mean"]),
            sd_of_peaks=float(row["sd_of_peaks"]),
            calculated={
                model: dict(zip(table["principles"], map(float, numbers), strict=True))
                for model, numbers in zip(table["models"], row["calculated"], strict=True)
            },
        )
        for row in table["rows"]
    )


def table_3() -> dict[str, float]:
    """The accuracy factor [%] that the paper prints for each model; only Coulomb's follows from table 2."""
    table = _read("table-2.toml")
    return dict(zip(table["models"], map(float, table["accuracy_factor_percent"]["printed"]), strict=True))


def mean_relative_error(model: str, *, force: str | None = None, principle: str | None = None) -> float:
    """Mean |calculated - measured| / measured over table 2, over one force or one principle only where that is given."""
    errors = [
        abs(number - row.mean) / row.mean
        for row in table_2()
        if force in (None, row.force)
        for name, number in row.calculated[model].items()
        if principle in (None, name)
    ]
    return sum(errors) / len(errors)
