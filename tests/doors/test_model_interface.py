"""Do the contact and its partners answer as one kind of model, and do the shells of FMI know nothing else of them?"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import pytest
from evat.native.compile import TARGETS, compile_library, fmi_headers, shell_sources, source_root
from test_kernel_rules import OF_OBJECT, Library, read_elf

ROOT = source_root()
# C99, 7.19 to 7.21 (bcmp: what compilers make of memcmp); calloc and free serve an instance whose host brings none.
LIBRARY = "calloc free memcpy memmove memset memcmp bcmp strcmp strlen strcpy strspn strchr snprintf vsnprintf"


def declared(header: str) -> set[str]:
    """Functions that a header declares."""
    text = re.sub(r"/\*.*?\*/", "", (ROOT / header).read_text(encoding="utf-8"), flags=re.DOTALL)
    return set(re.findall(r"\b(\w+)\([^()]*(?:\([^()]*\)[^()]*)*\);", text))


INTERFACE, SHARED = declared("fmi/model.h"), declared("kernel/shared.h")


def objects(sources: Sequence[Path], folder: Path) -> list[Library]:
    compile_library(sources, folder, TARGETS["x86_64-linux"], include=[fmi_headers()], link=False)
    return [read_elf(path, OF_OBJECT) for path in folder.glob("*.o")]


@pytest.mark.parametrize("source", ["kernel/model.c", "machines/machine.c"])
def test_a_model_implements_the_whole_interface(source: str, tmp_path: Path) -> None:
    (model,) = objects([ROOT / source], tmp_path / "objects")
    assert len(INTERFACE) > 30
    assert model.shown >= INTERFACE
    assert {name for name in model.shown if name.startswith("model_")} <= INTERFACE


@pytest.mark.parametrize("version", [2, 3])
def test_the_shells_call_the_interface_and_what_all_models_share(version: int, tmp_path: Path) -> None:
    shells = objects(shell_sources(ROOT, version), tmp_path / "objects")
    own = frozenset[str]().union(*(one.shown for one in shells))
    needed = frozenset[str]().union(*(one.needed for one in shells)) - own - {"_GLOBAL_OFFSET_TABLE_"}
    assert {"model_step_wired", "model_get", "hash_bytes"} <= needed
    assert needed <= {*INTERFACE, *SHARED, *LIBRARY.split()}


def test_the_shells_include_no_model_of_their_own() -> None:
    included = {name for path in (ROOT / "fmi").glob("*.[ch]") for name in re.findall(r'#include "(.*)"', path.read_text(encoding="utf-8"))}
    assert included == {"component.h", "model.h", "../kernel/shared.h", "fmi2Functions.h", "fmi3Functions.h"}
