"""What goes on in the rigs, machines and ellipses on which the diagnosis is calibrated? Motions, parameters and effects drawn at random.

All run through the component itself, as no library has it: in two cases of three the base law is of a form that is a little wrong, and an
effect acts by a relative of its own form. A gap is as large as its ratio to the noise of one recording says once the nominal parameters and
the set-up have been refitted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Nominal, SetupSd, Trial
from evat.inference.parameters import Scales, amplitudes, shape_parameter, shapes
from evat.inference.prediction import Prediction
from evat.model import Effect, FloatArray
from evat.models.contact import ContactModel
from evat.required_inputs import KINEMATICS

BELIEF = 0.15  # usual prior standard deviation of a nominal parameter, of its value
EXACT = ("vibration_frequency", "width")  # known to whoever set them
SPEED = "slip_velocity"
THICKNESS = "uncut_thickness"
STRIBECK, PRESLIDING, VISCOUS = (1.0, 2.0), (1.0, 3.0), (0.7, 1.3)  # exponents of the base law, where it is of another form
ASYMMETRY = 0.03  # of F_S, there: at most so much more is needed to break away in one direction
ENTRY = (0.02, 0.1)  # of the rms, there: thickness (or force) over which the chip comes in
BENT = 0.25  # of the logarithm of a power, standard deviation: of an effect, there, or of what it reads
LATE = (0.002, 0.02)  # of a record, there: time in which an effect comes and goes
RELATIVE = (0.1, 0.25)  # of an effect, there: share that another of its family has in it
WITHIN = 1.4  # times the size that was asked for: as near must that of an effect come
SHORTEST, LONGEST = 300, 600  # samples of a recording
CYCLES = 6  # in a recording of a rig
ELLIPSE, PER_TURN = 2e4, 60  # Hz, and samples


@dataclass(frozen=True)
class Rig:
    """What really moves: `experiment` has a trial for each condition, longer by `spare` samples than what is recorded, outputs of zeros;
    `law` is the nominal model as it ought to be."""

    experiment: Experiment
    law: Mapping[str, float | str]
    samples: int
    spare: int


@dataclass(frozen=True)
class Form:
    """How the base law differs from its nominal form: values beside those of the law, the share by which F_S differs by direction, and
    over which share of the rms the chip comes in."""

    values: Mapping[str, float]
    asymmetry: float = 0.0
    entry: float = 0.0


def draw_rig(draw: np.random.Generator, conditions: int, spare: int) -> Rig:
    """A rig whose motion is given, alone or with its chip, or the ellipse."""
    kind, samples = int(draw.integers(3)), int(draw.integers(SHORTEST, LONGEST + 1))
    force = float(10 ** draw.uniform(0.3, 1.7))
    law: dict[str, float | str] = {"friction_law": "lugre", "F_C": force, "F_S": force * float(draw.uniform(1.0, 1.6))}
    if kind == 2:
        trials = _ellipse(draw, law, force, samples + spare, conditions)
    else:
        trials = _driven(draw, law, force, samples, spare, conditions, has_chip=kind == 1)
    experiment = Experiment(Path(), f"rig of kind {kind}", "", Nominal(law, (), {}), {}, tuple(trials), None, "")
    return Rig(experiment, law, samples, spare)


def _ellipse(draw: np.random.Generator, law: dict[str, float | str], force: float, length: int, conditions: int) -> list[Trial]:
    law |= {"kinematics": "internal", "vibration_frequency": ELLIPSE, "sigma0": force / 1e-6, "sigma1": 1e-2 * force, "sigma2": 0.1 * force}
    law |= {"v_s": float(10 ** draw.uniform(-2.3, -1)), "shear_stress": float(draw.uniform(2e8, 6e8)), "width": 1e-3}
    times = np.arange(length) / (ELLIPSE * PER_TURN)
    outputs = {name: np.zeros(length) for name in ("principal_force", "feed_force")}
    speeds = np.linspace(0.08, 0.4, conditions)
    return [Trial(f"{place}", f"c{place}", {"cutting_speed": float(speed)}, times, {}, outputs) for place, speed in enumerate(speeds)]


def _driven(
    draw: np.random.Generator, law: dict[str, float | str], force: float, samples: int, spare: int, conditions: int, *, has_chip: bool
) -> list[Trial]:
    """It swings, it stops and goes, or it goes from one speed to the next."""
    frequency, speed = float(10 ** draw.uniform(0, 2)), float(10 ** draw.uniform(-3, -0.5))
    law |= {"kinematics": "external", "v_s": speed * float(10 ** draw.uniform(-1.5, -0.3)), "proxy_source": "proxy_speed"}
    law |= {"sigma0": force / (speed / frequency * float(10 ** draw.uniform(-2.5, -1))), "sigma2": 0.3 * force / speed}
    law["sigma1"] = 0.1 * force / speed * float(10 ** draw.uniform(-2, -0.3))
    if has_chip:
        law |= {"shear_stress": 10 * force / (1e-3 * 1e-4), "width": 1e-3}
    names = ("principal_force", "feed_force") if has_chip else ("friction_force",)
    motion, trials = int(draw.integers(3)), list[Trial]()
    times = np.arange(samples + spare) / (frequency * samples / CYCLES)
    for place, share in enumerate(np.geomspace(0.25, 1.0, conditions)):
        wave = 2 * np.pi * frequency * times
        swing = np.sin(wave) + 0.3 * place * np.sin(2.4 * wave + place)
        stops = np.sign(swing) * np.maximum(np.abs(swing) - 0.3, 0.0)
        stairs = 0.6 + 0.5 * np.tanh(8 * np.sin(wave / 2.2 + place)) * np.tanh(8 * np.cos(wave / 3.7))
        inputs = {
            SPEED: speed * share * (swing, stops, stairs)[motion],
            "proxy_speed": speed * (0.5 + 0.4 * np.sin(wave / (2.3 + place))),
            "normal_load": 10 * (1 + 0.3 * np.cos(wave / 3.1)),
        }
        if has_chip:
            inputs[THICKNESS] = 1e-4 * (0.6 + 0.8 * np.sin(wave + 1))
        trials.append(Trial(f"{place}", f"c{place}", {}, times, inputs, {name: np.zeros(times.size) for name in names}))
    return trials


def draw_form(draw: np.random.Generator, rig: Rig) -> Form:
    """Another one than the nominal: as published friction curves, presliding loops and entries differ."""
    stribeck, viscous = float(draw.uniform(*STRIBECK)), float(draw.uniform(*VISCOUS))
    presliding = math.exp(float(draw.uniform(*np.log(PRESLIDING))))
    speeds = [np.sqrt(np.mean(t.inputs[SPEED] ** 2)) if SPEED in t.inputs else t.values["cutting_speed"] for t in rig.experiment.trials]
    level = float(np.median(speeds))  # at which viscous friction is as large as the nominal model says, whatever its exponent
    values = {"lugre.stribeck_exponent": stribeck, "lugre.presliding_exponent": presliding, "lugre.viscous_exponent": viscous}
    values["lugre.viscous_reference"] = level
    return Form(values, float(draw.uniform(-ASYMMETRY, ASYMMETRY)), float(draw.uniform(*ENTRY)))


class World:
    """A rig and the form of its base law: `clean` (N,) is what its outputs are without any effect."""

    def __init__(self, rig: Rig, form: Form | None = None) -> None:
        self.rig, self.form = rig, form or Form({})
        self.values: dict[str, float | str] = {**rig.law, **self.form.values}
        self.prediction = Prediction(ContactModel(1), self._softened(rig.experiment))
        self.base = self.prediction.one(self.values)
        self._sharp = self.base + self._by_direction()
        self.clean = self._entered(self._sharp)
        self.level = float(np.sqrt(np.mean(self.clean**2)))
        self.left = self._refit()
        self._effects = {
            effect.name: effect
            for effect in self.prediction.model.effects
            if not self.prediction.model.missing_inputs([effect.name], self.values, rig.experiment.given)
            and effect.applies(str(rig.law[KINEMATICS]), rig.experiment.given)
        }

    def _softened(self, experiment: Experiment) -> Experiment:
        """Where the thickness is given, the chip comes in bit by bit."""
        trials = list[Trial]()
        for trial in experiment.trials:
            inputs = dict(trial.inputs)
            if THICKNESS in inputs and self.form.entry:
                thick = np.maximum(inputs[THICKNESS], 0.0)
                width = self.form.entry * float(np.sqrt(np.mean(thick**2)))
                inputs[THICKNESS] = np.where(thick > 0, thick * -np.expm1(-thick / width), inputs[THICKNESS])
            trials.append(replace(trial, inputs=inputs))
        return replace(experiment, trials=tuple(trials))

    def _entered(self, row: FloatArray) -> FloatArray:
        """Where the thickness comes from the ellipse, the forces do the same."""
        if not self.form.entry or self.rig.law[KINEMATICS] != "internal":
            return row
        soft = row.copy()
        for channel in self.prediction.channels:
            own = self.prediction.places(channel)
            width = self.form.entry * float(np.sqrt(np.mean(row[own] ** 2)))
            soft[own] = row[own] * -np.expm1(-np.abs(row[own]) / width)
        return soft

    def _by_direction(self) -> FloatArray:
        change: FloatArray = np.zeros_like(self.base)
        if self.form.asymmetry and self.rig.law[KINEMATICS] == "external":
            static = float(self.values["F_S"])
            forward, back = self.prediction.many({**self.values, "F_S": static * (1 + np.array([1.0, -1.0]) * self.form.asymmetry)})
            for segment in self.prediction.segments:
                ahead = self.prediction.experiment.trials[segment.trial].inputs[SPEED] >= 0
                change[segment.at] = np.where(ahead, forward[segment.at], back[segment.at]) - self.base[segment.at]
        return change

    def _refit(self) -> Callable[[FloatArray, float], FloatArray]:
        """What a refit of the nominal parameters and of the set-up leaves of a change of the outputs, (K, N) and the noise -> (K, N), as
        far as they are linear and the set-up is within its tolerance."""
        channels = self.prediction.channels
        stated = {
            c: SetupSd(zero=SetupSd.ZERO_OF_RMS * float(np.sqrt(np.mean(self.clean[self.prediction.places(c)] ** 2)))) for c in channels
        }
        prediction = Prediction(self.prediction.model, replace(self.prediction.experiment, setup_sd=stated))
        scales = {name: BELIEF * value for name, value in self.rig.law.items() if isinstance(value, float) and name not in EXACT}
        own = len(scales)
        scales |= {parameter.name: parameter.sd for parameter in prediction.setup.parameters}
        values = {**self.rig.law, **dict.fromkeys(prediction.setup.names, 0.0)}
        _, slopes = prediction.jacobian(values, list(scales), scales)

        def left(change: FloatArray, noise: float) -> FloatArray:
            point = _ridge(slopes, change, noise)
            change = change - np.clip(point[:, own:], -CONSTANTS.widest_setup_error, CONSTANTS.widest_setup_error) @ slopes[:, own:].T
            rest: FloatArray = change - _ridge(slopes[:, :own], change, noise) @ slopes[:, :own].T
            return rest

        return left

    def gap(
        self, draw: np.random.Generator, sizes: tuple[float, ...], noise: float, *, by_relatives: bool
    ) -> tuple[FloatArray, tuple[str, ...]] | None:
        """Contributions (N,) of as many effects as there are sizes [N rms] and their names; None where none of those drawn can do it."""
        total, names = np.zeros_like(self.base), list[str]()
        offered = list(self._effects.values())
        for _ in range(30):
            effect = offered[int(draw.integers(len(offered)))]
            if effect.name in names or any(name in effect.rivals for name in names):
                continue
            row = self._sized(draw, effect, sizes[len(names)], noise, by_relatives=by_relatives)
            if row is not None:
                total, names = total + row, [*names, effect.name]
                if len(names) == len(sizes):
                    return self._entered(self._sharp + total) - self.clean, tuple(names)
        return None

    def _sized(self, draw: np.random.Generator, effect: Effect, size: float, noise: float, *, by_relatives: bool) -> FloatArray | None:
        """Its contribution (N,), so strong that a refit leaves about as much as asked; None where it cannot be."""
        prediction, change = self.prediction, int(draw.integers(3)) if by_relatives else -1
        if change == 1:
            prediction = self._bent_inputs(draw)
        base = self.base if prediction is self.prediction else prediction.one(self.values)
        scales = Scales(prediction.model, self.rig.experiment)
        values: dict[str, float | str | FloatArray] = dict(self.values)
        scales.force = scales.force or self.level
        for variable in shapes(effect):
            values[variable.name] = shape_parameter(variable, scales).value(float(np.clip(draw.normal(), -1.5, 1.5)))
        own = amplitudes(effect)
        chosen = own[int(draw.integers(len(own)))]
        sign = -1.0 if chosen.min < chosen.neutral and draw.random() < 0.5 else 1.0
        values |= {v.name: v.neutral for v in own if v is not chosen}
        reach = scales.amplitude(chosen)
        for factors in (10 ** np.arange(-5.0, 4.0, 0.5), 10 ** np.linspace(-0.4, 0.4, 9)):
            tried = np.clip(chosen.neutral + sign * reach * factors, chosen.min, chosen.max)
            rows = prediction.many({**values, chosen.name: tried}, (effect.name,)) - base
            levels = np.sqrt(np.mean(self.left(np.nan_to_num(rows), noise) ** 2, axis=1))
            levels[~np.all(np.isfinite(rows), axis=1)] = 0.0
            apart = np.abs(np.log(np.maximum(levels, 1e-12 * size) / size))
            place = int(np.argmin(apart))
            reach *= float(factors[place])
        if apart[place] > math.log(WITHIN):
            return None
        row: FloatArray = rows[place]
        row = self._bent(draw, row) if change == 0 else self._late(draw, row) if change == 2 else row
        relatives = [other for other in self._effects.values() if other is not effect and other.family and other.family == effect.family]
        if by_relatives and relatives and draw.random() < 0.5:
            other = relatives[int(draw.integers(len(relatives)))]
            share = float(draw.uniform(*RELATIVE))
            more = self._sized(draw, other, share * size, noise, by_relatives=False)
            row = row if more is None else row + more
        return row

    def _bent(self, draw: np.random.Generator, row: FloatArray) -> FloatArray:
        """A row (N,) that grows with another power of itself, each channel in its own rms."""
        bent, power = row.copy(), math.exp(BENT * float(draw.normal()))
        for channel in self.prediction.channels:
            own = self.prediction.places(channel)
            bent[own] = _powered(row[own], power)
        return bent

    def _bent_inputs(self, draw: np.random.Generator) -> Prediction:
        """What only effects read is as if they read another power of it."""
        power = math.exp(BENT * float(draw.normal()))
        trials = [
            replace(
                trial,
                inputs={name: column if name in (SPEED, THICKNESS) else _powered(column, power) for name, column in trial.inputs.items()},
            )
            for trial in self.prediction.experiment.trials
        ]
        return Prediction(self.prediction.model, replace(self.prediction.experiment, trials=tuple(trials)))

    def _late(self, draw: np.random.Generator, row: FloatArray) -> FloatArray:
        """A row (N,) that follows itself with a time constant."""
        late, keeps = row.copy(), math.exp(-1 / (float(draw.uniform(*LATE)) * self.rig.samples))
        for segment in self.prediction.segments:
            own = row[segment.at]
            late[segment.at], _ = lfilter([1 - keeps], [1, -keeps], own, zi=[keeps * own[0]])
        return late


def _ridge(slopes: FloatArray, change: FloatArray, noise: float) -> FloatArray:
    """(K, p) prior standard deviations that parameters move for a change (K, N) in white noise."""
    square = slopes.T @ slopes + noise**2 * np.eye(slopes.shape[1])
    return np.asarray(np.linalg.solve(square, slopes.T @ change.T).T, dtype=np.float64)


def _powered(row: FloatArray, power: float) -> FloatArray:
    level = float(np.sqrt(np.mean(row**2)))
    powered: FloatArray = level * np.sign(row) * np.abs(row / level) ** power if level > 0 else row
    return powered
