"""What is the smallest place that holds most of a square? One range of one quantity, two ranges of it, or a range of each of two."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.model import BoolArray, FloatArray

Box = dict[str, tuple[float, float]]
Window = tuple[float, int, int]  # samples in it, first bin, bin after the last; beyond all bins: it runs over the end


@dataclass(frozen=True)
class _Axis:
    """A quantity in bins, of about as many samples each: its bins' low and high ends, and the bin of each sample. `turns` : it is a phase,
    and a range may run over the end."""

    name: str
    low: FloatArray
    high: FloatArray
    bins: npt.NDArray[np.intp]
    turns: bool

    def summed(self, weights: FloatArray) -> FloatArray:
        return np.bincount(self.bins, weights, self.low.size).astype(np.float64)

    def bounds(self, begin: int, end: int) -> tuple[float, float]:
        if self.turns and end - begin >= self.low.size:
            return 0.0, 1.0
        return float(self.low[begin % self.low.size]), float(self.high[(end - 1) % self.low.size])


def within(column: FloatArray, bounds: tuple[float, float]) -> BoolArray:
    """Which samples lie in a range; one whose low end is above its high end (of a phase) runs over the end of the cycle."""
    low, high = bounds
    above, below = column >= low, column <= high
    return above & below if low <= high else above | below


def smallest_place(energy: FloatArray, columns: Mapping[str, FloatArray], turning: str = "") -> list[tuple[Box, float]]:
    """Boxes with the fewest samples that together hold region_share of the square, and the share that each holds; one without bounds where
    the square lies all over.

    energy : (n,), squares; columns : (n,) each, what a sample can be told by; turning : the one of them that is a phase, 0 to 1.
    """
    total = float(energy.sum())
    if total <= 0:
        return [({}, 0.0)]
    energy = energy / total
    regions = sorted(_places(energy, columns, turning), key=lambda place: place[0])
    if not regions or regions[0][0] > (CONSTANTS.region_share - CONSTANTS.region_concentration) * energy.size:
        return [({}, 1.0)]
    shares = []
    for box in regions[0][1]:
        inside = np.ones(energy.size, dtype=bool)
        for name, bounds in box.items():
            inside &= within(columns[name], bounds)
        shares.append((box, float(energy[inside].sum())))
    return sorted(shares, key=lambda each: -each[1])


def _places(energy: FloatArray, columns: Mapping[str, FloatArray], turning: str) -> Iterator[tuple[float, list[Box]]]:
    """Places with what they cost: their samples, more for those of two parts."""
    varying = {name: column for name, column in columns.items() if np.ptp(column) > 0}
    for name, column in varying.items():
        axis = _axis(name, column, name == turning, CONSTANTS.region_bins)
        sums, counts = axis.summed(energy), axis.summed(np.ones(energy.size))
        if one := _window(sums, counts, CONSTANTS.region_share, axis.turns):
            yield one[0], [{name: axis.bounds(one[1], one[2])}]
        if two := _two_windows(sums, counts, axis.turns):
            yield two[0] / CONSTANTS.region_simplicity, [{name: axis.bounds(begin, end)} for begin, end in two[1]]
    coarse = [_axis(name, column, name == turning, CONSTANTS.region_bins_of_two) for name, column in varying.items()]
    for first, second in combinations(coarse, 2):
        if rectangle := _rectangle(first, second, energy):
            samples, rows, own = rectangle
            yield samples / CONSTANTS.region_simplicity, [{first.name: first.bounds(*rows), second.name: second.bounds(*own)}]


def _axis(name: str, column: FloatArray, turns: bool, most: int) -> _Axis:
    values = np.unique(column)
    if turns:
        edges = np.linspace(0.0, 1.0, most + 1)
    elif values.size <= most:
        return _Axis(name, values, values, np.searchsorted(values, column), turns)
    else:
        edges = np.unique(np.quantile(column, np.linspace(0.0, 1.0, most + 1)))
    bins = np.clip(np.searchsorted(edges, column, side="right") - 1, 0, edges.size - 2)
    return _Axis(name, edges[:-1], edges[1:], bins, turns)


def _sums(row: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(row)])


def _window(sums: FloatArray, counts: FloatArray, wanted: float, turns: bool) -> Window | None:
    """The range of bins with the fewest samples that holds as much of the square."""
    size = sums.size
    held, samples = (_sums(np.tile(row, 2) if turns else row) for row in (sums, counts))
    begins = np.arange(size)
    ends = np.searchsorted(held, held[begins] + wanted - CONSTANTS.region_rounding)
    good = np.flatnonzero((ends < held.size) & (ends - begins <= size))
    if not good.size:
        return None
    costs = samples[ends[good]] - samples[begins[good]]
    best = int(np.argmin(costs))
    return float(costs[best]), int(begins[good[best]]), int(ends[good[best]])


def _two_windows(sums: FloatArray, counts: FloatArray, turns: bool) -> tuple[float, list[tuple[int, int]]] | None:
    """The two ranges of bins with the fewest samples that together hold region_share; of a phase the cycle is cut open between any two."""
    size, best = sums.size, (np.inf, list[tuple[int, int]]())
    i, j, k = _apart(size)
    for turn in range(size if turns else 1):
        held, samples = _sums(np.roll(sums, -turn)), _sums(np.roll(counts, -turn))
        first = held[j] - held[i]
        need = np.maximum(CONSTANTS.region_share - first, CONSTANTS.region_part)
        end = np.searchsorted(held, held[k] + need - CONSTANTS.region_rounding)
        good = np.flatnonzero((first >= CONSTANTS.region_part) & (end <= size))
        if not good.size:
            continue
        costs = samples[j[good]] - samples[i[good]] + samples[end[good]] - samples[k[good]]
        place = int(np.argmin(costs))
        if costs[place] < best[0]:
            at = good[place]
            best = (float(costs[place]), [(int(i[at]) + turn, int(j[at]) + turn), (int(k[at]) + turn, int(end[at]) + turn)])
    return best if best[1] else None


def _apart(size: int) -> Sequence[npt.NDArray[np.intp]]:
    """First bin and bin after the last of a range, and first bin of one behind it, at least one bin between them."""
    i, j, k = (each.ravel() for each in np.meshgrid(*[np.arange(size + 1)] * 3, indexing="ij"))
    good = (i < j) & (j < k) & (k < size)
    return i[good], j[good], k[good]


def _rectangle(first: _Axis, second: _Axis, energy: FloatArray) -> tuple[float, tuple[int, int], tuple[int, int]] | None:
    """The ranges of two quantities with the fewest samples that hold region_share where both are met."""
    shape = (first.low.size, second.low.size)
    flat: Any = first.bins * shape[1] + second.bins
    tables = [np.bincount(flat, weights, shape[0] * shape[1]).reshape(shape) for weights in (energy, np.ones(energy.size))]
    rows = [np.cumsum(np.pad(np.tile(table, (2, 1)) if first.turns else table, ((1, 0), (0, 0))), axis=0) for table in tables]
    best: tuple[float, tuple[int, int], tuple[int, int]] | None = None
    for begin in range(shape[0]):
        for end in range(begin + 1, (begin + shape[0] if first.turns else shape[0]) + 1):
            window = _window(rows[0][end] - rows[0][begin], rows[1][end] - rows[1][begin], CONSTANTS.region_share, second.turns)
            if window is not None and (best is None or window[0] < best[0]):
                best = window[0], (begin, end), (window[1], window[2])
    return best
