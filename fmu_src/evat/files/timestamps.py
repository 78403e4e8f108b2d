"""How many seconds has a recording run, where its clock is written as dates and times of day?

Only differences count, so a date is not read: whatever order its parts have, it must change where the time of day runs over midnight, and
nowhere else.
"""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.compute

from evat.files.cells import TIME_OF_DAY
from evat.files.text import RecordError
from evat.model import FloatArray

_DAY = 86_400.0


class Timestamps:
    """Turns the texts of a column, batch by batch, into seconds since its first row."""

    def __init__(self, file: str, header: str) -> None:
        self._where, self._rows = f"{file}, column {header!r}", 0
        self._first, self._last, self._date, self._days = np.nan, np.nan, "", 0.0

    def __call__(self, texts: pa.Array) -> FloatArray:
        """Seconds, of shape (rows,); RecordError where a text is no time of day, or a date jumps."""
        parts = pa.compute.extract_regex(texts, TIME_OF_DAY)
        if parts.null_count:
            row = int(np.argmax(parts.is_null().to_numpy(zero_copy_only=False)))
            raise RecordError(
                f"{self._where}, data row {self._rows + row + 1}: {str(texts[row].as_py() or '')[:40]!r} is no time of day; write it like "
                "10:15:00.250, with a date in front or without."
            )
        hour, minute = (self._numbers(parts, name) for name in ("hour", "minute"))
        half = np.array([text[:1].lower() for text in parts.field("half").to_pylist()])
        hour = np.where(half == "", hour, hour % 12 + 12 * (half == "p"))
        day = 3600 * hour + 60 * minute + self._numbers(parts, "second")
        dates = parts.field("date").to_numpy(zero_copy_only=False)
        if not self._rows:
            self._first, self._last, self._date = float(day[0]), float(day[0]), dates[0]
        over = np.diff(day, prepend=self._last) < -_DAY / 2
        changed = dates != np.concatenate([[self._date], dates[:-1]])
        if bool(np.any(dates != "")) and np.any(changed != over):
            row = int(np.argmax(changed != over))
            raise RecordError(
                f"{self._where}, data row {self._rows + row + 1}: {texts[row].as_py()[:40]!r}; the date changes where the time of day runs "
                "over midnight, and nowhere else. Cut the recording in two there."
            )
        days = self._days + np.cumsum(over)
        self._last, self._date, self._days = float(day[-1]), dates[-1], float(days[-1])
        self._rows += len(texts)
        return np.asarray(day - self._first + _DAY * days, dtype=np.float64)

    @staticmethod
    def _numbers(parts: pa.StructArray, name: str) -> FloatArray:
        texts = pa.compute.replace_substring(parts.field(name), ",", ".")
        return np.asarray(texts.cast(pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)
