"""What do the builders ask of a model, be it the contact or a partner? The one place that tells them apart."""

from __future__ import annotations

import hashlib
import json
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from evat.fmu.documentation import contact as documentation
from evat.fmu.documentation import partner as machine_documentation
from evat.fmu.documentation import picture
from evat.fmu.documentation.picture import Picture
from evat.fmu.fmu_facts import FmuFacts, Version, load
from evat.fmu.reference_results import Follow
from evat.fmu.structure.model_structure import Structure, model_structure, restricted
from evat.fmu.structure.partner import machine_structure
from evat.model import BuildError, FloatArray, Law, Variable
from evat.native import kernel, machine
from evat.native.compile import CONTACT, source_root


def parts() -> tuple[str, ...]:
    """Everything that is built as an FMU: the contact, then what carries it with other starts, then its partners."""
    carriers = sorted(path.stem for path in (source_root() / "fmus").glob("evat_*.toml"))
    return (CONTACT, *(part for part in carriers if part != CONTACT), *machine.names())


def fmu_facts_of(part: str = CONTACT) -> FmuFacts:
    """What the FMU shows beside its model's tables."""
    if part not in parts():
        raise BuildError(f"there is no part {part!r}; allowed are {', '.join(parts())}.")
    return load(source_root() / "fmus" / f"{part}.toml")


def every_variable(model: str) -> tuple[Variable, ...]:
    """The table of a model, whatever an FMU shows of it."""
    return kernel.variables() if model == CONTACT else machine.variables(model)


def model_token(model: str) -> str:
    """The hash over the tables of a model."""
    return kernel.token() if model == CONTACT else machine.token(model)


def variants(model: str) -> tuple[FmuFacts, ...]:
    """The FMUs that carry a model; one binary serves them all."""
    return tuple(facts for facts in map(fmu_facts_of, parts()) if facts.model == model)


def token_of(version: Version, fmu_facts: FmuFacts) -> str:
    """The GUID or instantiationToken of one file: it changes with the model's tables, and with what the FMU makes of them."""
    shown = [fmu_facts.shown, fmu_facts.connected]
    identity = [fmu_facts.model_name, version, sorted(fmu_facts.start.items()), *shown, model_token(fmu_facts.model)]
    return f"{{{uuid.UUID(bytes=hashlib.sha256(json.dumps(identity).encode()).digest()[:16])}}}"


def shown_variables(fmu_facts: FmuFacts) -> tuple[Variable, ...]:
    """The table as the FMU shows it, with its own starts and places.

    Raises BuildError for a name that is not in the table, for one that is connected and no output, and where a state is shown without its
    rate, or no time.
    """
    every = every_variable(fmu_facts.model)
    known = {v.name for v in every}
    if unknown := [name for name in (*fmu_facts.shown, *fmu_facts.start) if name not in known]:
        raise BuildError(f"fmus/{fmu_facts.part}.toml: {', '.join(unknown)}: there is no such variable. Correct the file.")
    outputs = {v.name for v in every if v.causality == "output"}
    if unknown := [name for name in fmu_facts.connected if name not in outputs]:
        raise BuildError(f"fmus/{fmu_facts.part}.toml: {', '.join(unknown)}: there is no such output. Correct the file.")
    inside = outputs.difference(fmu_facts.connected) if fmu_facts.connected else set()
    shown = set(fmu_facts.shown) or known
    rates = {v.derivative_of: v.name for v in every if v.derivative_of}
    if missing := [name for name in ("time", *(rates[name] for name in shown & rates.keys())) if name not in shown]:
        raise BuildError(f"fmus/{fmu_facts.part}.toml: {', '.join(missing)} must be shown, too. Add it.")
    rows = [v for v in every if v.name in shown]
    return tuple(
        replace(
            v,
            index=place,
            start=v.check(fmu_facts.start[v.name]) if v.name in fmu_facts.start else v.start,
            derivative_of=v.derivative_of if v.derivative_of in shown else None,
            causality="local" if v.name in inside else v.causality,
        )
        for place, v in enumerate(rows)
    )


@dataclass(frozen=True, slots=True)
class PartModel:
    """What one FMU says of its model, and what is made of that."""

    variables: tuple[Variable, ...]
    states: tuple[str, ...]
    laws: tuple[Law, ...]
    structure: Callable[[], Structure]
    documentation: Callable[[FmuFacts], Mapping[str, bytes]]
    icon: Callable[[], Picture]
    follow: Follow


def _follow(one: kernel.Contact | machine.Machine, times: FloatArray, names: Sequence[str], inputs: Mapping[str, FloatArray]) -> FloatArray:
    """See `reference_files`."""
    for name, column in inputs.items():
        one.set(name, column[0])
    one.start(float(times[0]))
    if not inputs:
        return one.run(times, {}, names)
    rows = [[one.get(name) for name in names]]
    for place, step in enumerate(np.diff(times)):
        for name, column in inputs.items():
            one.set(name, column[place])
        one.advance(float(step))
        rows.append([one.get(name) for name in names])
    return np.array(rows)


def _contact(facts: FmuFacts) -> PartModel:
    variables = shown_variables(facts)

    return PartModel(
        variables,
        tuple(name for name in kernel.states() if name in {v.name for v in variables}),
        kernel.laws(),
        lambda: restricted(model_structure(), variables),
        lambda fmu_facts: documentation.documentation_files(fmu_facts, variables),
        lambda: picture.icon({v.name for v in variables}),
        lambda times, names, inputs: _follow(kernel.Contact(facts.start), times, names, inputs),
    )


def _partner(part: str) -> PartModel:
    return PartModel(
        machine.variables(part),
        machine.states(part),
        (),
        lambda: machine_structure(part),
        lambda fmu_facts: machine_documentation.documentation_files(fmu_facts, part),
        lambda: picture.block(part, machine.variables(part)),
        lambda times, names, inputs: _follow(machine.Machine(part), times, names, inputs),
    )


@lru_cache
def model_of(part: str) -> PartModel:
    """The model of the FMU `part`, with the starts that it has there."""
    fmu_facts = fmu_facts_of(part)
    return _contact(fmu_facts) if fmu_facts.model == CONTACT else _partner(part)
