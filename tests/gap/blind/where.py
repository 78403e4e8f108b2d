"""Where does a gap lie? The smallest boxes over a signal, the phase, the time or two of them that hold 80 % of its square."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from radau import Array
from world import Channels, World

SHARE = 0.8
BINS, COARSE = 48, 14
DEARER = 0.75
SLIGHT = (0.03, 0.2)  # of the squared gap: channels below it have no place, above it must have one


def coordinates(world: World) -> dict[str, list[Array]]:
    """Every quantity that a box may bound, at the samples of each condition."""
    columns: dict[str, list[Array]] = {}
    if world.means:
        names = sorted({name for scene in world.scenes for name in scene.values})
        return {name: [np.array([scene.values[name]]) for scene in world.scenes] for name in names}
    for name in world.scenes[0].signals:
        columns[name] = [scene.signals[name](scene.times) for scene in world.scenes]
    columns["time"] = [scene.times for scene in world.scenes]
    if world.excitation and all(f > 0 for f in world.excitation):
        columns["phase"] = [np.mod(f * scene.times, 1.0) for f, scene in zip(world.excitation, world.scenes, strict=True)]
    names = sorted({name for scene in world.scenes for name in scene.values})
    return columns | {name: [np.full(scene.times.size, scene.values[name]) for scene in world.scenes] for name in names}


def everything(world: World) -> dict[str, list[Array]]:
    """These, and what a diagnosis that computes the motion itself may bound besides."""
    columns = coordinates(world)
    if world.means:
        return columns
    for name, what in (("slip_velocity", "v"), ("uncut_thickness", "h"), ("proxy_speed", "theta"), ("normal_load", "load")):
        columns.setdefault(name, [scene.sampled(getattr(scene, what)[:, 1] * scene.on[:, 1]) for scene in world.scenes])
    columns.setdefault("sliding_distance", [scene.sampled(scene.distance[:, 1]) for scene in world.scenes])
    return columns


Box = dict[str, list[float]]
Place = list[tuple[Box, float]]  # boxes and the share of the channel's squared gap in each


def places(world: World, gap: list[Channels]) -> dict[str, list[list[dict[str, Any]]]]:
    """The places of a gap along the coordinates of its world."""
    return places_of(world.channels, coordinates(world), gap)


def places_of(channels: tuple[str, ...], coordinates: dict[str, list[Array]],
              gap: list[Channels]) -> dict[str, list[list[dict[str, Any]]]]:  # fmt: skip
    """Of each channel with a part of the squared gap the smallest place, and others that are hardly larger: there is more than one way to
    say where. A channel with a small part may be left out: then no boxes at all are one of its places, the last."""
    weight = {name: sum(float(part[name] @ part[name]) for part in gap) for name in channels}
    total = sum(weight.values()) or 1.0
    axes = {name: np.concatenate(parts) for name, parts in coordinates.items()}
    places = {}
    for name in channels:
        if weight[name] / total >= SLIGHT[0]:
            energy = np.concatenate([part[name] for part in gap]) ** 2
            places[name] = [
                [{"channel": name, "box": box, "share": share * weight[name] / total} for box, share in place]
                for place in _ranked(_candidates(axes, energy))
            ]
            if weight[name] / total < SLIGHT[1]:
                places[name].append([])
    return places


def _binned(values: Array, count: int) -> tuple[Array, Any]:
    """Edges with about the same number of samples between them, and the bin of each sample."""
    edges = np.unique(np.quantile(values, np.linspace(0, 1, count + 1)))
    if edges.size < 3:
        return edges, np.zeros(values.size, dtype=int)
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    return edges, place


def _candidates(axes: dict[str, Array], energy: Array) -> list[tuple[float, Place, bool]]:
    """Places that hold the share: number of samples in them, boxes, and whether it takes more than one window of one axis."""
    whole = float(np.sum(energy)) or 1.0
    candidates: list[tuple[float, Place, bool]] = [(float(energy.size), [({}, 1.0)], False)]
    for axis, values in axes.items():
        edges, place = _binned(values, BINS)
        if edges.size < 3:
            continue
        e, n = (np.bincount(place, weights, minlength=edges.size - 1) for weights in (energy / whole, np.ones(energy.size)))
        for windows, cost in _windows(e, n):
            boxes: Place = [({axis: [float(edges[i]), float(edges[j])]}, float(np.sum(e[i:j]))) for i, j in windows]
            candidates.append((cost, boxes, len(windows) > 1))
    names = [axis for axis, values in axes.items() if np.unique(values).size > 2]
    for first, second in combinations(names, 2):
        pair = _rectangle(axes[first], axes[second], energy / whole)
        if pair:
            (low_1, high_1, low_2, high_2), cost, share = pair
            candidates.append((cost, [({first: [low_1, high_1], second: [low_2, high_2]}, share)], True))
    return candidates


def _ranked(candidates: list[tuple[float, Place, bool]]) -> list[Place]:
    """The smallest first; what takes two windows or two axes has to be a quarter smaller than what does not. Then those within reach."""
    cost = np.array([size / (DEARER if two else 1.0) for size, _, two in candidates])
    order = np.argsort(cost, kind="stable")
    least = cost[order[0]]
    return [candidates[k][1] for k in order.tolist() if cost[k] <= least / DEARER or k == order[0]]


def _windows(e: Any, n: Any) -> list[tuple[list[tuple[int, int]], float]]:
    """The cheapest single window, and the cheapest two, that hold the share: places and number of samples."""
    E, N = np.concatenate([[0.0], np.cumsum(e)]), np.concatenate([[0.0], np.cumsum(n)])
    i, j = np.triu_indices(E.size, 1)
    inside, cost = E[j] - E[i], N[j] - N[i]
    windows = []
    good = np.flatnonzero(inside >= SHARE)
    if good.size:
        k = good[np.argmin(cost[good])]
        windows.append(([(int(i[k]), int(j[k]))], float(cost[k])))
    order = np.argsort(-inside / np.maximum(cost, 1))[:400]
    a, b = np.meshgrid(order, order, indexing="ij")
    fits = (j[a] < i[b]) & (inside[a] + inside[b] >= SHARE) & (inside[a] > 0.15) & (inside[b] > 0.15)
    if fits.any():
        both = np.where(fits, cost[a] + cost[b], np.inf)
        k_1, k_2 = np.unravel_index(int(np.argmin(both)), both.shape)
        p, q = order[k_1], order[k_2]
        windows.append(([(int(i[p]), int(j[p])), (int(i[q]), int(j[q]))], float(both[k_1, k_2])))
    return windows


def _rectangle(x: Array, y: Array, energy: Array) -> tuple[tuple[float, float, float, float], float, float] | None:
    """The cheapest rectangle over two axes that holds the share."""
    (ex, px), (ey, py) = _binned(x, COARSE), _binned(y, COARSE)
    if ex.size < 3 or ey.size < 3:
        return None
    shape = (ex.size - 1, ey.size - 1)
    flat = px * shape[1] + py
    E, N = (np.bincount(flat, w, minlength=shape[0] * shape[1]).reshape(shape) for w in (energy, np.ones(x.size)))
    E, N = (np.pad(np.cumsum(np.cumsum(a, 0), 1), ((1, 0), (1, 0))) for a in (E, N))
    i, j = np.triu_indices(shape[0] + 1, 1)
    k, m = np.triu_indices(shape[1] + 1, 1)

    def inside(a: Any) -> Any:
        band = a[j] - a[i]
        return band[:, m] - band[:, k]

    cost = np.where(inside(E) >= SHARE, inside(N), np.inf)
    r, c = np.unravel_index(int(np.argmin(cost)), cost.shape)
    if not np.isfinite(cost[r, c]):
        return None
    place = (float(ex[i[r]]), float(ex[j[r]]), float(ey[k[c]]), float(ey[m[c]]))
    return place, float(cost[r, c]), float(inside(E)[r, c])
