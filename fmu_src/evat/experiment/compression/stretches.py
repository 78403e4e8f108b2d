"""Where does a recording repeat itself, where is it held still, and where does it do neither? By its inputs, coarsely seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from evat.experiment.compression.overview import Overview
from evat.experiment.periods import period
from evat.experiment.smoothing import noise_sd
from evat.model import FloatArray

Kind = Literal["repeating", "held", "transient"]

FEWEST_CYCLES = 8  # in a row that are alike: so many are a stretch
COARSEST = 24  # blocks of a cycle; of fewer its shape is not seen
POINTS = 512  # of a cycle that is compared with the one before
ALIKE = 0.03  # of the standard deviation of the cycle, by which cycles that are alike may differ
RANGE = 0.02  # of the standard deviation of the record, over which a held input may range
NOISES = 6.0  # standard deviations of the blocks' noise, added to both
LOOKED = 4096  # blocks in which a period is looked for at a time, thinned where it is longer
STEPS = 512  # of a record, at which a period is looked for
SETTLES, LEAST_TO_SETTLE = 8, 1000  # of a held stretch at most, and of a record at least: so long what is held settles
SHORTEST = 200  # of a record: so much of it, held still, is a stretch


@dataclass(frozen=True)
class Stretch:
    """Rows `begin` to `end` (not included). Of a repeating one `rows` are places, whole or not, at which its phase, counted in cycles, is
    `phases`; it goes straight in between."""

    kind: Kind
    begin: int
    end: int
    rows: FloatArray
    phases: FloatArray

    @property
    def cycles(self) -> int:
        """Whole ones."""
        return int(np.floor(self.phases[-1]) - np.ceil(self.phases[0])) if self.kind == "repeating" else 0


def plain(kind: Kind, begin: int, end: int) -> Stretch:
    return Stretch(kind, begin, end, np.empty(0), np.empty(0))


def stretches(overview: Overview, inputs: list[int]) -> list[Stretch]:
    """The whole record, piece after piece. inputs : the places of its input columns."""
    table = overview.means[:, inputs]
    spread = table.std(axis=0)
    moving = table[:, spread > 1e-9 * np.max(np.abs(table), axis=0, initial=0.0)]
    if not moving.shape[1]:
        return [plain("held", 0, overview.rows)]
    moving = (moving - moving.mean(axis=0)) / moving.std(axis=0)
    noise = max(noise_sd(column[: 1 << 16]) for column in moving.T)
    course = _repeating(overview, moving, noise)
    held = list[Stretch]()
    for begin, end in _between(course, len(moving)):
        held += [
            plain("held", (begin + first) * overview.block, (begin + last) * overview.block)
            for first, last in _held(moving[begin:end], RANGE + NOISES * noise, max(len(moving) // SHORTEST, COARSEST))
        ]
    return _with_transients([*(each for each, _ in course), *held], overview.rows)


def _between(course: list[tuple[Stretch, tuple[int, int]]], count: int) -> list[tuple[int, int]]:
    """The blocks that no repeating stretch has."""
    edges = [0, *(edge for _, blocks in course for edge in blocks), count]
    return [(begin, end) for begin, end in zip(edges[::2], edges[1::2], strict=True) if end > begin]


def _with_transients(some: list[Stretch], rows: int) -> list[Stretch]:
    """All rows, what is left between stretches as transients. How what is held settles belongs to that before it."""
    whole, at = list[Stretch](), 0
    for each in sorted(some, key=lambda stretch: stretch.begin):
        if each.kind == "held" and each.begin:
            settles = min((each.end - each.begin) // SETTLES, max(each.begin - at, rows // LEAST_TO_SETTLE))
            each = plain("held", each.begin + settles, each.end)
        if each.begin > at:
            whole.append(plain("transient", at, each.begin))
        whole.append(each)
        at = each.end
    if at < rows:
        whole.append(plain("transient", at, rows))
    return whole


def _held(moving: FloatArray, most: float, shortest: int) -> list[tuple[int, int]]:
    """First and last (not included) of the blocks over which no column ranges over more than `most`."""
    if len(moving) < shortest:
        return []
    reach = np.max(
        [maximum_filter1d(column, shortest, mode="nearest") - minimum_filter1d(column, shortest, mode="nearest") for column in moving.T],
        axis=0,
    )
    middle = shortest // 2
    starts = np.flatnonzero(reach[middle : len(moving) - (shortest - 1 - middle)] <= most)
    pieces, at = list[tuple[int, int]](), 0
    while (place := np.searchsorted(starts, at)) < starts.size:
        begin, size = int(starts[place]), 2 * shortest
        while True:
            piece = moving[begin : begin + size]
            ranges = np.max(np.maximum.accumulate(piece) - np.minimum.accumulate(piece), axis=1)
            if ranges[-1] > most or begin + size >= len(moving):
                break
            size *= 2
        at = begin + int(np.searchsorted(ranges, most, side="right"))
        pieces.append((begin, at))
    return pieces


def _repeating(overview: Overview, moving: FloatArray, noise: float) -> list[tuple[Stretch, tuple[int, int]]]:
    """Stretches that repeat themselves, each with its first and last (not included) block."""
    course, at, free, step = list[tuple[Stretch, tuple[int, int]]](), 0, 0, max(len(moving) // STEPS, COARSEST)
    while at + FEWEST_CYCLES * COARSEST < len(moving):
        starts = _cycles(moving, at, free, noise)
        if starts is None:
            at += step
            continue
        first, last = max(int(np.ceil(starts[0])), free), min(int(np.floor(starts[-1])) + 1, len(moving))
        starts = starts[1:-1]  # the force of the first cycle, and maybe the motion of the last, is not that of the others
        rows = _straightened(starts) * overview.block + (overview.block - 1) / 2
        begin, end = max(int(np.ceil(rows[0])), free * overview.block), min(int(np.floor(rows[-1])), overview.rows)
        course.append((Stretch("repeating", begin, end, rows, np.arange(rows.size, dtype=np.float64)), (first, last)))
        at = free = last
    return course


def _cycles(moving: FloatArray, at: int, free: int, noise: float) -> FloatArray | None:
    """Where cycles begin, the end of the last one included; None where nothing repeats itself from `at` on. free : where the last
    stretch ended."""
    length = 1 << 8
    while True:
        window = moving[at : at + length]
        thin = max(len(window) // LOOKED, 1)
        seen = window[: len(window) // thin * thin].reshape(-1, thin, window.shape[1]).mean(axis=1)
        varying = [column - column.mean() for column in seen.T if np.ptp(column) > ALIKE]
        cycle = thin * max((period(column) for column in varying), default=0.0)
        if cycle >= COARSEST:
            starts = _followed(moving, at, cycle, free, noise)
            if starts.size > FEWEST_CYCLES + 2:
                return starts
        if at + length >= len(moving):
            return None
        length *= 2


def _followed(moving: FloatArray, at: int, cycle: float, free: int, noise: float) -> FloatArray:
    """From the cycle that begins at `at` on and back, as long as one is like those before."""
    points = min(int(cycle), POINTS)
    first = _cycle(moving, float(at), cycle, points)
    if first is None:
        return np.empty(0)
    forward, cycle = _one_way(moving, float(at), cycle, first, 1, noise)
    back, _ = _one_way(moving, float(at), cycle, first, -1, noise)
    back = [start for start in back if start >= free]
    starts = [*reversed(back), float(at), *forward]
    return np.array([*starts, starts[-1] + cycle]) if starts[-1] + cycle <= len(moving) - 1 else np.array(starts)


def _one_way(moving: FloatArray, at: float, cycle: float, like: FloatArray, way: int, noise: float) -> tuple[list[float], float]:
    """Where the cycles after (way 1) or before (-1) it begin, and how long a cycle is in the end."""
    starts, like = list[float](), like.copy()
    begin, points = at, len(like)
    most = ALIKE * float(np.sqrt(np.mean(np.var(like, axis=0)))) + 2 * noise
    while True:
        here, slope = begin + way * cycle, (np.roll(like, -1, axis=0) - np.roll(like, 1, axis=0)) * points / (2 * cycle)
        for _ in range(3):
            seen = _cycle(moving, here, cycle, points)
            if seen is None:
                return starts, cycle
            shift = float(np.sum((like - seen) * slope) / np.sum(slope * slope))
            here += float(np.clip(shift, -cycle / 20, cycle / 20))
            if abs(shift) < 1e-3 * cycle / points:
                break
        seen = _cycle(moving, here, cycle, points)
        if seen is None or np.sqrt(np.mean((seen - like) ** 2)) > most:
            return starts, cycle
        starts.append(here)
        begin = here
        cycle = abs(here - at) / len(starts)
        like += (seen - like) / min(len(starts) + 1, 16)


def _cycle(moving: FloatArray, begin: float, cycle: float, points: int) -> FloatArray | None:
    """A cycle as (points, columns); None where the record does not hold it."""
    places = begin + np.arange(points) * cycle / points
    if places[0] < 0 or places[-1] > len(moving) - 1:
        return None
    left = np.minimum(places.astype(int), len(moving) - 2)
    share = (places - left)[:, None]
    return np.asarray((1 - share) * moving[left] + share * moving[left + 1])


def _straightened(starts: FloatArray) -> FloatArray:
    """The same on a straight line where they scatter about it by less than they are known: the clock of the motion does not wander."""
    count = np.arange(starts.size)
    line = np.polynomial.Polynomial.fit(count, starts, 1)(count)
    wander = starts - line
    scatter = np.diff(wander)
    slow = np.sqrt(np.mean(wander**2)) > 2 * np.sqrt(np.mean(scatter**2) / 2) + 1e-9
    return np.asarray(starts if slow else line)
