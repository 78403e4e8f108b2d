"""What is measured in these recordings? Signals, repeats and a first nominal model; a question where nothing can be guessed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from evat.experiment import ExperimentError
from evat.experiment.begin.files import first_rows, recordings
from evat.experiment.begin.names import by_what_they_share, named
from evat.experiment.begin.runs import FilePart, rows_of, runs
from evat.experiment.begin.signals import Signals
from evat.experiment.begin.sliding import repeating, sliding
from evat.experiment.begin.understood import Answers, Begun, Question, SignalGuess, TrialGuess
from evat.experiment.begin.words import Meant
from evat.experiment.document import CLOCK, FRICTION, TRIGGER
from evat.native import kernel
from evat.required_inputs import AMPLITUDES, MOTION
from evat.units import affine, base_unit

CUTTING = {"principal_force": "principal_force", "feed_force": "feed_force"}
UNKNOWN = 1.0  # relative sd of a value that no data tell: it may be several times as large, or as small
PRESLIDING = 1e-5  # m, F_C/sigma0: the middle of the parameter sets, of which most are within a factor of ten (0.01 to 74 um)
ALIKE = 10.0  # times as long at most is a step of the clock of files that were recorded alike
BESIDE = ("normal_load", "uncut_thickness")  # what a test is made at beside its motion
SET = ("cutting_speed", "feed", "width")  # what a cut is made at
VIBRATION = ("vibration_frequency", *AMPLITUDES)


def begin(folder: Path, answers: Answers) -> tuple[Begun | None, list[Question]]:
    """What a folder holds, or the questions that are left."""
    return _Guess(recordings(folder, answers.form, answers.stated), answers).begun()


class _Guess(Signals):
    runs: Sequence[FilePart] = ()

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
        self.leave_aside_what_runs_otherwise(clock)
        more = {name: self.chosen(name, (name,)) for name in (*(BESIDE if motion is not None else ()), TRIGGER)}
        beside = [column for name in BESIDE if (column := more.get(name)) is not None]
        measured = [each.header for each in (clock, motion, force, *cut) if each is not None]
        wanted = list(dict.fromkeys([*measured, *(column.header for column in beside)]))
        self.runs = runs(self.recorded, clock.header, [header for header in self.columns if header not in measured])
        self.rows = {
            each.name: rows_of(self.recorded, each, wanted) if each.rows else first_rows(self.recorded, each.file, wanted)
            for each in self.runs
        }
        self.clock(clock)
        if motion is not None:
            self.motion(motion, clock)
        load = more.get("normal_load") if force is not None and force.kind == "coefficient" else None
        for each in cut if force is None else [force]:
            self.force(each, motion, FRICTION if each is force else str(self.told.get(each.header, each.kind)), load)
        for name, column in more.items():
            if column is not None and column.header not in measured:
                self.plain(name, column)
        for name, header in self.answers.signals.items():
            if name not in {signal.name for signal in self.signals}:
                self.plain(name, self.columns[header])
        if self.questions:
            return None, self.questions
        trials, repeats = self.trials(motion, [column.header for column in beside])
        values = self.nominal(motion, force)
        return self.result(trials, "", (), "external" if motion is not None else "internal", values, repeats), []

    def leave_aside_what_runs_otherwise(self, clock: Meant) -> None:
        """Of the files that have no headers those whose clock, by another's, is none, or takes steps of another size."""
        recorded = self.recorded
        if not recorded.bare:
            return
        usual = self.usual_step(recorded.headed, clock.header)
        strange = [file for file in recorded.bare if not usual / ALIKE < self.usual_step(file, clock.header) < usual * ALIKE]
        bare, form = tuple(file for file in recorded.bare if file not in strange), recorded.sniffed.form
        self.recorded = replace(
            recorded,
            files=tuple(file for file in recorded.files if file not in strange),
            sniffed=replace(recorded.sniffed, form=form if bare else replace(form, columns=())),
            bare=bare,
            aside=(
                *recorded.aside,
                *(
                    f"{file}: it has no headers, and by those of {recorded.headed} its {clock.header!r} is no such clock"
                    for file in strange
                ),
            ),
        )

    def usual_step(self, file: str, header: str) -> float:
        """Of a column, in its first rows; nan where it does not hold two numbers."""
        try:
            steps = np.diff(first_rows(self.recorded, file, [header])[header])
        except ExperimentError:
            return math.nan
        return float(np.median(steps)) if steps.size else math.nan

    def trials(self, motion: Meant | None, beside: Sequence[str]) -> tuple[tuple[TrialGuess, ...], str]:
        told, repeats = named([each.name for each in self.runs])
        if counted := sorted({header for each in self.runs for header in each.rows}):
            self.look.append(f"recordings that stand in one file are told apart by the column {' and '.join(map(repr, counted))}")
        conditions = {file: each.condition for file, each in told.items()}
        if counted and motion is not None:  # a number that counts recordings does not say which of them repeat each other
            conditions, repeats = {each.name: PurePosixPath(each.name).stem for each in self.runs}, ""
        if not repeats and motion is not None and len(conditions) > 1:
            groups = repeating(self.rows, motion.header, self.is_position, beside, conditions)
            if len(set(groups.values())) < len(groups):
                conditions = by_what_they_share(conditions, groups)
                repeats = f"recordings as long, and with as fast a motion{' at as high a load' if beside else ''}, repeat each other"
        signals = {signal.name for signal in self.signals}
        needed = ("normal_load",) if motion is not None else SET
        trials = tuple(
            TrialGuess(
                each.file,
                conditions[each.name],
                {
                    name: number * affine(unit, kernel.variable(name).unit)[0]
                    for name, number, unit in told[each.name].values
                    if name in needed and name not in signals
                },
                each.rows,
            )
            for each in self.runs
        )
        if len(set(conditions.values())) == len(conditions):
            self.look.append("no repeats were seen; trials of one condition tell the noise, so give repeats the same condition")
        return trials, repeats

    def nominal(self, motion: Meant | None, force: Meant | None) -> dict[str, tuple[float, float, str]]:
        """Values, their relative standard deviations, and where they come from."""
        start = {variable.name: variable.start for variable in kernel.variables()}
        if motion is None or force is None:
            why = "the component's start, not from your data"
            if motion is not None:
                return {name: (start[name], UNKNOWN, why) for name in ("F_C", "F_S", "sigma2")}
            told = self.answers.signals
            kilohertz, *microns = start[VIBRATION[0]] / 1e3, *(start[name] * 1e6 for name in VIBRATION[1:])
            sizes = " and ".join(f"{each:g}" for each in microns)
            self.look.append(
                f"the tool vibrates as the component starts, at {kilohertz:g} kHz with amplitudes of {sizes} um, and its rake angle is "
                f"{start['rake_angle']:g}: put in yours; a tool that does not vibrate has amplitudes of 0"
            )
            sds = {**dict.fromkeys(("F_C", "F_S", "sigma2", "shear_stress"), UNKNOWN), **dict.fromkeys(SET, 0.1)}
            sds |= {name: 0.0 for name in (*VIBRATION, "rake_angle") if name not in told}
            return {name: (start[name], sd, why) for name, sd in sds.items()}
        by_name = {signal.name: signal.table for signal in self.signals}
        level = self.level(motion, force, by_name[FRICTION])
        if not level > 0:
            level = start["F_C"]
        return {
            "F_C": (float(f"{level:.3g}"), 0.3, "median of the force while it slides"),
            "F_S": (float(f"{1.15 * level:.3g}"), 0.3, "somewhat more than F_C"),
            "v_s": (start["v_s"], UNKNOWN, "the component's start, not from your data"),
            "sigma0": (
                float(f"{level / PRESLIDING:.3g}"),
                2 * UNKNOWN,
                "bristles that bend by 10 um, an order of magnitude: not from your data",
            ),
            "sigma1": (start["sigma1"], UNKNOWN, "the component's start, not from your data"),
            "sigma2": (start["sigma2"], UNKNOWN, "the component's start, not from your data"),
        }

    def level(self, motion: Meant, force: Meant, table: Mapping[str, Any]) -> float:
        """Median size of the friction force while it slides [N]."""
        _, forces = sliding(self.rows.values(), motion.header, self.is_position, force.header)
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
        used = {str(signal.table["column"]) for signal in self.signals} | {header for trial in trials for header in trial.rows}
        left = [f"column {header!r}" for header in self.columns if header not in used]
        names = tuple(self.signals)
        return Begun(
            self.recorded, names, trials, means, ignored, kinematics, values, repeats, (*left, *self.recorded.aside), tuple(self.look)
        )
