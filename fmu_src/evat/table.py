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

HEADER = re.compile(r"\s*(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*")


class RecordError(EvatError):
    """A data file that does not hold what is needed; names file, column and row."""


@dataclass(frozen=True, slots=True)
class Table:
    """The columns of a file as they stand in it: `columns[header]` and the unit that a header such as "v [mm/s]" states."""

    path: Path
    columns: Mapping[str, FloatArray]

    def column(self, header: str, unit: str) -> FloatArray:
        """The column in `unit`; its header's unit is converted, a header without one is taken to be in `unit`.

        Raises
        ------
        RecordError, where there is no such column, its unit does not fit, or a value is missing or not finite.
        """
        if header not in self.columns:
            raise RecordError(f"{self.path.name}: there is no column {header!r}; it has {', '.join(map(repr, self.columns))}.")
        values = self.columns[header]
        if not np.all(np.isfinite(values)):
            row = int(np.argmin(np.isfinite(values)))
            raise RecordError(
                f"{self.path.name}, column {header!r}, data row {row + 1}: no finite number. Nothing is filled in; mend or cut it."
            )
        match = HEADER.fullmatch(header)
        if match is None:
            return values
        try:
            factor, offset = affine(match["unit"], unit)
        except EvatError as error:
            raise RecordError(f"{self.path.name}, column {header!r}: {error}") from error
        return values * factor + offset

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
    columns = {}
    for name in table.column_names:
        kind = table.schema.field(name).type
        if pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind):
            columns[name] = table[name].to_numpy().astype(np.float64)
    if not columns:
        raise RecordError(f"{path.name}: no column of numbers was found; the first line is taken as the header.")
    return Table(path, columns)


def write_trace(trace: Trace, path: Path) -> Path:
    """Write a trace as Parquet or, by any other suffix, CSV; headers carry the units, Parquet also how it was made. Atomic."""
    names = {"time [s]": trace.times} | {f"{name} [{trace.units[name]}]": column for name, column in trace.columns.items()}
    made_by = json.dumps(trace.made_by, sort_keys=True, default=str)
    table = pa.table(names).replace_schema_metadata({"made_by": made_by})
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, scratch = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    os.close(descriptor)
    try:
        if path.suffix.lower() in (".parquet", ".pq"):
            pa.parquet.write_table(table, scratch)
        else:
            pa.csv.write_csv(table, scratch)
        os.replace(scratch, path)
    finally:
        Path(scratch).unlink(missing_ok=True)
    return path
