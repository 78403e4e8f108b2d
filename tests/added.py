"""How does the code of a page on adding something get into a copy of the sources? For the tests of these pages."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from evat.native.compile import PACKAGE, source_root

# The two libraries that this machine loads, one contact at a time and many, or the first alone; and no other.
COMPILE = """
import sys
from evat.native import compile as compiling
from evat.native.processor import instructions
wide = next(fit for fit in compiling._processors(compiling.MANY_LANES) if fit.needs <= set(instructions()))
for lanes, processor in ((1, compiling.BASELINE), (compiling.MANY_LANES, wide))[:int(sys.argv[1])]:
    print(compiling.build_kernel_library(compiling.PACKAGE / "_lib", lanes, processor))
"""


@dataclass(frozen=True)
class Page:
    """A page on adding something to the kernel: `code` of the file `place`, called `name`, and the line in the registry as a diff."""

    text: str
    code: str
    change: str
    place: str
    name: str


def page(folder: str) -> Page:
    """The page of the kernel's folder of that name."""
    text = (source_root() / "kernel" / folder / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```c\n(.*?)```", text, re.DOTALL)
    (change,) = re.findall(r"```diff\n(.*?)```", text, re.DOTALL)
    ((place, name),) = re.findall(rf"`fmu_src/(kernel/{folder}/(\w+)\.c)`:\n", text)
    return Page(text, code, change, place, name)


def copied(folder: Path, added: Page, code: str, *, batches: bool = True) -> dict[str, str]:
    """A copy of package and kernel with `code` in the page's place, compiled; the environment in which Python finds it first. Without
    `batches` it runs one contact at a time only, and is compiled in half of the time."""
    shutil.copytree(PACKAGE, folder / "evat", ignore=shutil.ignore_patterns("_lib", "_source", "__pycache__"))
    for part in ("kernel", "fmi", "fmus"):
        shutil.copytree(source_root() / part, folder / part)
    (folder / added.place).write_text(code, encoding="utf-8")
    compiling = folder / "evat" / "native" / "compile.py"
    optimised = compiling.read_text(encoding="utf-8")
    assert optimised.count('RELEASE = ("-O2"') == 1
    compiling.write_text(optimised.replace('RELEASE = ("-O2"', 'RELEASE = ("-O0"'), encoding="utf-8")  # compiled in a third of the time
    registry = folder / "kernel" / "registry.h"
    before = "".join(line[1:] for line in added.change.splitlines(keepends=True) if not line.startswith("+"))
    after = "".join(line[1:] for line in added.change.splitlines(keepends=True) if not line.startswith("-"))
    text = re.sub(r" +\\$", r" \\", registry.read_text(encoding="utf-8"), flags=re.MULTILINE)  # the page does not align them
    assert text.count(before) == 1, f"registry.h has no place for the page's line:\n{before}"
    registry.write_text(text.replace(before, after), encoding="utf-8")
    there = {**os.environ, "PYTHONPATH": str(folder)}
    done = python(there, "-c", COMPILE, "2" if batches else "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(folder))
    return there


def python(environment: dict[str, str], *arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Python with the copy, in `folder`."""
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False)


def evat(environment: dict[str, str], *arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """The copy's command line, in `folder`."""
    return python(environment, "-c", "from evat.commands.main import main; main()", *arguments, folder=folder)
