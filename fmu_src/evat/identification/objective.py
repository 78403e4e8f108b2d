"""How far is a model from an experiment? The objectives, for all members of a generation in one call of the model.

least_squares : mean of ((measured - calculated)/scale)^2
huber         : the same, beyond HUBER scales linear
relative      : the paper's eq. 9, sum|measured - calculated| / sum|measured|, averaged over the channels
The scale of a channel is its noise, where repeats or a stated sd give it, otherwise ASSUMED_SD of its rms.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Literal, get_args

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import ExperimentError
from evat.identification.space import Space
from evat.inference.law.initial_state import with_initial_state
from evat.inference.noise.estimate import repeatability, stated_sd
from evat.inference.parameters import Parameter, form_parameters, nominal_parameters
from evat.inference.prediction import TIGHTNESS, Prediction
from evat.model import FloatArray, ParameterError

Kind = Literal["least_squares", "huber", "relative"]
HUBER = 1.345  # scales: 95 % efficient on Gaussian noise
ASSUMED_SD = 0.03  # of the rms: a scale is no more than that until a fit has shown the noise
FAILED = 1e30  # cost of a set that the model cannot run; finite, so that populations have a spread
MOST_BYTES = 13e6  # of predictions held at a time; what is made of them on the way takes as much three times more
LANES = 8  # sets that the model runs side by side in a thread


class Objective:
    """Costs of points of the cube of free parameters."""

    def __init__(self, prediction: Prediction, space: Space, on: Sequence[str], kind: Kind, values: Mapping[str, float | str]) -> None:
        """values : parameters that are held, beside the nominal ones; `on` : effects beside the nominal ones."""
        if kind not in get_args(Kind):
            raise ParameterError(f"objective {kind!r}: allowed are {', '.join(get_args(Kind))}.")
        self.prediction, self.space, self.on, self.kind, self.values = prediction, space, tuple(on), kind, dict(values)
        self.channels = prediction.channels
        self.noise = repeatability(prediction)
        measured, scale = prediction.measured, np.empty_like(prediction.measured)
        self.shares = np.empty_like(measured)  # of |residual| in eq. 9
        for channel in self.channels:
            places = prediction.places(channel)
            whole, rms = float(np.abs(measured[places]).sum()), float(np.sqrt(np.mean(measured[places] ** 2)))
            if rms == 0:
                raise ExperimentError(
                    f"{prediction.experiment.title!r}: {channel} is zero in every sample. A sensor that was off, or a wrong column? "
                    "There is nothing to identify from it; leave it out of the signals."
                )
            scale[places] = self.noise.get(channel) or ASSUMED_SD * rms
            self.shares[places] = 1 / (whole * len(self.channels))
        stated = stated_sd(prediction)
        self._stated = np.isfinite(stated)
        self.weights: FloatArray = 1 / np.where(np.isfinite(stated), stated, scale)

    @property
    def at_once(self) -> int:
        """How many predictions are held at a time: enough for all threads, whatever the memory."""
        return max(LANES * (os.cpu_count() or 1), int(MOST_BYTES / (8 * self.prediction.measured.size)) // LANES * LANES)

    @property
    def side_by_side(self) -> int:
        """How many descents may go on at a time, each with slopes of its own; a run of a long record has threads itself."""
        size = 8 * self.prediction.measured.size * (1 + len(self.space.free))
        return min(os.cpu_count() or 1, max(1, int(MOST_BYTES / size)))

    def has_sd(self, channel: str) -> bool:
        """Whether an sd came with every number of a channel."""
        return bool(self._stated[self.prediction.places(channel)].all())

    @property
    def held_sd(self) -> dict[str, float]:
        """Standard deviations [SI] of nominal values that are held and that their owner knows to within a share: what nominal.relative_sd
        says, or its default, as for a diagnosis."""
        may_be_off = nominal_parameters(self.prediction.model, self.prediction.experiment)
        held = [each.name for each in may_be_off if each.name not in (*self.space.names, *self.values)]
        return {name: self.known_to(name) * abs(float(self.prediction.nominal[name])) for name in held}

    @property
    def shapes(self) -> tuple[Parameter, ...]:
        """Shapes of the base law, such as the exponent of Stribeck's curve, that nobody knows exactly and that are held as in textbooks."""
        forms = form_parameters(self.prediction.model, self.prediction.experiment)
        return tuple(each for each in forms if each.name not in (*self.space.names, *self.values))

    def known_to(self, name: str) -> float:
        """The share of a nominal value to within which it is known."""
        variable = next(variable for variable in self.prediction.model.variables if variable.name == name)
        return self.prediction.experiment.nominal.known_to(variable)

    def at(self, point: FloatArray) -> Prediction:
        """The prediction with what an unknown start of its trials changes at a point (p,) of the cube."""
        return with_initial_state(self.prediction, {**self.values, **self.space.at(point)}, self.on)

    def predicted(self, points: FloatArray) -> FloatArray:
        """(K, p) -> (K, N), nan where a set fails."""
        return self.prediction.many({**self.values, **self.space.values(points)}, self.on)

    def _of_search(self) -> dict[str, float | str]:
        """What is held in a search, which takes no differences between runs; a tolerance that somebody has chosen stays."""
        chosen = {*self.prediction.experiment.nominal.values, *self.values, *self.space.names}
        loose = TIGHTNESS in self.prediction.nominal and TIGHTNESS not in chosen and self.prediction.experiment.means is None
        return {TIGHTNESS: CONSTANTS.solver_tolerance_of_records, **self.values} if loose else self.values

    def costs(self, points: FloatArray) -> FloatArray:
        """(K, p) -> (K,), for a search. A point's cost depends on nothing but the point: not on its neighbours, threads or chunks."""
        most, held = self.at_once, self._of_search()
        values = np.empty(len(points))
        for first in range(0, len(points), most):
            rows = self.prediction.many({**held, **self.space.values(points[first : first + most])}, self.on)
            rows -= self.prediction.measured
            values[first : first + most] = [self.cost(row) for row in rows]
        return values

    def cost(self, residual: FloatArray) -> float:
        """Of one residual, calculated less measured; FAILED where it is not finite."""
        if self.kind == "relative":
            cost = float(np.sum(np.abs(residual) * self.shares))
        else:
            scaled = residual * self.weights
            if self.kind == "huber":
                size = np.abs(scaled)
                cost = float(np.mean(np.where(size <= HUBER, size**2, HUBER * (2 * size - HUBER))))
            else:
                cost = float(np.mean(scaled * scaled))
        return cost if np.isfinite(cost) and cost < FAILED else FAILED

    def jacobian(self, point: FloatArray, only: Sequence[int] | None = None) -> tuple[FloatArray, FloatArray]:
        """Prediction (N,) and its slopes (N, p) with respect to the point of the cube, or to some of its places."""
        return slopes(self.prediction, self.space, self.values, self.on, point, only)


def slopes(
    prediction: Prediction,
    space: Space,
    values: Mapping[str, float | str],
    on: Sequence[str],
    point: FloatArray,
    only: Sequence[int] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Prediction (N,) and its slopes (N, p) with respect to a point of the cube, or to some of its places."""
    at, rates = space.at(point), space.slopes(point)
    scales = {one.name: one.scale(at[one.name]) for one in space.free}
    places = list(range(len(space.free)) if only is None else only)
    names = [space.names[place] for place in places]
    row, table = prediction.jacobian({**values, **at}, names, scales, on, prior=False)
    return row, table * (rates[places] / np.array([scales[name] for name in names]))


def relative_error(prediction: Prediction, residual: FloatArray) -> dict[str, float]:
    """The paper's eq. 9 of each channel."""
    squares: dict[str, list[float]] = {}
    for segment in prediction.segments:
        sums = squares.setdefault(segment.channel, [0.0, 0.0])
        sums[0] += float(np.abs(residual[segment.at]).sum())
        sums[1] += float(np.abs(prediction.measured[segment.at]).sum())
    return {channel: difference / whole if whole else float("inf") for channel, (difference, whole) in squares.items()}
