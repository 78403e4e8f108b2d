"""What may the measurement do to a force? Effects that the library names, in laws of other form than the library's.

A gain, zero or delay counts as an effect from twice to three times on what set-ups are off by; below it, it is set-up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import signal

from .drive import Array, Channels, Drive, shifted
from .effects_of_friction import Draw, form
from .world import Effect, World

Filter = tuple[list[float], list[float]]


def filtered(fine: Array, h: float, transfer: Filter) -> Array:
    """A force through a continuous transfer function of gain 1 at rest, begun in its steady state; powers of s fall from the left."""
    b, a = ([q / h ** (len(p) - 1 - n) for n, q in enumerate(p)] for p in transfer)  # time in steps
    sections = signal.zpk2sos(*signal.bilinear_zpk(*signal.tf2zpk(b, a), fs=1.0))
    begin = signal.sosfilt_zi(sections)[:, :, None] * fine[:1]
    return np.asarray(signal.sosfilt(sections, fine, axis=0, zi=begin)[0])


def _each(change: Callable[[Array, Drive, float], Array]) -> Callable[[Channels, Drive, float], None]:
    def act(forces: Channels, d: Drive, s: float) -> None:
        for name in forces:
            forces[name] = change(forces[name], d, s)

    return act


def _sample(d: Drive) -> float:
    return d.every * d.h


@form("sensor_delay", "bessel")
def _(world: World, rng: Draw) -> Effect:
    """A Bessel filter of fourth order: all frequencies of interest come equally late."""
    z, p, k = signal.besselap(4, norm="delay")
    _, a = signal.zpk2tf(z, p, k)

    def change(fine: Array, d: Drive, s: float) -> Array:
        T = max(abs(s) * _sample(d), 1e-3 * d.h)
        scaled = [float(q) * T ** (4 - n) for n, q in enumerate(a)]
        return filtered(fine, d.h, ([scaled[-1]], scaled))

    return Effect("sensor_delay", "bessel", 3.0, 40.0, least=2.0, sensor=_each(change))


@form("sensor_delay", "pure_and_amplifier")
def _(world: World, rng: Draw) -> Effect:
    part = float(rng.uniform(0.05, 0.2))

    def change(fine: Array, d: Drive, s: float) -> Array:
        T = max(part * s * _sample(d), 1e-3 * d.h)
        return filtered(shifted(fine, s * d.every * (1 - part)), d.h, ([1.0], [T, 1.0]))

    return Effect("sensor_delay", "pure_and_amplifier", 3.0, 40.0, least=2.0, sensor=_each(change))


@form("sensor_lowpass", "two_poles")
def _(world: World, rng: Draw) -> Effect:
    apart = float(rng.uniform(0.15, 0.5))

    def change(fine: Array, d: Drive, s: float) -> Array:
        T = max(s * _sample(d), 1e-3 * d.h)
        return filtered(fine, d.h, ([1.0], [T * T * apart, T * (1 + apart), 1.0]))

    return Effect("sensor_lowpass", "two_poles", 2.0, 60.0, least=0.5, sensor=_each(change))


@form("sensor_lowpass", "critical")
def _(world: World, rng: Draw) -> Effect:
    damping = float(rng.uniform(0.85, 1.1))

    def change(fine: Array, d: Drive, s: float) -> Array:
        T = max(s * _sample(d), 1e-3 * d.h)
        return filtered(fine, d.h, ([1.0], [T * T, 2 * damping * T, 1.0]))

    return Effect("sensor_lowpass", "critical", 1.5, 40.0, least=0.4, sensor=_each(change))


def _swing(T: float, damping: float) -> list[float]:
    return [T * T, 2 * damping * T, 1.0]


@form("dynamometer_resonance", "two_modes")
def _(world: World, rng: Draw) -> Effect:
    apart, share, damping = float(rng.uniform(1.4, 2.2)), float(rng.uniform(0.1, 0.35)), float(rng.uniform(0.02, 0.1))

    def change(fine: Array, d: Drive, s: float) -> Array:
        T = max(s * _sample(d), 0.5 * d.h) / (2 * np.pi)
        one, two = (filtered(fine, d.h, ([1.0], _swing(T / q, damping))) for q in (1.0, apart))
        return (1 - share) * one + share * two

    return Effect("dynamometer_resonance", "two_modes", 4.0, 60.0, least=3.0, sensor=_each(change))


@form("dynamometer_resonance", "with_antiresonance")
def _(world: World, rng: Draw) -> Effect:
    at, damping = float(rng.uniform(1.3, 2.0)), float(rng.uniform(0.02, 0.1))

    def change(fine: Array, d: Drive, s: float) -> Array:
        T = max(s * _sample(d), 0.5 * d.h) / (2 * np.pi)
        return filtered(fine, d.h, (_swing(T / at, damping), _swing(T, damping)))

    return Effect("dynamometer_resonance", "with_antiresonance", 4.0, 60.0, least=3.0, sensor=_each(change))


def _size(fine: Array) -> float:
    return float(np.sqrt(np.mean(fine**2)))


@form("sensor_offset", "settling")
def _(world: World, rng: Draw) -> Effect:
    """A zero that creeps the last tenth of its way within each record."""
    parts, settle = rng.uniform(-1, 1, 3), float(rng.uniform(0.05, 0.15))
    parts[int(rng.integers(0, max(1, len(world.channels))))] = 1.0

    def act(forces: Channels, d: Drive, s: float) -> None:
        late = 1 - settle * np.exp(-3 * d.since / float(np.max(d.since)))
        unit = {name: _size(fine) for name, fine in forces.items()}
        for part, name in zip(parts, world.channels, strict=False):
            forces[name] = forces[name] + s * part * unit[name] * late

    return Effect("sensor_offset", "settling", 0.1, 1.5, least=0.025, both_ways=True, sensor=act)


@form("sensor_offset", "differs_by_condition")
def _(world: World, rng: Draw) -> Effect:
    """Much the same in all conditions, not quite."""
    parts, spread, seed = rng.uniform(-1, 1, 3), float(rng.uniform(0.05, 0.15)), int(rng.integers(1 << 30))
    parts[int(rng.integers(0, max(1, len(world.channels))))] = 1.0

    def act(forces: Channels, d: Drive, s: float) -> None:
        own = 1 + spread * np.random.default_rng(seed).standard_normal(d.lanes)
        for part, name in zip(parts, world.channels, strict=False):
            forces[name] = forces[name] + s * part * _size(forces[name]) * own

    return Effect("sensor_offset", "differs_by_condition", 0.1, 1.5, least=0.025, both_ways=True, sensor=act)


@form("sensor_drift", "charge_leak")
def _(world: World, rng: Draw) -> Effect:
    """A charge amplifier that leaks towards another zero."""
    late = float(rng.uniform(0.5, 1.5))

    def change(fine: Array, d: Drive, s: float) -> Array:
        u = d.since / float(np.max(d.since))
        return fine + s * _size(fine) * -np.expm1(-u / late) / -np.expm1(-1 / late)

    return Effect("sensor_drift", "charge_leak", 0.1, 3.0, both_ways=True, sensor=_each(change))


@form("sensor_drift", "warming")
def _(world: World, rng: Draw) -> Effect:
    power = float(rng.uniform(0.6, 1.5))

    def change(fine: Array, d: Drive, s: float) -> Array:
        return fine + s * _size(fine) * (d.since / float(np.max(d.since))) ** power

    return Effect("sensor_drift", "warming", 0.1, 3.0, both_ways=True, sensor=_each(change))


@form("sensor_gain", "bent")
def _(world: World, rng: Draw) -> Effect:
    """One channel's scale, and a little more of it at large forces."""
    which, bend = world.channels[int(rng.integers(len(world.channels)))], float(rng.uniform(-0.2, 0.2))

    def act(forces: Channels, d: Drive, s: float) -> None:
        fine = forces[which]
        forces[which] = fine * (1 + s * (1 + bend * np.abs(fine) / (float(np.max(np.abs(fine))) + 1e-300)))

    return Effect("sensor_gain", "bent", 0.1, 0.8, least=0.03, both_ways=True, sensor=act)


@form("sensor_gain", "one_channel")
def _(world: World, rng: Draw) -> Effect:
    which = world.channels[int(rng.integers(len(world.channels)))]
    return Effect(
        "sensor_gain",
        "one_channel",
        0.1,
        0.8,
        least=0.03,
        both_ways=True,
        sensor=lambda forces, d, s: forces.update({which: forces[which] * (1 + s)}),
    )


@form("cross_talk", "one_way")
def _(world: World, rng: Draw) -> Effect:
    a, b = [world.channels[k] for k in rng.permutation(2)]
    return Effect(
        "cross_talk", "one_way", 0.05, 0.5, both_ways=True, sensor=lambda forces, d, s: forces.update({a: forces[a] + s * forces[b]})
    )


@form("cross_talk", "turned")
def _(world: World, rng: Draw) -> Effect:
    """A dynamometer that stands a little askew, and not quite rigidly."""
    a, b = world.channels[0], world.channels[1]

    def act(forces: Channels, d: Drive, s: float) -> None:
        one, two = forces[a], forces[b]
        forces[a], forces[b] = one + s * two, two - 0.8 * s * one

    return Effect("cross_talk", "turned", 0.05, 0.5, both_ways=True, sensor=act)


def _mains(world: World, rng: Draw) -> float:
    """A line that the record resolves, at no simple ratio to the motion."""
    span = float(np.max(world.conditions.t))
    rate = 1 / (world.conditions.every * world.conditions.h)
    for f in (50.0, 60.0, 100.0, 150.0):
        if 4 / span < f < rate / 8:
            return f
    return float(np.sqrt(6 / span * rate / 12))


@form("line_disturbance", "drifting_phase")
def _(world: World, rng: Draw) -> Effect:
    f, wander, seed = _mains(world, rng), float(rng.uniform(0.2, 0.8)), int(rng.integers(1 << 30))

    def change(fine: Array, d: Drive, s: float) -> Array:
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, d.lanes)
        u = d.t / float(np.max(d.t))
        return fine + s * _size(fine) * np.sin(2 * np.pi * f * d.t + phase + wander * np.sin(2 * np.pi * u + phase))

    return Effect("line_disturbance", "drifting_phase", 0.1, 2.0, sensor=_each(change))


@form("line_disturbance", "beating")
def _(world: World, rng: Draw) -> Effect:
    f, beat, seed = _mains(world, rng), float(rng.uniform(0.1, 0.3)), int(rng.integers(1 << 30))

    def change(fine: Array, d: Drive, s: float) -> Array:
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, d.lanes)
        u = d.t / float(np.max(d.t))
        return fine + s * _size(fine) * (1 + beat * np.sin(4 * np.pi * u + phase)) * np.sin(2 * np.pi * f * d.t + phase)

    return Effect("line_disturbance", "beating", 0.1, 2.0, sensor=_each(change))
