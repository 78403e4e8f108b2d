"""How is the benchmark's contact moved? Slip velocities of a friction rig and of a machine, as smooth functions of time, from rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from radau import Array
from scene import Signal

Draw = np.random.Generator


@dataclass(frozen=True)
class Motion:
    """slip: velocity over time for unit peak speed; times: of the samples; frequency: of the excitation [Hz], 0 where there is none."""

    slip: Signal
    times: Array
    frequency: float


def reciprocating(rng: Draw, frequency: float, _: float) -> Motion:
    cycles, per = int(rng.integers(5, 11)), int(rng.integers(90, 150))
    return Motion(lambda t: np.sin(2 * np.pi * frequency * t), clock(cycles / frequency, cycles * per), frequency)


def ramp(rng: Draw, frequency: float, _: float) -> Motion:
    cycles, per, round_ = int(rng.integers(3, 6)), int(rng.integers(180, 300)), float(rng.uniform(0.96, 0.99))
    top = float(np.arcsin(round_))
    return Motion(lambda t: np.arcsin(round_ * np.sin(2 * np.pi * frequency * t)) / top, clock(cycles / frequency, cycles * per), frequency)


def stepped(rng: Draw, frequency: float, rest: float) -> Motion:
    """Levels with rests between them; a level lasts between a half and one and a half of 1/frequency."""
    count, per = int(rng.integers(7, 12)), int(rng.integers(110, 170))
    levels = rng.uniform(0.15, 1.0, count) * np.where(rng.random(count) < 0.4, -1, 1)
    levels[rng.random(count) < rest] = 0.0
    levels[0], levels[int(rng.integers(1, count))] = 0.0, 1.0
    lengths = rng.uniform(0.5, 1.5, count) / frequency
    lengths[0] = 0.2 / frequency
    lengths[1:][levels[1:] == 0] *= rng.uniform(0.3, 2.5, int(np.sum(levels[1:] == 0)))
    ends, soft = np.cumsum(lengths), 0.035 / frequency
    changes = np.diff(levels)

    def slip(t: Array) -> Array:
        return np.asarray(sum(c * (1 + np.tanh((t - at) / soft)) / 2 for c, at in zip(changes, ends[:-1], strict=True)))

    return Motion(slip, clock(float(ends[-1]), int(ends[-1] * frequency * per)), 0.0)


def multi_sine(rng: Draw, frequency: float, _: float) -> Motion:
    cycles, per = int(rng.integers(3, 6)), int(rng.integers(300, 420))
    orders = [1, *sorted(rng.choice([2, 3, 4, 5], 2, replace=False).tolist())]
    sizes = np.array([1.0, rng.uniform(0.2, 0.7), rng.uniform(0.1, 0.5)]) * rng.choice([-1, 1], 3)
    top = float(np.max(np.abs(sum(s * np.sin(2 * np.pi * n * np.linspace(0, 1, 2000)) for s, n in zip(sizes, orders, strict=True)))))

    def slip(t: Array) -> Array:
        return np.asarray(sum(s / top * np.sin(2 * np.pi * n * frequency * t) for s, n in zip(sizes, orders, strict=True)))

    return Motion(slip, clock(cycles / frequency, cycles * per), frequency)


RIG = {make.__name__: make for make in (reciprocating, ramp, stepped, multi_sine)}


def clock(span: float, count: int) -> Array:
    """Sample times from 0, evenly spaced, between 500 and 4000 of them."""
    count = min(max(count, 500), 4000)
    return np.linspace(0.0, span, count + 1)


def slow(rng: Draw, span: float, mean: float, swing: float) -> Signal:
    """A signal that swings by the share `swing` about its mean, over one to three times within the span, or grows to it."""
    if rng.random() < 0.4:
        late = float(rng.uniform(0.2, 0.6)) * span
        return lambda t: mean * (1 - swing + 2 * swing * -np.expm1(-t / late))
    turns, phase = float(rng.uniform(0.7, 3.2)) / span, float(rng.uniform(0, 2 * np.pi))
    return lambda t: np.asarray(mean * (1 + swing * np.sin(2 * np.pi * turns * t + phase)))
