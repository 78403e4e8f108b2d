"""How does FMI 3.0 write the description of a model? Variables and unknowns go by their value reference."""

from __future__ import annotations

from collections.abc import Sequence

from evat.fmu.description.model_description import (
    Facts,
    add_experiment,
    add_items,
    add_units,
    attributes_of,
    head_of,
    real_type,
    reference,
    root,
)
from evat.fmu.structure.model_structure import Unknown
from evat.fmu.xml import Element, Scalar, add, serialised
from evat.model import Variable

_ELEMENTS = {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "choice": "Enumeration"}


def _add_types(parent: Element, facts: Facts) -> None:
    element = add(parent, "TypeDefinitions")
    for kind in facts.types.reals:
        add(element, "Float64Type", {"name": kind.name, **real_type(kind)})
    for choices in facts.types.enumerations:
        child = add(element, "EnumerationType", {"name": choices.name, "description": choices.description})
        add_items(child, choices)


def _add_variable(parent: Element, variable: Variable, facts: Facts, references: dict[str, int]) -> None:
    head = head_of(variable, facts)
    if variable.causality in ("input", "output") and variable.variability == "continuous":
        head["intermediateUpdate"] = True
    add(parent, _ELEMENTS[variable.type], {**head, **attributes_of(variable, facts, references)})


def _add_unknowns(parent: Element, tag: str, unknowns: Sequence[Unknown]) -> None:
    for unknown in unknowns:
        pairs: dict[str, Scalar | None] = {
            "valueReference": reference(unknown.variable),
            "dependencies": " ".join(str(reference(known)) for known in unknown.knowns),
            "dependenciesKind": " ".join(unknown.kinds),
        }
        add(parent, tag, pairs)


def model_description(facts: Facts) -> bytes:
    """modelDescription.xml of FMI 3.0."""
    document = root("3.0", "instantiationToken", facts)
    for name, flags in facts.fmu.fmi3.items():
        add(document, name, {"modelIdentifier": facts.fmu.model_name, **flags})
    add_units(document, facts)
    _add_types(document, facts)
    add_experiment(document, facts)
    variables = add(document, "ModelVariables")
    references = {variable.name: reference(variable) for variable in facts.variables}
    for variable in facts.variables:
        _add_variable(variables, variable, facts, references)
    structure = add(document, "ModelStructure")
    _add_unknowns(structure, "Output", facts.structure.outputs)
    _add_unknowns(structure, "ContinuousStateDerivative", facts.structure.derivatives)
    _add_unknowns(structure, "InitialUnknown", facts.structure.initial_unknowns)
    _add_unknowns(structure, "EventIndicator", facts.structure.indicators)
    return serialised(document)
