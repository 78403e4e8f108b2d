"""How does FMI 2.0 write the description of a model? Variables and unknowns go by their place in the list, counted from 1."""

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
    root,
)
from evat.fmu.structure.model_structure import Unknown
from evat.fmu.xml import Element, Scalar, add, serialised
from evat.model import Variable

_ELEMENTS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "choice": "Enumeration"}


def _place(variable: Variable) -> int:
    return variable.index + 1


def _add_interfaces(parent: Element, facts: Facts) -> None:
    for name, flags in facts.fmu.fmi2.items():
        child = add(parent, name, {"modelIdentifier": facts.fmu.model_name, **flags})
        files = add(child, "SourceFiles")
        for source in facts.sources:
            add(files, "File", {"name": source})


def _add_types(parent: Element, facts: Facts) -> None:
    element = add(parent, "TypeDefinitions")
    for kind in facts.types.reals:
        add(add(element, "SimpleType", {"name": kind.name}), "Real", real_type(kind))
    for choices in facts.types.enumerations:
        child = add(element, "SimpleType", {"name": choices.name, "description": choices.description})
        add_items(add(child, "Enumeration"), choices)


def _add_variable(parent: Element, variable: Variable, facts: Facts, places: dict[str, int]) -> None:
    element = add(parent, "ScalarVariable", head_of(variable, facts))
    add(element, _ELEMENTS[variable.type], attributes_of(variable, facts, places))


def _add_unknowns(parent: Element, tag: str, unknowns: Sequence[Unknown]) -> None:
    if not unknowns:
        return
    element = add(parent, tag)
    for unknown in unknowns:
        pairs: dict[str, Scalar | None] = {
            "index": _place(unknown.variable),
            "dependencies": " ".join(str(_place(known)) for known in unknown.knowns),
            "dependenciesKind": " ".join(unknown.kinds),
        }
        add(element, "Unknown", pairs)


def model_description(facts: Facts) -> bytes:
    """modelDescription.xml of FMI 2.0."""
    document = root("2.0", "guid", facts)
    document.set("numberOfEventIndicators", str(len(facts.structure.indicators)))
    _add_interfaces(document, facts)
    add_units(document, facts)
    _add_types(document, facts)
    add_experiment(document, facts)
    variables = add(document, "ModelVariables")
    places = {variable.name: _place(variable) for variable in facts.variables}
    for variable in facts.variables:
        _add_variable(variables, variable, facts, places)
    structure = add(document, "ModelStructure")
    _add_unknowns(structure, "Outputs", facts.structure.outputs)
    _add_unknowns(structure, "Derivatives", facts.structure.derivatives)
    _add_unknowns(structure, "InitialUnknowns", facts.structure.initial_unknowns)
    return serialised(document)
