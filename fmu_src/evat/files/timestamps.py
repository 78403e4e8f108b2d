"""How many seconds has a recording run, where its clock is written as dates and times of day?

Only differences count, so a date is not read: whatever order its parts have, it must change where the time of day runs over midnight, and
nowhere else.
"""

from __future__ import annotations

import re

import numpy as np
import pyarrow as pa
import pyarrow.compute

from evat.files.text import RecordError
from evat.model import FloatArray

_PATTERN = (
    r"^\s*(?P<date>(?:.*[^0-9:])?)(?P<hour>\d{1,2}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d(?:[.,]\d+)?)"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?:Z|[+-]\d{2}:?\d{2})?\s*$"
)
_DAY = 86_400.0


def is_timestamp(text: str) -> bool:
    """Whether a cell holds a time of day, with a date in front or without: 2024-05-03T10:15:00.250, 03.05.2024 10:15:00,25, 10:15:00 PM."""
    return re.match(_PATTERN, text) is not None


class Timestamps:
    """Turns the texts of a column, batch by batch, into seconds since its first row."""

    def __init__(self, file: str, header: str) -> None:
        self._where, self._rows = f"{file}, column {header!r}", 0
        self._first, self._last, self._date, self._days = np.nan, np.nan, "", 0.0

    def __call__(self, texts: pa.Array) -> FloatArray:
        """Seconds, of shape (rows,); RecordError where a text is no time of day, or a date jumps."""
        parts = pa.compute.extract_regex(texts, _PATTERN)
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
