"""What do folders look like as laboratories leave them? Three, made of simulated tests, with the names, marks and files that people use.

They were written down before anything that reads them was.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from evat.experiment import Experiment
from evat.studies.orthogonal import orthogonal
from numpy.typing import NDArray

TRUTH: Mapping[str, float | str] = {
    "friction_law": "lugre", "F_C": 8.0, "F_S": 9.5, "v_s": 0.01, "sigma0": 1e5, "sigma1": 30.0, "sigma2": 2.0,
}  # fmt: skip
ASYMMETRIC = ("direction_asymmetry",)
Columns = Sequence[NDArray[np.float64]]


def _rows(columns: Columns, digits: Sequence[int]) -> list[list[str]]:
    return [[f"{value:.{places}f}" for value, places in zip(row, digits, strict=True)] for row in zip(*columns, strict=True)]


def simulated(effects: Sequence[str] = (), *, rate: float = 20.0, speeds: Sequence[float] = (0.05, 0.5), seed: int = 1) -> Experiment:
    return orthogonal(TRUTH, effects, motion="reversal", repeats=2, speeds=list(speeds), rate=rate, seed=seed)


def german_rig(folder: Path) -> Path:
    """A tribometer's export: semicolons, decimal comma, cp1252, names in one line and units in the next, a remark that is no number."""
    folder.mkdir(parents=True)
    made = simulated(ASYMMETRIC)
    for trial, name in zip(made.trials, ("langsam_Nr1", "langsam_Nr2", "schnell_Nr1", "schnell_Nr2"), strict=True):
        housing = 23.4 + 0.01 * trial.times
        rows = _rows((trial.times, 1e3 * trial.inputs["slip_velocity"], trial.outputs["friction_force"], housing), (4, 4, 5, 2))
        lines = ["Zeit;Gleitgeschwindigkeit;Reibkraft;Temperatur Gehäuse;Bemerkung", "s;mm/s;N;°C;"]
        lines += [";".join(cell.replace(".", ",") for cell in row) + ";" for row in rows]
        (folder / f"Versuch_Kupfer_{name}.csv").write_bytes(("\r\n".join(lines) + "\r\n").encode("cp1252"))
    return folder


def named_runs(folder: Path) -> Path:
    """A logger's files: ms and mm/s in the names of the columns, the load and the repeat in the names of the files, a BOM in front."""
    folder.mkdir(parents=True)
    made = simulated(rate=40.0)
    for trial, name in zip(made.trials, ("run_50N_rep1", "run_50N_rep2", "run_80N_rep1", "run_80N_rep2"), strict=True):
        load = float(name.split("_")[1].removesuffix("N")) + 0 * trial.times
        rows = _rows((1e3 * trial.times, 1e3 * trial.inputs["slip_velocity"], trial.outputs["friction_force"], load), (2, 4, 5, 1))
        lines = ["time_ms,velocity_mm/s,friction_force_N,normal_force_N", *(",".join(row) for row in rows)]
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8-sig")
    (folder / "notes.md").write_text("Tuesday: changed the specimen after run_50N_rep2.\n", encoding="utf-8")
    return folder


RADIUS, TORQUE_CONSTANT = 0.02, 0.5  # m, N.m/A


def driven_axis(folder: Path) -> Path:
    """A servo's trace: tabs, lines of remarks above, the motor's angle and current, the clock last."""
    folder.mkdir(parents=True)
    made = simulated(rate=200.0)
    for trial, name in zip(made.trials, ("axis_slow_01", "axis_slow_02", "axis_fast_01", "axis_fast_02"), strict=True):
        speed = trial.inputs["slip_velocity"]
        way = np.concatenate(([0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(trial.times))))
        angle = np.degrees(way / RADIUS)
        current = trial.outputs["friction_force"] * RADIUS / TORQUE_CONSTANT
        rows = _rows((angle, current, trial.times), (6, 6, 5))
        lines = [
            "# Servo trace, drive X1",
            "# exported 12.03.",
            "Motor angle [deg]\tMotor current [A]\tt [s]",
            *("\t".join(row) for row in rows),
        ]
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder
