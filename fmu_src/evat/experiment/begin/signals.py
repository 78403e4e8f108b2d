"""How is each signal read? Its column, unit, sign and scale, as a table of the experiment.toml."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from evat.experiment import ExperimentError
from evat.experiment.begin.columns import RecordedColumns
from evat.experiment.begin.files import Recordings
from evat.experiment.begin.sliding import ALIKE, with_direction
from evat.experiment.begin.understood import Answers, Question, SignalGuess
from evat.experiment.begin.words import Meant
from evat.experiment.document import CLOCK, TRIGGER
from evat.experiment.remarks import unwrapped
from evat.model import FloatArray, ParameterError
from evat.native import kernel
from evat.required_inputs import MOTION
from evat.units import affine, base_unit

AGAINST = -0.3  # correlation of force and direction below which the sensor counts the other way


class Signals(RecordedColumns):
    """`signals` as far as they are known; `rows` are the first of each recording, by file and column."""

    def __init__(self, recorded: Recordings, answers: Answers) -> None:
        super().__init__(recorded, answers)
        self.signals: list[SignalGuess] = []
        self.rows: dict[str, dict[str, FloatArray]] = {}

    @property
    def is_position(self) -> bool:
        """Whether the motion was recorded as a position."""
        return any(signal.name == MOTION and signal.table.get("from") == "position" for signal in self.signals)

    def clock(self, column: Meant) -> None:
        steps = np.concatenate([np.diff(rows[column.header]) for rows in self.rows.values()])
        step = float(np.median(steps)) if steps.size else 0.0
        if not step > 0:
            raise ExperimentError(f"column {column.header!r} was taken for the clock and does not increase; use --signal {CLOCK}=COLUMN.")
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
            if of and radial:
                turn = math.tau / affine(unit, "rad")[0]
                self.rows = {file: {**rows, column.header: unwrapped(rows[column.header], turn)} for file, rows in self.rows.items()}
            if radial:
                table["radius"] = self.radius(f"{column.header!r} is in {unit}")
        self.signals.append(SignalGuess(MOTION, table, self.why(MOTION, column)))

    def dimension(self, column: Meant, unit: str, allowed: Mapping[str, Any]) -> Any:
        for base, what in allowed.items():
            if base_unit(unit).exponents == base_unit(base).exponents:
                return what
        raise ExperimentError(
            f"column {column.header!r} is in {unit}; for what it was taken for, allowed is {' or '.join(allowed)}. Use --signal or --unit."
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
            together = with_direction(self.rows.values(), motion.header, self.is_position, column.header)
            more = f"correlation with the direction of motion {together:.2f}" if math.isfinite(together) else ""
            if together < AGAINST:
                table["sign"] = -1
                self.look.append(
                    f"{column.header!r} runs against the motion, so its sign was turned; friction is positive in positive slip"
                )
            elif abs(together) <= -AGAINST:
                self.look.append(f"{column.header!r} hardly follows the direction of motion: is it friction?")
        self.signals.append(SignalGuess(name, table, self.why(name, column, more)))

    def constant_load(self, column: Meant, load: Meant) -> float:
        """By which a friction coefficient becomes a force [N]."""
        loads = np.concatenate([rows[load.header] for rows in self.rows.values()]) * affine(self.unit(load, "N"), "N")[0]
        least, most = float(loads.min()), float(loads.max())
        if not most - least <= ALIKE * most:
            raise ExperimentError(
                f"{column.header!r} is a friction coefficient, and {load.header!r} goes from {least:.4g} to {most:.4g} N; a force is "
                "needed. Add a column of the friction force, or use --motor-constant 'LOAD N' for a load that all recordings share."
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


def base_name(unit: str) -> str:
    """A unit's own SI unit, for the denominator of a motor constant: A of mA; "1" of a pure number."""
    exponents = base_unit(unit or "1").exponents
    return next((base for base in ("A", "V") if base_unit(base).exponents == exponents), "1")
