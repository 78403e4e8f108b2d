"""How is a parameter set read from and written to an SSP 1.0 parameter values file (.ssv)? Units are converted to SI on reading.

pyssp-standard is not used for it: it parses with entities on, drops descriptions, and writes in place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Any

from lxml import etree

from evat.files.read_xml import XmlError, check_valid, number, read_xml
from evat.files.writing import put
from evat.model import FIRST_ITEM, ParameterError, Variable
from evat.units import BaseUnit, base_unit, convert

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
ABOUT = "urn:evat:parameter-set"  # our annotation: notes and the speed range, for which SSP has no place
SETTABLE = ("parameter", "input")
_NAMES = {"ssv": SSV, "ssc": SSC, "about": ABOUT}


@dataclass(frozen=True, slots=True)
class Content:
    """What an .ssv file holds: values in SI by variable name, choices by their place."""

    name: str
    title: str
    values: Mapping[str, float]
    sources: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    speed_range: tuple[float, float] | None = None


def read(path: Path, variables: Mapping[str, Variable]) -> Content:
    """The content of a file; ParameterError with file and line where it is not one that these variables allow."""
    tree = read_xml(path, path.name)
    check_valid(tree, "SystemStructureParameterValues", path.name)
    root = tree.getroot()
    units = units_in_file(root, path.name)
    values: dict[str, float] = {}
    sources: dict[str, str] = {}
    for parameter in root.iterfind("ssv:Parameters/ssv:Parameter", _NAMES):
        name = parameter.get("name")
        try:
            if name in values:
                raise ParameterError(f"{name} is there twice; keep one.")
            values[name] = _value(name, parameter[0], units, variables)
        except ParameterError as error:
            raise ParameterError(f"{path.name}, line {parameter.sourceline}: {error}") from error
        if parameter.get("description"):
            sources[name] = parameter.get("description")
    about = root.find("ssv:Annotations/ssc:Annotation/about:set", _NAMES)
    notes = () if about is None else tuple(note.text or "" for note in about.iterfind("about:note", _NAMES))
    speed_range = None if about is None else _speed_range(path, about)
    return Content(root.get("name"), root.get("description", root.get("name")), values, sources, notes, speed_range)


def write(path: Path, content: Content, variables: Mapping[str, Variable]) -> Path:
    """Write `content`; the file appears whole or not at all."""
    return put(path, serialised(content, variables))


def serialised(content: Content, variables: Mapping[str, Variable]) -> bytes:
    """`content` as XML, in the order of the variables; the same content gives the same bytes."""
    root = etree.Element(f"{{{SSV}}}ParameterSet", nsmap={"ssv": SSV, "ssc": SSC}, version="1.0", name=content.name)
    if content.title != content.name:
        root.set("description", content.title)
    parameters = etree.SubElement(root, f"{{{SSV}}}Parameters")
    used: list[str] = []
    for name in sorted(content.values, key=lambda name: variables[name].index):
        variable, value = variables[name], content.values[name]
        parameter = etree.SubElement(parameters, f"{{{SSV}}}Parameter", name=name)
        if content.sources.get(name):
            parameter.set("description", content.sources[name])
        if variable.type == "choice":
            etree.SubElement(parameter, f"{{{SSV}}}Enumeration", value=variable.choices[int(value)])
        elif variable.type == "boolean":
            etree.SubElement(parameter, f"{{{SSV}}}Boolean", value="true" if value else "false")
        elif variable.type == "integer":
            etree.SubElement(parameter, f"{{{SSV}}}Integer", value=str(int(value)))
        else:
            real = etree.SubElement(parameter, f"{{{SSV}}}Real", value=repr(float(value)))
            if variable.unit != "1":
                real.set("unit", variable.unit)
                used += [] if variable.unit in used else [variable.unit]
    if used:
        units = etree.SubElement(root, f"{{{SSV}}}Units")
        for unit in used:
            numbers = {key: str(power) for key, power in base_unit(unit).exponents.items()}  # the variables' units are SI: factor 1
            etree.SubElement(etree.SubElement(units, f"{{{SSC}}}Unit", name=unit), f"{{{SSC}}}BaseUnit", numbers)
    if content.notes or content.speed_range is not None:
        annotations = etree.SubElement(root, f"{{{SSV}}}Annotations")
        annotation = etree.SubElement(annotations, f"{{{SSC}}}Annotation", type="evat.parameter-set")
        about = etree.SubElement(annotation, f"{{{ABOUT}}}set", nsmap={"about": ABOUT})
        if content.speed_range is not None:
            about.set("lowest_speed", repr(content.speed_range[0]))
            about.set("highest_speed", repr(content.speed_range[1]))
        for note in content.notes:
            etree.SubElement(about, f"{{{ABOUT}}}note").text = note
    return bytes(etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8"))


def _value(name: str, element: Any, units: Mapping[str, BaseUnit], variables: Mapping[str, Variable]) -> float:
    if name not in variables or variables[name].causality not in SETTABLE:
        allowed = ", ".join(known for known, variable in variables.items() if variable.causality in SETTABLE)
        raise ParameterError(f"{name!r} is no parameter or input; allowed are {allowed}.")
    variable, kind, text = variables[name], etree.QName(element).localname, element.get("value")
    kinds = {"real": ("Real", "Integer"), "integer": ("Integer",), "boolean": ("Boolean",), "choice": ("Enumeration", "String", "Integer")}
    if kind not in kinds[variable.type]:
        raise ParameterError(f"{name} is given as {kind}; allowed is {' or '.join(kinds[variable.type])}.")
    if kind in ("Enumeration", "String"):
        return variable.check(text)
    if kind == "Boolean":
        return variable.check(text.strip() in ("true", "1"))
    if variable.type == "choice":
        return variable.check(float(text) - FIRST_ITEM)  # as the FMU numbers them
    unit = element.get("unit")
    if unit is None or not math.isfinite(float(text)):
        return variable.check(float(text))
    wanted, source = base_unit(variable.unit), units[unit] if unit in units else base_unit(unit)
    if source.exponents != wanted.exponents:
        raise ParameterError(f"{name} = {text} {unit}: {unit} does not measure what {variable.unit} measures.")
    return variable.check(convert(Decimal(text.strip()), source, wanted))


def units_in_file(root: Any, what: str) -> dict[str, BaseUnit]:
    """The units that an .ssv file itself defines, by name."""
    return {unit.get("name"): _unit_in_file(unit[0], what) for unit in root.iterfind("ssv:Units/ssc:Unit", _NAMES)}


def _unit_in_file(base: Any, what: str) -> BaseUnit:
    exponents = {key: int(power) for key, power in base.attrib.items() if key not in ("factor", "offset") and int(power) != 0}
    if number(base, "factor", what, 1.0) == 0:
        raise XmlError(f"{what}, line {base.sourceline}: factor = 0; a unit is some number of SI units.")
    number(base, "offset", what, 0.0)
    return BaseUnit(exponents, Decimal(base.get("factor", "1").strip()), Decimal(base.get("offset", "0").strip()))


def _speed_range(path: Path, about: Any) -> tuple[float, float] | None:
    if about.get("lowest_speed") is None and about.get("highest_speed") is None:
        return None
    low, high = (number(about, key, path.name) for key in ("lowest_speed", "highest_speed"))
    if not 0 <= low < high:
        raise ParameterError(
            f"{path.name}, line {about.sourceline}: lowest_speed and highest_speed [m/s] must be numbers, the second higher."
        )
    return low, high
