"""What does a piece of a long recording tell? Averages over its cycles, or over short times of it, in two halves that tell the noise.

Each half takes as much from the begin and the end of the piece as from its middle (quarters 1 and 4, and 2 and 3): what drifts straight
through the piece is the same in both, and noise that goes on from cycle to cycle is not shared but where quarters meet.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_filter

from evat.experiment.compression.stretches import Stretch
from evat.model import FloatArray

FINE = 5  # bins for each point; points are local parabolas over those of their neighbours
JUMP = 0.05  # of the range of an input in the piece, by which a straight line between points may miss it
AFTER_JUMP = 8  # points until the contact has slid on from one
EDGE = 1e-6  # of a bin: a row at the edge of one falls on the same side in every cycle, whatever the rounding
HALF_OF_QUARTER = np.array([0, 1, 1, 0])


@dataclass
class Piece:
    """Rows `begin` to `end` (not included) of a stretch, to become `points` points of a cycle, or of the time between. `fine` bins make a
    point. Sums are (halves, columns, bins)."""

    stretch: Stretch
    begin: int
    end: int
    points: int
    fine: int
    halves: int
    inputs: tuple[int, ...] = ()  # places of the columns that no point may misrepresent
    sums: FloatArray = field(init=False)
    counts: FloatArray = field(init=False)
    offsets: FloatArray = field(init=False)  # of the rows from the begin of their bin, in bins
    squares: FloatArray = field(init=False)  # (columns,), of all rows

    def __post_init__(self) -> None:
        self.counts = np.zeros((self.halves, self.bins))
        self.offsets = np.zeros((self.halves, self.bins))

    @property
    def bins(self) -> int:
        return self.points * self.fine

    @property
    def phases(self) -> tuple[float, float]:
        """At its begin and its end, in cycles."""
        first, last = np.interp([self.begin, self.end], self.stretch.rows, self.stretch.phases)
        return float(first), float(last)

    def add(self, first: int, columns: list[FloatArray]) -> None:
        """Rows from `first` on, as far as they lie in this piece."""
        low, high = max(self.begin - first, 0), min(self.end - first, columns[0].size)
        if high <= low:
            return
        if not hasattr(self, "sums"):
            self.sums, self.squares = np.zeros((self.halves, len(columns), self.bins)), np.zeros(len(columns))
        rows = np.arange(first + low, first + high)
        places, halves = self._places(rows)
        whole = np.minimum(places.astype(np.intp), self.bins - 1)
        at = halves * self.bins + whole
        size = self.halves * self.bins
        self.counts += np.bincount(at, minlength=size).reshape(self.halves, self.bins)
        self.offsets += np.bincount(at, places - whole, size).reshape(self.halves, self.bins)
        for place, column in enumerate(columns):
            own = column[low:high]
            self.sums[:, place] += np.bincount(at, own, size).reshape(self.halves, self.bins)
            self.squares[place] += float(own @ own)

    def _places(self, rows: npt.NDArray[np.intp]) -> tuple[FloatArray, npt.NDArray[np.intp]]:
        """In which bin each row lies, whole or not, and in which half."""
        if self.stretch.kind == "repeating":
            first, last = self.phases
            phases = np.interp(rows, self.stretch.rows, self.stretch.phases)
            places, share = (phases % 1.0) * self.bins + EDGE, (phases - first) / (last - first)
        else:
            places = np.asarray((rows - self.begin) * (self.bins / (self.end - self.begin)), dtype=np.float64)
            share = places % 1.0
        quarter = np.clip((4 * share).astype(np.intp), 0, 3)
        return places, HALF_OF_QUARTER[quarter] if self.halves == 2 else np.zeros_like(quarter)

    def averages(self) -> tuple[FloatArray, FloatArray]:
        """Places of the points within the piece, 0 to 1, and their values (halves, columns, points)."""
        full = np.all(self.counts > 0, axis=0)
        means = self.sums[:, :, full] / self.counts[:, None, full]
        if self.fine == 1 or not full.all():  # few rows, or locked to the cycle: where they lie they tell, and nowhere else
            return (np.flatnonzero(full) + self._within[full]) / self.bins, means
        places = np.asarray((np.arange(self.points) + 0.5) / self.points + (self._within.mean() - 0.5) / self.bins)
        cyclic = self.stretch.kind == "repeating"
        window = min(2 * self.fine + 1, (self.bins - 1) // 2 * 2 + 1)
        smooth = savgol_filter(means, window, min(2, window - 1), axis=2, mode="wrap" if cyclic else "interp")
        points = smooth[:, :, self.fine // 2 :: self.fine]
        kept = self._shown(means[:, list(self.inputs)].mean(axis=0), points[:, list(self.inputs)].mean(axis=0), places)
        return places[kept], points[:, :, kept]

    @property
    def _within(self) -> FloatArray:
        """Where the rows of each bin lie on the average, in bins from its begin; nan of none."""
        with np.errstate(invalid="ignore"):
            within: FloatArray = self.offsets.sum(axis=0) / self.counts.sum(axis=0)
        return within

    def _shown(self, means: FloatArray, points: FloatArray, places: FloatArray) -> npt.NDArray[np.bool_]:
        """Which points (n,) lie beside no jump of an input (inputs, bins) that a straight line between points (inputs, n) misses."""
        inner, missed = (np.arange(self.bins) + 0.5) / self.bins, np.zeros(self.bins, dtype=bool)
        for fine, coarse in zip(means, points, strict=True):
            missed |= np.abs(fine - np.interp(inner, places, coarse, period=self._period)) > JUMP * np.ptp(fine)
        beside = missed.reshape(self.points, self.fine).any(axis=1)
        places_beside = np.flatnonzero(beside)[:, None] + np.arange(-1, AFTER_JUMP + 1)
        shown = np.ones(self.points, dtype=bool)
        shown[places_beside % self.points if self._period else np.clip(places_beside, 0, self.points - 1)] = False
        return shown if np.count_nonzero(shown) > self.points // 2 else np.ones(self.points, dtype=bool)

    @property
    def _period(self) -> float | None:
        return 1.0 if self.stretch.kind == "repeating" else None

    def left_out(self, places: FloatArray, values: FloatArray) -> FloatArray:
        """(columns,): the root mean square of what the averages leave out of the rows, noise and all."""
        count = float(self.counts.sum())
        mean = self.sums.sum(axis=0)
        filled = self.counts.sum(axis=0)
        curve = values.mean(axis=0)
        inner = (np.arange(self.bins) + 0.5) / self.bins
        shown = np.array([np.interp(inner, places, row, period=self._period) for row in curve])
        square = self.squares - 2 * np.sum(shown * mean, axis=1) + np.sum(shown**2 * filled, axis=1)
        return np.asarray(np.sqrt(np.maximum(square, 0.0) / max(count, 1.0)))
