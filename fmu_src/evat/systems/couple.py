"""How do the components of a system go through time together? Communication steps, inputs continued or interpolated, power watched.

In each step the components move one after the other (Gauss-Seidel) or all from the same values (Jacobi). The input of a component whose
source has moved already is interpolated over the step; any other is continued, as a constant or along its last slope. At the end of the
step all inputs are set to what their sources show, and outputs that follow them at once are read anew.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from evat.model import FloatArray, FmuError, ParameterError, SimulationError, Trace, nearest
from evat.models.drive import Driver
from evat.systems.model import Component, Port, SspError, System, SystemInterrupted, SystemStopped
from evat.systems.power import Power

Order = Literal["gauss-seidel", "jacobi"]
Inputs = Literal["linear", "constant"]
Values = Mapping[str, Mapping[str, float | str | bool]]
Progress = Callable[[float], None]

START_PASSES = 20  # over all components, until what they show at the start no longer changes
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

    def time(self, n: int) -> float:
        """End of the n-th step [s]."""
        return self.stop if n == self.count else self.start + n * self.step


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
    if not (0 < planned.step < np.inf and planned.start < planned.stop < np.inf and planned.every >= 1):
        raise ParameterError(
            f"step {planned.step:g} s, from {planned.start:g} to {planned.stop:g} s, every {planned.every}: a step above 0, a stop after "
            "the start and a whole number from 1 are needed."
        )
    if (planned.stop - planned.start) / planned.step > MOST_STEPS:
        raise ParameterError(
            f"steps of {planned.step:g} s from {planned.start:g} to {planned.stop:g} s are more than {MOST_STEPS:g}; take longer steps, or "
            "stop earlier."
        )
    if planned.count / planned.every > MOST_ROWS:
        raise ParameterError(f"{planned.count} steps, each {planned.every}. kept: more than {MOST_ROWS} rows; keep fewer (--every).")
    return planned


@dataclass(frozen=True, slots=True)
class Given:
    """Inputs that a record drives: ports, sample times [s], values of shape (samples, ports); held beyond its ends."""

    ports: tuple[Port, ...]
    times: FloatArray
    table: FloatArray

    def at(self, time: float) -> FloatArray:
        return np.array([np.interp(time, self.times, column) for column in self.table.T])


NO_INPUTS = Given((), np.zeros(1), np.zeros((1, 0)))


class Member:
    """A component at work: where its inputs and outputs stand among all signals."""

    def __init__(self, component: Component, driver: Driver, sources: Mapping[str, int], outputs: Mapping[str, int]) -> None:
        self.name, self.driver = component.name, driver
        self.inputs, self.outputs = list(sources), list(outputs)
        self.source = np.array(list(sources.values()), dtype=np.intp)
        self.place = np.array(list(outputs.values()), dtype=np.intp)
        self.row = np.empty(len(outputs))

    def show(self, doing: str, signals: FloatArray) -> None:
        """Read the outputs into the signals."""
        if self.row.size:
            self.driver.get(doing, self.row)
            if not np.all(np.isfinite(self.row)):
                name = self.outputs[int(np.argmin(np.isfinite(self.row)))]
                raise SimulationError(f"{name} is {self.row[self.outputs.index(name)]}, which is no finite number")
            signals[self.place] = self.row


class Coupled:
    """A system between `with` and its end."""

    def __init__(self, system: System, values: Values | None = None, given: Given = NO_INPUTS) -> None:
        self.system, self.given, given_values = system, given, values or {}
        for name in given_values:
            if name not in system.components:
                raise SspError(f"there is no component {name!r}; {nearest(name, system.components)}")
        self.values = {name: {**component.values, **given_values.get(name, {})} for name, component in system.components.items()}
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

    def __enter__(self) -> Coupled:
        try:
            self.members = [self._member(component) for component in self.system.components.values()]
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _member(self, component: Component) -> Member:
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
        return Member(component, driver, feeds, shows)

    def run(self, plan: Plan, progress: Progress | None = None) -> tuple[Trace, Power]:
        """Go through the plan: what the components showed, and how the power at the bonds came out.

        Raises
        ------
        SystemStopped with the results so far, where a component fails.
        """
        y, rows, times = np.zeros(len(self.signals)), [], []
        power, doing = Power(self.system, self.signals), ("the start", plan.start)
        kept = 0
        try:
            for member in self.members:
                with _failing(member):
                    member.driver.prepare(member.inputs, member.outputs, plan.start, plan.stop)
            self._settle(y, plan.start)
            rows.append(y[: self._from_record].copy())
            times.append(plan.start)
            slope = np.zeros_like(y)
            for n in range(1, plan.count + 1):
                doing = ("the step", plan.time(n - 1))
                before = y.copy()
                self._step(plan, n, y, slope, power)
                if plan.inputs == "linear":
                    slope = (y - before) / (plan.time(n) - plan.time(n - 1))
                if n % plan.every == 0 or n == plan.count:
                    times.append(plan.time(n))
                    rows.append(y[: self._from_record].copy())
                kept = n
                if progress is not None and n % 512 == 0:
                    progress(n / plan.count)
        except _Failed as failed:
            trace = self._trace(times, rows, plan)
            raise SystemStopped(
                f"component {failed.member} failed in {doing[0]} at t = {doing[1]:.9g} s, after {kept} of {plan.count} steps: {failed}",
                trace,
            ) from failed
        except KeyboardInterrupt:
            raise SystemInterrupted(self._trace(times[: len(rows)], rows[: len(times)], plan)) from None
        for member in self.members:
            member.driver.end()
        return self._trace(times, rows, plan), power

    def _settle(self, y: FloatArray, time: float) -> None:
        """What all show at the start: inputs from outputs until nothing changes."""
        y[self._from_record :] = self.given.at(time)
        for _ in range(START_PASSES):
            before = y.copy()
            for member in self.members:
                with _failing(member):
                    member.driver.set("first inputs", y[member.source])
                    member.show("first outputs", y)
            if np.array_equal(before, y):
                break
        for member in self.members:
            with _failing(member):
                member.driver.begin()
                member.show("first outputs", y)

    def _step(self, plan: Plan, n: int, y: FloatArray, slope: FloatArray, power: Power) -> None:
        start, end = plan.time(n - 1), plan.time(n)
        step, doing = end - start, f"step to t = {end:.9g} s"
        given = self.given.at(end)
        guess = y + step * slope  # what a source that has not moved yet is taken to show at the end
        guess[self._from_record :] = given
        then = guess.copy()
        power.open(y)
        for member in self.members:
            now, ahead = y[member.source], (then if plan.order == "gauss-seidel" else guess)[member.source]
            with _failing(member):
                member.driver.step(doing, start, step, now, ahead)
                member.show(doing, then)
            power.moved(member.name, ahead, then)
        power.close(step)
        y[:] = then
        for member in self.members:  # inputs as they have turned out
            if member.inputs:
                with _failing(member):
                    member.driver.set(doing, y[member.source])
                    member.show(doing, y)

    def _trace(self, times: Sequence[float], rows: Sequence[FloatArray], plan: Plan) -> Trace:
        table = np.array(rows).reshape(len(rows), self._from_record)
        names = [at for at, place in self.signals.items() if place < self._from_record]
        units = {".".join(at): self.system.components[at[0]].connectors[at[1]].unit for at in names}
        columns = {".".join(at): table[:, place].copy() for place, at in enumerate(names)}
        about: dict[str, str | float] = {"system": self.system.name, "step": plan.step, "order": plan.order, "inputs": plan.inputs}
        about |= {"notes": "; ".join(self.notes)} if self.notes else {}
        return Trace(np.array(times), columns, units, about)


class _Failed(Exception):
    """A member could not go on."""

    def __init__(self, member: str, text: str) -> None:
        super().__init__(text)
        self.member = member


class _failing:
    """Says which member it was."""

    def __init__(self, member: Member) -> None:
        self._member = member

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, SimulationError):
            raise _Failed(self._member.name, str(error)) from error


def run_file(
    path: Path,
    folder: Path,
    values: Values | None = None,
    given: Given = NO_INPUTS,
    progress: Progress | None = None,
    **wishes: object,
) -> tuple[Trace, Power]:
    """Read an .ssp into `folder` and run it; `wishes` as `plan` takes them."""
    from evat.systems.read import read

    system = read(path, folder)
    with Coupled(system, values, given) as coupled:
        return coupled.run(plan(system, **wishes), progress)  # type: ignore[arg-type]
