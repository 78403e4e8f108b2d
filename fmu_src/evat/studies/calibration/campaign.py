"""On which simulated cases is the diagnosis calibrated? A campaign of rigs, machines and ellipses, with a gap or without.

What goes on in them is drawn by `simulated_rigs`, how it is recorded by `simulated_records`. What a judgement sees of a case is what a
diagnosis would: the same way from the recordings on. Case after case is appended to a file, so that a campaign goes on where it was
stopped; a case depends on its number alone.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Nominal
from evat.files.writing import as_output_error, usable
from evat.gap import diagnose_with
from evat.gap.verdict.calibrate import CalibrationCase
from evat.gap.verdict.constants import Constants
from evat.gap.verdict.judgement import MISTUNED, NO_GAP, UNKNOWN
from evat.model import EvatError
from evat.models.contact import ContactModel
from evat.native.compile import kernel_library_path
from evat.processes import process_pool
from evat.studies.calibration.simulated_records import NOISE, SPARE, STRANGE, Stranger, draw_bench, record
from evat.studies.calibration.simulated_rigs import EXACT, World, draw_form, draw_rig

KINDS = (NO_GAP, MISTUNED, "single", "single", "single", "pair", UNKNOWN)
SMALL, CLEAR = (0.3, 10.0), (1.0, 10.0)  # structural rms of a gap over the noise of one recording: of one effect, and of all else
SECOND = (0.4, 1.0)  # of the first: size of the second effect
REPEATS = ((2, 2), (2, 1, 1), (1, 1, 1), (2, 2, 1))  # recordings of each condition
KNOWN = (0.05, 0.25)  # relative standard deviation of a nominal value
FORMAT = 3  # of a line of the campaign's file


def draw_case(number: int, seed: int = 1) -> tuple[Experiment, str] | None:
    """The experiment with that number, and its truth; None where no effect that was drawn does anything there."""
    draw = np.random.default_rng([seed, number])
    kind = KINDS[number % len(KINDS)]
    other_form = number % 3 != 0 and kind != NO_GAP
    repeats = REPEATS[int(draw.integers(len(REPEATS)))]
    rig = draw_rig(draw, len(repeats), SPARE)
    world = World(rig, draw_form(draw, rig) if other_form else None)
    noise = world.level * float(10 ** draw.uniform(*NOISE))
    size = noise * math.exp(float(draw.uniform(*np.log(SMALL if kind == "single" else CLEAR))))
    row, stranger, truth = world.clean, None, kind
    if kind in ("single", "pair"):
        sizes = (size,) if kind == "single" else (size, size * float(draw.uniform(*SECOND)))
        gap = world.gap(draw, sizes, noise, by_relatives=other_form)
        if gap is None:
            return None
        row, truth = world.clean + gap[0], "+".join(sorted(gap[1]))
    elif kind == UNKNOWN:
        shape = STRANGE[int(draw.integers(len(STRANGE)))]
        stranger = Stranger(shape, float(draw.uniform(0.02, 0.1)), size, bool(draw.integers(2)))
    sd = {name: float(draw.uniform(*KNOWN)) for name, value in rig.law.items() if isinstance(value, float) and name not in EXACT}
    nominal = dict(rig.law)
    if kind != NO_GAP:
        for name, share in sd.items():
            nominal[name] = float(rig.law[name]) * math.exp(share * float(draw.normal()))
    trials = record(draw, world, draw_bench(draw, world, noise), row, repeats, stranger)
    values = Nominal(nominal, (), {**sd, **dict.fromkeys(EXACT, 0.0)})
    return replace(rig.experiment, nominal=values, trials=trials), truth


def run_case(number: int) -> str:
    """A line of the campaign's file: the case's number, what the judgement sees of it (nothing where there was no case), and how many
    seconds of a processor it took."""
    began = time.process_time()
    try:
        drawn = draw_case(number)
        if drawn is None:
            return _line({"number": number})
        experiment, truth = drawn
        answer, _ = diagnose_with(experiment, ContactModel(1), constants=Constants())
        case = CalibrationCase(answer.judgement.features, truth)
        return _line({"number": number, "case": case.line(), "seconds": round(time.process_time() - began, 1)})
    except EvatError as error:
        return _line({"number": number, "error": str(error)[:200]})


@functools.cache
def kernel_digest() -> str:
    """The kernel through which cases are run: those of another one are other cases."""
    return hashlib.sha256(kernel_library_path().read_bytes()).hexdigest()[:16]


def constants_digest() -> str:
    """The constants by which cases are diagnosed: by others a judgement sees others. Those that are calibrated stand as in the table, as
    cases are judged before any fit."""
    values = {name: getattr(CONSTANTS, name) for name in CONSTANTS.declared()}
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]


def _made_by() -> dict[str, Any]:
    return {"kernel": kernel_digest(), "constants": constants_digest(), "format": FORMAT}


def _line(entry: Mapping[str, Any]) -> str:
    text = json.dumps({**entry, **_made_by()}, sort_keys=True)
    return json.dumps({"digest": hashlib.sha256(text.encode()).hexdigest()[:16], "entry": text})


def _entry(line: str) -> Mapping[str, Any] | None:
    """What a line says; None where it is cut off, damaged, of another kernel, of other constants or of another format."""
    try:
        held = json.loads(line)
        text, digest = str(held["entry"]), held["digest"]
        entry: dict[str, Any] = json.loads(text)
        as_now = all(entry[name] == value for name, value in _made_by().items())
        return entry if hashlib.sha256(text.encode()).hexdigest()[:16] == digest and as_now else None
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def campaign(path: Path, count: int, workers: int, tell: Callable[[int], None] | None = None) -> Iterator[CalibrationCase]:
    """Cases 0 to count - 1; those that the file does not have whole, run through this kernel and by these constants, are run and appended
    to it."""
    text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
    entries = [entry for line in text.splitlines() if (entry := _entry(line)) is not None]
    kept, whole = {entry["number"]: entry for entry in entries}, text.endswith("\n") or not text
    missing = [number for number in range(count) if number not in kept]
    usable(path.parent)
    with process_pool(workers) as pool:
        for number, line in zip(missing, pool.map(run_case, missing), strict=True):
            with as_output_error(path, "the case"), path.open("a", encoding="utf-8") as file:
                file.write(line + "\n" if whole else "\n" + line + "\n")
            kept[number], whole = _entry(line) or {}, True
            if tell:
                tell(len(kept))
    for number in range(count):
        if "case" in kept[number]:
            yield CalibrationCase.read(kept[number]["case"])


def numbers(cases: Sequence[CalibrationCase]) -> dict[str, int]:
    """How many cases of each kind."""
    counts: dict[str, int] = {}
    for case in cases:
        kind = case.truth if case.truth in (NO_GAP, MISTUNED, UNKNOWN) else "pair" if "+" in case.truth else "single"
        counts[kind] = counts.get(kind, 0) + 1
    return counts
