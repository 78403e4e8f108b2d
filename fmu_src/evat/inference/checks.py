"""Can a measurement be compared with a model at all? Sign, unit, clock: what would make every later number nonsense."""

from __future__ import annotations

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import FEWEST_ROWS, Experiment, ExperimentError
from evat.model import FloatArray


def check_clocks(experiment: Experiment) -> None:
    """ExperimentError where a clock jumps: between the samples the inputs would be made up."""
    for trial in experiment.trials:
        check_rows(trial.file, trial.times.size)
        steps = np.diff(trial.times)
        longest, shortest, usual = int(np.argmax(steps)), int(np.argmin(steps)), float(np.median(steps))
        check_gap(trial.file, float(steps[longest]), usual, longest + 1, float(trial.times[longest]))
        check_crowd(trial.file, float(steps[shortest]), usual, shortest + 1)


def check_rows(file: str, rows: int) -> None:
    """ExperimentError where a recording has too few samples to have a usual step."""
    if rows < FEWEST_ROWS:
        raise ExperimentError(f"{file}: it has {rows} rows; a recording has at least {FEWEST_ROWS}.")


def check_gap(file: str, longest: float, usual: float, sample: int, time: float) -> None:
    """ExperimentError where the longest step of a clock, after that sample, is no step but a gap."""
    if longest > CONSTANTS.clock_gap * usual:
        raise ExperimentError(
            f"{file}: the clock jumps by {longest:.4g} s after sample {sample} (t = {time:.6g} s), "
            f"its usual step is {usual:.4g} s. What moved in between is not known: cut the file there into two trials."
        )


def check_crowd(file: str, shortest: float, usual: float, sample: int) -> None:
    """ExperimentError where the shortest step of a clock, after that sample, is none that a clock tells."""
    if shortest < CONSTANTS.finest_step * usual:
        raise ExperimentError(
            f"{file}: samples {sample} and {sample + 1} are {shortest:.4g} s apart, the usual step of the clock is {usual:.4g} s: no clock "
            "tells them apart. Correct the times, or leave out one of the two."
        )


def opposed(measured: FloatArray, simulated: FloatArray) -> float | None:
    """The correlation (about zero) of a measured channel (n,) with the simulated one where it says that a sign is turned; else None."""
    both = float(np.sqrt(np.sum(measured**2) * np.sum(simulated**2)))
    cosine = float(np.sum(measured * simulated)) / both if both > 0 else 0.0
    return cosine if cosine < CONSTANTS.opposed_correlation else None


def unit_ratio(measured: FloatArray, simulated: FloatArray) -> float | None:
    """The rms of a measured channel (n,) over that of the simulated one where it says that a unit is wrong; else None. inf where the
    simulated one is zero."""
    ours, theirs = rms(measured), rms(simulated)
    ratio = ours / theirs if theirs > 0 else np.inf
    return None if 1 / CONSTANTS.wrong_unit_ratio < ratio < CONSTANTS.wrong_unit_ratio else ratio


def rms(column: FloatArray) -> float:
    return float(np.sqrt(np.mean(column**2)))
