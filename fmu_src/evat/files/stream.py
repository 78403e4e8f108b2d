"""How is a data file of any size read? In batches of the columns that are needed: CSV block by block, Parquet page by page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from evat.files.regular import check_regular
from evat.files.table import is_parquet
from evat.files.text import PLAIN, RecordError, TextForm, bad_line, text_options
from evat.files.timestamps import Timestamps
from evat.model import FloatArray

CSV_BLOCK = 1 << 22  # bytes; a row must fit into one
PARQUET_ROWS = 1 << 17
PARQUET_BUFFER = 1 << 20  # bytes of a column that are read at a time; without it, and with reading ahead, whole row groups are

Bytes = Callable[[int], None]  # told how many more bytes of the file are done


@dataclass(frozen=True, slots=True)
class Batches:
    """An open file: `rows` where the file says how many it has, and its columns, batch by batch, in the order asked for; nan for holes."""

    rows: int | None
    each: Iterator[list[FloatArray]]


def headers(path: Path, form: TextForm = PLAIN) -> tuple[str, ...]:
    """The headers of a file, as they stand in it; RecordError where there are none that can be read."""
    with _explained(path, form):
        if is_parquet(path):
            with pa.parquet.ParquetFile(path) as file:
                names = tuple(file.schema_arrow.names)
        else:
            source, options = text_options(path, form, block_size=CSV_BLOCK)
            with pa.csv.open_csv(source, **options) as reader:
                names = tuple(reader.schema.names)
    for name in names:
        if name and names.count(name) > 1:
            raise RecordError(f"{path.name}: two columns have the header {name!r}; give each its own.")
    return names


def rows_about(path: Path, form: TextForm = PLAIN) -> int:
    """How many rows a file has; of text so many as its first lines let one expect."""
    with _explained(path, form):
        if is_parquet(path):
            with pa.parquet.ParquetFile(path) as file:
                return int(file.metadata.num_rows)
        with path.open("rb") as text:
            head = text.read(CSV_BLOCK)
        return max(head.count(b"\n"), 1) * path.stat().st_size // max(len(head), 1)


def open_batches(path: Path, wanted: Sequence[str], done: Bytes, form: TextForm = PLAIN) -> AbstractContextManager[Batches]:
    """Some columns of a file as numbers. RecordError, when it is opened or on the way, where it holds something else."""
    return _parquet(path, wanted, done) if is_parquet(path) else _csv(path, wanted, done, form)


@contextmanager
def _csv(path: Path, wanted: Sequence[str], done: Bytes, form: TextForm) -> Iterator[Batches]:
    types: dict[str, Any] = dict.fromkeys(wanted, pa.float64())  # by the whole column, not by what its first block looks like
    stamps = {place: Timestamps(path.name, name) for place, name in enumerate(wanted) if name == form.timestamp}
    types |= {wanted[place]: pa.string() for place in stamps}
    convert = pa.csv.ConvertOptions(include_columns=list(wanted), column_types=types, decimal_point=form.decimal)
    with ExitStack() as stack:
        stack.enter_context(_explained(path, form, wanted))
        # By its name: a file of Python's may be closed, or the interpreter gone, while Arrow still reads ahead.
        source, options = text_options(path, form, block_size=CSV_BLOCK)
        reader = stack.enter_context(pa.csv.open_csv(source, convert_options=convert, **options))
        yield Batches(None, _told(_columns(reader, stamps), path.stat().st_size, None, done))


@contextmanager
def _parquet(path: Path, wanted: Sequence[str], done: Bytes) -> Iterator[Batches]:
    with _explained(path), pa.parquet.ParquetFile(path, buffer_size=PARQUET_BUFFER, pre_buffer=False) as file:
        for name in wanted:
            kind = file.schema_arrow.field(name).type
            if not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
                raise RecordError(f"{path.name}, column {name!r}: it holds {kind}; numbers are needed.")
        rows = file.metadata.num_rows
        batches = file.iter_batches(PARQUET_ROWS, columns=list(wanted))
        yield Batches(rows, _told(_columns(batches, {}), path.stat().st_size, rows, done))


def _columns(batches: Iterator[pa.RecordBatch], stamps: Mapping[int, Timestamps]) -> Iterator[list[FloatArray]]:
    for batch in batches:
        if batch.num_rows:
            yield [
                stamps[place](column) if place in stamps else column.to_numpy(zero_copy_only=False).astype(np.float64, copy=False)
                for place, column in enumerate(batch.columns)
            ]


def _told(batches: Iterator[list[FloatArray]], size: int, rows: int | None, done: Bytes) -> Iterator[list[FloatArray]]:
    """Tells how many of the file's `size` bytes each batch was, by its rows; where `rows` is None, all by those of the first block."""
    told = 0.0
    for columns in batches:
        count = columns[0].size
        rows = rows or count * max(1, size // CSV_BLOCK)
        yield columns
        before, told = told, min(float(size), told + size * count / rows)
        done(int(told) - int(before))
    done(size - int(told))


@contextmanager
def _explained(path: Path, form: TextForm = PLAIN, wanted: Sequence[str] = ()) -> Iterator[None]:
    try:
        check_regular(path)
        yield
    except OSError as error:
        raise RecordError(f"{path.name}: {error.strerror or error}.") from error
    except pa.ArrowException as error:
        where = "" if is_parquet(path) else bad_line(path, form, wanted)
        raise RecordError(
            f"{path.name}: this is no table of numbers ({where or error}). Numbers have a decimal point, or what reader.decimal says; "
            "missing ones are left empty."
        ) from error
    except UnicodeEncodeError as error:
        raise RecordError(f"{path.name}: the file's name is no text (UTF-8); rename it.") from error
    except UnicodeDecodeError as error:
        raise RecordError(
            f"{path.name}: the headers are not written in UTF-8; name their encoding as reader.encoding, or save the file as UTF-8."
        ) from error
