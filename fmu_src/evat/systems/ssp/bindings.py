"""Which values does an .ssp bind to its components? Parameter files (.ssv), by the FMU's own names or through a mapping (.ssm)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

from lxml import etree

from evat.files import ssv
from evat.files.read_xml import XmlError, check_valid, number, read_xml
from evat.model import ParameterError, nearest
from evat.systems.model import SspError, port
from evat.units import BaseUnit, base_unit, convert

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
    "about": "urn:evat:system",
}
# SSP 1 knows Real and Integer; SSP 2 also the types of FMI 3.
NUMBERS = {"Real", "Integer", "Float32", "Float64", *(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64))}

Value = float | str | bool
Units = Mapping[str, str] | Mapping[str, str | None]


def inside(folder: Path, source: str, where: str, what: str) -> Path:
    """The file of an archive that lies unpacked in `folder`; SspError for one outside, or one that is not there."""
    path = (folder / source).resolve()
    if "://" in source or not path.is_relative_to(folder.resolve()):
        raise SspError(f"{where}: the source {source!r} lies outside of the archive; it is not read.")
    if not os.path.isfile(path):
        raise SspError(f"{where}: {what} {source[:200]} is missing from the archive.")
    return path


def of_component(element: Any, folder: Path, where: str, units: Units) -> dict[str, Value]:
    """What the bindings of a component set, by the names of its FMU, whose `units` are given."""
    values: dict[str, Value] = {}
    for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
        if binding.find("ssd:ParameterMapping", NAMESPACES) is not None:
            raise SspError(f"{where}: its parameter binding has a mapping; of a component only the FMU's own names are read.")
        values.update(values_of(_values_file(binding, folder, where), units))
    if unknown := [key for key in values if key not in units]:
        raise SspError(f"{where}: its parameter values name {unknown[0]!r}, which the FMU does not have.")
    return values


def of_system(system: Any, folder: Path, where: str, units: Mapping[str, Units]) -> dict[str, dict[str, Value]]:
    """What the bindings of the system itself set, by component, over what stands at the components (SSP 2.0, section 4.5.1.4)."""
    bound: dict[str, dict[str, Value]] = {}
    for binding in system.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
        path = _values_file(binding, folder, where)
        mapping = binding.find("ssd:ParameterMapping", NAMESPACES)
        names = list(values_of(path, {}))
        targets = {name: [name] for name in names} if mapping is None else _targets(mapping, folder, where)
        if unknown := [name for name in targets if name not in names]:
            raise SspError(f"{where}: its parameter mapping names {unknown[0]!r}; {nearest(unknown[0], names)}")
        if lost := [name for name in names if name not in targets]:
            raise SspError(f"{where}: its parameter mapping says nothing of {lost[0]!r} in {path.name}.")
        of_component: dict[str, dict[str, str]] = {}
        for source, ends in targets.items():
            for at in (port(text, f"{where}, parameter {source}") for text in ends):
                if at[1] not in units.get(at[0], {}):
                    raise SspError(f"{where}: parameter {source} is for {'.'.join(at)}, which no component has.")
                of_component.setdefault(at[0], {})[at[1]] = source
        for component, sources in of_component.items():
            read = values_of(path, {source: units[component][name] for name, source in sources.items()})
            bound.setdefault(component, {}).update({name: read[source] for name, source in sources.items()})
    return bound


def _values_file(binding: Any, folder: Path, where: str) -> Path:
    if binding.get("prefix"):
        raise SspError(f"{where}: its parameter binding has a prefix; only names as they stand are read.")
    if binding.get("source") is None:
        raise SspError(f"{where}: its parameter values stand in the .ssd; only .ssv files are read.")
    return inside(folder, binding.get("source"), where, "the parameter file")


def _targets(mapping: Any, folder: Path, where: str) -> dict[str, list[str]]:
    """Where each parameter goes, as "component.variable"; one may go to several."""
    if mapping.get("source") is None:
        raise SspError(f"{where}: its parameter mapping stands in the .ssd; only .ssm files are read.")
    path = inside(folder, mapping.get("source"), where, "the parameter mapping")
    tree = read_xml(path, path.name)
    check_valid(tree, "SystemStructureParameterMapping", path.name)
    targets: dict[str, list[str]] = {}
    for entry in tree.getroot().iterfind("ssm:MappingEntry", NAMESPACES):
        if [child for child in entry if etree.QName(child).localname.endswith("Transformation")]:
            raise SspError(f"{path.name}, line {entry.sourceline}: the entry has a transformation; only names are mapped.")
        targets.setdefault(entry.get("source"), []).append(entry.get("target"))
    return targets


def values_of(path: Path, units: Units) -> dict[str, Value]:
    """What an .ssv file sets, by name; numbers in the units that the FMU has for these names, as are those without a unit.

    Where the FMU has none, a number stands as it is.
    """
    tree = read_xml(path, path.name)
    check_valid(tree, "SystemStructureParameterValues", path.name)
    own = ssv.units_in_file(tree.getroot(), path.name)
    values: dict[str, Value] = {}
    for parameter in tree.getroot().iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        name, kind, where = parameter.get("name"), etree.QName(parameter[0]).localname, f"{path.name}, line {parameter.sourceline}"
        if name in values:
            raise XmlError(f"{where}: {name} is there twice; keep one.")
        if kind == "Boolean":
            values[name] = parameter[0].get("value").strip() in ("true", "1")
        elif kind in ("Enumeration", "String"):
            values[name] = parameter[0].get("value")
        elif kind in NUMBERS:
            value, unit, wanted = number(parameter[0], "value", path.name), parameter[0].get("unit"), units.get(name)
            if unit is not None and wanted is not None and unit != wanted:  # a name that the FMU does not have is told elsewhere
                value = _in_unit(value, own.get(unit, unit), wanted, f"{where}: {name} = {value:g} {unit}")
            values[name] = value
        else:
            raise XmlError(f"{where}: {name} is given as {kind}, which no variable here takes; numbers, choices and texts are read.")
    return values


def _in_unit(value: float, unit: BaseUnit | str, wanted: str, what: str) -> float:
    try:
        source, target = base_unit(unit) if isinstance(unit, str) else unit, base_unit(wanted)
        if source.exponents == target.exponents:
            return convert(Decimal(repr(value)), source, target)
    except ParameterError:  # a unit of the author's own
        pass
    raise SspError(f"{what}: the FMU has this in {wanted}, and the one does not measure what the other does, or is no unit that is known.")
