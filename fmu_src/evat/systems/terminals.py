"""Which variables are connected where two terminals are? Members of one name, an output to an input: a plug of FMI 3, for tools and files
that connect variable by variable, as SSP does (in its version 2.0, too).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from fmpy import read_model_description

from evat.files.read_xml import read_xml
from evat.files.unpack import member, opened
from evat.model import EvatError

TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
FACING = {"signal": "signal", "inflow": "outflow", "outflow": "inflow"}  # what a member meets on the other side


class TerminalError(EvatError):
    """Two terminals that do not fit."""


@dataclass(frozen=True)
class Member:
    """One variable of a terminal."""

    name: str
    variable: str
    kind: str
    causality: str
    unit: str


@dataclass(frozen=True)
class Terminal:
    fmu: str
    name: str
    kind: str
    members: dict[str, Member]


@dataclass(frozen=True)
class Connection:
    """From an output to an input; `forward`: from the first terminal to the second."""

    member: str
    output: str
    input: str
    forward: bool


def terminals(fmu: Path) -> dict[str, Terminal]:
    """The terminals of an FMU by name; none where it describes none."""
    with opened(fmu) as archive:
        if TERMINALS not in archive.namelist():
            return {}
        root = read_xml(member(archive, TERMINALS), f"{fmu.name}, {TERMINALS}").getroot()
    known = {v.name: v for v in read_model_description(str(fmu), validate=False).modelVariables}
    by_name = {}
    for element in root.findall("Terminals/Terminal"):
        members = {}
        for row in element.findall("TerminalMemberVariable"):
            name, variable = row.get("memberName") or row.get("variableName"), row.get("variableName")
            if variable not in known:
                raise TerminalError(f"{fmu.name}, terminal {element.get('name')}: there is no variable {variable!r}; correct {TERMINALS}.")
            unit = known[variable].unit or (known[variable].declaredType.unit if known[variable].declaredType else None) or "1"
            members[name] = Member(name, variable, row.get("variableKind"), known[variable].causality, unit)
        by_name[element.get("name")] = Terminal(fmu.name, element.get("name"), element.get("terminalKind") or "", members)
    return by_name


def connect(one: Terminal, other: Terminal) -> list[Connection]:
    """The connections of variables that a connection of both terminals stands for.

    Raises
    ------
    TerminalError where their kinds, members, units or directions do not fit.
    """
    both = f"{one.fmu}: {one.name} and {other.fmu}: {other.name}"
    if one.kind != other.kind:
        raise TerminalError(f"{both} are of different kinds, {one.kind!r} and {other.kind!r}; only terminals of one kind are connected.")
    if one.members.keys() != other.members.keys():
        odd = sorted(one.members.keys() ^ other.members.keys())
        raise TerminalError(f"{both} do not have the same members; on one side only: {', '.join(odd)}.")
    connections = []
    for name, mine in one.members.items():
        theirs = other.members[name]
        if {mine.causality, theirs.causality} != {"input", "output"}:
            raise TerminalError(f"{both}: {name} is {mine.causality} and {theirs.causality}; an output and an input are needed.")
        if FACING.get(mine.kind) != theirs.kind:
            raise TerminalError(f"{both}: {name} is {mine.kind} and {theirs.kind}; what flows out of one must flow into the other.")
        if mine.unit != theirs.unit:
            raise TerminalError(f"{both}: {name} is in {mine.unit} and in {theirs.unit}; the same unit is needed.")
        forward = mine.causality == "output"
        out, into = (mine, theirs) if forward else (theirs, mine)
        connections.append(Connection(name, out.variable, into.variable, forward))
    return connections
