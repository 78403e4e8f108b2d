"""How does a declared system become an .ssp that works everywhere? SystemStructure.ssd of SSP 1.0 as importers read it in practice.

FMI 2 co-simulation, the same unit at both ends of a connection, no connectors of the system, one .ssv for each component with the FMU's
own names, and the annotation without which OMSimulator gives up. `write_full` has what the standards offer beyond that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from evat import __version__, fmu
from evat.files import ssv
from evat.fmu import archive
from evat.fmu.credibility import credibility_files
from evat.fmu.xml import Element, add, serialised, top
from evat.model import Variable
from evat.paper.tables import materials as materials_of_work
from evat.paper.work_materials import material_of
from evat.systems.declared import Declared, Part, load, materials, names, of_work, portable, set_values
from evat.units import base_unit

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
ABOUT = "urn:evat:system"  # our annotation: bonds, and which steps are worth a row
SET_NAME = "default"  # of every .ssv: Ecos takes the sets of one name together

Progress = Callable[[str], None]


def fmu_entry(part: Part) -> str:
    """Where the archive keeps the FMU of a component."""
    return f"resources/{fmu.fmu_facts_of(part.part).model_name}.fmu"


def add_units(parent: Element, variables: Iterable[Variable], namespace: str = SSD) -> None:
    """The units of these variables by their SI exponents."""
    units = sorted({variable.unit for variable in variables if variable.type == "real" and variable.unit != "1"})
    if units:
        element = add(parent, f"{{{namespace}}}Units")
        for unit in units:
            add(add(element, f"{{{SSC}}}Unit", {"name": unit}), f"{{{SSC}}}BaseUnit", dict(base_unit(unit).exponents))


def add_connector(parent: Element, variable: Variable, kind: str | None = None, name: str | None = None) -> Element:
    """A real connector."""
    connector = add(parent, f"{{{SSD}}}Connector", {"name": name or variable.name, "kind": kind or variable.causality})
    add(connector, f"{{{SSC}}}Real", {"unit": variable.unit if variable.unit != "1" else None})
    return connector


def root(declared: Declared, version: str) -> Element:
    """The root element."""
    head = {"version": version, "name": declared.name, "description": declared.title, "generationTool": f"evat {__version__}"}
    head |= {"generationDateAndTime": archive.stamp()}
    return top(f"{{{SSD}}}SystemStructureDescription", head, {"ssd": SSD, "ssc": SSC, "oms": OMS, "evat": ABOUT})


def add_annotations(parent: Element, declared: Declared) -> None:
    """How OMSimulator steps it, and what `evat system` knows beyond the standard."""
    annotations = add(parent, f"{{{SSD}}}Annotations")
    oms = add(annotations, f"{{{SSC}}}Annotation", {"type": "org.openmodelica"})
    information = add(add(oms, f"{{{OMS}}}Annotations"), f"{{{OMS}}}SimulationInformation")
    tolerances = {"absoluteTolerance": 1e-6, "relativeTolerance": 1e-6}
    add(information, f"{{{OMS}}}FixedStepMaster", {"description": "oms-ma", "stepSize": declared.step_of_held_inputs, **tolerances})
    ours = add(
        add(annotations, f"{{{SSC}}}Annotation", {"type": "evat.system"}),
        f"{{{ABOUT}}}system",
        {"step": declared.step, "every": declared.every},
    )
    for bond in declared.bonds:
        ends = {"force": ".".join(bond.force), "velocity": ".".join(bond.velocity)}
        add(ours, f"{{{ABOUT}}}bond", ends | ({"against": "true"} if bond.against else {}))


def structure(declared: Declared) -> bytes:
    """The portable SystemStructure.ssd."""
    document = root(declared, "1.0")
    system = add(document, f"{{{SSD}}}System", {"name": declared.name})
    elements = add(system, f"{{{SSD}}}Elements")
    connected = []
    for part in declared.parts.values():
        head = {"name": part.name, "type": "application/x-fmu-sharedlibrary", "source": fmu_entry(part)}
        component = add(elements, f"{{{SSD}}}Component", head)
        connectors = add(component, f"{{{SSD}}}Connectors")
        for name in declared.connectors(part.name):
            add_connector(connectors, part.variables[name])
            connected.append(part.variables[name])
        bindings = add(component, f"{{{SSD}}}ParameterBindings")
        add(bindings, f"{{{SSD}}}ParameterBinding", {"source": f"resources/{part.name}.ssv"})
    connections = add(system, f"{{{SSD}}}Connections")
    for to, at in declared.connections.items():
        ends = {"startElement": at[0], "startConnector": at[1], "endElement": to[0], "endConnector": to[1]}
        add(connections, f"{{{SSD}}}Connection", ends)
    add_annotations(system, declared)
    add_units(document, connected)
    add(document, f"{{{SSD}}}DefaultExperiment", {"startTime": 0.0, "stopTime": float(declared.stop_time)})
    return serialised(document)


def parameter_file(part: Part, values: Mapping[str, float], name: str = SET_NAME) -> bytes:
    """The .ssv of a component."""
    return ssv.serialised(ssv.Content(name, name, values, part.sources), part.variables)


def parameter_files(declared: Declared) -> dict[str, bytes]:
    """One for each component; and those of the other materials, which nothing binds."""
    files = {f"resources/{part.name}.ssv": parameter_file(part, part.values) for part in declared.parts.values()}
    for name in materials(declared):
        (part,) = (part for part in declared.parts.values() if part.part == "evat_turning")
        material = material_of(name)
        thermal = of_work(material, part.variables) if material else {}
        values = portable({**set_values(name)[0], **thermal}, part.variables, name)
        files[f"resources/{part.name}/{name.replace('/', '-')}.ssv"] = parameter_file(part, values)
    for heat in (part for part in declared.parts.values() if part.part == "tool_heat"):
        for material in materials_of_work():
            files[f"resources/{heat.name}/{material}.ssv"] = parameter_file(heat, {**heat.values, **of_work(material, heat.variables)})
    return files


def write(name: str, output: Path, fmus: Mapping[str, Path]) -> Path:
    """Write a system of ours as an .ssp with these FMI 2 FMUs, by their parts; it appears whole or not at all."""
    declared = load(name)
    files = {"SystemStructure.ssd": structure(declared), **parameter_files(declared), **credibility_files(name, name, __version__)}
    for part in declared.parts.values():
        files[fmu_entry(part)] = fmus[part.part].read_bytes()
    return archive.write(files, output)


def write_all(folder: Path, fmus: Path, progress: Progress = lambda _: None) -> list[Path]:
    """All systems of ours, with the FMUs in the folder `fmus`."""
    of_parts = {part: fmus / fmu.file_name(2, part) for part in fmu.parts()}
    written = []
    for name in names():
        progress(f"system {name}")
        written.append(write(name, folder / f"{name}.ssp", of_parts))
    return written
