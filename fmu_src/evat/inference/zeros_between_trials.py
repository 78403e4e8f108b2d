"""Did the contact rest where its recorded velocity reads next to nothing? Zeros that drift from trial to trial, and noise at rest.

A hundredth of a percent of the speed bends resting bristles by all that they can bend in a second, and each recording creeps in its own
way: then repeats differ by what is no noise, and no law with one zero fits them all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_opening

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Trial
from evat.inference.parameters import Parameter
from evat.inference.prediction import Prediction
from evat.inference.recorded_inputs import RecordedInputs
from evat.inference.setup.rest import rests
from evat.inference.setup.setup_errors import zero_of_input
from evat.model import BoolArray, FloatArray, Model
from evat.required_inputs import MOTION


@dataclass(frozen=True, slots=True)
class SlowMotions:
    """An experiment whose slow motions are as they are likeliest to have been, the same by other noise (None where no input had any), and
    what was done to it, in a sentence."""

    experiment: Experiment
    perturbed: Experiment | None
    said: str


def more_at_rest(experiment: Experiment) -> dict[str, float]:
    """By the trial's file, what its velocity read at rest more than those of all trials did; empty where they agree."""
    levels = {file: rest.level for file, rest in rests(experiment).items()}
    usual = float(np.mean(list(levels.values()))) if levels else 0.0
    return {file: level - usual for file, level in levels.items()} if len(set(levels.values())) > 1 else {}


def without_zeros_between_trials(model: Model, experiment: Experiment) -> tuple[Experiment, dict[str, float]]:
    """The experiment without what velocities read at rest more than others, and how much that was.

    What all of them read is a set-up error of the fits. Nothing is taken where the model is nearer to what was measured with slow
    motions, as recorded, than with rests.
    """
    more = more_at_rest(experiment)
    freed = zeroed(experiment, more)
    return (freed, more) if more and _left(model, freed) <= _left(model, experiment) else (experiment, {})


def where_at_rest(recorded: RecordedInputs) -> dict[str, BoolArray]:
    """By the trial's file, (n,): true where its velocity reads for a while what it reads of a contact at rest, but for noise; without
    trials that never do, and all of them where a velocity has no noise. Smoothed, a motion begins a sample too soon; repeats that share
    one rest together."""
    noise, masks = recorded.noise.get(MOTION, 0.0), dict[str, BoolArray]()
    if not noise > 0:
        return masks
    rest_of, sharing = rests(recorded.experiment), dict[bytes, list[str]]()
    smooth = {trial.file: trial.inputs[MOTION] for trial in recorded.experiment.trials if trial.file in rest_of}
    read = {trial.file: trial.inputs[MOTION] for trial in recorded.recorded.trials if trial.file in rest_of}
    for file, velocity in smooth.items():
        sharing.setdefault(velocity.tobytes(), []).append(file)
    for files in sharing.values():
        level, velocity = rest_of[files[0]].level, smooth[files[0]]
        rows = np.array([read[file] for file in files]) - level
        most = CONSTANTS.noise_at_rest * noise
        near = (np.abs(velocity - level) <= most) | np.all(np.abs(rows) <= most, axis=0)
        size = max(math.ceil(CONSTANTS.least_rest * velocity.size), CONSTANTS.fewest_rest_samples)
        mask: BoolArray = binary_opening(near, np.ones(size)) | _stays_there(rows.mean(axis=0), near, noise)
        if np.any(velocity[mask]):
            masks.update(dict.fromkeys(files, mask))
    return masks


def _stays_there(velocity: FloatArray, near: BoolArray, noise: float) -> BoolArray:
    """(n,): true in rows of samples that are `near` rest and show neither a level nor a trend beyond what noise of this standard deviation
    has: a motion that turns round, or passes through rest, goes from one end of what is near to the other."""
    stays = np.zeros(near.size, dtype=np.bool_)
    turns = np.flatnonzero(np.diff(near.astype(np.int8), prepend=0, append=0))
    for begin, end in zip(turns[::2].tolist(), turns[1::2].tolist(), strict=True):
        count = end - begin
        if count < CONSTANTS.fewest_rest_samples:
            continue
        row, time = velocity[begin:end], np.arange(count) - 0.5 * (count - 1)
        level, trend = float(np.mean(row)) * math.sqrt(count), float(time @ row) / math.sqrt(float(time @ time))
        stays[begin:end] = max(abs(level), abs(trend)) <= CONSTANTS.noise_at_rest * noise
    return stays


def held_at_rest(experiment: Experiment, masks: Mapping[str, BoolArray]) -> Experiment:
    """Velocities of 0 there, by the trials' files."""

    def of(trial: Trial, mask: BoolArray) -> Trial:
        return replace(trial, inputs={**trial.inputs, MOTION: np.where(mask, 0.0, trial.inputs[MOTION])})

    return replace(experiment, trials=tuple(of(trial, masks[trial.file]) if trial.file in masks else trial for trial in experiment.trials))


def with_slow_motions_as_likeliest(model: Model, recorded: RecordedInputs, units: Mapping[str, str]) -> SlowMotions:
    """The experiment as recorded, freed of zeros between trials, or with contacts at rest where their velocities read no more than noise
    does: whichever the nominal model is nearest to. Bristles at rest sum up all that a velocity reads, its noise and its last bit too."""
    freed, more = without_zeros_between_trials(model, recorded.experiment)
    perturbed = recorded.perturbed
    masks = where_at_rest(recorded)
    held = held_at_rest(recorded.experiment, masks)
    if masks and _left(model, held) <= CONSTANTS.rest_before_creep * _left(model, freed):
        said = f"{MOTION}: where it reads no more than noise does, in {len(masks)} recordings, the contact was taken to rest"
        return SlowMotions(held, None if perturbed is None else held_at_rest(perturbed, masks), said)
    if more:
        return SlowMotions(freed, None if perturbed is None else zeroed(perturbed, more_at_rest(perturbed)), zeros_in_words(more, units))
    return SlowMotions(freed, perturbed, "")


def _left(model: Model, experiment: Experiment) -> float:
    """The share of the squares that the nominal model leaves, with the likeliest zero of the velocity, and gain and zero of a channel."""
    prediction, shares = Prediction(model, experiment), list[float]()
    zeros = ((zero, u) for zero in prediction.input_zeros for u in tried_zeros(prediction, zero))
    tried = [{zero.name: zero.value(float(u))} for zero, u in zeros]
    for values in tried or [{}]:
        row, left = prediction.one(values), 0.0
        for channel in prediction.channels:
            own = prediction.places(channel)
            measured, basis = prediction.measured[own], np.column_stack([row[own], np.ones(own.size)])
            if not np.all(np.isfinite(basis)):
                return math.inf
            rest = measured - basis @ np.linalg.lstsq(basis, measured, rcond=None)[0]
            left += float(rest @ rest) / max(float(measured @ measured), 1e-300)
        shares.append(left)
    return min(shares)


def tried_zeros(prediction: Prediction, zero: Parameter) -> FloatArray:
    """Where the zero of an input is looked for, in its prior standard deviations: that of the velocity over all that it may be, and what is
    read at rest; any other where it should be, since a force is nearly linear in it."""
    if zero.name != zero_of_input(MOTION):
        return np.zeros(1)
    levels = [rest.level for rest in rests(prediction.experiment).values()]
    read = [zero.within(zero.place(float(np.mean(levels))))] if levels else []
    return np.append(np.linspace(zero.within(-math.inf), zero.within(math.inf), CONSTANTS.zeros_tried), read)


def zeroed(experiment: Experiment, more: Mapping[str, float]) -> Experiment:
    """Velocities less what they read more than others, by the trials' files."""

    def of(trial: Trial) -> Trial:
        level = more.get(trial.file, 0.0)
        return trial.with_input(MOTION, lambda velocity: velocity - level) if level else trial

    return replace(experiment, trials=tuple(map(of, experiment.trials)))


def zeros_in_words(more: Mapping[str, float], units: Mapping[str, str]) -> str:
    """What was taken from which recordings, in a sentence."""
    file = max(more, key=lambda each: abs(more[each]))
    return (
        f"{MOTION}: at rest {file} reads {more[file]:+.3g} {units[MOTION]} beside the others; what trials differ by there "
        f"was taken from {len(more)} of them"
    )
