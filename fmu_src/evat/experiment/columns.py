"""Is every row of a recording fit to be used? Its columns in SI, batch by batch, along a clock that runs on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from evat.experiment import FEWEST_ROWS, ExperimentError, Remark, SetupSd, Signal
from evat.experiment.column import Column
from evat.experiment.document import BESIDE, CLOCK, Document, TrialEntry
from evat.experiment.remarks import Remarks
from evat.files.sniff import units_below
from evat.files.spelling import unit_meant
from evat.files.stream import Bytes, headers, open_batches
from evat.files.table import unit_in
from evat.files.text import RecordError, TextForm
from evat.model import FloatArray, IntArray, Model, ParameterError
from evat.units import affine, base_unit


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
    columns, below = [], units_below(entry.path, document.form, header)
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
        check_line_of_units(signal, entry.source, below.get(signal.column, ""))
        column = Column.of_signal(signal, None if signal.name in BESIDE else by_name[signal.name])
        columns.append(replace(column, zero_sd=document.setup_sd.get(signal.name, SetupSd()).zero))
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


def check_line_of_units(signal: Signal, file: str, stated: str) -> None:
    """ExperimentError where a line of units below the headers states another one than the document; text that is none says nothing."""
    meant = unit_meant(stated) or stated
    try:
        if meant in ("", "1", signal.unit) or not base_unit(meant):
            return
    except ParameterError:
        return
    try:
        fits = affine(meant, signal.unit) == (1, 0)
    except ParameterError:
        fits = False
    if not fits:
        raise ExperimentError(
            f"{file}, column {signal.column!r}: the line of units below its header states {stated}, the document says {signal.unit} "
            f"(signals.{signal.name}.unit); correct the one that is wrong."
        )


def trial_batches(
    entry: TrialEntry,
    columns: list[Column],
    done: Bytes,
    rows: Callable[[int], None],
    form: TextForm,
    remarks: list[Remark] | None = None,
) -> Iterator[list[FloatArray]]:
    """A trial's file in batches, in SI and checked. `rows` is told how many there will be where the file says so, `remarks` at the end what
    should be known of it."""
    at, count, last, seen = 0, 0, -np.inf, Remarks(entry.source, columns)
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
                yield seen.seen(numbers, batch)
    except RecordError as error:
        raise ExperimentError(unreadable(entry.source, error)) from error
    if count < 2:  # of more its clock is looked at, and whether these are enough
        where = f" with {', '.join(f'{header} = {value:g}' for header, value in entry.rows.items())}" if entry.rows else " of data"
        raise ExperimentError(f"{entry.source}: it has {count} row{'s' * (count != 1)}{where}; a recording has at least {FEWEST_ROWS}.")
    told = seen.told()
    if remarks is not None:
        remarks += told


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
        f"{before[place]:.9g} to {times[place]:.9g} s. Correct it, or cut the recording there; "
        "where a column counts the recordings of a file, give each trial its `rows`."
    )
