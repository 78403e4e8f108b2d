"""What do the standards offer beyond the portable form? The same systems in SSP 2.0, with FMI 3 components, as NAME-full.ssp.

The system shows its outputs as connectors and on a signal dictionary; its parameters are one flat list that an .ssm maps to components.
Few importers read this today.
"""

from __future__ import annotations

from pathlib import Path

from lxml import etree

from evat import __version__, fmu
from evat.files import ssv
from evat.fmu import archive
from evat.fmu.credibility import credibility_files
from evat.fmu.xml import Element, add, serialised, top
from evat.model import Variable
from evat.systems.declared import Declared, load, names
from evat.systems.ssp.write import SSC, SSD, Progress, add_annotations, add_connector, add_units, fmu_entry, root

SSM = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SSB = "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
VALUES, MAPPING, SIGNALS, BUS = "resources/system.ssv", "resources/system.ssm", "resources/signals.ssb", "bus"


def _flat(component: str, variable: str) -> str:
    """A name without a dot, for the outside of the system."""
    return f"{component}_{variable}".replace(".", "_")


def _structure(declared: Declared) -> bytes:
    document = root(declared, "2.0")
    system = add(document, f"{{{SSD}}}System", {"name": declared.name})
    outer = add(system, f"{{{SSD}}}Connectors")
    for at in declared.inputs:
        add_connector(outer, declared.variable(at), "input", _flat(*at))
    for at in declared.show:
        add_connector(outer, declared.variable(at), "output", _flat(*at))
    bindings = add(system, f"{{{SSD}}}ParameterBindings")
    binding = add(bindings, f"{{{SSD}}}ParameterBinding", {"source": VALUES})
    add(binding, f"{{{SSD}}}ParameterMapping", {"source": MAPPING})
    elements = add(system, f"{{{SSD}}}Elements")
    for part in declared.parts.values():
        head = {"name": part.name, "type": "application/x-fmu-sharedlibrary", "source": fmu_entry(part), "implementation": "CoSimulation"}
        connectors = add(add(elements, f"{{{SSD}}}Component", head), f"{{{SSD}}}Connectors")
        for name in declared.connectors(part.name):
            add_connector(connectors, part.variables[name])
    bus = add(add(elements, f"{{{SSD}}}SignalDictionaryReference", {"name": BUS, "dictionary": "signals"}), f"{{{SSD}}}Connectors")
    for at in declared.show:
        add_connector(bus, declared.variable(at), "inout", _flat(*at))
    connections = add(system, f"{{{SSD}}}Connections")
    for to, at in declared.connections.items():
        _connect(connections, at, to)
    for at in declared.inputs:
        _connect(connections, (None, _flat(*at)), at)
    for at in declared.show:
        _connect(connections, at, (BUS, _flat(*at)))
        _connect(connections, at, (None, _flat(*at)))
    dictionaries = add(system, f"{{{SSD}}}SignalDictionaries")
    add(dictionaries, f"{{{SSD}}}SignalDictionary", {"name": "signals", "source": SIGNALS})
    add_annotations(system, declared)
    add_units(document, [part.variables[name] for part in declared.parts.values() for name in declared.connectors(part.name)])
    add(document, f"{{{SSD}}}DefaultExperiment", {"startTime": 0.0, "stopTime": float(declared.stop_time)})
    return serialised(document)


def _connect(parent: Element, at: tuple[str | None, str], to: tuple[str | None, str]) -> None:
    ends = {"startElement": at[0], "startConnector": at[1], "endElement": to[0], "endConnector": to[1]}
    add(parent, f"{{{SSD}}}Connection", ends)


def _values(declared: Declared) -> bytes:
    """All parameters of the system in one list."""
    variables: dict[str, Variable] = {}
    values: dict[str, float] = {}
    sources: dict[str, str] = {}
    for part in declared.parts.values():
        for name, value in part.values.items():
            flat = _flat(part.name, name)
            variables[flat], values[flat], sources[flat] = part.variables[name], value, part.sources.get(name, "")
    root = etree.fromstring(ssv.serialised(ssv.Content(declared.name, declared.title, values, sources), variables))
    root.set("version", "2.0")
    return serialised(root)


def _mapping(declared: Declared) -> bytes:
    """From the flat names to those of the components."""
    document = top(f"{{{SSM}}}ParameterMapping", {"version": "2.0"}, {"ssm": SSM, "ssc": SSC})
    for part in declared.parts.values():
        for name in part.values:
            add(document, f"{{{SSM}}}MappingEntry", {"source": _flat(part.name, name), "target": f"{part.name}.{name}"})
    return serialised(document)


def _signals(declared: Declared) -> bytes:
    document = top(f"{{{SSB}}}SignalDictionary", {"version": "2.0"}, {"ssb": SSB, "ssc": SSC})
    for at in declared.show:
        variable = declared.variable(at)
        entry = add(document, f"{{{SSB}}}DictionaryEntry", {"name": _flat(*at), "description": variable.meaning})
        add(entry, f"{{{SSC}}}Real", {"unit": variable.unit if variable.unit != "1" else None})
    add_units(document, map(declared.variable, declared.show), SSB)
    return serialised(document)


def write(name: str, output: Path, fmus: Path) -> Path:
    """Write a system of ours in full with the FMI 3 FMUs in the folder `fmus`; it appears whole or not at all."""
    declared = load(name)
    files = {
        "SystemStructure.ssd": _structure(declared),
        VALUES: _values(declared),
        MAPPING: _mapping(declared),
        SIGNALS: _signals(declared),
        **credibility_files(name, name, __version__),
    }
    for part in declared.parts.values():
        files[fmu_entry(part)] = (fmus / fmu.file_name(3, part.part)).read_bytes()
    return archive.write(files, output)


def write_all(folder: Path, fmus: Path, progress: Progress = lambda _: None) -> list[Path]:
    """All systems of ours."""
    written = []
    for name in names():
        progress(f"system {name}, in full")
        written.append(write(name, folder / f"{name}-full.ssp", fmus))
    return written
