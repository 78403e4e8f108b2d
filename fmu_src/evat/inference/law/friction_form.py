"""In which ways may the friction force of a contact differ from that of its law? In those in which published laws differ from each other.

Beside its parameters each law differs in how it goes from rest to sliding (Prandtl 1928 and Iwan 1966: elements that yield one after the
other), in how smoothly it passes zero, and in how late the level follows the velocity (Hess and Soom 1990). Each of these is a column that
a motion tells without any law. A level that follows over a way (Dieterich 1979) is none: that is an effect, which has a name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from evat.inference.law.initial_state import steady_deflections
from evat.inference.prediction import Prediction, with_lead_in
from evat.model import FloatArray
from evat.required_inputs import FRICTION, MOTION


def friction_forms(prediction: Prediction, values: Mapping[str, float | str], on: Sequence[str]) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """How friction forces may differ, (n, k), and where these stand in the long vector, (n,): nowhere where no slip velocity was recorded
    beside them."""
    recorded = [
        s for s in prediction.segments if s.trial >= 0 and s.channel == FRICTION and MOTION in prediction.experiment.trials[s.trial].inputs
    ]
    if not recorded:
        return np.empty((0, 0)), np.empty(0, dtype=np.intp)
    trials = [prediction.experiment.trials[s.trial] for s in recorded]
    motions = [with_lead_in(trial) for trial in trials]
    speeds = np.concatenate([np.abs(inputs[MOTION]) for _, inputs, _ in motions])
    fastest = float(np.quantile(speeds, 0.99))
    slowest = max(float(np.quantile(speeds, 0.05)), 1e-3 * fastest)
    ways = [float(np.median(np.abs(inputs[MOTION])) * np.median(np.diff(times))) for times, inputs, _ in motions]
    length = max(steady_deflections(prediction, values, on).values(), default=0.0) or 3 * float(np.median(ways))
    rows, of_run = list[FloatArray](), dict[bytes, FloatArray]()
    for segment, trial, (times, inputs, before) in zip(recorded, trials, motions, strict=True):
        key = prediction.alike[segment.trial]
        if key not in of_run:
            start = prediction.starts.get(trial.file, 0.0) / length
            of_run[key] = friction_columns(times, inputs[MOTION], length, (slowest, fastest), start)[before:]
        rows.append(of_run[key])
    return np.concatenate(rows), np.concatenate([np.arange(s.at.start, s.at.stop) for s in recorded])


def friction_columns(times: FloatArray, velocity: FloatArray, length: float, range_: tuple[float, float], start: float) -> FloatArray:
    """Of one motion (n,), (n, k). length : over which bristles bend [m]; start : how far they were bent before, by that."""
    slowest, fastest = range_
    steps = np.diff(times, prepend=times[0])
    middle = 0.5 * (velocity + np.concatenate([velocity[:1], velocity[:-1]]))
    moved = steps * middle
    yielding = _stops(moved, length * np.geomspace(0.125, 4.0, 6), start)
    way = yielding[:, 3]
    speed = np.log(np.maximum(np.abs(velocity), slowest))
    smooth = np.array([velocity / (np.abs(velocity) + size) for size in np.geomspace(slowest, fastest, 4)[:3]]).T
    usual = float(np.median(steps[1:])) if steps.size > 1 else 1.0
    late = np.array([_lagged(speed, steps / (usual * by)) - speed for by in (3.0, 12.0, 48.0)]).T
    return np.column_stack([yielding, smooth, way[:, None] * late])


def _stops(moved: FloatArray, widths: FloatArray, start: float) -> FloatArray:
    """Elements that yield after each of the widths (k,) along a way moved in steps (n,): (n, k), 1 where they yield."""
    states, row = np.empty((moved.size, widths.size)), np.clip(np.full(widths.size, start), -1.0, 1.0)
    for place, step in enumerate(moved[:, None] / widths):
        row = np.clip(row + step, -1.0, 1.0)
        states[place] = row
    return states


def _lagged(column: FloatArray, rates: FloatArray) -> FloatArray:
    """A column (n,) that is followed late, by `rates` (n,) of the difference in each step."""
    gains, followed, value = -np.expm1(-rates), np.empty_like(column), column[0]
    for place, (gain, target) in enumerate(zip(gains, column, strict=True)):
        value = value + gain * (target - value)
        followed[place] = value
    return followed
