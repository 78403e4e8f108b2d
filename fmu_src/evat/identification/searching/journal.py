"""What has a search evaluated so far? A file with a line per generation, from which a search that was cut off goes on to the same end.

The search is run again from its seed; costs of generations that are in the journal are read instead of calculated. So every search can
be resumed, to the last bit, whatever its own state is. A line is flushed to the disk before the next generation begins; a torn last line
(kill -9 while writing) is dropped, which costs that generation.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from evat.files.writing import as_output_error, put
from evat.model import EvatError, FloatArray


class JournalError(EvatError):
    """A journal that cannot be read, or belongs to another search."""


class Journal:
    """Generations of one search, in the order in which they were evaluated."""

    def __init__(self, path: Path, facts: Mapping[str, Any], resume: bool) -> None:
        """facts : all that decides the course of the search (data, bounds, seed, ...); resume : go on where there is a journal."""
        self.path, self._lines, self._next = path, list[dict[str, Any]](), 0
        head = json.dumps({"journal": 1, **facts}, sort_keys=True)
        if resume and path.is_file():
            self._read(head)
        else:
            self._begin(head)

    @property
    def held(self) -> int:
        """Generations that need not be calculated."""
        return len(self._lines)

    def recall(self, points: FloatArray) -> FloatArray | None:
        """Costs of the next generation, None where it has not been evaluated yet."""
        if self._next >= len(self._lines):
            return None
        line = self._lines[self._next]
        self._next += 1
        if line["points"] != _digest(points):
            raise JournalError(
                f"{self.path}: generation {self._next} of this journal has other members than this search; the libraries or the "
                "machine have changed. Start without resuming."
            )
        return np.array(line["costs"], dtype=np.float64)

    def keep(self, points: FloatArray, costs: FloatArray) -> None:
        """Append a generation; on the disk when this returns."""
        line = {"points": _digest(points), "costs": costs.tolist()}
        with as_output_error(self.path, "the journal"), self.path.open("ab") as file:
            file.write(_with_sum(json.dumps(line)))
            file.flush()
            os.fsync(file.fileno())
        self._lines.append(line)
        self._next = len(self._lines)

    def _begin(self, head: str) -> None:
        put(self.path, _with_sum(head), "the journal")

    def _read(self, head: str) -> None:
        try:
            data = self.path.read_bytes()
        except OSError as error:
            raise JournalError(f"{self.path}: the journal cannot be read: {error.strerror}.") from error
        whole, texts = 0, list[str]()
        for line in data.splitlines(keepends=True):
            text = _checked(line)
            if text is None:
                break
            texts.append(text)
            whole += len(line)
        if not texts:
            raise JournalError(
                f"{self.path}: the first line of this journal is damaged, or this is no journal; which search it belongs to cannot be "
                "told. Start without resuming, which replaces it."
            )
        if texts[0] != head:
            written = json.loads(texts[0])
            asked = json.loads(head)
            other = sorted(key for key in {*written, *asked} if written.get(key) != asked.get(key))
            raise JournalError(
                f"{self.path}: this journal is of another search, which differs in {', '.join(other)}. Ask for the same search, or start "
                "without resuming."
            )
        self._lines = [json.loads(text) for text in texts[1:]]
        if whole < len(data):
            with as_output_error(self.path, "the journal"):
                os.truncate(self.path, whole)


def _digest(points: FloatArray) -> str:
    return hashlib.sha256(np.ascontiguousarray(points, dtype=np.float64).tobytes()).hexdigest()[:16]


def _with_sum(text: str) -> bytes:
    return f"{hashlib.sha256(text.encode()).hexdigest()[:8]} {text}\n".encode()


def _checked(line: bytes) -> str | None:
    """The text of a whole line, None of a torn one."""
    check, _, text = line.decode("utf-8", errors="replace").partition(" ")
    if not text.endswith("\n"):
        return None
    text = text.removesuffix("\n")
    return text if hashlib.sha256(text.encode()).hexdigest()[:8] == check else None
