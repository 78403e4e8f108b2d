"""May a file be read to its end? One that is no regular file, such as a device or a pipe, may have none."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path


def check_regular(path: Path) -> None:
    """OSError, as where the system refuses, where it is something else."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        raise OSError(
            errno.EINVAL, "it is no regular file, but a device, pipe or socket, which may have no end; copy it into a file", str(path)
        )
