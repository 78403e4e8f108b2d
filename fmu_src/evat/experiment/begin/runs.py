"""Which column counts the recordings that stand in one file below each other? One that changes wherever the clock begins anew, and only
there; two where one counts within the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from evat.experiment import ExperimentError
from evat.experiment.begin.files import Recordings
from evat.experiment.document import part_name
from evat.files.stream import open_batches
from evat.files.text import RecordError
from evat.model import FloatArray, IntArray

MOST_RUNS = 1000  # in a file: more are samples
MOST_COLUMNS = 12  # that are tried


@dataclass(frozen=True, slots=True)
class FilePart:
    """A recording: its name, the file it stands in, and the rows of it: by header, what stands in that column."""

    name: str
    file: str
    rows: Mapping[str, float]


def runs(recorded: Recordings, clock: str, others: Sequence[str]) -> list[FilePart]:
    """Every recording of the files, in their order: a file is one where its clock runs on.

    others : headers of columns that may count, each of which is left out where it holds no numbers.
    """
    every, counters = list[FilePart](), dict[str, tuple[str, ...]]()
    for file in recorded.files:
        times = _column(recorded, file, clock)
        begins = np.concatenate([[0], np.flatnonzero(np.diff(times) <= 0) + 1]) if times is not None else np.zeros(1, dtype=np.intp)
        if times is None or begins.size == 1 or begins.size > MOST_RUNS:
            every.append(FilePart(file, file, {}))
            continue
        held = {header: column for header in others[:MOST_COLUMNS] if (column := _column(recorded, file, header)) is not None}
        chosen = counters.get("", ()) or _counters(held, begins)
        if not chosen:
            every.append(FilePart(file, file, {}))
            continue
        counters[""] = chosen
        for begin in begins:
            rows = {header: float(held[header][begin]) for header in chosen}
            every.append(FilePart(part_name(file, rows), file, rows))
    return every


def rows_of(recorded: Recordings, run: FilePart, wanted: Sequence[str]) -> dict[str, FloatArray]:
    """Columns of one of several recordings in a file."""
    columns = {header: _column(recorded, run.file, header) for header in {*wanted, *run.rows}}
    if missing := [header for header, column in columns.items() if column is None]:
        raise ExperimentError(f"{run.file}, column {missing[0]!r}: it holds something that is no number.")
    held = {header: column for header, column in columns.items() if column is not None}
    own = np.logical_and.reduce([held[header] == value for header, value in run.rows.items()])
    return {header: held[header][own] for header in wanted}


def _column(recorded: Recordings, file: str, header: str) -> FloatArray | None:
    """All of a column; None where it is none of numbers."""
    try:
        with open_batches(recorded.folder / file, [header], lambda count: None, recorded.sniffed.form) as batches:
            return np.concatenate([np.empty(0), *(batch[0] for batch in batches.each)])
    except RecordError:
        return None


def _counters(held: Mapping[str, FloatArray], begins: IntArray) -> tuple[str, ...]:
    """The headers, one or two, whose values are each recording's own."""
    still = {
        header: column[begins]
        for header, column in held.items()
        if np.all(np.isfinite(column)) and np.array_equal(np.flatnonzero(np.diff(column)) + 1, begins[1:][np.diff(column[begins]) != 0])
    }
    for count in (1, 2):
        for headers in combinations(still, count):
            if len(set(zip(*(still[header].tolist() for header in headers), strict=True))) == begins.size:
                slow_first = sorted(headers, key=lambda header: len(set(still[header].tolist())))
                return tuple(slow_first)
    return ()
