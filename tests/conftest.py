"""Which FMUs do the tests drive? Those of this machine's platform, built once from the sources as they stand and kept for the next run.

With EVAT_TEST_FMUS=FOLDER in the environment they drive the FMUs in that folder instead, and build none.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import signal
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from evat import fmu
from evat.fmu.python_fmu import MODEL_NAME, build_python_fmu
from evat.native import compile as compiling
from evat.native.compile import PACKAGE, host_target, is_whole, kernel_library_path, seal, source_root
from evat.systems.ssp.write import write_all

# What a shell starts in the background ignores SIGINT, and so would every program that a test stops by it.
signal.signal(signal.SIGINT, signal.default_int_handler)


GIVEN = os.environ.get("EVAT_TEST_FMUS")
FOLDER = Path(GIVEN) if GIVEN else Path(__file__).resolve().parent.parent / "build" / "out" / "test-fmus"
MADE_FROM = (".c", ".h", ".toml", ".py", ".j2")


def _fingerprint() -> str:
    """Changes with anything that an FMU is made from; the compiled kernel is asked for the tables, so it counts too."""
    digest = hashlib.sha256(kernel_library_path().read_bytes())
    folders = {PACKAGE, *(source_root() / name for name in ("kernel", "machines", "fmi", "fmus"))}
    for path in sorted(path for folder in folders for path in folder.rglob("*") if path.suffix in MADE_FROM):
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    for package in ("evat", "fmpy", "pythonfmu", "ziglang"):
        digest.update(importlib.metadata.version(package).encode())
    return digest.hexdigest()


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One process at a time. SQLite's lock works on every platform, and ends with a process that is killed."""
    with closing(sqlite3.connect(folder / "lock.sqlite", timeout=600, isolation_level=None)) as lock:
        lock.execute("BEGIN EXCLUSIVE")
        yield


@pytest.fixture(scope="session")
def fmus() -> dict[str, Path]:
    """All FMUs by a short name."""
    paths = {"fmi2": FOLDER / fmu.file_name(2), "fmi3": FOLDER / fmu.file_name(3), "python": FOLDER / f"{MODEL_NAME}.fmu"}
    paths |= {f"{part}-fmi{version}": FOLDER / fmu.file_name(version, part) for part in fmu.parts()[1:] for version in (2, 3)}  # type: ignore[arg-type]
    if GIVEN:
        return paths
    FOLDER.mkdir(parents=True, exist_ok=True)
    with _alone(FOLDER):
        state = _fingerprint()
        if not all(is_whole(path, state) for path in paths.values()):
            fmu.build_all(FOLDER, [host_target().fmi3_folder])
            build_python_fmu(paths["python"])
            for path in paths.values():
                seal(path, state)
    return paths


@pytest.fixture
def unoptimised(monkeypatch: pytest.MonkeyPatch) -> None:
    """C is compiled in a third of the time: where it matters what is compiled, and not into what."""
    monkeypatch.setattr(compiling, "RELEASE", ("-O0", *compiling.RELEASE[1:]))


@pytest.fixture(scope="session")
def fmi2_fmu(fmus: dict[str, Path]) -> Path:
    return fmus["fmi2"]


@pytest.fixture(scope="session")
def fmi3_fmu(fmus: dict[str, Path]) -> Path:
    return fmus["fmi3"]


@pytest.fixture(scope="session")
def python_fmu(fmus: dict[str, Path]) -> Path:
    return fmus["python"]


@pytest.fixture(scope="session")
def systems(fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Our systems by name, made of these FMUs."""
    folder = tmp_path_factory.mktemp("systems")
    return {path.stem: path for path in write_all(folder, fmus["fmi2"].parent)}


@pytest.fixture(autouse=True)
def _same_working_directory() -> Iterator[None]:
    """A test that leaves the process elsewhere breaks those that follow: it fails itself, and they go on."""
    before = Path.cwd()
    yield
    try:
        now: Path | None = Path.cwd()
    except FileNotFoundError:  # it is gone
        now = None
    os.chdir(before)
    assert now == before
