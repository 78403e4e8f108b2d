"""What of a gap is left when the base law may move, linearly and by what its owner knows; and which LuGre is nearest a world?"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .base_laws import Law
from .drive import Array, Channels
from .world import World

STEP = 0.01
SHARP, LUGRE = Law("sharp"), Law("lugre")


def sizes(world: World, parts: list[Channels]) -> dict[str, float]:
    """Root mean square of each channel over all lanes."""
    return {name: float(np.sqrt(np.mean(np.concatenate([part[name] for part in parts]) ** 2))) for name in world.channels}


def flat(world: World, parts: list[Channels], unit: Mapping[str, float]) -> Array:
    """All samples of all channels, each in its unit: channel after channel, lane after lane."""
    return np.concatenate([part[name] / unit[name] for name in world.channels for part in parts])


def per_channel(world: World, parts: list[Channels], r: Array) -> dict[str, float]:
    """Root mean square of each channel of such a row of samples."""
    rms, at = {}, 0
    for name in world.channels:
        n = sum(part[name].size for part in parts)
        rms[name] = float(np.sqrt(np.mean(r[at : at + n] ** 2)))
        at += n
    return rms


def sensitivity(world: World, params: Mapping[str, float], unit: Mapping[str, float], law: Law | None = None,
                cut: Law | None = None) -> tuple[Array, Array, list[Channels]]:  # fmt: skip
    """Response, its derivatives by the relative change of each free parameter, and the response by lanes: one run of all lanes."""
    sets = [dict(params)] + [{**params, name: params[name] * (1 + STEP)} for name in world.free]
    d = world.conditions
    all_ = [world.samples(forces, d) for forces in world.respond(d, sets, (), law, cut)]
    y = flat(world, all_[0], unit)
    return y, np.stack([(flat(world, one, unit) - y) / STEP for one in all_[1:]], axis=1), all_[0]


def left(r: Array, J: Array, sd: Array, noise: float) -> Array:
    """What remains of r after the best parameters, held by their owner's knowledge, where each sample is uncertain by `noise`."""
    A = np.concatenate([J / noise, np.diag(1 / sd)])
    x, *_ = np.linalg.lstsq(A, np.concatenate([r / noise, np.zeros(sd.size)]), rcond=None)
    return np.asarray(r - J @ x)


def nearest_lugre(world: World, target: list[Channels], unit: Mapping[str, float], loose: float = 0.5) -> tuple[dict[str, float], Array]:
    """The parameters with which the nominal model's form comes nearest to these records, and what it leaves: Levenberg and Marquardt."""
    params, names = dict(world.params), world.free
    y = flat(world, target, unit)
    reached, J, _ = sensitivity(world, params, unit, LUGRE, SHARP)
    start, damp = np.zeros(len(names)), 1e-3
    best, best_cost, u = y - reached, np.inf, start
    best_cost = float(best @ best)
    for _ in range(8):
        A = np.concatenate([J, np.sqrt(damp * y.size) * np.eye(len(names)), 1e-2 * np.sqrt(y.size) / loose * np.eye(len(names))])
        b = np.concatenate([best, np.zeros(len(names)), -1e-2 * np.sqrt(y.size) / loose * u])
        step, *_ = np.linalg.lstsq(A, b, rcond=None)
        tried = np.clip(u + np.clip(step, -0.5, 0.5), -1.5, 1.5)
        moved = {**params, **{name: params[name] * float(np.exp(q)) for name, q in zip(names, tried, strict=True)}}
        now, J_now, _ = sensitivity(world, moved, unit, LUGRE, SHARP)
        cost = float((y - now) @ (y - now))
        if cost < best_cost:
            done = cost > 0.998 * best_cost
            u, best, best_cost, J, damp = tried, y - now, cost, J_now, damp / 5
            if done:
                break
        else:
            damp *= 10
    return {**params, **{name: params[name] * float(np.exp(q)) for name, q in zip(names, u, strict=True)}}, best
