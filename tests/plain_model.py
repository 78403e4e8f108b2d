"""What does a model of a few lines leave out? Everything of the Model protocol but its formula: the rest is here, for the tests."""

from __future__ import annotations

import inspect
import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from evat.model import Effect, FloatArray, ParameterError, Rival, Run, Trace, Variable, hash_of, table_hash
from evat.required_inputs import missing_inputs

SETTLING: FloatArray = np.array([0.0, 1.0])


class PlainModel:
    """Subclasses have `variables`, `effects`, and `formula`: outputs (K, n) or (n,) from values of shape (K, 1)."""

    variables: tuple[Variable, ...]
    effects: tuple[Effect, ...]

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        """values : of all parameters and inputs, (K or 1, n or 1); nan where an input is not given."""
        raise NotImplementedError

    @property
    def digest(self) -> str:
        own = type(self)
        return hash_of(table_hash(self), *map(inspect.getsource, (own.formula, own.cycle_time, own.settled)))

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        units = {variable.name: variable.unit for variable in self.variables if variable.causality == "output"}
        rows = self.simulate_many(Run(run.times, run.inputs, tuple(run.outputs) or tuple(units)), on, dict(values))
        return Trace(run.times, {name: row[0] for name, row in rows.items()}, {name: units[name] for name in rows}, {"model": self.digest})

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        known = {variable.name: variable for variable in self.variables}
        if unknown := [name for name in (*values, *run.inputs, *run.outputs) if name not in known]:
            raise ParameterError(f"there is no {unknown[0]!r}.")
        if unknown := [name for name in on if name not in {effect.name for effect in self.effects}]:
            raise ParameterError(f"there is no effect {unknown[0]!r}.")
        if not run.outputs:
            raise ParameterError("no outputs were asked for.")
        point = {v.name: np.full((1, 1), math.nan if v.causality == "input" else v.start) for v in self.variables}
        for name, value in values.items():
            point[name] = np.array([known[name].check(one) for one in np.atleast_1d(np.asarray(value)).tolist()])[:, None]
        for name, column in run.inputs.items():
            if np.shape(column)[-1:] != run.times.shape:
                raise ParameterError(f"{name} has {np.size(column)} samples, the clock has {run.times.size}.")
            point[name] = np.atleast_2d(column)
        counts = {column.shape[0] for column in point.values()} - {1}
        if len(counts) > 1:
            raise ParameterError(f"values vary over different numbers of sets: {sorted(counts)}.")
        count = counts.pop() if counts else 1
        columns = self.formula(run.times, point, on)
        return {name: np.array(np.broadcast_to(columns[name], (count, run.times.size))) for name in run.outputs}

    def settled(self, names: Sequence[str], on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        return {name: rows[:, -1] for name, rows in self.simulate_many(Run(SETTLING, {}, tuple(names)), on, values).items()}

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        return math.nan

    def rival_laws(self, values: Mapping[str, float | str]) -> Sequence[Rival]:
        return ()

    def missing_inputs(self, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str]) -> Mapping[str, Sequence[str]]:
        return missing_inputs(self, on, values, given)
