"""Is the page on how to add an effect true? Its code goes into a copy of the sources, is compiled, and passes what every effect must."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from evat.native import kernel
from evat.native.compile import PACKAGE, compile_library, host_target, source_root

CATALOGUE = Path(__file__).with_name("test_catalogue.py")
PAGE = (source_root() / "kernel" / "effects" / "README.md").read_text(encoding="utf-8")
(CODE,) = re.findall(r"```c\n(.*?)```", PAGE, re.DOTALL)
(CHANGE,) = re.findall(r"```diff\n(.*?)```", PAGE, re.DOTALL)
((PLACE, NAME),) = re.findall(r"`fmu_src/(kernel/effects/(\w+)\.c)`:\n", PAGE)


def copied(folder: Path, code: str) -> dict[str, str]:
    """A copy of package and kernel with the page's effect in it, compiled; the environment in which Python finds it first."""
    shutil.copytree(PACKAGE, folder / "evat", ignore=shutil.ignore_patterns("_lib", "_source", "__pycache__"))
    shutil.copytree(source_root() / "kernel", folder / "kernel")
    (folder / PLACE).write_text(code, encoding="utf-8")
    registry = folder / "kernel" / "registry.h"
    before = "".join(line[1:] for line in CHANGE.splitlines(keepends=True) if not line.startswith("+"))
    after = "".join(line[1:] for line in CHANGE.splitlines(keepends=True) if not line.startswith("-"))
    text = registry.read_text(encoding="utf-8")
    assert text.count(before) == 1, f"registry.h has no place for the page's line:\n{before}"
    registry.write_text(text.replace(before, after), encoding="utf-8")
    there = {**os.environ, "PYTHONPATH": str(folder)}
    done = python(there, "-m", "evat.native.compile")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(folder))
    return there


def python(environment: dict[str, str], *arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False)


def conformance(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    return python(environment, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rf", str(CATALOGUE), *arguments)


@pytest.fixture(scope="module")
def added(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return copied(tmp_path_factory.mktemp("added"), CODE)


def test_the_pages_effect_passes_the_conformance_test(added: dict[str, str]) -> None:
    done = conformance(added)
    assert done.returncode == 0, done.stdout[-3000:]
    found = conformance(added, "--collect-only", "-k", NAME)
    assert f"test_neutral_is_off_to_the_last_bit[{NAME}-internal]" in found.stdout


def test_the_command_line_knows_it_by_asking(added: dict[str, str], tmp_path: Path) -> None:
    done = python(added, "-c", "from evat.commands.main import main; main()", "effects", NAME, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "share |v|/(|v| + v_w)" in " ".join(done.stdout.split())
    assert (tmp_path / f"{NAME}.png").stat().st_size > 10_000


def test_it_weakens_friction_as_the_page_says(added: dict[str, str]) -> None:
    """Half of the share at v_w, nothing far below, all of it far above: Coulomb friction, so that nothing else knows the speed."""
    ask = f"""
from evat.kernel import Contact
start = Contact()
share, v_w = (start.get("{NAME}." + name) for name in ("share", "v_w"))
for times, lost in ((1e-3, 0), (1, share / 2), (1e3, share)):
    forces = []
    for on in ((), ("{NAME}",)):
        contact = Contact({{"kinematics": "external", "friction_law": "coulomb", "slip_velocity": times * v_w, "sigma2": 0.0}}, on)
        contact.start()
        contact.evaluate()
        forces.append(contact.get("friction_force"))
    print(abs(1 - forces[1] / forces[0] - lost) <= 1.01e-3 * share)
"""
    done = python(added, "-c", ask)
    assert done.stdout.split() == ["True"] * 3, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("right", "wrong", "test"),
    [
        (".neutral = 0, TUNED", ".neutral = 0.1, TUNED", "test_neutral_is_off_to_the_last_bit"),
        (".start = 0.3", ".start = 0", "test_the_table_tells_all"),
        ('"guess: order', '"', "test_the_table_tells_all"),
    ],
)
def test_the_conformance_test_sees_a_mistake(tmp_path: Path, right: str, wrong: str, test: str) -> None:
    code = CODE.replace(right, wrong) if right.startswith(".") else re.sub(rf"{right}[^\"]*", wrong, CODE)
    assert code != CODE
    done = conformance(copied(tmp_path, code), "-k", NAME)
    assert done.returncode == 1, done.stdout[-3000:]
    failed = set(re.findall(r"FAILED \S+::(\w+)", done.stdout))
    assert test in failed


def test_its_own_values_may_be_called_like_any_variable(tmp_path: Path) -> None:
    """The kernel's headers leave TIME, WIDTH, F_C, ... to the effects."""
    base = kernel.variables()[: kernel.library()[1].BASE_COUNT]
    names = ", ".join(variable.name.upper() for variable in base)
    assert {"TIME", "F_C"} <= set(names.split(", "))
    own = CODE.replace("enum { ON, SHARE, V_W, COUNT };", f"enum {{ ON, SHARE, V_W, COUNT }};\nenum {{ {names} }};")
    assert own != CODE
    (tmp_path / "own.c").write_text(own, encoding="utf-8")
    include = (source_root() / "kernel", source_root() / "kernel" / "effects")
    compile_library([tmp_path / "own.c"], tmp_path / "objects", host_target(), include=include, link=False)


def test_every_field_and_file_that_the_page_names_is_there() -> None:
    root = source_root() / "kernel"
    header = (root / "kernel.h").read_text(encoding="utf-8")
    point = header[header.index("struct Point {") :]
    point = re.sub(r"/\*.*?\*/", "", point[: point.index("\n};")], flags=re.DOTALL)
    fields = set(re.findall(r"\w+", point))
    rows = re.findall(r"^\| `(STAGE_\w+)` \|.*\| (.*) \|$", PAGE, re.MULTILINE)
    assert len(rows) == 7
    for stage, named in rows:
        assert stage in header
        assert set(re.findall(r"`(\w+)`", named)) <= fields, stage
    for name in re.findall(r"`(\w+\.c)`", PAGE):
        assert (root / "effects" / name).is_file(), name
    for stage in set(re.findall(r"STAGE_[A-Z]+", " ".join(path.read_text() for path in (root / "effects").glob("*.c")))):
        assert stage in {row[0] for row in rows}, stage
