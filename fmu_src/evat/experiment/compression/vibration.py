"""Where does a recording of a vibration stand still but for its cycles, and at which phase is it there?

The phase is measured, since no generator and no recorder share a clock for minutes: by demodulation, window after window.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize_scalar
from scipy.signal.windows import hann

from evat.experiment.compression.stretches import Stretch, plain
from evat.model import FloatArray

WINDOW, FEWEST_CYCLES = 4096, 16  # rows, and cycles, of a window at least
SEARCHED = 0.02  # of the frequency that the model has, to each side
STANDS_OUT = 30.0  # times the spectrum around, from which a line is a vibration; noise reaches 5
LEAP = 8.0  # robust standard deviations of the change from window to window,
CHANGE = 0.01  # and of the amplitude: a change above both is a transient
FAINT = 0.2  # of the usual amplitude, below which nothing vibrates
SHORTEST = 4  # windows of a stretch
WANDER = 0.02  # of a cycle: less is no clock, but what the force does
SLOW = 16  # of a record: what clocks do goes on for as long


def frequency(column: FloatArray, expected: float) -> float | None:
    """Cycles for each row of the strongest line of a column (n,) near the `expected` one; None where nothing stands out there."""
    size = 8 * column.size
    spectrum = np.abs(np.fft.rfft((column - column.mean()) * hann(column.size), size))
    low, high = (int(expected * (1 + side * SEARCHED) * size) for side in (-1, 1))
    low, high = max(low - 8, 1), min(high + 8, spectrum.size - 2)
    if high <= low:
        return None
    place = low + int(np.argmax(spectrum[low : high + 1]))
    if spectrum[place] < STANDS_OUT * np.median(spectrum):
        return None
    before, here, after = np.log(spectrum[place - 1 : place + 2] + 1e-300)
    bend = before - 2 * here + after
    return float((place + (0.5 * (before - after) / bend if bend else 0.0)) / size)


class Demodulation:
    """Windows of `window` rows each: `means` (windows, columns) and complex `amplitudes` (windows, columns) at `turns` cycles a row."""

    def __init__(self, batches: Iterable[Sequence[FloatArray]], turns: float) -> None:
        self.turns, self.rows = turns, 0
        self.window = max(WINDOW, int(np.ceil(FEWEST_CYCLES / turns)))
        weights = hann(self.window, sym=False)
        turning = 2 * weights / weights.sum() * np.exp(-2j * np.pi * turns * np.arange(self.window))
        left, means, amplitudes = None, list[FloatArray](), list[FloatArray]()
        for batch in batches:
            table = np.column_stack(batch)
            self.rows += len(table)
            left = table if left is None else np.vstack([left, table])
            count = len(left) // self.window
            whole = left[: count * self.window].reshape(count, self.window, left.shape[1])
            means.append(np.einsum("i,kij->kj", weights / weights.sum(), whole))
            amplitudes.append(np.einsum("i,kij->kj", turning, whole))
            left = left[count * self.window :]
        begins = self.window * np.arange(sum(map(len, means)))
        self.means: FloatArray = np.concatenate(means)
        self.amplitudes = np.concatenate(amplitudes) * np.exp(-2j * np.pi * np.mod(turns * begins, 1.0))[:, None]

    def times(self, rows: FloatArray) -> FloatArray:
        """The clock [s], which is the first column, at rows, whole or not."""
        slope = (self.means[-1, 0] - self.means[0, 0]) / max(self.window * (len(self.means) - 1), 1)
        away = np.asarray(rows) - np.clip(rows, self.middles[0], self.middles[-1])
        times: FloatArray = np.interp(rows, self.middles, self.means[:, 0]) + slope * away
        return times

    @property
    def middles(self) -> FloatArray:
        """The rows in the middle of the windows."""
        middles: FloatArray = np.asarray(self.window * (np.arange(len(self.means)) + 0.5), dtype=np.float64)  # of Hann's periodic window
        return middles


def steady(demodulation: Demodulation, told_by: int) -> list[Stretch]:
    """The whole record, piece after piece. told_by : the column that tells the phase, best one that moves the contact."""
    amplitude = demodulation.amplitudes
    if len(amplitude) < 2 * SHORTEST:
        return [plain("transient", 0, demodulation.rows)]
    reference = amplitude[:, told_by]
    usual = float(np.median(np.abs(reference)))
    phase = _phase(reference, np.abs(reference) >= FAINT * usual)  # what the clocks do is no change: all amplitudes are turned back
    turned = amplitude * np.exp(-2j * np.pi * phase)[:, None]
    seen = np.column_stack([demodulation.means, turned.real, turned.imag])
    scale = np.tile(np.median(np.abs(amplitude), axis=0) + np.median(np.abs(demodulation.means), axis=0) + 1e-300, 3)
    change = np.abs(np.diff(seen, axis=0)) / scale
    usual_change = 1.4826 * np.median(change, axis=0)
    leaps = np.any(change > np.maximum(LEAP * usual_change, CHANGE), axis=1)
    broken = np.zeros(len(seen), dtype=bool)
    broken[:-1] |= leaps
    broken[1:] |= leaps
    broken |= np.abs(reference) < FAINT * usual
    turns = demodulation.turns * demodulation.middles + phase
    course, at = list[Stretch](), 0
    edges = np.flatnonzero(np.diff(np.concatenate([[True], broken, [True]]).astype(int)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if last - first < SHORTEST:
            continue
        begin = int(first) * demodulation.window if first else 0
        end = int(last) * demodulation.window if last < len(seen) else demodulation.rows
        if begin > at:
            course.append(plain("transient", at, begin))
        rows, phases = demodulation.middles[first:last], turns[first:last]
        slope = demodulation.turns
        rows = np.concatenate([[begin], rows, [end]])
        phases = np.concatenate([[phases[0] - slope * (rows[1] - begin)], phases, [phases[-1] + slope * (end - rows[-2])]])
        course.append(Stretch("repeating", begin, end, rows, phases))
        at = end
    if at < demodulation.rows:
        course.append(plain("transient", at, demodulation.rows))
    return course


def _phase(reference: npt.NDArray[np.complex128], sound: npt.NDArray[np.bool_]) -> FloatArray:
    """Phases (windows,) in cycles, of those that are `sound`, straight in between.

    As two clocks make them that differ in rate alone, unless they wander by more than WANDER: what a condition that drifts does to the
    phase of a force stays in the force.
    """
    count, some = np.arange(reference.size), np.where(sound, reference, 0.0) * hann(reference.size + 2)[1:-1]
    # Sampled a few times in a cycle, harmonics fold onto the fundamental and beat with it: they are lines of their own in the spectrum.
    padded = 1 << int(np.ceil(np.log2(8 * reference.size)))
    coarse = float(np.fft.fftfreq(padded)[np.argmax(np.abs(np.fft.fft(some, padded)))])

    def line(slope: float) -> complex:
        return complex(np.sum(some * np.exp(-2j * np.pi * slope * count)))

    best = minimize_scalar(lambda slope: -abs(line(slope)), bounds=(coarse - 1 / padded, coarse + 1 / padded), options={"xatol": 1e-9})
    slope = float(best.x)
    straight = slope * count + np.angle(line(slope)) / (2 * np.pi)
    left = (reference * np.exp(-2j * np.pi * straight))[sound]
    mean = uniform_filter1d(np.array([left.real, left.imag]), max(left.size // SLOW, 1), axis=1, mode="nearest")
    wander = np.unwrap(np.arctan2(mean[1], mean[0])) / (2 * np.pi)
    if np.percentile(np.abs(wander), 90) < WANDER:
        return np.asarray(straight, dtype=np.float64)
    return np.asarray(straight + np.interp(count, count[sound], wander), dtype=np.float64)
