"""Do terminals connect by name, into connections that an SSP holds, and is what does not fit refused?"""

from __future__ import annotations

import dataclasses
import zipfile
from pathlib import Path

import fmpy
import pytest
from evat.systems.terminals import Terminal, TerminalError, connect, terminals
from lxml import etree

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
MACHINE = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Machine" instantiationToken="x">
<CoSimulation modelIdentifier="Machine"/><ModelVariables>
{}</ModelVariables><ModelStructure/></fmiModelDescription>"""
PLUG = """<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals>
<Terminal name="tool_post" matchingRule="plug" terminalKind="_evat_planar_flange">
{}</Terminal></Terminals></fmiTerminalsAndIcons>"""
MEMBERS = {  # member -> variable, causality, unit, kind; in another order than the contact's
    "force_y": ("f_y", "input", "N", "inflow"),
    "force_x": ("f_x", "input", "N", "inflow"),
    "velocity_x": ("speed_x", "output", "m/s", "signal"),
    "velocity_y": ("speed_y", "output", "m/s", "signal"),
    "displacement_x": ("place_x", "output", "m", "signal"),
    "displacement_y": ("place_y", "output", "m", "signal"),
}


@pytest.fixture
def machine(tmp_path: Path) -> Terminal:
    """An FMU of somebody else's with the facing terminal; names of its own."""
    variables, members = "", ""
    for place, (member, (name, causality, unit, kind)) in enumerate(MEMBERS.items()):
        start = ' start="0"' if causality == "input" else ""
        variables += f'<Float64 name="{name}" valueReference="{place}" causality="{causality}" unit="{unit}"{start}/>\n'
        members += f'<TerminalMemberVariable variableName="{name}" memberName="{member}" variableKind="{kind}"/>\n'
    path = tmp_path / "Machine.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", MACHINE.format(variables))
        archive.writestr("terminalsAndIcons/terminalsAndIcons.xml", PLUG.format(members))
    return terminals(path)["tool_post"]


@pytest.fixture
def tool(fmi3_fmu: Path) -> Terminal:
    return terminals(fmi3_fmu)["tool"]


def test_an_fmu_of_fmi2_describes_no_terminals(fmi2_fmu: Path) -> None:
    assert terminals(fmi2_fmu) == {}


def test_members_of_one_name_are_connected(tool: Terminal, machine: Terminal) -> None:
    connected = {connection.member: (connection.output, connection.input, connection.forward) for connection in connect(tool, machine)}
    assert connected == {
        "force_x": ("tool_force_x", "f_x", True),
        "force_y": ("tool_force_y", "f_y", True),
        "displacement_x": ("place_x", "tool_displacement_x", False),
        "displacement_y": ("place_y", "tool_displacement_y", False),
        "velocity_x": ("speed_x", "tool_velocity_x", False),
        "velocity_y": ("speed_y", "tool_velocity_y", False),
    }
    backward = {connection.member: (connection.output, connection.input, not connection.forward) for connection in connect(machine, tool)}
    assert backward == connected


def test_the_connections_are_those_of_a_valid_system_structure(tool: Terminal, machine: Terminal) -> None:
    def element(parent: etree._Element | None, kind: str, /, **attributes: str) -> etree._Element:
        tag = f"{{{SSD}}}{kind}"
        return etree.Element(tag, attributes, {"ssd": SSD, "ssc": SSC}) if parent is None else etree.SubElement(parent, tag, attributes)

    root = element(None, "SystemStructureDescription", version="1.0", name="cut")
    system = element(root, "System", name="cut")
    elements = element(system, "Elements")
    for name, terminal in (("contact", tool), ("machine", machine)):
        component = element(elements, "Component", name=name, type="application/x-fmu-sharedlibrary", source=f"resources/{terminal.fmu}")
        connectors = element(component, "Connectors")
        for member in terminal.members.values():
            connector = element(connectors, "Connector", name=member.variable, kind=member.causality)
            etree.SubElement(connector, f"{{{SSC}}}Real")
    connections = element(system, "Connections")
    for one in connect(tool, machine):
        ends = ("contact", "machine") if one.forward else ("machine", "contact")
        element(connections, "Connection", startElement=ends[0], startConnector=one.output, endElement=ends[1], endConnector=one.input)
    schema = Path(fmpy.__file__).parent / "ssp" / "schema" / "SystemStructureDescription.xsd"
    etree.XMLSchema(file=str(schema)).assertValid(root)
    assert len(connections) == 6


@pytest.mark.parametrize(
    ("member", "change", "message"),
    [
        ("force_x", {"unit": "kN"}, "in N and in kN"),
        ("force_x", {"causality": "output"}, "output and output"),
        ("force_x", {"kind": "outflow"}, "what flows out"),
        ("displacement_x", {"name": "x"}, "on one side only: displacement_x, x"),
    ],
)
def test_what_does_not_fit_is_refused(tool: Terminal, machine: Terminal, member: str, change: dict[str, str], message: str) -> None:
    spoilt = dataclasses.replace(machine.members[member], **change)
    members = {**{name: one for name, one in machine.members.items() if name != member}, spoilt.name: spoilt}
    with pytest.raises(TerminalError, match=message):
        connect(tool, dataclasses.replace(machine, members=members))


def test_other_kinds_are_refused(tool: Terminal, fmi3_fmu: Path) -> None:
    with pytest.raises(TerminalError, match="different kinds"):
        connect(tool, terminals(fmi3_fmu)["contact"])
