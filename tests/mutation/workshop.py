"""How is a mistake made, built and looked for? In a copy of the project, one at a time, with the tests that find most soonest.

C is compiled with the project's own flags; of the kernel, object by object, so that a mistake costs the compilation of one file and a link.
A mistake that leaves the machine code as it was is none.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import tomlkit
from evat.fmu import fmu_facts_of
from evat.fmu.sources import VARIANTS, variants_file
from evat.native import compile as compiling
from evat.native.compile import (
    CONTACT,
    MANY_LANES,
    CompileError,
    Processor,
    build_machine_library,
    compile_library,
    fmi_headers,
    host_target,
    include_folders,
    machine_names,
    model_sources,
    shell_sources,
)
from evat.native.processor import instructions
from mistakes import Mistake, in_c, in_python, places_in_python

ROOT = Path(__file__).resolve().parents[2]
KNOWN = Path(__file__).with_name("known.toml")
SOURCES = "fmu_src"
TOLD = ("-Wno-error",)  # what a mistake leaves unused is no mistake of its own


@dataclass(frozen=True)
class Part:
    """Files that are built alike, and the tests that look at them."""

    files: tuple[str, ...]  # patterns, from the source root
    tests: tuple[str, ...]
    quick: float  # [s]; tests that take longer come after all others


PARTS = {
    "kernel": Part(
        ("kernel/**/*.c", "kernel/elementary.h", "kernel/solver/root.h"),
        (
            "tests/laws",
            "tests/effects",
            "tests/doors/test_reference.py",
            "tests/doors/test_lanes.py",
            "tests/models/test_batch.py",
            "tests/tolerance/test_causes.py",
            "tests/tolerance/test_causes_of_feedback.py",
            "tests/tolerance/test_causes_within_steps.py",
        ),
        2.0,
    ),
    "machines": Part(
        ("machines/*.c", "machines/parts/*.c"),
        (
            "tests/systems/test_machines.py",
            "tests/systems/test_machine_derivatives.py",
            "tests/systems/test_tool_heat.py",
            "tests/systems/test_tool_structure.py",
        ),
        9.0,
    ),
    "shells": Part(
        ("fmi/*.c", "kernel/model.c"),
        (
            "tests/doors/test_life_cycle.py",
            "tests/doors/test_values.py",
            "tests/doors/test_fmu_state.py",
            "tests/doors/test_event_mode.py",
            "tests/doors/test_cs_and_me.py",
            "tests/doors/test_averaging_doors.py",
            "tests/doors/test_solver_side.py",
            "tests/doors/test_output_derivatives.py",
            "tests/doors/test_finite.py",
        ),
        3.0,
    ),
    "python": Part(  # the quick ones; whole fits take minutes
        ("evat/identification/**/*.py", "evat/inference/**/*.py", "evat/gap/*.py", "evat/gap/search/*.py", "evat/gap/verdict/*.py"),
        (
            "tests/gap/test_toy_model.py",
            "tests/gap/test_jumps.py",
            "tests/gap/test_irregular.py",
            "tests/gap/test_location.py",
            "tests/gap/test_discrepancy.py",
            "tests/gap/test_outliers.py",
            "tests/gap/test_advise.py",
            "tests/gap/test_credibility.py",
            "tests/gap/test_doubts.py",
            "tests/gap/test_gates.py",
            "tests/gap/test_small.py",
            "tests/gap/test_starts.py",
            "tests/identify/test_bad_input.py",
            "tests/identify/test_valleys.py",
            "tests/identify/test_candidates.py",
            "tests/identify/test_noise_and_journal.py",
            "tests/identify/test_advice.py",
            "tests/identify/test_cluster.py",
            "tests/identify/test_objective.py",
            "tests/identify/test_search.py",
            "tests/identify/test_wording.py",
            "tests/inference",
        ),
        8.0,
    ),
}
LEFT_OUT = (  # what compiles on its own, longer than a test may take
    "tests/effects/test_adding_an_effect.py",
    "tests/models/test_batch.py::test_every_library_gives_the_same_bits",
)


def files(part: str) -> list[Path]:
    """Of a part; what the shells alone see of the kernel is theirs."""
    some = (path for pattern in PARTS[part].files for path in (ROOT / SOURCES).glob(pattern))
    return sorted(path for path in some if (part != "kernel" or path.name != "model.c") and path.name != Path(VARIANTS).name)


def every_mistake(part: str) -> list[Mistake]:
    """All that can be made in a part of C."""
    return [mistake for file in files(part) for mistake in in_c(file, ROOT / SOURCES)]


def known(kind: str) -> dict[tuple[str, str, str], dict[str, str]]:
    """What is known of single mistakes: (file, line as it is, line with the mistake) -> all that is said. `kind`: equivalent or killed."""
    rows = tomlkit.parse(KNOWN.read_text(encoding="utf-8")).unwrap()[kind]
    return {(row["file"], row["was"], row["becomes"]): row for row in rows}


def drawn(part: str, count: int, seed: int) -> list[Mistake]:
    """So many of them that are not known to be none, each file in proportion to what there is to go wrong in it."""
    luck, none = random.Random(f"{part} {seed}"), known("equivalent")
    if part == "python":
        places = [(file, *place) for file in files(part) for place in places_in_python(file)]
        some = [in_python(file, ROOT / SOURCES, *place) for file, *place in luck.sample(places, min(count, len(places)))]
        return [mistake for mistake in some if mistake.name not in none]
    every = [mistake for mistake in every_mistake(part) if mistake.name not in none]
    return luck.sample(every, min(count, len(every)))


class Workshop:
    """A copy of the project in `folder`, with what the tests of one part need. FMUs for the shells are taken from `fmus`."""

    def __init__(self, folder: Path, part: str, fmus: Path | None = None, tests: Sequence[str] | None = None) -> None:
        self.tests = tuple(tests or PARTS[part].tests)
        self.folder, self.part, self.order = folder, part, folder / f"{part}.json"
        self.copy, self.objects, self.fmus = folder / "copy", folder / "objects", folder / "fmus"
        if self.copy.exists():
            shutil.rmtree(self.copy)
        self.copy.mkdir(parents=True)
        ignored = shutil.ignore_patterns("__pycache__", "out", ".*")
        for name in (SOURCES, "tests", "build", "ssp"):
            shutil.copytree(ROOT / name, self.copy / name, ignore=ignored)
        for name in ("pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md"):
            shutil.copy(ROOT / name, self.copy / name)
        self.root = self.copy / SOURCES
        (self.root / VARIANTS).write_bytes(variants_file([(2, fmu_facts_of()), (3, fmu_facts_of())]))  # the tokens of the given FMUs
        self.libraries = self.root / "evat" / "_lib"
        self.target = host_target()
        if fmus is not None and not self.fmus.exists():
            shutil.copytree(fmus, self.fmus)
        self.machines: dict[str, bytes] = {}
        self.left_over: set[str] = set()  # kinds whose library still has a mistake that is gone from the objects
        self.right: dict[Path, bytes] = {}  # what a mistake has taken the place of

    # --- building

    def _objects(self, kind: str, sources: Sequence[Path]) -> None:
        """Compile `sources` to objects of a kind: 1 or 8 lanes, or an FMU of version 2 or 3."""
        lanes = {"1": 1, "8": MANY_LANES}.get(kind)
        if lanes is None:
            include, defines, exports = [*include_folders(self.root, CONTACT), fmi_headers()], {}, []
            processor = Processor("", (*compiling.BASELINE.flags, *TOLD))
        else:
            fits = next(fit for fit in compiling._processors(lanes) if fit.needs <= set(instructions()))
            processor, include = Processor(fits.name, (*fits.flags, *TOLD)), list(include_folders(self.root)[:1])
            defines, exports = {"LANES": lanes}, ["kernel.h"]
        fresh = self.folder / "fresh"
        compile_library(sources, fresh, self.target, include=include, defines=defines, exports=exports, link=False, processor=processor)
        place = self.objects / kind
        place.mkdir(parents=True, exist_ok=True)
        for built in fresh.iterdir():
            shutil.copy(built, place / built.name)

    def _link(self, kind: str, output: Path) -> None:
        command = [*compiling.compiler(), "-target", self.target.zig, "-O2", "-fno-sanitize=undefined", "-shared", "-o", str(output)]
        names = sorted(map(str, (self.objects / kind).glob("*.o")))
        subprocess.run([*command, *names, *compiling._link_flags(self.target, output.name), "-lm"], check=True, capture_output=True)

    def _finish(self, kind: str) -> None:
        """Put what the objects make to where the tests find it."""
        if kind in "18":
            lanes = 1 if kind == "1" else MANY_LANES
            fits = next(fit for fit in compiling._processors(lanes) if fit.needs <= set(instructions()))
            library = self.libraries / compiling._library_name(lanes, fits)
            self._link(kind, library)
            compiling.seal(library, compiling.sources_digest(self.root, CONTACT))  # else the tests compile their own at each start
            return
        import zipfile

        path = self.fmus / f"EvatContact-fmi{kind[-1]}.fmu"
        library = self.folder / f"EvatContact{self.target.extension}"
        self._link(kind, library)
        folder = self.target.fmi2_folder if kind == "fmi2" else self.target.fmi3_folder
        with zipfile.ZipFile(path) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
        place = next(name for name in files if name.startswith(f"binaries/{folder}/"))
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for name, content in {**files, place: library.read_bytes()}.items():
                archive.writestr(name, content)

    def _kinds(self, file: Path) -> dict[str, list[Path]]:
        """Which objects hang on a file: all that include it, or its own."""
        kernel = model_sources(self.root)
        if self.part == "kernel":
            return {kind: kernel if file.suffix == ".h" else [file] for kind in "18"}
        return {f"fmi{version}": [file] for version in (2, 3) if file in (*kernel, *shell_sources(self.root, version))}

    def prepare(self, longest: float | None = None) -> None:
        """Build all that a mistake may change, and measure the tests."""
        self.build()
        if not self.order.is_file():
            self._must_pass(None)
        self._must_pass(PARTS[self.part].quick if longest is None else longest)

    def build(self) -> None:
        """What is built of code without a mistake."""
        if self.part == "kernel":
            for kind in "18":
                self._objects(kind, model_sources(self.root))
                self._finish(kind)
        elif self.part == "shells":
            for version in (2, 3):
                self._objects(f"fmi{version}", [*model_sources(self.root), *shell_sources(self.root, version)])
                self._finish(f"fmi{version}")
        elif self.part == "machines":
            self.machines = self._build_machines()

    def _must_pass(self, longest: float | None) -> None:
        """A test that fails without any mistake would find them all."""
        status, test, said = self._pytest(["-x"] if longest else [], 3600, longest)
        if status != 0:
            raise SystemExit(f"the tests of {self.part} fail without any mistake (status {status}, {test}):\n{said}")

    def _build_machines(self) -> dict[str, bytes]:
        """All whose sources are not those they were built from: what the mistake before has changed, too."""
        ours, compiling.source_root = compiling.source_root, lambda: self.root
        try:
            return {part: build_machine_library(self.libraries, part).read_bytes() for part in machine_names(self.root)}
        finally:
            compiling.source_root = ours

    def _build(self, file: Path) -> bool:
        """Build what hangs on the file; False where the machine code is what it was."""
        if self.part == "machines":
            return self._build_machines() != self.machines
        left, changed = set(self.left_over), set()
        for kind, sources in self._kinds(file).items():
            before = {path: path.read_bytes() for path in (self.objects / kind).iterdir()}
            self._objects(kind, sources)
            if any(path.read_bytes() != content for path, content in before.items()):
                self.right |= before
                self.left_over.add(kind)
                changed.add(kind)
                self._finish(kind)
        for kind in left - changed:
            self._finish(kind)
        self.left_over = changed
        return bool(changed)

    def _put_right(self) -> None:
        """The objects as they were; the next mistake links them again."""
        for path, content in self.right.items():
            path.write_bytes(content)
        self.right.clear()

    # --- looking

    def _pytest(self, arguments: Sequence[str], limit: float, longest: float | None = None) -> tuple[int, str, str]:
        """Status, the test that failed or was being run, and what was said."""
        environment = {**os.environ, "MUTATION_ORDER": str(self.order), "PYTHONDONTWRITEBYTECODE": "1"}
        helpers = self.copy / "tests" / "mutation"
        environment["PYTHONPATH"] = os.pathsep.join(map(str, (self.root, self.copy / "build", helpers)))
        environment["EVAT_TEST_FMUS"] = str(self.fmus)
        if longest is not None:
            environment["MUTATION_LONGEST"] = str(longest)
        ignored = [f"--{'deselect' if '::' in path else 'ignore'}={path}" for path in LEFT_OUT]
        command = [sys.executable, "-m", "pytest", "-q", "-p", "killing_order", "-p", "no:cacheprovider", "-p", "no:randomly", "--tb=line"]
        command += [*ignored, *self.tests, *arguments]
        with (self.folder / "said.txt").open("w+", encoding="utf-8") as said:
            process = subprocess.Popen(command, cwd=self.copy, env=environment, stdout=said, stderr=said, start_new_session=True)
            try:
                status = process.wait(limit)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                status = process.wait()
            said.seek(0)
            text = said.read()
        run = [line[2:] for line in text.splitlines() if line.startswith("@ ")]
        return status, run[-1] if run and status not in (0, 5) else "", text[-1500:]

    def verdict(self, mistake: Mistake, longest: float | None = None) -> tuple[str, str]:
        """("killed", by which test), ("survived", ""), ("same code", ""), or ("no program", "") where it does not compile."""
        file = self.root / mistake.file
        right = file.read_text(encoding="utf-8")
        try:
            file.write_text(mistake.text, encoding="utf-8")
            try:
                if file.suffix == ".py":
                    compile(mistake.text, mistake.file, "exec")
                elif not self._build(file):
                    return "same code", ""
            except (CompileError, SyntaxError):
                return "no program", ""
            seen: dict[str, list[float]] = json.loads(self.order.read_text(encoding="utf-8"))
            longest = longest or PARTS[self.part].quick
            limit = 30 + 4 * sum(seconds for seconds, _ in seen.values() if seconds <= longest)
            status, test, _ = self._pytest(["-x"], limit, longest)
            if status == 0:
                return "survived", ""
            if test in seen:
                seen[test][1] += 1
                self.order.write_text(json.dumps(seen, indent=0), encoding="utf-8")
            return (
                "killed",
                test if test and status == 1 else f"{test} (status {status})".strip(),
            )  # a test that failed, or an end by a signal
        finally:
            file.write_text(right, encoding="utf-8")
            self._put_right()


def campaign(workshop: Workshop, some: Sequence[Mistake], longest: float | None = None) -> Iterator[tuple[Mistake, str, str]]:
    """Each mistake with its verdict."""
    for mistake in some:
        yield mistake, *workshop.verdict(mistake, longest)
