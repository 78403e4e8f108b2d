"""In which ways may the forces of a vibrating cut differ from those of the model? In those in which published cutting models differ.

They differ in how the force grows with the thickness of the chip (Kienzle 1952: an exponent; Albrecht 1960: a force of the edge itself)
and with its speed (Johnson and Cook 1983), in how soon it stands when the edge enters (a rounded edge pushes before it cuts), and in what
the friction on the rake face does at a reversal, as any law of friction. Each of these is a column of each force that the motion of the
model tells.
"""

from __future__ import annotations

import itertools
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.inference.law.friction_form import friction_columns
from evat.inference.law.initial_state import PERIODIC, START
from evat.inference.prediction import BRISTLE, OWN, Prediction, with_lead_in
from evat.model import FloatArray, Run

SLIP, THICKNESS = "slip_velocity_used", "uncut_thickness_used"
SEEN = (SLIP, THICKNESS, BRISTLE)


@dataclass(frozen=True, slots=True)
class _Motion:
    """What a cut does in one recording, or in one cycle whose means were taken; each (n,)."""

    times: FloatArray
    slip: FloatArray
    thickness: FloatArray
    deflection: FloatArray
    before: int  # samples of it that come before the recording


def cut_forms(prediction: Prediction, values: Mapping[str, float | str], on: Sequence[str]) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """How each force of a cut may differ, (n, k), and where these stand in the long vector, (n,): nowhere where the model does not move by
    itself. Means have the means of a cycle."""
    nothing = np.empty((0, 0)), np.empty(0, dtype=np.intp)
    names = {variable.name for variable in prediction.model.variables}
    free = prediction.setup_names | prediction.form_names
    own = {name: value for name, value in values.items() if OWN not in name and name not in free}
    plain = {**prediction.nominal, **own}
    if not names.issuperset(SEEN) or not np.isfinite(prediction.model.cycle_time(plain)):
        return nothing
    effects = tuple(dict.fromkeys((*prediction.experiment.nominal.effects, *on)))
    recorded = _recorded(prediction, plain, effects)
    averaged = _averaged(prediction, plain, effects)
    columns = _columns({**recorded, **averaged})
    if not columns:
        return nothing
    rows = itertools.cycle(range(_rows(prediction)))  # in the order of the rows, force by force
    channels, width = prediction.channels, next(iter(columns.values())).shape[1]
    table = np.zeros((prediction.measured.size, len(channels) * width))
    for segment in prediction.segments:
        place = channels.index(segment.channel) * width  # each force by itself: in which direction a form acts is not known either
        key = prediction.alike[segment.trial] if segment.trial >= 0 else _condition(prediction, next(rows))
        block = columns[key] if segment.trial >= 0 else np.mean(columns[key], axis=0)
        table[segment.at, place : place + width] = block
    return table, np.arange(prediction.measured.size)


def _recorded(prediction: Prediction, values: Mapping[str, float | str], effects: Sequence[str]) -> dict[Hashable, _Motion]:
    """The motions of recordings: those that repeat each other once."""
    motions = dict[Hashable, _Motion]()
    for place, trial in enumerate(prediction.experiment.trials):
        if prediction.alike[place] not in motions:
            times, inputs, before = with_lead_in(trial)
            motions[prediction.alike[place]] = _motion(prediction, Run(times, inputs, SEEN), effects, {**values, **trial.values}, before)
    return motions


def _averaged(prediction: Prediction, values: Mapping[str, float | str], effects: Sequence[str]) -> dict[Hashable, _Motion]:
    """A cycle of each condition of which means were taken."""
    motions = dict[Hashable, _Motion]()
    for row in range(_rows(prediction)):
        if (key := _condition(prediction, row)) not in motions:
            own = {**values, **dict(key), START: PERIODIC}
            times = np.linspace(0.0, prediction.model.cycle_time(own), CONSTANTS.samples_of_a_cycle)
            motions[key] = _motion(prediction, Run(times, {}, SEEN), effects, own, 0)
    return motions


def _rows(prediction: Prediction) -> int:
    means = prediction.experiment.means
    return 0 if means is None else len(means.conditions)


def _condition(prediction: Prediction, row: int) -> tuple[tuple[str, float], ...]:
    """What was varied in the row of means, and its value."""
    means = prediction.experiment.means
    return tuple((name, float(column[row])) for name, column in means.values.items()) if means is not None else ()


def _motion(prediction: Prediction, run: Run, effects: Sequence[str], values: Mapping[str, float | str], before: int) -> _Motion:
    rows = prediction.model.simulate_many(run, effects, values)
    slip, thickness, deflection = (np.nan_to_num(np.asarray(rows[name][0])) for name in SEEN)
    return _Motion(run.times, slip, np.maximum(thickness, 0.0), deflection, before)


def _columns(motions: Mapping[Hashable, _Motion]) -> dict[Hashable, FloatArray]:
    """Of each motion (n, k), in scales that all share; none where nothing is cut."""
    thickest = max((float(np.max(motion.thickness)) for motion in motions.values()), default=0.0)
    if not thickest > 0:
        return {}
    speeds = np.concatenate([np.abs(motion.slip[motion.thickness > 0]) for motion in motions.values()])
    fastest = float(np.quantile(speeds, 0.99))
    slowest = max(float(np.quantile(speeds, 0.05)), 1e-3 * fastest)
    length = max(float(np.max(np.abs(motion.deflection))) for motion in motions.values()) or 1e-3 * thickest
    columns = dict[Hashable, FloatArray]()
    for key, motion in motions.items():
        thickness = motion.thickness / thickest
        open_, rate = thickness > 0, np.log(np.maximum(np.abs(motion.slip), slowest) / fastest)
        grows = thickness * np.log(np.where(open_, np.maximum(thickness, 1e-6), 1.0))
        enters = thickness[:, None] * np.exp(-thickness[:, None] / np.array([0.03, 0.1, 0.3]))
        friction = friction_columns(motion.times, motion.slip, length, (slowest, fastest), 0.0) * open_[:, None]
        table = np.column_stack([open_, grows, enters, thickness * rate, friction])
        columns[key] = table[motion.before :]
    return columns
