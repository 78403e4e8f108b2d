"""How are a friction rig and a machine axis moved? Velocities of unit peak over time in periods, as functions that run on without end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .drive import Array

Draw = np.random.Generator
Velocity = Callable[[Array], Array]


@dataclass(frozen=True)
class Motion:
    """velocity(u), u in periods; periods in a record; samples per period; whether a frequency of excitation can be named."""

    velocity: Velocity
    periods: float
    per: int
    periodic: bool = True


def reciprocating(rng: Draw) -> Motion:
    """A crank: a sine with a little of the second harmonic."""
    second = float(rng.uniform(0.0, 0.12))
    return Motion(lambda u: np.sin(2 * np.pi * u) + second * np.sin(4 * np.pi * u), float(rng.integers(4, 8)), int(rng.integers(90, 170)))


def ramps(rng: Draw) -> Motion:
    """Up and down at constant acceleration, turned smoothly at the top."""
    top = float(rng.uniform(0.9, 0.98))
    return Motion(lambda u: np.arcsin(top * np.sin(2 * np.pi * u)) / np.arcsin(top), float(rng.integers(3, 6)), int(rng.integers(140, 260)))


def velocity_steps(rng: Draw) -> Motion:
    """Levels that never rest, some against the others, each reached within a few percent of its length."""
    count = int(rng.integers(5, 9))
    levels = np.exp(rng.uniform(np.log(0.05), 0.0, count)) * np.where(rng.random(count) < 0.3, -1.0, 1.0)
    levels[int(rng.integers(count))] = 1.0
    return _levels(rng, levels, soft=0.02)


def stops_and_dwells(rng: Draw) -> Motion:
    """Strokes with rests of very different lengths between them."""
    count = int(rng.integers(6, 11))
    levels = rng.uniform(0.2, 1.0, count) * np.where(rng.random(count) < 0.4, -1.0, 1.0)
    levels[1::2] = 0.0
    levels[0] = 1.0
    return _levels(rng, levels, soft=0.03, rests=(0.1, 2.5))


def _levels(rng: Draw, levels: Array, soft: float, rests: tuple[float, float] = (0.6, 1.4)) -> Motion:
    lengths = np.where(levels == 0, np.exp(rng.uniform(*np.log(rests), levels.size)), rng.uniform(0.6, 1.4, levels.size))
    ends = np.cumsum(lengths)

    def velocity(u: Array) -> Array:
        w = np.mod(u, ends[-1])
        out = np.full_like(w, levels[0])
        for change, at in zip(np.diff(levels, append=levels[:1]), ends, strict=True):
            out = out + change * _rise((w - at) / soft)
        return out

    return Motion(velocity, float(ends[-1]), int(rng.integers(90, 150)), periodic=False)


def _rise(u: Array) -> Array:
    return (1 + np.tanh(u)) / 2


def multi_sine(rng: Draw) -> Motion:
    orders = np.array([1, *sorted(rng.choice([2, 3, 5, 7], 3, replace=False).tolist())])
    sizes, phases = np.array([1.0, *rng.uniform(0.15, 0.6, 3)]), rng.uniform(0, 2 * np.pi, 4)
    u = np.linspace(0, 1, 4000)
    top = float(np.max(np.abs(np.sum(sizes * np.sin(2 * np.pi * orders * u[:, None] + phases), axis=1))))

    def velocity(u: Array) -> Array:
        return np.asarray(sum(s * np.sin(2 * np.pi * n * u + p) for s, n, p in zip(sizes, orders, phases, strict=True)) / top)

    return Motion(velocity, float(rng.integers(2, 5)), int(rng.integers(260, 400)))


def positioning(rng: Draw) -> Motion:
    """An axis that goes out and back by jerk-limited moves with rests between, the way back at another speed."""
    out, back, rest = float(rng.uniform(0.22, 0.34)), float(rng.uniform(0.22, 0.34)), float(rng.uniform(0.04, 0.12))
    ratio = out / back

    def hump(u: Array, begin: float, length: float) -> Array:
        w = np.clip((u - begin) / length, 0.0, 1.0)
        return np.clip(1.25 * np.sin(np.pi * w) ** 1.5, 0.0, 1.0)

    def velocity(u: Array) -> Array:
        w = np.mod(u, 1.0)
        return (hump(w, rest, out) - ratio * hump(w, 0.5 + rest, back)) / max(1.0, ratio)

    return Motion(velocity, float(rng.integers(3, 6)), int(rng.integers(200, 320)))


def slow_reversals(rng: Draw) -> Motion:
    """Contouring: a circle's component, with quadrant changes at many speeds."""
    change = float(rng.uniform(0.3, 0.7))
    return Motion(
        lambda u: np.sin(2 * np.pi * u) * (1 - change + change * np.sin(2 * np.pi * u / 5.3) ** 2),
        float(rng.integers(4, 7)), int(rng.integers(120, 200)),
    )  # fmt: skip


RIG = {make.__name__: make for make in (reciprocating, ramps, velocity_steps, stops_and_dwells, multi_sine)}
AXIS = {make.__name__: make for make in (positioning, slow_reversals, ramps)}
