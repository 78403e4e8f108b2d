"""What do we declare of our systems? ssp/NAME/system.toml: parts, values and connections, checked against the tables of the parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evat import parameter_sets
from evat.files.read_toml import read_toml
from evat.fmu.part_model import fmu_facts_of, model_of, parts
from evat.model import Variable
from evat.native.compile import CONTACT, PACKAGE
from evat.paper.work_materials import constants
from evat.systems.model import Bond, Port, SspError, port

KEYS = {"title", "stop_time", "step", "step_of_held_inputs", "every", "inputs", "show", "components", "connections", "bonds"}
BOND_KEYS = {"force", "velocity", "against"}
PART_KEYS = {"part", "set", "work", "values"}


@dataclass(frozen=True, slots=True)
class Part:
    """A component: which FMU, its variables as that FMU starts them, and the values that the system gives it (SI, choices by place)."""

    name: str
    part: str
    variables: Mapping[str, Variable]
    values: Mapping[str, float]
    sources: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Declared:
    """One system. Its communication `step` [s] is that of our own coupling, which continues inputs along their slope; `step_of_held_inputs`
    that of masters which hold them, so that friction stays within 1 % of its range. `inputs` are given from outside."""

    name: str
    title: str
    stop_time: float
    step: float
    step_of_held_inputs: float
    every: int
    parts: Mapping[str, Part]
    connections: Mapping[Port, Port]
    bonds: tuple[Bond, ...]
    show: tuple[Port, ...]
    inputs: tuple[Port, ...] = ()

    def variable(self, at: Port) -> Variable:
        """The variable at a port; SspError where there is none."""
        where = f"system {self.name}"
        if at[0] not in self.parts:
            raise SspError(f"{where}: there is no component {at[0]!r}; it has {', '.join(self.parts)}.")
        if at[1] not in self.parts[at[0]].variables:
            raise SspError(f"{where}: component {at[0]} has no variable {at[1]!r}.")
        return self.parts[at[0]].variables[at[1]]

    def connectors(self, component: str) -> tuple[str, ...]:
        """What the component shows, in the order of its table: what is connected or given from outside, and the outputs to look at."""
        ports = {*self.connections, *self.connections.values(), *self.show, *self.inputs}
        return tuple(name for name in self.parts[component].variables if (component, name) in ports)


def folder() -> Path:
    """Where the declarations lie: beside the sources in a checkout, in the package once installed."""
    places = (PACKAGE / "_source" / "ssp", PACKAGE.parent.parent / "ssp")
    for place in places:
        if place.is_dir():
            return place
    raise SspError(f"the systems are not there; looked for {places[0]} and {places[1]}. Install evat again.")


def names() -> tuple[str, ...]:
    """The systems that we declare."""
    return tuple(sorted(path.parent.name for path in folder().glob("*/system.toml")))


def load(name: str) -> Declared:
    """The declaration of a system of ours."""
    if name not in names():
        raise SspError(f"there is no system {name!r}; ours are {', '.join(names())}.")
    table = read_toml(folder() / name / "system.toml")
    where = f"system {name}"
    _only(table, KEYS, where)
    parts = {key: _part(key, entry, f"{where}, component {key}") for key, entry in table["components"].items()}
    connections = {port(to, where): port(at, where) for to, at in table["connections"].items()}
    bonds = tuple(_bond(bond, where) for bond in table.get("bonds", []))
    show, inputs = (tuple(port(text, where) for text in table.get(key, ())) for key in ("show", "inputs"))
    step, every = table["step"], table.get("every", 1)
    held = table.get("step_of_held_inputs", step)
    declared = Declared(name, table["title"], table["stop_time"], step, held, every, parts, connections, bonds, show, inputs)
    _check(declared)
    return declared


def _only(table: Mapping[str, Any], keys: set[str], where: str) -> None:
    if unknown := sorted(table.keys() - keys):
        raise SspError(f"{where}: unknown {', '.join(unknown)}; allowed are {', '.join(sorted(keys))}.")


def _bond(entry: Mapping[str, Any], where: str) -> Bond:
    _only(entry, BOND_KEYS, f"{where}, bond of {entry.get('force')}")
    return Bond(port(entry["force"], where), port(entry["velocity"], where), entry.get("against", False))


def _part(name: str, entry: Mapping[str, Any], where: str) -> Part:
    _only(entry, PART_KEYS, where)
    if entry["part"] not in parts():
        raise SspError(f"{where}: there is no part {entry['part']!r}; allowed are {', '.join(parts())}.")
    variables = {variable.name: variable for variable in model_of(entry["part"]).variables}
    values: dict[str, float] = {}
    sources: dict[str, str] = {}
    if "set" in entry:
        if fmu_facts_of(entry["part"]).model != CONTACT:
            raise SspError(f"{where}: parameter sets are of the contact; {entry['part']} has none.")
        values, sources = set_values(entry["set"])
        if hidden := [key for key in values if key not in variables]:
            raise SspError(f"{where}: the set {entry['set']} gives {', '.join(hidden)}, which {entry['part']} does not show.")
    if "work" in entry:
        thermal = of_work(entry["work"], variables)
        values |= thermal
        sources |= {key: constants(entry["work"])[key].source for key in thermal}
    for key, value in entry.get("values", {}).items():
        if key not in variables or variables[key].causality not in ("parameter", "input"):
            raise SspError(f"{where}: {key!r} is no parameter or input of {entry['part']}.")
        values[key] = variables[key].check(value)
    return Part(name, entry["part"], variables, portable(values, variables, where), sources)


def set_values(name: str) -> tuple[dict[str, float], dict[str, str]]:
    """Values and sources of a parameter set of the contact, its effects among them."""
    parameter_set = parameter_sets.load(name)
    return {**parameter_set.values, **dict.fromkeys(parameter_set.effects, 1.0)}, dict(parameter_set.sources)


def of_work(material: str, variables: Mapping[str, Variable]) -> dict[str, float]:
    """The thermal constants of a material that are among the variables."""
    return {key: variables[key].check(row.value) for key, row in constants(material).items() if key in variables}


def portable(values: Mapping[str, float], variables: Mapping[str, Variable], where: str) -> dict[str, float]:
    """The values without choices that stand at their start: some importers cannot set choices, so no other is allowed."""
    for name, value in values.items():
        if variables[name].type == "choice" and value != variables[name].start:
            wanted, start = (variables[name].choices[int(number)] for number in (value, variables[name].start))
            raise SspError(
                f"{where}: {name} = {wanted}, but the FMU starts with {start}, and some importers cannot set choices; "
                "take a part that starts with it (fmus/*.toml, [start])."
            )
    return {name: value for name, value in values.items() if variables[name].type != "choice"}


def _check(declared: Declared) -> None:
    where = f"system {declared.name}"
    for to, at in declared.connections.items():
        target, source = declared.variable(to), declared.variable(at)
        if target.causality != "input" or source.causality != "output":
            raise SspError(f"{where}: {'.'.join(at)} to {'.'.join(to)}: an output to an input is needed.")
        if target.unit != source.unit:
            raise SspError(f"{where}: {'.'.join(at)} is in {source.unit}, {'.'.join(to)} in {target.unit}; no importer converts both ways.")
    for at in declared.inputs:
        if declared.variable(at).causality != "input" or at in declared.connections:
            raise SspError(f"{where}: {'.'.join(at)} is no input, or something feeds it.")
    for at in declared.show:
        if declared.variable(at).causality != "output":
            raise SspError(f"{where}: {'.'.join(at)} is no output.")
    for bond in declared.bonds:
        for at in (bond.force, bond.velocity):
            if at not in declared.connections.values():
                raise SspError(f"{where}: {'.'.join(at)} of a bond is not connected.")


def materials(declared: Declared) -> Sequence[str]:
    """Parameter sets of the contact that this system takes as they stand: those with its choices."""
    places = [part for part in declared.parts.values() if part.part == "evat_turning"]
    fitting = []
    for name in parameter_sets.names() if places else ():
        try:
            portable(set_values(name)[0], places[0].variables, name)
        except SspError:
            continue
        fitting.append(name)
    return fitting
