"""How does the code of the pages on adding a law and an effect get into a copy of the sources? For the tests of these pages."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from evat.native.compile import PACKAGE, source_root
from filelock import FileLock

# The two libraries that this machine loads, one contact at a time and many; and no other.
COMPILE = """
from evat.native import compile as compiling
from evat.native.processor import instructions
wide = next(fit for fit in compiling._processors(compiling.MANY_LANES) if fit.needs <= set(instructions()))
for lanes, processor in ((1, compiling.BASELINE), (compiling.MANY_LANES, wide)):
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


LAW, EFFECT = page("friction"), page("effects")
# What is wrong with copies of the page's effect that stand beside it, by their names: a pattern in its code, and what stands there.
MISTAKES = {
    "not_neutral": (r"\.neutral = 0, TUNED", ".neutral = 0.1, TUNED"),
    "never_on": (r"\.start = 0\.3", ".start = 0"),
    "without_source": (r'"guess: order[^"]*', '"'),
}


def copied(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A copy of package and kernel with the page's law, its effect and the mistaken ones, compiled once for all workers; the environment
    in which Python finds it first."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder, there = base / "added", {**os.environ, "PYTHONPATH": str(base / "added")}
    with FileLock(base / "added.lock"):
        if not folder.is_dir():
            _copy(folder)
            done = python(there, "-c", COMPILE)
            assert done.returncode == 0, done.stderr
            assert done.stdout.startswith(str(folder))
    return there


def _copy(folder: Path) -> None:
    shutil.copytree(PACKAGE, folder / "evat", ignore=shutil.ignore_patterns("_lib", "_source", "__pycache__"))
    for part in ("kernel", "fmi", "fmus"):
        shutil.copytree(source_root() / part, folder / part)
    compiling = folder / "evat" / "native" / "compile.py"
    optimised = compiling.read_text(encoding="utf-8")
    assert optimised.count('RELEASE = ("-O2"') == 1
    compiling.write_text(optimised.replace('RELEASE = ("-O2"', 'RELEASE = ("-O1"'), encoding="utf-8")  # in two thirds of the time
    registry = folder / "kernel" / "registry.h"
    text = re.sub(r" +\\$", r" \\", registry.read_text(encoding="utf-8"), flags=re.MULTILINE)  # the pages do not align them
    for added in (LAW, EFFECT):
        (folder / added.place).write_text(added.code, encoding="utf-8")
        before = "".join(line[1:] for line in added.change.splitlines(keepends=True) if not line.startswith("+"))
        after = "".join(line[1:] for line in added.change.splitlines(keepends=True) if not line.startswith("-"))
        assert text.count(before) == 1, f"registry.h has no place for the page's line:\n{before}"
        text = text.replace(before, after)
    own = f"    LINE({EFFECT.name}) \\\n"
    assert text.count(own) == 1
    for name, (right, wrong) in MISTAKES.items():
        code, count = re.subn(right, wrong, EFFECT.code.replace(EFFECT.name, name))
        assert count == 1
        (folder / EFFECT.place).with_stem(name).write_text(code, encoding="utf-8")
        text = text.replace(own, f"{own}    LINE({name}) \\\n")
    registry.write_text(text, encoding="utf-8")


def python(environment: dict[str, str], *arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Python with the copy, in `folder`."""
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False)


def evat(environment: dict[str, str], *arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """The copy's command line, in `folder`."""
    return python(environment, "-c", "from evat.commands.main import main; main()", *arguments, folder=folder)
