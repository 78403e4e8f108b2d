"""Where is the FMU that runs on this machine? In the package, if a wheel brought it; else among the user's caches, built on first use.
FMUs for all platforms are kept there, too.

Either is taken only while it is whole, and made from what is here now; those of other states are cleared away when nobody has used them for
a month. `python -m evat.fmu.host FOLDER` writes what a wheel brings.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import re
import shutil
import sys
import time
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from platformdirs import user_cache_path

from evat import fmu
from evat.files.writing import OutputError, put
from evat.fmu import Progress, silent
from evat.fmu.fmu_facts import Version
from evat.native.compile import CONTACT, PACKAGE, TARGETS, host_target, is_whole, seal, seal_of, source_root

BROUGHT = PACKAGE / "_fmus"
# What an FMU is made from: C and facts, and the rooms of the package that building one loads, with the modules that stand in none.
SOURCES = ("fmi", "fmus", "kernel", "machines")
ROOMS = ("files", "fmu", "native", "paper", "parameters", "templates")
VERSIONS: tuple[Version, ...] = (2, 3)
UNUSED = 30 * 24 * 3600.0  # s, after which what another state of the sources left is cleared away
KINDS = (".c", ".h", ".j2", ".py", ".toml")


@lru_cache
def made_from() -> str:
    """Changes with anything of ours that an FMU is made from; the same in a checkout and where it is installed."""
    root = source_root()
    files = {f"{path.relative_to(root)}": path for name in SOURCES for path in (root / name).rglob("*")}
    files |= {f"evat/{path.name}": path for path in PACKAGE.iterdir()}
    files |= {f"evat/{path.relative_to(PACKAGE)}": path for name in ROOMS for path in (PACKAGE / name).rglob("*")}
    digest = hashlib.sha256(host_target().zig.encode())
    for name, path in sorted(files.items()):
        if path.suffix in KINDS:
            digest.update(f"{Path(name).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def _kept(version: Version, part: str, targets: tuple[str, ...] = ()) -> Path:
    """Where the user's caches have it: a place for each state of the sources, each version of what compiles them, and each set of
    platforms but this machine's own alone."""
    digest = hashlib.sha256(made_from().encode() + os.environ.get("SOURCE_DATE_EPOCH", "").encode() + ",".join(targets).encode())
    for package in ("evat", "fmpy", "ziglang"):
        with suppress(importlib.metadata.PackageNotFoundError):
            digest.update(importlib.metadata.version(package).encode())
    return Path(user_cache_path("evat", appauthor=False)) / digest.hexdigest()[:20] / fmu.file_name(version, part)


def _clear_others(own: Path) -> None:
    """Of the places beside `own` those that nobody has used for long; what is no such place stays."""
    for place in own.parent.iterdir():
        if place != own and re.fullmatch("[0-9a-f]{20}", place.name):
            with suppress(OSError):
                if time.time() - place.stat().st_mtime > UNUSED:
                    shutil.rmtree(place)


def brought(version: Version, part: str = CONTACT) -> Path | None:
    """The FMU that the wheel brought; None where it brought none, or it is no longer that of these sources."""
    path = BROUGHT / fmu.file_name(version, part)
    return path if is_whole(path, made_from()) else None


def host_fmu(version: Version = 2, part: str = CONTACT, progress: Progress = silent) -> Path:
    """The FMU for this machine: that which came with an installed evat, or one that is compiled on first use and kept.

    Parameters
    ----------
    version : 2 or 3
        Of FMI.
    part : str
        The contact, "evat_contact", or one of its partners; `evat.fmu.parts()` lists them.
    progress : callable, optional
        Told what is being done, a line each.

    Returns
    -------
    Path
        Of the FMU; copy it, and leave it as it is.

    Raises
    ------
    CompileError
        Where it has to be compiled, and there is no C compiler (`pip install 'evat[build]'`).
    OutputError
        Where it cannot be kept.

    Examples
    --------
    >>> import evat
    >>> evat.host_fmu(3).name
    'EvatContact-fmi3.fmu'
    """
    return _host_fmu(version, part, progress, {})


def _host_fmu(version: Version, part: str, progress: Progress, binaries: dict[tuple[Version, str, str], bytes]) -> Path:
    """The same; `binaries` are those that were compiled already."""
    if (path := brought(version, part)) is not None:
        return path
    path = _kept(version, part)
    if not is_whole(path, made_from()):
        seal(fmu.build_sharing(version, path, [host_target().fmi3_folder], progress, part, binaries), made_from())
        _clear_others(path.parent)
    with suppress(OSError):  # where the user's caches cannot be written, nothing is cleared either
        os.utime(path.parent)
    return path


def build_all(folder: Path, progress: Progress = silent) -> tuple[Path, ...]:
    """As `fmu.build_all` for this machine alone; what is there already is not compiled again."""
    binaries: dict[tuple[Version, str, str], bytes] = {}
    here = [_host_fmu(version, part, progress, binaries) for part in fmu.parts() for version in VERSIONS]
    return tuple(put(folder / path.name, path.read_bytes()) for path in here)


def build_for_all(folder: Path, progress: Progress = silent) -> tuple[Path, ...]:
    """As `fmu.build_all` for every platform; what was built before from the same sources is taken from the user's caches, where it can
    be kept there."""
    binaries: dict[tuple[Version, str, str], bytes] = {}
    return tuple(_for_all(version, part, folder, progress, binaries) for part in fmu.parts() for version in VERSIONS)


def _for_all(version: Version, part: str, folder: Path, progress: Progress, binaries: dict[tuple[Version, str, str], bytes]) -> Path:
    kept, path = _kept(version, part, tuple(TARGETS)), folder / fmu.file_name(version, part)
    if is_whole(kept, made_from()):
        put(path, kept.read_bytes())
    else:
        fmu.build_sharing(version, path, None, progress, part, binaries)
        with suppress(OSError, OutputError):
            seal(put(kept, path.read_bytes()), made_from())
            _clear_others(kept.parent)
    with suppress(OSError):
        os.utime(kept.parent)
    return path


def bring(folder: Path) -> None:
    """Every FMU into the folder, each with what says that it is whole and of these sources."""
    binaries: dict[tuple[Version, str, str], bytes] = {}
    for part in fmu.parts():
        for version in VERSIONS:
            kept = _host_fmu(version, part, silent, binaries)
            for path in (kept, seal_of(kept)):
                put(folder / path.name, path.read_bytes())


if __name__ == "__main__":
    bring(Path(sys.argv[1]))
