"""What does an .ssp hold? Read as something that a stranger sent: nothing leaves its folder, and every complaint is plain."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy

from evat.files.read_xml import XmlError, check_valid, number, read_xml
from evat.files.unpack import Allowance, ArchiveError, opened, unpack
from evat.model import ParameterError
from evat.systems.model import Bond, Component, Connector, Port, SspError, System, port
from evat.systems.ssp.bindings import NAMESPACES, inside, of_component, of_system
from evat.systems.ssp.names import check_name
from evat.systems.ssp.relays import through
from evat.units import affine, base_unit

FMU_TYPES = (None, "application/x-fmu-sharedlibrary")
NO_DAY = (1980, 1, 1)  # in a ZIP: the first that it can write
IMPLEMENTATIONS = ("any", "CoSimulation")


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
    if top.get("version", "1.0") not in ("1.0", "1.1", "2.0"):
        raise SspError(f"{what}: it is of SSP {top.get('version')}; SSP 1.0, 1.1 and 2.0 are read.")
    check_valid(tree, "SystemStructureDescription", what)
    system = top.find("ssd:System", NAMESPACES)
    if system.find("ssd:Elements/ssd:System", NAMESPACES) is not None:
        raise SspError(f"{what}: it holds a system within the system; only flat systems are read.")
    components: dict[str, Component] = {}
    units: dict[str, dict[str, str | None]] = {}
    for element in system.iterfind("ssd:Elements/ssd:Component", NAMESPACES):
        check_name(element.get("name"), components, f"{what}, line {element.sourceline}")
        component, units[element.get("name")] = _component(element, folder, path.name, allowance)
        components[component.name] = component
    if not components:
        raise SspError(f"{what}: there is no component in it.")
    for name, values in of_system(system, folder, what, units).items():
        components[name] = replace(components[name], values={**components[name].values, **values})
    connections, notes = _connections(system, components, what)
    experiment, about = (
        top.find("ssd:DefaultExperiment", NAMESPACES),
        system.find("ssd:Annotations/ssc:Annotation/about:system", NAMESPACES),
    )
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
        notes
        if about is not None
        else (*notes, "it names no communication step: a thousandth of the run is taken where none is given (--step)"),
        _day(top.get("generationDateAndTime", ""), path),
    )


def _day(stated: str, archive: Path) -> str:
    """The day that the system says it was made on, else that of its newest file; "" where an archive knows of none."""
    if day := re.match(r"\d{4}-\d\d-\d\d(?=T)", stated):
        return day[0]
    with opened(archive) as packed:
        newest = max(entry.date_time[:3] for entry in packed.infolist())
    return "" if newest <= NO_DAY else "-".join(f"{part:02}" for part in newest)


def _component(element: Any, folder: Path, archive: str, allowance: Allowance) -> tuple[Component, dict[str, str | None]]:
    """A component, and the unit of each variable of its FMU."""
    name, where = element.get("name"), f"{archive}, component {element.get('name')}"
    if element.get("type") not in FMU_TYPES:
        raise SspError(f"{where}: it is of type {element.get('type')}; only FMUs are coupled.")
    if element.get("implementation", "any") not in IMPLEMENTATIONS:
        raise SspError(f"{where}: it is to run by {element.get('implementation')}; only co-simulation is coupled.")
    if element.get("source") is None:
        raise SspError(f"{where}: it has no source; a system is run with the FMUs of all its components.")
    source = inside(folder, element.get("source"), where, "the FMU")
    with opened(source, where, allowance):
        pass
    try:
        description = fmpy.read_model_description(str(source), validate=False)
    except Exception as error:  # fmpy raises what its parsers raise
        raise SspError(f"{where}: {element.get('source')} is no FMU that can be read ({error}).") from error
    variables = {variable.name: variable for variable in description.modelVariables}
    connectors = {}
    for child in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
        connectors[child.get("name")] = _connector(child, variables, where)
    units = {name: _declared(variable) for name, variable in variables.items()}
    return Component(name, source, connectors, of_component(element, folder, where, units)), units


def _declared(variable: Any) -> str | None:
    """The unit that the FMU declares for a variable; None where it declares none, not even that of a pure number."""
    of_type = variable.declaredType.unit if variable.declaredType is not None else None
    unit = variable.unit or of_type
    return None if unit is None else str(unit)


def _real(connector: Any) -> Any:
    """What says that it is a real number, and of which unit; None where nothing does."""
    return next((real for kind in ("Real", "Float64") if (real := connector.find(f"ssc:{kind}", NAMESPACES)) is not None), None)


def _connector(element: Any, variables: Mapping[str, Any], where: str) -> Connector:
    name, kind = element.get("name"), element.get("kind")
    if name not in variables:
        raise SspError(f"{where}: its FMU has no variable {name!r} for the connector of that name.")
    if kind not in ("input", "output") or variables[name].causality != kind:
        raise SspError(
            f"{where}: connector {name} is {kind}, the FMU's variable is {variables[name].causality}; both must be input or output."
        )
    declared, real = _declared(variables[name]), _real(element)
    if declared is None:  # what the system says of it is all that is known
        given = None if real is None else real.get("unit")
        return Connector(name, kind, given or "1", has_unit=given is not None)
    unit = declared
    stated = unit if real is None else real.get("unit", unit)
    if stated != unit and _factor(stated, unit) != (1.0, 0.0):
        raise SspError(f"{where}: connector {name} is in {stated}, the FMU's variable in {unit}; give both the same unit.")
    return Connector(name, kind, unit)


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
    for where, ends in through(system, what):
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
        Bond(port(bond.get("force", ""), what), port(bond.get("velocity", ""), what), _against(bond, what))
        for bond in about.iterfind("about:bond", NAMESPACES)
    )
    for bond in bonds:
        for at in (bond.force, bond.velocity):
            if at not in connections.values():
                raise SspError(f"{what}: {'.'.join(at)} of a bond feeds no input.")
    return bonds


def _against(bond: Any, what: str) -> bool:
    text = bond.get("against", "false")
    if text not in ("true", "false"):
        raise SspError(f"{what}: against = {text!r} of a bond; allowed are true and false.")
    return bool(text == "true")
