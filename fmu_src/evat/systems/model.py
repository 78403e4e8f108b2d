"""Which words do the systems share? Components, their connectors, connections, and the bonds through which power flows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from evat.model import EvatError, SimulationError, Trace


class SspError(EvatError):
    """A system that cannot be read, built or coupled.

    Examples
    --------
    >>> import evat
    >>> try:
    ...     evat.run_system("stick_slip", {"spindle": {"speed_set": 25.0}})
    ... except evat.SspError as error:
    ...     print(error)
    there is no component 'spindle'; there are path, guideway, drive.
    """


class SystemStopped(SimulationError):
    """A system that a component stopped in mid-run; `trace` holds the results until then."""

    def __init__(self, text: str, trace: Trace) -> None:
        super().__init__(text)
        self.trace = trace


class SystemInterrupted(KeyboardInterrupt):
    """A system that Ctrl-C stopped in mid-run; `trace` holds the results until then."""

    def __init__(self, trace: Trace) -> None:
        super().__init__()
        self.trace = trace


Port = tuple[str, str]  # component, variable


def port(text: str, where: str) -> Port:
    """The two parts of "component.variable"."""
    component, dot, variable = text.partition(".")
    if not dot or not component or not variable:
        raise SspError(f"{where}: {text!r} is no COMPONENT.VARIABLE.")
    return component, variable


@dataclass(frozen=True, slots=True)
class Connector:
    """A variable of a component that the system shows. One that neither FMU nor system gives a unit has that of what it is joined to."""

    name: str
    kind: str  # input or output
    unit: str
    has_unit: bool = True


@dataclass(frozen=True, slots=True)
class Component:
    """One FMU of a system: where it lies, what it shows, and the values it is given; the set's `values` are as the .ssv has them."""

    name: str
    source: Path
    connectors: dict[str, Connector]
    values: Mapping[str, float | str | bool] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Bond:
    """A force and a velocity that go opposite ways between the same two components: their product is a power, which the side of the force
    gives; where the force acts `against` the motion, as friction does, that of the velocity."""

    force: Port
    velocity: Port
    against: bool = False


@dataclass(frozen=True, slots=True)
class System:
    """What is coupled: `connections` from each input to the output that feeds it."""

    name: str
    title: str
    components: Mapping[str, Component]
    connections: Mapping[Port, Port]
    bonds: tuple[Bond, ...]
    start_time: float
    stop_time: float
    step: float | None
    every: int = 1
    notes: tuple[str, ...] = ()  # what was taken for granted
    day: str = ""  # when it was made, as its archive says
