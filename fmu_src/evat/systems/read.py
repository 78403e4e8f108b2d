"""What does an .ssp hold? Read as something that a stranger sent: nothing leaves its folder, and every complaint is plain."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import fmpy
from lxml import etree

from evat.files import ssv
from evat.files.read_xml import XmlError, check_valid, number, read_xml
from evat.files.unpack import Allowance, ArchiveError, opened, unpack
from evat.model import ParameterError
from evat.systems.model import Bond, Component, Connector, Port, SspError, System, port
from evat.units import BaseUnit, affine, base_unit, convert

_NS = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "about": "urn:evat:system",
}
FMU_TYPES = (None, "application/x-fmu-sharedlibrary")


def read(path: Path, folder: Path) -> System:
    """The system in an .ssp, unpacked into the empty `folder`, with its connections checked against the FMUs."""
    if not path.is_file():
        raise SspError(f"{path}: there is no such file.")
    try:
        return _read(path, folder)
    except (ArchiveError, XmlError) as error:
        raise SspError(str(error)) from error


def _read(path: Path, folder: Path) -> System:
    allowance = Allowance()
    unpack(path, folder, allowance=allowance)
    what = f"{path.name}, SystemStructure.ssd"
    if not (folder / "SystemStructure.ssd").is_file():
        raise SspError(f"{path.name}: there is no SystemStructure.ssd in it; it is no system.")
    tree = read_xml(folder / "SystemStructure.ssd", what)
    top = tree.getroot()
    if top.get("version", "1.0") not in ("1.0", "1.1"):
        raise SspError(
            f"{what}: it is of SSP {top.get('version')}; SSP 1.0 and 1.1 are read. Take its portable form: "
            "of NAME-full.ssp, which `evat build` writes, that is NAME.ssp beside it, the same system."
        )
    check_valid(tree, "SystemStructureDescription" + ("11" if top.get("version") == "1.1" else ""), what)
    system = top.find("ssd:System", _NS)
    if system.find("ssd:Elements/ssd:System", _NS) is not None:
        raise SspError(f"{what}: it holds a system within the system; only flat systems are read.")
    if system.find("ssd:Connectors/ssd:Connector", _NS) is not None:
        raise SspError(f"{what}: the system itself has connectors; take the variant without, or remove them.")
    components = {}
    for element in system.iterfind("ssd:Elements/ssd:Component", _NS):
        if element.get("name") in components:
            raise SspError(f"{what}, line {element.sourceline}: component {element.get('name')} is there twice.")
        components[element.get("name")] = _component(element, folder, path.name, allowance)
    if not components:
        raise SspError(f"{what}: there is no component in it.")
    connections, notes = _connections(system, components, what)
    experiment, about = top.find("ssd:DefaultExperiment", _NS), system.find("ssd:Annotations/ssc:Annotation/about:system", _NS)
    start, stop = (
        default if experiment is None else number(experiment, key, what, default)
        for key, default in (("startTime", 0.0), ("stopTime", 1.0))
    )
    return System(
        top.get("name"),
        top.get("description", top.get("name")),
        components,
        connections,
        _bonds(about, connections, what),
        start,
        stop,
        None if about is None else number(about, "step", what),
        1 if about is None else int(number(about, "every", what, 1, whole=True)),
        notes,
    )


def _component(element: Any, folder: Path, archive: str, allowance: Allowance) -> Component:
    name, where = element.get("name"), f"{archive}, component {element.get('name')}"
    if element.get("type") not in FMU_TYPES:
        raise SspError(f"{where}: it is of type {element.get('type')}; only FMUs are coupled.")
    source = _inside(folder, element.get("source"), where, "the FMU")
    with opened(source, where, allowance):
        pass
    try:
        description = fmpy.read_model_description(str(source), validate=False)
    except Exception as error:  # fmpy raises what its parsers raise
        raise SspError(f"{where}: {element.get('source')} is no FMU that can be read ({error}).") from error
    variables = {variable.name: variable for variable in description.modelVariables}
    connectors = {}
    for child in element.iterfind("ssd:Connectors/ssd:Connector", _NS):
        connectors[child.get("name")] = _connector(child, variables, where)
    values = {}
    for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", _NS):
        values.update(_bound(binding, folder, where, {name: _declared(variable) for name, variable in variables.items()}))
    if unknown := [key for key in values if key not in variables]:
        raise SspError(f"{where}: its parameter values name {unknown[0]!r}, which the FMU does not have.")
    return Component(name, source, connectors, values)


def _inside(folder: Path, source: str, where: str, what: str) -> Path:
    path = (folder / source).resolve()
    if "://" in source or not path.is_relative_to(folder.resolve()):
        raise SspError(f"{where}: the source {source!r} lies outside of the archive; it is not read.")
    if not os.path.isfile(path):
        raise SspError(f"{where}: {what} {source[:200]} is missing from the archive.")
    return path


def _declared(variable: Any) -> str | None:
    """The unit that the FMU declares for a variable; None where it declares none, not even that of a pure number."""
    of_type = variable.declaredType.unit if variable.declaredType is not None else None
    unit = variable.unit or of_type
    return None if unit is None else str(unit)


def _connector(element: Any, variables: Mapping[str, Any], where: str) -> Connector:
    name, kind = element.get("name"), element.get("kind")
    if name not in variables:
        raise SspError(f"{where}: its FMU has no variable {name!r} for the connector of that name.")
    if kind not in ("input", "output") or variables[name].causality != kind:
        raise SspError(
            f"{where}: connector {name} is {kind}, the FMU's variable is {variables[name].causality}; both must be input or output."
        )
    declared, real = _declared(variables[name]), element.find("ssc:Real", _NS)
    if declared is None:  # what the system says of it is all that is known
        given = None if real is None else real.get("unit")
        return Connector(name, kind, given or "1", has_unit=given is not None)
    unit = declared
    stated = unit if real is None else real.get("unit", unit)
    if stated != unit and _factor(stated, unit) != (1.0, 0.0):
        raise SspError(f"{where}: connector {name} is in {stated}, the FMU's variable in {unit}; give both the same unit.")
    return Connector(name, kind, unit)


def _in_unit(value: float, unit: BaseUnit | str, wanted: str, what: str) -> float:
    try:
        source, target = base_unit(unit) if isinstance(unit, str) else unit, base_unit(wanted)
        if source.exponents == target.exponents:
            return convert(Decimal(repr(value)), source, target)
    except ParameterError:  # a unit of the author's own
        pass
    raise SspError(f"{what}: the FMU has this in {wanted}, and the one does not measure what the other does, or is no unit that is known.")


def _factor(unit: str, wanted: str) -> tuple[float, float] | None:
    """Factor and offset between two units; None where they measure different things."""
    try:
        return affine(unit, wanted) if base_unit(unit).exponents == base_unit(wanted).exponents else None
    except ParameterError:  # a unit of the author's own: it fits itself only
        return None


def _connections(system: Any, components: Mapping[str, Component], what: str) -> tuple[dict[Port, Port], tuple[str, ...]]:
    """What feeds each input, and what had to be taken for granted: a port without a unit has that of the other one."""
    connections: dict[Port, Port] = {}
    notes = list[str]()
    for element in system.iterfind("ssd:Connections/ssd:Connection", _NS):
        where = f"{what}, line {element.sourceline}"
        ends = [(element.get(f"{end}Element"), element.get(f"{end}Connector")) for end in ("start", "end")]
        for component, connector in ends:
            if component not in components:
                raise SspError(f"{where}: the connection names component {component!r}, which is not there.")
            if connector not in components[component].connectors:
                raise SspError(f"{where}: component {component} has no connector {connector!r}.")
        if len(element):
            raise SspError(f"{where}: the connection has a transformation; importers ignore them, so none is allowed.")
        kinds = [components[component].connectors[connector].kind for component, connector in ends]
        at, to = (ends[1], ends[0]) if kinds == ["input", "output"] else ends
        if sorted(kinds) != ["input", "output"]:
            raise SspError(f"{where}: {'.'.join(ends[0])} and {'.'.join(ends[1])} are both {kinds[0]}s; an output feeds an input.")
        if to in connections:
            raise SspError(f"{where}: the input {'.'.join(to)} is fed twice.")
        joined = [components[component].connectors[connector] for component, connector in (at, to)]
        units = [each.unit for each in joined]
        if units[0] != units[1] and not all(each.has_unit for each in joined):
            bare, other = (at, to) if not joined[0].has_unit else (to, at)
            taken = components[other[0]].connectors[other[1]].unit
            components[bare[0]].connectors[bare[1]] = replace(components[bare[0]].connectors[bare[1]], unit=taken)
            notes.append(f"{'.'.join(bare)} has no unit; it is taken to be in {taken}, as {'.'.join(other)} is")
        elif units[0] != units[1] and _factor(*units) != (1.0, 0.0):
            raise SspError(f"{where}: the units do not match: {'.'.join(at)} is in {units[0]}, {'.'.join(to)} in {units[1]}.")
        connections[to] = at
    return connections, tuple(notes)


def _bonds(about: Any, connections: Mapping[Port, Port], what: str) -> tuple[Bond, ...]:
    if about is None:
        return ()
    bonds = tuple(
        Bond(port(bond.get("force", ""), what), port(bond.get("velocity", ""), what)) for bond in about.iterfind("about:bond", _NS)
    )
    for bond in bonds:
        for at in (bond.force, bond.velocity):
            if at not in connections.values():
                raise SspError(f"{what}: {'.'.join(at)} of a bond feeds no input.")
    return bonds


def _bound(binding: Any, folder: Path, where: str, units: Mapping[str, str | None]) -> dict[str, float | str | bool]:
    if binding.get("prefix") or binding.find("ssd:ParameterMapping", _NS) is not None:
        raise SspError(f"{where}: its parameter binding has a prefix or a mapping; only the FMU's own names are read.")
    if binding.get("source") is None:
        raise SspError(f"{where}: its parameter values stand in the .ssd; only .ssv files are read.")
    path = _inside(folder, binding.get("source"), where, "the parameter file")
    return values_of(path, units)


def values_of(path: Path, units: Mapping[str, str] | Mapping[str, str | None]) -> dict[str, float | str | bool]:
    """What an .ssv file sets, by name; numbers in the units that the FMU has for these names, as are those without a unit.

    Where the FMU has none, a number stands as it is.
    """
    tree = read_xml(path, path.name)
    check_valid(tree, "SystemStructureParameterValues", path.name)
    own = ssv.units_in_file(tree.getroot(), path.name)
    values: dict[str, float | str | bool] = {}
    for parameter in tree.getroot().iterfind("ssv:Parameters/ssv:Parameter", _NS):
        name, kind, where = parameter.get("name"), etree.QName(parameter[0]).localname, f"{path.name}, line {parameter.sourceline}"
        if name in values:
            raise XmlError(f"{where}: {name} is there twice; keep one.")
        if kind == "Boolean":
            values[name] = parameter[0].get("value").strip() in ("true", "1")
        elif kind in ("Enumeration", "String"):
            values[name] = parameter[0].get("value")
        elif kind in ("Real", "Integer"):
            value, unit, wanted = number(parameter[0], "value", path.name), parameter[0].get("unit"), units.get(name)
            if unit is not None and wanted is not None and unit != wanted:  # a name that the FMU does not have is told elsewhere
                value = _in_unit(value, own.get(unit, unit), wanted, f"{where}: {name} = {value:g} {unit}")
            values[name] = value
        else:
            raise XmlError(f"{where}: {name} is given as {kind}, which no variable here takes; numbers, choices and texts are read.")
    return values
