"""A LuGre contact of a few lines, which shares nothing with the kernel, and records of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from evat.experiment import Experiment, InitialBristle, Nominal, Signal, Trial
from evat.model import FloatArray

VALUES = {"F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 100.0, "sigma2": 5.0, "v_s": 0.01}
TIMES = np.arange(500) * 1e-3
STEADY = 11.0 / 1e5  # m: F_S / sigma0
NOISE = 0.1


def lugre(v: FloatArray, z: float) -> FloatArray:
    """Exact for a velocity that stands still between samples: the bristle goes to its target as an exponential (100 parts a sample)."""
    force, parts = np.empty(v.size), 100
    for place, speed in enumerate(v):
        limit = VALUES["F_C"] + (VALUES["F_S"] - VALUES["F_C"]) * np.exp(-((speed / VALUES["v_s"]) ** 2))
        rate = speed - VALUES["sigma0"] * abs(speed) / limit * z
        force[place] = VALUES["sigma0"] * z + VALUES["sigma1"] * rate + VALUES["sigma2"] * speed
        if place + 1 < v.size:
            for part in range(parts):
                now = speed + (v[place + 1] - speed) * (part + 0.5) / parts
                limit = VALUES["F_C"] + (VALUES["F_S"] - VALUES["F_C"]) * np.exp(-((now / VALUES["v_s"]) ** 2))
                decay = np.exp(-VALUES["sigma0"] * abs(now) / limit * 1e-3 / parts)
                z = z * decay + np.sign(now) * limit / VALUES["sigma0"] * (1 - decay)
    return force


def world(starts: Sequence[float], believed: InitialBristle, wait: float = 0.08, zero: float = 0.0) -> Experiment:
    """Trials that stand for a while, then go to and fro; two of each. zero : what the recorded velocity has and the contact has not."""
    draw, trials = np.random.default_rng(5), list[Trial]()
    for place, z in enumerate(starts):
        v = 0.004 * (1 + place) * np.sin(2 * np.pi * 5 * np.maximum(TIMES - wait, 0))
        force = lugre(v, z)
        for repeat in range(2):
            shown = force * (1 + 0.003 * draw.normal()) + NOISE * draw.normal(size=TIMES.size)
            trials.append(Trial(f"{place}{repeat}.csv", f"c{place}", {}, TIMES, {"slip_velocity": v + zero}, {"friction_force": shown}))
    nominal = Nominal({"kinematics": "external", "friction_law": "lugre", **VALUES}, (), {}, initial_bristle=believed)
    signals = {
        "time": Signal("time", "t", "s", None),
        "slip_velocity": Signal("slip_velocity", "v", "m/s", "input"),
        "friction_force": Signal("friction_force", "F", "N", "output"),
    }
    return Experiment(Path(), "rig", "", nominal, signals, tuple(trials), None, "")
