"""What is measured in these recordings? Signals, repeats and a first nominal model; a question where nothing can be guessed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from evat.experiment import ExperimentError
from evat.experiment.begin.files import Recordings, first_rows, recordings
from evat.experiment.begin.names import named
from evat.experiment.begin.words import Meant, meant
from evat.experiment.document import CLOCK, FRICTION, TRIGGER
from evat.files.text import TextForm
from evat.model import FloatArray, ParameterError
from evat.native import kernel
from evat.required_inputs import MOTION
from evat.units import affine, base_unit

ALIKE = 0.02  # relative: recordings whose motions differ by less repeat each other
MOVING = 0.05  # of the highest speed: below it friction is not read off
AGAINST = -0.3  # correlation of force and direction below which the sensor counts the other way
CUTTING = {"principal_force": "principal_force", "feed_force": "feed_force"}
UNKNOWN = 1.0  # relative sd of a value that no data tell: it may be several times as large, or as small
SET = ("cutting_speed", "feed", "width")  # what a cut is made at


@dataclass(slots=True)
class Answers:
    """What was told and so is not guessed: columns by signal, units by column, lever arm [m], motor constant (number, unit), and the form
    of the files as far as its fields are `stated`."""

    signals: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    radius: float | None = None
    motor_constant: tuple[float, str] | None = None
    form: TextForm = field(default_factory=TextForm)
    stated: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Question:
    """What cannot be told: the option that answers it, how it is asked, and what may be answered (anything where it is empty)."""

    option: str
    asked: str
    choices: tuple[str, ...] = ()
    key: str = ""


@dataclass(frozen=True, slots=True)
class SignalGuess:
    """A signal's table, and by what it was guessed, "" where it was told."""

    name: str
    table: Mapping[str, Any]
    why: str


@dataclass(frozen=True, slots=True)
class TrialGuess:
    file: str
    condition: str
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Begun:
    """What was understood of a folder; `values` (value, relative sd, why) are of the nominal model, `left` is what was not used and why."""

    recorded: Recordings
    signals: tuple[SignalGuess, ...]
    trials: tuple[TrialGuess, ...]
    means: str
    ignored: tuple[str, ...]
    kinematics: str
    values: Mapping[str, tuple[float, float, str]]
    repeats: str
    left: tuple[str, ...]
    look: tuple[str, ...]


def begin(folder: Path, answers: Answers) -> tuple[Begun | None, list[Question]]:
    """What a folder holds, or the questions that are left."""
    return _Guess(recordings(folder, answers.form, answers.stated), answers).begun()


class _Guess:
    def __init__(self, recorded: Recordings, answers: Answers) -> None:
        self.recorded, self.answers = recorded, answers
        self.questions: list[Question] = []
        self.signals: list[SignalGuess] = []
        self.look: list[str] = []
        headers, below = recorded.sniffed.headers, recorded.sniffed.units
        for column in (*answers.signals.values(), *answers.units):
            if column not in headers:
                raise ExperimentError(f"there is no column {column!r}; the files have {', '.join(map(repr, headers[:40]))}.")
        pairs = [(header, unit) for header, unit in zip(headers, below, strict=True) if header.strip() and headers.count(header) == 1]
        self.columns = {header: meant(header, unit, answers.units.get(header, "")) for header, unit in pairs}
        self.told = {column: name for name, column in answers.signals.items()}
        self.rows: dict[str, dict[str, FloatArray]] = {}

    def begun(self) -> tuple[Begun | None, list[Question]]:
        recorded = self.recorded
        clock = self.chosen(CLOCK, ("time",)) or self.only_timestamps()
        if clock is not None and clock.header in recorded.sniffed.timestamps:
            sniffed = recorded.sniffed
            self.recorded = replace(recorded, sniffed=replace(sniffed, form=replace(sniffed.form, timestamp=clock.header)))
        if clock is None and self.of("principal_force", "feed_force", "force") and (self.of(*SET) or self.counted() < 50):
            return self.averages()
        if clock is None:
            self.ask_column(CLOCK, "which column is the clock")
            return None, self.questions
        motion = self.chosen(MOTION, ("velocity", "position"))
        cut = [column for kind in CUTTING if (column := self.chosen(kind, (kind,))) is not None]
        force = None
        if motion is not None or not cut:
            if motion is None:
                self.ask_column(MOTION, "which column is the slip velocity, or the position")
            force = self.chosen(FRICTION, ("force", "torque", "current", "coefficient"))
            if force is None and not cut:
                self.ask_column(FRICTION, "which column is the friction force, a torque or the motor's current")
        if self.questions:
            return None, self.questions
        load = self.chosen("normal_load", ("normal_load",)) if force is not None and force.kind == "coefficient" else None
        read = [each for each in (clock, motion, force, load, *cut) if each is not None]
        wanted = [each.header for each in read]
        self.rows = {file: first_rows(self.recorded, file, wanted) for file in self.recorded.files}
        self.clock(clock)
        if motion is not None:
            self.motion(motion, clock)
        for each in cut if force is None else [force]:
            self.force(each, motion, FRICTION if each is force else str(self.told.get(each.header, each.kind)), load)
        for name, kind in (("normal_load", "normal_load"), ("uncut_thickness", "uncut_thickness"), (TRIGGER, "trigger")):
            more = self.chosen(name, (kind,))
            if more is not None and (more not in read or more is load) and (motion is not None or name == TRIGGER):
                self.plain(name, more)
        for name, header in self.answers.signals.items():
            if name not in {signal.name for signal in self.signals}:
                self.plain(name, self.columns[header])
        if self.questions:
            return None, self.questions
        trials, repeats = self.trials(motion)
        values = self.nominal(motion, force)
        return self.result(trials, "", (), "external" if motion is not None else "internal", values, repeats), []

    # Which column is it?

    def of(self, *kinds: str) -> list[Meant]:
        return [each for each in self.columns.values() if each.kind in kinds and each.header not in self.told]

    def chosen(self, name: str, kinds: Sequence[str]) -> Meant | None:
        """The column that was told, else the only one of the first kind that there is, by its name rather than by its unit alone, measured
        rather than commanded."""
        if name in self.answers.signals:
            return self.columns[self.answers.signals[name]]
        for kind, by_name in [(kind, by_name) for by_name in (True, False) for kind in kinds]:
            candidates = [each for each in self.of(kind) if bool(each.word) == by_name]
            measured = [each for each in candidates if not each.commanded] or candidates
            stated = [each for each in measured if each.unit] or measured
            if len(stated) > 1:
                longest = max(len(each.word) for each in stated)
                stated = [each for each in stated if len(each.word) == longest]
            if len(stated) == 1:
                return stated[0]
            if len(stated) > 1:
                self.ask_column(name, f"which column is {name}", tuple(each.header for each in stated))
                return stated[0]
        return None

    def only_timestamps(self) -> Meant | None:
        """The clock where no name tells it: the only column that holds times of day."""
        stamped = self.recorded.sniffed.timestamps
        return self.columns.get(stamped[0]) if len(stamped) == 1 else None

    def ask_column(self, name: str, asked: str, choices: tuple[str, ...] = ()) -> None:
        columns = choices or tuple(self.columns)
        self.questions.append(Question(f"--signal {name}=COLUMN", f"{asked}?", columns, name))

    def unit(self, column: Meant, usual: str = "") -> str:
        if not column.unit and usual:
            self.look.append(f"column {column.header!r} states no unit; {usual} was taken")
        if not column.unit and not usual:
            self.questions.append(
                Question(f"--unit '{column.header}=UNIT'", f"in which unit is the column {column.header!r}?", (), column.header)
            )
        return column.unit or usual

    def why(self, name: str, column: Meant, more: str = "", stamped: bool = False) -> str:
        by = "" if name in self.answers.signals else f"by {column.word!r} in its header" if column.word else "by its unit"
        unit = "it holds times of day" if stamped else "" if column.unit else "its unit is usual, the header states none"
        return "; ".join(filter(None, (by, unit, more)))

    # The signals.

    def clock(self, column: Meant) -> None:
        steps = np.concatenate([np.diff(rows[column.header]) for rows in self.rows.values()])
        step = float(np.median(steps)) if steps.size else 0.0
        if not step > 0:
            raise ExperimentError(f"column {column.header!r} was taken for the clock and does not increase; say --signal {CLOCK}=COLUMN.")
        usual = "s" if step < 1 else "ms"  # nobody records friction at one sample a second or slower
        stamped = column.header == self.recorded.sniffed.form.timestamp
        unit = "s" if stamped else self.unit(column, usual)
        rate = 1 / (step * affine(unit, "s")[0])
        self.signals.append(
            SignalGuess(CLOCK, {"column": column.header, "unit": unit}, self.why(CLOCK, column, f"{rate:.6g} samples a second", stamped))
        )
        self.look.append(f"the clock is in {unit}, so there are {rate:.6g} samples a second; is that so?")

    def motion(self, column: Meant, clock: Meant) -> None:
        unit = self.unit(column)
        table: dict[str, Any] = {"column": column.header, "unit": unit, "role": "input"}
        if unit:
            of, radial = self.dimension(
                column, unit, {"m/s": (False, False), "m": (True, False), "rad/s": (False, True), "rad": (True, True)}
            )
            if of:
                table["from"] = "position"
            if radial:
                table["radius"] = self.radius(f"{column.header!r} is in {unit}")
        self.signals.append(SignalGuess(MOTION, table, self.why(MOTION, column)))

    def dimension(self, column: Meant, unit: str, allowed: Mapping[str, Any]) -> Any:
        for base, what in allowed.items():
            if base_unit(unit).exponents == base_unit(base).exponents:
                return what
        raise ExperimentError(
            f"column {column.header!r} is in {unit}; what it was taken for is in {', '.join(allowed)}. Say --signal or --unit."
        )

    def radius(self, because: str) -> float:
        if self.answers.radius is None and not any(each.key == "radius" for each in self.questions):
            self.questions.append(
                Question("--radius '20 mm'", f"{because}; at which radius is the contact (a screw: lead/2/pi)?", (), "radius")
            )
        return self.answers.radius or 1.0

    def force(self, column: Meant, motion: Meant | None, name: str, load: Meant | None) -> None:
        unit = self.unit(column, {"current": "A", "torque": "N.m", "coefficient": "1"}.get(column.kind, "N"))
        table: dict[str, Any] = {"column": column.header, "unit": unit, "role": "output"}
        what = self.dimension(column, unit, {"N": "force", "N.m": "torque", "A": "current", "V": "voltage", "1": "pure number"})
        if what == "torque":
            table["radius"] = self.radius(f"{column.header!r} is a torque")
        elif load is not None and self.answers.motor_constant is None:
            table["scale"] = self.constant_load(column, load)
        elif what != "force":
            table["scale"] = self.motor_constant(column, unit)
        more = ""
        if motion is not None:
            together = self.with_direction(motion, column)
            more = f"correlation with the direction of motion {together:.2f}" if math.isfinite(together) else ""
            if together < AGAINST:
                table["sign"] = -1
                self.look.append(
                    f"{column.header!r} runs against the motion, so its sign was turned; friction is positive in positive slip"
                )
            elif not abs(together) > -AGAINST:
                self.look.append(f"{column.header!r} hardly follows the direction of motion: is it friction?")
        self.signals.append(SignalGuess(name, table, self.why(name, column, more)))

    def constant_load(self, column: Meant, load: Meant) -> float:
        """By which a friction coefficient becomes a force [N]."""
        loads = np.concatenate([rows[load.header] for rows in self.rows.values()]) * affine(self.unit(load, "N"), "N")[0]
        least, most = float(loads.min()), float(loads.max())
        if not most - least <= ALIKE * most:
            raise ExperimentError(
                f"{column.header!r} is a friction coefficient, and {load.header!r} goes from {least:.4g} to {most:.4g} N; a force is "
                "needed. Add a column of the friction force, or say --motor-constant 'LOAD N' for a load that all recordings share."
            )
        self.look.append(f"the friction force is {column.header!r} times the load of {np.median(loads):.4g} N")
        return float(f"{np.median(loads):.6g}")

    def motor_constant(self, column: Meant, unit: str) -> float:
        """What a unit of SI of the column is in N."""
        if self.answers.motor_constant is None:
            option, asked = "--motor-constant '0.5 N.m/A'", f"{column.header!r} is in {unit}; how many N or N.m is one {unit}?"
            if column.kind == "coefficient":
                option, asked = "--motor-constant '50 N'", f"{column.header!r} is a friction coefficient; at which normal load?"
            self.questions.append(Question(option, asked, (), "motor_constant"))
            return 1.0
        number, given = self.answers.motor_constant
        per = base_name(unit)
        for wanted in ("N", "N.m"):
            try:
                factor = affine(given, wanted if per == "1" else f"{wanted}/{per}")[0]
            except ParameterError:  # the other, then
                continue
            return number * factor / (self.radius(f"the motor constant is in {given}") if wanted == "N.m" else 1.0)
        raise ExperimentError(f"--motor-constant in {given}: N or N.m for each {unit} of {column.header!r} is needed, such as '0.5 N.m/A'.")

    def plain(self, name: str, column: Meant) -> None:
        """A signal that is read as it stands."""
        if name == TRIGGER:
            self.signals.append(SignalGuess(name, {"column": column.header, "unit": column.unit or "1"}, self.why(name, column)))
            return
        role = "output" if kernel.variable(name).causality == "output" else "input"
        unit = self.unit(column, "N" if kernel.variable(name).unit == "N" else "")
        self.signals.append(SignalGuess(name, {"column": column.header, "unit": unit, "role": role}, self.why(name, column)))

    # What the numbers tell.

    def speed(self, rows: Mapping[str, FloatArray], motion: Meant) -> FloatArray:
        """The slip velocity in units of its column (over a sample, of a position); its size does not matter here."""
        column = rows[motion.header]
        table = next((signal.table for signal in self.signals if signal.name == MOTION), {})
        return np.gradient(column) if table.get("from") and column.size > 1 else column

    def sliding(self, motion: Meant, force: Meant) -> tuple[FloatArray, FloatArray]:
        """Slip velocity and force in units of their columns, over all recordings, where the contact moves."""
        speeds, forces = [], []
        for rows in self.rows.values():
            speed = self.speed(rows, motion)
            moving = np.abs(speed) > MOVING * np.max(np.abs(speed), initial=0.0)
            speeds.append(speed[moving])
            forces.append(rows[force.header][moving])
        return np.concatenate(speeds), np.concatenate(forces)

    def with_direction(self, motion: Meant, force: Meant) -> float:
        """Correlation of the force with the direction of motion, over all recordings."""
        speed, column = self.sliding(motion, force)
        direction = np.sign(speed)
        if direction.size < 3 or not np.ptp(direction) or not np.ptp(column) > 0:
            return float(np.sign(np.mean(direction * column))) if direction.size else math.nan
        return float(np.corrcoef(direction, column)[0, 1])

    def trials(self, motion: Meant | None) -> tuple[tuple[TrialGuess, ...], str]:
        told, repeats = named(self.recorded.files)
        conditions = {file: each.condition for file, each in told.items()}
        if not repeats and motion is not None and len(conditions) > 1:
            conditions, repeats = self.by_likeness(conditions, motion)
        signals = {signal.name for signal in self.signals}
        needed = ("normal_load",) if motion is not None else SET
        trials = tuple(
            TrialGuess(
                file,
                conditions[file],
                {
                    name: number * affine(unit, kernel.variable(name).unit)[0]
                    for name, number, unit in told[file].values
                    if name in needed and name not in signals
                },
            )
            for file in self.recorded.files
        )
        if len(set(conditions.values())) == len(conditions):
            self.look.append("no repeats were seen; trials of one condition tell the noise, so give repeats the same condition")
        return trials, repeats

    def by_likeness(self, conditions: Mapping[str, str], motion: Meant) -> tuple[dict[str, str], str]:
        """Recordings as long as each other whose motions are as large repeat each other; they are named by what their names share."""
        groups: list[tuple[tuple[float, int], str]] = []
        alike = {}
        for file, rows in self.rows.items():
            speed = self.speed(rows, motion)
            size, count = float(np.sqrt(np.mean(speed**2))) if speed.size else 0.0, speed.size
            for (other, samples), condition in groups:
                if abs(size - other) <= ALIKE * max(size, other) and abs(count - samples) <= ALIKE * max(count, samples):
                    alike[file] = condition
                    break
            else:
                groups.append(((size, count), conditions[file]))
                alike[file] = conditions[file]
        if len(groups) == len(alike):
            return alike, ""
        shared = {name: _shared([conditions[file] for file in alike if alike[file] == name]) for name in set(alike.values())}
        if all(shared.values()) and len(set(shared.values())) == len(shared):
            alike = {file: shared[name] for file, name in alike.items()}
        return alike, "recordings as long, and with as fast a motion, repeat each other"

    def nominal(self, motion: Meant | None, force: Meant | None) -> dict[str, tuple[float, float, str]]:
        """Values, their relative standard deviations, and where they come from."""
        start = {variable.name: variable.start for variable in kernel.variables()}
        if motion is None or force is None:
            why = "the component's start, not from your data"
            names = ("F_C", "F_S", "sigma2", "shear_stress", *SET) if motion is None else ("F_C", "F_S", "sigma2")
            return {name: (start[name], 0.1 if name in SET else UNKNOWN, why) for name in names}
        by_name = {signal.name: signal.table for signal in self.signals}
        level = self.level(motion, force, by_name[FRICTION])
        if not level > 0:
            level = start["F_C"]
        return {
            "F_C": (float(f"{level:.3g}"), 0.3, "median of the force while it slides"),
            "F_S": (float(f"{1.15 * level:.3g}"), 0.3, "somewhat more than F_C"),
            "v_s": (start["v_s"], UNKNOWN, "the component's start, not from your data"),
            "sigma0": (float(f"{level / 1e-4:.3g}"), UNKNOWN, "bristles that bend by 0.1 mm: not from your data"),
            "sigma1": (start["sigma1"], UNKNOWN, "the component's start, not from your data"),
            "sigma2": (start["sigma2"], UNKNOWN, "the component's start, not from your data"),
        }

    def level(self, motion: Meant, force: Meant, table: Mapping[str, Any]) -> float:
        """Median size of the friction force while it slides [N]."""
        _, forces = self.sliding(motion, force)
        median = float(np.median(np.abs(forces))) if forces.size else 0.0
        factor = float(base_unit(str(table["unit"])).factor) * float(table.get("scale", 1.0)) / float(table.get("radius", 1.0))
        return median * factor

    def counted(self) -> int:
        wanted = [each.header for each in self.of("principal_force", "feed_force", "force")][:1]
        return max(first_rows(self.recorded, file, wanted)[wanted[0]].size for file in self.recorded.files)

    def averages(self) -> tuple[Begun | None, list[Question]]:
        """A file of averages: what was set, and mean forces."""
        if len(self.recorded.files) > 1:
            raise ExperimentError(f"{', '.join(self.recorded.files[:3])} have no clock and look like averages; put all rows into one file.")
        used: set[str] = set()
        wanted = [(f"mean_{kind}", kind) for kind in CUTTING] + [(name, name) for name in SET]
        for name, kind in wanted:
            column = self.chosen(name, (kind,))
            if column is None:
                continue
            usual = "N" if kind in CUTTING else {"cutting_speed": "m/min"}.get(kind, "mm")
            role = "output" if kind in CUTTING else "input"
            self.signals.append(
                SignalGuess(name, {"column": column.header, "unit": self.unit(column, usual), "role": role}, self.why(name, column))
            )
            used.add(column.header)
        if not any(signal.name.startswith("mean_") for signal in self.signals):
            self.ask_column("mean_feed_force", "which column is the mean feed force (or say --signal mean_principal_force=COLUMN)")
        for name, header in self.answers.signals.items():
            if header not in used:
                self.plain(name, self.columns[header])
                used.add(header)
        if self.questions:
            return None, self.questions
        ignored = tuple(header for header in self.columns if header not in used and header != "condition")
        values = self.nominal(None, None)
        values = {name: value for name, value in values.items() if name not in {signal.name for signal in self.signals}}
        self.look.append("rows with the same settings are replicates and tell the noise of a mean")
        return self.result((), self.recorded.files[0], ignored, "internal", values, ""), []

    def result(
        self,
        trials: tuple[TrialGuess, ...],
        means: str,
        ignored: tuple[str, ...],
        kinematics: str,
        values: Mapping[str, tuple[float, float, str]],
        repeats: str,
    ) -> Begun:
        used = {str(signal.table["column"]) for signal in self.signals}
        left = [f"column {header!r}" for header in self.columns if header not in used]
        names = tuple(self.signals)
        return Begun(
            self.recorded, names, trials, means, ignored, kinematics, values, repeats, (*left, *self.recorded.aside), tuple(self.look)
        )


def base_name(unit: str) -> str:
    """A unit's own SI unit, for the denominator of a motor constant: A of mA; "1" of a pure number."""
    exponents = base_unit(unit or "1").exponents
    return next((base for base in ("A", "V") if base_unit(base).exponents == exponents), "1")


def _shared(names: Sequence[str]) -> str:
    """The parts that all of the names have, as they stand in the first."""
    first, *others = (name.split("_") for name in names)
    return "_".join(part for part in first if all(part in other for other in others))
