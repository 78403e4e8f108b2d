"""Which cells does a line of text have, and are they numbers or times of day?"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence

NUMBER = re.compile(r"\s*[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?\s*")
MISSING = ("", "nan", "na", "n/a", "null", "inf", "-inf", "+inf")  # what Arrow takes for a number that is none
TIME_OF_DAY = (
    r"^\s*(?P<date>(?:.*[^0-9:])?)(?P<hour>\d{1,2}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d(?:[.,]\d+)?)"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?:Z|[+-]\d{2}:?\d{2})?\s*$"
)


def cells_of(line: str, width: int) -> list[str]:
    """The cells of a line whose columns are set apart by blanks. Where it does not have `width` words, it is one of headers: a unit in
    brackets belongs to the name before it, and names of several words are set apart by two blanks or more; a sign of a remark in front
    does not count."""
    words = line.split()
    if len(words) == width or not words:
        return words
    text = re.sub(r"^(?:#|%|//|;)+\s*", "", line.strip())
    ways = (text.split(), re.split(r"\s+(?![\[(])", text), re.split(r"\s{2,}|\t", text))
    return next((way for way in ways if len(way) == width), words)


def split(line: str, delimiter: str, width: int = 0) -> list[str]:
    """The cells of a line; `width`, where it is known, tells of headers with blanks which words belong together."""
    if delimiter == " ":
        return cells_of(line, width)
    try:
        return next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:
        return [line]


def numbers_of(decimal: str) -> Callable[[Sequence[str]], int]:
    """How many cells of a row are numbers with that decimal mark."""
    other = "," if decimal == "." else "."
    return lambda row: sum(NUMBER.fullmatch(cell) is not None and other not in cell for cell in row)


def is_numeric(row: Sequence[str], decimal: str) -> bool:
    """Whether most of what is filled in is numbers."""
    filled = [cell for cell in row if cell.strip().lower() not in MISSING]
    return bool(filled) and 2 * numbers_of(decimal)(filled) >= len(filled)


def is_timestamp(text: str) -> bool:
    """Whether a cell holds a time of day, with a date in front or without: 2024-05-03T10:15:00.250, 03.05.2024 10:15:00,25, 10:15:00 PM."""
    return re.match(TIME_OF_DAY, text) is not None
