"""How far may an optimum lie from the truth because of what no fit frees? Nominal values that are held, gain and zero of each output, the
zero of each recorded input.

A shift of the prediction that all trials share: their prior is that of a diagnosis, what the data tell of them enters linearly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection

import numpy as np

from evat.identification.objective import Objective
from evat.inference.setup.setup_errors import CLOCK, GAIN, MASS, ZERO, by_channel
from evat.model import FloatArray

DAMPING = "damping_mode"  # the choice of whether a law's damping is limited to what dissipates
# Of what a lag does: so far off is its slope where forces leap between samples. Half of it was no free parameter's, in records whose
# residual a third of a sample left as it was.
LEAP_ERROR = 0.6
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
    """By each nominal value that is held, each gain and zero of an output and each zero of an input: how far (p,) the optimum is likely to
    lie from here, in the cube, because that is another, by what its owner knows of it and what these data tell; the covariance (p, p) of
    how far by all of them; and what the prediction (N,), SI, changes by once they are where the data want them.

    slopes : (N, p) and psi : (N,), weighed; table : (N, p), the slopes as they are; unit : the loss's rise that is one sd, squared, over
    2; predicted : (N,), SI; covariance : (p, p), over that unit; with_shapes : shapes of the law are held values, too.
    """
    of_setup = _by_setup(objective, weigh, slopes, predicted, (GAIN, ZERO, MASS))
    of_inputs = _by_input_zeros(objective, weigh, slopes, point, predicted)
    columns = {**_by_held_values(objective, point, predicted, with_shapes), **of_setup, **of_inputs}
    if not columns:
        return {}, np.zeros((point.size, point.size)), np.zeros(predicted.size)
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
    together = steps @ wanted
    square = np.einsum("pi,ij,pj->p", steps, spread, steps) + np.max([together**2, steps**2 @ wanted**2], axis=0)
    shared = steps @ (spread + np.diag(wanted**2)) @ steps.T + np.outer(together, together)
    factors = np.sqrt(np.divide(square, np.diag(shared), out=np.zeros_like(square), where=np.diag(shared) > 0))
    return moved, shared * np.outer(factors, factors), changes @ wanted + table @ (steps @ wanted)


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
    return {name: _change(predicted, *rows[2 * place : 2 * place + 2]) for place, name in enumerate(ends)}


def _change(predicted: FloatArray, up: FloatArray, down: FloatArray) -> FloatArray:
    """What a prediction (N,) changes by from here to an end, as the mean of the sides that run; nan where neither does."""
    sides = [side for side in (up - predicted, predicted - down) if np.all(np.isfinite(side))]
    return np.mean(sides, axis=0) if sides else np.full(predicted.size, np.nan)


def _by_input_zeros(
    objective: Objective, weigh: Callable[[FloatArray], FloatArray], slopes: FloatArray, point: FloatArray, predicted: FloatArray
) -> dict[str, FloatArray]:
    """What the prediction (N,) changes by, in SI, where the zero of a recorded input is one sd off in all trials alike: by that of a load
    a force in proportion leans, and it moves the parameters by as much. Not where the fit frees an effect that does the same."""
    prediction, columns = objective.prediction, dict[str, FloatArray]()
    values = {**objective.values, **objective.space.at(point)}
    for zero in prediction.input_zeros:
        up, down = (prediction.one({**values, zero.name: side * zero.sd}, objective.on) for side in (1, -1))
        column = _change(predicted, up, down)
        if not np.all(np.isfinite(column)) or not _is_freed(objective, slopes, weigh(column)):
            columns[zero.name] = column
    return columns


def _by_setup(
    objective: Objective,
    weigh: Callable[[FloatArray], FloatArray],
    slopes: FloatArray,
    predicted: FloatArray,
    kinds: Collection[str],
) -> dict[str, FloatArray]:
    """What the prediction (N,) changes by, in SI, where a set-up error of these kinds is one sd off in all trials alike: repeats show
    nothing of that, and every force of the law follows it. Not where the fit frees an effect that does the same to the record."""
    columns = dict[str, FloatArray]()
    for parameter in objective.prediction.setup.parameters:
        if by_channel(parameter.name)[1] in kinds:
            column = parameter.sd * objective.prediction.setup.slopes(predicted, parameter.name, {})
            if not _is_freed(objective, slopes, weigh(column)):
                columns[parameter.name] = column
    return columns


def moved_by_clocks(
    objective: Objective,
    weigh: Callable[[FloatArray], FloatArray],
    slopes: FloatArray,
    unit: float,
    predicted: FloatArray,
    covariance: FloatArray,
) -> dict[str, FloatArray]:
    """By the clock of each channel, as far as these data leave it open: how far (p,) that moves the optimum, in the cube. Told and not in
    intervals: of what a lag does beside what the parameters do little can be told where a force leaps between samples. As in
    moved_by_held."""
    moved = dict[str, FloatArray]()
    for name, change in _by_setup(objective, weigh, slopes, predicted, (CLOCK,)).items():
        column = weigh(change)
        steps = -covariance @ (slopes.T @ column)
        left, whole = (float(np.sum(part**2)) / unit for part in (column + slopes @ steps, column))
        moved[name] = steps / np.sqrt(1 + max(left - LEAP_ERROR**2 * whole, 0.0))
    return moved


def moved_by_damping(
    objective: Objective,
    weigh: Callable[[FloatArray], FloatArray],
    slopes: FloatArray,
    point: FloatArray,
    predicted: FloatArray,
    covariance: FloatArray,
) -> tuple[str, FloatArray]:
    """By the other way in which a law's damping may act, where nobody has stated one: which that is, and how far (p,) it moves the optimum,
    in the cube; "" where it was stated. As in moved_by_held."""
    prediction, none = objective.prediction, np.zeros(slopes.shape[1])
    variable = next((each for each in prediction.model.variables if each.name == DAMPING), None)
    if variable is None or DAMPING in {**prediction.experiment.nominal.values, **objective.values}:
        return "", none
    usual = variable.choices[int(variable.start)]
    other = next(choice for choice in variable.choices if choice != usual)
    changed = prediction.one({**objective.values, **objective.space.at(point), DAMPING: other}, objective.on)
    return other, -covariance @ (slopes.T @ weigh(changed - predicted)) if np.all(np.isfinite(changed)) else none


def _is_freed(objective: Objective, slopes: FloatArray, column: FloatArray) -> bool:
    """Whether the fit frees an effect that does to the record what a set-up error (N,), weighed, does."""
    may_be_it = {v.name for effect in objective.prediction.model.effects for v in effect.variables if math.isfinite(v.neutral)}
    free = slopes[:, [name in may_be_it for name in objective.space.names]]
    own = free / np.maximum(np.linalg.norm(free, axis=0), 1e-300)
    return bool(np.any(np.abs(own.T @ column) > FREED * np.linalg.norm(column)))
