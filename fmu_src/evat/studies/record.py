"""How well does the FMU follow a measured motion? Velocity in, friction force out, the residual in N and %."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evat.files.table import read_table
from evat.files.text import RecordError
from evat.model import FloatArray, ParameterError, Run, Trace
from evat.models.drive import Progress, drive

HALF_WINDOW = 2  # samples on each side of a velocity that is taken from positions


@dataclass(frozen=True, slots=True)
class Columns:
    """Headers of a record's columns. Velocity or position is needed; `force_sign` -1 turns a force that counts the other way."""

    time: str
    force: str
    velocity: str | None = None
    position: str | None = None
    force_sign: float = 1.0


@dataclass(frozen=True, slots=True)
class RecordComparison:
    """Measured against simulated: arrays of shape (n,), SI; residual_share is the residual's RMS over that of the measured force."""

    times: FloatArray
    velocity: FloatArray
    measured: FloatArray
    trace: Trace
    residual_rms: float
    residual_share: float


def velocity_from_position(times: FloatArray, position: FloatArray, half_window: int = HALF_WINDOW) -> FloatArray:
    """Slope of the position over 2 half_window + 1 samples by their own times, shape (n,); shorter windows at both ends.

    Raises RecordError where the record is shorter than one window.
    """
    count = times.size
    if count < 2 * half_window + 1:
        raise RecordError(f"the record has {count} samples; a velocity from positions needs at least {2 * half_window + 1}.")
    at = np.arange(count)
    before, after = np.maximum(at - half_window, 0), np.minimum(at + half_window, count - 1)
    return np.asarray((position[after] - position[before]) / (times[after] - times[before]))


def read_record(path: Path, columns: Columns, between: tuple[float, float] | None = None) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, slip velocity and friction force of a file, SI, shape (n,) each; optionally cut to `between` [s]."""
    table = read_table(path)
    times = table.clock(columns.time)
    force = columns.force_sign * table.column(columns.force, "N")
    if columns.velocity is not None:
        velocity = table.column(columns.velocity, "m/s")
    elif columns.position is not None:
        velocity = velocity_from_position(times, table.column(columns.position, "m"))
    else:
        raise ParameterError(f"{path.name}: name the column of the velocity or of the position; it has {', '.join(table.columns)}.")
    if between is not None:
        kept = (times >= between[0]) & (times <= between[1])
        if np.count_nonzero(kept) < 2:
            raise RecordError(f"{path.name}: fewer than 2 samples lie between {between[0]:g} and {between[1]:g} s.")
        times, velocity, force = times[kept], velocity[kept], force[kept]
    return times, velocity, force


def follow_record(
    fmu: Path,
    path: Path,
    columns: Columns,
    values: Mapping[str, float | str],
    effects: Sequence[str] = (),
    *,
    between: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> RecordComparison:
    """Drive the FMU with a measured motion and compare its friction force with the measured one.

    Raises
    ------
    RecordError, where the file does not hold the columns; ParameterError, FmuError, SimulationError as `drive` does.
    """
    times, velocity, measured = read_record(path, columns, between)
    switched: dict[str, float | str | bool] = {**values, **dict.fromkeys(effects, True), "kinematics": "external"}
    run = Run(times, {"slip_velocity": velocity}, ("friction_force", "bristle_deflection", "clamped_count"))
    trace = drive(fmu, run, switched, progress=progress)
    residual = trace["friction_force"] - measured
    scale = float(np.sqrt(np.mean(measured**2)))
    if scale == 0:
        raise RecordError(f"{path.name}: the measured force is zero throughout.")
    rms = float(np.sqrt(np.mean(residual**2)))
    return RecordComparison(times, velocity, measured, trace, rms, rms / scale)
