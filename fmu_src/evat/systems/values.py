"""Which values does a user give the components of a system? COMPONENT.VARIABLE=VALUE with units, parameter sets, records of inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from evat import parameter_sets
from evat.files.table import once, read_table
from evat.files.text import RecordError
from evat.model import ParameterError, near_names, nearest
from evat.native import kernel
from evat.paper.work_materials import constants, material_of
from evat.systems.couple import Given
from evat.systems.model import Port, SspError, System, port
from evat.systems.ssp.bindings import values_of
from evat.units import to_si

Value = float | str | bool


@lru_cache(maxsize=32)
def _variables(source: Path) -> Mapping[str, Any]:
    return {variable.name: variable for variable in fmpy.read_model_description(str(source), validate=False).modelVariables}


def variable(system: System, at: Port) -> Any:
    """fmpy's description of a variable; SspError where there is none."""
    if at[0] not in system.components:
        raise SspError(f"there is no component {at[0]!r}; {nearest(at[0], system.components)}")
    known = _variables(system.components[at[0]].source)
    if at[1] not in known:
        raise SspError(f"component {at[0]} has no variable {at[1]!r}; {nearest(at[1], known)}")
    return known[at[1]]


def unit(system: System, at: Port) -> str:
    """The unit of a variable."""
    declared_variable = variable(system, at)
    declared = declared_variable.declaredType.unit if declared_variable.declaredType is not None else None
    return str(declared_variable.unit or declared or "1")


def value(system: System, at: Port, text: str) -> Value:
    """What a typed value stands for in the unit of the FMU; choices by their names, also where the FMU's number was typed."""
    known = variable(system, at)
    if known.causality in ("output", "local", "independent") and known.initial != "exact":
        raise SspError(f"{'.'.join(at)} is {known.causality} and computed; only parameters, inputs and the starts of states can be set.")
    if at in system.connections:
        raise SspError(f"{'.'.join(at)} is fed by {'.'.join(system.connections[at])}; it cannot be set.")
    if known.type == "Boolean":
        if text.lower() not in ("true", "false"):
            raise ParameterError(f"{'.'.join(at)} = {text!r}: allowed are true and false.")
        return text.lower() == "true"
    if known.type == "Enumeration":
        items: dict[str, str] = {str(item.name): str(item.value) for item in known.declaredType.items}
        if text in items:
            return text
        if text in items.values():
            return next(name for name, number in items.items() if number == text)
        allowed = ", ".join(f"{name} ({number})" for name, number in items.items())
        near = near_names(text, items)
        raise ParameterError(f"{'.'.join(at)} = {text!r}: allowed are {allowed}{f'; did you mean {near[0]}?' if near else '.'}")
    return to_si(text, unit(system, at), name=".".join(at))


def typed(system: System, texts: Iterable[str]) -> dict[str, dict[str, Value]]:
    """Values from COMPONENT.VARIABLE=VALUE."""
    values: dict[str, dict[str, Value]] = {}
    for text in texts:
        name, equals, given = text.partition("=")
        if not equals or not given.strip():
            raise ParameterError(f"{text!r}: write COMPONENT.VARIABLE=VALUE, for example 'spindle.speed_set=80 rpm'.")
        at = port(name.strip(), repr(text))
        if at[1] in values.get(at[0], {}):
            raise ParameterError(f"{'.'.join(at)} is given twice, at last as --value {text!r}; keep one.")
        values.setdefault(at[0], {})[at[1]] = value(system, at, given.strip())
    return values


def in_units(system: System, values: Mapping[str, Mapping[str, Value]]) -> dict[str, dict[str, Value]]:
    """Values from Python: texts with units as numbers in the unit of the FMU, all else as it stands."""
    told: dict[str, dict[str, Value]] = {}
    for component, of_component in values.items():
        told[component] = {
            name: value(system, (component, name), given) if isinstance(given, str) else given for name, given in of_component.items()
        }
    return told


def seconds(given: float | str | None, name: str) -> float | None:
    """A time that was given in s or as a text with a unit."""
    return None if given is None else to_si(given, "s", name=name)


def from_set(system: System, component: str, name: str) -> dict[str, Value]:
    """What a parameter set says for a component: one of the contact's by name, or any .ssv file."""
    if name.endswith(".ssv"):
        path = Path(name)
        if not path.is_file():
            raise SspError(f"{path}: there is no such file.")
        known = _variables(system.components[component].source)
        return values_of(path, {each: unit(system, (component, each)) for each in known})
    parameter_set = parameter_sets.load(name)
    known = _variables(system.components[component].source)
    if "friction_law" not in known:
        raise SspError(f"the set {name} is of the contact, and component {component} is none.")
    switches = {effect.name: effect.name in parameter_set.effects for effect in kernel.effects()}
    given = {**switches, **parameter_set.by_choice}
    at_start = {**dict.fromkeys(switches, False), **kernel.by_choice({key: kernel.variable(key).start for key in parameter_set.values})}
    # An FMU that shows a part of the contact has the rest as it starts: only what stands there may be left out.
    lacking = [key for key, wanted in given.items() if key not in known and wanted != at_start[key]]
    if on := [key for key in lacking if key in switches] or lacking:
        does, fmu = "switches on" if on[0] in switches else "gives", system.components[component].source.name
        raise SspError(
            f"the set {name} {does} {', '.join(on)}, which the FMU of component {component} ({fmu}) does not have; take "
            "another set, or a component that has it."
        )
    return {key: wanted for key, wanted in given.items() if key in known}


def of_work(system: System, component: str, name: str) -> dict[str, dict[str, Value]]:
    """A parameter set of a component, and with a material's also its heat: where a part gives the component its contact_temperature,
    that part's constants of the work, and the component's own of the temperature proxy."""
    material, given = material_of(name), {component: from_set(system, component, name)}
    source = system.connections.get((component, "contact_temperature"))
    if material is None or source is None:
        return given
    for each in (component, source[0]):
        known = _variables(system.components[each].source)
        thermal = {key: row.value for key, row in constants(material).items() if key in known}
        given = merged(given, {each: thermal})
    return given


def record(system: System, path: Path) -> Given:
    """Inputs from a table with a column `time` and columns COMPONENT.VARIABLE, units in brackets where they are not SI."""
    table = read_table(path)
    headers = once(table.columns, path.name)
    if "time" not in headers or len(headers) < 2:
        raise RecordError(
            f"{path.name}: columns {', '.join(map(repr, table.columns))}; needed are 'time' and inputs as COMPONENT.VARIABLE."
        )
    times = table.clock(headers.pop("time"))
    ports = tuple(port(name, path.name) for name in headers)
    for at in ports:
        if variable(system, at).causality != "input":
            raise SspError(f"{path.name}: {'.'.join(at)} is no input.")
    columns = [table.column(header, unit(system, at)) for at, header in zip(ports, headers.values(), strict=True)]
    return Given(ports, times, np.column_stack(columns))


def merged(*parts: Mapping[str, Mapping[str, Value]]) -> dict[str, dict[str, Value]]:
    """Later values over earlier ones."""
    together: dict[str, dict[str, Value]] = {}
    for part in parts:
        for component, values in part.items():
            together.setdefault(component, {}).update(values)
    return together
