"""How do the components of a system go through time together? What is connected to what, how it starts, what is kept when it stops.

The steps themselves, in which inputs are continued or interpolated and power is watched, are compiled: fmu_src/coupling/coupling.h.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from evat.model import FloatArray, FmuError, ParameterError, SimulationError, Trace, nearest
from evat.models.drive import Driver, only_once
from evat.native.coupling import CallFailed, Coupling, Ends, NotFinite, NotSettled
from evat.systems.model import Bond, Component, Port, SspError, System, SystemInterrupted, SystemStopped
from evat.systems.power import Power

Order = Literal["gauss-seidel", "jacobi"]
Inputs = Literal["linear", "constant"]
Values = Mapping[str, Mapping[str, float | str | bool]]
Progress = Callable[[float], None]

MOST_ROWS = 20_000_000
MOST_STEPS = 1e12  # weeks of them


@dataclass(frozen=True, slots=True)
class Plan:
    """How to couple: the communication step [s], what is kept of it, and how inputs go on."""

    step: float
    start: float
    stop: float
    every: int = 1
    order: Order = "gauss-seidel"
    inputs: Inputs = "linear"

    @property
    def count(self) -> int:
        """Steps in all; the last one may be shorter."""
        return max(1, int(np.ceil((self.stop - self.start) / self.step * (1 - 1e-9))))

    @property
    def longest(self) -> float:
        """The longest step that is made [s]: that of the plan, unless the run is shorter."""
        return min(self.step, self.stop - self.start)

    def ends(self, steps: NDArray[np.int64]) -> FloatArray:
        """Ends of these steps, counted from 1 [s]; of 0 the start."""
        return np.where(steps == self.count, self.stop, self.start + steps * self.step)

    def between(self, n: int, m: int) -> FloatArray:
        """Ends of the n-th to the m-th step [s]."""
        return self.ends(np.arange(n, m + 1))

    def time(self, n: int) -> float:
        """End of the n-th step [s]."""
        return float(self.ends(np.array([n]))[0])

    @property
    def middle(self) -> float:
        """Where the half begins over which means are taken [s]."""
        return 0.5 * (self.start + self.stop)


def plan(
    system: System,
    step: float | None = None,
    stop: float | None = None,
    every: int | None = None,
    order: Order = "gauss-seidel",
    inputs: Inputs = "linear",
) -> Plan:
    """The plan of a run: what is not given is as the system says."""
    step = step if step is not None else system.step
    planned = Plan(
        step if step is not None else (system.stop_time - system.start_time) / 1000,
        system.start_time,
        stop if stop is not None else system.stop_time,
        every if every is not None else system.every,
        order,
        inputs,
    )
    for name, wish, allowed in (("order", order, get_args(Order)), ("inputs", inputs, get_args(Inputs))):
        if wish not in allowed:
            raise ParameterError(f"{name} = {wish!r}: allowed are {' and '.join(map(repr, allowed))}.")
    whole = 1 <= planned.every <= MOST_STEPS and planned.every == planned.every // 1
    if not (0 < planned.step < np.inf and planned.start < planned.stop < np.inf and whole):
        raise ParameterError(
            f"step {planned.step:g} s, from {planned.start:g} to {planned.stop:g} s, every {planned.every:.9g}: a step above 0, a stop "
            f"after the start and a whole number from 1 to {MOST_STEPS:g} are needed."
        )
    if (planned.stop - planned.start) / planned.step > MOST_STEPS:
        raise ParameterError(
            f"steps of {planned.step:g} s from {planned.start:g} to {planned.stop:g} s are more than {MOST_STEPS:g}; take longer steps, or "
            "stop earlier."
        )
    if planned.count / planned.every > MOST_ROWS:
        raise ParameterError(f"{planned.count} steps with every = {planned.every} give more than {MOST_ROWS} rows; keep fewer (--every).")
    return replace(planned, every=int(planned.every))


@dataclass(frozen=True, slots=True)
class Given:
    """Inputs that a record drives: ports, sample times [s], values of shape (samples, ports); held beyond its ends."""

    ports: tuple[Port, ...]
    times: FloatArray
    table: FloatArray

    def beyond(self, plan: Plan) -> tuple[str, ...]:
        """What is to be told of parts of a run that the record does not cover.

        Raises
        ------
        SspError, where it covers nothing of it.
        """
        if not self.ports:
            return ()
        names, first, last = ", ".join(map(".".join, self.ports)), float(self.times[0]), float(self.times[-1])
        if last < plan.start or first > plan.stop:
            raise SspError(
                f"the record of {names} is from {first:g} to {last:g} s, the run from {plan.start:g} to {plan.stop:g} s: give one that "
                "covers the run."
            )
        late = (f"the record of {names} begins at {first:g} s: until then its first values are held",) if first > plan.start else ()
        ends = last < plan.stop * (1 - 1e-9)
        return (*late, f"the record of {names} ends at {last:g} s: from there on its last values are held") if ends else late

    def at(self, times: FloatArray) -> FloatArray:
        """Values at these times, of shape (times, ports)."""
        return np.array([np.interp(times, self.times, column) for column in self.table.T]).reshape(-1, times.size).T


NO_INPUTS = Given((), np.zeros(1), np.zeros((1, 0)))


@dataclass(frozen=True, slots=True)
class SystemMember:
    """A component at work: where its inputs and outputs stand among all signals."""

    name: str
    driver: Driver
    sources: Mapping[str, int]
    places: Mapping[str, int]


class Coupled:
    """A system between `with` and its end."""

    def __init__(self, system: System, values: Values | None = None, given: Given = NO_INPUTS) -> None:
        self.system, self.given, given_values = system, given, values or {}
        for name in given_values:
            if name not in system.components:
                raise SspError(f"there is no component {name!r}; {nearest(name, system.components)}")
        self.values = {name: {**component.values, **given_values.get(name, {})} for name, component in system.components.items()}
        self._check_values(given_values)
        self._check_instances()
        self._stack = ExitStack()
        self.signals: dict[Port, int] = {}
        for name, component in system.components.items():
            for connector in component.connectors.values():
                if connector.kind == "output":
                    self.signals[name, connector.name] = len(self.signals)
        self._from_record = len(self.signals)
        for at in given.ports:
            if at in system.connections:
                raise SspError(f"the input {'.'.join(at)} is fed by {'.'.join(system.connections[at])}; a record cannot drive it.")
            self.signals[at] = len(self.signals)
        unfed = (
            (name, connector.name)
            for name, component in system.components.items()
            for connector in component.connectors.values()
            if connector.kind == "input" and connector.name not in self.values[name]
        )
        self.notes = (
            *system.notes,
            *(
                f"nothing feeds {'.'.join(at)}: it stays as it starts; give it as an input (--input FILE), or a value"
                for at in unfed
                if at not in system.connections and at not in given.ports
            ),
        )

    def _check_values(self, values: Values) -> None:
        """A value of what is fed would change nothing."""
        for at in ((component, name) for component, of_component in values.items() for name in of_component):
            source = (
                ".".join(self.system.connections[at]) if at in self.system.connections else "the record" if at in self.given.ports else ""
            )
            if source:
                raise SspError(f"{'.'.join(at)} is fed by {source}; a value for it would change nothing. Leave it out.")

    def _check_instances(self) -> None:
        once = dict[str, str]()
        for name, component in self.system.components.items():
            about = only_once(component.source)
            if about is not None and about in once:
                raise SspError(f"components {once[about]} and {name} are one FMU, which says that it can be there only once in a process.")
            if about is not None:
                once[about] = name

    def __enter__(self) -> Coupled:
        try:
            self.members = [self._member(component) for component in self.system.components.values()]
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _member(self, component: Component) -> SystemMember:
        try:
            driver = self._stack.enter_context(Driver(component.source, self.values[component.name], name=component.name))
        except (FmuError, ParameterError, SimulationError) as error:
            raise type(error)(f"component {component.name}: {error}") from error
        feeds = {to[1]: self.signals[at] for to, at in self.system.connections.items() if to[0] == component.name}
        feeds |= {at[1]: self.signals[at] for at in self.given.ports if at[0] == component.name}
        if unknown := [name for name in feeds if name not in driver.variables or driver.variables[name].causality != "input"]:
            raise SspError(f"component {component.name} has no input {unknown[0]!r}.")
        if wrong := [name for name in feeds if driver.variables[name].type not in ("Real", "Float64")]:
            raise SspError(
                f"component {component.name}: {wrong[0]} is of type {driver.variables[wrong[0]].type}; only real inputs are coupled."
            )
        shows = {at[1]: place for at, place in self.signals.items() if at[0] == component.name and place < self._from_record}
        return SystemMember(component.name, driver, feeds, shows)

    def run(self, plan: Plan, progress: Progress | None = None) -> tuple[Trace, Power]:
        """Go through the plan: what the components showed, and how the power at the bonds came out.

        Raises
        ------
        SystemStopped with the results so far, where a component fails; SystemInterrupted with them at Ctrl-C; SspError where a record
        covers nothing of the plan, ParameterError where a component takes no shorter last step.
        """
        self._check_last_step(plan)
        self.given.beyond(plan)
        loop, table = None, np.empty((self._from_record, 1 + -(-plan.count // plan.every)))
        try:
            loop = self._started(plan)
            try:
                loop.run(table, plan.count, plan.every, plan.between, self.given.at, progress, plan.middle)
            except (CallFailed, NotFinite, NotSettled) as failed:
                raise self._failed(f"step to t = {plan.time(loop.steps + 1):.9g} s", failed) from failed
        except _Failed as failed:
            done, where = (0, "the start") if loop is None else (loop.steps, "the step")
            who = "the system" if failed.member is None else f"component {failed.member}"
            raise SystemStopped(
                f"{who} failed in {where} at t = {plan.time(done):.9g} s, after {done} of {plan.count} steps: {failed}",
                self._trace(plan, table, loop),
            ) from failed
        except KeyboardInterrupt:
            raise SystemInterrupted(self._trace(plan, table, loop)) from None
        for member in self.members:
            member.driver.end()
        names = [".".join(bond.force) for bond in self.system.bonds]
        return self._trace(plan, table, loop), Power(dict(zip(names, loop.powers(), strict=True)))

    def _check_last_step(self, plan: Plan) -> None:
        if abs(plan.count * plan.step / (plan.stop - plan.start) - 1) < 1e-9:
            return
        fixed = [m.name for m in self.members if not m.driver.description.coSimulation.canHandleVariableCommunicationStepSize]
        if fixed:
            raise ParameterError(
                f"the last of {plan.count} steps of {plan.step:g} s from {plan.start:g} to {plan.stop:g} s is shorter, and component "
                f"{fixed[0]} takes no other step: stop at a whole number of steps."
            )

    def _started(self, plan: Plan) -> Coupling:
        """All members at the start, with what they show there."""
        for member in self.members:
            with _failing(member):
                member.driver.prepare(list(member.sources), list(member.places), plan.start, plan.stop)
        loop = Coupling(
            [member.driver.member for member in self.members],
            [list(member.sources.values()) for member in self.members],
            [list(member.places.values()) for member in self.members],
            len(self.given.ports),
            bonds=[self._bond(bond) for bond in self.system.bonds],
            jacobi=plan.order == "jacobi",
            continued=plan.inputs == "linear",
        )
        loop.signals[self._from_record :] = self.given.at(np.array([plan.start]))[0]
        try:
            for n, member in enumerate(self.members):
                doing = "first inputs"
                for name, place in member.sources.items():
                    if self._shown_after(place, n):
                        loop.signals[place] = member.driver.start_of(name)
                loop.set(n)
                doing = "first outputs"
                loop.show(n)
            loop.settle()
            for n, member in enumerate(self.members):
                with _failing(member):
                    member.driver.begin()
                loop.show(n)
            loop.settle()
        except (CallFailed, NotFinite, NotSettled) as failed:
            raise self._failed(doing, failed) from failed
        return loop

    def _shown_after(self, place: int, n: int) -> bool:
        """Whether the n-th member or a later one shows this signal: until then an input keeps its own start, where 0 may be none."""
        return any(place in member.places.values() for member in self.members[n:])

    def _bond(self, bond: Bond) -> Ends:
        names = [member.name for member in self.members]
        sides = names.index(bond.force[0]), names.index(bond.velocity[0])
        return Ends(self.signals[bond.force], self.signals[bond.velocity], *sides, bond.against)

    def _failed(self, doing: str, failed: CallFailed | NotFinite | NotSettled) -> _Failed:
        if isinstance(failed, NotSettled):
            name = next(".".join(at) for at, place in self.signals.items() if place == failed.signal)
            return _Failed(
                None,
                "outputs that follow inputs at once feed one another in a loop, and do not settle: "
                f"{name} came to {failed.value:.6g}. Give one of them a state between input and output, such as a mass or a filter.",
            )
        member = self.members[failed.member]
        return _Failed(member.name, str(member.driver.failure(doing, failed)))

    def _trace(self, plan: Plan, table: FloatArray, loop: Coupling | None) -> Trace:
        kept = 0 if loop is None else loop.kept
        names = [at for at, place in self.signals.items() if place < self._from_record]
        units = {".".join(at): self.system.components[at[0]].connectors[at[1]].unit for at in names}
        columns = {".".join(at): table[place, :kept] for place, at in enumerate(names)}
        about: dict[str, str | float | Mapping[str, float | str]] = {
            "system": self.system.name,
            "step": plan.longest,
            "order": plan.order,
            "inputs": plan.inputs,
        }
        notes = (*self.notes, *self.given.beyond(plan))
        about |= {"notes": "; ".join(notes)} if notes else {}
        if loop is not None and loop.steps == plan.count:
            about[MEANS] = {".".join(at): float(mean) for at, mean in zip(names, loop.means(), strict=True)}
        return Trace(plan.ends(np.minimum(np.arange(kept) * plan.every, plan.count)), columns, units, about)


MEANS = "mean_of_last_half"


def means_of_last_half(trace: Trace) -> Mapping[str, float]:
    """Of each output over all steps of the last half of a run, kept or not: rows that are kept may lie at the same places of each cycle."""
    means = trace.made_by[MEANS]
    assert isinstance(means, Mapping)
    return {name: float(mean) for name, mean in means.items()}


class _Failed(Exception):
    """A member could not go on; None: the system."""

    def __init__(self, member: str | None, text: str) -> None:
        super().__init__(text)
        self.member = member


@contextmanager
def _failing(member: SystemMember) -> Iterator[None]:
    """Says which member it was."""
    try:
        yield
    except (ParameterError, SimulationError) as error:
        raise _Failed(member.name, str(error)) from error


def run_file(
    path: Path,
    folder: Path,
    values: Values | None = None,
    given: Given = NO_INPUTS,
    progress: Progress | None = None,
    **wishes: object,
) -> tuple[Trace, Power]:
    """Read an .ssp into `folder` and run it; `wishes` as `plan` takes them."""
    from evat.systems.ssp.read import read

    system = read(path, folder)
    with Coupled(system, values, given) as coupled:
        return coupled.run(plan(system, **wishes), progress)  # type: ignore[arg-type]
