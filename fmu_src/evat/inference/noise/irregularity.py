"""What comes and goes by itself? Bursts, lines and wander in what repeats of a recording do not share, which no noise has.

A chatter line, a built-up edge that grows and breaks off, a hum, a level that jumps or wanders: their phase or moment differs from repeat
to repeat, so no model of the contact can have them, and they are no noise either. A single outlier is no burst; a filter of the noise is no
line; a straight drift is no wander, since every amplifier has one. What fills a recording is told by conditions that do not have it, if it
is larger there and smoother, too: noise that grows with the force keeps its spectrum. What fills stretches of recordings
is told by the others, in the same way.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import binary_dilation, median_filter
from scipy.stats import kurtosis

from evat.constants import CONSTANTS
from evat.inference.noise.autoregression import autocovariance, robust_sd
from evat.inference.noise.calm_windows import autoregression_where_calm, innovation_sd_where_calm, window_count
from evat.model import BoolArray, FloatArray


@dataclass(frozen=True)
class Irregularity:
    """Of one channel: the mean square of what repeats do not share [unit squared], the shares of it in bursts, in lines, in wander and in
    what some conditions have beside these and others have not, in stretches that are smoother than the noise is where it is calm, and the
    frequency [Hz] of the strongest line, 0 where there is none."""

    square: float = 0.0
    bursts: float = 0.0
    lines: float = 0.0
    frequency: float = 0.0
    wander: float = 0.0
    of_some_conditions: float = 0.0
    smooth: float = 0.0

    @property
    def share(self) -> float:
        return min(self.bursts + self.lines + self.wander + self.of_some_conditions + self.smooth, 1.0)

    def __str__(self) -> str:
        """What it is, the largest first, as a person reads it."""
        line = f"a line at {self.frequency:.4g} Hz" if self.frequency else "lines"
        kinds = {
            "a level that jumps or wanders": self.wander,
            "bursts": self.bursts,
            line: self.lines,
            "what some conditions alone have": self.of_some_conditions,
            "stretches that are smoother than the noise": self.smooth,
        }
        return ", ".join(f"{kind} ({share:.0%})" for kind, share in sorted(kinds.items(), key=lambda each: -each[1]) if share >= 0.01)


def bursts(row: FloatArray) -> BoolArray:
    """Which samples of a difference between repeats lie in a burst, and not in the tail of one shock to noise that goes on."""
    if row.size < CONSTANTS.fewest_regular_samples:
        return np.zeros(row.size, dtype=bool)
    memory = _memory(row)
    shocks = np.concatenate([row[:1], row[1:] - memory * row[:-1]])
    middle = median_filter(shocks, CONSTANTS.burst_samples)
    away = np.abs(middle - np.median(middle))
    size = 1.4826 * float(np.median(away))
    if size <= 0:
        return np.zeros(row.size, dtype=bool)
    return np.asarray(binary_dilation(away > CONSTANTS.burst_height * size, iterations=CONSTANTS.burst_samples // 2), dtype=bool)


def _memory(row: FloatArray) -> float:
    """Lag-one correlation of a row, as a first-order autoregression has it."""
    return float(np.clip(_quadrant_correlation([row - np.median(row)]), 0.0, 0.99))


def _quadrant_correlation(rows: Sequence[FloatArray]) -> float:
    """Lag-one correlation by the signs of the samples: bursts and jumps, large as they may be, are few."""
    signs = [np.sign(row) for row in rows]
    return float(np.sin(np.pi / 2 * np.mean(np.concatenate([row[1:] * row[:-1] for row in signs]))))


def lines(row: FloatArray) -> tuple[float, float, int]:
    """Share of a row's mean square in lines of its spectrum, and the strongest: how far above the spectrum around, and its place."""
    if row.size < CONSTANTS.fewest_regular_samples:
        return 0.0, 0.0, 0
    memory = float(np.clip(row[1:] @ row[:-1] / (row @ row + 1e-300), -0.99, 0.99))
    squares, plain = _spectrum(row[1:] - memory * row[:-1]), _spectrum(row[1:])
    around = median_filter(squares, max(21, squares.size // 10 * 2 + 1)) / np.log(2)  # the median of an exponential variable
    above = squares / (around + 1e-300)
    above[:2] = 0.0
    strongest = int(np.argmax(above))
    share = float(plain[above > CONSTANTS.line_height].sum() / plain.sum()) if plain.sum() > 0 else 0.0
    return share, float(above[strongest]), strongest


def without_lines(row: FloatArray) -> FloatArray:
    """A row less the sines at the lines of its spectrum: they are no noise, and an autoregression would take them for it."""
    places = np.arange(row.size)
    for _ in range(int(CONSTANTS.most_lines)):
        _, above, strongest = lines(row)
        if above <= CONSTANTS.line_height:
            break
        numbers = (strongest + np.linspace(-1.0, 1.0, 33)) / (row.size - 1)  # a line lies between two places of a spectrum
        best = numbers[int(np.argmax(np.abs(np.exp(-2j * np.pi * np.outer(numbers, places)) @ row)))]
        row = _remainder(row, np.column_stack([np.cos(2 * np.pi * best * places), np.sin(2 * np.pi * best * places)]))
    return row


def _spectrum(row: FloatArray) -> FloatArray:
    squares: FloatArray = np.abs(np.fft.rfft((row - row.mean()) * np.hanning(row.size))) ** 2
    return squares


def wander(rows: Sequence[FloatArray], predicted: Sequence[FloatArray]) -> float:
    """Mean square of baseline wander in what repeats do not share [unit squared].

    Of a level, or of a friction that changes its sign with the motion: what the slowest periods of a recording hold beyond what a
    first-order autoregression would that has the next ones, a straight drift aside.

    Parameters
    ----------
    rows, predicted : of each recording the difference from its repeats, and what is predicted of it; (n,) each.
    """
    periods = int(CONSTANTS.wander_periods)
    long = [(row, own) for row, own in zip(rows, predicted, strict=True) if row.size >= 8 * periods + 2]
    levels = [_without_drift(row, own) for row, own in long]
    # Differences of a first-order autoregression have a lag-one correlation of -(1 - memory)/2, and a jump is one of many. What is smoother
    # than any such noise is none. Short recordings tell the memory coarsely: the longest that they allow counts.
    thinned = [_without_shift(row, own)[:: _every(row)] for row, own in long]
    if not thinned:
        return 0.0
    of_differences = _quadrant_correlation([np.diff(row) for row in thinned])
    longest = 1 + 2 * of_differences + CONSTANTS.memory_deviations * np.pi / np.sqrt(sum(row.size for row in thinned))
    memory = 0.0 if of_differences > CONSTANTS.smooth_differences else float(np.clip(longest, 0.0, 0.99))
    ways = (levels, [level * np.sign(own) for level, (_, own) in zip(levels, long, strict=True)])
    return max(_slow_excess(way, periods, memory) for way in ways)


def _slow_excess(rows: Sequence[FloatArray], periods: int, memory: float) -> float:
    """Mean square in the slowest periods beyond that of noise with this memory of thinned samples."""
    slow = expected = 0.0
    for row in rows:
        squares = 2 * np.abs(np.fft.rfft(row - row.mean())[1 : 4 * periods + 1]) ** 2 / row.size
        angles = 2 * np.pi * np.arange(1, 4 * periods + 1) / -(-row.size // _every(row))
        of_noise = 1 / (1 - 2 * memory * np.cos(angles) + memory**2)
        slow += float(squares[:periods].sum())
        expected += float(squares[periods:].mean() * of_noise[:periods].sum() / of_noise[periods:].mean())
    return (slow - expected) / sum(row.size for row in rows) if slow > CONSTANTS.wander_height * expected else 0.0


def _every(row: FloatArray) -> int:
    """Of how many samples one is enough to tell what is slow."""
    return max(1, row.size // int(CONSTANTS.wander_samples))


def _without_drift(row: FloatArray, own: FloatArray) -> FloatArray:
    """A row less its mean, and less a straight drift of zero and gain unless a single shift of its level explains more."""
    free, straight = row - row.mean(), _remainder(row, _drifts(own))
    by_shift = max(explains for _, explains in _shifts(row, own))
    return free if by_shift > free @ free - straight @ straight else straight


def _without_shift(row: FloatArray, own: FloatArray) -> FloatArray:
    """A row less drift, gain, clock and a single shift of its level: what was fitted where a large one was leaves something of each."""
    steps = [level for level, _ in _shifts(row, own)]
    return _remainder(row, np.column_stack([_drifts(own), own, np.gradient(own), *steps]))


def _drifts(own: FloatArray) -> FloatArray:
    course = np.linspace(-1.0, 1.0, own.size)
    return np.column_stack([np.ones(own.size), course, course * own / (np.sqrt(np.mean(own**2)) + 1e-300)])


def _shifts(row: FloatArray, own: FloatArray) -> list[tuple[FloatArray, float]]:
    """Where the level shifts most, as it stands and against the motion: the level (n,), and the square that it explains."""
    before, shifts = np.arange(1, row.size), list[tuple[FloatArray, float]]()
    for way in (np.ones(row.size), np.sign(own)):
        level = (row - row.mean()) * way
        explains = np.cumsum(level - level.mean())[:-1] ** 2 * row.size / (before * (row.size - before))
        place = int(np.argmax(explains))
        shifts.append((way * (np.arange(row.size) > place), float(explains[place])))
    return shifts


def _remainder(row: FloatArray, basis: FloatArray) -> FloatArray:
    left: FloatArray = row - basis @ np.linalg.lstsq(basis, row, rcond=None)[0]
    return left


def of_some_conditions(rows: Sequence[FloatArray], conditions: Sequence[Hashable]) -> float:
    """Sum of squares in the rows of conditions that scatter more, and more smoothly, than the quietest does, beyond what that has."""
    of_condition: dict[Hashable, list[FloatArray]] = {}
    for row, condition in zip(rows, conditions, strict=True):
        of_condition.setdefault(condition, []).append(row - np.median(row))
    known = [own for own in of_condition.values() if sum(row.size for row in own) >= CONSTANTS.fewest_regular_samples]
    if len(known) < 2:
        return 0.0
    squares = np.array([robust_sd(np.concatenate(own)) ** 2 for own in known])
    memories = np.array([_quadrant_correlation(own) for own in known])
    quietest = int(np.argmin(squares))
    larger = squares > CONSTANTS.unequal_noise**2 * squares[quietest]
    smoother = memories > memories[quietest] + CONSTANTS.unequal_memory
    counts = np.array([sum(row.size for row in own) for own in known])
    return float(np.sum((counts * (squares - squares[quietest]))[larger & smoother]))


def smoother_than_calm(rows: Sequence[FloatArray], predicted: Sequence[FloatArray]) -> float:
    """Sum of squares in the rows (n,) beyond what noise has that goes on as it does where it is calm; lines and bursts, which are told by
    themselves, aside. 0 where that is not told, and where it is a slow noise of its own. predicted : of each, (n,)."""
    clear, own = list[FloatArray](), list[FloatArray]()
    for row, force in zip(map(without_lines, rows), predicted, strict=True):
        quiet = ~bursts(row)
        if np.count_nonzero(quiet) >= CONSTANTS.calm_window:  # a burst may fill a recording
            clear.append(row[quiet])
            own.append(force[quiet])
    windows = window_count(clear)
    filter_ = autoregression_where_calm(clear)
    if filter_ is None or _changes_as_noise(clear, own):
        return 0.0
    chance = float(np.exp(CONSTANTS.calm_deviations / np.sqrt(windows)))
    calm = float(autocovariance(filter_, 1)[0]) * sum(row.size * innovation_sd_where_calm(filter_, row) ** 2 for row in clear)
    return max(sum(row.size * robust_sd(row) ** 2 for row in clear) - chance * calm, 0.0)


def _changes_as_noise(rows: Sequence[FloatArray], predicted: Sequence[FloatArray]) -> bool:
    """Whether the level of rows (n,) changes over a quarter of a window by what is normally distributed, as of noise, however slow: what
    builds up and breaks off, and what comes in stretches, has a few large changes beside many small ones. So do repeats that are out of
    step, where the force jumps: there nothing is asked."""
    some = int(CONSTANTS.calm_window) // 4
    changes, steady = list[FloatArray](), list[BoolArray]()
    for row, own in zip(rows, predicted, strict=True):
        level = np.convolve(row, np.full(some, 1 / some), mode="valid")
        beside = sliding_window_view(np.pad(own, some, mode="edge"), 4 * some)  # a quarter of a window to either side
        changes.append(level[some:] - level[:-some])
        steady.append(beside.max(axis=1) - beside.min(axis=1) <= CONSTANTS.jump_of_prediction * np.ptp(own))
    every, asked = np.concatenate(changes), np.concatenate(steady)
    if 2 * np.count_nonzero(asked) > asked.size:  # else the motion is so quick that nothing is left
        every = every[asked]
    chance = np.sqrt(24 * CONSTANTS.calm_window / every.size)  # standard error of a kurtosis; neighbours have most of a window in common
    return bool(kurtosis(every) <= CONSTANTS.heavy_tails * chance)


def irregular(
    rows: Sequence[FloatArray], steps: Sequence[float], predicted: Sequence[FloatArray], conditions: Sequence[Hashable] = ()
) -> Irregularity:
    """Of all differences (n,) between repeats of one channel; steps : their sample times [s]; predicted : (n,) of each; conditions : of
    each, where there are several."""
    total = sum(float(row @ row) for row in rows)
    if total <= 0:
        return Irregularity()
    count = sum(row.size for row in rows)
    in_bursts = sum(float(np.sum(row[bursts(row)] ** 2)) for row in rows)
    line_of_row = [(*lines(row), row.size, step, float(row @ row)) for row, step in zip(rows, steps, strict=True)]
    in_lines = sum(share * square for share, *_, square in line_of_row)
    _, above, place, size, step, _ = max(line_of_row, key=lambda line: line[1])
    frequency = place / ((size - 1) * step) if above > CONSTANTS.line_height else 0.0
    wanders, level = wander(rows, predicted), sum(float(own @ own) for own in predicted) / count
    share = wanders * count / total if wanders > CONSTANTS.least_wander**2 * level else 0.0
    of_some = of_some_conditions(rows, conditions) / total if conditions else 0.0
    of_some = max(of_some - (in_bursts + in_lines) / total - share, 0.0)
    smooth = max(smoother_than_calm(rows, predicted) / total - share - of_some, 0.0)
    return Irregularity(total / count, in_bursts / total, in_lines / total, frequency, share, of_some, smooth)
