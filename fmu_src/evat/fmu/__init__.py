"""How does the component become .fmu files? Kernel tables and compiled C in, EvatContact-fmi2.fmu and -fmi3.fmu out."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

from .. import kernel
from ..compile import TARGETS, host_target, source_root
from . import archive, fmi2, fmi3
from .description import Facts
from .documentation import copyright_line, documentation_files
from .reference_results import reference_files
from .shown import FmuError, Shown, Version, load
from .sources import binary_name, compile_binary, source_files, source_names
from .structure import model_structure
from .terminals import terminal_files

__all__ = ["FmuError", "Version", "build_all", "build_fmu", "facts", "file_name", "shown"]

Progress = Callable[[str], None]


def shown() -> Shown:
    """What the FMU shows beside the kernel's tables."""
    return load(source_root() / "fmus" / "evat_contact.toml")


def facts(version: Version) -> Facts:
    """Everything that modelDescription.xml is made of."""
    return Facts(
        shown=shown(),
        token=kernel.token(),
        variables=kernel.variables(),
        states=kernel.states(),
        laws=kernel.laws(),
        structure=model_structure(),
        sources=source_names(version),
        copyright=copyright_line(),
    )


def model_description(version: Version) -> bytes:
    """modelDescription.xml."""
    write = fmi2.model_description if version == 2 else fmi3.model_description
    return write(facts(version))


def file_name(version: Version) -> str:
    """Name of the archive."""
    return f"{shown().model_name}-fmi{version}.fmu"


def _silent(line: str) -> None:
    """Nobody wants to hear of the progress."""


def build_fmu(version: Version, output: Path, targets: Iterable[str] | None = None, progress: Progress = _silent) -> Path:
    """Build one FMU, for Co-Simulation and Model Exchange, and return its path.

    Parameters
    ----------
    version : 2 or 3, the FMI version.
    output : the .fmu to write; it appears whole or not at all.
    targets : platforms to compile for, by FMI 3 platform tuple; all that the compiler serves by default.
    progress : is told what is being done, a line each.
    """
    if version not in (2, 3):
        raise FmuError(f"FMI version {version!r}: FMUs are built for version 2 or 3.")
    names = list(TARGETS) if targets is None else list(targets)
    if unknown := [name for name in names if name not in TARGETS]:
        raise FmuError(f"no such target: {', '.join(unknown)}; targets are {', '.join(TARGETS)}.")
    if not names:
        raise FmuError(f"an FMU without any binary was asked for; name a target, for example {host_target().fmi3_folder}.")
    about = shown()
    progress(f"FMI {version}: variables, dependencies, documentation")
    files = {
        "modelDescription.xml": model_description(version),
        **documentation_files(about),
        **terminal_files(about, kernel.variables()),
        **reference_files(about),
        **source_files(version, about),
    }
    with tempfile.TemporaryDirectory(prefix="evat-fmu-") as folder:
        for name in names:
            progress(f"FMI {version}: compile for {name}")
            files[binary_name(version, TARGETS[name], about)] = compile_binary(version, TARGETS[name], about, Path(folder))
    progress(f"FMI {version}: write {output.name}")
    return archive.write(files, output)


def build_all(folder: Path, targets: Iterable[str] | None = None, progress: Progress = _silent) -> tuple[Path, ...]:
    """Build the FMUs of both versions into `folder`."""
    names = None if targets is None else list(targets)
    return tuple(build_fmu(version, folder / file_name(version), names, progress) for version in (2, 3))
