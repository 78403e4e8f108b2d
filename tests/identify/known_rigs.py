"""Which experiments do these tests identify? Simulated ones, whose truth is known: a LuGre contact that is moved to and fro, or slides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from evat.experiment import Experiment, Nominal, SetupSd, Signal, Trial
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

MODEL = ContactModel(threads=2)
TRUTH: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 300.0, "sigma2": 40.0, "v_s": 1e-2,
}  # fmt: skip
FREE = ("F_C", "F_S", "sigma0", "sigma1", "sigma2", "v_s")
GUESS: dict[str, float | str] = {**TRUTH, "F_C": 5.0, "F_S": 20.0, "sigma0": 3e4, "sigma1": 100.0, "sigma2": 10.0, "v_s": 2e-2}
STEP = 2e-3  # s
TIMES: FloatArray = np.arange(1000) * STEP
TO_AND_FRO: FloatArray = 0.05 * np.sin(2 * np.pi * TIMES) + 0.002 * np.sin(2 * np.pi * 7.3 * TIMES)
SLIDING: FloatArray = 0.05 + 0.2 * np.linspace(0.0, 1.0, TIMES.size)


def force(
    velocity: FloatArray, values: Mapping[str, float | str] = TRUTH, on: Sequence[str] = (), inputs: Mapping[str, FloatArray] | None = None
) -> FloatArray:
    run = Run(np.arange(velocity.size) * STEP, {"slip_velocity": velocity, **(inputs or {})}, ("friction_force",))
    friction: FloatArray = MODEL.simulate(run, on, {**values, "relative_tolerance": 1e-8})["friction_force"]
    return friction


def trial(
    velocity: FloatArray,
    condition: str = "c0",
    *,
    noise: float = 0.01,
    seed: int = 1,
    values: Mapping[str, float | str] = TRUTH,
    measured: FloatArray | None = None,
) -> Trial:
    """A recording with white noise, of that share of the force's rms."""
    clean = force(velocity, values) if measured is None else measured
    noisy = clean + noise * np.sqrt(np.mean(clean**2)) * np.random.default_rng(seed).standard_normal(clean.size)
    times = np.arange(velocity.size) * STEP
    return Trial(f"{condition}-{seed}.csv", condition, {}, times, {"slip_velocity": velocity}, {"friction_force": noisy})


def experiment(*trials: Trial, nominal: Mapping[str, float | str] = GUESS, effects: tuple[str, ...] = ()) -> Experiment:
    signals = {
        "time": Signal("time", "t", "s", None),
        "slip_velocity": Signal("slip_velocity", "v", "m/s", "input"),
        "friction_force": Signal("friction_force", "F", "N", "output"),
    }
    return Experiment(Path(), "rig", "", Nominal(dict(nominal), effects, {}), signals, tuple(trials), None, "hash of no file")


def exact(made: Experiment) -> Experiment:
    """The same with what is true of a simulation: its set-up has no errors, and what is held has its true value. What intervals then hold
    is noise, whose size is known."""
    measured = {name for each in made.trials for name in (*each.inputs, *each.outputs)} | set(made.outputs)
    setup = {name: SetupSd(gain=0.0, zero=0.0, clock=0.0) for name in measured}
    return replace(made, setup_sd=setup, nominal=replace(made.nominal, default_relative_sd=0.0))
