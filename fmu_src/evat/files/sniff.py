"""How was a file of numbers written, if nobody says so? Encoding, delimiter, decimal mark, and the lines above the numbers, from its first
lines."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import charset_normalizer

from evat.files.cells import is_numeric, is_timestamp, numbers_of, split
from evat.files.regular import check_regular
from evat.files.spelling import unit_meant
from evat.files.table import is_parquet
from evat.files.text import LONGEST_LINE, RecordError, TextForm, delimiter_of, in_file, lines_of

HEAD = 256 << 10  # bytes that are looked at
MOST_LINES = 500  # of them: more take time and tell nothing new
MOST_BYTES = 8 << 30
DELIMITERS = ("\t", ";", ",", "|", " ")
FEWEST_ROWS = 2
CLEARLY = 1.1
MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
# What measuring programs write, the commonest first; a few letters in a line of headers leave the choice between all others open.
ENCODINGS = ["cp1252", "latin_1", "cp1250", "cp1251", "cp932", "gb18030"]
# The letters beyond ASCII of languages that share an encoding, a language a word: French, Italian, Spanish, Portuguese, German, Danish and
# Norwegian, Swedish and Finnish; Polish, Czech and Slovak, Hungarian, Romanian, Croatian and Slovene. The õ of Portuguese is left out: it
# would be the ő of Hungarian, where it is in the word for a force.
LETTERS = {
    "cp1252": "àâçèéêëîïôùûüÿœ àèéìíîòóùú áéíñóúü àáâãçéêíóôú äöüß åæøéòó åäöé",
    "cp1250": "ąćęłńóśźż áäčďéěíĺľňóôŕřšťúůýž áéíóöőúüű âăîşţ čćđšž",
}
_SIGNS = "µºª"  # are letters to Unicode
_WITHIN = re.compile(r"[¹²³£¥¿¼¾][^\W\d_]")  # no sign of these stands before a letter: it is one, in another encoding


@dataclass(frozen=True, slots=True)
class Sniffed:
    """What a file looks like: its form, its headers, () where it has none, what a line of units below them says of each, "" where it says
    nothing, and the headers of columns that hold times of day."""

    form: TextForm
    headers: tuple[str, ...]
    units: tuple[str, ...]
    timestamps: tuple[str, ...] = ()


def sniff(path: Path, known: TextForm | None = None, stated: Sequence[str] = ()) -> Sniffed:
    """The form of a text file; fields of `known` that are `stated` are taken from there. RecordError where it is no text with numbers."""
    check_regular(path)
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise RecordError(f"{path.name}: {size / 2**30:.3g} GiB; at most {MOST_BYTES >> 30} GiB are looked at. Cut it into recordings.")
    with path.open("rb") as file:
        head = file.read(HEAD)
    known = known or TextForm()
    encoding = known.encoding if "encoding" in stated else encoding_of(head, path.name)
    text = codecs.getincrementaldecoder("utf-8-sig" if encoding == "utf-8" else encoding)(errors="replace").decode(head)
    lines = text.splitlines()[: None if size <= HEAD else -1][:MOST_LINES]
    if any(len(line) > LONGEST_LINE // 8 for line in lines) or (not lines and size):
        raise RecordError(f"{path.name}: a line of more than {LONGEST_LINE // 8} characters; this is no table with a row a line.")
    best: tuple[tuple[int, int], str, str, list[bool]] | None = None
    for delimiter in DELIMITERS if "delimiter" not in stated else (known.delimiter,):
        for decimal in (".", ",") if "decimal" not in stated else (known.decimal,):
            if decimal == delimiter:
                continue
            rows = [split(line, delimiter) for line in lines]
            width = max((len(row) for row in rows), key=[len(row) for row in rows if len(row) > 1].count, default=0)
            numeric = [len(row) == width > 1 and is_numeric(row, decimal) for row in rows]
            count = numbers_of(decimal)
            score = (sum(numeric), sum(count(row) for row, counts in zip(rows, numeric, strict=True) if counts))
            # Blanks stand inside cells, too: they set columns apart only where nothing else tells about as many numbers.
            if best is None or (score > best[0] and (delimiter != " " or score[1] > CLEARLY * best[0][1])):
                best = (score, delimiter, decimal, numeric)
    if best is None or best[0][0] < FEWEST_ROWS:
        raise RecordError(
            f"{path.name}: no rows of numbers were seen in its first {len(lines)} lines, with tab, semicolon, comma, bar or blanks "
            "between the columns."
            if size
            else f"{path.name}: the file is empty."
        )
    _, delimiter, decimal, numeric = best
    form = TextForm(delimiter, decimal, encoding)
    return _headed(path, lines, numeric.index(True), form, known, stated)


def _headed(path: Path, lines: list[str], first: int, form: TextForm, known: TextForm, stated: Sequence[str]) -> Sniffed:
    """Which of the lines above the numbers are headers, which are units."""
    first_row = split(lines[first], form.delimiter)
    width = len(first_row)
    above = [place for place in range(first) if len(split(lines[place], form.delimiter, width)) == width]
    if "skip_rows" in stated:
        above = [place for place in above if place >= known.skip_rows]
    if not above and "columns" not in stated and (shorter := _of_rows_that_end_with_a_delimiter(lines, first, form.delimiter)):
        names, below = shorter
        return Sniffed(replace(form, skip_rows=first, columns=names), names, _bare(below), _stamped(names, first_row))
    if not above:
        if known.columns and len(known.columns) != width:
            raise RecordError(
                f"{path.name}: line {first + 1} is the first of {width} numbers, and {len(known.columns)} columns are named; name all."
            )
        form = replace(form, skip_rows=first, columns=known.columns)
        return Sniffed(form, form.columns, ("",) * width, _stamped(form.columns, first_row))
    header, units = above[0] if "skip_rows" in stated else above[-1], [""] * width
    rows = {place: split(lines[place], form.delimiter, width) for place in above}
    if "skip_rows" not in stated and len(above) > 1 and _is_units(rows[header], rows[above[-2]]):
        header = above[-2]
    if header != above[-1]:
        units = rows[above[-1]]
    form = replace(form, skip_rows=header, rows_after_header=first - header - 1)
    names = tuple(rows[header])
    return Sniffed(form, names, _bare(units), _stamped(names, first_row))


def _of_rows_that_end_with_a_delimiter(lines: list[str], first: int, delimiter: str) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Headers and units above rows that have one cell more than these, an empty one; None where that is not so."""
    width = len(split(lines[first], delimiter))
    above = [cells for line in lines[:first] if len(cells := split(line, delimiter)) == width - 1]
    if not above or any(split(line, delimiter)[-1].strip() for line in lines[first:] if line.strip()):
        return None
    if len(above) > 1 and _is_units(above[-1], above[-2]):
        return (*above[-2], ""), (*above[-1], "")
    return (*above[-1], ""), ("",) * width


def _bare(units: Sequence[str]) -> tuple[str, ...]:
    return tuple(unit.strip().strip("[]()") for unit in units)


def _stamped(names: Sequence[str], first_row: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name, cell in zip(names, first_row, strict=False) if is_timestamp(cell))


def encoding_of(head: bytes, name: str) -> str:
    """The encoding of a file's first bytes; RecordError where they are no text."""
    for mark, encoding in MARKS.items():
        if head.startswith(mark):
            return encoding
    if b"\0" in head:
        raise RecordError(f"{name}: it holds bytes that no text has; this is a binary file. Export it as CSV or Parquet.")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        # Only lines with such letters tell anything; the many digits beside them would hide them.
        telling = b"\n".join(line for line in head.splitlines() if not line.isascii())[:4096]
        for western_or_eastern, languages in LETTERS.items():
            if _of_one_language(telling, western_or_eastern, languages.split()):
                return western_or_eastern
        likeliest = charset_normalizer.from_bytes(telling, cp_isolation=ENCODINGS, preemptive_behaviour=False).best()
        if likeliest is None:
            raise RecordError(f"{name}: its encoding cannot be told; give it as --encoding, such as cp1252, or save it as UTF-8.") from None
        # Where several read the same, the commonest is meant; bytes that one of them has not stand for no letter there.
        return "cp1252" if telling.decode("cp1252", "replace") == str(likeliest) else likeliest.encoding
    return "utf-8"


def _of_one_language(text: bytes, encoding: str, languages: Sequence[str]) -> bool:
    """Whether a text in that encoding has letters beyond ASCII, of one of the languages alone."""
    try:
        read = text.decode(encoding)
    except UnicodeDecodeError:
        return False
    letters = {sign.lower() for sign in read if sign.isalpha() and not sign.isascii() and sign not in _SIGNS}
    return bool(letters) and not _WITHIN.search(read) and any(letters <= set(language) for language in languages)


def units_below(path: Path, form: TextForm, names: Sequence[str]) -> dict[str, str]:
    """By header, what a line of units between headers and numbers says; empty where there is none. A file that cannot be read has none."""
    if is_parquet(path) or not form.rows_after_header:
        return {}
    own = in_file(path, form)
    if own.columns:
        return {}
    lines = lines_of(path, own, own.skip_rows + 1 + own.rows_after_header)[own.skip_rows + 1 :]
    for line in lines:
        cells = split(line.rstrip("\r\n"), delimiter_of(path, own), len(names))
        if len(cells) == len(names) and _is_units(cells, names):
            return dict(zip(names, _bare(cells), strict=True))
    return {}


def _is_units(cells: Sequence[str], above: Sequence[str]) -> bool:
    """Whether a line below one of names holds their units."""
    filled = [cell for cell in cells if cell.strip()]
    units = sum(unit_meant(cell.strip().strip("[]()")) is not None for cell in filled)
    return 2 * units >= len(filled) > 0 and sum(bool(cell.strip()) for cell in above) >= len(filled)
