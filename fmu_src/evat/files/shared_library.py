"""Is a shared library whole? What its headers speak of must lie within the file: to load one that is cut short ends the process."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from pathlib import Path

_MACH_SEGMENTS = {0x1: ("II", 32), 0x19: ("QQ", 40)}  # of 32 and of 64 bits: place and size in the file, and where these stand


def cut_at(library: Path) -> int | None:
    """How many bytes the file should have at least, where it has fewer; None where nothing is missing, or it is no ELF, PE or Mach-O file,
    which the system says itself."""
    data = library.read_bytes()
    for marks, ends in _KINDS:
        if data.startswith(marks):
            needed = 0
            try:
                for end in ends(data):
                    needed = max(needed, end)
            except struct.error:  # the headers themselves are cut
                needed = max(needed, len(data) + 1)
            return needed if needed > len(data) else None
    return None


def _elf(data: bytes) -> Iterator[int]:
    """Ends of the tables of segments and sections, and of what each of them holds."""
    wide, order = data[4] == 2 if len(data) > 4 else True, ">" if data[5:6] == b"\2" else "<"
    segments, sections = struct.unpack_from(f"{order}{'QQ' if wide else 'II'}", data, 32 if wide else 28)
    sizes = struct.unpack_from(f"{order}4H", data, 54 if wide else 42)
    yield segments + sizes[0] * sizes[1]
    yield sections + sizes[2] * sizes[3]
    for n in range(sizes[1]):
        start = segments + n * sizes[0]
        yield sum(struct.unpack_from(f"{order}Q16xQ", data, start + 8) if wide else struct.unpack_from(f"{order}I8xI", data, start + 4))
    for n in range(sizes[3]):
        start = sections + n * sizes[2]
        (kind,) = struct.unpack_from(f"{order}I", data, start + 4)
        if kind not in (0, 8):  # of no use, or filled with zeros that no file has
            yield sum(struct.unpack_from(f"{order}{'QQ' if wide else 'II'}", data, start + (24 if wide else 16)))


def _pe(data: bytes) -> Iterator[int]:
    """Ends of the table of sections, and of what each of them holds."""
    (at,) = struct.unpack_from("<I", data, 60)
    sections, optional = struct.unpack_from("<2xH12xH", data, at + 4)
    table = at + 24 + optional
    yield table + 40 * sections
    for n in range(sections):
        yield sum(struct.unpack_from("<II", data, table + 40 * n + 16))


def _mach(data: bytes) -> Iterator[int]:
    """Ends of the commands, and of what each segment holds."""
    order = "<" if data[0] in (0xCE, 0xCF) else ">"
    commands, size = struct.unpack_from(f"{order}16xII", data)
    at = 32 if 0xCF in (data[0], data[3]) else 28
    yield at + size
    for _ in range(commands):
        kind, length = struct.unpack_from(f"{order}II", data, at)
        if kind in _MACH_SEGMENTS:
            form, place = _MACH_SEGMENTS[kind]
            yield sum(struct.unpack_from(f"{order}{form}", data, at + place))
        at += length


def _fat(data: bytes) -> Iterator[int]:
    """Ends of the libraries for several processors that lie in one file."""
    (count,) = struct.unpack_from(">4xI", data)
    for n in range(count):
        yield sum(struct.unpack_from(">II", data, 8 + 20 * n + 8))


_KINDS: tuple[tuple[bytes | tuple[bytes, ...], Callable[[bytes], Iterator[int]]], ...] = (
    (b"\x7fELF", _elf),
    (b"MZ", _pe),
    ((b"\xce\xfa\xed\xfe", b"\xcf\xfa\xed\xfe", b"\xfe\xed\xfa\xce", b"\xfe\xed\xfa\xcf"), _mach),
    (b"\xca\xfe\xba\xbe", _fat),
)
