"""Does the C touch memory that is not its own, or do what C leaves undefined? The tests of the doors once more, under sanitizers.

AddressSanitizer and UndefinedBehaviorSanitizer stop the process at the first finding and write a report. That they would is tried on a
copy with two faults planted.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest
from evat.files.writing import put
from evat.fmu import fmu_facts_of
from evat.fmu.sources import VARIANTS, variants_file
from evat.native.compile import (
    SANITIZE,
    CompileError,
    compile_library,
    fmi_headers,
    host_target,
    include_folders,
    sanitizer_runtime,
    shell_sources,
    source_root,
)
from sanitized import kernel_objects

HERE = Path(__file__).resolve().parent
TESTED = {
    "some": ("test_values", "test_life_cycle", "test_event_mode"),
    "others": ("test_fmu_state", "test_solver_side", "test_same_bits"),  # minutes, under sanitizers
}
# The library shows the kernel beside the FMI functions; and a step of 100 000 internal ones is slow under sanitizers.
LEFT_OUT = "not nothing_else and not ends_halfway"

UNDER_TEST = """
import sys
from pathlib import Path
import evat.native.kernel
import pytest
evat.native.kernel.kernel_library_path = lambda lanes=1, instructions=(): Path(sys.argv[1])
sys.exit(pytest.main(sys.argv[2:]))
"""
ONE_CALL = """
import sys
from pathlib import Path
from raw_fmi import Door, Instance
one = Instance(Door(Path(sys.argv[1]), Path(sys.argv[2])))
one.start() if sys.argv[3] == "start" else one.call("Reset")
"""
FAULTS = {
    "start": "    ((volatile char *)c)[block_size() + 5] = 1;\n",
    "reset": "    volatile int largest = 0x7fffffff; largest = largest + (c != NULL);\n",
}


@pytest.fixture(scope="module")
def preload() -> str:
    """What a program must load first; the C++ library too, or exceptions of Python's own extensions are a finding."""
    try:
        runtime = sanitizer_runtime()
    except CompileError as error:
        pytest.skip(str(error))
    answer = subprocess.run(["gcc", "-print-file-name=libstdc++.so.6"], capture_output=True, text=True, check=True)
    return f"{runtime} {Path(answer.stdout.strip()).resolve()}"


def objects(root: Path, folder: Path, sources: Iterable[Path]) -> dict[str, Path]:
    """These sources of `root` as objects, by their names."""
    include = [*include_folders(root), fmi_headers()]
    compile_library(sources, folder, host_target(), include=include, exports=["kernel.h"], link=False, sanitize=True)
    return {path.name: path for path in folder.glob("*.o")}


@pytest.fixture(scope="module")
def sound(preload: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Kernel and both shells as they are, compiled once: the copy with planted faults differs in one file."""
    assert preload
    root, folder = source_root(), tmp_path_factory.mktemp("sound")
    own = folder / VARIANTS
    put(own, variants_file([(2, fmu_facts_of()), (3, fmu_facts_of())]))
    shells = sorted({*shell_sources(root, 2), *shell_sources(root, 3)} - {root / VARIANTS})
    return {**kernel_objects(tmp_path_factory), **objects(root, folder / "objects", [*shells, own])}


def sanitized(parts: Mapping[str, Path], folder: Path, fmus: dict[str, Path]) -> Path:
    """The objects in one library, and FMUs around it; the library."""
    target = host_target()
    library = folder / f"all{target.extension}"
    subprocess.run(["gcc", *SANITIZE, "-shared", *map(str, parts.values()), "-o", str(library), "-lm"], check=True)
    for fmu in (fmus["fmi2"], fmus["fmi3"]):
        with zipfile.ZipFile(fmu) as plain, zipfile.ZipFile(folder / fmu.name, "w") as made:
            for name in plain.namelist():
                made.writestr(name, library.read_bytes() if name.endswith(target.extension) else plain.read(name))
    return library


def run(preload: str, folder: Path, script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A program over the FMUs in `folder`. Findings come on its error stream."""
    environment = os.environ | {
        "LD_PRELOAD": preload,
        "ASAN_OPTIONS": "detect_leaks=0",  # Python keeps memory to its end; growth has a test of its own
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "EVAT_TEST_FMUS": str(folder),
    }
    command = [sys.executable, "-c", script, *arguments]
    return subprocess.run(command, cwd=HERE, env=environment, capture_output=True, text=True, errors="replace", check=False)


@pytest.mark.parametrize("tested", ["some", pytest.param("others", marks=pytest.mark.campaign)])
def test_the_tests_of_the_doors_under_sanitizers(
    tested: str, preload: str, sound: dict[str, Path], fmus: dict[str, Path], tmp_path: Path
) -> None:
    library = sanitized(sound, tmp_path, fmus)
    files = [f"{name}.py" for name in TESTED[tested]]
    options = ["-q", "-x", "-p", "no:cacheprovider", "--capture=sys", "-k", LEFT_OUT, f"--basetemp={tmp_path / 'inner'}"]
    done = run(preload, tmp_path, UNDER_TEST, str(library), *options, *files)
    assert "AddressSanitizer" not in done.stderr, done.stderr[:5000]
    assert "runtime error" not in done.stderr, done.stderr[:5000]
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]


@pytest.fixture(scope="module")
def planted(sound: dict[str, Path], fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FMUs of a copy that writes behind its memory at the start and overflows an integer at a reset."""
    folder = tmp_path_factory.mktemp("planted")
    for name in ("kernel", "fmi", "fmus"):
        shutil.copytree(source_root() / name, folder / "copy" / name)
    component = folder / "copy" / "fmi" / "component.c"
    text = component.read_text()
    for function, fault in FAULTS.items():
        opening = f"enum Answer component_{function}(struct Component *c)\n{{\n"
        assert opening in text
        text = text.replace(opening, opening + fault)
    component.write_text(text)
    changed = objects(folder / "copy", folder / "objects", [component])
    assert set(changed) < set(sound)
    sanitized({**sound, **changed}, folder, fmus)
    return folder


@pytest.mark.parametrize(("function", "finding"), [("start", "heap-buffer-overflow"), ("reset", "signed integer overflow")])
def test_a_planted_fault_is_found(preload: str, planted: Path, fmus: dict[str, Path], function: str, finding: str) -> None:
    done = run(preload, planted, ONE_CALL, str(planted / fmus["fmi2"].name), str(planted), function)
    assert done.returncode != 0
    assert finding in done.stderr
    assert f"component_{function}" in done.stderr
