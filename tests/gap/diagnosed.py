"""Which diagnosis do the tests of its files look at? A simulated contact that resists more in one direction than its model believes."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.gap import diagnose_with
from evat.gap.answer import Diagnosis
from evat.gap.search.compare import Comparison
from evat.model import FloatArray, Run
from rig import STILL as MODEL

NOMINAL: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 300.0, "sigma2": 40.0, "v_s": 1e-2,
}  # fmt: skip
EFFECT, SIZE = "direction_asymmetry", 0.15
TIMES: FloatArray = np.arange(400) * 2e-3
NOISE = 0.05  # N


def _trial(condition: str, speed: float, seed: int, truth: dict[str, float | str]) -> Trial:
    velocity = speed * np.sin(2 * np.pi * 5 * TIMES)
    run = Run(TIMES, {"slip_velocity": velocity}, ("friction_force",))
    force = MODEL.simulate(run, (EFFECT,), {**truth, f"{EFFECT}.a": SIZE})["friction_force"]
    noise = NOISE * np.random.default_rng(seed).standard_normal(TIMES.size)
    return Trial(f"{condition}-{seed}.csv", condition, {}, TIMES, {"slip_velocity": velocity}, {"friction_force": force + noise})


def experiment() -> Experiment:
    truth: dict[str, float | str] = {**NOMINAL, "F_C": 9.5, "sigma2": 44.0}
    speeds = {"slow": 0.01, "middle": 0.03, "fast": 0.06, "fastest": 0.1}
    trials = [_trial(name, speed, 2 * n + k, truth) for n, (name, speed) in enumerate(speeds.items()) for k in range(2)]
    signals = {
        "time": Signal("time", "t", "s", None),
        "slip_velocity": Signal("slip_velocity", "v", "m/s", "input"),
        "friction_force": Signal("friction_force", "F", "N", "output"),
    }
    return Experiment(
        Path(), "rig", "", Nominal(dict(NOMINAL), (), {}, initial_bristle="relaxed"), signals, tuple(trials), None, "hash of no file"
    )


@lru_cache(maxsize=1)
def diagnosed() -> tuple[Diagnosis, Comparison]:
    return diagnose_with(experiment(), MODEL, version="0.0")
