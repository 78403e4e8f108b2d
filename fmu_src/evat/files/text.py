"""How is a text file of numbers written, and which line of it is wrong? Options of Arrow's reader, and a look at where it gives up.

Arrow's own transcoding calls Python from its threads and may hang when the interpreter ends in the midst of it. Numbers are ASCII in all
encodings that hold ASCII, so only the headers are decoded, here; what is left, UTF-16 and its like, is decoded whole, in memory.
"""

from __future__ import annotations

import codecs
import csv
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TextIO

import pyarrow as pa
import pyarrow.csv

from evat.files.cells import MISSING, NUMBER, cells_of, is_timestamp, numbers_of, split
from evat.model import EvatError

DELIMITERS = "\t;,"  # that are told apart where none is stated
LONGEST_LINE = 1 << 20  # characters
MOST_DECODED = 256 << 20  # bytes of a file whose encoding does not hold ASCII


class RecordError(EvatError):
    """A data file that does not hold what is needed; names file, column and row."""


@dataclass(frozen=True, slots=True)
class TextForm:
    """How the text files of an experiment are written. Without a `delimiter` it is the commonest of three in the header line; a blank
    stands for any number of blanks and tabs, also in front. `rows_after_header` stand between the headers and the numbers, such as one of
    units. `columns` are the headers of files that begin with numbers. `timestamp` is the header of a clock that is written as times of day,
    "" where it is a number."""

    delimiter: str = ""
    decimal: str = "."
    encoding: str = "utf-8"
    skip_rows: int = 0
    rows_after_header: int = 0
    columns: tuple[str, ...] = ()
    timestamp: str = ""

    @property
    def is_utf8(self) -> bool:
        return codecs.lookup(self.encoding).name in ("utf-8", "utf-8-sig", "ascii")

    @property
    def holds_ascii(self) -> bool:
        return "a;1".encode(self.encoding) == b"a;1"


PLAIN = TextForm()


def known_encoding(name: str) -> bool:
    """Whether Python can read text that is written so."""
    try:
        return bool("1".encode(codecs.lookup(name).name).decode(name) == "1") and not name.lower().startswith("idna")
    except (LookupError, UnicodeError, TypeError, ValueError):
        return False


def lines_of(path: Path, form: TextForm, most: int) -> list[str]:
    """Its first lines, as text; each at most LONGEST_LINE long."""
    encoding = "utf-8-sig" if form.is_utf8 else form.encoding
    try:
        with path.open(encoding=encoding, errors="replace", newline="") as file:
            return list(itertools.takewhile(bool, (file.readline(LONGEST_LINE) for _ in range(most))))
    except UnicodeError as error:  # a mark at the beginning that is not there
        raise _no_such_text(path, form, error) from error


def _no_such_text(path: Path, form: TextForm, error: UnicodeError) -> RecordError:
    return RecordError(f"{path.name}: this is no text in {form.encoding} ({error}); see reader.encoding.")


def _check_mark(path: Path, form: TextForm) -> None:
    """RecordError where a file begins with the mark of UTF-16 and is to be read as if every letter had a byte."""
    with path.open("rb") as file:
        wide = file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    if wide and form.holds_ascii:
        raise RecordError(
            f'{path.name}: this is text in UTF-16, and {form.encoding} was expected; write encoding = "utf-16" in [reader] of '
            "experiment.toml, or save the file as UTF-8."
        )


def in_file(path: Path, form: TextForm) -> TextForm:
    """The form of one file of several: its own headers count where it has some, so `columns` are then left out. Where it has none,
    `skip_rows` of them stand above its numbers, or no line. RecordError where these are more or fewer than `columns`."""
    if not form.columns:
        return form
    lines = [line.rstrip("\r\n") for line in lines_of(path, form, form.skip_rows + 1)]
    delimiters, width = form.delimiter or DELIMITERS, len(form.columns)
    if any(tuple(split(line, delimiter, width)) == form.columns for line in lines[form.skip_rows :] for delimiter in delimiters):
        return replace(form, columns=())
    for place in sorted({0, form.skip_rows} & set(range(len(lines)))):
        rows = {delimiter: split(lines[place], delimiter) for delimiter in delimiters}
        for delimiter, row in rows.items():
            if len(row) == width and _holds_numbers(row, form.decimal):
                return replace(form, skip_rows=place, rows_after_header=0, delimiter=delimiter)
    if lines and len(row := max(rows.values(), key=len)) > 1 and numbers_of(form.decimal)(row) == len(row):
        raise RecordError(
            f"{path.name}, line {place + 1}: {len(row)} numbers where reader.columns names {width} columns; name all of them."
        )
    return replace(form, columns=())


def _holds_numbers(row: Sequence[str], decimal: str) -> bool:
    """Whether more than half of what is filled in is numbers or times of day; a remark above them may hold one of each."""
    filled = [cell for cell in row if cell.strip().lower() not in MISSING]
    return 2 * (numbers_of(decimal)(filled) + sum(map(is_timestamp, filled))) > len(filled)


def delimiter_of(path: Path, form: TextForm = PLAIN) -> str:
    """What stands between the columns of a text file: a tab, semicolon or comma, where the form does not say."""
    if form.delimiter:
        return form.delimiter
    lines = lines_of(path, form, form.skip_rows + 1)
    return max(DELIMITERS, key=lines[-1].count if len(lines) > form.skip_rows else "".count)


def _set_apart_by_tabs(path: Path, form: TextForm) -> tuple[bytes, list[str]]:
    """The rows of a file whose columns are set apart by blanks, with one tab in place of each run of them, and its headers."""
    lines = _decoded(path, form).splitlines()
    first = form.skip_rows + 1 + form.rows_after_header if not form.columns else form.skip_rows
    rows = [row for line in lines[first:] if (row := line.split())]
    if form.columns:
        return "\n".join(map("\t".join, rows)).encode(), list(form.columns)
    header = lines[form.skip_rows] if len(lines) > form.skip_rows else ""
    return "\n".join(map("\t".join, rows)).encode(), cells_of(header, len(rows[0]) if rows else 0)


def _decoded(path: Path, form: TextForm) -> str:
    """The whole of a file that Arrow cannot read by itself."""
    size, encoding = path.stat().st_size, "utf-8-sig" if form.is_utf8 else form.encoding
    if size > MOST_DECODED:
        why = f"in {form.encoding}" if not form.holds_ascii else "with runs of blanks between its columns"
        raise RecordError(
            f"{path.name}: {size >> 20} MiB {why}; a file that large is read only in UTF-8 with a delimiter: save it as that."
        )
    try:
        return path.read_bytes().decode(encoding)
    except UnicodeError as error:
        raise _no_such_text(path, form, error) from error


def text_options(path: Path, form: TextForm, **read: Any) -> tuple[Any, dict[str, Any]]:
    """What Arrow's readers are given: the source, and the options to read and to parse it."""
    _check_mark(path, form)
    form = in_file(path, form)
    delimiter = delimiter_of(path, form)
    source: Any = path
    options: dict[str, Any] = {"skip_rows": form.skip_rows, "skip_rows_after_names": form.rows_after_header}
    if form.columns:
        options["column_names"] = list(form.columns)
    if delimiter == " ":
        body, names = _set_apart_by_tabs(path, form)
        source, delimiter, options = pa.BufferReader(body), "\t", {"column_names": names}
    elif not form.holds_ascii:
        source = pa.BufferReader(_decoded(path, form).encode())
    elif not form.is_utf8 and not form.columns:
        lines = lines_of(path, form, form.skip_rows + 1)
        names = next(csv.reader(lines[form.skip_rows :], delimiter=delimiter), [])
        options = {"skip_rows": form.skip_rows + 1 + form.rows_after_header, "column_names": names}
    if not options.get("column_names", ["told by the file"]):
        raise RecordError(f"{path.name}: there is no line of headers after {form.skip_rows} lines; see reader.skip_rows.")
    return source, {
        "read_options": pa.csv.ReadOptions(**options, **read),
        "parse_options": pa.csv.ParseOptions(delimiter=delimiter),
    }


def bad_line(path: Path, form: TextForm, wanted: Sequence[str] = ()) -> str:
    """The first line after the headers that has too many or too few cells, or no number where one is wanted, in words; "" where all are
    right."""
    form = in_file(path, form)
    encoding, delimiter = "utf-8-sig" if form.is_utf8 else form.encoding, delimiter_of(path, form)
    numbers = tuple(MISSING)
    try:
        with path.open(encoding=encoding, errors="replace", newline="") as file:
            rows = _numbered(file, form, delimiter)
            header = next(rows, (0, []))[1]
            places = [place for place, name in enumerate(header) if name in wanted and name != form.timestamp]
            for number, row in rows:
                line = f"line {number}"
                if row and len(row) != len(header):
                    return f"{line}: {len(row)} cells where the headers are {len(header)}: {delimiter.join(row)[:60]!r}"
                for place in places if row else ():
                    cell = row[place].strip()
                    wrong_mark = "," in cell if form.decimal == "." else "." in cell
                    if cell.lower() not in numbers and (not NUMBER.fullmatch(cell) or wrong_mark):
                        hint = f"; the decimal mark is {form.decimal!r}, see reader.decimal" if NUMBER.fullmatch(cell) else ""
                        return f"{line}, column {header[place]!r}: {cell[:40]!r} is no number{hint}"
    except (OSError, csv.Error) as error:
        return f"({error})"
    return ""


def _numbered(file: TextIO, form: TextForm, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """The number of each line (that of its last, where a cell goes over several) and its cells; the headers first, then the numbers."""
    for _ in range(form.skip_rows):
        file.readline(LONGEST_LINE)
    if form.columns:
        yield form.skip_rows, list(form.columns)
        rows = map(str.split, file) if delimiter == " " else csv.reader(file, delimiter=delimiter)
        yield from enumerate(rows, form.skip_rows + 1)
        return
    if delimiter == " ":
        header = file.readline(LONGEST_LINE)
        for _ in range(form.rows_after_header):
            file.readline(LONGEST_LINE)
        first = file.readline(LONGEST_LINE)
        yield form.skip_rows + 1, cells_of(header, len(first.split()))
        yield from enumerate(map(str.split, itertools.chain([first], file)), form.skip_rows + form.rows_after_header + 2)
        return
    rows = csv.reader(file, delimiter=delimiter)
    for count, row in enumerate(rows):
        if not 0 < count <= form.rows_after_header:
            yield form.skip_rows + rows.line_num, row
