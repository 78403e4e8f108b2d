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

from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap.search.starts.design import Design, neutral_values, points_over
from evat.gap.search.starts.linear import expected_evidence, linear_fit
from evat.gap.search.starts.periodogram import WAY, peaks
from evat.gap.search.starts.plausible import plausible_amplitudes
from evat.gap.search.starts.quadrature import in_phase, quadrature, sine_of
from evat.inference.band_whitening import BandWhitening, Sums
from evat.inference.discrepancy import known
from evat.inference.fit import Fit
from evat.inference.law.initial_state import RANDOM
from evat.inference.parameters import Parameter, Scales, amplitude_parameter, amplitudes, shape_parameters
from evat.inference.prediction import OWN, Prediction
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


class Screen:
    """Effects tried one after the other beside a fit."""

    def __init__(self, prediction: Prediction, whitening: BandWhitening, scales: Scales) -> None:
        self.prediction, self.whitening, self.scales = prediction, whitening, scales
        self.probe = prediction.of(small(prediction.experiment))
        self._level = np.concatenate([np.full(s.at.stop - s.at.start, whitening.levels[s.channel]) for s in self.probe.segments])
        self._probed: dict[tuple[tuple[str, ...], bytes], dict[str, FloatArray]] = {}

    def starts(self, base: Fit, effect: Effect) -> list[Start]:
        """Where to fit the effect from, the best first; none where it does nothing here."""
        design = self._design(base, effect)
        if not design.strengths:
            return []
        if _is_time(design.strengths) and len(design.points) > CONSTANTS.shapes_beside_a_time:
            design = design.few(CONSTANTS.shapes_beside_a_time)
        reach = self._reach(design)
        design = design.repeated(reach.size // len(design.points))
        if _is_time(design.strengths):
            design, reach = _of_any_size(design, reach)
        lanes, reached = self._lanes(base, design, reach)
        predicted = self.prediction.many(lanes, (*base.on, effect.name))
        slopes = np.nan_to_num(predicted - base.predicted).T / reached  # (N, G q)
        if design.sine is not None:
            amplitudes = [amplitude_parameter(variable, 1.0) for variable in design.strengths]
            points, slopes = in_phase(self.whitening, base, design.points, slopes, amplitudes, design.sine)
            design, reached = design.one_of_two(points), reached[: slopes.shape[1]]
        return self._refined(base, design, slopes, reached)

    def _design(self, base: Fit, effect: Effect) -> Design:
        """What is tried. An amplitude that does nothing by itself says something only once another is there: it is a shape."""
        unknown = shape_parameters(effect, self.scales)
        sine, phases = sine_of(unknown), list[dict[str, float]]()
        if sine is None:
            points = points_over(unknown)
        else:
            unit = unknown[sine[0]].unit
            tops = peaks(self.prediction, self.whitening, base.predicted, unit, _fewest_periods(effect, unit))
            points = quadrature(tops, unknown, sine)
            phases = [{f"{unknown[sine[1]].name}{OWN}{key}": phase for key, phase in top.phases.items()} for top in tops]
        every = tuple(amplitudes(effect))
        spreads = self._spreads(base, effect, unknown, points, every)
        strengths = tuple(variable for variable in every if np.any(np.isfinite(spreads[variable.name])))
        idle = [variable for variable in every if variable not in strengths and variable.neutral > 0 and variable.min >= 0]
        if strengths and idle:
            unknown, sine, phases = (*unknown, *map(_as_shape, idle)), None, []
            points = points_over(unknown)
            spreads = self._spreads(base, effect, unknown, points, strengths)
        return Design(effect, strengths, unknown, points, spreads, sine, phases)

    def _refined(self, base: Fit, design: Design, slopes: FloatArray, reached: FloatArray) -> list[Start]:
        """Of the points that promise most by the sums as they are, a linear fit each."""
        grams = self.whitening.sums(base.predicted, np.column_stack([base.slopes, slopes])).grams
        information = known(grams, base.likelihood.weights * self.whitening.trust)
        fitted, width = base.slopes.shape[1], len(design.strengths)
        begin = np.concatenate([base.point, np.zeros(width)])
        promising = list[tuple[float, int, tuple[Parameter, ...]]]()
        for row in range(len(design.points)):
            own, parameters = np.arange(row * width, (row + 1) * width), design.parameters(row)
            if np.any(slopes[:, own]) and all(math.isfinite(parameter.sd) and parameter.sd > 0 for parameter in parameters):
                kept = [*range(fitted), *(fitted + own), -1]
                expected = expected_evidence(information[np.ix_(kept, kept)], begin, parameters[:width])
                promising.append((expected - design.cost(row), row, parameters))
        starts, beside = list[Start](), range(grams.shape[-1] - 1 - RANDOM, grams.shape[-1])
        for _, row, parameters in sorted(promising, key=lambda each: -each[0])[: CONSTANTS.refined_points]:
            own = np.arange(row * width, (row + 1) * width)
            kept = [*range(fitted), *(fitted + own), *beside]
            evidence, point = linear_fit(self.whitening, Sums(grams[:, :, kept][:, :, :, kept]), base, parameters[:width])
            whole = np.concatenate([point[fitted:], design.points[row]])
            starts.append(
                Start(design.effect, parameters, whole, evidence - design.cost(row), slopes[:, own], reached[own], design.fixed(row))
            )
        return sorted(starts, key=lambda start: -start.evidence)

    def _reach(self, design: Design) -> FloatArray:
        """Where amplitudes are tried, in their prior standard deviations: (G,) or, for one that need not be linear, as that of a sine is,
        several for each point."""
        count = len(design.points)
        if design.sine is not None:
            return np.full(count, CONSTANTS.trial_amplitudes[1])
        if len(design.strengths) > 1:
            return np.full(count, CONSTANTS.linear_amplitude)
        (own,) = design.strengths
        if not _is_time(design.strengths):
            return np.tile(CONSTANTS.trial_amplitudes, count)
        # A time may be any that the record can show. What rings shows near its own period only: the more times, the fewer dampings.
        number = CONSTANTS.trial_times * (max(CONSTANTS.shape_values // count, 1) if design.unknown else 1)
        times = np.geomspace(0.5 * self.scales.step, 0.2 * self.scales.duration, number)
        spreads = design.spreads[own.name]
        return np.concatenate([times / spread if np.isfinite(spread) else np.ones(number) for spread in spreads])

    def _spreads(
        self,
        base: Fit,
        effect: Effect,
        unknown: Sequence[Parameter],
        points: FloatArray,
        strengths: Sequence[Variable],
    ) -> dict[str, FloatArray]:
        """Of each amplitude at each point: how large it is where it does what is plausible; nan where it does nothing. Asked
        beside one base only: beside another it is of the same order."""
        names = (effect.name, *(variable.name for variable in strengths), *(parameter.name for parameter in unknown))
        key = (names, points.tobytes())
        if key in self._probed:
            return self._probed[key]
        without = self.probe.one(base.values, base.on)
        shape = {p.name: np.array([p.value(float(u)) for u in points[:, place]]) for place, p in enumerate(unknown)}
        channels = [self.probe.places(channel) for channel in self.probe.channels]
        spreads = dict[str, FloatArray]()
        for variable in strengths:

            def sizes(amplitudes: FloatArray, rows: npt.NDArray[np.intp], variable: Variable = variable) -> FloatArray:
                lanes: dict[str, float | str | FloatArray] = {
                    **base.values,
                    **neutral_values(effect),
                    variable.name: variable.neutral + amplitudes,
                }
                lanes.update({name: values[rows] for name, values in shape.items()})
                change = (self.probe.many(lanes, (*base.on, effect.name)) - without) / self._level
                rms: FloatArray = np.max([np.sqrt(np.mean(change[:, channel] ** 2, axis=1)) for channel in channels], axis=0)
                return rms

            least = self.scales.amplitude(variable) * CONSTANTS.first_probe
            plausible = plausible_amplitudes(sizes, least, variable.max - variable.neutral, len(points))
            spreads[variable.name] = np.minimum(plausible, variable.prior_sd or np.inf)
            if sine_of(unknown) is not None:  # one amplitude for both components
                spreads[variable.name] = np.repeat(np.fmin(spreads[variable.name][::2], spreads[variable.name][1::2]), 2)
        self._probed[key] = spreads
        return spreads

    def _lanes(self, base: Fit, design: Design, reach: FloatArray) -> tuple[dict[str, float | str | FloatArray], FloatArray]:
        """Value sets (G q): each amplitude alone at each point of the design; and how far it is there from doing nothing, in its prior
        standard deviations (G q): less than its reach where it meets its bound."""
        rows, width = len(design.points), len(design.strengths)
        lanes: dict[str, float | str | FloatArray] = {**base.values, **neutral_values(design.effect)}
        reached = np.repeat(reach, width).reshape(rows, width)
        for place, variable in enumerate(design.strengths):
            column = np.full((rows, width), variable.neutral)
            spread = np.nan_to_num(design.spreads[variable.name])
            most = np.divide(variable.max - variable.neutral, spread, out=np.full(rows, np.inf), where=spread > 0)
            reached[:, place] = np.minimum(reach, most)
            column[:, place] = np.minimum(variable.neutral + reach * spread, variable.max)
            lanes[variable.name] = column.ravel()
        for place, parameter in enumerate(design.unknown):
            lanes[parameter.name] = np.repeat([parameter.value(float(u)) for u in design.points[:, place]], width)
        for name in {name for own in design.phases for name in own}:
            lanes[name] = np.repeat([own.get(name, 0.0) for own in design.phases], 2 * width)
        return lanes, reached.ravel()


def _of_any_size(design: Design, reach: FloatArray) -> tuple[Design, FloatArray]:
    """With a prior for each time that is tried as wide as it, where that is more than what is plausible: of what rings after a jump a
    hundredth of the period does a tenth as much, so that what is plausible says nothing of how long a time may be."""
    (own,) = design.strengths
    spread = design.spreads[own.name]
    wide = np.fmax(spread, reach * spread)
    return replace(design, spreads={own.name: wide}), np.divide(reach * spread, wide, out=np.ones_like(wide), where=wide > 0)


def _fewest_periods(effect: Effect, unit: str) -> float:
    """Within the longest recording or way: what a sensor shows more slowly is a drift of it."""
    if unit == WAY:
        return CONSTANTS.least_ripple
    return CONSTANTS.fewest_line_periods if effect.stage == "measurement" else CONSTANTS.fewest_turns


def _is_time(strengths: Sequence[Variable]) -> bool:
    """Whether what an effect does grows with a time alone."""
    return len(strengths) == 1 and strengths[0].unit == "s"


def _as_shape(variable: Variable) -> Parameter:
    low, high = max(variable.min, variable.neutral / 10), min(variable.max, variable.neutral * 10)
    return Parameter(variable.name, variable.unit, variable.neutral, math.log(high / low) / 4, low, high, True)
