"""How does output reach the disk? Made in a folder beside its place, moved there whole; never half, and nothing is left lying about.

A process that is killed cannot tidy up. So each such folder has a lock beside it that ends with its process, and the next run that writes
there clears away the folders of this machine whose lock is free. Those of other machines on a shared disk are left to them: whether a
lock reaches from one machine to another nobody knows.
"""

from __future__ import annotations

import errno
import os
import platform
import re
import secrets
import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from evat.model import EvatError

_HOST = re.sub(r"[^A-Za-z0-9]", "_", platform.node())[:40] or "nameless"
_OURS = f".evat-{_HOST}-"  # how our folders on this machine are named, and their locks, which end in _LOCK
_LOCK = ".lock"
_FULL = (errno.ENOSPC, errno.EDQUOT)
_cleared: set[str] = set()  # folders that this process has looked at already
_one_at_a_time = threading.Lock()


class OutputError(EvatError):
    """A file or folder that cannot be written.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=1, speeds=[0.5], rate=100.0)
    >>> _ = open("a-file", "w").close()
    >>> try:
    ...     evat.write_experiment(made, "a-file/rig")
    ... except evat.OutputError:
    ...     print("a file is no folder")
    a file is no folder
    """

    cause: OSError | None = None  # where the system said so


def cannot(place: Path | str, error: OSError | OutputError, what: str = "it") -> OutputError:
    """The error that says of `place` what the system said, and what to do."""
    cause = error.cause if isinstance(error, OutputError) else error
    if cause is None:
        return OutputError(f"{place}: {what} cannot be written: {error}")
    passing = any(part.startswith(_OURS) for part in Path(place).parts)  # only what nobody is to see is named from within such a folder
    todo = "name another temporary folder in TMPDIR" if passing else "name another place"
    todo = f"free some space there, or {todo}" if cause.errno in _FULL else todo
    failure = OutputError(f"{place}: {what} cannot be written: {cause.strerror or cause}. {todo[0].upper()}{todo[1:]}.")
    failure.cause = cause
    return failure


@contextmanager
def as_output_error(place: Path | str, what: str = "it") -> Iterator[None]:
    """Says of `place` that it cannot be written, whatever the system refuses within the block."""
    try:
        yield
    except (OSError, OutputError) as error:
        raise cannot(place, error, what) from error


@contextmanager
def scratch(beside: Path) -> Iterator[Path]:
    """A new folder inside the folder `beside`, which is made where it is missing; gone when the block ends."""
    with as_output_error(beside):
        try:
            beside.mkdir(parents=True, exist_ok=True)
        except FileExistsError as error:  # what pathlib says of a file that is no folder
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(beside)) from error
        _clear(beside)
        made = beside / f"{_OURS}{secrets.token_hex(6)}"
        lock = FileLock(f"{made}{_LOCK}", timeout=10, thread_local=False)
        try:
            Path(lock.lock_file).touch()  # where nothing can be made the lock would try again for all of its time
            _try(lock)
            made.mkdir()
        except BaseException:
            _forget(lock)
            raise
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)
        _forget(lock)


@contextmanager
def whole(path: Path, what: str = "it") -> Iterator[Path]:
    """A place to write a file to, which becomes `path` where the block ends well; OutputError, and `path` as it was, where it does not.

    A link is followed; what is neither file nor folder, such as a terminal or a pipe, is written to.
    """
    path, real = Path(path), os.path.realpath(path)
    special = os.path.exists(real) and not os.path.isfile(real) and not os.path.isdir(real)
    with as_output_error(path, what), temporary() if special else scratch(path.parent) as folder:
        made = folder / "made"  # whatever the name is: not every library takes one that is no text
        yield made
        if special:
            with made.open("rb") as source, path.open("wb") as target:
                shutil.copyfileobj(source, target)
        else:
            os.replace(made, real)


def put(path: Path, data: bytes | str, what: str = "it") -> Path:
    """Write a file whole, text as UTF-8."""
    with whole(path, what) as made:
        made.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


@contextmanager
def temporary() -> Iterator[Path]:
    """A folder among the temporary ones, gone when the block ends. TMPDIR says where they lie."""
    try:
        root = Path(tempfile.gettempdir())
    except OSError as error:
        raise OutputError(f"no temporary folder can be written ({error.strerror}); name one in TMPDIR.") from error
    with scratch(root) as folder:
        yield folder


def usable(folder: Path) -> None:
    """OutputError where nothing can be written into `folder`, which is made: asked before minutes of work."""
    with as_output_error(os.path.abspath(folder), "a file in it"), scratch(folder) as made:
        (made / "probe").write_bytes(b"\0")  # an empty one fits on a full disk


@contextmanager
def usable_while(folder: Path) -> Iterator[None]:
    """`usable` before the block; where that ends in an error, the folder is gone again if it was made for this and nothing is in it."""
    place = Path(os.path.abspath(folder))
    missing = [each for each in (place, *place.parents) if not each.exists()]
    usable(folder)
    try:
        yield
    except BaseException:
        for each in missing:
            with suppress(OSError):  # something is in it
                each.rmdir()
        raise


def _try(lock: FileLock) -> None:
    """Lock it where the disk knows locks; elsewhere the folder does as well, but is not cleared after a kill."""
    try:
        lock.acquire()
    except (OSError, Timeout, NotImplementedError):
        _forget(lock)  # one that is there and free would tell that nobody is alive


def _forget(lock: FileLock) -> None:
    with suppress(OSError):
        lock.release()
    with suppress(OSError):
        os.unlink(lock.lock_file)


def _clear(folder: Path) -> None:
    """Remove what processes of this machine that live no more have left in `folder`; looked for once in each process."""
    with _one_at_a_time:
        key = os.path.realpath(folder)
        if key in _cleared:
            return
        _cleared.add(key)
    with suppress(OSError), os.scandir(folder) as entries:
        abandoned = [entry.path for entry in entries if entry.name.startswith(_OURS) and entry.name.endswith(_LOCK) and _is_ours(entry)]
        for path in abandoned:
            lock = FileLock(path, thread_local=False)
            with suppress(OSError, Timeout, NotImplementedError):
                lock.acquire(blocking=False)
                left = path.removesuffix(_LOCK)
                shutil.rmtree(left, ignore_errors=True)
                if os.path.lexists(left):
                    lock.release()
                else:
                    _forget(lock)


def _is_ours(entry: os.DirEntry[str]) -> bool:
    """Whether it is a file of this user's: in a folder that all may write to, others could lay out anything."""
    return entry.is_file(follow_symlinks=False) and (not hasattr(os, "getuid") or entry.stat(follow_symlinks=False).st_uid == os.getuid())
