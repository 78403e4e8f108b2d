"""What does a model say to an experiment? One long vector of predicted values beside one of measured ones, for many value sets at once.

A recorded output is compared with what the model's sensor shows of it (`measured_<output>`, where there is one), a mean with the mean.
"""

from __future__ import annotations

import copy
import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.experiment import Experiment, ExperimentError, Means, Trial
from evat.inference.parameters import Parameter
from evat.inference.setup.clock import sample_times
from evat.inference.setup.setup_errors import SetupErrors, recording, without_zero, zero_of_input, zeros_of_inputs
from evat.model import FloatArray, Model, Run
from evat.threads import kept_threads

Values = Mapping[str, float | str | FloatArray]
TIGHTNESS = "relative_tolerance"
AVERAGING = "averaging_window"
BRISTLE = "bristle_deflection"  # a state of the model, whose start differs from trial to trial
OWN = "@"  # "variable@condition" or "variable@file": by how much a value is more there


@dataclass(frozen=True, slots=True)
class Segment:
    """A piece of the long vector: one output of one trial, or of all means. `trial` is its place in the experiment, -1 for means."""

    trial: int
    condition: str
    channel: str
    at: slice


@dataclass(frozen=True, slots=True)
class Linearised:
    """A parameter of the nominal law that is not simulated anew each time: the model runs with it at `at` (in its prior standard
    deviations), and each of these adds `column` (N,). One that no law has is a form of any."""

    parameter: Parameter
    at: float
    column: FloatArray


def at_tolerance_of_records(model: Model, experiment: Experiment) -> Experiment:
    """The same, with the solver's tolerance at which records are compared, unless it is stated or there are means."""
    if experiment.means is not None or all(variable.name != TIGHTNESS for variable in model.variables):
        return experiment
    values = {TIGHTNESS: CONSTANTS.solver_tolerance_of_records, **experiment.nominal.values}
    return replace(experiment, nominal=replace(experiment.nominal, values=values))


class Prediction:
    """An experiment and a model of it.

    Values are those of the model's variables and of the `setup` errors. `measured` has the shape (N,): all that was measured, segment
    after segment (`segments`: trial by trial, in each channel by channel; means last, row by row). All numbers SI.
    """

    def __init__(self, model: Model, experiment: Experiment) -> None:
        self.model, self.experiment, self.threads = model, experiment, runs_at_a_time(model)
        self._names = {variable.name for variable in model.variables}
        self.linearised: tuple[Linearised, ...] = ()
        self.starts: Mapping[str, float] = {}
        self.steady: Mapping[str, float] = {}
        segments, measured, at = list[Segment](), list[FloatArray](), 0
        for place, trial in enumerate(experiment.trials):
            for channel, column in trial.outputs.items():
                segments.append(Segment(place, trial.condition, channel, slice(at, at + column.size)))
                measured.append(column)
                at += column.size
        if experiment.means is not None:
            for channel, column in experiment.means.outputs.items():
                for row, condition in enumerate(experiment.means.conditions):
                    segments.append(Segment(-1, condition, channel, slice(at + row, at + row + 1)))
                measured.append(column)
                at += column.size
        if not at:
            raise ExperimentError(f"{experiment.title!r}: nothing was measured that could be compared.")
        self.segments: tuple[Segment, ...] = tuple(segments)
        self.measured: FloatArray = np.concatenate(measured)
        recordings = tuple(recording(experiment, s.channel, s.at, s.trial) for s in segments)
        self.bent: FloatArray = np.zeros(self.measured.size)
        self.own_start: FloatArray = np.zeros(self.measured.size)
        units = {v.name: v.unit for v in model.variables}
        self.setup = SetupErrors(experiment, recordings, self.measured, units)
        self.input_zeros = zeros_of_inputs(experiment, units)
        self._zero_names = frozenset(zero_of_input(name) for trial in experiment.trials for name in trial.inputs)
        self.form_names = frozenset[str]()
        self.apart = self.over_intervals = False

    @property
    def setup_names(self) -> frozenset[str]:
        """Of all set-up errors, those of recorded inputs among them."""
        return self.setup.names | self._zero_names

    @property
    def channels(self) -> tuple[str, ...]:
        """What was measured, in the order of the segments."""
        return tuple(dict.fromkeys(segment.channel for segment in self.segments))

    def places(self, channel: str) -> npt.NDArray[np.intp]:
        """Where one channel stands in the long vectors."""
        return np.concatenate([np.arange(s.at.start, s.at.stop) for s in self.segments if s.channel == channel])

    def recordings(self, column: FloatArray) -> dict[str, list[FloatArray]]:
        """A long vector (N,) channel by channel, a row for each recording; means have no neighbours and are left out."""
        rows: dict[str, list[FloatArray]] = {}
        for segment in self.segments:
            if segment.trial >= 0:
                rows.setdefault(segment.channel, []).append(column[segment.at])
        return rows

    def variable_of(self, output: str) -> str:
        """The model's variable that stands for a measured output."""
        head, tail = ("mean_", output[5:]) if output.startswith("mean_") else ("", output)
        sensor = f"{head}measured_{tail}"
        return sensor if sensor in self._names else output

    @cached_property
    def nominal(self) -> dict[str, float | str]:
        """The experiment's nominal values, with a tolerance that suits differences between runs unless they have their own."""
        fine = {TIGHTNESS: CONSTANTS.solver_tolerance} if TIGHTNESS in self._names else {}
        return {**fine, **self.experiment.nominal.values}

    @cached_property
    def alike(self) -> dict[int, bytes]:
        """Which trials repeat each other: those that run alike, unless each is a motion by itself."""
        return {place: key + str(place).encode() for place, key in self._runs.items()} if self.apart else self._runs

    def each_apart(self) -> Prediction:
        """The same with every trial a motion by itself, as where something that no model has in step goes through repeats."""
        other = copy.copy(self)
        other.__dict__.pop("alike", None)
        other.apart = True
        return other

    @cached_property
    def _runs(self) -> dict[int, bytes]:
        """What each trial runs along: repeats that share inputs, clock and values are run once."""
        digests = {}
        for place, trial in enumerate(self.experiment.trials):
            digest = hashlib.sha256(repr((sorted(trial.values.items()), list(trial.inputs), list(trial.outputs))).encode())
            times, inputs, _ = with_lead_in(trial)
            for column in (times, *inputs.values()):
                digest.update(np.ascontiguousarray(column).tobytes())
            digests[place] = digest.digest()
        return digests

    def many(self, values: Values | None = None, on: Sequence[str] = ()) -> FloatArray:
        """Predictions of K value sets: (K, N), nan where a set fails; K = 1 where no value is an array.

        values : override the nominal ones; what a trial states for itself counts before both.
        on : effects that are on, beside the nominal ones.
        """
        values = values or {}
        sampled = self._sampled_as(values)
        rows = sampled._of_model(self._simulated(values), on)
        for each in self._linear(values):
            rows = rows + self._away(each, values) * each.column
        return sampled.setup.applied(rows, values)

    def linearise(self, parameters: Sequence[Linearised]) -> Prediction:
        """The same, with these parameters entering linearly as long as the law is the nominal one."""
        other = copy.copy(self)
        other.linearised = tuple(parameters)
        other.form_names = frozenset(each.parameter.name for each in parameters) - self._names - self.setup_names
        return other

    def starting(self, starts: Mapping[str, float], bent: FloatArray | None, steady: Mapping[str, float] | None = None) -> Prediction:
        """The same with bristles that are bent at the start. By the files of trials, `starts` is how far [m], and `steady` how far steady
        slip bends them; `bent` (N,) is what as much more at the start of each trial changes in the prediction."""
        other = copy.copy(self)
        other.starts, other.steady = dict(starts), dict(steady or {})
        other.bent = np.zeros(self.measured.size) if bent is None else bent
        other.own_start = other._own_start()
        return other

    def _own_start(self) -> FloatArray:
        """What the start of each trial changes beside that of the first with its motion, (N,): these are simulated once, also where each
        is compared by itself."""
        own, first = np.zeros(self.measured.size), dict[bytes, str]()
        for segment in self.segments:
            if segment.trial < 0:
                continue
            file = self.experiment.trials[segment.trial].file
            shared = first.setdefault(self._runs[segment.trial], file)
            further = self.starts.get(file, 0.0) - self.starts.get(shared, 0.0)
            if further and self.steady.get(file, 0.0) > 0:
                own[segment.at] = further / self.steady[file] * self.bent[segment.at]
        return own

    def with_slopes_over_intervals(self) -> Prediction:
        """The same with derivatives of means over sampling intervals, which have one where a jump moves through samples."""
        other = copy.copy(self)
        other.over_intervals = True
        return other

    def sampled_at(self, clocks: Mapping[str, float]) -> Prediction:
        """The same with runs in which the channels of a record are so late [s], by name: a jump is then where it is between two samples."""
        other = copy.copy(self)
        other.setup = self.setup.sampled_at(clocks)
        return other

    def _sampled_as(self, values: Values) -> Prediction:
        """The same with runs sampled where these values tell that the channels were, if the force jumps by itself: each model then has
        clocks of its own, and not those of another shifted by interpolation, which rounds its jumps."""
        late = {name: float(np.asarray(value)) for name, value in values.items() if name in self.setup.names and np.ndim(value) == 0}
        setup = self.setup.late_as(late) if self.jumps else self.setup
        if setup is self.setup:
            return self
        other = copy.copy(self)
        other.setup = setup
        return other

    def set_up_as(self, whole: Prediction) -> Prediction:
        """The same with the set-up errors of another, of whose records these are parts, and runs sampled as there."""
        other = copy.copy(self)
        other.setup = whole.setup.of(self.setup.recordings)
        return other

    def of_model_alone(self, values: Values) -> Values:
        """Values without those of the set-up errors and of forms that no law has."""
        return {name: value for name, value in values.items() if name not in self.setup_names and name not in self.form_names}

    def of(self, experiment: Experiment) -> Prediction:
        """Another experiment by the same model, its linearised parameters held; trials start as those of their files did, and all repeats
        as the first of them."""
        other = Prediction(self.model, experiment).starting(self.starts, None, self.steady).set_up_as(self)
        other.apart = self.apart
        return other.linearise([replace(each, column=np.zeros(other.measured.size)) for each in self.linearised])

    def running_the_law(self) -> Prediction:
        """The same with shapes of the law run, and not held where they are linearised: linear stays what no law has."""
        return self.linearise([each for each in self.linearised if each.parameter.name not in self._names])

    def _has_nominal_law(self, values: Values) -> bool:
        return all(self.nominal.get(name) == value for name, value in values.items() if isinstance(value, str))

    def _linear(self, values: Values) -> tuple[Linearised, ...]:
        """What enters linearly here: shapes of the law where it is the nominal one, the zero of an input where it is named."""
        nominal, anyway = self._has_nominal_law(values), self.setup_names | self.form_names
        return tuple(e for e in self.linearised if (e.parameter.name in values if e.parameter.name in anyway else nominal))

    def _simulated(self, values: Values) -> Values:
        """What is simulated: set-up errors of inputs alone, and linearised parameters where they are held."""
        inner = {name: value for name, value in values.items() if name not in self.setup.names}
        return {**inner, **{each.parameter.name: each.parameter.value(each.at) for each in self._linear(values)}}

    def _away(self, each: Linearised, values: Values) -> FloatArray:
        """Prior standard deviations (K, 1) or (1, 1) from where a linearised parameter is held."""
        given = np.atleast_1d(np.asarray(values.get(each.parameter.name, each.parameter.mean), dtype=np.float64))
        away: FloatArray = np.array([[each.parameter.place(float(value)) - each.at] for value in given])
        return away

    def _of_model(self, values: Values, on: Sequence[str], smooth: bool = False) -> FloatArray:
        """The same without set-up errors of what was measured. smooth : means over a sampling interval about each sample: where a jump
        moves from one sample to the next these change by as much as it has moved, and samples by nothing or by all of it."""
        effects = tuple(dict.fromkeys((*self.experiment.nominal.effects, *on)))
        count = max([np.size(value) for value in values.values() if np.ndim(value) == 1], default=1)
        plain = self.of_model_alone({name: value for name, value in values.items() if OWN not in name})
        moved = {place: _moved(trial, values, plain) for place, trial in enumerate(self.experiment.trials)}

        def of_trial(place: int) -> FloatArray:
            trial = self.experiment.trials[place]
            times, inputs, before = with_lead_in(trial)
            sampled, places = sample_times(times, [self.setup.late(channel, times - trial.times[0]) for channel in trial.outputs])
            inputs = without_zero(inputs, values)
            shown = tuple(self.variable_of(channel) for channel in trial.outputs)
            start = {BRISTLE: self.starts[trial.file]} if trial.file in self.starts else {}
            held = {**start, **self._own({**plain, **moved[place][1]}, trial.values)}
            if smooth and (means := self._over_intervals(times, inputs, shown, effects, held)) is not None:
                middles, table = means
                at_samples = [_interpolated(sampled[at][before:], middles, table[name]) for name, at in zip(shown, places, strict=True)]
                return _side_by_side([np.broadcast_to(rows, (count, rows.shape[1])) for rows in at_samples])
            if sampled is not times:
                inputs = {name: np.interp(sampled, times, column) for name, column in inputs.items()}
            run = Run(sampled, inputs, shown)
            rows = self.model.simulate_many(run, effects, held)
            own = slice(before, None)  # where all are sampled alike, a view
            return _side_by_side(
                [
                    np.broadcast_to(rows[name], (count, sampled.size))[:, own if sampled is times else at[own]]
                    for name, at in zip(shown, places, strict=True)
                ]
            )

        keys = [(key, moved[place][0]) for place, key in self._runs.items()]
        once = dict[tuple[bytes, tuple[str, ...]], int]()
        for place, key in enumerate(keys):
            once.setdefault(key, place)
        if self.threads == 1 or len(once) == 1:
            rows = {key: of_trial(place) for key, place in once.items()}
        else:
            rows = dict(zip(once, kept_threads("trials", self.threads).map(of_trial, once.values()), strict=True))
        blocks = [rows[key] for key in keys]
        if self.experiment.means is not None:
            blocks.append(self._means(self.experiment.means, effects, values, count))
        return _side_by_side(blocks) + self.own_start

    def _over_intervals(
        self, times: FloatArray, inputs: Mapping[str, FloatArray], shown: Sequence[str], effects: Sequence[str], values: Values
    ) -> tuple[FloatArray, Mapping[str, FloatArray]] | None:
        """Middles of sampling intervals (n,) and the means of outputs over them (K, n); None where the model tells none."""
        step = float(np.median(np.diff(times)))
        clock = times[0] + step * np.arange(round((times[-1] - times[0]) / step) + 2)
        if not {AVERAGING, *(f"mean_{name}" for name in shown)} <= self._names or clock.size > 2 * times.size:
            return None
        run = Run(
            clock, {name: np.interp(clock, times, column) for name, column in inputs.items()}, tuple(f"mean_{name}" for name in shown)
        )
        rows = self.model.simulate_many(run, effects, {**values, AVERAGING: step})
        return clock[1:] - step / 2, {name: rows[f"mean_{name}"][:, 1:] for name in shown}

    def one(self, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> FloatArray:
        """Prediction of one value set, (N,)."""
        row: FloatArray = self.many(values or {}, on)[0]
        return row

    def numerical_error(self, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> FloatArray:
        """What the solver's tolerance leaves in a prediction, (N,): its change when the tolerance is a hundred times tighter."""
        if TIGHTNESS not in self.nominal:
            return np.zeros(self.measured.size)
        own = {**self.nominal, **(values or {})}
        least = next(variable.min for variable in self.model.variables if variable.name == TIGHTNESS)
        finer = {**own, TIGHTNESS: max(float(own[TIGHTNESS]) / 100, least)}
        return self.one(own, on) - self.one(finer, on)

    def jacobian(
        self,
        values: Mapping[str, float | str],
        names: Sequence[str],
        scales: Mapping[str, float],
        on: Sequence[str] = (),
        *,
        prior: bool = True,
    ) -> tuple[FloatArray, FloatArray]:
        """The prediction (N,) and its derivatives (N, p) with respect to `names` times their `scales`, by one-sided differences.

        A step goes towards the inside of a variable's bounds. prior : the scales are prior standard deviations, by one of which no number
        changes by more than counts; else they say no more than how long a step is.
        """
        if (sampled := self._sampled_as(values)) is not self:
            return sampled.jacobian(values, names, scales, on, prior=prior)
        bounds = {variable.name: variable for variable in self.model.variables}
        linear = {e.parameter.name: e for e in self._linear(values)}
        own = [name for name in names if name not in self.setup.names and name not in linear]
        size = np.array([scales[name] for name in own])
        point = np.array([float(values[name]) for name in own])
        low, high = (np.array([getattr(bounds[name], end) for name in own]) for end in ("min", "max"))
        smooth = self.jumps and self.over_intervals
        step = (CONSTANTS.derivative_step if smooth or not self.jumps else CONSTANTS.derivative_step_across_jumps) * size
        steps = np.where(
            (step <= high - point) | (high - point >= point - low), np.minimum(step, high - point), -np.minimum(step, point - low)
        )
        table = np.clip(point + np.vstack([np.zeros(len(own)), np.diag(steps)]), low, high)
        lanes = {name: table[:, place] for place, name in enumerate(own)}
        rows = self._of_model({**self._simulated(values), **lanes}, on, smooth=smooth)
        here = self._of_model(self._simulated(values), on)[0] if smooth else rows[0]
        here = here + sum((self._away(each, values)[0] * each.column for each in linear.values()), np.zeros(1))
        most = self._steepest(here) if prior else np.inf
        inner = [np.clip((row - rows[0]) / (step / scale), -most, most) for row, step, scale in zip(rows[1:], steps, size, strict=False)]
        for name in (name for name in linear if name in names):
            parameter = linear[name].parameter
            inner.append(scales[name] / parameter.slope(parameter.place(float(values[name]))) * linear[name].column)
        table = self.setup.linear(np.array(inner).reshape(len(inner), self.measured.size), values)
        of_model = dict(zip([*own, *(name for name in linear if name in names)], table, strict=True))
        slopes = [of_model[name] if name in of_model else scales[name] * self.setup.slopes(here, name, values) for name in names]
        return self.setup.applied(here[None], values)[0], np.array(slopes).reshape(len(names), self.measured.size).T

    @cached_property
    def jumps(self) -> bool:
        """Does the force jump where the model says so? Where a motion that it makes itself is recorded over time, as the tool enters and
        leaves the work."""
        return bool(self.experiment.trials) and math.isfinite(self.model.cycle_time(self.nominal))

    def _steepest(self, predicted: FloatArray) -> FloatArray:
        """The most that one prior standard deviation of a parameter counts for in each number (N,): what is far beyond all that was
        measured, and predicted, tells no more, and its square would leave nothing of the prior's."""
        most = np.empty(self.measured.size)
        for channel in self.channels:
            at = self.places(channel)
            largest = np.max(np.abs([self.measured[at], predicted[at]]), initial=0.0, where=np.isfinite([self.measured[at], predicted[at]]))
            most[at] = CONSTANTS.steepest_slope * float(largest)
        return most

    def _own(self, values: Values, of_trial: Mapping[str, float]) -> dict[str, float | str | FloatArray]:
        return {**self.nominal, **values, **of_trial}

    def _means(self, means: Means, effects: Sequence[str], values: Values, count: int) -> FloatArray:
        """All rows of all sets in one call: (count, channels * rows). Rows of one condition (replicates) are simulated once."""
        columns = np.column_stack([*means.values.values(), np.zeros(len(means.conditions))])
        distinct, row_of = np.unique(columns, axis=0, return_inverse=True)
        rows = len(distinct)
        own = self._own(self.of_model_alone(values), {})
        # The sets of a row are neighbours: lanes that move alike step alike, in half of the time.
        sets = {name: np.tile(value, rows) if np.ndim(value) == 1 else value for name, value in own.items()}
        sets.update({name: np.repeat(column, count) for name, column in zip(means.values, distinct.T, strict=False)})
        names = {channel: self.variable_of(channel) for channel in means.outputs}
        settled = self.model.settled(tuple(dict.fromkeys(names.values())), effects, sets)
        return np.concatenate([settled[name].reshape(rows, count)[row_of.ravel()].T for name in names.values()], axis=1)


def runs_at_a_time(model: Model) -> int:
    """As many as a model's `threads` say, where it has them: None is one for each processor. Of another, one."""
    threads = getattr(model, "threads", 1)
    return threads or os.cpu_count() or 1


def _interpolated(at: FloatArray, times: FloatArray, rows: FloatArray) -> FloatArray:
    """Rows (K, n) at other times, (K, m); constant beyond the ends."""
    place = np.clip(np.searchsorted(times, at) - 1, 0, times.size - 2)
    share = np.clip((at - times[place]) / (times[place + 1] - times[place]), 0.0, 1.0)
    between: FloatArray = rows[:, place] * (1 - share) + rows[:, place + 1] * share
    return between


def _side_by_side(blocks: Sequence[FloatArray]) -> FloatArray:
    """(K, ...) beside each other; one alone is not copied, since it may be as long as a record of minutes."""
    return blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=1)


def _moved(trial: Trial, values: Values, plain: Values) -> tuple[tuple[str, ...], dict[str, FloatArray]]:
    """Names of the values that its condition or the trial has by itself, and what the variables then are; not of effects that are off.

    Such a value is the phase of a sine: a sum of two may be beyond its bounds, and a whole turn is none.
    """
    names = tuple(
        name
        for name in values
        if OWN in name and name.partition(OWN)[2] in (trial.condition, trial.file) and name.partition(OWN)[0] in plain
    )
    own = {name.partition(OWN)[0]: np.asarray(values[name]) for name in names}
    sums = {name: np.asarray(plain[name], dtype=np.float64) + shift for name, shift in own.items()}
    return names, {name: np.where(np.abs(sum_) > math.tau, np.remainder(sum_, math.tau), sum_) for name, sum_ in sums.items()}


def with_lead_in(trial: Trial) -> tuple[FloatArray, Mapping[str, FloatArray], int]:
    """Times and inputs of all that is run, and how many samples of it come before the trial."""
    lead = trial.lead_in
    if lead is None:
        return trial.times, trial.inputs, 0
    inputs = {name: np.concatenate([lead.inputs[name], column]) for name, column in trial.inputs.items()}
    return np.concatenate([lead.times, trial.times]), inputs, lead.times.size
