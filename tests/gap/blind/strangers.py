"""What can a record hold that no effect of the library explains? Additive, per trial, for unit size; sizes and times differ by trial."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from radau import Array
from scene import Scene
from world import Channels, World

Draw = np.random.Generator
Stranger = Callable[[Draw, Scene, Channels], Channels]


def _pulse(t: Array, at: Array, rise: float, decay: float, height: Array) -> Array:
    late = np.maximum(t[:, None] - at[None, :], 0.0)
    return np.asarray((height * (1 - np.exp(-late / rise)) * np.exp(-late / decay)).sum(axis=1))


def _spread(rng: Draw, world: World) -> dict[str, float]:
    shares = {name: float(rng.uniform(0.3, 1.0)) for name in world.channels}
    shares[str(rng.choice(world.channels))] = 1.0
    return shares


def _rate(world: World, rng: Draw) -> float:
    """A frequency that no excitation has: between 5 and 40 periods in a record, off every order."""
    span = float(world.scenes[0].times[-1])
    own = world.excitation[0] if world.excitation and world.excitation[0] > 0 else 8 / span
    return own * float(rng.choice([2.37, 3.61, 4.43, 5.57, 1.62]) * rng.uniform(0.97, 1.03))


def chatter(world: World, rng: Draw) -> Stranger:
    frequency, share, growth = _rate(world, rng), _spread(rng, world), float(rng.uniform(0.0, 1.5))

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        t, span = scene.times, scene.times[-1]
        wave = np.sin(2 * np.pi * frequency * t + own.uniform(0, 2 * np.pi)) * np.exp(growth * (t / span - 0.5))
        wave = wave * scene.sampled(scene.on[:, 1].astype(float))
        return {name: float(share[name]) * wave for name in world.channels}

    return add


def built_up_edge(world: World, rng: Draw) -> Stranger:
    share, count = _spread(rng, world), float(rng.uniform(4, 9))

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        t, span = scene.times, scene.times[-1]
        breaks = np.cumsum(own.uniform(0.4, 1.6, 40)) * span / count
        start = np.concatenate([[0.0], breaks])
        place = np.searchsorted(start, t, side="right") - 1
        height = own.uniform(0.6, 1.4, start.size)[place]
        saw = height * (t - start[place]) / (span / count)
        return {name: share[name] * saw * np.tanh(3 * forces[name] / (np.std(forces[name]) + 1e-12)) for name in world.channels}

    return add


def adhesion(world: World, rng: Draw) -> Stranger:
    share, count = _spread(rng, world), float(rng.uniform(6, 20))

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        t, span = scene.times, scene.times[-1]
        at = np.sort(own.uniform(0, span, own.poisson(count) + 1))
        step = t[1] - t[0]
        spikes = _pulse(t, at, 2 * step, float(rng_decay) * step, own.exponential(1.0, at.size))
        return {name: share[name] * spikes * np.sign(forces[name]) for name in world.channels}

    rng_decay = rng.uniform(6, 25)
    return add


def hum(world: World, rng: Draw) -> Stranger:
    frequency, third, share = _rate(world, rng), float(rng.uniform(0.0, 0.5)), _spread(rng, world)

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        turn = 2 * np.pi * frequency * scene.times + own.uniform(0, 2 * np.pi)
        return {name: share[name] * (np.sin(turn) + third * np.sin(3 * turn + 1.0)) for name in world.channels}

    return add


def stick_pulses(world: World, rng: Draw) -> Stranger:
    share, count, wide = _spread(rng, world), float(rng.uniform(5, 14)), float(rng.uniform(0.01, 0.04))

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        t, span = scene.times, scene.times[-1]
        at = np.cumsum(own.uniform(0.5, 1.5, 60)) * span / count
        u = (t[:, None] - at[None, :]) / (wide * span)
        burst = np.where((u > 0) & (u < 1), u, 0.0).sum(axis=1)
        return {name: share[name] * burst * np.tanh(3 * forces[name] / (np.std(forces[name]) + 1e-12)) for name in world.channels}

    return add


def chipping(world: World, rng: Draw) -> Stranger:
    share, back = _spread(rng, world), float(rng.uniform(0.0, 0.4))

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        t, span = scene.times, scene.times[-1]
        first, second = np.sort(own.uniform(0.15, 0.85, 2)) * span
        level = (t > first) * 1.0 - (t > second) * (1 + back)
        return {name: share[name] * level for name in world.channels}

    return add


def beating(world: World, rng: Draw) -> Stranger:
    """The force itself swells and fades at a rate of its own."""
    frequency, share = _rate(world, rng) * 0.21, _spread(rng, world)

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        swell = np.sin(2 * np.pi * frequency * scene.times + own.uniform(0, 2 * np.pi))
        return {name: share[name] * swell * forces[name] / (np.std(forces[name]) + 1e-12) for name in world.channels}

    return add


def odd_condition(world: World, rng: Draw) -> Stranger:
    """For averages: a regime of its own about one value of what varies."""
    axis = str(rng.choice(sorted(world.scenes[0].values)))
    every = np.array([scene.values[axis] for scene in world.scenes])
    middle, width = float(rng.choice(every)), 0.25 * float(np.ptp(every)) + 1e-30
    share = _spread(rng, world)

    def add(own: Draw, scene: Scene, forces: Channels) -> Channels:
        bump = float(np.exp(-(((scene.values[axis] - middle) / width) ** 2)))
        return {name: share[name] * bump * np.abs(forces[name]) for name in world.channels}

    return add


STRANGERS = {make.__name__: make for make in (chatter, built_up_edge, adhesion, hum, stick_pulses, chipping, beating)}
FOR_MEANS = {"odd_condition": odd_condition}
