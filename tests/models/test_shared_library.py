"""Is a library that is cut short told from a whole one before it ends the process?"""

from __future__ import annotations

import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from evat.files.shared_library import cut_at
from evat.native.compile import kernel_library_path

BINARIES = "binaries/"


# The least that a PE and a Mach-O file consist of: one section, one segment, of 100 bytes each.
PE = (
    b"MZ"
    + bytes(58)
    + struct.pack("<I", 64)
    + b"PE\0\0"
    + struct.pack("<2xH12xH2x", 1, 0)
    + struct.pack("<16xII16x", 100, 128)
    + bytes(100)
)
SEGMENT = struct.pack("<II16x4Q16x", 0x19, 72, 0, 100, 104, 100)
MACH = struct.pack("<I12xIII4x", 0xFEEDFACF, 1, len(SEGMENT), 0) + SEGMENT + bytes(100)
FAT = struct.pack(">II8xIII", 0xCAFEBABE, 1, 28, len(MACH), 0) + MACH


def is_told(library: bytes, place: Path) -> None:
    place.write_bytes(library)
    assert cut_at(place) is None
    for length in (6, len(library) // 2, len(library) * 3 // 4, len(library) - 40):
        place.write_bytes(library[:length])
        wanted = cut_at(place)
        assert wanted is not None, length
        assert length < wanted <= len(library), length


@pytest.mark.parametrize("library", [PE, MACH, FAT], ids=["PE", "Mach-O", "Mach-O for several"])
def test_a_part_of_a_library_is_none(tmp_path: Path, library: bytes) -> None:
    is_told(library, tmp_path / "library")


def test_nor_is_a_part_of_one_of_this_machine(tmp_path: Path) -> None:
    is_told(kernel_library_path().read_bytes(), tmp_path / "library")


def test_what_is_no_library_is_left_to_the_system(tmp_path: Path) -> None:
    (tmp_path / "text.so").write_text("no library")
    assert cut_at(tmp_path / "text.so") is None


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_with_half_a_library_is_refused_in_one_line(fmus: dict[str, Path], tmp_path: Path, version: int) -> None:
    """In a process of its own, which it ended."""
    with zipfile.ZipFile(fmus[f"fmi{version}"]) as whole, zipfile.ZipFile(tmp_path / "half.fmu", "w") as half:
        for entry in whole.infolist():
            data = whole.read(entry)
            half.writestr(entry, data[: len(data) // 2] if entry.filename.startswith(BINARIES) else data)
    code = "import sys; from pathlib import Path; from evat.models.drive import Driver; Driver(Path(sys.argv[1]), {}).__enter__()"
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "half.fmu")], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.returncode
    assert "FmuError: " in done.stderr
    assert "is truncated" in done.stderr.splitlines()[-1]
