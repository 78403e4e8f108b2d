"""What does a person read and see who opens the FMU? documentation/index.html and its pictures."""

from __future__ import annotations

from pathlib import Path

from evat.files.unpack import opened
from evat.files.writing import put

FOLDER = "documentation"  # in an FMU


def beside(fmu: Path, to: Path) -> dict[str, str]:
    """The documentation of an FMU, unpacked into the folder `to`: its first page as a link from there, and what it is."""
    with opened(fmu) as packed:
        for name in packed.namelist():
            if name.startswith(f"{FOLDER}/") and not name.endswith("/"):
                put(to / name, packed.read(name))
    return {f"{FOLDER}/index.html": f"what the FMU of these runs is: {fmu.name}, its equations, variables and their sources"}
