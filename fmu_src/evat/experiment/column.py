"""What is one column of a data file: which variable, in which unit, within which bounds? And are its numbers fit to be used?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from evat.experiment import ExperimentError, Signal
from evat.experiment.checks import MOST
from evat.experiment.document import CLOCK, to_variable, turn_of
from evat.model import FloatArray, IntArray, Variable
from evat.units import affine


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a file: the variable `name` in `si` = factor * value in the file + offset, between `low` and `high`; where it
    is derived from the column, it lies between `variable_low` and `variable_high` itself. Of a signal also its range to both sides
    (`full_scale`), a whole `turn` of an angle that is differentiated, and how far the zero of an input may be off (`zero_sd`), SI; None
    where there is none, or nobody said. An input that is `never_negative` is recorded with noise, and so below 0 none the less."""

    header: str
    name: str
    unit: str
    factor: float
    offset: float
    si: str
    low: float
    high: float
    variable_low: float = -np.inf
    variable_high: float = np.inf
    slack: float = 0.0  # how far outside the bounds a value may lie: see Variable
    full_scale: float | None = None
    turn: float | None = None
    zero_sd: float | None = None
    never_negative: bool = False

    @classmethod
    def of_signal(cls, signal: Signal, known: Variable | None) -> Column:
        """The column of a signal; a position has no bounds."""
        plain = "s" if signal.name == CLOCK else signal.unit
        si, low, high = (known.unit, known.min, known.max) if known else (plain, -np.inf, np.inf)
        own = (low, high)
        if signal.of:
            low, high = -np.inf, np.inf
        slack = known.slack if known else 0.0
        return cls(
            signal.column,
            signal.name,
            signal.unit,
            *to_variable(signal, si),
            si,
            low,
            high,
            *own,
            slack,
            signal.full_scale,
            turn_of(signal),
            never_negative=signal.role == "input" and low == 0,
        )

    @classmethod
    def of(cls, header: str, name: str, unit: str, known: Variable | None) -> Column:
        """The column of a variable, or of the clock where there is none; ParameterError where the unit does not fit."""
        si, low, high = (known.unit, known.min, known.max) if known else ("s", -np.inf, np.inf)
        return cls(header, name, unit, *affine(unit, si), si, low, high, slack=known.slack if known else 0.0)

    def checked(self, file: str, rows: IntArray, raw: FloatArray) -> FloatArray:
        """The column in SI; an error names the row (of `rows`, from 1) of what is no number or lies outside the variable's bounds."""
        with np.errstate(over="ignore"):  # what is too large is told below, by its row
            column = raw if (self.factor, self.offset) == (1, 0) else raw * self.factor + self.offset
        low, high = float(column.min()), float(column.max())
        if not (np.isfinite(low) and np.isfinite(high)):
            place = int(np.argmin(np.isfinite(column)))
            row = rows[place]
            if np.isfinite(raw[place]):
                self._too_large(file, row, float(raw[place]))
            raise ExperimentError(
                f"{file}, column {self.header!r}, data row {row}: no finite number. Nothing is filled in; correct or cut it."
            )
        least, most = self.low - self.slack, self.high + self.slack
        if (low < least and not self.never_negative) or high > most:
            place = int(np.argmax((column < least) | (column > most)))
            raise ExperimentError(
                f"{file}, column {self.header!r}, data row {rows[place]}: {self.name} = {column[place]:g} {self.si}; allowed is "
                f"{self.low:g} to {self.high:g} {self.si}. Its unit is given as {self.unit}: is that right?"
            )
        if self.low == -np.inf and self.name != CLOCK and max(-low, high) > MOST:
            place = int(np.argmax(np.abs(column) > MOST))
            self._too_large(file, rows[place], float(raw[place]))
        return column

    def _too_large(self, file: str, row: int, value: float) -> NoReturn:
        raise ExperimentError(
            f"{file}, column {self.header!r}, data row {row}: {value:g} {self.unit}; {self.name} of more than {MOST:g} {self.si} is no "
            "measurement. Does it stand for a missing value, or is the unit or the scale wrong? Nothing is filled in; correct or cut it."
        )
