"""How do other people's tools make one FMU of a system? fmpy's container and that of the FMU manipulation toolbox."""

from __future__ import annotations

import copy
import json
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
from evat.systems.model import Port, System
from evat.systems.ssp.read import read


def opened(ssp: Path, folder: Path) -> System:
    folder.mkdir(parents=True)
    return read(ssp, folder)


def by_fmpy(ssp: Path, folder: Path, step: float, ports: list[Port]) -> Path:
    """A container FMU of fmpy; values are starts of variables that the container shows."""
    from fmpy.container_fmu.cli import create_container_fmu
    from fmpy.container_fmu.config import Component, Configuration, Connection
    from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown

    system = opened(ssp, folder / "read")
    components, variables = {}, {}
    for name, part in system.components.items():
        path = folder / f"{name}.fmu"  # the container keeps each under its file's name
        shutil.copy(part.source, path)
        components[name] = Component(name, path, fmpy.read_model_description(str(path)))
        variables[name] = {v.name: v for v in components[name].modelDescription.modelVariables}

    def real(port: Port) -> ModelVariable:
        variable = copy.copy(variables[port[0]][port[1]])
        variable.type = "Float64"  # in the words of FMI 3, which its runtime reads
        return variable

    connections = [Connection(components[at[0]], [real(at)], components[to[0]], [real(to)]) for to, at in system.connections.items()]
    clock = ModelVariable("time", 0, "Float64")
    clock.causality, clock.variability = "independent", "continuous"
    mappings, shown = {}, [clock]  # the clock is the container's own
    starts = [((name, key), value) for name, part in system.components.items() for key, value in part.values.items()]
    for (component, name), value in [*starts, *((port, None) for port in ports)]:
        inner = variables[component][name]
        kind = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}[inner.type]
        outer = ModelVariable(f"{component}_{name}", 0, kind)
        outer.causality, outer.variability = (
            ("output", "continuous") if value is None else ("parameter", "tunable" if kind == "Float64" else "fixed")
        )
        outer.initial = "calculated" if value is None else "exact"
        outer.start = None if value is None else str(value).lower() if isinstance(value, bool) else str(value)
        shown.append(outer)
        mappings[outer] = [(components[component], inner)]
    description = ModelDescription(fmiVersion="3.0", modelName="container", instantiationToken="container", variableNamingConvention="flat")
    description.coSimulation = CoSimulation("container_fmu", fixedInternalStepSize=step)
    description.defaultExperiment = DefaultExperiment(startTime="0", stopTime="1", stepSize=str(step))
    description.modelVariables = shown
    description.outputs = [Unknown(variable=variable) for variable in shown if variable.causality == "output"]
    target = folder / "container.fmu"
    work = folder / "work"
    work.mkdir()
    create_container_fmu(Configuration(False, description, list(components.values()), connections, mappings), work, target)
    return target


def by_toolbox(ssp: Path, folder: Path, step: float, ports: list[Port]) -> Path:
    """A container FMU of the toolbox, FMI 2: from its own JSON, since from an .ssp it takes neither values nor outputs."""
    system = opened(ssp, folder / "read")
    for name, part in system.components.items():
        shutil.copy(part.source, folder / f"{name}.fmu")
    wanted = {
        "name": "container.fmu",
        "step_size": step,
        "mt": False,
        "profiling": False,
        **dict.fromkeys(("auto_link", "auto_input", "auto_output", "auto_parameter", "auto_local"), False),
        "fmu": [f"{name}.fmu" for name in system.components],
        "link": [[f"{at[0]}.fmu", at[1], f"{to[0]}.fmu", to[1]] for to, at in system.connections.items()],
        "output": [[f"{port[0]}.fmu", port[1], "_".join(port)] for port in ports],
        "start": [[f"{name}.fmu", key, value] for name, part in system.components.items() for key, value in part.values.items()],
    }
    (folder / "container.json").write_text(json.dumps(wanted), encoding="utf-8")
    program = Path(sys.executable).with_name("fmucontainer")
    subprocess.run(
        [str(program), "-fmu-directory", str(folder), "-container", "container.json"],
        check=True,
        capture_output=True,
        cwd=folder,
        timeout=120,
    )
    return folder / "container.fmu"
