"""What does a file of averages hold? Rows of what varied, the means, and where known their standard deviations; rows of one condition are
replicates."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from evat.experiment import ExperimentError, Means, Signal
from evat.experiment.checks import SETTABLE
from evat.experiment.column import Column
from evat.experiment.columns import check_header, check_line_of_units, unreadable
from evat.experiment.document import MEAN, Document, TrialEntry, check_inputs
from evat.files.sniff import units_below
from evat.files.stream import headers
from evat.files.table import HEADER, Table, read_table, read_texts, unit_in
from evat.files.text import RecordError
from evat.model import Model, ParameterError, Variable
from evat.units import base_unit

CONDITION = "condition"  # header of the names of the conditions; without it they are named after what varied
SD = "_sd"  # a standard deviation is headed like its mean, with this at the end of the name
SAME = 1e-9  # relative: a trial and a row whose values agree like this were run at one condition


def read_means(document: Document, file: str, path: Path, model: Model) -> Means:
    """The averages of an experiment; ExperimentError where a column or a row cannot be used."""
    try:
        table = read_table(path, document.form)
        names = read_texts(path, CONDITION, document.form) if CONDITION in (*table.columns, *table.without_numbers) else None
    except RecordError as error:
        raise ExperimentError(unreadable(file, error)) from error
    by_name = {variable.name: variable for variable in model.variables}
    columns = _columns(document, file, path, table, by_name)
    checked = {
        column.name: replace(column, never_negative=False).checked(  # a mean below 0 is no noise
            file, np.arange(1, 1 + table.columns[column.header].size), table.columns[column.header]
        )
        for column in columns
    }
    outputs = {name: column for name, column in checked.items() if name in by_name and by_name[name].causality == "output"}
    sd = {name.removesuffix(SD): column for name, column in checked.items() if name not in by_name}
    values = {name: column for name, column in checked.items() if name in by_name and name not in outputs}
    if not outputs:
        raise ExperimentError(f"{file}: there is no column of averages; head at least one like {', '.join(_means(by_name)[:3])}.")
    for name in sd:
        if name not in outputs:
            raise ExperimentError(f"{file}: there is {name + SD} and no {name}; add the mean or remove its standard deviation.")
    check_inputs(model, document.nominal, values, file)
    count = next(iter(outputs.values())).size
    rows = [{name: float(column[row]) for name, column in values.items()} for row in range(count)]
    conditions = tuple(names) if names is not None else tuple(_condition(row, document.trials) for row in rows)
    for row, condition in enumerate(conditions):
        if not condition.strip():
            raise ExperimentError(f"{file}, data row {row + 1}: the condition has no name; give it one, or leave out the column.")
        first = conditions.index(condition)
        if first < row and any(not _close(rows[first][name], value) for name, value in rows[row].items()):
            raise ExperimentError(
                f"{file}, data row {row + 1}: the condition {condition!r} is in row {first + 1} already, at other values; rows of one "
                "condition are replicates. Give them different names, or correct the values."
            )
    return Means(file, conditions, values, outputs, sd)


def _columns(document: Document, file: str, path: Path, table: Table, by_name: Mapping[str, Variable]) -> list[Column]:
    """Which column is which variable: by a signal that names it, else by its header."""
    signals = {signal.column: signal for signal in document.signals.values()}
    columns: list[Column] = []
    if unknown := [header for header in document.ignored if header not in (*table.columns, *table.without_numbers)]:
        raise ExperimentError(f"{file}: means.ignore names {unknown[0]!r}, and there is no such column; correct or remove it.")
    below = units_below(path, document.form, headers(path, document.form))
    for header in (*table.columns, *table.without_numbers):
        if header == CONDITION or header in document.ignored:
            continue
        if header in table.without_numbers:
            raise ExperimentError(
                f"{file}, column {header!r}: not all of it is numbers. Numbers have a decimal point; nothing is filled in."
            )
        if header in signals:
            check_header(signals[header], file)
            check_line_of_units(signals[header], file, below.get(header, ""))
            name = signals[header].name
        else:
            name = _name(header)
        known = _known(file, header, name, by_name)
        try:
            column = _column(header, name, known, document.signals, signals)
        except ParameterError as error:
            raise ExperimentError(f"{file}, column {header!r}: {error}") from error
        if any(name == other.name for other in columns):
            raise ExperimentError(f"{file}, column {header!r}: there is another column of {name}; keep one.")
        columns.append(column)
    missing = [signal for signal in document.averaged if signal.column not in table.columns]
    for signal in missing:
        raise ExperimentError(
            f"{file}: there is no column {signal.column!r} for {signal.name}; it has {', '.join(map(repr, table.columns))}. "
            f"Name the right one as signals.{signal.name}.column."
        )
    return columns


def _column(header: str, name: str, known: Variable, by_name: Mapping[str, Signal], by_column: Mapping[str, Signal]) -> Column:
    """How a column is read: as its signal says, else by the unit in its header. ParameterError where a unit does not fit."""
    if header in by_column:
        if by_column[header].of:
            raise ParameterError(f"signals.{name}.from: an average is not differentiated; give the velocity, and remove it.")
        return Column.of_signal(by_column[header], known)
    stated, mean = unit_in(header), by_name.get(known.name)
    if name == known.name or mean is None:
        column = Column.of(header, name, stated or known.unit, known)
    elif stated is None or _alike(stated, mean.unit):  # a spread stands beside its mean in the file, before any scale
        column = replace(Column.of_signal(replace(mean, column=header, unit=stated or mean.unit), known), name=name)
    else:
        column = Column.of(header, name, stated, known)
    return column if name == known.name else replace(column, factor=abs(column.factor), offset=0.0, low=0.0)


def _alike(stated: str, unit: str) -> bool:
    """Whether both units measure the same kind of quantity; ParameterError where the stated one is none."""
    return base_unit(stated).exponents == base_unit(unit).exponents


def _known(file: str, header: str, name: str, by_name: Mapping[str, Variable]) -> Variable:
    """The variable of a column: something that can be set, a mean, or the mean that a standard deviation belongs to."""
    mean = name.removesuffix(SD) if name not in by_name else name
    known = by_name.get(mean)
    if known is not None and known.type == "real" and (mean in _means(by_name) or (mean == name and known.causality in SETTABLE)):
        return known
    settable = [other for other, variable in by_name.items() if variable.causality in SETTABLE]
    near = difflib.get_close_matches(name, [CONDITION, *settable, *_means(by_name)], n=3)
    hint = f"did you mean {', '.join(near)}? " if near else ""
    raise ExperimentError(
        f"{file}, column {header!r}: {name!r} is no number that can be set and no mean; {hint}Columns are {CONDITION}, values "
        f"set, means ({', '.join(_means(by_name))}) and means with {SD} at the end. Rename the column, or name it in means.ignore."
    )


def _name(header: str) -> str:
    match = HEADER.fullmatch(header)
    return header[: match.start("square" if match["square"] is not None else "round") - 1].strip() if match else header.strip()


def _means(by_name: Iterable[str]) -> list[str]:
    return [name for name in by_name if name.startswith(MEAN)]


def _condition(row: Mapping[str, float], trials: Iterable[TrialEntry]) -> str:
    """The name of the trials that were run at a row's values, else what varied."""
    same = {trial.condition for trial in trials if row and all(_close(trial.values.get(name), value) for name, value in row.items())}
    return same.pop() if len(same) == 1 else named_after(row)


def named_after(row: Mapping[str, float]) -> str:
    """What a condition is called that has no name: what varied, in SI."""
    return ", ".join(f"{name}={value:.6g}" for name, value in row.items()) or "all"


def _close(number: float | None, value: float) -> bool:
    return number is not None and math.isclose(number, value, rel_tol=SAME)
