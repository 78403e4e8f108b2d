"""What feeds what where signals pass through connectors of the system and signal dictionaries? As connections between components alone.

Such a connector hands on what it is given. Where nothing in the system gives it anything, as with an input of the system, the input of the
component behind it is not connected, and is there for a record.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from evat.systems.model import Port, SspError
from evat.systems.ssp.bindings import NAMESPACES

End = tuple[str | None, str]  # element, connector; no element is the system itself
SEEN_FROM_WITHIN = {"input": "output", "output": "input"}  # an input of the system gives, an output of it takes


def through(system: Any, what: str) -> Iterator[tuple[str, tuple[Port, Port]]]:
    """Where each connection stands, and the two ports that it joins, in the order of the file."""
    kinds = _kinds(system)
    components = {element.get("name") for element in system.iterfind("ssd:Elements/ssd:Component", NAMESPACES)}
    direct = list[tuple[str, End, End]]()
    given: dict[End, tuple[str, End]] = {}  # of a connector that hands on: where that stands, and what it is given
    for element in system.iterfind("ssd:Connections/ssd:Connection", NAMESPACES):
        where = f"{what}, line {element.sourceline}"
        if len(element):
            raise SspError(f"{where}: the connection has a transformation; importers ignore them, so none is allowed.")
        at, to = _ends(element, kinds, where)
        if components >= {at[0], to[0]}:
            direct.append((where, at, to))
            continue
        if "input" in (kinds[at], SEEN_FROM_WITHIN.get(kinds[to])):
            at, to = to, at
        if "input" in (kinds[at], SEEN_FROM_WITHIN.get(kinds[to])):
            raise SspError(f"{where}: between {_told(at)} and {_told(to)} there is no output, or no input; one of each is needed.")
        if to[0] in components:
            direct.append((where, at, to))
        elif to in given:
            raise SspError(f"{where}: {_told(to)} is fed twice.")
        else:
            given[to] = (where, at)
    for where, at, to in direct:
        passed = set[End]()
        while at in given:
            if at in passed:
                raise SspError(f"{given[at][0]}: {_told(at)} is fed by itself.")
            passed.add(at)
            at = given[at][1]
        if at[0] in components:
            yield where, ((str(at[0]), at[1]), (str(to[0]), to[1]))


def _kinds(system: Any) -> dict[End, str]:
    """Which connectors there are, and what each is, seen from within the system."""
    kinds: dict[End, str] = {}
    for connector in system.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
        kinds[None, connector.get("name")] = SEEN_FROM_WITHIN.get(connector.get("kind"), connector.get("kind"))
    for element in system.iterfind("ssd:Elements/*", NAMESPACES):
        for connector in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
            kinds[element.get("name"), connector.get("name")] = connector.get("kind")
    return kinds


def _ends(connection: Any, kinds: Mapping[End, str], where: str) -> tuple[End, End]:
    at, to = ((connection.get(f"{end}Element"), connection.get(f"{end}Connector")) for end in ("start", "end"))
    for end in (at, to):
        if end[0] not in {element for element, _ in kinds}:
            raise SspError(f"{where}: the connection names component {end[0]!r}, which is not there.")
        if end not in kinds:
            raise SspError(f"{where}: {'the system' if end[0] is None else f'component {end[0]}'} has no connector {end[1]!r}.")
    return at, to


def _told(end: End) -> str:
    return f"the system's {end[1]}" if end[0] is None else f"{end[0]}.{end[1]}"
