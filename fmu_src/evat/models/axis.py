"""How is friction identified on an axis that a motor drives? motor force = mass * acceleration + friction, around any model of friction.

A drive's record has position and motor force; speed and acceleration are taken from the position, and the friction is what is not inertia.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TypeVar

import numpy as np

from evat.model import FloatArray, Model, ParameterError, Rival, Run, Trace, Variable, hash_of

MASS = Variable("axis_mass", "kg", 1.0, 1e-6, 1e9, "moving mass of the axis, rotating parts included", "definition", nominal=10.0)
ACCELERATION = Variable(
    "axis_acceleration", "m/s2", 0.0, -1e9, 1e9, "acceleration of the axis, along the slip velocity", "definition",
    causality="input", variability="continuous",
)  # fmt: skip
FORCE = Variable(
    "motor_force", "N", 0.0, -1e12, 1e12, "axis_mass * axis_acceleration + what the sensor shows of the friction force", "definition",
    causality="output", variability="continuous",
)  # fmt: skip
Value = TypeVar("Value", float | str, float | str | FloatArray)
FRICTION = "measured_friction_force"


class AxisModel:
    """An axis as a Model: that of its friction, with a mass."""

    def __init__(self, friction: Model) -> None:
        self.friction = friction
        self.variables = (*friction.variables, MASS, ACCELERATION, FORCE)
        self.effects = friction.effects

    @property
    def digest(self) -> str:
        """Hash over the friction's digest and what the axis adds to it."""
        return hash_of(self.friction.digest, *map(repr, (MASS, ACCELERATION, FORCE)))

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        """Drive the axis through `run`; see evat.model.Model."""
        inertia = _inertia(run, values)
        trace = self.friction.simulate(_inner(run), on, _inner_values(values))
        columns, units = {**trace.columns}, {**trace.units}
        if not run.outputs or FORCE.name in run.outputs:
            columns[FORCE.name] = inertia[0] + trace[FRICTION]
            units[FORCE.name] = FORCE.unit
        return Trace(trace.times, columns, units, {**trace.made_by, "model": self.digest, "values": dict(values)})

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """K value sets through one run; see evat.model.Model."""
        inertia = _inertia(run, values)
        rows = self.friction.simulate_many(_inner(run), on, _inner_values(values))
        return _whole(rows, inertia, FORCE.name in run.outputs)

    def settled(self, names: Sequence[str], on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """Of the friction, and the motor force where the acceleration stays as `values` have it; see evat.model.Model."""
        inner = tuple(dict.fromkeys(FRICTION if name == FORCE.name else name for name in names))
        inertia = _inertia(Run(np.zeros(1)), values)[:, 0]
        return _whole(self.friction.settled(inner, on, _inner_values(values)), inertia, FORCE.name in names)

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        return self.friction.cycle_time(_inner_values(values))

    def rival_laws(self, values: Mapping[str, float | str]) -> Sequence[Rival]:
        """Those of the friction."""
        return self.friction.rival_laws(_inner_values(values))

    def missing_inputs(self, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str]) -> Mapping[str, Sequence[str]]:
        return self.friction.missing_inputs(on, _inner_values(values), given)


def _inertia(run: Run, values: Mapping[str, float | str | FloatArray]) -> FloatArray:
    """Mass times acceleration (K or 1, n or 1) [N]; ParameterError where one of them is out of its bounds."""
    factors = []
    for variable in (MASS, ACCELERATION):
        held = values.get(variable.name, variable.start)
        column = np.asarray(variable.check(held) if isinstance(held, str) else held, dtype=np.float64)
        if column.ndim > 1:
            raise ParameterError(f"{variable.name}: one number for each set is needed, this has the shape {column.shape}.")
        factors.append(np.atleast_1d(column)[:, None])
    if ACCELERATION.name in run.inputs:
        factors[1] = np.atleast_2d(np.asarray(run.inputs[ACCELERATION.name], dtype=np.float64))
        if factors[1].shape[1:] != run.times.shape:
            raise ParameterError(f"{ACCELERATION.name} has {factors[1].shape[-1]} samples, the clock has {run.times.size}.")
    for variable, column in zip((MASS, ACCELERATION), factors, strict=True):
        for bad in column[~((column >= variable.min) & (column <= variable.max))][:1]:
            variable.check(float(bad))
    _count(*(column.shape[0] for column in factors))
    return factors[0] * factors[1]


def _inner(run: Run) -> Run:
    """The run of the friction alone."""
    inputs = {name: column for name, column in run.inputs.items() if name != ACCELERATION.name}
    outputs = (*(name for name in run.outputs if name != FORCE.name), *([FRICTION] if FORCE.name in run.outputs else []))
    return Run(run.times, inputs, tuple(dict.fromkeys(outputs)))


def _inner_values(values: Mapping[str, Value]) -> dict[str, Value]:
    """Those of the friction alone."""
    return {name: value for name, value in values.items() if name not in (MASS.name, ACCELERATION.name)}


def _whole(rows: Mapping[str, FloatArray], inertia: FloatArray, force: bool) -> Mapping[str, FloatArray]:
    """Rows of all K sets, with the motor force where it is wanted: also where only mass or acceleration differ from set to set."""
    count = _count(inertia.shape[0], *(row.shape[0] for row in rows.values()))
    whole = {**rows, FORCE.name: inertia + rows[FRICTION]} if force else rows
    return {name: np.broadcast_to(row, (count, *row.shape[1:])) for name, row in whole.items()}


def _count(*sizes: int) -> int:
    """How many sets there are, where one stands for any number; ParameterError where they are not equally many."""
    several = set(sizes) - {1}
    if len(several) > 1:
        raise ParameterError(f"values vary over different numbers of sets: {', '.join(map(str, sorted(several)))}.")
    return several.pop() if several else 1
