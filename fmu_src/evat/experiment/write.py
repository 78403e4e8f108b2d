"""How is an experiment written, so that reading it gives the same again? A folder that appears whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import tomlkit

from evat import parameter_sets
from evat.experiment import Experiment, ExperimentError, Means, Nominal, SetupSd, Signal, Trial
from evat.experiment.document import CLOCK, FILE, FORMAT, TRIGGER
from evat.experiment.means import CONDITION, SD
from evat.experiment.nominal import CHOICES, INITIAL_BRISTLE
from evat.files.table import write_columns
from evat.files.writing import as_output_error, scratch, usable
from evat.model import FloatArray
from evat.native import kernel
from evat.units import affine

SUFFIXES = (".csv", ".parquet")
BELIEVED = Nominal({}, (), {})  # what a document says that says nothing of it


def write_experiment(experiment: Experiment, folder: str | PathLike[str], *, suffix: str = ".csv") -> Path:
    """Write a folder that `read_experiment` reads back; it appears whole or not at all.

    Parameters
    ----------
    experiment : Experiment
        What to write. The nominal values are written in full beside the name of a shipped set.
    folder : path
        A new folder, or an empty one.
    suffix : ".csv" or ".parquet"
        Of the data files.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    ExperimentError
        Where something recorded has no signal, or the folder holds something already.
    OutputError
        Where it cannot be written. Nothing is left behind then.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=2, speeds=[0.5], rate=100.0)
    >>> sorted(path.name for path in evat.write_experiment(made, "ramps").iterdir())
    ['experiment.toml', 'trials']
    """
    folder = Path(folder)
    if suffix not in SUFFIXES:
        raise ExperimentError(f"suffix {suffix!r}: data files are written as {' or '.join(SUFFIXES)}.")
    recorded = {key for trial in experiment.trials for key in (CLOCK, *trial.inputs, *trial.outputs)}
    signals = {name: _as_it_is(signal) for name, signal in experiment.signals.items() if name != TRIGGER}
    if any(trial.lead_in is not None for trial in experiment.trials):
        signals[TRIGGER] = Signal(TRIGGER, TRIGGER, "1", None)
    experiment = replace(experiment, signals=signals)
    if unsigned := sorted(recorded - set(experiment.signals)):
        raise ExperimentError(f"{', '.join(unsigned)}: recorded, but no signal gives its column and unit; add a Signal for each.")
    with new_folder(folder) as made:
        _write(experiment, made, suffix)
    return folder


def check_new(folder: Path) -> None:
    """ExperimentError where there is something already, OutputError where nothing can be written: asked before the work."""
    _check_free(folder)
    usable(folder.parent)


def _check_free(folder: Path) -> None:
    with as_output_error(folder):
        if folder.is_symlink() or (folder.exists() and (not folder.is_dir() or any(folder.iterdir()))):
            raise ExperimentError(f"{folder}: there is something already, and measurements are not overwritten; name a new folder.")


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """A place to write a folder in, which becomes `folder` where the block ends well; ExperimentError where there is something already."""
    _check_free(folder)
    with as_output_error(folder), scratch(folder.parent) as beside:
        made = beside / "experiment"
        made.mkdir()
        yield made
        if folder.exists():
            folder.rmdir()
        os.replace(made, folder)


def _write(experiment: Experiment, folder: Path, suffix: str) -> None:
    document = tomlkit.document()
    document["format"] = FORMAT
    document["title"] = experiment.title
    if experiment.intended_use:
        document["intended_use"] = experiment.intended_use
    document["nominal"] = _nominal(experiment.nominal)
    if experiment.signals:
        document["signals"] = {name: _signal(signal) for name, signal in experiment.signals.items()}
    names: set[str] = set()
    if experiment.setup_sd:
        document["setup_sd"] = {name: _setup_sd(stated, name, experiment.signals) for name, stated in experiment.setup_sd.items()}
    document.add(tomlkit.nl())
    with_lead_in = any(trial.lead_in is not None for trial in experiment.trials)
    if experiment.trials:
        document["trials"] = trials = tomlkit.aot()
    for trial in experiment.trials:
        name = _file(trial.file, suffix, names)
        columns = _columns(trial, with_lead_in)
        write_columns(
            {experiment.signals[key].column: _typed(experiment.signals[key], column) for key, column in columns.items()}, folder / name
        )
        entry = tomlkit.table()
        entry.update({"file": name, "condition": trial.condition})
        if trial.values:
            entry["values"] = tomlkit.inline_table()
            entry["values"].update(_numbers(trial.values))
        if trial.noise_sd:
            entry["noise_sd"] = tomlkit.inline_table()
            entry["noise_sd"].update(_numbers(trial.noise_sd))
        trials.append(entry)
    if experiment.means is not None:
        name = _file(experiment.means.file, suffix, names)
        write_columns(_means(experiment.means, experiment.signals), folder / name)
        document["means"] = {"file": name}
    (folder / FILE).write_text(tomlkit.dumps(document), encoding="utf-8", newline="\n")


def _columns(trial: Trial, with_lead_in: bool) -> dict[str, FloatArray]:
    """Of all rows, those before the trial too, where any trial has such: then the trigger says which count."""
    own = {CLOCK: trial.times, **trial.inputs, **trial.outputs}
    if not with_lead_in:
        return own
    own[TRIGGER] = np.ones(trial.times.size)
    if (lead := trial.lead_in) is None:
        return own
    before = {CLOCK: lead.times, **lead.inputs, **lead.outputs, TRIGGER: np.zeros(lead.times.size)}
    return {name: np.concatenate([before[name], column]) for name, column in own.items()}


def _nominal(nominal: Nominal) -> dict[str, Any]:
    keys = {variable: key for key, variable in CHOICES.items()}
    table: dict[str, Any] = {keys[name]: value for name, value in nominal.values.items() if name in keys}
    if nominal.parameters in parameter_sets.names():
        table["parameters"] = nominal.parameters
    values = {name: value for name, value in nominal.values.items() if name not in keys}
    relative_sd = dict(nominal.relative_sd)
    if nominal.default_relative_sd != BELIEVED.default_relative_sd:
        known = {name: nominal.known_to(kernel.variable(name)) for name, value in values.items() if not isinstance(value, str)}
        relative_sd = known | relative_sd
    table["effects"] = list(nominal.effects)
    if nominal.initial_bristle != BELIEVED.initial_bristle:
        table[INITIAL_BRISTLE] = nominal.initial_bristle
    table |= {"values": _numbers(values)} if values else {}
    return table | ({"relative_sd": _numbers(relative_sd)} if relative_sd else {})


def _setup_sd(stated: SetupSd, name: str, signals: Mapping[str, Signal]) -> dict[str, float]:
    """What was stated, in the units of the signals."""
    entries = {} if kernel.variable(name).causality == "input" else {"gain": stated.gain, "clock_drift": stated.clock_drift}
    for key, value, unit in (("zero", stated.zero, name), ("clock", stated.clock, CLOCK)):
        if value is not None:
            entries[key] = _difference(signals[unit], value) if unit in signals else value
    return entries


def _as_it_is(signal: Signal) -> Signal:
    """What was converted where it was read is written as the variable itself, in SI; its offset stays where the sensor's range, which lies
    to both sides of it, is known."""
    if not signal.converted:
        return signal
    offset = signal.offset if signal.full_scale is not None else 0.0
    return Signal(signal.name, signal.name, kernel.variable(signal.name).unit, signal.role, signal.full_scale, offset=offset)


def _signal(signal: Signal) -> dict[str, Any]:
    table: dict[str, Any] = {"column": signal.column, "unit": signal.unit}
    if signal.role is not None:
        table["role"] = signal.role
    if signal.full_scale is not None:
        table["full_scale"] = _difference(signal, signal.full_scale)
    if signal.offset:
        table["offset"] = float(signal.offset)
    return table


def _typed(signal: Signal, column: FloatArray) -> FloatArray:
    """The column in the unit that its document states."""
    if signal.name == TRIGGER:
        return column
    factor, offset = _to_typed(signal)
    offset -= factor * signal.offset
    return column if (factor, offset) == (1, 0) else column * factor + offset


def _difference(signal: Signal, value: float) -> float:
    """A difference of the variable, such as a standard deviation, in the unit that its document states, wherever that begins to count."""
    factor, _ = _to_typed(signal)
    return float(value * factor)


def _to_typed(signal: Signal) -> tuple[float, float]:
    return affine("s" if signal.name == CLOCK else kernel.variable(signal.name).unit, signal.unit)


def _means(means: Means, signals: Mapping[str, Signal]) -> dict[str, FloatArray | Sequence[str]]:
    columns: dict[str, FloatArray | Sequence[str]] = {CONDITION: list(means.conditions)}
    for name, column in {**means.values, **means.outputs}.items():
        if name in signals:
            columns[signals[name].column] = _typed(signals[name], column)
        else:
            columns[f"{name} [{kernel.variable(name).unit}]"] = column
    return columns | {f"{name}{SD} [{kernel.variable(name).unit}]": column for name, column in means.sd.items()}


def _numbers(values: Mapping[str, float | str]) -> dict[str, float | str]:
    """Plain numbers and texts, without the types of other libraries."""
    return {name: value if isinstance(value, str) else float(value) for name, value in values.items()}


def _file(file: str, suffix: str, names: set[str]) -> str:
    """The name of a data file in the folder; it is kept, but for the suffix."""
    path = PurePosixPath(file).with_suffix(suffix)
    if path.is_absolute() or ".." in path.parts or "\\" in file:
        raise ExperimentError(f"file {file!r}: data files lie inside the experiment's folder.")
    if str(path) in names or str(path) == FILE:
        raise ExperimentError(f"file {file!r}: there are two files of the name {path}; name them apart.")
    names.add(str(path))
    return str(path)
