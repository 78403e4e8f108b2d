"""What does a person read who opens the FMU of a partner? documentation/index.html from its table."""

from __future__ import annotations

import math

from evat import __version__
from evat.fmu import archive
from evat.fmu.documentation import picture
from evat.fmu.documentation.contact import inline, license_text
from evat.fmu.fmu_facts import FmuFacts
from evat.html import render
from evat.model import Variable
from evat.native import machine

FILES = {"diagram.svg": "the picture above", "licenses/license.txt": "the licence", "externalDependencies.txt": "what it depends on"}
_TITLES = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters", "local": "Local variables"}


def _start(variable: Variable, states: tuple[str, ...]) -> str:
    if variable.causality in ("output", "local") and variable.name not in states:
        return ""
    return variable.choices[int(variable.start)] if variable.choices else f"{variable.start:.6g}"


def _bound(variable: Variable, limit: float) -> str:
    return "" if variable.choices or math.isinf(limit) else f"{limit:.6g}"


def documentation_files(fmu_facts: FmuFacts, part: str) -> dict[str, bytes]:
    """The folder documentation and the picture of the model."""
    variables, states = machine.variables(part), machine.states(part)
    drawing = picture.block(fmu_facts.model_name, variables)
    page = render(
        "machine.html.j2",
        fmu_facts=fmu_facts,
        version=__version__,
        day=archive.generated().date().isoformat(),
        token=machine.token(part),
        equations=machine.equations(part),
        diagram=inline(drawing.svg),
        groups=[(title, [v for v in variables if v.causality == role]) for role, title in _TITLES.items()],
        guesses=sum(v.source.startswith("guess") for v in variables if v.causality == "parameter"),
        start=lambda variable: _start(variable, states),
        bound=_bound,
        files=FILES,
    )
    return {
        "documentation/index.html": page.encode(),
        "documentation/diagram.png": drawing.png,
        "documentation/diagram.svg": drawing.svg,
        "documentation/externalDependencies.txt": b"none\n",
        "documentation/licenses/license.txt": license_text().encode(),
        "model.png": drawing.png,
    }
