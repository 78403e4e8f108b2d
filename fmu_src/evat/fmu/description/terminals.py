"""Which variables belong together at a connection? terminalsAndIcons.xml and its pictures, of FMI 3 alone."""

from __future__ import annotations

from collections.abc import Sequence

from evat.fmu.documentation import picture
from evat.fmu.documentation.picture import Picture
from evat.fmu.fmu_facts import FmuFacts
from evat.fmu.xml import Scalar, add, serialised, top
from evat.model import BuildError, Variable

_FOLDER = "terminalsAndIcons"
_EXTENT = {"x1": -100.0, "y1": -100.0, "x2": 100.0, "y2": 100.0}


def terminals_xml(fmu_facts: FmuFacts, variables: Sequence[Variable]) -> bytes:
    """terminalsAndIcons.xml."""
    causalities = {variable.name: variable.causality for variable in variables}
    document = top("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    graphics = add(document, "GraphicalRepresentation")
    add(graphics, "CoordinateSystem", {**_EXTENT, "suggestedScalingFactorTo_mm": 0.1})
    add(graphics, "Icon", _EXTENT)
    parent = add(document, "Terminals") if fmu_facts.terminals else document  # the schema allows no empty list
    for terminal in fmu_facts.terminals:
        head = {
            "name": terminal["name"],
            "matchingRule": terminal["rule"],
            "terminalKind": terminal["kind"],
            "description": terminal["description"],
        }
        element = add(parent, "Terminal", head)
        for member in terminal["members"]:
            if causalities.get(member["variable"]) not in ("input", "output"):
                raise BuildError(
                    f"terminal {terminal['name']}: {member['variable']!r} is neither an input nor an output; correct the table."
                )
            names = {"variableName": member["variable"], "memberName": member["member"], "variableKind": member["kind"]}
            add(element, "TerminalMemberVariable", names)
        place = dict(zip(("x1", "y1", "x2", "y2"), terminal["place"], strict=True))
        look: dict[str, Scalar | None] = {
            "defaultConnectionColor": " ".join(map(str, terminal["color"])),
            "defaultConnectionStrokeSize": 1.0,
        }
        add(element, "TerminalGraphicalRepresentation", {**look, **place, "iconBaseName": terminal["name"]})
    return serialised(document)


def terminal_files(fmu_facts: FmuFacts, variables: Sequence[Variable], icon: Picture) -> dict[str, bytes]:
    """The folder terminalsAndIcons of the archive."""
    files = {f"{_FOLDER}/terminalsAndIcons.xml": terminals_xml(fmu_facts, variables)}
    drawings = {"icon": icon, **{t["name"]: picture.terminal_icon(t["color"]) for t in fmu_facts.terminals}}
    for name, drawing in drawings.items():
        files[f"{_FOLDER}/{name}.png"] = drawing.png
        files[f"{_FOLDER}/{name}.svg"] = drawing.svg
    return files
