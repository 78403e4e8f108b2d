"""Do random sequences of legal and illegal calls break an FMU? All parts, both versions of FMI, under sanitizers; fuzz.c.

A finding names a sequence, which depends on seed and number only: build and run it alone as fuzz.c says. EVAT_FUZZ_SEED chooses another
seed; `python3 build/test.py -m campaign -k fuzz -s` runs for ten minutes and prints its figures.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from evat.native.compile import (
    CONTACT,
    SANITIZE,
    CompileError,
    compile_library,
    fmi_headers,
    host_target,
    include_folders,
    machine_names,
    model_sources,
    sanitizer_runtime,
    source_root,
)
from sanitized import kernel_objects

HERE = Path(__file__).resolve().parent
PARTS = (CONTACT, *machine_names(source_root()))
SECONDS = {CONTACT: 3.0, **dict.fromkeys(PARTS[1:], 1.0)}  # of the clock, in every run of the tests
CAMPAIGN = {CONTACT: 360.0, **dict.fromkeys(PARTS[1:], 48.0)}  # ten minutes
SLOWEST = 1.0  # seconds of the processor, under sanitizers, that a call may take: it is left then, and counted
SEED = int(os.environ.get("EVAT_FUZZ_SEED", "1"))
CAMPAIGN_SEED = int(os.environ.get("EVAT_FUZZ_SEED", "2"))

Objects = dict[str, Path]


class Workshop:
    """Compiles what is asked for, once: shells and host are the same for all models."""

    def __init__(self, factory: pytest.TempPathFactory) -> None:
        self.folder = factory.mktemp("fuzz")
        self._factory = factory
        self._kept: dict[str, Objects] = {}

    def objects(self, name: str, part: str, sources: Sequence[Path]) -> Objects:
        if name not in self._kept:
            include = [*include_folders(source_root(), part), source_root() / "kernel", fmi_headers()]
            defines = ["_XOPEN_SOURCE=700"]
            made = compile_library(
                sources, self.folder / name, host_target(), include=[*include, HERE], defines=defines, link=False, sanitize=True
            )
            self._kept[name] = {path.name: path for path in made.glob("*.o")}
        return self._kept[name]

    def fuzz(self, part: str, instead: Objects | None = None) -> Path:
        """The program for one part; some of its objects may be replaced by others."""
        objects = self.objects("around", part, [*sorted((source_root() / "fmi").glob("*.c")), *sorted(HERE.glob("*.c"))])
        if part == CONTACT:
            model = kernel_objects(self._factory)
        else:
            model = self.objects(f"model-{part}", part, model_sources(source_root(), part))
        objects = {**objects, **model, **(instead or {})}
        program = self.folder / f"fuzz-{part}{'-planted' if instead else ''}"
        subprocess.run(["gcc", *SANITIZE, *map(str, objects.values()), "-o", str(program), "-lm"], check=True)
        return program


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Workshop:
    try:
        sanitizer_runtime()
    except CompileError as error:
        pytest.skip(str(error))
    return Workshop(tmp_path_factory)


def ran(program: Path, seed: int, seconds: float) -> tuple[subprocess.CompletedProcess[str], Mapping[str, float]]:
    """What it said, and its figures."""
    command = [str(program), str(seed), "0", "1000000000", str(seconds), str(SLOWEST)]
    environment = os.environ | {"UBSAN_OPTIONS": "print_stacktrace=1:abort_on_error=1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace", timeout=seconds + 120, check=False)
    last = done.stdout.splitlines()[-1] if done.stdout else ""
    return done, {name: float(number) for name, number in re.findall(r"(\w+) ([\d.]+)(?: |$)", last)}


def judged(workshop: Workshop, part: str, seed: int, seconds: float) -> str:
    """One line of figures; a finding, or a run in which little has happened, fails."""
    done, figures = ran(workshop.fuzz(part), seed, seconds)
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[:5000]
    assert figures["findings"] == 0
    assert figures["calls"] > 200 * seconds
    for what in ("ok", "error", "refused", "numbers", "done", "forged", "taken"):
        assert figures[what] > 0, what
    assert figures["done"] > 0.8 * figures["steps"]
    assert figures["slow"] == 0 or part == CONTACT  # one of its steps may hold any number of cycles
    return f"{part}, seed {seed}: " + ", ".join(f"{name} {number:g}" for name, number in figures.items())


@pytest.mark.parametrize("part", PARTS)
def test_random_calls_break_nothing(workshop: Workshop, part: str) -> None:
    print(judged(workshop, part, SEED, SECONDS[part]))


@pytest.mark.parametrize(
    ("seed", "sequence"),
    [
        (606842, 66845),  # a gap at the oldest cycle that is kept: the place before a ring's first was read
        (880417, 6976),  # a step of 1e9 s that ended 19 cycles late, at a point that was kept for another
        (661127, 48233),  # a saved past with forces at a time of -1.8e308 s that were no numbers, which was refused then
    ],
)
def test_sequences_that_broke_something_do_no_longer(workshop: Workshop, seed: int, sequence: int) -> None:
    """Of the contact, each by itself."""
    command = [str(workshop.fuzz(CONTACT)), str(seed), str(sequence), "1", "60", str(SLOWEST)]
    environment = os.environ | {"UBSAN_OPTIONS": "print_stacktrace=1:abort_on_error=1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace", timeout=180, check=False)
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[:5000]
    assert done.stdout.splitlines()[-1].startswith("sequences 1 ")


@pytest.mark.campaign
@pytest.mark.parametrize("part", PARTS)
def test_ten_minutes_of_random_calls_break_nothing(workshop: Workshop, part: str) -> None:
    print(judged(workshop, part, CAMPAIGN_SEED, CAMPAIGN[part]))


# ---- would a fault be found? ----

FAULTS: dict[str, tuple[tuple[tuple[str, str, str], ...], str]] = {
    "a forged state is taken": ((("fmi/state.c", "own = is_sound(", "own = 1 || is_sound("),), r"FOUND .*takes a state in mode"),
    "an illegal call is answered": (
        (("fmi/fmi3.c", "ENTER(RUNNING | STEP_FAILED);", "ENTER(ANY_MODE);"),),
        r"FOUND .*fmi3Terminate: answers 0 in mode \d+, where it must be refused",
    ),
    "an error is silent": (
        (("fmi/report.c", "    c->host.say(&c->host, answer,", "    if (answer != ANSWER_ERROR)\n        c->host.say(&c->host, answer,"),),
        r"FOUND .*answers 3 with 0 log lines",
    ),
    "a value out of bounds is taken": (
        (("kernel/shared.c", "if (value < variable->min || value > variable->max)", "if (value < variable->min)"),),
        r"FOUND .*to arguments that must be refused",
    ),
    "what is no number is shown": (
        (
            ("machines/machine.c", "if (!isfinite(model->value[i]))\n            return STATUS_DIVERGED;", ";"),
            ("fmi/values.c", "        if (!isfinite(x))\n", "        if (0)\n"),
        ),
        r"FOUND .*value \d+ is -?(inf|nan)",
    ),
    "memory is written behind its end": (
        (
            (
                "fmi/component.c",
                "component_reset(struct Component *c)\n{\n",
                "component_reset(struct Component *c)\n{\n    ((volatile char *)c)[block_size()] = 1;\n",
            ),
        ),
        r"heap-buffer-overflow[\s\S]*DIED in sequence \d+ \d+",
    ),
    "an integer overflows": (
        (("machines/linear_response.c", "(int)ceil(log2(size) + 1)", "(int)ceil(log2(size) * 1e30)"),),
        r"(outside the range|cannot be represented)[\s\S]*DIED in sequence",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(workshop: Workshop, tmp_path: Path, fault: str) -> None:
    edits, words = FAULTS[fault]
    faulty = []
    for name, text, other in edits:
        whole = (source_root() / name).read_text()
        assert text in whole, name
        copy = tmp_path / name
        copy.parent.mkdir(exist_ok=True)
        copy.write_text(whole.replace(text, other))
        faulty.append(copy)
    done, _ = ran(workshop.fuzz("spindle", workshop.objects(fault, "spindle", faulty)), SEED, 4.0)
    assert done.returncode != 0
    assert re.search(words, done.stdout + done.stderr), (done.stdout + done.stderr)[-3000:]
