"""A friction rig with known effects: strokes of four sizes, three repeats each, coloured noise. Made by the component itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

VALUES: dict[str, float | str] = {
    "kinematics": "external",
    "friction_law": "lugre",
    "F_C": 9.0,
    "F_S": 11.0,
    "sigma0": 1e5,
    "sigma1": 100.0,
    "sigma2": 5.0,
    "v_s": 0.01,
}
SAMPLES, STEP, NOISE = 400, 1e-3, 0.15
MODEL = ContactModel(threads=1)
# What swings by itself, or along the way, needs short steps: half of the time of a diagnosis, for candidates that few tests are about.
SWINGING = ("position_dependence", "holder_compliance", "dynamometer_resonance", "line_disturbance")
STILL = ContactModel(threads=1)
STILL.effects = tuple(effect for effect in STILL.effects if effect.name not in SWINGING)
Noise = Callable[[np.random.Generator, int], FloatArray]


def coloured(draw: np.random.Generator, size: int) -> FloatArray:
    return np.convolve(draw.normal(size=size + 2), [0.8, 0.5, 0.3], mode="valid")


def measured(
    on: Sequence[str] = (),
    truth: Mapping[str, float | str] | None = None,
    *,
    nominal: Mapping[str, float | str] | None = None,
    extra: Callable[[FloatArray], FloatArray] | None = None,
    noise: Noise = coloured,
    repeats: int = 3,
    seed: int = 3,
    inputs: Mapping[str, Callable[[FloatArray, int], FloatArray]] | None = None,
    late: float = 0.0,
) -> Experiment:
    """truth overrides VALUES in what is measured, nominal in what is believed; extra (of the time) is added; late shifts the clock [s]."""
    draw, trials = np.random.default_rng(seed), list[Trial]()
    times = np.arange(SAMPLES) * STEP
    for place in range(4):
        wave = 2 * np.pi * 5 * times + 0.3 * place
        columns = {"slip_velocity": 0.012 * (1 + place) * np.sin(wave) + 0.01 * (place % 2)}
        columns |= {name: made(times, place) for name, made in (inputs or {}).items()}
        run = Run(times, columns, ("measured_friction_force",))
        force = MODEL.simulate(run, on, {**VALUES, **(truth or {})})["measured_friction_force"]
        force = np.interp(times - late, times, force)
        for repeat in range(repeats):
            recorded = force * (1 + 0.003 * draw.normal()) + 0.02 * draw.normal() + NOISE * noise(draw, times.size)
            recorded = recorded + (0 if extra is None else extra(times))
            trials.append(Trial(f"{place}{repeat}.csv", f"c{place}", {}, times, columns, {"friction_force": recorded}))
    signals = {"friction_force": Signal("friction_force", "F", "N", "output")}
    return Experiment(Path(), "rig", "", Nominal({**VALUES, **(nominal or {})}, (), {}), signals, tuple(trials), None, "")
