"""What does the command `evat` say in a folder, and how does it end? Run in this process: a new one takes a second to begin."""

from __future__ import annotations

import io
import subprocess
import warnings
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
from evat import console
from evat.commands.main import main


def evat(*arguments: str, folder: Path, columns: int = 80) -> subprocess.CompletedProcess[str]:
    """As a user of a terminal so many columns wide would see it."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True) for _ in range(2))
    status: object = 0
    with pytest.MonkeyPatch.context() as patched, warnings.catch_warnings(), redirect_stdout(out), redirect_stderr(err):
        patched.setattr("sys.argv", ["evat", *arguments])
        patched.setenv("COLUMNS", str(columns))
        for each in (console.out, console.err):  # which may have been made where the environment said another width
            patched.setattr(each, "_width", columns)
        patched.chdir(folder)
        try:
            main()
        except SystemExit as end:
            status = end.code or 0
    said, complained = (stream.buffer.getvalue().decode() for stream in (out, err))  # type: ignore[attr-defined]
    return subprocess.CompletedProcess(["evat", *arguments], status if isinstance(status, int) else 1, said, complained)


def typed(*words: str) -> tuple[int, str, str]:
    """Exit status, output and complaints of a command that reads no answers, here and at the width that is."""
    ended = evat(*words, folder=Path.cwd())
    return ended.returncode, ended.stdout, ended.stderr
