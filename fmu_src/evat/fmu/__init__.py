"""How do contact and partners become .fmu files? Tables and compiled C in, EvatContact-fmi2.fmu and -fmi3.fmu out."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from os import PathLike
from pathlib import Path

from evat.files.writing import temporary, usable
from evat.fmu import archive
from evat.fmu.credibility import credibility_files
from evat.fmu.description import fmi2, fmi3
from evat.fmu.description.model_description import Facts
from evat.fmu.description.terminals import terminal_files
from evat.fmu.documentation.contact import copyright_line
from evat.fmu.fmu_facts import TOLERANCE, Version
from evat.fmu.part_model import fmu_facts_of, model_of, parts, token_of
from evat.fmu.reference_results import reference_files
from evat.fmu.sources import binary_name, compile_binary, source_files, source_names
from evat.model import BuildError
from evat.native.compile import CONTACT, TARGETS, compiler, host_target, stop_compilers

__all__ = ["BuildError", "Version", "build_all", "build_fmu", "facts", "file_name", "fmu_facts_of", "parts"]

Progress = Callable[[str], None]


def facts(version: Version, part: str = CONTACT) -> Facts:
    """Everything that modelDescription.xml is made of."""
    model, fmu_facts = model_of(part), fmu_facts_of(part)
    return Facts(
        fmu=fmu_facts,
        token=token_of(version, fmu_facts),
        variables=model.variables,
        states=model.states,
        laws=model.laws,
        structure=model.structure(),
        sources=source_names(version, fmu_facts),
        copyright=copyright_line(),
    )


def model_description(version: Version, part: str = CONTACT) -> bytes:
    """modelDescription.xml."""
    write = fmi2.model_description if version == 2 else fmi3.model_description
    return write(facts(version, part))


def file_name(version: Version, part: str = CONTACT) -> str:
    """Name of the archive."""
    return f"{fmu_facts_of(part).model_name}-fmi{version}.fmu"


def silent(line: str) -> None:
    """Nobody wants to hear of the progress."""


def build_fmu(
    version: Version,
    output: str | PathLike[str],
    targets: Iterable[str] | None = None,
    progress: Progress = silent,
    part: str = CONTACT,
) -> Path:
    """Build one FMU, for Co-Simulation and Model Exchange.

    Parameters
    ----------
    version : 2 or 3
        Of FMI.
    output : path
        The .fmu to write; it appears whole or not at all.
    targets : iterable of str, optional
        Platforms to compile for, by FMI 3 platform tuple, such as "x86_64-linux"; without it all five.
    progress : callable, optional
        Told what is being done, a line each.
    part : str
        The contact, "evat_contact", or one of its partners; `evat.fmu.parts()` lists them.

    Returns
    -------
    Path
        Of the FMU.

    Raises
    ------
    BuildError
        For a version or platform that there is none of.
    CompileError
        Where there is no C compiler (`pip install 'evat[build]'`).
    OutputError
        Where it cannot be written.

    Examples
    --------
    >>> import evat
    >>> evat.build_fmu(3, "EvatSpindle.fmu", ["x86_64-linux"], part="spindle").name
    'EvatSpindle.fmu'
    """
    return build_sharing(version, Path(output), targets, progress, part, {})


def build_sharing(
    version: Version,
    output: Path,
    targets: Iterable[str] | None,
    progress: Progress,
    part: str,
    binaries: dict[tuple[Version, str, str], bytes],
) -> Path:
    """build_fmu; `binaries` of a version, a platform and a model are compiled once for all FMUs that carry it."""
    if version not in (2, 3):
        raise BuildError(f"FMI version {version!r}: FMUs are built for version 2 or 3.")
    names = list(TARGETS) if targets is None else list(targets)
    if unknown := [name for name in names if name not in TARGETS]:
        raise BuildError(f"no such target: {', '.join(unknown)}; targets are {', '.join(TARGETS)}.")
    if not names:
        raise BuildError(f"an FMU without any binary was asked for; name a target, for example {host_target().fmi3_folder}.")
    usable(output.parent)
    compiler()  # before any of the work that comes first
    fmu_facts, model = fmu_facts_of(part), model_of(part)
    title = f"{fmu_facts.model_name}, FMI {version}"
    progress(f"{title}: variables, dependencies, documentation")
    tolerance = next((variable.start for variable in model.variables if variable.name == TOLERANCE), None)
    files = {
        "modelDescription.xml": model_description(version, part),
        **model.documentation(fmu_facts),
        **(terminal_files(fmu_facts, model.variables, model.icon()) if version == 3 else {}),
        **reference_files(fmu_facts, tolerance, model.follow),
        **credibility_files(fmu_facts.model_name, part, token_of(version, fmu_facts)),
        **source_files(version, fmu_facts),
    }
    with temporary() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:

        def compiled(name: str) -> bytes:
            key = (version, name, fmu_facts.model)
            if key not in binaries:
                binaries[key] = compile_binary(version, TARGETS[name], fmu_facts.model, folder / name)
            return binaries[key]

        try:
            for name, data in zip(names, pool.map(compiled, names), strict=True):
                progress(f"{title}: compiled for {name}")
                files[binary_name(version, TARGETS[name], fmu_facts)] = data
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            stop_compilers()
            raise
    progress(f"{title}: write {output.name}")
    return archive.write(files, output)


def build_all(folder: Path, targets: Iterable[str] | None = None, progress: Progress = silent) -> tuple[Path, ...]:
    """Build the FMUs of both versions into `folder`."""
    names = None if targets is None else list(targets)
    versions: tuple[Version, ...] = (2, 3)
    binaries: dict[tuple[Version, str, str], bytes] = {}
    return tuple(
        build_sharing(version, folder / file_name(version, part), names, progress, part, binaries)
        for part in parts()
        for version in versions
    )
