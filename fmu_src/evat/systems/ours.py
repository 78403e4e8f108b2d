"""Which .ssp is meant? A file; or one of our systems by its name, made of the FMUs for this machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

from evat.files.writing import temporary
from evat.fmu.host import host_fmu
from evat.model import nearest
from evat.systems.declared import load, names
from evat.systems.model import SspError
from evat.systems.ssp.write import Progress, write


@contextmanager
def archive_of(ssp: str | PathLike[str], progress: Progress = lambda _: None) -> Iterator[Path]:
    """The file, or for as long as it is asked for that of the system of this name; `progress` is told which FMUs are built for it.

    Raises
    ------
    SspError where there is neither; CompileError where an FMU has to be built, and there is no C compiler.
    """
    path, name = Path(ssp), str(ssp)
    if path.is_file():
        yield path
    elif name in names():
        fmus = {part.part: host_fmu(2, part.part, progress) for part in load(name).parts.values()}
        with temporary() as folder:
            yield write(name, folder / f"{name}.ssp", fmus)
    else:
        raise SspError(f"{path}: there is no such file, and none of our systems is called so; {nearest(name, names())}")
