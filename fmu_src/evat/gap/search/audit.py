"""What can these records carry? Looked at before anything is fitted; what they cannot tell is said, and a claim that rests on it is not
made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.declaration import misdeclared
from evat.gap.search.recordings import misrecorded
from evat.inference.checks import opposed, unit_ratio
from evat.inference.cycles import other_frequency
from evat.inference.prediction import Prediction
from evat.model import Effect, FloatArray


@dataclass(frozen=True)
class Audit:
    """`refused`: why no verdict can be given; `notes`: what else is to be known; `idle[effect]`: its needed inputs that do not vary."""

    refused: tuple[str, ...]
    notes: tuple[str, ...]
    idle: dict[str, tuple[str, ...]]


def varying(prediction: Prediction) -> set[str]:
    """Inputs and trial values that are not the same all over the experiment."""
    columns: dict[str, list[FloatArray]] = {}
    experiment = prediction.experiment
    for trial in experiment.trials:
        for name, column in trial.inputs.items():
            columns.setdefault(name, []).append(column)
        for name, value in trial.values.items():
            columns.setdefault(name, []).append(np.array([value]))
    if experiment.means is not None:
        for name, column in experiment.means.values.items():
            columns.setdefault(name, []).append(column)
    names = set[str]()
    for name, rows in columns.items():
        whole = np.concatenate(rows)
        if np.ptp(whole) > CONSTANTS.least_variation * max(float(np.max(np.abs(whole - zero))) for zero in zeros(prediction, name)):
            names.add(name)
    return names


def zeros(prediction: Prediction, name: str) -> list[float]:
    """What the size of an input is counted from: 0, and of a temperature those that the nominal model states, such as the ambient one: 5 K
    are much beside the 5 K by which a contact warms, and little beside the 293 K from 0 K to the temperature of a room."""
    temperatures = [variable for variable in prediction.model.variables if variable.unit == "K" and not variable.difference]
    own = [variable.start for variable in temperatures if variable.name == name]
    stated = [variable for variable in temperatures if variable.causality == "parameter" and variable.name != name]
    return ([float(prediction.nominal.get(variable.name, variable.start)) for variable in stated] or own) if own else [0.0]


def idle_effects(prediction: Prediction, effects: Sequence[Effect]) -> dict[str, tuple[str, ...]]:
    """Effects whose needed inputs are there but do not vary: they are one with other parameter values."""
    moving, everything = varying(prediction), prediction.experiment.given
    held = {name: value for name, value in prediction.nominal.items() if name not in everything}
    idle = {}
    for effect in effects:
        if not prediction.model.missing_inputs([effect.name], prediction.nominal, everything):
            still = prediction.model.missing_inputs([effect.name], held, moving)
            if still:
                idle[effect.name] = tuple(still)
    return idle


def too_slow(prediction: Prediction) -> str:
    """Why a record cannot be compared with a model that vibrates faster than it was sampled; "" where it can."""
    for trial in prediction.experiment.trials:
        period = prediction.model.cycle_time({**prediction.nominal, **trial.values})
        if math.isfinite(period) and trial.times.size > 1:
            step = trial.sampling_interval
            if step * CONSTANTS.samples_per_cycle > period:
                return (
                    f"{trial.file} was sampled at {1 / step:.4g} Hz, the vibration has {1 / period:.4g} Hz: "
                    "phases cannot be seen; give cycle means as a means file, or a faster record"
                )
    return ""


def audit(prediction: Prediction, predicted: FloatArray, noise_sd: dict[str, float], numerical: FloatArray) -> Audit:
    """predicted : (N,), by the nominal model; noise_sd : of each channel, whitened, in the median of its recordings; numerical : (N,), the
    solver's error."""
    refused, notes = list(filter(None, [too_slow(prediction)])), list[str]()
    experiment = prediction.experiment
    recorded = sum(trial.times.size for trial in experiment.trials)
    means = len(experiment.means.conditions) if experiment.means is not None else 0
    if recorded < CONSTANTS.fewest_samples and means < CONSTANTS.fewest_means:
        least = f"{CONSTANTS.fewest_samples} samples or {CONSTANTS.fewest_means} means"
        refused.append(f"{recorded} samples and {means} means: at least {least} are needed")
    declared_wrong = misdeclared(prediction, predicted)
    refused += declared_wrong
    if not refused and (frequency := other_frequency(prediction)) is not None:
        refused.append(str(frequency))
    for channel in prediction.channels:
        places = prediction.places(channel)
        measured, simulated = prediction.measured[places], predicted[places]
        refused += _channel(channel, measured, simulated) if not declared_wrong else []
        signal = experiment.signals.get(channel)
        if (
            signal is not None
            and signal.full_scale
            and np.mean(np.abs(measured - signal.offset) >= CONSTANTS.saturation_level * signal.full_scale) > CONSTANTS.saturated_share
        ):
            notes.append(f"{channel}: the sensor is at the end of its range ({signal.full_scale:g}); what lies beyond is cut off")
        error = float(np.sqrt(np.mean(numerical[places] ** 2)))
        visible = CONSTANTS.visible_solver_error * float(np.sqrt(np.mean(simulated**2)))
        if error > CONSTANTS.solver_error_limit * noise_sd.get(channel, math.inf) and error > visible:
            refused.append(f"{channel}: the solver's own error ({error:.3g}) dominates; lower the model's relative tolerance")
    for told, of_recordings in zip((refused, notes), misrecorded(prediction, predicted) if not declared_wrong else ([], []), strict=True):
        told += of_recordings
    notes += _stated(prediction, predicted, noise_sd)
    return Audit(tuple(refused), tuple(notes), idle_effects(prediction, prediction.model.effects))


def _stated(prediction: Prediction, predicted: FloatArray, noise_sd: dict[str, float]) -> list[str]:
    """Effects that are off and whose parameters the nominal model states, where with these they cannot be seen."""
    sd = np.concatenate([np.full(s.at.stop - s.at.start, noise_sd.get(s.channel, math.nan)) for s in prediction.segments])
    notes = []
    for effect in prediction.model.effects:
        stated = any(variable.name in prediction.nominal for variable in effect.variables)
        if not stated or effect.name in prediction.experiment.nominal.effects:
            continue
        change = prediction.one(on=(effect.name,)) - predicted
        if np.all(np.isfinite(change)) and float(np.sqrt(np.nansum((change / sd) ** 2))) < CONSTANTS.visible_change:
            share = float(np.sqrt(np.mean(change**2) / np.mean(predicted**2)))
            notes.append(
                f"{effect.name}: not identifiable, with the values that the nominal model states it changes {share:.1g} of the rms"
            )
    return notes


def _channel(channel: str, measured: FloatArray, simulated: FloatArray) -> list[str]:
    if np.ptp(measured) == 0:
        return [f"{channel}: it is {measured[0]:g} all the time; is the sensor connected?"]
    if not np.any(simulated):
        return []
    if (ratio := unit_ratio(measured, simulated)) is not None:
        return [f"{channel}: measured is {ratio:.3g} times the model; check its unit"]
    if opposed(measured, simulated) is not None:
        return [
            f"{channel}: measured runs against the model; check its sign (forces act on the tool, positive slip gives positive friction)"
        ]
    return []
