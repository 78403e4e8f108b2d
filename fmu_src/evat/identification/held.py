"""How far may an optimum lie from the truth because of what no fit frees? Nominal values that are held, gain and zero of each channel.

A shift of the prediction that all trials share: their prior is that of a diagnosis, what the data tell of them enters linearly.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from evat.identification.objective import Objective
from evat.inference.setup.setup_errors import GAIN, ZERO, by_channel
from evat.model import FloatArray

FREED = 0.999  # correlation of what a set-up error does with what an effect does, from which the one is the other


def moved_by_held(
    objective: Objective,
    weigh: Callable[[FloatArray], FloatArray],
    slopes: FloatArray,
    table: FloatArray,
    psi: FloatArray,
    unit: float,
    point: FloatArray,
    predicted: FloatArray,
    covariance: FloatArray,
    with_shapes: bool,
) -> tuple[dict[str, FloatArray], FloatArray, FloatArray]:
    """By each nominal value that is held, and each gain and zero of a channel: how far (p,) the optimum is likely to lie from here, in the
    cube, because that is another, by what its owner knows of it and what these data tell; the square (p,) of how far by all of them; and
    what the prediction (N,), SI, changes by once they are where the data want them.

    slopes : (N, p) and psi : (N,), weighed; table : (N, p), the slopes as they are; unit : the loss's rise that is one sd, squared, over
    2; predicted : (N,), SI; covariance : (p, p), over that unit; with_shapes : shapes of the law are held values, too.
    """
    columns = {**_by_held_values(objective, point, predicted, with_shapes), **_by_setup(objective, weigh, slopes, predicted)}
    if not columns:
        return {}, np.zeros(point.size), np.zeros(predicted.size)
    changes = np.array(list(columns.values())).T
    runs = np.all(np.isfinite(changes), axis=0)
    changes = np.where(runs, changes, 0.0)
    by_sd = weigh(changes)
    steps = -covariance @ (slopes.T @ by_sd)
    left = (by_sd + slopes @ steps) / np.sqrt(unit)  # once the free parameters have followed
    spread = np.linalg.inv(left.T @ left + np.eye(len(columns)))
    wanted = -spread @ (left.T @ (psi / np.sqrt(unit)))
    likely = np.sqrt(np.diag(spread) + wanted**2)
    moved = {name: steps[:, at] * likely[at] if runs[at] else np.full(point.size, np.nan) for at, name in enumerate(columns)}
    # What two of them may be off by is told together: where data tell their sum, one makes up for the other.
    square: FloatArray = np.einsum("pi,ij,pj->p", steps, spread, steps) + np.max([(steps @ wanted) ** 2, steps**2 @ wanted**2], axis=0)
    return moved, square, changes @ wanted + table @ (steps @ wanted)


def _by_held_values(objective: Objective, point: FloatArray, predicted: FloatArray, with_shapes: bool) -> dict[str, FloatArray]:
    """What the prediction (N,) changes by, in SI, where a held nominal value is one sd another; nan where it runs to neither side."""
    bounds, nominal = {variable.name: variable for variable in objective.prediction.model.variables}, objective.prediction.nominal
    # A sd up and down: a difference as small as for a slope tells little of so far.
    ends = {name: (at := float(nominal[name]), at + far, at - far) for name, far in objective.held_sd.items()}
    if with_shapes:
        ends |= {shape.name: (shape.mean, shape.value(1.0), shape.value(-1.0)) for shape in objective.shapes}
    if not ends:
        return {}
    tried: dict[str, FloatArray] = {}
    for place, (name, (at, *both)) in enumerate(ends.items()):
        tried[name] = np.full(2 * len(ends), at)
        tried[name][2 * place : 2 * place + 2] = both
        tried[name] = np.clip(tried[name], bounds[name].min, bounds[name].max)
    rows = objective.prediction.many({**objective.values, **objective.space.at(point), **tried}, objective.on)
    sides = np.array([rows[0::2] - predicted, predicted - rows[1::2]])
    runs = np.all(np.isfinite(sides), axis=2)  # (2, names)
    change = np.sum(np.nan_to_num(sides) * runs[:, :, None], axis=0) / np.maximum(runs.sum(axis=0), 1)[:, None]
    return {name: row if runs[:, place].any() else row * np.nan for place, (name, row) in enumerate(zip(ends, change, strict=True))}


def _by_setup(
    objective: Objective, weigh: Callable[[FloatArray], FloatArray], slopes: FloatArray, predicted: FloatArray
) -> dict[str, FloatArray]:
    """What the prediction (N,) changes by, in SI, where the gain or the zero of a channel is one sd off in all trials alike: repeats show
    nothing of that, and every force of the law follows it. Not where the fit frees an effect that does the same to the record."""
    setup, effects = objective.prediction.setup, objective.prediction.model.effects
    may_be_it = {v.name for effect in effects for v in effect.variables if math.isfinite(v.neutral)}
    free = slopes[:, [name in may_be_it for name in objective.space.names]]
    own, columns = free / np.maximum(np.linalg.norm(free, axis=0), 1e-300), dict[str, FloatArray]()
    for parameter in setup.parameters:
        if by_channel(parameter.name)[1] not in (GAIN, ZERO):
            continue
        column = parameter.sd * setup.slopes(predicted, parameter.name, {})
        weighed = weigh(column)
        if not np.any(np.abs(own.T @ weighed) > FREED * np.linalg.norm(weighed)):
            columns[parameter.name] = column
    return columns
