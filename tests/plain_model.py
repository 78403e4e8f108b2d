"""What does a model of a few lines leave out? Everything of the Model protocol but simulate_many: no cycle, no rivals, no needs."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from evat.model import FloatArray, Rival, Run, Trace


class PlainModel:
    """Subclasses have `variables`, `effects` and simulate_many."""

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        raise NotImplementedError

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        columns = {name: rows[0] for name, rows in self.simulate_many(run, on, dict(values)).items()}
        return Trace(run.times, columns, dict.fromkeys(columns, "N"), {})

    def settled(self, names: Sequence[str], on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        raise NotImplementedError

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        return math.nan

    def rival_laws(self, values: Mapping[str, float | str]) -> Sequence[Rival]:
        return ()

    def missing_inputs(self, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str]) -> Mapping[str, Sequence[str]]:
        return {}
