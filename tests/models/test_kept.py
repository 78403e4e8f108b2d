"""Is what is kept from one run to the next checked before it is used, and made anew where it is damaged? Libraries and the FMU."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
from evat import fmu
from evat.files.writing import OutputError
from evat.fmu import host
from evat.native import compile as compile_c
from evat.native.compile import is_whole, kernel_library_path, machine_library_path, seal, seal_of, source_root

PACKAGE = compile_c.PACKAGE
ASK = "from evat.native import kernel; kernel.Contact().start(); print(kernel.token())"
PART = "spindle"  # compiled in a tenth of the time of the kernel, and loaded by the same door
ASK_PART = f"from evat.native.machine import Machine; Machine('{PART}').evaluate(); print('evaluated')"


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package with sources and libraries in a folder of its own."""
    folder = tmp_path_factory.mktemp("copied")
    shutil.copytree(PACKAGE, folder / "evat", ignore=shutil.ignore_patterns("__pycache__", "_source"))
    for name in ("kernel", "machines", "fmi", "fmus"):
        shutil.copytree(source_root() / name, folder / name)
    return folder


def asked(folder: Path, code: str = ASK, **environment: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True, text=True, timeout=300, check=False, cwd=folder, env={**os.environ, "PYTHONPATH": path, **environment},
    )  # fmt: skip


def damaged(library: Path, damage: str) -> None:
    """Half of a library, once loaded, ends the process with a bus error; an empty one was a traceback; a bit is another model."""
    whole = library.read_bytes()
    if damage == "nothing says that it is whole":
        seal_of(library).unlink()
        return
    bit = bytearray(whole)
    bit[len(bit) // 2] ^= 1
    library.unlink()  # it may be loaded
    library.write_bytes({"empty": b"", "torn": whole[: len(whole) // 2], "a bit": bytes(bit)}[damage])


@pytest.mark.parametrize("damage", ["empty", "torn", "a bit", "nothing says that it is whole"])
def test_a_damaged_library_is_seen_to_be(damage: str, tmp_path: Path) -> None:
    library = tmp_path / kernel_library_path().name
    for path in (kernel_library_path(), seal_of(kernel_library_path())):
        shutil.copy(path, tmp_path)
    assert is_whole(library)
    damaged(library, damage)
    assert not is_whole(library)


def test_a_damaged_library_is_compiled_anew(copied: Path) -> None:
    library = copied / "evat" / "_lib" / machine_library_path(PART).name
    whole = library.read_bytes()
    damaged(library, "torn")
    done = asked(copied, ASK_PART)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "evaluated"
    assert f"{library}: the compiled library is damaged" in done.stderr
    assert library.read_bytes() == whole
    assert is_whole(library)
    assert asked(copied, ASK_PART).stderr == ""


def test_a_library_of_other_sources_is_compiled_anew(copied: Path) -> None:
    """Its tables are not laid out as the headers say, and reading them ended the process: what a checkout of another commit leaves."""
    header = copied / "kernel" / "tables.h"
    ours = header.read_text(encoding="utf-8")
    first = "struct Variable {\n"
    assert first in ours
    header.write_text(ours.replace(first, f"{first}    double one_more;\n"), encoding="utf-8")
    library = copied / "evat" / "_lib" / machine_library_path(PART).name
    kept = library.read_bytes(), seal_of(library).read_bytes()
    assert is_whole(library)
    done = asked(copied, ASK_PART)
    library.unlink()  # it may be loaded
    library.write_bytes(kept[0])
    seal_of(library).write_bytes(kept[1])
    header.write_text(ours, encoding="utf-8")
    assert done.returncode == 0, (done.returncode, done.stderr)
    assert f"{library}: the compiled library was compiled from other sources; it is compiled anew" in done.stderr
    assert done.stdout.strip() == "evaluated"


def test_a_damaged_library_that_cannot_be_compiled_says_what_to_do(copied: Path, tmp_path: Path) -> None:
    library = copied / "evat" / "_lib" / kernel_library_path().name
    kept = library.read_bytes(), seal_of(library).read_bytes()
    library.unlink()
    library.write_bytes(kept[0][:1000])
    no_compiler = "import importlib.util as u; f = u.find_spec; u.find_spec = lambda name, *a: None if name == 'ziglang' else f(name, *a)\n"
    done = asked(copied, f"{no_compiler}import sys; sys.argv = ['evat', 'info']\nfrom evat.commands.main import main; main()")
    library.write_bytes(kept[0])
    seal_of(library).write_bytes(kept[1])
    assert done.returncode != 0
    assert "the compiled library is damaged and cannot be compiled anew: no C compiler: the package ziglang is not installed" in done.stderr
    assert "Install evat again." in done.stderr


def test_a_library_that_the_system_does_not_load_says_so(copied: Path) -> None:
    """Whole, and yet no library of this machine."""
    library = copied / "evat" / "_lib" / kernel_library_path().name
    kept = library.read_bytes(), seal_of(library).read_bytes()
    library.unlink()
    library.write_bytes(b"no library")
    seal(library, kept[1].decode().splitlines()[0])
    done = asked(copied)
    library.write_bytes(kept[0])
    seal_of(library).write_bytes(kept[1])
    assert f"EvatError: {library}: the compiled library cannot be loaded here" in done.stderr


@pytest.fixture
def cache(fmi2_fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """A place of its own for the user's caches, and the FMUs that are built into it, in their order."""
    built = list[Path]()

    def build(version: int, path: Path, targets: list[str], progress: object, part: str, binaries: object) -> Path:
        built.append(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(fmi2_fmu.read_bytes())
        return path

    monkeypatch.setattr(host, "user_cache_path", lambda *_, **__: tmp_path / "cache")
    monkeypatch.setattr(fmu, "build_sharing", build)
    return built


def _with_half_a_binary(data: bytes) -> bytes:
    """An archive that is whole, with a library in it that is not."""
    changed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, content[: len(content) // 2] if name.startswith("binaries/") else content)
    return changed.getvalue()


def test_an_fmu_is_built_once_and_again_when_what_it_is_made_from_changes(cache: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    assert host.host_fmu() == host.host_fmu() == cache[0]
    assert len(cache) == 1
    assert host.host_fmu(3, "spindle") == cache[1]
    assert cache[1].name == "EvatSpindle-fmi3.fmu"
    monkeypatch.setattr(host, "made_from", lambda: "another state")
    assert host.host_fmu() == cache[2] != cache[0]


def test_a_model_is_compiled_once_for_all_fmus_that_carry_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = list[tuple[int, str]]()

    def library(version: int, target: object, model: str, folder: Path) -> bytes:
        compiled.append((version, model))
        return b"a library"

    monkeypatch.setattr(host, "user_cache_path", lambda *_, **__: tmp_path / "cache")
    monkeypatch.setattr(host, "BROUGHT", tmp_path / "none")
    monkeypatch.setattr(fmu, "parts", lambda: ("evat_slip", "evat_guideway", "spindle"))
    monkeypatch.setattr(fmu, "compile_binary", library)
    assert len(host.build_all(tmp_path / "out")) == 6
    assert sorted(compiled) == [(version, model) for version in (2, 3) for model in ("evat_contact", "spindle")]


def test_fmus_for_all_platforms_are_built_once(cache: list[Path], fmi2_fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Into whatever folder; again where the sources or the day they carry change, where what is kept is damaged, or cannot be kept."""
    monkeypatch.setattr(fmu, "parts", lambda: ("evat_contact", "spindle"))

    def builds(folder: str) -> int:
        before = len(cache)
        written = host.build_for_all(tmp_path / folder)
        assert [path.read_bytes() == fmi2_fmu.read_bytes() for path in written] == [True] * 4
        return len(cache) - before

    assert [builds("a"), builds("a"), builds("b")] == [4, 0, 0]
    kept = host._kept(2, "spindle", tuple(compile_c.TARGETS))
    assert kept != host._kept(2, "spindle")
    kept.write_bytes(b"half")
    assert [builds("b"), builds("b")] == [1, 0]
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    assert [builds("b"), builds("b")] == [4, 0]
    monkeypatch.setattr(host, "made_from", lambda: "another state")
    assert builds("b") == 4
    (tmp_path / "no folder").write_text("", encoding="ascii")
    monkeypatch.setattr(host, "user_cache_path", lambda *_, **__: tmp_path / "no folder" / "cache")
    assert [builds("b"), builds("b")] == [4, 4]


def test_what_nobody_has_used_for_a_month_is_cleared_away(cache: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """When another is built; what is no FMU's place stays, and to use one is to keep it."""
    first = host.host_fmu().parent
    beside = {name: tmp_path / "cache" / name for name in ("0123456789abcdef0123", "fedcba98765432100123", "guide-0.1")}
    for days, place in zip((31, 29, 31), beside.values(), strict=True):
        place.mkdir()
        os.utime(place, (then := time.time() - days * 86400, then))
    os.utime(first, (0, 0))
    assert host.host_fmu().parent == first
    monkeypatch.setattr(host, "made_from", lambda: "another state")
    second = host.host_fmu().parent
    assert {*(tmp_path / "cache").iterdir()} == {first, second, *list(beside.values())[1:]}


def test_the_fmu_that_a_wheel_brought_is_taken_while_it_is_of_these_sources(
    cache: list[Path], fmi2_fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host, "BROUGHT", tmp_path / "brought")
    brought = tmp_path / "brought" / fmi2_fmu.name
    brought.parent.mkdir()
    brought.write_bytes(fmi2_fmu.read_bytes())
    assert host.host_fmu() == cache[0]  # nothing says that it is whole
    seal(brought, host.made_from())
    assert host.host_fmu() == brought
    seal(brought, "of other sources")
    assert host.host_fmu() == cache[0]
    assert len(cache) == 1


def test_all_that_building_an_fmu_loads_counts_as_what_it_is_made_from() -> None:
    code = "import sys, evat.fmu.host; print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('evat.') and m.__file__))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    rooms = {Path(path).relative_to(PACKAGE).parts[0] for path in loaded if len(Path(path).relative_to(PACKAGE).parts) > 1}
    assert rooms <= set(host.ROOMS)


@pytest.mark.parametrize("damage", ["empty", "torn", "half a binary", "a bit"])
def test_a_damaged_fmu_among_the_caches_is_built_anew(cache: list[Path], fmi2_fmu: Path, damage: str) -> None:
    path, whole = host.host_fmu(), fmi2_fmu.read_bytes()
    assert host.host_fmu() == path
    assert len(cache) == 1
    bit = bytearray(whole)
    bit[len(bit) // 2] ^= 1
    path.write_bytes({"empty": b"", "torn": whole[:20_000], "half a binary": _with_half_a_binary(whole), "a bit": bytes(bit)}[damage])
    assert host.host_fmu().read_bytes() == whole
    assert len(cache) == 2
    host.host_fmu()
    assert len(cache) == 2


def test_a_place_for_caches_that_is_none_is_no_end_of_a_diagnosis(
    cache: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The report then says why the FMU was not run."""
    from evat.commands.diagnose import _fmu

    monkeypatch.undo()
    (tmp_path / "file").write_text("no folder", encoding="utf-8")
    monkeypatch.setattr(host, "user_cache_path", lambda *_, **__: tmp_path / "file" / "cache")
    path, why = _fmu(None)
    assert path is None
    assert "cannot be written: Not a directory" in why


def test_a_seal_that_cannot_be_written_is_an_error_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "kept").write_bytes(b"x")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(compile_c.os, "replace", full)
    with pytest.raises(OutputError, match=r"kept.sha256: it cannot be written: No space left on device"):
        seal(tmp_path / "kept")
    assert not is_whole(tmp_path / "kept")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]
