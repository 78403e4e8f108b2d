"""What is left of a gap once the base law's parameters have been fitted again, ideally? And could anybody see it in this noise?

The structural gap is the noise-free response with its causes less the best response that the same base law without them can give. Its
size over the noise (taken as white and with the scatter between trials) is what an observer who knew everything else could go by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from law import Form
from radau import Array
from world import Channels, World


@dataclass(frozen=True)
class Refit:
    """values: of the base law, fitted; gap: what they leave, per condition and channel; size: rms of the gap per channel."""

    values: dict[str, float]
    gap: list[Channels]
    size: dict[str, float]


def flatten(world: World, forces: Sequence[Channels], weight: dict[str, float]) -> Array:
    return np.concatenate([part[name] / weight[name] for part in forces for name in world.channels])


def jacobian(world: World, values: dict[str, float], free: Sequence[str], weight: dict[str, float], form: Form) -> tuple[Array, Array]:
    """The response, and its change with the logarithm of each free value (a hundredth of a percent forward and backward)."""
    at = flatten(world, world.respond(values, form=form), weight)
    columns = []
    for name in free:
        ends = [
            flatten(world, world.respond({**values, name: values[name] * factor}, form=form), weight) for factor in (1 + 1e-4, 1 - 1e-4)
        ]
        columns.append((ends[0] - ends[1]) / 2e-4)
    return at, np.stack(columns, axis=1) if columns else np.zeros((at.size, 0))


def solve(J: Array, r: Array, damping: float = 1e-9) -> Array:
    """Least squares by scaled normal equations, lightly damped: some values have next to no say."""
    scale = np.sqrt(np.sum(J * J, axis=0)) + 1e-30
    S = J / scale
    solution: Array = np.linalg.solve(S.T @ S + damping * np.eye(S.shape[1]), S.T @ r) / scale
    return solution


def refit(world: World, target: Sequence[Channels], hold: dict[str, float], weight: dict[str, float], *, form: Form | None = None,
          rounds: int = 6) -> Refit:  # fmt: skip
    """Gauss-Newton with step control on the logarithms of the free values. hold: how strongly each clings to its true value, in units of
    the rows (0: not at all)."""
    form = form or world.form
    values = dict(world.values)
    free = [name for name in hold if values[name] > 0]
    truth, cling = np.array([values[name] for name in free]), np.array([hold[name] for name in free])
    goal = flatten(world, target, weight)

    def away(values: dict[str, float]) -> Array:
        return np.asarray(cling * np.log(np.array([values[name] for name in free]) / truth))

    at, J = jacobian(world, values, free, weight, form)
    best = float(np.sum((goal - at) ** 2))
    for _ in range(rounds):
        step = np.clip(solve(np.concatenate([J, np.diag(cling)]), np.concatenate([goal - at, -away(values)])), -0.4, 0.4)
        gained = False
        for shrink in (1.0, 0.5, 0.2):
            trial = {**values, **{name: values[name] * float(np.exp(shrink * d)) for name, d in zip(free, step, strict=True)}}
            miss = float(np.sum((goal - flatten(world, world.respond(trial, form=form), weight)) ** 2) + np.sum(away(trial) ** 2))
            if miss < best:
                gained = miss < 0.999 * best
                values, best = trial, miss
                break
        if not gained:
            break
        at, J = jacobian(world, values, free, weight, form)
    left = world.respond(values, form=form)
    gap = [{name: want[name] - have[name] for name in world.channels} for want, have in zip(target, left, strict=True)]
    return Refit(values, gap, size(world, gap))


def size(world: World, gap: Sequence[Channels]) -> dict[str, float]:
    """Root mean square of each channel over all conditions."""
    return {name: float(np.sqrt(np.mean(np.concatenate([part[name] for part in gap]) ** 2))) for name in world.channels}


def random_effects(world: World, forces: Sequence[Channels], jitter: dict[str, float]) -> list[Channels]:
    """How a trial's gain, zero and delay move each channel, one standard deviation each: three rows per channel."""
    effects = []
    for scene, part in zip(world.scenes, forces, strict=True):
        rows: Channels = {}
        for name in world.channels:
            force = part[name]
            slope = np.gradient(force, scene.times) if force.size > 2 else np.zeros(force.size)
            rows[name] = np.stack([jitter["gain"] * force, np.full(force.size, jitter[f"zero {name}"]), jitter["delay"] * slope])
        effects.append(rows)
    return effects


class Whitener:
    """Takes noise of the given rms (correlated over `memory` samples) and the scatter between trials out of a difference, so that what is
    left has one standard deviation per number. All repeats of a condition count."""

    def __init__(
        self, world: World, forces: Sequence[Channels], noise: dict[str, float], jitter: dict[str, float], memory: float, repeats: int
    ):
        self.world, self.noise, self.repeats = world, noise, repeats
        self.inflation = np.sqrt(1 + 2 * memory)
        self.factors: list[dict[str, tuple[Array, Array]]] = []
        for part in random_effects(world, forces, jitter):
            own = {}
            for name, rows in part.items():
                U, s, _ = np.linalg.svd((rows / (noise[name] * self.inflation)).T, full_matrices=False)
                own[name] = (U, 1 - 1 / np.sqrt(1 + s * s))
            self.factors.append(own)

    def __call__(self, forces: Sequence[Channels]) -> Array:
        white = []
        for part, own in zip(forces, self.factors, strict=True):
            for name in self.world.channels:
                r = part[name] / (self.noise[name] * self.inflation)
                U, shrink = own[name]
                white.append((r - U @ (shrink * (U.T @ r))) * np.sqrt(self.repeats))
        return np.concatenate(white)


def difference(a: Sequence[Channels], b: Sequence[Channels]) -> list[Channels]:
    return [{name: one[name] - two[name] for name in one} for one, two in zip(a, b, strict=True)]


def projected(r: Array, columns: Array, hold: Array | None = None) -> Array:
    """r without what the columns can explain; hold: how strongly each column's share clings to 0 (a row each, appended to what is left)."""
    if not columns.shape[1]:
        return r
    if hold is None:
        return np.asarray(r - columns @ solve(columns, r))
    solution = solve(np.concatenate([columns, np.diag(hold)]), np.concatenate([r, np.zeros(hold.size)]))
    return np.concatenate([r - columns @ solution, -hold * solution])


def sensitivity(world: World, free: Sequence[str], whiten: Whitener, values: dict[str, float] | None = None) -> Array:
    values = dict(values or world.values)
    columns = []
    for name in free:
        if values.get(name, 0.0) <= 0:
            continue
        ends = [world.respond({**values, name: values[name] * factor}) for factor in (1 + 1e-4, 1 - 1e-4)]
        columns.append(whiten(difference(*ends)) / 2e-4)
    return np.stack(columns, axis=1) if columns else np.zeros((0, 0))


def left_by(world: World, forces: Sequence[Channels], plain: Sequence[Channels], weight: dict[str, float], J: Array, hold: Array) -> float:
    """Linear estimate of the gap between two responses after a refit, in units of the weight: the channel where it is largest."""
    r = flatten(world, difference(forces, plain), weight)
    left = projected(r, J, hold)
    sizes, at = dict.fromkeys(world.channels, 0.0), 0
    count = dict.fromkeys(world.channels, 0)
    for part in plain:
        for name in world.channels:
            piece = left[at : at + part[name].size]
            sizes[name] += float(piece @ piece)
            count[name] += piece.size
            at += part[name].size
    return max(float(np.sqrt(sizes[name] / count[name])) for name in world.channels)
