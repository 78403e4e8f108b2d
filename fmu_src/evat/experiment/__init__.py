"""What is a measured experiment? Signals, trials, means, and the model as its owner believes it today. SI throughout."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from evat.model import EvatError, FloatArray, Variable
from evat.units import base_unit

Role = Literal["input", "output"]
DISTANCE = "sliding_distance"  # how far a contact has slid; effects go by it

InitialBristle = Literal["relaxed", "slid_in", "free"]

FEWEST_ROWS = 3  # of a recording, or of a stretch of one


class ExperimentError(EvatError):
    """An experiment that cannot be used as it stands; names file, line, column or row, and what to do.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=1, speeds=[0.5], rate=100.0)
    >>> try:
    ...     made.only(["speed 7"])
    ... except evat.ExperimentError as error:
    ...     print(error)
    'Orthogonal cutting tests, simulated: ramp': asked for conditions 'speed 7'; it has 'speed 1'.
    """


@dataclass(frozen=True, slots=True)
class Signal:
    """One measured quantity: a variable of the component and where it stands in the data files.

    `unit` is the one typed in the file; `full_scale` (the sensor's range, to both sides of `offset`) is in SI. A clock has no role. The
    variable is sign scale value + offset, value in the SI unit of the column; without a `scale` the unit measures what the variable does.
    `of` = "position": the variable is the derivative of that. With a `radius` [m] the column is an angle, its speed, or a torque.
    """

    name: str
    column: str
    unit: str
    role: Role | None
    full_scale: float | None = None
    sign: int = 1
    scale: float | None = None
    offset: float = 0.0
    of: Literal["", "position"] = ""
    radius: float | None = None

    @property
    def converted(self) -> bool:
        """Whether more than its unit is changed where it is read."""
        return self.sign != 1 or self.scale is not None or self.offset != 0 or bool(self.of) or self.radius is not None

    @property
    def shown_in(self) -> str:
        """The unit in which its owner reads the variable: that of the file, or, of the derivative of a position, that length a second;
        "" where a scale or a lever arm makes another quantity of the column."""
        if self.of == "position":
            return f"{self.unit}/s" if self.scale is None and self.radius is None else "mm/s"
        return self.unit if self.scale is None and self.radius is None else ""


def as_typed(variable: Variable, signals: Mapping[str, Signal]) -> Variable:
    """The variable to be shown in the unit of its owner's files, where they measure it, or something else that has a unit of its kind."""
    own = signals.get(variable.name)
    unit = "" if own is None else own.shown_in
    if own is None and variable.unit not in ("", "1"):
        kind = base_unit(variable.unit).exponents
        recorded = (each.shown_in for each in signals.values() if each.role is not None)
        unit = next((each for each in recorded if each and base_unit(each).exponents == kind), "")
    return replace(variable, display_unit=unit) if unit else variable


@dataclass(frozen=True, slots=True)
class Nominal:
    """The model as its owner believes it today.

    `values` are complete (the parameter set with what overrides it; friction_law and kinematics are names of choices), `relative_sd` holds
    only what was given; for the rest `default_relative_sd` counts, of a temperature TEMPERATURE_SD at most. `parameters` names the set or
    its file, "" where there is none. `initial_bristle` says how bristles are bent when a trial begins: not at all, as in steady slip, or
    anyhow.
    """

    TEMPERATURE_SD: ClassVar[float] = 0.01  # 3 K of an ambient one: a tenth of what is counted from absolute zero is 30 K

    values: Mapping[str, float | str]
    effects: tuple[str, ...]
    relative_sd: Mapping[str, float]
    default_relative_sd: float = 0.1
    parameters: str = ""
    initial_bristle: InitialBristle = "free"

    def known_to(self, variable: Variable) -> float:
        """The standard deviation of its value, as a share of it."""
        usual = min(self.default_relative_sd, self.TEMPERATURE_SD) if variable.unit == "K" else self.default_relative_sd
        return self.relative_sd.get(variable.name, usual)


@dataclass(frozen=True, slots=True)
class SetupSd:
    """How far a channel may be off in all trials alike, as standard deviations: its gain [1], its zero [unit of the channel], its clock
    [s] and the rate at which that drifts beside a recorded motion's [s/s]. None: ZERO_OF_RMS of its root mean square, and one sample."""

    ZERO_OF_RMS: ClassVar[float] = 0.01

    gain: float = 0.01
    zero: float | None = None
    clock: float | None = None
    clock_drift: float = 2e-4  # two quartz clocks, of 100 ppm each at worst


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One recording: every column has shape (n,), in SI; `values` are what the component's parameters were in it. `lead_in` is what was
    recorded just before and does not count: a model runs through it to where the recording begins. `noise_sd` is that of a sample of an
    output, where its owner stated one; `position_sd` that of the position [m] which an input was differentiated from."""

    file: str
    condition: str
    values: Mapping[str, float]
    times: FloatArray
    inputs: Mapping[str, FloatArray]
    outputs: Mapping[str, FloatArray]
    lead_in: Trial | None = None
    noise_sd: Mapping[str, float] = field(default_factory=dict)
    position_sd: Mapping[str, float] = field(default_factory=dict)

    @property
    def sampling_interval(self) -> float:
        """The usual one [s]; of at least two samples."""
        return float(np.median(np.diff(self.times)))

    def __repr__(self) -> str:
        span = f", {self.times[0]:g} to {self.times[-1]:g} s" if self.times.size else ""
        return (
            f"<Trial {self.file}: condition {self.condition}, {self.times.size} samples{span}; {', '.join([*self.inputs, *self.outputs])}>"
        )

    def head(self, count: int) -> Trial:
        """Its first samples."""
        return self.between(0, count)

    def between(self, begin: int, end: int) -> Trial:
        """Its samples from `begin` on, up to `end`, with the lead-in of the whole."""
        inputs, outputs = ({name: column[begin:end] for name, column in some.items()} for some in (self.inputs, self.outputs))
        return replace(self, times=self.times[begin:end], inputs=inputs, outputs=outputs)

    def with_input(self, name: str, change: Callable[[FloatArray], FloatArray]) -> Trial:
        """An input changed, and what was recorded of it just before alike: a model that runs through other numbers begins elsewhere."""
        lead = None if self.lead_in is None else self.lead_in.with_input(name, change)
        inputs = {**self.inputs, name: change(self.inputs[name])} if name in self.inputs else self.inputs
        return replace(self, inputs=inputs, lead_in=lead)


@dataclass(frozen=True, slots=True, eq=False)
class Means:
    """Averages, a row per condition: `values` (what varied), `outputs` and, where given, their `sd`, each of shape (rows,), in SI."""

    file: str
    conditions: tuple[str, ...]
    values: Mapping[str, FloatArray]
    outputs: Mapping[str, FloatArray]
    sd: Mapping[str, FloatArray]

    def only(self, conditions: Collection[str]) -> Means | None:
        """The rows of these conditions; None where there are none."""
        kept = [row for row, condition in enumerate(self.conditions) if condition in conditions]
        if not kept:
            return None
        values, outputs, sd = ({name: column[kept] for name, column in some.items()} for some in (self.values, self.outputs, self.sd))
        return Means(self.file, tuple(self.conditions[row] for row in kept), values, outputs, sd)


@dataclass(frozen=True, slots=True)
class Remark:
    """A sentence on a recording, told where it was read; a `doubt` is one on all that is made of its numbers."""

    text: str
    doubt: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """Everything that was measured on one contact: what `evat.read_experiment` and `evat.orthogonal` give.

    Attributes
    ----------
    folder : Path
        Where its files are.
    title, intended_use : str
        As its owner says it.
    nominal : Nominal
        The model as its owner believes it: `values`, `effects`, and `relative_sd` of the values.
    signals : mapping of str to Signal
        By variable, the column and unit in the files.
    trials : tuple of Trial
        Recordings: `times` [s], `inputs` and `outputs` of shape (n,), SI; `condition`, and `values` that were held in it.
    means : Means or None
        Averages, a row for each condition.
    data_hash : str
        Over the bytes of the files that it was read from.
    setup_sd : mapping of str to SetupSd
        By channel, how far the set-up may be off, where its owner stated anything.
    day : str
        That of the newest file; "" where there are none.
    remarks : tuple of Remark
        What its owner should know of the files, such as of a sensor at the end of its range.
    mass : float
        Of what moves with the slip [kg], as its owner states it: so much inertia was taken off the friction force.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=2, speeds=[0.5], rate=100.0)
    >>> made.conditions, made.outputs, len(made.trials)
    (('speed 1',), ('friction_force',), 2)
    >>> made.trials[0].outputs["friction_force"].shape == made.trials[0].times.shape
    True
    """

    folder: Path
    title: str
    intended_use: str
    nominal: Nominal
    signals: Mapping[str, Signal]
    trials: tuple[Trial, ...]
    means: Means | None
    data_hash: str
    setup_sd: Mapping[str, SetupSd] = field(default_factory=dict)
    day: str = ""
    remarks: tuple[Remark, ...] = ()
    mass: float = 0.0

    def __repr__(self) -> str:
        rows = f", {len(self.means.conditions)} rows of averages" if self.means is not None else ""
        held = f"{len(self.trials)} trials{rows} of {len(self.conditions)} conditions"
        return f"<Experiment {self.title!r}: {held}; measured: {', '.join(self.outputs)}>"

    @property
    def conditions(self) -> tuple[str, ...]:
        """Each condition once, in the order of the files."""
        of_means = self.means.conditions if self.means is not None else ()
        return tuple(dict.fromkeys([*(trial.condition for trial in self.trials), *of_means]))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of what was measured and is to be predicted: recorded outputs, then means."""
        recorded = [name for name, signal in self.signals.items() if signal.role == "output"]
        return tuple(dict.fromkeys([*recorded, *(self.means.outputs if self.means is not None else ())]))

    @property
    def given(self) -> frozenset[str]:
        """Variables that it states itself, beside the nominal model: recorded inputs, and values of trials and means."""
        return self.recorded | self.stated

    @property
    def recorded(self) -> frozenset[str]:
        """Inputs with a column in the files of trials."""
        return frozenset(name for trial in self.trials for name in trial.inputs)

    @property
    def stated(self) -> frozenset[str]:
        """Variables that trials and means state a value of."""
        return frozenset(name for trial in self.trials for name in trial.values) | frozenset(self.means.values if self.means else ())

    @property
    def samples(self) -> int:
        """Measured numbers in all: samples of every output of every trial, and means."""
        recorded = sum(column.size for trial in self.trials for column in trial.outputs.values())
        return recorded + sum(column.size for column in (self.means.outputs.values() if self.means is not None else ()))

    def only(self, conditions: Collection[str]) -> Experiment:
        """The same experiment with these conditions alone; ExperimentError where one is not in it, or none is asked for."""
        unknown = [condition for condition in conditions if condition not in self.conditions]
        if unknown or not conditions:
            asked = ", ".join(map(repr, unknown)) or "none"
            raise ExperimentError(f"{self.title!r}: asked for conditions {asked}; it has {', '.join(map(repr, self.conditions))}.")
        trials = tuple(trial for trial in self.trials if trial.condition in conditions)
        means = self.means.only(conditions) if self.means is not None else None
        return replace(self, trials=trials, means=means)
