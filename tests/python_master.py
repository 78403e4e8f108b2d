"""How does a plain loop over fmpy step a system? What the compiled one (fmu_src/coupling) is held to bit by bit, and is timed beside."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from evat.model import FloatArray
from evat.systems.couple import Given, Plan
from evat.systems.model import Component, Port, System
from fmpy.simulation import apply_start_values, instantiate_fmu

MOST_PASSES = 20  # through components that hand on at once what they are given


class Part:
    """A component at work: the places of its inputs and outputs among all signals; one that does not interpolate inputs gets their mean."""

    def __init__(self, component: Component, system: System, signals: dict[Port, int], folder: Path, plan: Plan) -> None:
        about = fmpy.read_model_description(str(component.source), validate=False)
        reference = {variable.name: variable.valueReference for variable in about.modelVariables}
        fed = {at: source for at, source in system.connections.items() if at[0] == component.name}
        fed |= {at: at for at in signals if at[0] == component.name and component.connectors[at[1]].kind == "input"}
        shown = [at for at in signals if at[0] == component.name and at not in fed]
        self.name, self.inputs, self.outputs = component.name, [reference[at[1]] for at in fed], [reference[at[1]] for at in shown]
        self.sources, self.places = [signals[source] for source in fed.values()], [signals[at] for at in shown]
        self.fmu: Any = instantiate_fmu(fmpy.extract(str(component.source), str(folder / component.name)), about, "CoSimulation")
        assert not apply_start_values(self.fmu, about, component.values)
        three, times = about.fmiVersion.startswith("3"), {"startTime": plan.start, "stopTime": plan.stop}
        self._set, self._get = (self.fmu.setFloat64, self.fmu.getFloat64) if three else (self.fmu.setReal, self.fmu.getReal)
        self.interpolates = not three and about.coSimulation.canInterpolateInputs
        if not three:
            self.fmu.setupExperiment(**times)
        self.fmu.enterInitializationMode(**(times if three else {}))

    def set(self, values: FloatArray) -> None:
        if self.inputs:
            self._set(self.inputs, values)

    def show(self, signals: FloatArray) -> None:
        signals[self.places] = self._get(self.outputs)

    def step(self, time: float, step: float, now: FloatArray, then: FloatArray) -> None:
        if self.inputs and self.interpolates:
            self.fmu.setRealInputDerivatives(self.inputs, [1] * len(self.inputs), (then - now) / step)
        else:
            self.set(0.5 * (now + then))
        self.fmu.doStep(time, step)
        self.set(then)


class PythonMaster:
    """A system at its start; `run` takes it through the plan, once."""

    def __init__(self, system: System, given: Given, folder: Path, plan: Plan) -> None:
        names = [(n, c.name) for n, part in system.components.items() for c in part.connectors.values() if c.kind == "output"]
        self.shown, self.given, self.plan = len(names), given, plan
        self.signals = {at: place for place, at in enumerate([*names, *given.ports])}
        self.parts = [Part(component, system, self.signals, folder, plan) for component in system.components.values()]
        self.bonds = [(bond, self.signals[bond.force], self.signals[bond.velocity]) for bond in system.bonds]
        self.y = y = np.zeros(len(self.signals))
        y[self.shown :] = given.at(np.array([plan.start]))[0]
        self.settle()
        for part in self.parts:
            part.fmu.exitInitializationMode()
            part.show(y)
        self.settle()

    def close(self) -> None:
        for part in self.parts:
            part.fmu.freeInstance()

    def settle(self) -> None:
        """Inputs as they have turned out, until none moves."""
        for _ in range(MOST_PASSES):
            before = self.y.copy()
            for part in self.parts:
                part.set(self.y[part.sources])
                part.show(self.y)
            if np.array_equal(before, self.y):
                return

    def run(self) -> tuple[FloatArray, dict[str, FloatArray], dict[str, tuple[float, float, float]]]:
        """Times that are kept, what the components show at them, and at each bond the energy that passed, was made, and moved."""
        plan, y, slope = self.plan, self.y, np.zeros_like(self.y)
        times, rows = [plan.start], [y[: self.shown].copy()]
        energies = {".".join(bond.force): np.zeros(3) for bond, _, _ in self.bonds}
        for n in range(1, plan.count + 1):
            start, end = plan.time(n - 1), plan.time(n)
            step, before = end - start, y.copy()
            guess = before + step * slope  # what a source that has not moved yet is taken to show
            guess[self.shown :] = self.given.at(np.array([end]))[0]
            then, seen = guess.copy(), {}
            for part in self.parts:
                ahead = (then if plan.order == "gauss-seidel" else guess)[part.sources]
                part.step(start, step, before[part.sources], ahead)
                part.show(then)
                seen |= {(part.name, source): value for source, value in zip(part.sources, ahead, strict=True)}
            for bond, f, v in self.bonds:
                one = work(before[f], then[f], before[v], seen[bond.force[0], v]) * step
                other = work(before[f], seen[bond.velocity[0], f], before[v], then[v]) * step
                energies[".".join(bond.force)] += (abs(other), (one - other) if bond.against else (other - one), abs(other - one))
            y[:] = then
            self.settle()
            if plan.inputs == "linear":
                slope = (y - before) / step
            if n % plan.every == 0 or n == plan.count:
                times.append(end)
                rows.append(y[: self.shown].copy())
        columns = {".".join(at): column for at, column in zip(self.signals, np.array(rows).T, strict=False)}
        return np.array(times), columns, {name: tuple(sums.tolist()) for name, sums in energies.items()}


def work(f_0: float, f_1: float, v_0: float, v_1: float) -> float:
    """Of a force on a velocity, both linear over a step of 1 s."""
    return (2 * f_0 * v_0 + f_0 * v_1 + f_1 * v_0 + 2 * f_1 * v_1) / 6
