"""Does a trial repeat itself, and after how many samples? From the model's own cycle, or from the inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment.periods import period
from evat.inference.prediction import Prediction
from evat.model import FloatArray


@dataclass(frozen=True, slots=True)
class OtherFrequency:
    """Of a recording `file`: the frequency at which its forces come back, and at which its tool is said to vibrate [Hz]; and by how many
    cycles these come apart in it."""

    file: str
    measured: float
    stated: float
    apart: float

    def __str__(self) -> str:
        return (
            f"{self.file}: the force comes back at {self.measured:.5g} Hz, and the tool is said to vibrate at {self.stated:.5g} Hz: by its "
            f"end they are {self.apart:.2g} cycles apart; state the frequency as it was, or mend the clock"
        )


def other_frequency(prediction: Prediction) -> OtherFrequency | None:
    """Where what was recorded of a tool that vibrates comes back at another frequency than it is said to; None where it does not, or where
    no recording has enough cycles to tell. What one clock or one generator has wrong it has wrong in all trials by the same share."""
    courses, longest, file, stated = list[tuple[FloatArray, FloatArray]](), 0.0, "", math.nan
    for segment in prediction.segments:
        if segment.trial < 0:
            continue
        trial = prediction.experiment.trials[segment.trial]
        period_stated = prediction.model.cycle_time({**prediction.nominal, **trial.values})
        cycles = (trial.times - trial.times[0]) / period_stated if math.isfinite(period_stated) else np.zeros(1)
        column = prediction.measured[segment.at]
        if cycles[-1] < CONSTANTS.cycles_to_see_a_frequency or not np.ptp(column) > 0:
            continue
        courses.append((cycles, (column - column.mean()) / np.std(column)))
        if cycles[-1] > longest:
            longest, file, stated = float(cycles[-1]), trial.file, 1 / period_stated
    if not courses or np.mean([_left_by_cycles(*course) for course in courses]) < CONSTANTS.left_by_cycles:
        return None
    finest = CONSTANTS.phase_apart / (2 * longest)  # half of what is told
    steps = min(math.ceil(CONSTANTS.frequency_range / finest), CONSTANTS.frequencies_tried)
    shares = finest * np.arange(-steps, steps + 1)
    left = np.array([sum(_left_by_cycles((1 + share) * cycles, column) for cycles, column in courses) for share in shares])
    best = int(np.argmin(left))
    apart = float(abs(shares[best])) * longest
    if not apart > CONSTANTS.phase_apart or not left[steps] > CONSTANTS.clearer_frequency * left[best] or best in (0, 2 * steps):
        return None
    return OtherFrequency(file, (1 + float(shares[best])) * stated, stated, apart)


def _left_by_cycles(cycles: FloatArray, column: FloatArray) -> float:
    """The mean square of a column (n,) that the first harmonics of so many cycles (n,) leave."""
    angles = 2 * np.pi * np.outer(cycles, np.arange(1, CONSTANTS.frequency_harmonics + 1))
    waves = np.column_stack([np.ones(cycles.size), np.cos(angles), np.sin(angles)])
    fitted = waves @ np.linalg.lstsq(waves, column, rcond=None)[0]
    return float(np.mean((column - fitted) ** 2))


def cycle_time(prediction: Prediction, place: int) -> float:
    """Period [s] of the motion in a trial; nan where it has none, or fewer than two."""
    trial = prediction.experiment.trials[place]
    own = prediction.model.cycle_time({**prediction.nominal, **trial.values})
    if math.isfinite(own):
        return own
    step = trial.sampling_interval
    columns = [column - column.mean() for column in trial.inputs.values() if np.ptp(column) > 0]
    if not columns or trial.times.size < 16:
        return math.nan
    lag = max(period(column) for column in columns)
    return lag * step if lag > 0 else math.nan


def cycle_samples(prediction: Prediction, place: int) -> float:
    """The same in samples; 0 where there is none."""
    trial = prediction.experiment.trials[place]
    cycle = cycle_time(prediction, place)
    if not math.isfinite(cycle) or trial.times.size < 16:
        return 0.0
    samples = cycle / trial.sampling_interval
    return samples if 2 < samples <= trial.times.size / 1.5 else 0.0
