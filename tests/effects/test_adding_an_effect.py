"""Is the page on how to add an effect true? Its code goes into a copy of the sources, is compiled, and passes what every effect must."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from added import EFFECT as PAGE
from added import LAW, MISTAKES, Page, copied, evat, python
from evat.native import kernel
from evat.native.compile import compile_library, host_target, source_root

CATALOGUE = Path(__file__).with_name("test_catalogue.py")
NAME = PAGE.name


def conformance(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    return python(environment, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rf", str(CATALOGUE), *arguments)


@pytest.fixture(scope="module")
def added(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return copied(tmp_path_factory)


def test_the_pages_effect_passes_the_conformance_test(added: dict[str, str]) -> None:
    done = conformance(added, "-rp", "-k", NAME)
    assert done.returncode == 0, done.stdout[-3000:]
    assert f"::test_neutral_is_off_to_the_last_bit[{NAME}-internal]\n" in done.stdout


def test_the_command_line_knows_it_by_asking(added: dict[str, str], tmp_path: Path) -> None:
    done = evat(added, "effects", NAME, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "share |v|/(|v| + v_w)" in " ".join(done.stdout.split())
    assert (tmp_path / f"{NAME}.png").stat().st_size > 10_000


def test_it_weakens_friction_as_the_page_says(added: dict[str, str]) -> None:
    """Half of the share at v_w, nothing far below, all of it far above: Coulomb friction, so that nothing else knows the speed."""
    ask = f"""
from evat.native.kernel import Contact
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


def test_the_conformance_test_sees_a_mistake(added: dict[str, str]) -> None:
    tests = "test_neutral_is_off_to_the_last_bit", "test_the_table_tells_all"
    done = conformance(added, "-k", f"({' or '.join(MISTAKES)}) and ({' or '.join(tests)}) and not external and not combined")
    assert done.returncode == 1, done.stdout[-3000:]
    failed = set(re.findall(r"FAILED \S+::(\w+)\[(\w+)", done.stdout))
    assert failed == set(zip((tests[0], tests[1], tests[1]), MISTAKES, strict=True))


def test_its_own_values_may_be_called_like_any_variable(tmp_path: Path) -> None:
    """The kernel's headers leave TIME, WIDTH, F_C, ... to the effects."""
    base = kernel.variables()[: kernel.library()[1].BASE_COUNT]
    names = ", ".join(variable.name.upper() for variable in base)
    assert {"TIME", "F_C"} <= set(names.split(", "))
    own = PAGE.code.replace("enum { ON, SHARE, V_W, COUNT };", f"enum {{ ON, SHARE, V_W, COUNT }};\nenum {{ {names} }};")
    assert own != PAGE.code
    (tmp_path / "own.c").write_text(own, encoding="utf-8")
    include = (source_root() / "kernel", source_root() / "kernel" / "effects")
    compile_library([tmp_path / "own.c"], tmp_path / "objects", host_target(), include=include, link=False)


@pytest.mark.parametrize("page", [PAGE, LAW], ids=["effect", "law"])
def test_the_code_of_the_page_is_as_the_formatter_wants_it(page: Page, tmp_path: Path) -> None:
    """Whoever follows it to the letter passes the checks."""
    (tmp_path / "own.c").write_text(page.code, encoding="utf-8")
    formatter = [str(Path(sys.executable).with_name("clang-format")), f"--style=file:{source_root() / '.clang-format'}"]
    done = subprocess.run([*formatter, "--dry-run", "--Werror", str(tmp_path / "own.c")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_field_and_file_that_the_page_names_is_there() -> None:
    root = source_root() / "kernel"
    header = (root / "kernel.h").read_text(encoding="utf-8")
    point = header[header.index("struct Point {") :]
    point = re.sub(r"/\*.*?\*/", "", point[: point.index("\n};")], flags=re.DOTALL)
    fields = set(re.findall(r"\w+", point))
    rows = re.findall(r"^\| `(STAGE_\w+)` \|.*\| (.*) \|$", PAGE.text, re.MULTILINE)
    stages = header[header.index("enum Stage {") : header.index("STAGE_COUNT")]
    assert [name for name, _ in rows] == re.findall(r"STAGE_\w+", stages)
    for stage, named in rows:
        assert stage in header
        assert set(re.findall(r"`(\w+)`", named)) <= fields, stage
    for name in re.findall(r"`([\w./]+\.[ch])`", PAGE.text):
        assert any((folder / name).is_file() for folder in (root, root / "effects", root.parent.parent)) or PAGE.name in name, name
    for stage in set(re.findall(r"STAGE_[A-Z]+", " ".join(path.read_text() for path in (root / "effects").glob("*.c")))):
        assert stage in {row[0] for row in rows}, stage
