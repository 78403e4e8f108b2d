"""How far may a whole set-up be off? Gain, zero, clock and its drift of each channel, and the mass that moves between contact and sensor,
which all trials share, as parameters of every fit.

No rig is without them: an amplifier's gain is known to a percent, its zero drifts before the first recording, the force lags or leads the
motion by a sample, and by another at the end of a long recording where two clocks count. Model parameters run away where they have to
stand in for these.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, SetupSd
from evat.inference.parameters import Parameter
from evat.inference.setup.rest import rests, sd_of_zero
from evat.model import FloatArray
from evat.required_inputs import FRICTION, MOTION, PROXY

GAIN, ZERO, CLOCK, CLOCK_DRIFT, MASS = "gain", "zero", "clock", "clock_drift", "mass"


@dataclass(frozen=True, slots=True)
class Recording:
    """Where one recording of a channel stands in the long vector, its sample times (n,), and the acceleration (n,) [m/s^2] of what moves
    between the contact and the sensor; neither of a mean."""

    channel: str
    at: slice
    times: FloatArray | None
    acceleration: FloatArray | None = None


class SetupErrors:
    """measured = (1 + gain) model(t - late) + zero + mass acceleration, for each channel, with late = clock + clock_drift (t - t_first),
    and mass what moves beside what its owner states. `parameters` are those that its recordings can show: a mean has no clock, and a drift
    is one beside that of a recorded motion or of what drives a vibration. `unstated_mass` is one that moves where none is stated, which few
    rigs have. A positive clock is a force that is late, or a motion that is early."""

    def __init__(self, experiment: Experiment, recordings: tuple[Recording, ...], measured: FloatArray, units: Mapping[str, str]) -> None:
        self.recordings = recordings
        self.stated_mass = experiment.mass
        self.clocks: Mapping[str, float] = {}
        self.drifts: Mapping[str, float] = {}
        self.unstated_mass: Parameter | None = None
        parameters = list[Parameter]()
        for channel in dict.fromkeys(recording.channel for recording in recordings):
            own = [recording for recording in recordings if recording.channel == channel]
            level = float(np.sqrt(np.mean(np.concatenate([measured[recording.at] for recording in own]) ** 2)))
            steps = [float(np.median(np.diff(r.times))) for r in own if r.times is not None and r.times.size > 1]
            longest = max([float(r.times[-1] - r.times[0]) for r in own if r.times is not None and r.times.size > 1], default=0.0)
            stated = experiment.setup_sd.get(channel, SetupSd())
            sizes = {
                GAIN: (stated.gain, "1"),
                ZERO: (stated.zero if stated.zero is not None else SetupSd.ZERO_OF_RMS * level, units.get(channel, "1")),
                CLOCK: (stated.clock if stated.clock is not None else float(np.median(steps or [0.0])), "s"),
                CLOCK_DRIFT: (stated.clock_drift, "1"),
            }
            if stated.clock_drift * longest < CONSTANTS.least_drift * float(np.median(steps or [np.inf])):
                del sizes[CLOCK_DRIFT]
            for kind, (sd, unit) in sizes.items():
                if sd > 0 and (kind != CLOCK or steps):
                    parameters.append(
                        Parameter(
                            _name(channel, kind), unit, 0.0, sd, -CONSTANTS.widest_setup_error * sd, CONSTANTS.widest_setup_error * sd
                        )
                    )
            accelerations = [r.acceleration for r in own if r.acceleration is not None]
            if accelerations and experiment.mass > 0:
                mass = experiment.mass  # nothing else is one with it, so that it may be off by far more than is likely
                parameters.append(
                    Parameter(_name(channel, MASS), "kg", 0.0, CONSTANTS.mass_sd * mass, -mass, CONSTANTS.largest_mass * mass)
                )
            elif accelerations:
                self.unstated_mass = _unstated_mass(_name(channel, MASS), level, np.concatenate(accelerations))
        self.parameters = tuple(parameters)
        self.names = frozenset(parameter.name for parameter in (*parameters, self.unstated_mass) if parameter is not None)

    def of(self, recordings: tuple[Recording, ...]) -> SetupErrors:
        """The same set-up, known as well, over other recordings: of a part of a record, too short to show a drift, it is none the less."""
        other = copy.copy(self)
        other.recordings = recordings
        return other

    def sampled_at(self, clocks: Mapping[str, float]) -> SetupErrors:
        """The same for runs in which each channel is as late as here [s]; values that are not named are these."""
        other = copy.copy(self)
        other.clocks = {channel: clock for channel, clock in clocks.items() if _name(channel, CLOCK) in self.names}
        other.drifts = {}
        return other

    def late_as(self, values: Mapping[str, float]) -> SetupErrors:
        """The same for runs in which each channel is as late as the clocks and drifts among these values, by name, say; itself where it is
        so already."""
        told = {name: value for name, value in values.items() if name in self.names and by_channel(name)[1] in (CLOCK, CLOCK_DRIFT)}
        if all(self._usual(name) == value for name, value in told.items()):
            return self
        other = copy.copy(self)
        other.clocks, other.drifts = (
            {**held, **{by_channel(name)[0]: value for name, value in told.items() if by_channel(name)[1] == kind}}
            for kind, held in ((CLOCK, self.clocks), (CLOCK_DRIFT, self.drifts))
        )
        return other

    def late(self, channel: str, since: FloatArray) -> FloatArray | float:
        """How late [s] a channel is in these runs, so long (n,) [s] after the first sample."""
        drift = self.drifts.get(channel, 0.0)
        return self.clocks.get(channel, 0.0) + (drift * since if drift else 0.0)

    def widest_clock(self, channel: str) -> float:
        """By how much the clock of a channel may be off, either way [s]."""
        return next((parameter.high for parameter in self.parameters if parameter.name == _name(channel, CLOCK)), 0.0)

    def start(self, parameter: Parameter) -> float:
        """Where one of `parameters` is in these runs, in its prior standard deviations."""
        return parameter.place(self._usual(parameter.name))

    def applied(self, rows: FloatArray, values: Mapping[str, float | str | FloatArray]) -> FloatArray:
        """Predictions (K, N) as this set-up would show them; values that are not named are 0, or the clocks of the runs."""
        return self._applied(rows, values, inertia=True)

    def _applied(self, rows: FloatArray, values: Mapping[str, float | str | FloatArray], inertia: bool) -> FloatArray:
        """inertia : what moves adds its own, as it does to a prediction and to no derivative of one."""
        late = (
            inertia and self.stated_mass > 0 and (any(self.clocks.values()) or any(self.drifts.values()))
        )  # in runs that are sampled there
        if not late and all(np.all(np.asarray(values.get(name, self._usual(name))) == self._usual(name)) for name in self.names):
            return rows
        count = max(rows.shape[0], *(np.size(values.get(name, 0.0)) for name in self.names)) if rows.shape[0] == 1 else rows.shape[0]
        recorded = np.repeat(rows, count // max(rows.shape[0], 1), axis=0) if rows.shape[0] != count else rows.copy()
        for recording in self.recordings:
            gain, zero = (self._value(recording.channel, kind, values) for kind in (GAIN, ZERO))
            shown = (1 + gain) * _shifted(recorded[:, recording.at], recording.times, *self._late(recording, values)) + zero
            recorded[:, recording.at] = shown + self._inertia(recording, values) if inertia else shown
        return recorded

    def _inertia(self, recording: Recording, values: Mapping[str, float | str | FloatArray], later: float = 0.0) -> FloatArray | float:
        """What a force shows of what moves, by its gain and its clock, and `later` [s] still, less what was taken off it as if both were
        right: (K, n) or (1, n)."""
        if recording.acceleration is None:
            return 0.0
        gain, mass = (self._value(recording.channel, kind, values) for kind in (GAIN, MASS))
        if not np.any(self.stated_mass + mass):
            return -self.stated_mass * recording.acceleration
        clock, drift = self._late(recording, values)
        clock = clock + self.clocks.get(recording.channel, 0.0) + later
        drift = drift + self.drifts.get(recording.channel, 0.0)
        motions = np.broadcast_to(recording.acceleration, (max(len(clock), len(drift)), recording.acceleration.size))
        shown = _shifted(motions, recording.times, clock, drift)
        return (1 + gain) * (self.stated_mass + mass) * shown - self.stated_mass * recording.acceleration

    def slopes(self, row: FloatArray, name: str, values: Mapping[str, float | str | FloatArray]) -> FloatArray:
        """Derivative (N,) of the prediction to one of `names`; row : (N,), of the model alone."""
        slope = np.zeros_like(row)
        for recording in self.recordings:
            if not name.startswith(_name(recording.channel, "")):
                continue
            own, times = row[None, recording.at], recording.times
            gain, (clock, drift) = self._value(recording.channel, GAIN, values), self._late(recording, values)
            if name == _name(recording.channel, ZERO):
                slope[recording.at] = 1.0
            elif name in (_name(recording.channel, GAIN), _name(recording.channel, MASS)):
                value = self._value(recording.channel, by_channel(name)[1], values)
                more, less = (self._inertia(recording, {**values, name: value + side}) for side in (0.5, -0.5))  # it is linear in either
                slope[recording.at] = np.ravel(more - less)
                if name == _name(recording.channel, GAIN):
                    slope[recording.at] += _shifted(own, times, clock, drift)[0]
            elif times is not None and times.size > 1:
                h = CONSTANTS.clock_shift * float(np.median(np.diff(times)))
                after, before = (
                    (1 + gain) * _shifted(own, times, clock + by, drift) + self._inertia(recording, values, by) for by in (h, -h)
                )
                grown = times - times[0] if name == _name(recording.channel, CLOCK_DRIFT) else 1.0
                slope[recording.at] = grown * np.ravel(after - before) / (2 * h)
        return slope

    def linear(self, slopes: FloatArray, values: Mapping[str, float | str | FloatArray]) -> FloatArray:
        """Derivatives (p, N) of the model alone to its own parameters, as derivatives of what this set-up shows."""
        scaled = {name: 0.0 if by_channel(name)[1] in (ZERO, MASS) else values.get(name, self._usual(name)) for name in self.names}
        return self._applied(slopes, scaled, inertia=False)

    def _value(self, channel: str, kind: str, values: Mapping[str, float | str | FloatArray]) -> FloatArray:
        """(K, 1) or (1, 1); of a clock, how far it is from that of the runs."""
        name = _name(channel, kind)
        value = values.get(name, self._usual(name)) if name in self.names else 0.0
        column: FloatArray = np.asarray(value, dtype=np.float64).reshape(-1, 1) - self._usual(name)
        return column

    def _late(self, recording: Recording, values: Mapping[str, float | str | FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Clock and its drift, each (K, 1) or (1, 1)."""
        clock, drift = (self._value(recording.channel, kind, values) for kind in (CLOCK, CLOCK_DRIFT))
        return clock, drift

    def _usual(self, name: str) -> float:
        channel, kind = by_channel(name)
        return {CLOCK: self.clocks, CLOCK_DRIFT: self.drifts}.get(kind, {}).get(channel, 0.0)


def _unstated_mass(name: str, level: float, acceleration: FloatArray) -> Parameter | None:
    """What moves between the contact and a sensor of whose mass nothing is said; None where nothing speeds up. level : rms of the force."""
    usual = float(np.sqrt(np.mean(acceleration**2)))
    if not usual > 0 or not level > 0:
        return None
    return Parameter(name, "kg", 0.0, CONSTANTS.unstated_inertia * level / usual, 0.0, CONSTANTS.largest_inertia * level / usual)


def recording(experiment: Experiment, channel: str, at: slice, place: int) -> Recording:
    """Of a channel of the trial at this place, -1 for means, where it stands `at`."""
    if place < 0:
        return Recording(channel, at, None)
    trial = experiment.trials[place]
    moves = channel == FRICTION and MOTION in trial.inputs and trial.times.size > 1
    return Recording(channel, at, trial.times, np.gradient(trial.inputs[MOTION], trial.times) if moves else None)


def zeros_of_inputs(experiment: Experiment, units: Mapping[str, str]) -> tuple[Parameter, ...]:
    """How far the zero of each recorded input may be off: by that of a slip velocity a contact at rest creeps, and friction reverses before
    or after it does in the record; that of a load or a thickness leans a force that is proportional to it.

    An input that shows its zero in the record has none, nor one that was differentiated from a position, nor one that stays as it is. Its
    gain is one of the law's parameters, its clock that of the force; the zero of a temperature proxy is one with the values at its
    reference.
    """
    recorded = dict.fromkeys(name for trial in experiment.trials for name in trial.inputs)
    return tuple(zero for name in recorded if name != PROXY if (zero := _zero_of_input(experiment, name, units.get(name, "1"))) is not None)


def _zero_of_input(experiment: Experiment, name: str, unit: str) -> Parameter | None:
    columns, signal = [trial.inputs[name] for trial in experiment.trials if name in trial.inputs], experiment.signals.get(name)
    if (signal is not None and signal.of) or all(np.all(column == columns[0][0]) for column in columns):
        return None
    sd = sd_of_zero(experiment, name)
    widest = CONSTANTS.widest_setup_error * sd
    if name == MOTION:
        shown = any(rest.largest == 0 for rest in rests(experiment).values())
    else:
        shown = min(float(np.min(column)) for column in columns) <= widest  # out of contact
    return Parameter(zero_of_input(name), unit, 0.0, sd, -widest, widest) if sd > 0 and not shown else None


def without_zero(inputs: Mapping[str, FloatArray], values: Mapping[str, float | str | FloatArray]) -> dict[str, FloatArray]:
    """Inputs, each freed of its zero where `values` has one."""
    zeros = {name: values[zero_of_input(name)] for name in inputs if zero_of_input(name) in values}
    return {name: column - float(np.asarray(zeros[name])) if name in zeros else column for name, column in inputs.items()}


def _name(channel: str, kind: str) -> str:
    return f"setup.{channel}.{kind}"


def zero_of_input(name: str) -> str:
    """Its set-up error, whatever part of an experiment is looked at, and whether that shows it."""
    return _name(name, ZERO)


def name_of_clock(channel: str) -> str:
    return _name(channel, CLOCK)


def by_channel(name: str) -> tuple[str, str]:
    """Channel and kind of a set-up error."""
    _, channel, kind = name.split(".")
    return channel, kind


def called(channel: str, kind: str) -> str:
    """A set-up error in words."""
    return "the moved mass" if kind == MASS else f"the {kind.replace('_', ' ')} of the {channel.replace('_', ' ')}"


def _shifted(rows: FloatArray, times: FloatArray | None, clock: FloatArray, drift: FloatArray) -> FloatArray:
    """rows (K, n) as they were `clock` (K, 1) or (1, 1) [s] before, and by `drift` [s/s] longer the later; held at the ends."""
    if times is None or times.size < 2 or not (np.any(clock) or np.any(drift)):
        return rows
    late = np.broadcast_to(clock + drift * (times - times[0]), rows.shape)
    return np.array([np.interp(times - own, times, row) for row, own in zip(rows, late, strict=True)]).reshape(rows.shape)
