"""How far is the kernel from the right answer to a motion, in tolerances? The judged run, the reference, and the measure between them.

The measure. Error of a run = largest difference at any communication point between an output and the reference, over the size of that
output, over relative_tolerance. Size of friction_force: the largest of F_C, of F_S with a law that reads it, and of its own magnitude in
the run, because a bristle's deflection is only ever known to a share of its full reach, sigma0 times which is that, and the force may come
to rest at any small value.
Principal, feed and measured forces are sums with the friction force in them: the same size, or their own where they are larger. So are
powers and energies, over the way that the motion goes; the way that the contact slides is as large as itself, or a tenth of the motion's.

A draw that is beyond 10 tolerances is asked a second question: does the right answer itself move by more than 10 of them where what is
given moves by one? Inputs and friction levels are taken a tolerance larger and smaller, a given slip a rounding error (1e-12 of its size)
higher and lower, which is what hangs on a slip of just 0, and a given thickness thinner by a tolerance of its largest: one that comes to
just 0 at a corner and rises from there leaves a gap in time, or none. Where it does the draw is ill-conditioned: no solver that keeps to
the tolerance can be held to that answer, and the campaign counts it apart.

So it is where the chip flows by the shear angle of the moment, friction falls with speed, and one state goes with three slips: the
kernel stays with the one it came by until that ends, the reference, which looks from nowhere at each moment, may hold another. Whether
there is more than one is asked at each step of the reference, at fixed shear angles, which the search for the slip is no part of.

Forces jump where contact ends, bonds break, a law slips. A communication point so near to a jump that the kernel may find it a little
before or after is measured like a curve: a jump that comes early or late by the time in which the motion changes a spring force by one
tolerance counts as one tolerance of error.
"""

from __future__ import annotations

import functools
import hashlib
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cffi
import numpy as np
import numpy.typing as npt
from evat.model import BoolArray, FloatArray
from evat.native import kernel
from evat.native.compile import compile_library, host_target, kernel_sources, source_root
from filelock import FileLock

HERE = Path(__file__).resolve().parent
BUILT = HERE.parent.parent / "build" / "out" / "tolerance"
SOURCES = tuple(HERE / f"{name}.c" for name in ("radau", "course", "surface", "branches", "notes", "walk", "reference", "stepped"))
HEADERS = tuple(HERE / f"{name}.h" for name in ("radau", "course", "reference"))
EXPORTS = ("kernel.h", "radau.h", "reference.h")
VERDICTS = ("done", "no rates", "no step is short enough", "too many events", "too many steps")
FORCES = ("friction_force", "principal_force", "feed_force")
MEASURED = tuple(f"measured_{name}" for name in FORCES)
MEANS = tuple(f"mean_{name}" for name in (*FORCES, *MEASURED))
POWERS = ("mean_dissipated_power", "mean_shear_power")
TOTALS = ("dissipated_energy", "shear_energy", "sliding_distance")


@functools.cache
def library() -> tuple[Any, Any]:
    """Kernel and reference in one library, compiled where a source has changed."""
    root = source_root()
    sources = [*kernel_sources(root), *SOURCES]
    digest = hashlib.sha256(" ".join(EXPORTS).encode())
    for path in [*sources, *sorted((root / "kernel").rglob("*.h")), *HEADERS]:
        digest.update(path.read_bytes())
    output = BUILT / f"reference-{digest.hexdigest()[:16]}{host_target().extension}"
    BUILT.mkdir(parents=True, exist_ok=True)
    with FileLock(output.with_suffix(".lock")):  # tests run side by side
        if not output.is_file():
            include = [root / "kernel", HERE]
            compile_library(sources, output, host_target(), include=include, exports=EXPORTS, defines={"LANES": 1})
    ffi = cffi.FFI()
    text = kernel.declarations([root / "kernel" / "tables.h", root / "kernel" / "kernel.h", HERE / "radau.h", HERE / "reference.h"])
    ffi.cdef(text.replace("[LANES]", "[1]"))
    return ffi, ffi.dlopen(str(output))


@dataclass(frozen=True)
class Motion:
    """What the contact is driven with: inputs straight from `begin` to `end` of each segment (SI)."""

    times: FloatArray  # (n + 1,)
    begin: Mapping[str, FloatArray]  # (n,)
    end: Mapping[str, FloatArray]
    stepped: bool = False  # as a host steps an FMU, each segment one step; else as a record is followed

    @classmethod
    def record(cls, times: FloatArray, columns: Mapping[str, FloatArray], *, stepped: bool = False) -> Motion:
        """Through samples."""
        begin = {name: np.ascontiguousarray(column[:-1], dtype=np.float64) for name, column in columns.items()}
        end = {name: np.ascontiguousarray(column[1:], dtype=np.float64) for name, column in columns.items()}
        return cls(np.ascontiguousarray(times, dtype=np.float64), begin, end, stepped)

    @classmethod
    def held(cls, times: FloatArray, columns: Mapping[str, FloatArray]) -> Motion:
        """Inputs that stay at their values over each step."""
        values = {name: np.ascontiguousarray(column[:-1], dtype=np.float64) for name, column in columns.items()}
        return cls(np.ascontiguousarray(times, dtype=np.float64), values, values, True)


@dataclass(frozen=True)
class Case:
    """A contact and what it is driven with."""

    kind: str
    values: Mapping[str, float | str]
    on: tuple[str, ...]
    motion: Motion
    relative_tolerance: float
    seed: tuple[int, int] = (0, 0)

    @property
    def law(self) -> str:
        return str(self.values.get("friction_law", "lugre"))


@dataclass(frozen=True)
class Care:
    """How tightly the reference goes."""

    tolerance: float = 1e-9
    span: float = 1.0
    most_steps: int = 60_000
    most_events: int = 5_000
    branches: bool = False  # count the slips that go with each state


@dataclass(frozen=True)
class Jump:
    """Outputs that jump: when, in which time the motion changes a force by about itself, and what they are before and after."""

    time: float
    patience: float
    before: FloatArray
    after: FloatArray

    def of(self, members: BoolArray, later: float = 0.0) -> Jump:
        """The same of some outputs only; nan: not of this one."""
        return Jump(self.time + later, self.patience, *(np.where(members, side, math.nan) for side in (self.before, self.after)))


@dataclass
class Reference:
    verdict: str
    rows: FloatArray
    jumps: list[Jump] = field(default_factory=list)
    steps: int = 0
    events: int = 0
    evaluations: int = 0
    seconds: float = 0.0
    failed_at: float = 0.0
    branches: int = 0


@dataclass
class Answer:
    status: str
    rows: FloatArray
    steps: int
    seconds: float


def outputs(case: Case) -> tuple[str, ...]:
    """What is compared. Means of late measured forces are not: the reference shifts these forces, and windows do not shift with them.
    Nor is the deflection of a reset_integrator, which is carried along as it slides: as a state by rates it stands until it sticks."""
    means = case.values.get("kinematics", "internal") != "external" or case.values.get("averaging_window", 0) != 0
    late = "sensor_delay" in case.on
    shown = () if not means else (*(MEANS[: len(FORCES)] if late else MEANS), *POWERS)
    deflection = () if case.values.get("friction_law") == "reset_integrator" else ("bristle_deflection",)
    return (*FORCES, *MEASURED, *shown, *TOTALS, *deflection, "in_contact")


def _own(case: Case, effect: str, parameter: str) -> float:
    known = kernel.variable(f"{effect}.{parameter}")
    return float(case.values.get(known.name, known.start))


def _line(case: Case) -> FloatArray:
    frequency, phase = (_own(case, "line_disturbance", name) for name in ("frequency", "phase"))
    return np.asarray(np.sin(2 * math.pi * frequency * case.motion.times + phase))


# What sensors add as time goes on, per unit of a channel's own parameter.
ADDED: Mapping[str, Callable[[Case], FloatArray]] = {"sensor_drift": lambda case: case.motion.times, "line_disturbance": _line}


def _late(case: Case) -> tuple[Case, npt.NDArray[np.intp]]:
    """The case with its slip shifted by input_delay before the run and not in it, and the places of its samples."""
    motion, on = case.motion, tuple(name for name in case.on if name != "input_delay")
    places = np.arange(len(motion.times))
    if on == case.on or case.values.get("kinematics") != "external" or "slip_velocity" not in motion.begin:
        return replace(case, on=on), places
    tau, first, last = _own(case, "input_delay", "time"), motion.times[0], motion.times[-1]
    corners = motion.times + tau
    times = np.unique(np.concatenate([motion.times, corners[(corners > first) & (corners < last)]]))
    middle, length = (times[1:] + times[:-1]) / 2, np.diff(motion.times)

    def side(name: str, late: float, at: FloatArray) -> FloatArray:
        segment = np.clip(np.searchsorted(motion.times, middle - late) - 1, 0, len(length) - 1)
        share = np.clip((at - late - motion.times[segment]) / length[segment], 0, 1)
        return motion.begin[name][segment] * (1 - share) + motion.end[name][segment] * share

    late = {name: tau if name == "slip_velocity" else 0.0 for name in motion.begin}
    begin, end = ({name: side(name, late[name], at) for name in motion.begin} for at in (times[:-1], times[1:]))
    return replace(case, on=on, motion=replace(motion, times=times, begin=begin, end=end)), np.searchsorted(times, motion.times)


class _Prepared:
    """C's view of a case; keeps its arrays alive."""

    def __init__(self, case: Case, names: Sequence[str]) -> None:
        ffi, loaded = library()
        self.contact = ffi.new("struct Contact *")
        loaded.kernel_reset(self.contact)
        values = {"relative_tolerance": case.relative_tolerance, **case.values}
        for name, number in kernel.check_values(values, case.on).items():
            self.contact.value[kernel.variable(name).index][0] = number
        inputs = tuple(case.motion.begin)
        self.begin, self.end = (
            np.ascontiguousarray(np.column_stack([side[name] for name in inputs]) if inputs else np.empty((len(case.motion.times) - 1, 0)))
            for side in (case.motion.begin, case.motion.end)
        )
        self.input_index = ffi.new("int[]", [kernel.variable(name).index for name in inputs])
        self.output_index = ffi.new("int[]", [kernel.variable(name).index for name in names])
        for place, name in enumerate(inputs):
            self.contact.value[kernel.variable(name).index][0] = self.begin[0, place]
        self.motion = ffi.new("struct Motion *")
        self.motion.segments, self.motion.inputs, self.motion.outputs = len(case.motion.times) - 1, len(inputs), len(names)
        self.motion.rounds = case.motion.stepped
        self.motion.times = ffi.from_buffer("double[]", case.motion.times)
        self.motion.begin, self.motion.end = ffi.from_buffer("double[]", self.begin), ffi.from_buffer("double[]", self.end)
        self.motion.input_index, self.motion.output_index = self.input_index, self.output_index
        self.rows = np.full((len(case.motion.times), len(names)), math.nan)


STARTS = (1e-3, 1e-5, 1e-2, 1e-1)  # tolerances; cycles of other steps lead a search elsewhere, and a closer one may end where it is lost


def reference(case: Case, care: Care | None = None, start: float = STARTS[0]) -> Reference:
    """The right answer, from a periodic start that is found to `start` tolerances, or as near to it as one is found."""
    if "input_delay" in case.on:
        shifted, places = _late(case)
        run = reference(shifted, care, start)
        return replace(run, rows=run.rows[places])
    ffi, loaded = library()
    care = care or Care()
    names = outputs(case)
    # A delay is a shift of what the sensors show; what is added behind it as time goes on does not shift. A periodic start is the kernel's
    # own, found to a tolerance far below the one that is judged.
    late = float(case.values.get("sensor_delay.time", kernel.variable("sensor_delay.time").start)) if "sensor_delay" in case.on else 0.0
    values: dict[str, Any] = dict(case.values)
    if case.values.get("initial_state") == "periodic":
        values["relative_tolerance"] = start * case.relative_tolerance
    unshifted = {name: added for name, added in ADDED.items() if late > 0 and name in case.on}
    left_out = ("sensor_delay", *unshifted)
    right = replace(case, values=values, on=tuple(name for name in case.on if name not in left_out))
    prepared = _Prepared(right, names)
    lags = ffi.new("unsigned char[]", [name in MEASURED for name in names])
    prepared.motion.late, prepared.motion.lags = late, lags
    room = 4000
    jumps, sides = ffi.new("struct Jump[]", room), np.empty((2 * room, len(names)))
    yielded, how = ffi.new("struct Outcome *"), ffi.new("struct Care *")
    yielded.rows, yielded.jumps = ffi.from_buffer("double[]", prepared.rows), jumps
    yielded.sides, yielded.jump_room = ffi.from_buffer("double[]", sides), room
    how.tolerance, how.span, how.most_steps, how.most_events = care.tolerance, care.span, care.most_steps, care.most_events
    how.branches = care.branches
    begun = time.process_time()
    verdict = loaded.reference_run(prepared.contact, prepared.motion, how, yielded)
    seconds = time.process_time() - begun
    if prepared.contact.warnings & loaded.WARN_NOT_PERIODIC and start != STARTS[-1]:
        return reference(case, care, STARTS[STARTS.index(start) + 1])
    noted = [Jump(jumps[n].time, jumps[n].patience, *sides[jumps[n].first : jumps[n].first + 2].copy()) for n in range(yielded.jump_count)]
    for effect, added in unshifted.items():
        for name in MEASURED:
            prepared.rows[:, names.index(name)] += _own(case, effect, name.removeprefix("measured_")) * added(case)
    if late > 0:
        lagging = np.array([name in MEASURED for name in names])
        noted = [jump.of(~lagging) for jump in noted] + [jump.of(lagging, late) for jump in noted if not unshifted]
    steps, events, evaluations = yielded.steps, yielded.events, yielded.evaluations
    return Reference(VERDICTS[verdict], prepared.rows, noted, steps, events, evaluations, seconds, yielded.failed_at, yielded.branches)


def answer(case: Case) -> Answer:
    """What the kernel's own stepping gives."""
    ffi, loaded = library()
    names = outputs(case)
    prepared = _Prepared(case, names)
    begun = time.process_time()
    if case.motion.stepped:
        status = loaded.stepped_run(prepared.contact, prepared.motion, ffi.from_buffer("double[]", prepared.rows))
    else:
        status = loaded.kernel_start(prepared.contact, case.motion.times[0])
        record, yielded = ffi.new("struct Record *"), ffi.new("struct Yield *")
        table = np.ascontiguousarray(np.vstack([prepared.begin, prepared.end[-1:]]))
        record.count, record.times = len(case.motion.times), prepared.motion.times
        record.input_count, record.input_index, record.inputs = (
            prepared.motion.inputs,
            prepared.input_index,
            ffi.from_buffer("double[]", table),
        )
        yielded.output_count, yielded.output_index = len(names), prepared.output_index
        yielded.rows = ffi.from_buffer("double[]", prepared.rows)
        if status == loaded.STATUS_OK:
            status = loaded.kernel_run_record(prepared.contact, record, yielded, ffi.NULL)
    seconds = time.process_time() - begun
    steps = int(prepared.contact.value[kernel.variable("step_count").index][0])
    return Answer(ffi.string(loaded.kernel_status_text(status)).decode(), prepared.rows, steps, seconds)


@dataclass
class Judgement:
    """Errors in tolerances: of each output the largest, and its place."""

    case: Case
    answer: Answer
    reference: Reference
    errors: FloatArray  # (samples, outputs)
    names: tuple[str, ...]

    def worst(self, names: Sequence[str]) -> float:
        places = [self.names.index(name) for name in names if name in self.names]
        return float(np.max(self.errors[:, places], initial=0.0))


ROUNDING = 1e-12  # of a slip's size


def _moved(motion: Motion, factor: float, share: float, thinner: float = 0) -> Motion:
    """All inputs times a factor, the slip higher by a share of its size, the thickness lower by a share of its largest (below 0: none)."""

    def largest(name: str) -> float:
        return max((float(np.max(np.abs(columns[name]))) for columns in (motion.begin, motion.end) if name in columns), default=0.0)

    higher = {"slip_velocity": share * largest("slip_velocity"), "uncut_thickness": -thinner * largest("uncut_thickness")}

    def side(columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        return {name: column * factor + higher.get(name, 0) for name, column in columns.items()}

    return replace(motion, begin=side(motion.begin), end=side(motion.end))


def neighbours(case: Case) -> list[Case]:
    """What is given, a tolerance or a rounding error away."""
    near = [1 + sign * case.relative_tolerance for sign in (1, -1)]
    levels = {name: float(case.values.get(name, kernel.variable(name).start)) for name in ("F_C", "F_S")}
    beside = [replace(case, motion=_moved(case.motion, factor, 0)) for factor in near]
    beside += [replace(case, values={**case.values, **{name: level * factor for name, level in levels.items()}}) for factor in near]
    slides = "slip_velocity" in case.motion.begin
    if "uncut_thickness" in case.motion.begin:
        beside.append(replace(case, motion=_moved(case.motion, 1, 0, thinner=case.relative_tolerance)))
    return beside + [replace(case, motion=_moved(case.motion, 1, sign * ROUNDING)) for sign in (1, -1) if slides]


def sensitivity(case: Case, right: Reference, output: str, care: Care | None = None) -> float:
    """How far the right answer for one output moves between a case and its neighbours, at most, in tolerances."""
    names = outputs(case)
    place, furthest = names.index(output), 0.0
    for neighbour in neighbours(case):
        moved = reference(neighbour, care)
        if moved.verdict != "done":
            return math.inf
        furthest = max(furthest, float(np.max(errors(case, moved.rows, right, names)[:, place])))
    return furthest


def slips(case: Case, care: Care | None = None) -> int:
    """How many slips go with one state, at most, where the chip flows by the shear angle of the moment; elsewhere 1."""
    if case.values.get("chip_flow_angle") != "current_shear_angle":
        return 1
    return max(reference(case, replace(care or Care(), branches=True)).branches, 1)


def _way(case: Case) -> float:
    """Way of the motion, as much of which slides as contact lasts and sticks [m]."""
    motion, lengths = case.motion, np.diff(case.motion.times)
    if "slip_velocity" in motion.begin:
        return float(np.sum(lengths * (np.abs(motion.begin["slip_velocity"]) + np.abs(motion.end["slip_velocity"])) / 2))
    frequency, amplitude = (float(case.values.get(name, kernel.variable(name).start)) for name in ("vibration_frequency", "amplitude_x"))
    return 4 * amplitude * frequency * float(np.sum(lengths))


STICKS = 0.1  # share of the way; a contact that slides less is judged by as much


def sizes(case: Case, right: FloatArray, names: Sequence[str]) -> FloatArray:
    """What counts as the size of each output."""
    start = {name: float(case.values.get(name, kernel.variable(name).start)) for name in ("F_C", "F_S", "sigma0")}
    read = next(law.reads for law in kernel.laws() if law.name == case.law)
    static = max((start[each.name] for each in read if each.name == "F_S"), default=0.0)
    level = max(start["F_C"], static, float(np.max(np.abs(right[:, 0]))))
    own = np.max(np.abs(right), axis=0)
    size = np.maximum(own, level)
    way, period = _way(case), float(case.motion.times[-1] - case.motion.times[0])
    for place, name in enumerate(names):
        if name in POWERS:
            size[place] = max(level * way / period, own[place])
        elif name in TOTALS:
            size[place] = max(STICKS * way if name == "sliding_distance" else level * way, own[place])
        if name == "bristle_deflection":
            size[place] = max(level / start["sigma0"], own[place])
        elif name == "in_contact":
            size[place] = math.inf
    return size


def judge(case: Case, care: Care | None = None, right: Reference | None = None) -> Judgement:
    """Run both and compare."""
    names = outputs(case)
    right = right or reference(case, care)
    given = answer(case)
    if right.verdict != "done" or given.status != "done":
        return Judgement(case, given, right, np.full((1, len(names)), math.nan), names)
    return Judgement(case, given, right, errors(case, given.rows, right, names), names)


def errors(case: Case, rows: FloatArray, right: Reference, names: Sequence[str]) -> FloatArray:
    """In tolerances, (samples, outputs)."""
    size = sizes(case, right.rows, names)
    tolerance = case.relative_tolerance
    with np.errstate(invalid="ignore"):
        shares = np.abs(rows - right.rows) / size / tolerance
    shares[~np.isfinite(rows) & np.isfinite(right.rows)] = math.inf
    times = case.motion.times
    for jump in right.jumps:
        low, high = np.minimum(jump.before, jump.after), np.maximum(jump.before, jump.after)
        reach = 100 * tolerance * jump.patience
        for n in range(np.searchsorted(times, jump.time - reach), np.searchsorted(times, jump.time + reach, side="right")):
            outside = np.maximum(np.maximum(low - rows[n], rows[n] - high), 0) / size / tolerance
            late = abs(times[n] - jump.time) / jump.patience / tolerance
            shares[n] = np.fmin(shares[n], np.maximum(outside, late))
    return shares


if __name__ == "__main__":
    sys.exit("this is the measure; the campaign is tests/tolerance/campaign.py")
