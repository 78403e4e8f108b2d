"""On which small experiments is each constant of the diagnosis tried? A few of every kind, each of which is diagnosed in seconds.

Of the calibration's cases the rigs, cut short; then averages of a Stribeck curve, and a slide that rests between its strokes, whose force
leaps. All candidates but a few are left out of the library. Most constants are read by one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from evat.experiment import Experiment, Means, Nominal, Signal, Trial
from evat.model import FloatArray, ParameterError, Run
from evat.models.contact import ContactModel
from evat.studies.calibration.campaign import draw_case

Case = tuple[Experiment, str, ContactModel]  # with its truth
SAMPLES = 150  # of a recording
CANDIDATES = 7  # effects, beside those that act
STRIBECK: Mapping[str, float | str] = {
    "kinematics": "external",
    "friction_law": "lugre",
    "F_C": 10.0,
    "F_S": 14.0,
    "v_s": 0.02,
    "sigma0": 1e6,
    "sigma2": 3.0,
}
ACTS = "direction_asymmetry"  # where forces leap
LEAPS: Mapping[str, float | str] = {**STRIBECK, "F_S": 12.0, "sigma2": 0.0}


def _library(wanted: Collection[str]) -> ContactModel:
    model = ContactModel(1)
    model.effects = tuple(effect for effect in model.effects if effect.name in wanted)
    return model


def _cut_short(number: int) -> Case:
    """A case of the calibration."""
    drawn = draw_case(number)
    if drawn is None:
        raise ParameterError(f"case {number}: its effect does nothing there; choose another number.")
    experiment, truth = drawn
    model, own = ContactModel(1), truth.split("+")
    able = [e.name for e in model.effects if not model.missing_inputs([e.name], experiment.nominal.values, experiment.given)]
    trials = tuple(trial.head(SAMPLES) for trial in experiment.trials)
    return replace(experiment, trials=trials), truth, _library({*able[:: max(len(able) // CANDIDATES, 1)], *own, "elasto_plastic"})


def _averages() -> Case:
    """Of a Stribeck curve at two loads, noise unknown; friction depends on the load more than the nominal model has it."""
    draw, model = np.random.default_rng(1), _library(("load_dependence", "direction_asymmetry", "sensor_offset", "sensor_gain"))
    speeds, loads = np.tile(np.geomspace(1e-3, 1.0, 6), 2), np.repeat([5.0, 20.0], 6)
    values = {"slip_velocity": speeds, "normal_load": loads}
    clean = model.settled(("friction_force",), ("load_dependence",), {**STRIBECK, **values, "load_dependence.n": 0.2})
    force = clean["friction_force"] * (1 + 0.01 * draw.normal(size=speeds.size))
    means = Means("means.csv", tuple(f"c{row}" for row in range(speeds.size)), values, {"friction_force": force}, {})
    nominal = Nominal({**STRIBECK, "F_C": 11.0}, (), {"F_C": 0.1, "F_S": 0.1})
    return Experiment(Path(), "averages of a Stribeck curve", "", nominal, {}, (), means, ""), "load_dependence", model


def _strokes(times: FloatArray, period: float) -> FloatArray:
    """Velocity of strokes to and fro, a third of the time at rest."""
    swing = np.sin(2 * np.pi * times / period)
    speed: FloatArray = 0.1 * np.sign(swing) * np.maximum(np.abs(swing) - 0.5, 0.0)
    return speed


def _rests() -> Case:
    """Steps of a converter in the velocity, which reads another zero in each recording; a force that leaps, that comes with bursts of
    another kind and ends at the sensor's range, and an effect that is stated and off."""
    draw, model = np.random.default_rng(2), _library((ACTS, "sensor_offset", "viscous_friction", "sensor_lowpass"))
    trials, times = list[Trial](), np.arange(SAMPLES, dtype=np.float64) * 2e-3
    for place in range(4):
        speed = (1 + place // 2) * _strokes(times, 0.1 + 0.03 * (place // 2))
        clean = model.simulate_many(Run(times, {"slip_velocity": speed}, ("friction_force",)), (ACTS,), LEAPS)["friction_force"][0]
        bursts = 1.0 * np.sin(450 * times) * (np.sin(40 * times + place) > 0.8)
        force = np.clip(clean + bursts + 0.05 * draw.normal(size=times.size), -11.5, 11.5)
        read = np.round((speed + 2e-4 * place) / 1e-4) * 1e-4
        trials.append(Trial(f"{place}.csv", f"c{place // 2}", {}, times, {"slip_velocity": read}, {"friction_force": force}))
    nominal = Nominal({**LEAPS, "viscous_friction.coefficient": 1e-6}, (), {"F_C": 0.1})
    signals = {"friction_force": Signal("friction_force", "force", "N", "output", full_scale=11.5)}
    return Experiment(Path(), "strokes and rests", "", nominal, signals, tuple(trials), None, ""), ACTS, model


CASES: dict[int, Callable[[], Case]] = {  # those first that read most in least time
    0: _rests,
    1: _averages,
    2: lambda: _cut_short(3),
    3: lambda: _cut_short(0),
    4: lambda: _cut_short(1),
}
