"""What does a long recording do, coarsely? Means over short blocks of rows, from one pass, whatever its length."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from evat.model import FloatArray

MOST = 1 << 21  # blocks; once there are more, neighbours are joined


class Overview:
    """Blocks of `block` rows each: `means` (blocks, columns), and `way` (blocks + 1,), the integral [m] of the magnitude of one column over
    time to where each block begins, 0 where there is none. Rows that do not fill the last block are in `rows` alone."""

    def __init__(self, batches: Iterable[Sequence[FloatArray]], columns: int, motion: int | None) -> None:
        """batches : columns of equal length, the clock first; motion : the place of the column that is integrated."""
        self.block, self.rows, self._count = 1, 0, 0
        self._means, self._ways = np.empty((MOST, columns)), np.zeros(MOST)
        left = np.empty((0, columns))
        last = np.nan
        for batch in batches:
            table = np.column_stack(batch)
            self.rows += len(table)
            ways = np.zeros(len(table))
            if motion is not None:
                steps = np.diff(table[:, 0], prepend=table[0, 0] if np.isnan(last) else last)
                ways, last = np.abs(table[:, motion]) * steps, float(table[-1, 0])
            left = np.vstack([left, np.column_stack([table, ways])]) if left.size else np.column_stack([table, ways])
            left = self._taken(left)
        self.means: FloatArray = self._means[: self._count].copy()
        self.way: FloatArray = np.concatenate([[0.0], np.cumsum(self._ways[: self._count])])
        del self._means, self._ways

    def _taken(self, table: FloatArray) -> FloatArray:
        """Rows (n, columns + 1) as blocks; what is left over."""
        while True:
            count = min(len(table) // self.block, MOST - self._count)
            whole = table[: count * self.block].reshape(count, self.block, table.shape[1])
            self._means[self._count : self._count + count] = whole[:, :, :-1].mean(axis=1)
            self._ways[self._count : self._count + count] = whole[:, :, -1].sum(axis=1)
            self._count += count
            table = table[count * self.block :]
            if self._count < MOST:
                return table
            half = MOST // 2
            self._means[:half] = (self._means[0::2] + self._means[1::2]) / 2
            self._ways[:half] = self._ways[0::2] + self._ways[1::2]
            self._count, self.block = half, 2 * self.block

    def places(self, rows: FloatArray) -> FloatArray:
        """Where rows lie among the centres of the blocks."""
        places: FloatArray = (np.asarray(rows) - (self.block - 1) / 2) / self.block
        return places

    def times(self, rows: FloatArray) -> FloatArray:
        """The clock [s] at rows, whole or not; beyond the ends at the usual step."""
        at, clock = self.places(rows), self.means[:, 0]
        inner = np.interp(at, np.arange(len(clock)), clock)
        step = (clock[-1] - clock[0]) / max(len(clock) - 1, 1)
        times: FloatArray = inner + step * (np.minimum(at, 0.0) + np.maximum(at - (len(clock) - 1), 0.0))
        return times

    def ways(self, rows: FloatArray) -> FloatArray:
        """The integral [m] up to rows."""
        ways: FloatArray = np.interp(np.asarray(rows) / self.block, np.arange(len(self.way)), self.way)
        return ways
