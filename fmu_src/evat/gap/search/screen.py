"""What could an effect do to these records, and how much of the gap would that explain? The score test, over a design of its shapes.

An effect's amplitudes enter nearly linearly once its other parameters (times, frequencies, exponents) are given. So each point of a design
in those is one linear fit, in sums that are there already.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.inference.discrepancy import known, likelihood
from evat.inference.fit import Fit
from evat.inference.initial_state import RANDOM
from evat.inference.parameters import Parameter, Scales, amplitude_parameter, amplitudes, shape_parameter, shapes
from evat.inference.prediction import Prediction
from evat.inference.whitening import Sums, Whitening
from evat.model import Effect, FloatArray, Variable


@dataclass(frozen=True)
class Start:
    """A point to fit an effect from, what it adds to the evidence as far as linear sums can tell, and what it does there: `slopes` (N,
    q) of its amplitudes, the first of its `parameters`, taken at `reach` (q,), in their prior standard deviations."""

    effect: Effect
    parameters: tuple[Parameter, ...]
    point: FloatArray
    evidence: float
    slopes: FloatArray
    reach: FloatArray

    @property
    def straight(self) -> tuple[Parameter, ...]:
        """Its amplitudes, bounded to where their slopes say anything if there is but one: ten delays of a sample are no delay of ten."""
        if self.reach.size > 1:
            return self.parameters[: self.reach.size]
        (amplitude, *_), (reach,), ratio = self.parameters, self.reach, CONSTANTS.straight_range
        ends = amplitude.value(reach / ratio if amplitude.unit == "s" else -reach * ratio), amplitude.value(reach * ratio)
        return (replace(amplitude, low=max(amplitude.low, min(ends)), high=min(amplitude.high, max(ends))),)


def small(experiment: Experiment) -> Experiment:
    """A part of an experiment that is quick to run: the head of one trial of a few conditions, a few means."""
    chosen = _spread([trial.condition for trial in experiment.trials], CONSTANTS.probed_conditions)
    wholes = [next(trial for trial in experiment.trials if trial.condition == condition) for condition in chosen]
    means = experiment.means.only(_spread(experiment.means.conditions, CONSTANTS.probed_means)) if experiment.means is not None else None
    return replace(experiment, trials=tuple(whole.head(CONSTANTS.probed_samples) for whole in wholes), means=means)


def _spread(conditions: Sequence[str], most: int) -> list[str]:
    """So many of them at most, from the first to the last: neighbours are alike."""
    each = list(dict.fromkeys(conditions))
    return [each[round(k)] for k in np.linspace(0, len(each) - 1, min(most, len(each)))]


def _design(unknown: Sequence[Parameter]) -> FloatArray:
    """Points (G, s) over the prior of the shapes, in its standard deviations."""
    if not unknown:
        return np.zeros((1, 0))
    if len(unknown) == 1:
        reach = CONSTANTS.shape_range[0]
        return np.linspace(-reach, reach, CONSTANTS.shape_values)[:, None]
    reach = CONSTANTS.shape_range[1]
    points: FloatArray = qmc.Sobol(len(unknown), scramble=False).random(CONSTANTS.shape_points) * (2 * reach) - reach
    return points


class Screen:
    """Effects tried one after the other beside a fit."""

    def __init__(self, prediction: Prediction, whitening: Whitening, scales: Scales) -> None:
        self.prediction, self.whitening, self.scales = prediction, whitening, scales
        self.probe = prediction.of(small(prediction.experiment))
        self._level = np.concatenate([np.full(s.at.stop - s.at.start, whitening.levels[s.channel]) for s in self.probe.segments])
        self._probed: dict[tuple[str, ...], dict[str, FloatArray]] = {}

    def starts(self, base: Fit, effect: Effect) -> list[Start]:
        """Where to fit the effect from, the best first; none where it does nothing here."""
        unknown = [shape_parameter(variable, self.scales) for variable in shapes(effect)]
        strengths, idle = list(amplitudes(effect)), list[Variable]()
        neutral = {variable.name: variable.neutral for variable in strengths}
        spreads = self._spreads(base, effect, unknown, strengths, neutral)
        for variable in list(strengths):
            if not np.any(np.isfinite(spreads[variable.name])):
                strengths.remove(variable)
                idle.append(variable)
        if not strengths:
            return []
        for variable in idle:  # says something only once another amplitude is there: a shape
            if variable.neutral > 0 and variable.min >= 0:
                low, high = max(variable.min, variable.neutral / 10), min(variable.max, variable.neutral * 10)
                unknown.append(Parameter(variable.name, variable.unit, variable.neutral, math.log(high / low) / 4, low, high, True))
                spreads = self._spreads(base, effect, unknown, strengths, neutral)
        design, starts = _design(unknown), list[Start]()
        reach = self._reach(strengths, spreads, design.shape[0])
        design = np.repeat(design, reach.size // design.shape[0], axis=0)
        lanes, reached = self._lanes(base, effect, unknown, design, reach, strengths, neutral, spreads)
        predicted = self.prediction.many(lanes, (*base.on, effect.name))
        slopes = np.nan_to_num(predicted - base.predicted).T / reached  # (N, G q)
        everything = self.whitening.sums(base.predicted, np.column_stack([base.slopes, slopes])).grams
        information = known(everything, base.likelihood.weights * self.whitening.trust)
        fitted, width = base.slopes.shape[1], len(strengths)
        start = np.concatenate([base.point, np.zeros(width)])
        rows = list[tuple[float, FloatArray, tuple[Parameter, ...], list[int]]]()
        for row, shape in enumerate(design):
            own = [fitted + row * width + place for place in range(width)]
            if not np.any(slopes[:, [column - fitted for column in own]]):
                continue
            parameters = (
                *(amplitude_parameter(v, float(np.repeat(spreads[v.name], reach.size // spreads[v.name].size)[row])) for v in strengths),
                *unknown,
            )
            if not all(math.isfinite(parameter.sd) and parameter.sd > 0 for parameter in parameters):
                continue
            kept = [*range(fitted), *own, -1]
            rows.append((_expected(information[np.ix_(kept, kept)], start, parameters[:width]), shape, parameters, own))
        for _, shape, parameters, own in sorted(rows, key=lambda each: -each[0])[: CONSTANTS.refined_points]:
            kept = [*range(fitted), *own, *range(everything.shape[-1] - 1 - RANDOM, everything.shape[-1])]
            evidence, point = linear(self.whitening, Sums(everything[:, :, kept][:, :, :, kept]), start, parameters[:width])
            columns = [column - fitted for column in own]
            starts.append(
                Start(effect, parameters, np.concatenate([point[fitted:], shape]), evidence, slopes[:, columns], reached[columns])
            )
        return sorted(starts, key=lambda start: -start.evidence)

    def _reach(self, strengths: Sequence[Variable], spreads: Mapping[str, FloatArray], rows: int) -> FloatArray:
        """Where amplitudes are tried, in their prior standard deviations: (G,) or, for one that need not be linear, several for each
        row."""
        if len(strengths) > 1:
            return np.full(rows, CONSTANTS.linear_amplitude)
        (own,) = strengths
        if own.unit != "s":
            return np.tile(CONSTANTS.trial_amplitudes, rows)
        times = np.geomspace(
            0.5 * self.scales.step, 0.2 * self.scales.duration, CONSTANTS.trial_times
        )  # a time may be any that the record can show
        return np.concatenate([times / spread if np.isfinite(spread) else np.ones(CONSTANTS.trial_times) for spread in spreads[own.name]])

    def _spreads(
        self, base: Fit, effect: Effect, unknown: Sequence[Parameter], strengths: Sequence[Variable], neutral: Mapping[str, float]
    ) -> dict[str, FloatArray]:
        """Of each amplitude at each point of the design: how large it is where it does what is plausible; nan where it does nothing. Asked
        beside one base only: beside another it is of the same order."""
        key = (effect.name, *(variable.name for variable in strengths), *(parameter.name for parameter in unknown))
        if key in self._probed:
            return self._probed[key]
        design, without = _design(unknown), self.probe.one(base.values, base.on)
        shape = {p.name: np.array([p.value(float(u)) for u in design[:, place]]) for place, p in enumerate(unknown)}
        channels = [self.probe.places(channel) for channel in self.probe.channels]
        spreads = dict[str, FloatArray]()
        for variable in strengths:

            def sizes(amplitudes: FloatArray, rows: npt.NDArray[np.intp], variable: Variable = variable) -> FloatArray:
                lanes: dict[str, float | str | FloatArray] = {**base.values, **neutral, variable.name: variable.neutral + amplitudes}
                lanes.update({name: values[rows] for name, values in shape.items()})
                change = (self.probe.many(lanes, (*base.on, effect.name)) - without) / self._level
                rms: FloatArray = np.max([np.sqrt(np.mean(change[:, channel] ** 2, axis=1)) for channel in channels], axis=0)
                return rms

            least = self.scales.amplitude(variable) * CONSTANTS.first_probe
            spreads[variable.name] = _spreads_of(sizes, least, variable.max - variable.neutral, design.shape[0])
        self._probed[key] = spreads
        return spreads

    def _lanes(
        self,
        base: Fit,
        effect: Effect,
        unknown: Sequence[Parameter],
        design: FloatArray,
        reach: FloatArray,
        strengths: Sequence[Variable],
        neutral: Mapping[str, float],
        spreads: Mapping[str, FloatArray],
    ) -> tuple[dict[str, float | str | FloatArray], FloatArray]:
        """Value sets (G q): each amplitude alone at each point of the design; and how far it is there from doing nothing, in its prior
        standard deviations (G q): less than its reach where it meets its bound."""
        rows, width = design.shape[0], len(strengths)
        lanes: dict[str, float | str | FloatArray] = {**base.values, **neutral}
        reached = np.repeat(reach, width).reshape(rows, width)
        for place, variable in enumerate(strengths):
            column = np.full((rows, width), variable.neutral)
            spread = np.nan_to_num(np.repeat(spreads[variable.name], rows // spreads[variable.name].size))
            most = np.divide(variable.max - variable.neutral, spread, out=np.full(rows, np.inf), where=spread > 0)
            reached[:, place] = np.minimum(reach, most)
            column[:, place] = np.minimum(variable.neutral + reach * spread, variable.max)
            lanes[variable.name] = column.ravel()
        for place, parameter in enumerate(unknown):
            lanes[parameter.name] = np.repeat([parameter.value(float(u)) for u in design[:, place]], width)
        return lanes, reached.ravel()


def _spreads_of(sizes: Callable[[FloatArray, npt.NDArray[np.intp]], FloatArray], least: float, most: float, rows: int) -> FloatArray:
    """The amplitudes (rows,) at which responses have the plausible size, from one that is near it or else from the largest that has less;
    nan where nothing shows.

    sizes : of responses to amplitudes in some of the rows; from small to large, since what is too large may be slow to simulate.
    """
    amplitude, spreads = np.full(rows, min(least, most)), np.full(rows, np.nan)
    low, high = np.zeros(rows), np.full(rows, np.inf)  # amplitudes that are known to do less and more than what is plausible
    enough, near_enough = CONSTANTS.plausible_effect, CONSTANTS.near_plausible
    going = np.arange(rows)
    for _ in range(CONSTANTS.probes):
        tried = amplitude[going]
        size = sizes(tried, going)
        shows = np.isfinite(size) & (size > CONSTANTS.least_effect)
        less = shows & (size <= enough)
        first = shows & ~less & ~(low[going] > 0)  # too large, and nothing smaller is known to show
        near = shows & (size > enough / near_enough) & (size < enough * near_enough)  # on either side: runs have errors of their own
        with np.errstate(divide="ignore", invalid="ignore"):
            wanted = tried * enough / size
        spreads[going] = np.where(less | first | near, np.minimum(wanted, 10 * tried), spreads[going])
        below = np.isfinite(size) & (size <= enough)
        low[going] = np.where(below, tried, low[going])
        high[going] = np.where(below, high[going], tried)
        onward = np.where(
            shows & below,
            np.minimum(wanted, CONSTANTS.largest_probe_ratio * tried),
            np.where(below, CONSTANTS.largest_probe_ratio * tried, tried / CONSTANTS.largest_probe_ratio),
        )
        between = np.sqrt(low[going] * high[going])
        onward = np.where((low[going] > 0) & (onward >= high[going]) | ~below & (low[going] > 0), between, onward)
        amplitude[going] = np.minimum(onward, most)
        going = going[~near & (amplitude[going] != tried)]
        if not going.size:
            break
    return spreads


def _bounds(parameters: Sequence[Parameter]) -> FloatArray:
    """Least and greatest places, (2, q)."""
    return np.array([[p.within(-math.inf), p.within(math.inf)] for p in parameters]).reshape(-1, 2).T


def _expected(information: FloatArray, point: FloatArray, parameters: Sequence[Parameter]) -> float:
    """Evidence, but for a constant, of a model that is linear in its parameters, with a discrepancy that is given.

    information : (p + 1, p + 1), on [slopes, residual] at `point` (p,); the last of its parameters keep their bounds.
    """
    first, bounds = point.size - len(parameters), _bounds(parameters)
    step = np.linalg.solve(information[:-1, :-1] + np.eye(point.size), information[:-1, -1] - point)
    wanted = point[first:] + step[first:]
    step[first:] = np.clip(wanted, *bounds) - point[first:]
    free = np.append(np.ones(first), (wanted >= bounds[0]) & (wanted <= bounds[1]))
    change, there = np.append(-step, 1.0), point + step
    normal = information[:-1, :-1] * np.outer(free, free) + np.eye(point.size)
    return -0.5 * float(change @ information @ change + there @ there + np.linalg.slogdet(normal)[1])


def linear(
    whitening: Whitening, sums: Sums, point: FloatArray, parameters: Sequence[Parameter], rounds: int = 3
) -> tuple[float, FloatArray]:
    """Evidence and best point (p,) of a model that is linear in its parameters; as `sums` stand at `point`. `parameters` are the last of
    them, whose bounds are kept: one that would leave them stays there."""
    first, bounds = point.size - len(parameters), _bounds(parameters)
    free = np.ones(sums.grams.shape[-1])
    for _ in range(rounds):
        discrepancy = likelihood(whitening, sums, point)
        step = np.where(free[: point.size] > 0, discrepancy.step, 0.0)
        wanted = point[first:] + step[first:]
        step[first:] = np.clip(wanted, *bounds) - point[first:]
        point = point + step
        sums = Sums(_moved(sums.grams, step) * np.outer(free, free))
        free[first : point.size] *= (wanted >= bounds[0]) & (wanted <= bounds[1])
    sums = Sums(sums.grams * np.outer(free, free))
    return likelihood(whitening, sums, point).evidence, point


def _moved(grams: FloatArray, step: FloatArray) -> FloatArray:
    """Sums (..., w, w) where the residual is what is left after a step (p,) along the slopes: only its row and its column change."""
    moved, residual = grams.copy(), step.size
    moved[..., residual] -= moved[..., : step.size] @ step
    moved[..., residual, :] -= np.einsum("...kj,k->...j", moved[..., : step.size, :], step)
    return moved
