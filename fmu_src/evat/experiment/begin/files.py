"""Which files of a folder are recordings, and how are they written? The largest group with one set of headers; the rest is left aside."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from evat.experiment import ExperimentError
from evat.files.sniff import Sniffed, sniff
from evat.files.stream import headers, open_batches
from evat.files.table import is_parquet
from evat.files.text import RecordError, TextForm
from evat.model import FloatArray

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".asc", ".lvm", ".prn", ".parquet", ".pq")
MOST_FILES = 1000
DEEPEST = 4  # folders inside one another


@dataclass(frozen=True, slots=True)
class Recordings:
    """Files of one kind, their headers and units below them, their form, and why each other file was left aside."""

    folder: Path
    files: tuple[str, ...]
    sniffed: Sniffed
    aside: tuple[str, ...]


def recordings(folder: Path, known: TextForm, stated: Sequence[str]) -> Recordings:
    """What lies in a folder; ExperimentError where nothing does that could be read."""
    if not folder.is_dir():
        raise ExperimentError(f"{folder}: there is no such folder; name the one that holds the data files.")
    groups: dict[tuple[str, ...], list[tuple[str, Sniffed]]] = defaultdict(list)
    aside: list[str] = []
    for path in _candidates(folder):
        name = path.relative_to(folder).as_posix()
        try:
            _check_name(folder, path, name)
            sniffed = Sniffed(TextForm(), names := headers(path), ("",) * len(names)) if is_parquet(path) else sniff(path, known, stated)
            groups[sniffed.headers].append((name, sniffed))
        except (RecordError, OSError) as error:
            aside.append(str(error) if str(error).startswith(path.name) else f"{name}: {error}")
    if not groups:
        raise ExperimentError(_nothing(folder, aside))
    chosen = max(groups.values(), key=len)
    for other in groups.values():
        aside += [f"{name}: its headers are others than those of {chosen[0][0]}" for name, _ in other if other is not chosen]
    first = chosen[0][1]
    encodings = {each.form.encoding for _, each in chosen} - {"utf-8"}
    for name, each in chosen:
        if replace(each.form, encoding="") != replace(first.form, encoding=""):
            raise ExperimentError(
                f"{name} and {chosen[0][0]} have the same headers and are written differently: {_words(each.form)}; {_words(first.form)}. "
                "One [reader] holds for all files of a folder; save one of them anew, or move it away."
            )
    form = replace(first.form, encoding=encodings.pop() if len(encodings) == 1 else first.form.encoding)
    return Recordings(folder, tuple(name for name, _ in chosen), replace(first, form=form), tuple(aside))


def _nothing(folder: Path, aside: Sequence[str]) -> str:
    """What to say where nothing could be read."""
    kinds = ", ".join(SUFFIXES)
    if aside:
        return f"{folder}: no recording was found among its files ({kinds}). " + " ".join(aside[:5])
    names = sorted(path.name for path in folder.iterdir())
    if not names:
        return f"{folder}: the folder is empty; put the recordings into it ({kinds})."
    there = f"{', '.join(map(repr, names[:5]))}{', ...' if len(names) > 5 else ''}"
    return f"{folder}: none of its files is of a kind that is read ({kinds}); it holds {there}. Export the recordings as CSV or text."


def first_rows(recorded: Recordings, file: str, wanted: Sequence[str]) -> dict[str, FloatArray]:
    """Columns of a file, as far as its first block goes; ExperimentError names the line where something is no number."""
    try:
        with open_batches(recorded.folder / file, wanted, lambda count: None, recorded.sniffed.form) as batches:
            columns = next(iter(batches.each), [np.empty(0)] * len(wanted))
    except RecordError as error:
        raise ExperimentError(str(error)) from error
    return dict(zip(wanted, columns, strict=True))


def _candidates(folder: Path) -> list[Path]:
    chosen: list[Path] = []
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        if len(parts) <= DEEPEST and not any(part.startswith(".") for part in parts) and path.suffix.lower() in SUFFIXES and path.is_file():
            chosen.append(path)
        if len(chosen) > MOST_FILES:
            raise ExperimentError(f"{folder}: more than {MOST_FILES} data files; name a folder with fewer.")
    return chosen


def _check_name(folder: Path, path: Path, name: str) -> None:
    if not path.resolve().is_relative_to(folder.resolve()):
        raise RecordError(f"{path.name}: it leads out of the folder; copy the file into it.")
    if "\\" in name or not name.isprintable() or any("\ud800" <= sign <= "\udfff" for sign in name):
        raise RecordError(f"{path.name!r}: the file's name has signs that no document can hold; rename it.")


def _words(form: TextForm) -> str:
    between, lines = repr(form.delimiter), f"{form.skip_rows} lines above the headers, {form.rows_after_header} below"
    return f"{between} between columns, decimal mark {form.decimal!r}, {lines}"
