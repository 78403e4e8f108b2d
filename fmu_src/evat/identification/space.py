"""Which numbers are free, within which bounds, and how do they lie in the unit cube in which all searches run?

A positive parameter whose bounds are far apart is searched by its logarithm: from 1e4 to 1e6 N/m each decade counts alike.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.inference.parameters import Parameter
from evat.model import FloatArray, ParameterError, Tables, Variable, near_names, nearest

REACH = 20.0  # bounds that nobody gave: the nominal value over this, and times this
DECADES = 3.0  # a ratio of the bounds beyond which the logarithm is searched


@dataclass(frozen=True, slots=True)
class Free:
    """A free parameter: its variable, what the nominal model has for it, and bounds (SI)."""

    variable: Variable
    start: float
    low: float
    high: float

    @property
    def name(self) -> str:
        return self.variable.name

    @property
    def log(self) -> bool:
        return self.low > 0 and self.high > DECADES * self.low

    @property
    def coordinate(self) -> Parameter:
        """The unit interval: its ends are the bounds."""
        width = math.log(self.high / self.low) if self.log else self.high - self.low
        return Parameter(self.name, self.variable.unit, self.low, width, self.low, self.high, self.log)

    def value(self, u: float) -> float:
        """From the unit interval; never beyond the bounds by a rounding error."""
        return self.coordinate.value(u)

    def values(self, u: FloatArray) -> FloatArray:
        """Number by number: numpy's powers differ in the last bit with an array's length, and a set must not change with its neighbours."""
        return np.array([self.value(float(one)) for one in u])

    def place(self, value: float) -> float:
        """Into the unit interval."""
        return self.coordinate.place(min(max(value, self.low), self.high))

    def slope(self, u: float) -> float:
        """d value / d u."""
        return self.coordinate.slope(u)

    def scale(self, value: float) -> float:
        """How large a change from a value is one of the parameter, of which a small share is a step of its slope: that of its usual
        magnitudes, and no more than its bounds are apart. These may be as far apart as one likes."""
        return abs(value) if self.log else min(self.high - self.low, max(abs(value), abs(self.start), self.variable.nominal))


@dataclass(frozen=True, slots=True)
class Space:
    """The free parameters, in the order in which they were asked for."""

    free: tuple[Free, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(one.name for one in self.free)

    @property
    def start(self) -> FloatArray:
        return np.array([one.place(one.start) for one in self.free])

    def values(self, points: FloatArray) -> dict[str, FloatArray]:
        """Points of the cube, (K, p), as values by name, each (K,)."""
        return {one.name: one.values(points[:, place]) for place, one in enumerate(self.free)}

    def at(self, point: FloatArray) -> dict[str, float]:
        """One point of the cube, (p,), as values."""
        return {one.name: one.value(float(u)) for one, u in zip(self.free, point, strict=True)}

    def slopes(self, point: FloatArray) -> FloatArray:
        return np.array([one.slope(float(u)) for one, u in zip(self.free, point, strict=True)])


def space(
    model: Tables, nominal: Mapping[str, float | str], on: Sequence[str], free: Sequence[str], bounds: Mapping[str, tuple[float, float]]
) -> Space:
    """The free parameters with their bounds, checked against the model; ParameterError where one cannot be free."""
    known = {variable.name: variable for variable in model.variables}
    owner = {variable.name: effect.name for effect in model.effects for variable in effect.variables}
    unknown = [effect for effect in on if effect not in {effect.name for effect in model.effects}]
    if unknown:
        raise ParameterError(f"there is no effect {unknown[0]!r}; {nearest(unknown[0], (effect.name for effect in model.effects))}")
    if not free:
        raise ParameterError("no free parameter was named; name at least one that is to be found, for example F_C.")
    if repeated := [name for name in dict.fromkeys(free) if list(free).count(name) > 1]:
        raise ParameterError(f"{repeated[0]} is named twice among the free parameters; name it once.")
    if stray := sorted(set(bounds) - set(free)):
        raise ParameterError(f"bounds are given for {', '.join(stray)}, not free here; free are {', '.join(free)}.")
    free_variables = []
    for name in free:
        if name not in known:
            near = near_names(name, known)
            hint = f"; did you mean {', '.join(near)}?" if near else "."
            raise ParameterError(f"free parameter {name!r}: the model has no such variable{hint}")
        variable = known[name]
        if variable.causality != "parameter" or variable.type != "real":
            raise ParameterError(
                f"free parameter {name!r} is a {variable.type} {variable.causality}; only real parameters can be identified."
            )
        if name in owner and owner[name] not in on:
            raise ParameterError(f"free parameter {name!r} belongs to the effect {owner[name]}, which is off; switch it on, or drop it.")
        start, begins = float(nominal.get(name, variable.start)), "in the nominal model" if name in nominal else "where nobody says"
        free_variables.append(Free(variable, start, *_bounds(variable, start, begins, bounds.get(name))))
    return Space(tuple(free_variables))


def _bounds(variable: Variable, start: float, begins: str, given: tuple[float, float] | None) -> tuple[float, float]:
    name, unit = variable.name, "" if variable.unit == "1" else f" {variable.unit}"
    if given is None:
        if start <= 0 or variable.min < 0:
            why = "of either sign" if variable.min < 0 else "not above 0"
            raise ParameterError(
                f"free parameter {name}: it is {start:g}{unit} {begins}, and for a value that is {why} a twentieth and twenty times it "
                f"are no bounds; the model allows {variable.min:g} to {variable.max:g}{unit}. Give bounds, as --bound '{name}=LOW..HIGH'."
            )
        return max(variable.min, start / REACH), min(variable.max, start * REACH)
    low, high = given
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(f"bounds of {name}: {low:g} to {high:g}{unit}; the first must be below the second.")
    if low < variable.min or high > variable.max:
        raise ParameterError(f"bounds of {name}: {low:g} to {high:g}{unit}; the model allows {variable.min:g} to {variable.max:g}{unit}.")
    return low, high
