"""What could an effect do to these records, and how much of the gap would that explain? The score test, over a design of its shapes.

An effect's amplitudes enter nearly linearly once its other parameters (times, frequencies, exponents) are given. So each point of a design
in those is one linear fit, in sums that are there already.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap.search.starts.linear import expected_evidence, linear_fit
from evat.gap.search.starts.periodogram import peaks
from evat.gap.search.starts.plausible import plausible_amplitudes
from evat.gap.search.starts.quadrature import in_phase, quadrature, sine_of
from evat.inference.discrepancy import known
from evat.inference.fit import Fit
from evat.inference.law.initial_state import RANDOM
from evat.inference.parameters import Parameter, Scales, amplitude_parameter, amplitudes, shape_parameter, shapes
from evat.inference.prediction import OWN, Prediction
from evat.inference.whitening import Sums, Whitening
from evat.model import Effect, FloatArray, Variable


@dataclass(frozen=True)
class Start:
    """A point to fit an effect from, what it adds to the evidence as far as linear sums can tell, and what it does there: `slopes` (N,
    q) of its amplitudes, the first of its `parameters`, taken at `reach` (q,), in their prior standard deviations. `fixed` are values that
    conditions or trials have by themselves."""

    effect: Effect
    parameters: tuple[Parameter, ...]
    point: FloatArray
    evidence: float
    slopes: FloatArray
    reach: FloatArray
    fixed: Mapping[str, float] = field(default_factory=dict)

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
    """Points (G, s) over the prior of the shapes, in its standard deviations. In the order of the first shape: neighbours run side by side,
    and a block takes as long as its slowest."""
    if not unknown:
        return np.zeros((1, 0))
    if len(unknown) == 1:
        reach = CONSTANTS.shape_range[0]
        return np.linspace(-reach, reach, CONSTANTS.shape_values)[:, None]
    reach = CONSTANTS.shape_range[1]
    points: FloatArray = qmc.Sobol(len(unknown), scramble=False).random(CONSTANTS.shape_points) * (2 * reach) - reach
    return points[np.argsort(points[:, 0])]


class Screen:
    """Effects tried one after the other beside a fit."""

    def __init__(self, prediction: Prediction, whitening: Whitening, scales: Scales) -> None:
        self.prediction, self.whitening, self.scales = prediction, whitening, scales
        self.probe = prediction.of(small(prediction.experiment))
        self._level = np.concatenate([np.full(s.at.stop - s.at.start, whitening.levels[s.channel]) for s in self.probe.segments])
        self._probed: dict[tuple[tuple[str, ...], bytes], dict[str, FloatArray]] = {}

    def starts(self, base: Fit, effect: Effect) -> list[Start]:
        """Where to fit the effect from, the best first; none where it does nothing here."""
        unknown = [shape_parameter(variable, self.scales) for variable in shapes(effect)]
        strengths, idle = list(amplitudes(effect)), list[Variable]()
        neutral = {variable.name: variable.neutral for variable in strengths}
        sine, fixed = sine_of(unknown), list[dict[str, float]]()
        if sine is None:
            design = _design(unknown)
        else:
            tops = peaks(self.prediction, self.whitening, base.predicted, unknown[sine[0]].unit)
            design = quadrature(tops, unknown, sine)
            fixed = [{f"{unknown[sine[1]].name}{OWN}{key}": phase for key, phase in top.phases.items()} for top in tops]
        spreads = self._spreads(base, effect, unknown, design, strengths, neutral)
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
                sine, fixed, design = None, [], _design(unknown)
                spreads = self._spreads(base, effect, unknown, design, strengths, neutral)
        starts = list[Start]()
        reach = self._reach(strengths, spreads, design.shape[0], sine is not None)
        design = np.repeat(design, reach.size // design.shape[0], axis=0)
        lanes, reached = self._lanes(base, effect, unknown, design, reach, strengths, neutral, spreads)
        for name in {name for own in fixed for name in own}:
            lanes[name] = np.repeat([own.get(name, 0.0) for own in fixed], 2 * len(strengths))
        predicted = self.prediction.many(lanes, (*base.on, effect.name))
        slopes = np.nan_to_num(predicted - base.predicted).T / reached  # (N, G q)
        if sine is not None:
            design, slopes = in_phase(self.whitening, base, design, slopes, [amplitude_parameter(v, 1.0) for v in strengths], sine)
            reach, reached = reach[::2], reached[: slopes.shape[1]]
            spreads = {name: spread[::2] for name, spread in spreads.items()}
        everything = self.whitening.sums(base.predicted, np.column_stack([base.slopes, slopes])).grams
        information = known(everything, base.likelihood.weights * self.whitening.trust)
        fitted, width = base.slopes.shape[1], len(strengths)
        start = np.concatenate([base.point, np.zeros(width)])
        rows = list[tuple[float, FloatArray, tuple[Parameter, ...], list[int], int, float]]()
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
            expected = expected_evidence(information[np.ix_(kept, kept)], start, parameters[:width])
            costs = CONSTANTS.cost_of_own_value * len(set(fixed[row].values())) if fixed else 0.0
            rows.append((expected - costs, shape, parameters, own, row, costs))
        for _, shape, parameters, own, row, costs in sorted(rows, key=lambda each: -each[0])[: CONSTANTS.refined_points]:
            kept = [*range(fitted), *own, *range(everything.shape[-1] - 1 - RANDOM, everything.shape[-1])]
            evidence, point = linear_fit(self.whitening, Sums(everything[:, :, kept][:, :, :, kept]), start, parameters[:width])
            columns = [column - fitted for column in own]
            whole, held = np.concatenate([point[fitted:], shape]), fixed[row] if fixed else {}
            starts.append(Start(effect, parameters, whole, evidence - costs, slopes[:, columns], reached[columns], held))
        return sorted(starts, key=lambda start: -start.evidence)

    def _reach(self, strengths: Sequence[Variable], spreads: Mapping[str, FloatArray], rows: int, straight: bool) -> FloatArray:
        """Where amplitudes are tried, in their prior standard deviations: (G,) or, for one that need not be linear, several for each
        row. straight : whether one is linear anyway, as that of a sine is."""
        if straight:
            return np.full(rows, CONSTANTS.trial_amplitudes[1])
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
        self,
        base: Fit,
        effect: Effect,
        unknown: Sequence[Parameter],
        design: FloatArray,
        strengths: Sequence[Variable],
        neutral: Mapping[str, float],
    ) -> dict[str, FloatArray]:
        """Of each amplitude at each point of the design: how large it is where it does what is plausible; nan where it does nothing. Asked
        beside one base only: beside another it is of the same order."""
        names = (effect.name, *(variable.name for variable in strengths), *(parameter.name for parameter in unknown))
        key = (names, design.tobytes())
        if key in self._probed:
            return self._probed[key]
        without = self.probe.one(base.values, base.on)
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
            spreads[variable.name] = plausible_amplitudes(sizes, least, variable.max - variable.neutral, design.shape[0])
            if sine_of(unknown) is not None:  # one amplitude for both components
                spreads[variable.name] = np.repeat(np.fmin(spreads[variable.name][::2], spreads[variable.name][1::2]), 2)
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
