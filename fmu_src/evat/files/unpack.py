"""How is an archive unpacked that a stranger sent? Nothing leaves its folder, nothing is there twice, and a bomb stays packed.

What an archive says of its files is checked before any is written, and holds: no more of a file is unpacked than the archive says it has.
"""

from __future__ import annotations

import errno
import lzma
import stat
import unicodedata
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from evat.files.writing import as_output_error
from evat.model import EvatError

MOST_FILES, MOST_BYTES = 4000, 2 << 30  # of an archive once unpacked, with the archives in it
MOST_TIMES, HARMLESS = 100, 64 << 20  # it may be so many times as large unpacked, or so large in any case; binaries shrink to a third
_BLOCK = 1 << 20
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)
_ENCRYPTED = 0x41  # flags: by a password, and strongly
_LONGEST_NAME = 255
_BROKEN = "this archive cannot be read, it is corrupt or no ZIP"


class ArchiveError(EvatError):
    """An archive that is broken, or that nobody should unpack."""


@dataclass
class Allowance:
    """What may still be unpacked [bytes]: of one archive, or of several that lie in one."""

    left: int = field(default_factory=lambda: MOST_BYTES)


@contextmanager
def opened(archive: Path, where: str = "", allowance: Allowance | None = None) -> Iterator[zipfile.ZipFile]:
    """An archive whose entries were checked; `where` says in an error what it is part of.

    Raises
    ------
    ArchiveError, where it is no ZIP, or is damaged, or unpacks to too much, or an entry lies outside or is there twice.
    """
    where = f"{where}, {archive.name}" if where else archive.name
    if not archive.is_file():
        raise ArchiveError(f"{where}: there is no such file.")
    with _readable(where):
        packed = zipfile.ZipFile(archive)
    with packed:
        _check(packed.infolist(), archive.stat().st_size, where, allowance or Allowance())
        yield packed


def unpack(archive: Path, folder: Path, where: str = "", allowance: Allowance | None = None, but: tuple[str, ...] = ()) -> None:
    """Unpack a ZIP into `folder`, `but` for folders of these names ("sources/"). ArchiveError where it should not be or cannot be read,
    OutputError where `folder` cannot be written."""
    with opened(archive, where, allowance) as packed:
        for entry in packed.infolist():
            if entry.filename.startswith(but):
                continue
            path = folder / entry.filename
            with as_output_error(path):
                (path if entry.is_dir() else path.parent).mkdir(parents=True, exist_ok=True)
            if not entry.is_dir():
                _copy(packed, entry, path, archive.name)


def member(packed: zipfile.ZipFile, name: str) -> bytes:
    """One file of an archive."""
    with _readable(Path(packed.filename or "").name):
        return packed.read(name)


def _copy(packed: zipfile.ZipFile, entry: zipfile.ZipInfo, path: Path, where: str) -> None:
    """Block by block, since only so can be told whether the archive or the disk is at fault."""
    with _readable(where):
        source = packed.open(entry)
    with source, as_output_error(path), path.open("wb") as target:
        while True:
            with _readable(where):
                block = source.read(_BLOCK)
            if not block:
                return
            target.write(block)


@contextmanager
def _readable(where: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        if error.errno in (None, errno.EINVAL):  # a place in the file that is none
            raise ArchiveError(f"{where}: {_BROKEN} ({error}). Fetch it again.") from error
        raise ArchiveError(f"{where}: it cannot be read: {error.strerror}. Check that file and its disk.") from error
    except (EOFError, zipfile.BadZipFile, zlib.error, lzma.LZMAError, NotImplementedError, RuntimeError, ValueError) as error:
        raise ArchiveError(f"{where}: {_BROKEN} ({error}). Fetch it again.") from error


def _check_entry(entry: zipfile.ZipInfo, where: str) -> None:
    """ArchiveError for one that cannot be unpacked, as sound as it is."""
    named = f"{where}: the entry {entry.filename[:80]!r}"
    if entry.flag_bits & _ENCRYPTED:
        raise ArchiveError(f"{named} is encrypted; pack the archive without a password.")
    if entry.compress_type not in _METHODS:
        raise ArchiveError(f"{named} is packed by method {entry.compress_type}, which is not read; repack it with Deflate.")
    if any(unicodedata.category(sign) == "Cc" for sign in entry.filename):
        raise ArchiveError(f"{named} has control characters in its name; the archive is refused.")
    if (longest := max(len(part.encode(errors="replace")) for part in entry.filename.split("/"))) > _LONGEST_NAME:
        raise ArchiveError(f"{named} has a name of {longest} bytes, and no disk takes more than {_LONGEST_NAME}; rename it.")


def _check(entries: list[zipfile.ZipInfo], size: int, where: str, allowance: Allowance) -> None:
    files, folders = set[PurePosixPath](), set[PurePosixPath]()
    for entry in entries:
        name, kind = entry.filename, entry.external_attr >> 16
        path = PurePosixPath(name.casefold())  # to Windows and macOS both cases are one file
        _check_entry(entry, where)
        if not path.parts or path.is_absolute() or ".." in path.parts or set("\\:") & set(name) or "\0" in entry.orig_filename:
            raise ArchiveError(f"{where}: the entry {name!r} would be written outside of the archive's folder; the archive is refused.")
        if stat.S_ISLNK(kind):
            raise ArchiveError(f"{where}: the entry {name!r} is a link; the archive is refused.")
        if path in files:
            raise ArchiveError(
                f"{where}: the entry {name!r} is there twice, or differs from another by case alone, and readers differ in which they "
                "take; it is refused."
            )
        folders.update(path.parents)
        (folders if entry.is_dir() else files).add(path)
    if both := sorted(map(str, files & folders)):
        raise ArchiveError(f"{where}: the entry {both[0]!r} is there twice, as a file and as a folder; the archive is refused.")
    wanted = sum(entry.file_size for entry in entries)
    if len(entries) > MOST_FILES or wanted > MOST_BYTES:
        raise ArchiveError(f"{where}: it unpacks to more than {MOST_FILES} files or {MOST_BYTES >> 30} GiB; it is not read.")
    if wanted > max(HARMLESS, MOST_TIMES * size):
        raise ArchiveError(
            f"{where}: it has {size / 2**20:.3g} MiB and unpacks to {wanted / 2**20:.3g} MiB; what is then more than {MOST_TIMES} times "
            "as large is taken for a decompression bomb and not read. If it is yours, pack it with less compression."
        )
    if wanted > allowance.left:
        raise ArchiveError(f"{where}: with it, archives that lie in one unpack to more than {MOST_BYTES >> 30} GiB in all; it is not read.")
    allowance.left -= wanted
