"""What can be wrong with what the sensors show? Delay, scale, zero, drift, mixing, filters and a platform that rings."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from radau import Array
from scene import Scene
from scipy import signal
from world import Cause, Channels, World

Draw = np.random.Generator


def _late(force: Array, fine: float, delay: float) -> Array:
    """The force as it was `delay` earlier; before the record its first value."""
    at = np.arange(force.size) - delay / fine
    return np.asarray(np.interp(at, np.arange(force.size), force))


@lru_cache(maxsize=1024)
def _discrete(denominator: tuple[float, ...], fine: float) -> tuple[Array, Array]:
    b, a, _ = signal.cont2discrete(([1.0], denominator), fine, method="foh")
    return np.ravel(b), np.asarray(a)


def filtered(force: Array, fine: float, denominator: list[float]) -> Array:
    """A linear filter of gain 1 at rest, driven by straight lines between the grid's points, at rest at the start."""
    b, a = _discrete(tuple(denominator), fine)
    return np.asarray(signal.lfilter(b, a, force))


def _period(world: World) -> float:
    """The shortest excitation period [s], or a twentieth of the record."""
    periods = [1 / f for f in world.excitation if f > 0]
    return min(periods) if periods else float(world.scenes[0].times[-1]) / 20


def _coarsest(world: World) -> float:
    """The longest time between two samples [s]."""
    return max(float(scene.times[1] - scene.times[0]) for scene in world.scenes)


def sensor_delay(world: World, rng: Draw) -> Cause:
    unit, smear = _period(world), float(rng.uniform(0.02, 0.1))

    def wait(forces: Channels, scene: Scene, s: float) -> None:
        for name, force in forces.items():
            tau = s * unit
            blurred = filtered(force, scene.fine, [smear * tau, 1.0]) if smear * tau > 0.02 * scene.fine else force
            forces[name] = _late(blurred, scene.fine, (1 - smear) * tau)

    return Cause("sensor_delay", 0.02, 0.15, {"unit": unit, "smear": smear}, least=0.4 * _coarsest(world) / unit, sensor=wait)


def _weights(world: World, rng: Draw) -> dict[str, float]:
    """How strongly each channel has the fault: one of them in full."""
    names = [name.removeprefix("mean_") for name in world.channels]
    weights = {name: float(rng.choice([0.0, 1.0])) * float(rng.uniform(0.3, 1.0)) for name in names}
    weights[str(rng.choice(names))] = 1.0
    return weights


def sensor_gain(world: World, rng: Draw) -> Cause:
    weights, bend = _weights(world, rng), float(rng.uniform(-0.05, 0.05))

    def scale(forces: Channels, scene: Scene, s: float) -> None:
        for name, weight in weights.items():
            force = forces[name]
            top = float(np.max(np.abs(force))) or 1.0
            forces[name] = force * (1 + s * weight * (1 + bend * np.abs(force) / top))

    return Cause("sensor_gain", 0.1, 0.5, {**weights, "bend": bend}, both_ways=True, sensor=scale)


def _size(world: World) -> float:
    forces = world.respond()
    return max(float(np.sqrt(np.mean(part[name] ** 2))) for part in forces for name in world.channels)


def sensor_offset(world: World, rng: Draw) -> Cause:
    weights, size = _weights(world, rng), _size(world)

    def shift(forces: Channels, scene: Scene, s: float) -> None:
        for name, weight in weights.items():
            forces[name] = forces[name] + s * weight * size

    return Cause("sensor_offset", 0.1, 0.6, {**weights, "size": size}, both_ways=True, sensor=shift)


def sensor_drift(world: World, rng: Draw) -> Cause:
    weights, size = _weights(world, rng), _size(world)
    span = max(scene.times[-1] for scene in world.scenes)
    bend, kind = float(rng.uniform(0.8, 2.5)), str(rng.choice(["charge", "power"]))

    def wander(forces: Channels, scene: Scene, s: float) -> None:
        u = scene.grid / span
        grown = (1 - np.exp(-u / bend)) / (1 - np.exp(-1 / bend)) if kind == "charge" else u ** (0.7 + 0.2 * bend)
        for name, weight in weights.items():
            forces[name] = forces[name] + s * weight * size * grown

    return Cause("sensor_drift", 0.15, 0.8, {**weights, "size": size, "bend": bend, "kind": kind}, both_ways=True, sensor=wander)


def cross_talk(world: World, rng: Draw) -> Cause:
    to_feed, to_principal = float(rng.uniform(0.3, 1.0)), float(rng.uniform(-0.3, 1.0))

    def mix(forces: Channels, scene: Scene, s: float) -> None:
        principal, feed = forces["principal_force"], forces["feed_force"]
        forces["principal_force"] = principal + s * to_principal * feed
        forces["feed_force"] = feed + s * to_feed * principal

    return Cause("cross_talk", 0.05, 0.4, {"to_feed": to_feed, "to_principal": to_principal}, both_ways=True, sensor=mix)


def sensor_lowpass(world: World, rng: Draw) -> Cause:
    unit, second = _period(world), float(rng.uniform(0.05, 0.35))

    def smooth(forces: Channels, scene: Scene, s: float) -> None:
        T_1, T_2 = s * unit, second * s * unit
        for name, force in forces.items():
            forces[name] = filtered(force, scene.fine, [T_1 * T_2, T_1 + T_2, 1.0])

    return Cause("sensor_lowpass", 0.03, 0.3, {"unit": unit, "second": second}, least=0.4 * _coarsest(world) / unit, sensor=smooth)


def dynamometer_resonance(world: World, rng: Draw) -> Cause:
    unit, damping = _period(world), float(rng.uniform(0.02, 0.12))
    stiff, share = float(rng.uniform(2.2, 4.0)), float(rng.uniform(0.0, 0.12))

    def ring(forces: Channels, scene: Scene, s: float) -> None:
        T = s * unit / (2 * np.pi)
        for name, force in forces.items():
            first = filtered(force, scene.fine, [T * T, 2 * damping * T, 1.0])
            T_2 = T / stiff
            second = filtered(force, scene.fine, [T_2 * T_2, 2 * damping * T_2, 1.0])
            forces[name] = (1 - share) * first + share * second

    shape = {"unit": unit, "damping": damping, "stiff": stiff, "share": share}
    return Cause("dynamometer_resonance", 0.15, 0.6, shape, least=4 * _coarsest(world) / unit, sensor=ring)


SENSOR = {
    make.__name__: make
    for make in (sensor_delay, sensor_gain, sensor_offset, sensor_drift, cross_talk, sensor_lowpass, dynamometer_resonance)
}
