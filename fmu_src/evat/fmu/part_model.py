"""What do the builders ask of a model, be it the contact or a partner? The one place that tells them apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from evat.fmu.documentation import contact as documentation
from evat.fmu.documentation import partner as machine_documentation
from evat.fmu.documentation import picture
from evat.fmu.documentation.picture import Picture
from evat.fmu.fmu_facts import FmuFacts, load
from evat.fmu.reference_results import Follow
from evat.fmu.structure.model_structure import Structure, model_structure
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


@dataclass(frozen=True, slots=True)
class PartModel:
    """What one model says of itself, and what is made of that."""

    token: str
    variables: tuple[Variable, ...]
    states: tuple[str, ...]
    laws: tuple[Law, ...]
    structure: Callable[[], Structure]
    documentation: Callable[[FmuFacts], Mapping[str, bytes]]
    icon: Callable[[], Picture]
    follow: Follow


def _contact(start: Mapping[str, float | str]) -> PartModel:
    variables = tuple(replace(v, start=v.check(start[v.name])) if v.name in start else v for v in kernel.variables())

    def follow(times: FloatArray, names: Sequence[str]) -> FloatArray:
        contact = kernel.Contact(start)
        contact.start(float(times[0]))
        return contact.run(times, {}, names)

    return PartModel(
        kernel.token(),
        variables,
        kernel.states(),
        kernel.laws(),
        model_structure,
        lambda fmu_facts: documentation.documentation_files(fmu_facts, variables),
        picture.icon,
        follow,
    )


def _partner(part: str) -> PartModel:
    def follow(times: FloatArray, names: Sequence[str]) -> FloatArray:
        one = machine.Machine(part)
        one.start(float(times[0]))
        return one.run(times, {}, names)

    return PartModel(
        machine.token(part),
        machine.variables(part),
        machine.states(part),
        (),
        lambda: machine_structure(part),
        lambda fmu_facts: machine_documentation.documentation_files(fmu_facts, part),
        lambda: picture.block(part, machine.variables(part)),
        follow,
    )


@lru_cache
def model_of(part: str) -> PartModel:
    """The model of the FMU `part`, with the starts that it has there."""
    fmu_facts = fmu_facts_of(part)
    return _contact(fmu_facts.start) if fmu_facts.model == CONTACT else _partner(part)
