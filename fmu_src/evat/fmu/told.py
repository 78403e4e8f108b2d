"""What do the builders ask of a model, be it the contact or a partner? The one place that tells them apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from .. import kernel, machine
from ..compile import CONTACT
from ..model import FloatArray, Law, Variable
from . import documentation, machine_documentation, picture
from .machine_structure import machine_structure
from .picture import Picture
from .reference_results import Follow
from .shown import Shown
from .structure import Structure, model_structure


@dataclass(frozen=True, slots=True)
class Told:
    """What one model says of itself, and what is made of that."""

    token: str
    variables: tuple[Variable, ...]
    states: tuple[str, ...]
    laws: tuple[Law, ...]
    structure: Callable[[], Structure]
    documentation: Callable[[Shown], Mapping[str, bytes]]
    icon: Callable[[], Picture]
    follow: Follow


def _contact() -> Told:
    def follow(times: FloatArray, names: Sequence[str]) -> FloatArray:
        contact = kernel.Contact()
        contact.start(float(times[0]))
        return contact.run(times, {}, names)

    return Told(
        kernel.token(),
        kernel.variables(),
        kernel.states(),
        kernel.laws(),
        model_structure,
        documentation.documentation_files,
        picture.icon,
        follow,
    )


def _partner(part: str) -> Told:
    def follow(times: FloatArray, names: Sequence[str]) -> FloatArray:
        one = machine.Machine(part)
        one.start(float(times[0]))
        return one.run(times, {}, names)

    return Told(
        machine.token(part),
        machine.variables(part),
        machine.states(part),
        (),
        lambda: machine_structure(part),
        lambda shown: machine_documentation.documentation_files(shown, part),
        lambda: picture.block(part, machine.variables(part)),
        follow,
    )


@lru_cache
def told(part: str) -> Told:
    """The model of the FMU `part`."""
    return _contact() if part == CONTACT else _partner(part)
