"""In which coordinates is a parameter fitted, and what is known of it beforehand? Prior standard deviations from a prior mean.

A nominal parameter is known as well as its owner says. An effect's parameters are known by their units alone: an amplitude (it has a
neutral value) is as large as what it does to the outputs may plausibly be, the rest (times, frequencies, exponents) lies within what the
record can show: between its sample time and its length, and so on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import DISTANCE, Experiment
from evat.model import Effect, FloatArray, Model, Variable


@dataclass(frozen=True)
class Parameter:
    """value = mean + sd u, or mean exp(sd u) where `logarithmic`; u is standard normal a priori, or, of what has a `spike`, exactly 0 with
    the probability CONSTANTS.usual_form: those of one name together. `low` and `high` bound the value."""

    name: str
    unit: str
    mean: float
    sd: float
    low: float
    high: float
    logarithmic: bool = False
    spike: str = ""

    def value(self, u: float) -> float:
        value = self.mean * math.exp(self.sd * u) if self.logarithmic else self.mean + self.sd * u
        return min(max(value, self.low), self.high)

    def slope(self, u: float) -> float:
        """d value / d u."""
        return self.sd * (self.value(u) if self.logarithmic else 1.0)

    def place(self, value: float) -> float:
        """The u of a value."""
        return math.log(value / self.mean) / self.sd if self.logarithmic else (value - self.mean) / self.sd

    def within(self, u: float) -> float:
        """The nearest u whose value is within bounds."""
        low = self.place(self.low) if not self.logarithmic or self.low > 0 else -math.inf
        return min(max(u, low), self.place(self.high))


def nominal_parameters(model: Model, experiment: Experiment) -> tuple[Parameter, ...]:
    """Those of the nominal model that may be recalibrated: real and tunable, named in it, not exactly known, neither what
    each trial states for itself nor of an effect that is off."""
    stated = [set(trial.values) for trial in experiment.trials] + ([set(experiment.means.values)] if experiment.means is not None else [])
    by_all = set[str].intersection(*stated) if stated else set[str]()  # where only some state it, the others go by the nominal value
    off = {v.name for effect in model.effects if effect.name not in experiment.nominal.effects for v in effect.variables}
    parameters = []
    for variable in model.variables:
        value = experiment.nominal.values.get(variable.name)
        share = experiment.nominal.known_to(variable)
        if variable.type != "real" or variable.variability != "tunable" or not isinstance(value, (int, float)):
            continue
        if variable.name in by_all or variable.name in off or share == 0 or value == 0 or variable.reference:
            continue
        parameters.append(
            Parameter(variable.name, variable.unit, float(value), share, variable.min, variable.max, True)
            if value > 0 and variable.min >= 0
            else Parameter(variable.name, variable.unit, float(value), share * abs(value), variable.min, variable.max)
        )
    return tuple(parameters)


def form_parameters(model: Model, experiment: Experiment) -> tuple[Parameter, ...]:
    """Shapes of the base law that nobody knows exactly: outside of all effects, with a neutral value above 0, and not given by the user."""
    own = {variable.name for effect in model.effects for variable in effect.variables}
    return tuple(
        Parameter(v.name, v.unit, v.neutral, CONSTANTS.law_shape_sd, v.min, v.max, True, spike=v.name)
        for v in model.variables
        if v.name not in own and v.name not in experiment.nominal.values and v.type == "real" and v.variability == "tunable"
        if math.isfinite(v.neutral) and v.neutral > 0
    )


def at_usual_references(model: Model, experiment: Experiment) -> Experiment:
    """The same, with references that nobody stated (`Variable.reference`) at the usual magnitude of the record: there, other shapes of the
    law, and effects, do as much as their parameters say. Not of an effect of the nominal model, which stands as it is."""
    usual = Scales(model, experiment).usual
    acting = {v.name for effect in model.effects if effect.name in experiment.nominal.effects for v in effect.variables}
    unstated = [v for v in model.variables if v.reference and v.unit in usual and v.name not in acting]
    stated = {v.name: min(max(usual[v.unit], v.min), v.max) for v in unstated}  # a dead sensor shows no force
    return replace(experiment, nominal=replace(experiment.nominal, values={**stated, **experiment.nominal.values}))


def amplitudes(effect: Effect) -> tuple[Variable, ...]:
    return tuple(variable for variable in effect.variables if math.isfinite(variable.neutral) and variable.type == "real")


def shapes(effect: Effect) -> tuple[Variable, ...]:
    """What is not known of it beside its amplitudes. A reference is none: it says at what an amplitude is told."""
    return tuple(v for v in effect.variables if not math.isfinite(v.neutral) and v.type == "real" and not v.reference)


def references(effect: Effect) -> tuple[Variable, ...]:
    return tuple(variable for variable in effect.variables if variable.reference)


class Scales:
    """Which magnitudes does a record show? By unit, as a range."""

    def __init__(self, model: Model, experiment: Experiment) -> None:
        units = {variable.name: variable.unit for variable in model.variables}

        def rms(unit: str, columns: Mapping[str, FloatArray]) -> list[float]:
            return [float(np.sqrt(np.mean(column**2))) for name, column in columns.items() if units.get(name) == unit]

        clocks = [trial.times for trial in experiment.trials] or [np.arange(2.0)]
        self.step = float(np.median([float(np.median(np.diff(clock))) for clock in clocks if clock.size > 1] or [1.0]))
        self.duration = float(np.median([clock[-1] - clock[0] for clock in clocks]))
        outputs = [level for trial in experiment.trials for level in rms("N", trial.outputs)]
        if experiment.means is not None:
            outputs += rms("N", experiment.means.outputs)
        self.force = float(np.median(outputs)) if outputs else 1.0
        speeds = [level for trial in experiment.trials for level in rms("m/s", trial.inputs)]
        for trial in experiment.trials:
            speeds += [abs(value) for name, value in trial.values.items() if units.get(name) == "m/s"]
        speeds += [abs(v) for name, v in experiment.nominal.values.items() if units.get(name) == "m/s" and isinstance(v, float)]
        self.speed = float(np.median([speed for speed in speeds if speed > 0] or [0.1]))
        varied = [level for trial in experiment.trials for level in rms("m", trial.inputs)]
        for trial in experiment.trials:
            varied += [abs(value) for name, value in trial.values.items() if units.get(name) == "m" and name != DISTANCE]
        if experiment.means is not None:
            varied += rms("m", {name: column for name, column in experiment.means.values.items() if name != DISTANCE})
        # A feed that differs between cuts says more of how thick a chip is than the width of all of them.
        stated = [abs(v) for name, v in experiment.nominal.values.items() if units.get(name) == "m" and isinstance(v, float)]
        lengths = [length for length in varied if length > 0] or [length for length in stated if length > 0]
        slid = [trial.values.get(DISTANCE, 0.0) for trial in experiment.trials]  # before it, by a contact that wore on
        way = max(self.speed * self.duration, *slid) if slid else self.speed * self.duration
        self.length = float(np.median(lengths or [self.speed * self.duration]))
        self.distance = way if experiment.trials or not lengths else self.length  # means have no duration
        self.usual: Mapping[str, float] = {"s": self.duration, "N": self.force, "m/s": self.speed, "m": self.length}

    def span(self, variable: Variable) -> tuple[float, float]:
        """Smallest and largest value that the record could show anything of, within the variable's bounds."""
        start = abs(variable.start) or 1.0
        low, high = {
            "s": (0.5 * self.step, self.duration),
            "Hz": (0.5 / self.duration, 0.45 / self.step),
            "N": (0.1 * self.force, 10 * self.force),
            "m/s": (0.02 * self.speed, 5 * self.speed),
            "m": (min(self.length, 0.5 * self.speed * self.step), 3 * max(self.length, self.distance)),
            "N/m": (self.force / max(self.length, self.distance), 1e3 * self.force / min(self.length, self.distance)),
            "N.s/m": (1e-3 * self.force / self.speed, 10 * self.force / self.speed),
        }.get(variable.unit, (start / 5, start * 5))
        low, high = max(low, variable.min, 1e-300), min(high, variable.max)
        return (low, high) if low < high else (variable.min, variable.max)

    def amplitude(self, variable: Variable) -> float:
        """A first guess of how far an amplitude may be from its neutral value."""
        guess = {
            "N": 0.1 * self.force,
            "N/s": 0.1 * self.force / self.duration,
            "N.s/m": 0.1 * self.force / self.speed,
            "s": self.step,
            "m": 0.1 * self.length,
            "N/m": 0.1 * self.force / self.length,
        }.get(variable.unit, abs(variable.start - variable.neutral))
        return guess or 0.1


def shape_parameter(variable: Variable, scales: Scales) -> Parameter:
    """Anywhere within what the record can show; an angle within a turn. What has no unit (a damping ratio, an exponent) no record bounds:
    it stays as near to its start as effects of that name are known, or a resonance stands in for any filter."""
    if variable.unit == "rad" or variable.min < 0:
        return Parameter(variable.name, variable.unit, 0.0, 2.0, variable.min, variable.max)
    low, high = scales.span(variable)
    sd, beyond = max(math.log(high / low) / 4, 0.1), 1 if variable.unit == "1" else 3
    low, high, mean = max(variable.min, low / beyond), min(variable.max, high * beyond), math.sqrt(low * high)
    return Parameter(variable.name, variable.unit, mean, sd, low, high, True)


def shape_parameters(effect: Effect, scales: Scales) -> tuple[Parameter, ...]:
    """Of all shapes of an effect. What it changes for good goes on through a recording: what is over on the first hundredths of the way,
    in one recording after the other, is a state of the contact that each of them begins with."""
    parameters = [shape_parameter(variable, scales) for variable in shapes(effect)]
    if not effect.irreversible:
        return tuple(parameters)
    least = CONSTANTS.shortest_lasting * scales.distance
    return tuple(_at_least(least, each) if each.unit == "m" and each.low < least < each.high else each for each in parameters)


def _at_least(low: float, parameter: Parameter) -> Parameter:
    mean, spread = math.sqrt(low * parameter.high), math.log(parameter.high / low) / math.log(parameter.high / parameter.low)
    return replace(parameter, low=low, mean=mean, sd=parameter.sd * spread)


def law_parameters(
    variables: Sequence[Variable], known: Sequence[Parameter], given: Mapping[str, object], scales: Scales
) -> tuple[Parameter, ...]:
    """What another base law reads: as well known as it is where the nominal model has it, else anywhere within what the record can show."""
    named = {parameter.name for parameter in known} | set(given)
    more = [v for v in variables if v.name not in named and v.type == "real" and v.variability == "tunable" and v.min >= 0]
    return (*known, *(shape_parameter(variable, scales) for variable in more))


def amplitude_parameter(variable: Variable, sd: float) -> Parameter:
    return Parameter(variable.name, variable.unit, variable.neutral, sd, variable.min, variable.max)
