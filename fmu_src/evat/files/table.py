"""How do columns with units get from a file to SI numbers and back? CSV and Parquet, through pyarrow."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from evat.files.regular import check_regular
from evat.files.text import PLAIN, RecordError, TextForm, bad_line, text_options
from evat.files.writing import whole
from evat.model import EvatError, FloatArray, Trace
from evat.units import affine

# A name, and its unit in brackets at the end: "F [N]", "F (N)", "c [N/(m/min)]".
HEADER = re.compile(r".*?(?:\[(?P<square>[^][]*)\]|\((?P<round>(?:[^()]|\([^()]*\))*)\))\s*", re.DOTALL)

PARQUET = (".parquet", ".pq")


def unit_in(header: str) -> str | None:
    """What stands in the brackets at the end of a header, None where there are none."""
    match = HEADER.fullmatch(header)
    return None if match is None else (match["round"] if match["square"] is None else match["square"]).strip()


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
                f"{self.path.name}, column {header!r}, data row {row + 1}: no finite number. Nothing is filled in; correct or cut it."
            )
        stated = unit_in(header)
        if stated is None and header.rstrip().endswith(("]", ")")):
            raise RecordError(f"{self.path.name}, column {header!r}: the brackets at its end hold no unit; write it like 'v [mm/s]'.")
        if stated is None:
            return values
        try:
            factor, offset = affine(stated, unit)
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


def once(headers: Iterable[str], where: str) -> dict[str, str]:
    """Headers by their names, without units; RecordError where two are of one name, of which only one could count."""
    named = dict[str, str]()
    for header in headers:
        name = header.partition("[")[0].strip()
        if name in named:
            raise RecordError(f"{where}: {name} is there twice, as {named[name]!r} and as {header!r}; keep one.")
        named[name] = header
    return named


def is_parquet(path: Path) -> bool:
    """Whether a file is taken as Parquet; any other is taken as CSV."""
    return path.suffix.lower() in PARQUET


def read_table(path: Path, form: TextForm = PLAIN) -> Table:
    """All numeric columns of a CSV (comma, semicolon or tab) or Parquet file; RecordError where it cannot be read."""
    try:
        check_regular(path)
        if is_parquet(path):
            table = pa.parquet.read_table(path)
        else:
            source, options = text_options(path, form)
            table = pa.csv.read_csv(source, convert_options=pa.csv.ConvertOptions(decimal_point=form.decimal), **options)
    except OSError as error:
        raise RecordError(f"{path}: {error.strerror or error}.") from error
    except UnicodeEncodeError as error:
        raise RecordError(f"{path.name}: the file's name is no text (UTF-8); rename it.") from error
    except pa.ArrowException as error:
        where = "" if is_parquet(path) else bad_line(path, form)
        raise RecordError(f"{path.name}: this is no table of numbers ({where or error}).") from error
    try:
        names = table.column_names
    except UnicodeDecodeError as error:
        raise RecordError(
            f"{path.name}: the headers are not written in UTF-8; name their encoding as reader.encoding, or save the file as UTF-8."
        ) from error
    columns = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        if field.name in columns:
            raise RecordError(f"{path.name}: two columns have the header {field.name!r}; give each its own.")
        if pa.types.is_floating(field.type) or pa.types.is_integer(field.type) or pa.types.is_null(field.type):
            columns[field.name] = column.to_numpy().astype(np.float64)
    if not columns:
        raise RecordError(f"{path.name}: no column of numbers was found; the first line is taken as the header.")
    return Table(path, columns, tuple(name for name in names if name not in columns))


def read_texts(path: Path, header: str, form: TextForm = PLAIN) -> tuple[str, ...]:
    """One column as the texts that stand in it, such as names; RecordError where a row has none."""
    try:
        check_regular(path)
        if is_parquet(path):
            column = pa.parquet.read_table(path, columns=[header])[header].cast(pa.string())
        else:
            convert = pa.csv.ConvertOptions(
                include_columns=[header], column_types={header: pa.string()}, strings_can_be_null=True, null_values=[""]
            )  # "NA" is a name
            source, options = text_options(path, form)
            column = pa.csv.read_csv(source, convert_options=convert, **options)[header]
    except (OSError, pa.ArrowException) as error:
        raise RecordError(f"{path.name}, column {header!r}: it cannot be read as text ({error}).") from error
    texts = column.to_pylist()
    if None in texts:
        raise RecordError(
            f"{path.name}, column {header!r}, data row {texts.index(None) + 1}: it is empty. Nothing is filled in; complete it."
        )
    return tuple(texts)


def write_columns(columns: Mapping[str, FloatArray | Sequence[str]], path: Path, about: Mapping[str, str] | None = None) -> Path:
    """Write columns by their headers as Parquet or, by any other suffix, CSV; `about` is kept in Parquet.

    The file appears whole or not at all; OutputError where it cannot be written.
    """
    table = pa.table({name: _array(column) for name, column in columns.items()}).replace_schema_metadata(dict(about or {}))
    with whole(path) as made:
        if is_parquet(path):
            pa.parquet.write_table(table, made)
        else:
            pa.csv.write_csv(table, made)
    return path


def _array(column: FloatArray | Sequence[str]) -> pa.Array:
    """By its buffer, where it is one of floats: pa.array would load pandas for it, which takes as long as all the rest of Ctrl-C."""
    if isinstance(column, np.ndarray) and column.dtype == np.float64 and column.ndim == 1:
        return pa.Array.from_buffers(pa.float64(), column.size, [None, pa.py_buffer(np.ascontiguousarray(column))])
    return pa.array(column)


def write_trace(trace: Trace, path: Path) -> Path:
    """Write a trace, its headers with units; Parquet also keeps how it was made. See `write_columns`."""
    columns = {"time [s]": trace.times} | {f"{name} [{trace.units[name]}]": column for name, column in trace.columns.items()}
    return write_columns(columns, path, {"made_by": json.dumps(trace.made_by, sort_keys=True, default=str)})
