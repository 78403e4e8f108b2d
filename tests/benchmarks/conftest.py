"""What do all benchmarks share? The compiled loops, the FMUs, and one table at the end."""

from __future__ import annotations

import ctypes as ct
from pathlib import Path
from typing import Any

import pytest
from evat.native.compile import compile_library, host_target
from opened import OpenFmu, opened
from report import Row, Summary, as_text

ROWS = pytest.StashKey[list[Row]]()


@pytest.fixture(scope="session")
def summary(pytestconfig: pytest.Config) -> Summary:
    return Summary(pytestconfig.stash.setdefault(ROWS, []))


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    if rows := config.stash.get(ROWS, []):
        terminalreporter.write("\n" + as_text(rows))


@pytest.fixture(scope="session")
def loops(tmp_path_factory: pytest.TempPathFactory) -> ct.CDLL:
    """loops.c, compiled as the kernel is."""
    target = host_target()
    source = Path(__file__).resolve().with_name("loops.c")
    library = ct.CDLL(str(compile_library([source], tmp_path_factory.mktemp("loops") / f"loops{target.extension}", target)))
    for name in ("steps_2", "steps_3", "exchanges_2", "bare_steps"):
        getattr(library, name).restype = ct.c_double
    return library


@pytest.fixture(scope="session")
def fmi2(fmi2_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> OpenFmu:
    return opened(fmi2_fmu, tmp_path_factory.mktemp("fmi2"))


@pytest.fixture(scope="session")
def fmi3(fmi3_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> OpenFmu:
    return opened(fmi3_fmu, tmp_path_factory.mktemp("fmi3"))


@pytest.fixture(scope="session")
def twin(python_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> OpenFmu:
    return opened(python_fmu, tmp_path_factory.mktemp("twin"))
