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
from evat.files.text import RecordError, TextForm, in_file
from evat.model import FloatArray

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".asc", ".lvm", ".prn", ".parquet", ".pq")
MOST_FILES = 1000
DEEPEST = 4  # folders inside one another


class NoHeaders(ExperimentError):
    """No file that could be read says what its columns are."""


@dataclass(frozen=True, slots=True)
class Recordings:
    """Files of one kind, their headers and units below them, their form, and why each other file was left aside. `headed` is the file whose
    headers are taken for those of `bare`, which have none."""

    folder: Path
    files: tuple[str, ...]
    sniffed: Sniffed
    aside: tuple[str, ...]
    headed: str = ""
    bare: tuple[str, ...] = ()


def recordings(folder: Path, known: TextForm, stated: Sequence[str]) -> Recordings:
    """What lies in a folder; ExperimentError where nothing does that could be read, NoHeaders where headers alone are missing."""
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
    without_any = {name for name, _ in groups.get((), ())}
    unnamed = _take_over(groups)
    aside += unnamed
    if not groups:
        raise (NoHeaders if unnamed else ExperimentError)(_nothing(folder, aside))
    chosen = max(groups.values(), key=len)
    for other in groups.values():
        aside += [f"{name}: its headers are others than those of {chosen[0][0]}" for name, _ in other if other is not chosen]
    first = next((each for _, each in chosen if not each.form.columns), chosen[0][1])
    without = tuple(name for name, each in chosen if each.form.columns)
    first = replace(first, form=replace(first.form, columns=first.headers if without else ()))
    encodings = {each.form.encoding for _, each in chosen} - {"utf-8"}
    for name, each in chosen:
        if replace(each.form, encoding="") != replace(in_file(folder / name, first.form), encoding=""):
            raise ExperimentError(
                f"{name} and {chosen[0][0]} have the same headers and are written differently: {_words(each.form)}; {_words(first.form)}. "
                "One [reader] holds for all files of a folder; save one of them anew, or move it away."
            )
    form = replace(first.form, encoding=encodings.pop() if len(encodings) == 1 else first.form.encoding)
    bare = tuple(name for name in without if name in without_any)
    headed = next(name for name, _ in chosen if name not in without) if bare else ""
    return Recordings(folder, tuple(name for name, _ in chosen), replace(first, form=form), tuple(aside), headed, bare)


def _take_over(groups: dict[tuple[str, ...], list[tuple[str, Sniffed]]]) -> list[str]:
    """Put each file without headers to the files whose headers it may have; why others are left aside."""
    unnamed: dict[str, list[str]] = defaultdict(list)
    for name, sniffed in groups.pop((), []):
        alike = [headers for headers, ((_, other), *_) in groups.items() if _may_share(sniffed, headers, other)]
        if len(alike) == 1:
            groups[alike[0]].append((name, replace(sniffed, form=replace(sniffed.form, columns=alike[0]))))
            continue
        several = " and ".join(groups[headers][0][0] for headers in alike)
        why = f"the headers of {several} are as many, and others" if several else "no file like it has headers"
        unnamed[f"line {sniffed.form.skip_rows + 1} is the first of {len(sniffed.units)} numbers, without headers; {why}"].append(name)
    todo = "Add a line of headers, or name the columns in their order: --columns 't [s], v [m/s], F [N]'."
    return [f"{some(files)}: {why}. {todo}" for why, files in unnamed.items()]


def _may_share(bare: Sniffed, headers: tuple[str, ...], headed: Sniffed) -> bool:
    """Whether a file without headers may have those of another: as many columns, set apart and written alike."""
    alike = (bare.form.delimiter, bare.form.decimal) == (headed.form.delimiter, headed.form.decimal)
    return len(headers) == len(bare.units) and alike and not headed.form.columns


def some(files: Sequence[str]) -> str:
    """A list that is not too long."""
    return f"{', '.join(files[:3])}{f' and {len(files) - 3} more' if len(files) > 3 else ''}"


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
        raise RecordError(f"{path.name!r}: the file's name has characters that experiment.toml cannot hold; rename it.")


def _words(form: TextForm) -> str:
    between = repr(form.delimiter)
    lines = f"{form.skip_rows} lines above the headers, {form.rows_after_header} below"
    if form.columns:
        lines = f"no headers, {form.skip_rows} lines above the numbers"
    return f"{between} between columns, decimal mark {form.decimal!r}, {lines}"
