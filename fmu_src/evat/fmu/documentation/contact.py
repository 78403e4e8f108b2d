"""What does a person read who opens the FMU? documentation/index.html, licences, dependencies: all from the kernel's tables."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from importlib import metadata

from markupsafe import Markup

from evat import __version__, parameter_sets
from evat.fmu import archive
from evat.fmu.documentation import picture
from evat.fmu.fmu_facts import FmuFacts
from evat.html import render
from evat.model import BuildError, Variable
from evat.native import kernel

_TITLES = {
    "input": "Inputs",
    "output": "Outputs",
    "choice": "Choices (fixed)",
    "fixed": "Parameters, fixed",
    "tunable": "Parameters, tunable",
    "local": "Local variables",
}


def license_text() -> str:
    """The licence that the package was installed with."""
    for file in metadata.files("evat") or ():
        if file.name == "LICENSE":
            return file.read_text()
    raise BuildError("the licence text is not among the installed files of evat; install evat again.")


def copyright_line() -> str | None:
    """The copyright line of the licence."""
    match = re.search(r"^Copyright .*$", license_text(), re.MULTILINE)
    return match[0].strip() if match else None


def _group(variable: Variable) -> str:
    if variable.causality == "parameter":
        return "choice" if variable.type in ("choice", "boolean") else variable.variability
    return {"independent": "local", "calculated": "local"}.get(variable.causality, variable.causality)


@dataclass(frozen=True, slots=True)
class Own:
    """The variables of one law or effect, the switch first; the law has none."""

    name: str
    title: str
    switch: Variable | None
    variables: tuple[Variable, ...]


def _own(variables: tuple[Variable, ...]) -> tuple[Own, ...]:
    """What belongs to laws and effects, each with its parameters, states and rates in the order of the table."""
    table = {v.name: v for v in variables}
    groups = []
    for law in kernel.laws():
        if of_law := tuple(table[v.name] for v in law.variables if v.name in table):
            groups.append(Own(law.name, f"friction law {law.name}", None, of_law))
    for effect in kernel.effects():
        if effect.name not in table:
            continue
        switch = table[effect.name]
        own = {v.name for v in (*effect.variables, *effect.states)}
        every = tuple(v for v in variables if v.name in own or v.derivative_of in own)
        groups.append(Own(effect.name, f"effect {effect.name}", switch, every))
    return tuple(groups)


def _number(value: float) -> str:
    return f"{value:.6g}"


def _start(variable: Variable) -> str:
    if variable.causality in ("output", "local", "independent") and variable.name not in kernel.states():
        return ""
    if variable.choices:
        return variable.choices[int(variable.start)]
    return ("true" if variable.start else "false") if variable.type == "boolean" else _number(variable.start)


def _bound(variable: Variable, limit: float) -> str:
    return "" if variable.type in ("choice", "boolean") or math.isinf(limit) else _number(limit)


def _neutral(variable: Variable) -> str:
    return "" if math.isnan(variable.neutral) else _number(variable.neutral)


def _link(name: str, shown: Collection[str]) -> Markup:
    """The name of a variable, a link to its row where it is shown; an unknown name is an error of the template."""
    known = kernel.variable(name).name
    return Markup('<a href="#{0}">{1}</a>').format(known, _code(known)) if known in shown else _code(known)


def _code(name: str) -> Markup:
    """A name that may break after a dot or an underscore."""
    return Markup("<code>{}</code>").format(Markup("<wbr>").join(re.findall(r"[^._]*[._]|[^._]+", name)))


def inline(svg: bytes) -> Markup:
    """An SVG drawing without its XML prologue, for the inside of a page."""
    drawing = svg.decode()
    return Markup(drawing[drawing.index("<svg") :])  # our own drawing: nothing in it comes from outside


def page(fmu_facts: FmuFacts, drawing: picture.Picture, caption: str, variables: tuple[Variable, ...]) -> bytes:
    """documentation/index.html."""
    own = _own(variables)
    owned = {v.name for each in own for v in each.variables} | {each.switch.name for each in own if each.switch}
    parameters = [variable for variable in variables if variable.causality == "parameter"]
    shown = {variable.name for variable in variables}
    text = render(
        "documentation.html.j2",
        fmu_facts=fmu_facts,
        version=__version__,
        day=archive.generated().date().isoformat(),
        token=kernel.token(),
        diagram=inline(drawing.svg),
        caption=caption,
        v=lambda name: _link(name, shown),
        has=lambda name: kernel.variable(name).name in shown,
        code=_code,
        laws=kernel.laws(),
        effects=[effect for effect in kernel.effects() if effect.name in shown],
        shown_count=len(shown),
        every_count=len(kernel.variables()),
        parameters=parameters,
        guesses=sum(variable.source.startswith("guess") for variable in parameters),
        indicator_count=len(shown & set(kernel.indicators())),
        sets=[
            each for each in map(parameter_sets.load, parameter_sets.names()) if {*each.effects, *each.values} <= shown | {*fmu_facts.start}
        ],
        groups=[(key, title, [v for v in variables if _group(v) == key and v.name not in owned]) for key, title in _TITLES.items()],
        own=own,
        neutral=_neutral,
        shown_start=_start,
        bound=_bound,
    )
    return text.encode()


def documentation_files(fmu_facts: FmuFacts, variables: tuple[Variable, ...]) -> dict[str, bytes]:
    """The folder documentation and the picture of the model."""
    drawing, caption = picture.diagram({variable.name for variable in variables})
    return {
        "documentation/index.html": page(fmu_facts, drawing, caption, variables),
        "documentation/diagram.png": drawing.png,
        "documentation/diagram.svg": drawing.svg,
        "documentation/externalDependencies.txt": b"none\n",
        "documentation/licenses/license.txt": license_text().encode(),
        "model.png": drawing.png,
    }
