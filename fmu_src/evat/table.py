"""How do columns with units get from a file to SI numbers and back? CSV and Parquet, through pyarrow."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from evat.model import EvatError, FloatArray, Trace
from evat.units import affine

# A name, and its unit in brackets at the end: "F [N]", "F (N)", "c [N/(m/min)]".
HEADER = re.compile(r".*?(?:\[(?P<square>[^][]*)\]|\((?P<round>(?:[^()]|\([^()]*\))*)\))\s*", re.DOTALL)


class RecordError(EvatError):
    """A data file that does not hold what is needed; names file, column and row."""


@dataclass(frozen=True, slots=True)
class Table:
    """The columns of a file as they stand in it: `columns[header]` and the unit that a header such as "v [mm/s]" states."""

    path: Path
    columns: Mapping[str, FloatArray]
    without_numbers: tuple[str, ...] = ()  # headers of columns that hold something else

    def column(self, header: str, unit: str) -> FloatArray:
        """The column in `unit`; its header's unit is converted, a header without one is taken to be in `unit`.

        Raises
        ------
        RecordError, where there is no such column, its unit does not fit, or a value is missing or not finite.
        """
        if header in self.without_numbers:
            raise RecordError(
                f"{self.path.name}, column {header!r}: not all of it is numbers. Numbers have a decimal point; missing ones are left empty."
            )
        if header not in self.columns:
            raise RecordError(f"{self.path.name}: there is no column {header!r}; it has {', '.join(map(repr, self.columns))}.")
        values = self.columns[header]
        if not np.all(np.isfinite(values)):
            row = int(np.argmin(np.isfinite(values)))
            raise RecordError(
                f"{self.path.name}, column {header!r}, data row {row + 1}: no finite number. Nothing is filled in; mend or cut it."
            )
        match = HEADER.fullmatch(header)
        if match is None and header.rstrip().endswith(("]", ")")):
            raise RecordError(f"{self.path.name}, column {header!r}: the brackets at its end hold no unit; write it like 'v [mm/s]'.")
        if match is None:
            return values
        try:
            factor, offset = affine((match["round"] if match["square"] is None else match["square"]).strip(), unit)
        except EvatError as error:
            raise RecordError(f"{self.path.name}, column {header!r}: {error}") from error
        return values if (factor, offset) == (1, 0) else values * factor + offset  # adding 0 would lose the sign of -0

    def clock(self, header: str) -> FloatArray:
        """The column as an increasing clock in s; RecordError where it stands still or runs backwards."""
        times = self.column(header, "s")
        steps = np.diff(times)
        if times.size < 2 or not np.all(steps > 0):
            row = int(np.argmax(steps <= 0)) + 1 if times.size > 1 else 0
            raise RecordError(f"{self.path.name}, column {header!r}, data row {row + 1}: the clock must increase from row to row.")
        return times


def read_table(path: Path) -> Table:
    """All numeric columns of a CSV (comma, semicolon or tab) or Parquet file; RecordError where it cannot be read."""
    try:
        if path.suffix.lower() in (".parquet", ".pq"):
            table = pa.parquet.read_table(path)
        else:
            with path.open(encoding="utf-8", errors="replace") as file:
                first = file.readline()
            delimiter = max("\t;,", key=first.count)
            table = pa.csv.read_csv(path, parse_options=pa.csv.ParseOptions(delimiter=delimiter))
    except OSError as error:
        raise RecordError(f"{path}: {error.strerror or error}.") from error
    except pa.ArrowException as error:
        raise RecordError(f"{path.name}: this is no table of numbers ({error}).") from error
    try:
        names = table.column_names
    except UnicodeDecodeError as error:
        raise RecordError(f"{path.name}: the headers are not written in UTF-8; save the file anew in that encoding.") from error
    columns = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        if field.name in columns:
            raise RecordError(f"{path.name}: two columns have the header {field.name!r}; give each its own.")
        if pa.types.is_floating(field.type) or pa.types.is_integer(field.type) or pa.types.is_null(field.type):
            columns[field.name] = column.to_numpy().astype(np.float64)
    if not columns:
        raise RecordError(f"{path.name}: no column of numbers was found; the first line is taken as the header.")
    return Table(path, columns, tuple(name for name in names if name not in columns))


def write_trace(trace: Trace, path: Path) -> Path:
    """Write a trace as Parquet or, by any other suffix, CSV; headers carry the units, Parquet also how it was made.

    The file appears whole or not at all; RecordError where it cannot be written.
    """
    names = {"time [s]": trace.times} | {f"{name} [{trace.units[name]}]": column for name, column in trace.columns.items()}
    made_by = json.dumps(trace.made_by, sort_keys=True, default=str)
    table = pa.table(names).replace_schema_metadata({"made_by": made_by})
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".evat-") as folder:
            scratch = Path(folder) / "table"
            if path.suffix.lower() in (".parquet", ".pq"):
                pa.parquet.write_table(table, scratch)
            else:
                pa.csv.write_csv(table, scratch)
            os.replace(scratch, path)
    except OSError as error:
        raise RecordError(f"{path}: it cannot be written: {error.strerror or error}. Name another file.") from error
    return path
