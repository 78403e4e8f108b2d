"""What does modelDescription.xml say? The kernel's tables in the words of FMI: what FMI 2 and FMI 3 have in common."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from evat import __version__
from evat.fmu.archive import stamp
from evat.fmu.description.simple_types import Enumeration, RealType, SimpleTypes, simple_types
from evat.fmu.description.unit_definitions import definitions
from evat.fmu.fmu_facts import TOLERANCE, FmuFacts
from evat.fmu.structure.model_structure import Structure
from evat.fmu.xml import Element, Scalar, add, top
from evat.model import FIRST_ITEM, Law, Variable

FIRST_REFERENCE = 1
CAUSALITIES = {
    "independent": "independent",
    "parameter": "parameter",
    "calculated": "calculatedParameter",
    "input": "input",
    "output": "output",
    "local": "local",
}


@dataclass(frozen=True)
class Facts:
    """Everything that the description is made of."""

    fmu: FmuFacts
    token: str
    variables: tuple[Variable, ...]
    states: tuple[str, ...]
    laws: tuple[Law, ...]
    structure: Structure
    sources: tuple[str, ...]
    copyright: str | None

    @cached_property
    def types(self) -> SimpleTypes:
        """The type definitions."""
        return simple_types(self.variables, self.laws, self.fmu.quantities)


def reference(variable: Variable) -> int:
    """The value reference of a variable, from 1 on: see FIRST_REFERENCE in fmi/component.h."""
    return variable.index + FIRST_REFERENCE


def value_of(variable: Variable, number: float) -> Scalar:
    """A number of the table in the type that FMI gives the variable."""
    if variable.type == "real":
        return float(number)
    if variable.type == "boolean":
        return bool(number)
    return int(number) + (FIRST_ITEM if variable.type == "choice" else 0)


def initial(variable: Variable, states: Sequence[str]) -> str | None:
    """exact: has a start; calculated: has none; inputs and time say nothing."""
    if variable.causality in ("independent", "input"):
        return None
    return "exact" if variable.causality == "parameter" or variable.name in states else "calculated"


def start(variable: Variable, states: Sequence[str]) -> Scalar | None:
    """The start value where FMI wants one."""
    has_one = variable.causality == "input" or initial(variable, states) == "exact"
    return value_of(variable, variable.start) if has_one else None


def bounds(variable: Variable) -> dict[str, Scalar | None]:
    """min and max, infinite ones left out; choices and switches are bounded by their type."""
    if variable.type in ("boolean", "choice"):
        return {}
    limits = {"min": variable.min, "max": variable.max}
    return {name: value_of(variable, limit) if math.isfinite(limit) else None for name, limit in limits.items()}


def real_attributes(variable: Variable, facts: Facts, derivative: int | None) -> dict[str, Scalar | None]:
    """What a real variable says beyond its type, also where the type says it: some tools read only the variable."""
    is_state = variable.name in facts.states
    return {
        "declaredType": facts.types.of.get(variable.name),
        "quantity": facts.fmu.quantities.get(variable.unit),
        "unit": variable.unit,
        "displayUnit": variable.display_unit,
        "relativeQuantity": True if variable.difference else None,
        **bounds(variable),
        "nominal": variable.nominal if is_state or variable.nominal != 1 else None,
        "start": start(variable, facts.states),
        "derivative": derivative,
        "reinit": True if variable.name in facts.structure.reinit else None,
    }


def head_of(variable: Variable, facts: Facts) -> dict[str, Scalar | None]:
    """What every variable says first, whatever its type."""
    return {
        "name": variable.name,
        "valueReference": reference(variable),
        "description": described(variable),
        "causality": CAUSALITIES[variable.causality],
        "variability": variable.variability,
        "initial": initial(variable, facts.states),
    }


def attributes_of(variable: Variable, facts: Facts, places: Mapping[str, int]) -> dict[str, Scalar | None]:
    """What a variable says by its type. places : by name, how others are told by this version, such as the state of a derivative."""
    if variable.type == "real":
        return real_attributes(variable, facts, places[variable.derivative_of] if variable.derivative_of else None)
    return {**bounds(variable), "start": start(variable, facts.states), "declaredType": facts.types.of.get(variable.name)}


def described(variable: Variable) -> str:
    """Meaning and source."""
    return f"{variable.meaning} [{variable.source}]"


def root(version: str, token_name: str, facts: Facts) -> Element:
    """The root element with what both versions say of the model."""
    head: dict[str, Scalar | None] = {
        "fmiVersion": version,
        "modelName": facts.fmu.model_name,
        token_name: facts.token,
        "description": facts.fmu.description,
        "version": __version__,
        "copyright": facts.copyright,
        "license": facts.fmu.license,
        "generationTool": f"evat {__version__}",
        "generationDateAndTime": stamp(),
        "variableNamingConvention": "structured",
    }
    return top("fmiModelDescription", head)


def add_units(parent: Element, facts: Facts) -> None:
    """Units with their SI exponents and display units."""
    element = add(parent, "UnitDefinitions")
    for unit in definitions(facts.variables):
        child = add(element, "Unit", {"name": unit.name})
        add(child, "BaseUnit", {**unit.exponents, **_conversion(unit.factor, unit.offset)})
        for display in unit.displays:
            add(child, "DisplayUnit", {"name": display.name, **_conversion(display.factor, display.offset)})


def _conversion(factor: float, offset: float) -> dict[str, Scalar | None]:
    return {"factor": factor if factor != 1 else None, "offset": offset if offset != 0 else None}


def real_type(kind: RealType) -> dict[str, Scalar | None]:
    """The attributes of a type of real variables."""
    attributes: dict[str, Scalar | None] = {"quantity": kind.quantity, "unit": kind.unit, "displayUnit": kind.display_unit}
    return {**attributes, "relativeQuantity": True if kind.difference else None}


def add_items(parent: Element, kind: Enumeration) -> None:
    """The items of an enumeration."""
    for item in kind.items:
        add(parent, "Item", {"name": item.name, "value": item.value, "description": item.description})


def add_experiment(parent: Element, facts: Facts) -> None:
    """Log categories and the default experiment."""
    categories = add(parent, "LogCategories")
    for name, meaning in facts.fmu.log_categories.items():
        add(categories, "Category", {"name": name, "description": meaning})
    tolerance = next((variable.start for variable in facts.variables if variable.name == TOLERANCE), None)
    add(parent, "DefaultExperiment", {**facts.fmu.default_experiment, "tolerance": tolerance})
