"""A model of twenty lines with known answers: a spring that may bend, drift or lean. The diagnosis knows of a model what this has."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np
from evat.experiment import Experiment, Nominal, Trial
from evat.model import Effect, FloatArray, Run, Variable
from plain_model import PlainModel

SPRING = Variable("k", "N/m", 10.0, 0.0, 1e6, "stiffness", "toy")
WAY = Variable("x", "m", 0.0, -10.0, 10.0, "way", "toy", causality="input")
FORCE = Variable("F", "N", 0.0, -1e9, 1e9, "force", "toy", causality="output")


def _effect(name: str, parameter: str, unit: str, rivals: tuple[str, ...] = ()) -> Effect:
    own = Variable(f"{name}.{parameter}", unit, 1.0, -1e6, 1e6, parameter, "toy", neutral=0.0)
    return Effect(name, name, "toy", "toy", (own,), rivals)


class Toy(PlainModel):
    """F = k x (1 + c x) + rate t + a |x|."""

    effects = (_effect("bend", "c", "1/m"), _effect("drift", "rate", "N/s"), _effect("lean", "a", "N/m"))
    variables = (WAY, FORCE, SPRING, *(own for effect in effects for own in effect.variables))

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        x = values["x"]
        force = values["k"] * x
        if "bend" in on:
            force = force * (1 + values["bend.c"] * x)
        if "drift" in on:
            force = force + values["drift.rate"] * times
        if "lean" in on:
            force = force + values["lean.a"] * np.abs(x)
        return {"F": force}


class Loud(Toy):
    """A spring whose sensor may amplify."""

    effects = (*Toy.effects, _effect("amplify", "gain", "1"))
    variables = (*Toy.variables, *effects[-1].variables)

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        force = super().formula(times, values, on)["F"]
        return {"F": force * (1 + values["amplify.gain"]) if "amplify" in on else force}


def measured(
    on: Sequence[str] = (),
    values: Mapping[str, float] | None = None,
    *,
    noise: float = 0.1,
    conditions: int = 4,
    repeats: int = 3,
    seed: int = 1,
    extra: FloatArray | None = None,
) -> Experiment:
    """Trials of the toy with known effects: strokes of growing way, white noise [N]; `extra` is added to each."""
    draw, trials = np.random.default_rng(seed), list[Trial]()
    times = np.arange(400) * 0.01
    for place in range(conditions):
        x = (0.3 + 0.2 * place) * np.sin(2 * np.pi * (0.4 + 0.1 * place) * times)
        force = Toy().simulate_many(Run(times, {"x": x}, ("F",)), on, {"k": 10.0, **(values or {})})["F"][0]
        for repeat in range(repeats):
            recorded = force + noise * draw.normal(size=times.size) + (0 if extra is None else extra)
            trials.append(Trial(f"{place}{repeat}.csv", f"c{place}", {}, times, {"x": x}, {"F": recorded}))
    return Experiment(Path(), "toy", "", Nominal({"k": 10.0}, (), {}), {}, tuple(trials), None, "")
