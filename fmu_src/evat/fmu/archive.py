"""How do files become an FMU archive? Sorted names, fixed times, deflate, forward slashes, written at once or not at all."""

from __future__ import annotations

import os
import time
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from evat.files.writing import whole
from evat.model import BuildError

_EARLIEST = 315532800  # 1980-01-01T00:00:00Z, the first moment that ZIP can write


def generation_time() -> int:
    """Seconds since 1970 that the files carry: SOURCE_DATE_EPOCH, or a fixed moment, so that same input gives same bytes."""
    text = os.environ.get("SOURCE_DATE_EPOCH", str(_EARLIEST))
    try:
        return max(int(text), _EARLIEST)
    except ValueError:
        raise BuildError(f"SOURCE_DATE_EPOCH = {text!r}: a whole number of seconds since 1970 is needed; correct or unset it.") from None


def _check(name: str) -> None:
    path = PurePosixPath(name)
    if not name or path.is_absolute() or ".." in path.parts or "\\" in name or ":" in name or str(path) != name:
        raise BuildError(f"{name!r} is not a path inside an archive; use a relative path with forward slashes.")


def write(files: Mapping[str, bytes], output: Path) -> Path:
    """Write `files` (path inside the archive -> content) to `output`, in one step as seen from outside."""
    moment = time.gmtime(generation_time())[:6]
    for name in files:
        _check(name)
    with whole(output) as made, zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, moment)
            entry.create_system = 3  # of Unix on every machine
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, files[name], zipfile.ZIP_DEFLATED, 9)
    return output
