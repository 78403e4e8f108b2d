"""What should be known of a recording beside its numbers? Where a sensor was at the end of its range, an angle began a new turn, or a load
read less than nothing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import ExperimentError, Remark, SetupSd
from evat.experiment.column import Column
from evat.experiment.smoothing import noise_sd, quantum
from evat.model import FloatArray, IntArray

SEVERAL = 3  # samples at the end of a range, from which it is no peak that just fits in
WIDE = 1.001  # turns: an angle that goes beyond was not begun anew at each
ZERO_SDS, NOISE_SDS = 3.0, 4.0  # how far below 0 a zero, or noise, is likely to take what is never negative
MOST_BELOW = 0.05  # of the largest magnitude: what reads further below 0 is not near it


class Remarks:
    """What a recording of these columns asks for, seen batch by batch."""

    def __init__(self, file: str, columns: Sequence[Column]) -> None:
        self.file, self.columns = file, columns
        count = len(columns)
        self._at_end, self._jumps, self._below = ([0] * count for _ in range(3))
        self._least, self._most, self._squares = [math.inf] * count, [-math.inf] * count, [0.0] * count
        self._last: list[float] = [math.nan] * count
        self._lowest, self._row, self._noise = [0.0] * count, [0] * count, [0.0] * count
        self._rows = 0

    def seen(self, rows: IntArray, batch: list[FloatArray]) -> list[FloatArray]:
        """The same columns, SI, those that are never negative without what is below 0; rows : of the file, from 1."""
        self._rows += rows.size
        return [self._column(place, rows, values) for place, values in enumerate(batch)]

    def _column(self, place: int, rows: IntArray, values: FloatArray) -> FloatArray:
        column = self.columns[place]
        if column.full_scale is not None:
            end = column.full_scale - max(quantum(values), (1 - CONSTANTS.saturation_level) * column.full_scale)
            self._at_end[place] += int(np.count_nonzero(np.abs(values - column.offset) >= end))
        if column.turn is not None:
            self._jumps[place] += int(np.count_nonzero(np.abs(np.diff(values, prepend=self._last[place])) > column.turn / 2))
            self._last[place] = float(values[-1])
        self._least[place], self._most[place] = min(self._least[place], float(values.min())), max(self._most[place], float(values.max()))
        if not column.never_negative:
            return values
        self._squares[place] += float(values @ values)
        below = values < -column.slack
        if not below.any():
            return values
        self._below[place] += int(np.count_nonzero(below))
        if float(values.min()) < self._lowest[place]:
            at = int(np.argmin(values))
            self._lowest[place], self._row[place], self._noise[place] = float(values[at]), int(rows[at]), noise_sd(values)
        return np.where(below, 0.0, values)

    def told(self) -> tuple[Remark, ...]:
        """After the last batch; ExperimentError where what is never negative is clearly below 0."""
        remarks = list[Remark]()
        for place, column in enumerate(self.columns):
            if self._below[place]:
                self._check_below(place)
                share = -self._lowest[place] / max(abs(self._most[place]), 1e-300)
                remarks.append(
                    Remark(
                        f"{self.file}, column {column.header!r}: {column.name} reads below 0 in {self._below[place]} of {self._rows} "
                        f"samples, by {100 * share:.2g} % of its largest value at most; that is within its noise or its zero, and "
                        "taken as 0."
                    )
                )
            if self._jumps[place] and column.turn is not None and self._most[place] - self._least[place] <= WIDE * column.turn:
                remarks.append(
                    Remark(
                        f"{self.file}, column {column.header!r}: the angle begins a new turn at {self._jumps[place]} "
                        f"sample{'s' * (self._jumps[place] != 1)}; it is taken as one that goes on."
                    )
                )
            if self._at_end[place] >= SEVERAL:
                remarks.append(
                    Remark(
                        f"{self.file}, column {column.header!r}: {column.name} is at the end of the sensor's range (full_scale) in "
                        f"{self._at_end[place]} of {self._rows} samples; what lies beyond is cut off, and no value is to be believed that "
                        "rests on it. Leave those rows out, or measure with a wider range.",
                        doubt=True,
                    )
                )
        return tuple(remarks)

    def _check_below(self, place: int) -> None:
        column, largest = self.columns[place], max(abs(self._least[place]), abs(self._most[place]))
        rms = math.sqrt(self._squares[place] / self._rows)
        zero = SetupSd.ZERO_OF_RMS * rms if column.zero_sd is None else column.zero_sd
        allowed = min(max(ZERO_SDS * zero, NOISE_SDS * self._noise[place]), MOST_BELOW * largest)
        if -self._lowest[place] > allowed + column.slack:
            raise ExperimentError(
                f"{self.file}, column {column.header!r}, data row {self._row[place]}: {column.name} = {self._lowest[place]:g} {column.si}; "
                f"allowed is {column.low:g} to {column.high:g} {column.si}, and {-allowed:.3g} {column.si} for its noise and its zero. "
                f"Its unit is given as {column.unit}: is that right? Does the sensor count the other way (sign = -1), is its zero off, or "
                "did it change places with another column?"
            )


def unwrapped(column: FloatArray, turn: float | None) -> FloatArray:
    """An angle (n,) that is counted anew at each `turn` as one that goes on; as it is where it goes beyond one turn by itself."""
    if turn is None or np.ptp(column) > WIDE * turn or not np.any(np.abs(np.diff(column)) > turn / 2):
        return column
    return np.unwrap(column, period=turn)
