"""What did a velocity read where the contact rested? There it shows its zero."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, SetupSd
from evat.model import FloatArray
from evat.required_inputs import MOTION


@dataclass(frozen=True, slots=True)
class Rest:
    """What a recorded velocity reads of a contact at rest: its `level`, and the `largest` value."""

    level: float
    largest: float


def sd_of_zero(experiment: Experiment, name: str) -> float:
    """How far the zero of a recorded input may be off, as its owner says, else as rigs are."""
    columns = [trial.inputs[name] for trial in experiment.trials if name in trial.inputs]
    stated = experiment.setup_sd.get(name, SetupSd()).zero
    return stated if stated is not None else SetupSd.ZERO_OF_RMS * float(np.sqrt(np.mean(np.concatenate(columns) ** 2)))


def rests(experiment: Experiment) -> dict[str, Rest]:
    """By the trial's file, where the contact rested and its velocity was recorded, not differentiated from a position."""
    trials = [trial for trial in experiment.trials if MOTION in trial.inputs]
    signal = experiment.signals.get(MOTION)
    if not trials or (signal is not None and signal.of):
        return {}
    widest = CONSTANTS.widest_setup_error * sd_of_zero(experiment, MOTION)
    return {trial.file: rest for trial in trials if (rest := _rest(trial.inputs[MOTION], widest)) is not None}


def _rest(velocity: FloatArray, widest: float) -> Rest | None:
    """The flattest part of a recording (n,) that is as near to 0 as rest may be recorded; None where there is no such part."""
    size = math.ceil(CONSTANTS.least_rest * velocity.size)
    if size < CONSTANTS.fewest_rest_samples or velocity.size < size:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(velocity, size)
    low, high = windows.min(axis=1), windows.max(axis=1)
    largest = np.maximum(np.abs(low), np.abs(high))
    flattest = int(np.argmin(np.where(largest <= CONSTANTS.nearest_rest * widest, high - low, np.inf)))
    near = largest[flattest] <= CONSTANTS.nearest_rest * widest and (high - low)[flattest] <= CONSTANTS.flat_rest * widest
    if not near:
        return None
    # It goes on as far as the velocity stays about as flat: the longer, the better its level is known.
    middle, reach = windows[flattest].mean(), (high - low)[flattest]
    apart = np.flatnonzero(np.abs(velocity - middle) > reach)
    begin = max(apart[apart < flattest], default=-1) + 1
    end = min(apart[apart >= flattest + size], default=velocity.size)
    return Rest(float(velocity[begin:end].mean()), float(largest[flattest]))
