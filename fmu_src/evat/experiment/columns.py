"""Is every number of a recording fit to be used? Its columns in SI, batch by batch, within bounds, along a clock that runs on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evat.experiment import ExperimentError, Signal
from evat.experiment.document import BESIDE, CLOCK, Document, TrialEntry, to_variable
from evat.files.spelling import unit_meant
from evat.files.stream import Bytes, headers, open_batches
from evat.files.table import unit_in
from evat.files.text import RecordError, TextForm
from evat.model import FloatArray, IntArray, Model, ParameterError, Variable
from evat.units import affine, base_unit


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a file: the variable `name` in `si` = factor * value in the file + offset, between `low` and `high`; where it
    is derived from the column, it lies between `variable_low` and `variable_high` itself."""

    header: str
    name: str
    unit: str
    factor: float
    offset: float
    si: str
    low: float
    high: float
    variable_low: float = -np.inf
    variable_high: float = np.inf
    slack: float = 0.0  # how far outside the bounds a value may lie: see Variable

    @classmethod
    def of_signal(cls, signal: Signal, known: Variable | None) -> Column:
        """The column of a signal; a position has no bounds."""
        plain = "s" if signal.name == CLOCK else signal.unit
        si, low, high = (known.unit, known.min, known.max) if known else (plain, -np.inf, np.inf)
        own = (low, high)
        if signal.of:
            low, high = -np.inf, np.inf
        slack = known.slack if known else 0.0
        return cls(signal.column, signal.name, signal.unit, *to_variable(signal, si), si, low, high, *own, slack)

    @classmethod
    def of(cls, header: str, name: str, unit: str, known: Variable | None) -> Column:
        """The column of a variable, or of the clock where there is none; ParameterError where the unit does not fit."""
        si, low, high = (known.unit, known.min, known.max) if known else ("s", -np.inf, np.inf)
        return cls(header, name, unit, *affine(unit, si), si, low, high, slack=known.slack if known else 0.0)

    def checked(self, file: str, rows: IntArray, raw: FloatArray) -> FloatArray:
        """The column in SI; an error names the row (of `rows`, from 1) of what is no number or lies outside the variable's bounds."""
        column = raw if (self.factor, self.offset) == (1, 0) else raw * self.factor + self.offset
        low, high = float(column.min()), float(column.max())
        if not (np.isfinite(low) and np.isfinite(high)):
            row = rows[int(np.argmin(np.isfinite(column)))]
            raise ExperimentError(
                f"{file}, column {self.header!r}, data row {row}: no finite number. Nothing is filled in; mend or cut it."
            )
        least, most = self.low - self.slack, self.high + self.slack
        if low < least or high > most:
            place = int(np.argmax((column < least) | (column > most)))
            raise ExperimentError(
                f"{file}, column {self.header!r}, data row {rows[place]}: {self.name} = {column[place]:g} {self.si}; allowed is "
                f"{self.low:g} to {self.high:g} {self.si}. Its unit is given as {self.unit}: is that right?"
            )
        return column


def unreadable(file: str, error: RecordError) -> str:
    """What a file's reader says of it, who knows its bare name, with the name that it has in the experiment."""
    said, bare = str(error), Path(file).name
    return file + (said[len(bare) :] if said.startswith(bare) else f": {said}")


def trial_columns(document: Document, entry: TrialEntry, model: Model) -> list[Column]:
    """The columns that a trial's file must have, the clock first."""
    by_name = {variable.name: variable for variable in model.variables}
    try:
        header = headers(entry.path, document.form)
    except RecordError as error:
        raise ExperimentError(unreadable(entry.source, error)) from error
    columns = []
    if missing := [name for name in entry.rows if name not in header]:
        raise ExperimentError(
            f"{entry.source}: there is no column {missing[0]!r} to tell rows by; it has {', '.join(map(repr, header[:40]))}. "
            "Name the right one in `rows` of the trial."
        )
    for signal in sorted(document.recorded, key=lambda signal: signal.name != CLOCK):
        if signal.column not in header:
            raise ExperimentError(
                f"{entry.source}: there is no column {signal.column!r} for {signal.name}; it has {', '.join(map(repr, header[:40]))}. "
                f"Name the right one as signals.{signal.name}.column."
            )
        if signal.name in entry.values:
            raise ExperimentError(f"{entry.source}: {signal.name} is a signal and among the trial's values too; keep one.")
        check_header(signal, entry.source)
        columns.append(Column.of_signal(signal, None if signal.name in BESIDE else by_name[signal.name]))
    return columns


def check_header(signal: Signal, file: str) -> None:
    """ExperimentError where the brackets at the end of a header state another unit than the document.

    They may hold text that is no unit; round ones may also hold a unit of another kind, which is then text too: "T (C)" is no charge.
    A unit may be spelt as people do: [1/min] of a spindle, [Nm] of a torque.
    """
    stated = unit_in(signal.column)
    if stated is not None and unit_meant(stated) == signal.unit:
        return
    try:
        base_unit(stated or "")
    except ParameterError:
        return
    try:
        fits = affine(stated or "", signal.unit) == (1, 0)
    except ParameterError:
        fits = signal.column.rstrip().endswith(")")
    if not fits:
        raise ExperimentError(
            f"{file}, column {signal.column!r}: its header states {stated}, the document says {signal.unit} (signals.{signal.name}.unit); "
            "correct the one that is wrong."
        )


def trial_batches(
    entry: TrialEntry, columns: list[Column], done: Bytes, rows: Callable[[int], None], form: TextForm
) -> Iterator[list[FloatArray]]:
    """A trial's file in batches, in SI and checked. `rows` is told how many there will be where the file says so."""
    at, count, last = 0, 0, -np.inf
    headings = list(dict.fromkeys([*(column.header for column in columns), *entry.rows]))
    try:
        with open_batches(entry.path, headings, done, form) as batches:
            if batches.rows is not None:
                rows(batches.rows)
            for read in batches.each:
                by_header = dict(zip(headings, read, strict=True))
                own = _own_rows(entry, by_header)
                numbers, at = at + 1 + own, at + read[0].size
                if not own.size:
                    continue
                raw = [by_header[column.header][own] if entry.rows else by_header[column.header] for column in columns]
                batch = [column.checked(entry.source, numbers, values) for column, values in zip(columns, raw, strict=True)]
                _check_clock(entry.source, columns[0].header, numbers, last, batch[0])
                count, last = count + own.size, float(batch[0][-1])
                yield batch
    except RecordError as error:
        raise ExperimentError(unreadable(entry.source, error)) from error
    if count < 2:
        where = f" with {', '.join(f'{header} = {value:g}' for header, value in entry.rows.items())}" if entry.rows else " of data"
        raise ExperimentError(f"{entry.source}: it has {count} row{'s' * (count != 1)}{where}; a recording has at least 2.")


def _own_rows(entry: TrialEntry, columns: Mapping[str, FloatArray]) -> IntArray:
    """Places of the rows that are of this recording."""
    size = next(iter(columns.values())).size
    own = np.ones(size, dtype=bool)
    for header, value in entry.rows.items():
        own &= columns[header] == value
    return np.flatnonzero(own)


def _check_clock(file: str, header: str, rows: IntArray, last: float, times: FloatArray) -> None:
    if times[0] > last and np.all(times[1:] > times[:-1]):
        return
    before = np.concatenate(([last], times[:-1]))
    place = int(np.argmax(times <= before))
    raise ExperimentError(
        f"{file}, column {header!r}, data row {rows[place]}: the clock must increase from row to row; it goes from "
        f"{before[place]:.9g} to {times[place]:.9g} s. Mend it, or cut the recording there; "
        "where a column counts the recordings of a file, give each trial its `rows`."
    )
