"""At which frequencies, or over which ways, does what a model leaves go up and down? The highest peaks of its periodogram.

A sine of unknown frequency has as many likelihood maxima as the record has periods: no design of a few points meets the right one. Lomb
1976 and Scargle 1982: the peaks of a least-squares periodogram do. Over the position it tells of what stands still there, as it is and
turned with the motion, since a friction that rises and falls does so against it. Where a motion begins, and when a record does within a
hum, nobody may know: each condition, and each trial where repeats do not share it, then has a phase of its own. Phases are told from where
the model counts them, which the clock of the file and the lead-in before a recording say.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.signal import find_peaks

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Trial
from evat.inference.band_whitening import BandWhitening
from evat.inference.prediction import Prediction, with_lead_in
from evat.model import FloatArray
from evat.required_inputs import MOTION

TIME, WAY = "Hz", "m"  # units of what is told: a frequency over time, a period over the position


@dataclass(frozen=True, slots=True)
class Peak:
    """`value` is a frequency [Hz] or a period [m]; `phases` [rad] by condition or file, beside that of the first; empty where all share
    one."""

    value: float
    phases: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Course:
    """What is left, by the noise (n,), over time or position (n,), in a condition or trial `key`; `turned` with the motion or not."""

    key: str
    place: FloatArray
    left: FloatArray
    turned: bool


def peaks(prediction: Prediction, whitening: BandWhitening, predicted: FloatArray, unit: str, fewest: float) -> list[Peak]:
    """The highest peaks, the highest first, each with one phase for all and with phases of their own; empty where no motion was recorded or
    nothing is left.

    predicted : (N,), of the model whose residual is looked at; fewest : periods within the longest recording, or its way.
    """
    courses = _courses(prediction, whitening, predicted, unit)
    longest = max((float(np.ptp(course.place)) for course in courses), default=0.0)
    if longest <= 0:
        return []
    finest = max(float(np.ptp(c.place)) / max(float(np.median(np.abs(np.diff(c.place)))), 1e-9 * longest) for c in courses) / 2
    most = int(min(finest, CONSTANTS.periodogram_periods if unit == WAY else CONSTANTS.periodogram_lines))
    numbers = np.arange(int(4 * fewest), 4 * max(most, 1) + 1) / (4 * longest)  # four to a period of the longest
    if not numbers.size:
        return []
    keys = list(dict.fromkeys(course.key for course in courses))
    ways = [{key: _components([c for c in courses if c.key == key and c.turned == way], numbers) for key in keys} for way in (False, True)]
    powers = np.array([np.sum([2 * np.abs(c) ** 2 / max(n, 1) for c, n in each.values()], axis=0) for each in ways])
    power, way_of = powers.max(axis=0), powers.argmax(axis=0)
    tops = find_peaks(np.concatenate([[0.0], power, [0.0]]))[0] - 1
    highest = list[Peak]()
    for top in tops[np.argsort(-power[tops], kind="stable")][: CONSTANTS.periodogram_peaks]:
        turned = bool(way_of[top])
        number = np.array([_vertex(numbers, powers[int(turned)], int(top))])
        value = float(number[0] if unit == TIME else 1 / number[0])
        angles = {
            key: float(np.angle(_components([c for c in courses if c.key == key and c.turned == turned], number)[0][0])) for key in keys
        }
        first = next(iter(angles.values()))
        highest.append(Peak(value))
        if len(angles) > 1:
            highest.append(Peak(value, {key: (angle - first + np.pi) % (2 * np.pi) - np.pi for key, angle in angles.items()}))
    return highest


def _courses(prediction: Prediction, whitening: BandWhitening, predicted: FloatArray, unit: str) -> list[_Course]:
    courses = list[_Course]()
    for place, group in enumerate(whitening.groups):
        segment = prediction.segments[group.members[0]]
        if segment.trial < 0:
            continue
        trial = prediction.experiment.trials[segment.trial]
        key = trial.file if prediction.apart and unit == TIME else trial.condition
        left = whitening.residual_of_any_start(predicted, place) / float(whitening.sizes[place])
        left = left - left.mean()
        if unit == TIME:
            courses.append(_Course(key, trial.times, left, False))
        elif MOTION in trial.inputs:
            position, turned = _position(trial), left * np.sign(trial.inputs[MOTION])
            courses += [_Course(key, position, left, False), _Course(key, position, turned - turned.mean(), True)]
    return courses


def _position(trial: Trial) -> FloatArray:
    """From where the model is run from, the begin of the lead-in where there is one [m], (n,)."""
    times, inputs, before = with_lead_in(trial)
    velocity = inputs[MOTION]
    return np.concatenate([[0.0], np.cumsum(np.diff(times) * (velocity[1:] + velocity[:-1]) / 2)])[before:]


def _vertex(numbers: FloatArray, power: FloatArray, top: int) -> float:
    """Of the parabola through a peak and its neighbours: a frequency that is off by an eighth of a period in the longest recording turns
    the phases of recordings that begin at other times."""
    if not 0 < top < numbers.size - 1:
        return float(numbers[top])
    before, at, after = power[top - 1 : top + 2]
    bend = before - 2 * at + after
    moved = float(np.clip((before - after) / (2 * bend), -0.5, 0.5)) if bend < 0 else 0.0
    return float(numbers[top] + moved * (numbers[1] - numbers[0]))


def travel(experiment: Experiment) -> float:
    """From end to end of the longest recorded motion [m]; 0 where none was recorded."""
    return max((float(np.ptp(_position(trial))) for trial in experiment.trials if MOTION in trial.inputs), default=0.0)


def _components(courses: list[_Course], numbers: FloatArray) -> tuple[npt.NDArray[np.complex128], int]:
    """Sum of what is left times waves of each of so many periods to a unit, (m,), and of how many samples."""
    total = np.zeros(numbers.size, dtype=np.complex128)
    for first in range(0, numbers.size, 256):
        for course in courses:
            total[first : first + 256] += np.exp(-2j * np.pi * np.outer(numbers[first : first + 256], course.place)) @ course.left
    return total, sum(course.left.size for course in courses)
