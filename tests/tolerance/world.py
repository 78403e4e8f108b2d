"""Which motions and contacts is the kernel judged on? Seeded draws: draw number n of seed s is always the same case."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from evat import kernel, parameter_sets
from evat.model import FloatArray
from judged import Case, Motion

EXTERNAL = ("ramp", "stop", "stop_and_go", "reversal", "plateau", "held", "triangle", "sine")
TOLERANCES = {1e-3: 0.1, 1e-4: 0.5, 1e-5: 0.3, 1e-6: 0.1}
Random = np.random.Generator


def draw(seed: int, number: int) -> Case:
    """One case."""
    random = np.random.default_rng([seed, number])
    kind = str(random.choice(EXTERNAL))
    law = "lugre"
    values: dict[str, Any] = {"kinematics": "external", "friction_law": law, **contact(random)}
    motion = slip(random, kind, values)
    tolerance = float(random.choice(list(TOLERANCES), p=list(TOLERANCES.values())))
    return Case(kind, values, (), motion, tolerance, (seed, number))


def logarithmic(random: Random, low: float, high: float) -> float:
    return float(10 ** random.uniform(math.log10(low), math.log10(high)))


@functools.cache
def shipped() -> tuple[Mapping[str, float], ...]:
    """The values of the shipped parameter sets. What belongs to their effects stays off."""
    own = {variable.name for effect in kernel.effects() for variable in effect.variables}
    found = []
    for name in parameter_sets.names():
        values = parameter_sets.load(name).values
        found.append({key: value for key, value in values.items() if key not in own and not _is_switch(key)})
    return tuple(found)


def _is_switch(name: str) -> bool:
    return any(effect.name == name for effect in kernel.effects())


def contact(random: Random) -> dict[str, Any]:
    """Friction: as it starts, a shipped set, or anything plausible."""
    kind = random.choice(3, p=[0.25, 0.25, 0.5])
    if kind == 0:
        values: dict[str, Any] = {}
    elif kind == 1:
        values = dict(shipped()[random.integers(len(shipped()))])
    else:
        level = logarithmic(random, 0.5, 20)
        values = {
            "sigma0": logarithmic(random, 1e5, 1e7),
            "sigma1": logarithmic(random, 1, 1e3),
            "sigma2": random.choice([0, 1]) * random.uniform(0, 2),
            "F_C": level,
            "F_S": level * random.uniform(0.5, 2),
            "v_s": logarithmic(random, 5e-4, 5e-2),
            "damping_mode": "dissipative" if random.uniform() < 0.85 else "as_published",
        }
    if random.uniform() < 0.2:
        values["lugre.stribeck_exponent"] = float(random.choice([0.5, 1, 1.5, 3])) if random.uniform() < 0.5 else random.uniform(0.3, 6)
    if random.uniform() < 0.3:
        values["shear_angle_principle"] = "minimum_energy"
    if random.uniform() < 0.3:
        values["rake_angle"] = random.uniform(-0.2, 0.2)
    return values


# ---- slip that is given ----


def slip(random: Random, kind: str, values: Mapping[str, Any]) -> Motion:
    """Slip velocity over time."""
    v_s = float(values.get("v_s", kernel.variable("v_s").start))
    speed = min(v_s * logarithmic(random, 0.3, 100), 1.0)
    if kind in ("triangle", "sine"):
        return _wave(random, kind, speed)
    corners, lengths = _corners(random, kind, speed)
    times = np.concatenate([[0.0], np.cumsum(lengths)])
    if kind == "held":
        return Motion.held(times, {"slip_velocity": corners})
    parts = int(random.choice([1, 1, 2, 5, 20]))
    fine = np.concatenate([np.linspace(a, b, parts, endpoint=False) for a, b in itertools.pairwise(times)] + [times[-1:]])
    between = np.interp(fine, times, corners)
    between[::parts] = corners
    return Motion.record(fine, {"slip_velocity": between}, stepped=bool(random.uniform() < 0.5))


def _lengths(random: Random, count: int) -> FloatArray:
    return np.array([logarithmic(random, 1e-3, 0.3) for _ in range(count)])


def _corners(random: Random, kind: str, speed: float) -> tuple[FloatArray, FloatArray]:
    sign = float(random.choice([-1, 1]))
    if kind == "ramp":
        count = int(random.integers(2, 6))
        corners = speed * sign * random.uniform(0, 1, count + 1) ** 2
    elif kind == "stop":
        corners = sign * speed * np.array([*random.uniform(0.1, 1, int(random.integers(1, 3))), 0, 0])
    elif kind == "stop_and_go":
        corners = sign * speed * np.concatenate([[u, 0, 0, 0.5 * u * random.choice([-1, 1])] for u in random.uniform(0.1, 1, 3)])
    elif kind == "reversal":
        signs = sign * (-1.0) ** np.arange(int(random.integers(2, 7)))
        corners = speed * signs * random.uniform(0.05, 1, len(signs))
    elif kind == "plateau":
        corners = np.repeat(speed * random.uniform(-1, 1, int(random.integers(2, 4))), 2)
    else:
        corners = speed * random.uniform(-1, 1, int(random.integers(3, 8))) * random.choice([0, 1], p=[0.2, 0.8])
    return corners, _lengths(random, len(corners) - 1)


def _wave(random: Random, kind: str, speed: float) -> Motion:
    frequency, periods, samples = logarithmic(random, 1, 300), random.uniform(1, 4), int(random.integers(20, 500))
    times = np.linspace(0, periods / frequency, samples)
    turns = frequency * times + random.uniform()
    wave = np.sin(2 * math.pi * turns) if kind == "sine" else 4 * np.abs(turns % 1 - 0.5) - 1
    return Motion.record(
        times,
        {"slip_velocity": speed * wave + 0.3 * speed * random.choice([0, 1]) * random.uniform(-1, 1)},
        stepped=bool(random.uniform() < 0.5),
    )
