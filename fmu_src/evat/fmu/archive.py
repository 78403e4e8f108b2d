"""How do files become an FMU archive? Sorted names, fixed times, deflate, forward slashes, written at once or not at all."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from datetime import datetime, timezone
from pathlib import Path, PurePosixPath

from evat.files.writing import whole
from evat.model import BuildError

RELEASED = "2026-11-22"  # the day of this version
_EARLIEST = 315532800  # 1980-01-01T00:00:00Z, the first moment that ZIP can write
_LATEST = 4354819198  # 2107-12-31T23:59:58Z, the last one


def generated() -> datetime:
    """The moment in UTC that the files carry: SOURCE_DATE_EPOCH, or the day of this version, so that same input gives same bytes."""
    text = os.environ.get("SOURCE_DATE_EPOCH")
    if text is None:
        return datetime.fromisoformat(RELEASED).replace(tzinfo=timezone.utc)
    try:
        return datetime.fromtimestamp(min(max(int(text), _EARLIEST), _LATEST), timezone.utc)
    except ValueError:
        raise BuildError(f"SOURCE_DATE_EPOCH = {text!r}: a whole number of seconds since 1970 is needed; correct or unset it.") from None


def stamp() -> str:
    """The same as XML has it, xs:dateTime."""
    return generated().strftime("%Y-%m-%dT%H:%M:%SZ")


def _check(name: str) -> None:
    path = PurePosixPath(name)
    if not name or path.is_absolute() or ".." in path.parts or "\\" in name or ":" in name or str(path) != name:
        raise BuildError(f"{name!r} is not a path inside an archive; use a relative path with forward slashes.")


def write(files: Mapping[str, bytes], output: Path) -> Path:
    """Write `files` (path inside the archive -> content) to `output`, in one step as seen from outside."""
    moment = generated().timetuple()[:6]
    for name in files:
        _check(name)
    with whole(output) as made, zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, moment)
            entry.create_system = 3  # of Unix on every machine
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, files[name], zipfile.ZIP_DEFLATED, 9)
    return output
