"""How is friction identified on an axis that a motor drives? motor force = mass * acceleration + friction, around any model of friction.

A drive's record has position and motor force; speed and acceleration are taken from the position, and the friction is what is not inertia.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TypeVar

import numpy as np

from evat.model import FloatArray, Model, Run, Trace, Variable

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

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        inner, own, acceleration = self._apart(run, values)
        found = self.friction.simulate(inner, on, own)
        force = float(values.get(MASS.name, MASS.start)) * acceleration + found[FRICTION]
        return Trace(found.times, {**found.columns, FORCE.name: force}, {**found.units, FORCE.name: FORCE.unit}, found.made_by)

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        inner, own, acceleration = self._apart(run, values)
        rows = self.friction.simulate_many(inner, on, own)
        mass = np.atleast_1d(np.asarray(values.get(MASS.name, MASS.start), dtype=np.float64))
        return {**rows, FORCE.name: mass[:, None] * acceleration + rows[FRICTION]}

    def settled(self, names: Sequence[str], on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        own = {name: value for name, value in values.items() if name != MASS.name}
        return self.friction.settled(names, on, own)

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        return self.friction.cycle_time({name: value for name, value in values.items() if name != MASS.name})

    def missing_inputs(self, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str]) -> Mapping[str, Sequence[str]]:
        return self.friction.missing_inputs(on, values, given)

    @staticmethod
    def _apart(run: Run, values: Mapping[str, Value]) -> tuple[Run, dict[str, Value], FloatArray]:
        """The run and the values of the friction, and the acceleration."""
        inputs = {name: column for name, column in run.inputs.items() if name != ACCELERATION.name}
        outputs = tuple(dict.fromkeys((*(name for name in run.outputs if name != FORCE.name), FRICTION)))
        own = {name: value for name, value in values.items() if name != MASS.name}
        return Run(run.times, inputs, outputs), own, run.inputs.get(ACCELERATION.name, np.zeros_like(run.times))
