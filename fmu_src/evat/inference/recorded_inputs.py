"""Which motion did a noisy recording of it follow? Errors in variables: one smoothed input for the repeats of a condition.

A recorded velocity has noise, which bends bristles at rest and wears the model out; and it makes repeats of one motion differ, though they
are the same run. Its noise is taken out by local parabolas (evat.experiment.smoothing); what is left of the error is told by smoothing once
more what was smoothed, with fresh noise. That of a velocity that was differentiated is told by differentiating its position once more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import correlate

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Trial
from evat.experiment.smoothing import derivative, mean_step, noise_sd, smoothed
from evat.inference.checks import rms
from evat.model import FloatArray, IntArray
from evat.required_inputs import FRICTION, MOTION


@dataclass(frozen=True)
class RecordedInputs:
    """`experiment` with smoothed inputs, one for the repeats that share a motion, and as it was `recorded`; `perturbed` is smoothed by
    other noise, None where no input had any; `noise[name]` is the largest standard deviation that an input was seen to have [its unit]."""

    experiment: Experiment
    recorded: Experiment
    perturbed: Experiment | None
    noise: Mapping[str, float]


def smoothed_inputs(experiment: Experiment) -> RecordedInputs:
    """Inputs without noise are left as they are, to the bit."""
    smooth, other, noise = list(experiment.trials), list(experiment.trials), dict[str, float]()
    draw = np.random.default_rng(CONSTANTS.perturbation_seed)
    for places in same_motion(experiment.trials):
        first, noisy = experiment.trials[places[0]], False
        inputs, perturbed = dict(first.inputs), dict(first.inputs)
        for name in first.inputs:
            rows = np.array([experiment.trials[place].inputs[name] for place in places])
            if sd := max(experiment.trials[place].position_sd.get(name, 0.0) for place in places):
                inputs[name] = rows.mean(axis=0)
                left = sd / np.sqrt(len(np.unique(rows, axis=0)))  # rounding is the same in repeats that are
                perturbed[name] = _differentiated_again(first.times, inputs[name], left, draw)
                noise[name] = max(noise.get(name, 0.0), rms(perturbed[name] - inputs[name]))
                noisy = True
                continue
            sd = max(noise_sd(row) for row in rows)
            if sd == 0:
                continue
            noise[name] = max(noise.get(name, 0.0), sd)
            noisy = True
            left = sd / np.sqrt(len(rows))
            inputs[name] = smoothed(rows.mean(axis=0), left)
            perturbed[name] = smoothed(inputs[name] + left * draw.normal(size=rows.shape[1]) * (inputs[name] != 0), left)
        inertia = _inertia_beyond(experiment, places, inputs.get(MOTION), draw)
        if not noisy:
            continue
        for place, lead in zip(places, _lead_ins([experiment.trials[place] for place in places]), strict=True):
            trial = experiment.trials[place]
            smooth[place] = replace(trial, inputs=inputs, times=first.times, lead_in=lead)
            outputs = dict(trial.outputs)
            if inertia is not None and FRICTION in outputs:
                outputs[FRICTION] = outputs[FRICTION] - inertia
            other[place] = replace(trial, inputs=perturbed, outputs=outputs, times=first.times, lead_in=lead)
    if not noise:
        return RecordedInputs(experiment, experiment, None, {})
    whole, by_other_noise = replace(experiment, trials=tuple(smooth)), replace(experiment, trials=tuple(other))
    return RecordedInputs(whole, experiment, by_other_noise, noise)


def _lead_ins(trials: Sequence[Trial]) -> list[Trial | None]:
    """What was recorded before each of these repeats, smoothed and by the clock of the first: the longest of those that agree with it, and
    its own where it was another motion."""
    told: dict[int, Trial] = {}
    for place in sorted(range(len(trials)), key=lambda place: -_lead_length(trials[place])):
        lead = trials[place].lead_in
        if lead is None:
            continue
        for known in told:
            if _ends_alike(trials[known], trials[place]):
                told[place] = told[known]
                break
        else:
            sds = {name: 0.0 if lead.position_sd.get(name) else noise_sd(column) for name, column in lead.inputs.items()}
            inputs = {name: smoothed(column, sds[name]) if sds[name] > 0 else column for name, column in lead.inputs.items()}
            told[place] = replace(lead, times=lead.times + (trials[0].times[0] - trials[place].times[0]), inputs=inputs)
    return [told.get(place) for place in range(len(trials))]


def _lead_length(trial: Trial) -> int:
    return 0 if trial.lead_in is None else trial.lead_in.times.size


def _ends_alike(longer: Trial, shorter: Trial) -> bool:
    """Whether one motion came before both, as far as the shorter of their lead-ins tells."""
    one, other = longer.lead_in, shorter.lead_in
    assert one is not None
    assert other is not None
    count = other.times.size
    if count < CONSTANTS.fewest_input_samples or set(one.inputs) != set(other.inputs):
        return False
    return _agree({name: column[-count:] for name, column in one.inputs.items()}, other.inputs, CONSTANTS.alike_inputs, 0.0)


def _differentiated_again(times: FloatArray, velocity: FloatArray, sd: float, draw: np.random.Generator) -> FloatArray:
    """The velocity (n,) that would have come of its position with fresh noise of this standard deviation."""
    position = cumulative_trapezoid(velocity, times, initial=0.0) + sd * draw.normal(size=velocity.size)
    return derivative(position, mean_step(times), sd=sd)


def _inertia_beyond(
    experiment: Experiment, places: Sequence[int], velocity: FloatArray | None, draw: np.random.Generator
) -> FloatArray | None:
    """How much more inertia (n,) [N] would have been taken off the force, had the motion been recorded with other noise: most where it
    speeds up faster than that lets one see. None where none is taken off. velocity : (n,), what it is held to have been."""
    trials = [experiment.trials[place] for place in places]
    if experiment.mass == 0 or velocity is None:
        return None
    step, fresh = mean_step(trials[0].times), draw.normal(size=velocity.size)
    if sd := max(trial.position_sd.get(MOTION, 0.0) for trial in trials):
        again = derivative(cumulative_trapezoid(velocity, dx=step, initial=0.0) + sd * fresh, step, 2, sd=sd)
    elif sd := max(noise_sd(trial.inputs[MOTION]) for trial in trials):
        again = derivative(velocity + sd * fresh, step, sd=sd)
    else:
        return None
    return experiment.mass * (again - np.gradient(velocity, step))


def _noise_of_derivatives(trial: Trial) -> dict[str, float]:
    """Of each input that was differentiated, the standard deviation of what it is off by."""
    draw = np.random.default_rng(CONSTANTS.perturbation_seed)
    again = {name: _differentiated_again(trial.times, trial.inputs[name], sd, draw) for name, sd in trial.position_sd.items()}
    return {name: rms(velocity - trial.inputs[name]) for name, velocity in again.items()}


def same_motion(trials: Sequence[Trial]) -> list[list[int]]:
    """Places of the trials that recorded one motion: repeats of a condition whose inputs differ by no more than their noise."""
    groups: list[list[int]] = []
    own = [_noise_of_derivatives(trial) for trial in trials]
    for place, trial in enumerate(trials):
        for group in groups:
            first, known = trials[group[0]], (own[group[0]], own[place])
            if _one_run(first, trial) and _agree(first.inputs, trial.inputs, CONSTANTS.alike_inputs, 0.0, known):
                group.append(place)
                break
        else:
            groups.append([place])
    return groups


def comparable(trials: Sequence[Trial], shortest: int = 1) -> list[list[tuple[int, IntArray]]]:
    """Repeats among the recordings of a condition that can be compared sample by sample, with the samples in which they can: those that
    recorded one motion, `shortest` samples long at least, or those that are brought in step, where that compares more."""
    alike = [
        [(each, np.arange(trials[each].times.size)) for each in group]
        for group in same_motion(trials)
        if len(group) > 1 and trials[group[0]].times.size >= shortest
    ]
    step = in_step(trials) if len(trials) > max(sum(map(len, alike)), 1) else []
    return [step] if _compared(step) > sum(map(_compared, alike)) else alike


def _compared(kept: Sequence[tuple[int, IntArray]]) -> int:
    """How many samples repeats tell of their scatter: one for each sample of each beyond the first."""
    return (len(kept) - 1) * kept[0][1].size if kept else 0


def in_step(trials: Sequence[Trial]) -> list[tuple[int, IntArray]]:
    """Repeats of one motion that began at another moment of it, or lack samples, each with those in which it is in step with the others;
    those that follow no such motion, or are so short that the others would share less with it than they tell without it, are left out. What
    moves by itself, with no recorded input, does so by its clock."""
    order = sorted(range(len(trials)), key=lambda place: -trials[place].times.size)
    ordered = [trials[place] for place in order]
    kept = _by_clock(ordered)
    if trials[0].inputs:  # what lacks samples has one lag before the gap and another behind it
        both = kept, _by_lag(ordered)
        most = max(map(_compared, both))
        kept = min((each for each in both if _compared(each) >= CONSTANTS.as_much_compared * most), key=lambda kept: _apart(ordered, kept))
    return sorted(((order[place], at) for place, at in kept), key=lambda each: each[0])


def _apart(trials: Sequence[Trial], kept: Sequence[tuple[int, IntArray]]) -> float:
    """Mean square of what the inputs of recordings that were brought in step differ by, in that of the inputs."""
    total = 0.0
    for place, at in kept[1:]:
        for name, column in trials[kept[0][0]].inputs.items():
            own = column[kept[0][1]]
            total += (rms(own - trials[place].inputs[name][at]) / (rms(own) or 1.0)) ** 2
    return total / max(len(kept) - 1, 1)


def _by_lag(trials: Sequence[Trial]) -> list[tuple[int, IntArray]]:
    """The samples in which motions agree once one is so many samples later."""
    first, kept = trials[0], [(0, 0)]
    begin, end = 0, first.times.size
    for place, trial in enumerate(trials[1:], 1):
        lag = _lag(first, trial) if set(first.inputs) == set(trial.inputs) and dict(first.values) == dict(trial.values) else None
        if lag is None:
            continue
        both = max(begin, -lag), min(end, trial.times.size - lag)
        if both[1] - both[0] >= CONSTANTS.fewest_input_samples and len(kept) * (both[1] - both[0]) >= (len(kept) - 1) * (end - begin):
            (begin, end), kept = both, [*kept, (place, lag)]
    return [(place, np.arange(begin + lag, end + lag)) for place, lag in kept] if end - begin >= CONSTANTS.fewest_input_samples else []


def _by_clock(trials: Sequence[Trial]) -> list[tuple[int, IntArray]]:
    """The samples that were taken at the same times, of those trials whose samples fall together with those of the first, and whose
    motions agree in them."""
    first = trials[0]
    if first.times.size < CONSTANTS.fewest_input_samples:
        return []
    step = first.sampling_interval
    # A recorded motion has its own zero of time; what moves by itself has that of its clock.
    begins = [trial.times[0] - first.times[0] if trial.inputs else 0.0 for trial in trials]
    shared, ticks = np.array([], dtype=np.intp), dict[int, IntArray]()
    for place, trial in enumerate(trials):
        since = trial.times - first.times[0] - begins[place]
        tick = np.round(since / step)
        apart = np.abs(since - tick * step)
        if dict(trial.values) != dict(first.values) or np.median(apart) > CONSTANTS.clock_together * step or np.any(np.diff(tick) < 1):
            continue
        both = tick.astype(np.intp) if not ticks else np.intersect1d(shared, tick.astype(np.intp))
        if ticks and len(ticks) * both.size < (len(ticks) - 1) * shared.size:
            continue
        if both.size >= CONSTANTS.fewest_input_samples and _follows(first, trial, ticks.get(0, tick).astype(np.intp), tick.astype(np.intp)):
            shared, ticks[place] = both, tick.astype(np.intp)
    return [(place, np.flatnonzero(np.isin(own, shared))) for place, own in ticks.items()]


def _follows(one: Trial, other: Trial, ticks: IntArray, others: IntArray) -> bool:
    """Whether the motions agree in the samples that were taken at the same times."""
    if set(one.inputs) != set(other.inputs):
        return False
    _, here, there = np.intersect1d(ticks, others, return_indices=True)
    own, its = ({name: column[at] for name, column in trial.inputs.items()} for trial, at in ((one, here), (other, there)))
    return _agree(own, its, CONSTANTS.alike_inputs, CONSTANTS.in_step)


def _lag(one: Trial, other: Trial) -> int | None:
    """Samples by which the motion comes later in the other; None where it is another one."""
    if one.times.size < CONSTANTS.fewest_input_samples or other.times.size < CONSTANTS.fewest_input_samples:
        return None
    steps = [trial.sampling_interval for trial in (one, other)]
    if abs(steps[0] - steps[1]) > CONSTANTS.clock_jitter * steps[0]:
        return None
    moving = {name: float(np.ptp(column)) for name, column in one.inputs.items() if np.ptp(column) > 0}
    if not moving:
        return None
    name = max(moving, key=lambda each: moving[each])
    a, b = one.inputs[name], other.inputs[name]
    farthest = int(CONSTANTS.largest_lag * min(a.size, b.size))
    lags = np.arange(-farthest, farthest + 1)
    begins, ends = np.maximum(0, -lags), np.minimum(a.size, b.size - lags)
    sums_a, sums_b = (np.concatenate([[0.0], np.cumsum(column**2)]) for column in (a, b))
    squares = sums_a[ends] - sums_a[begins] + sums_b[ends + lags] - sums_b[begins + lags] - 2 * correlate(b, a)[lags + a.size - 1]
    apart = squares / (ends - begins)
    # Of lags that a motion which repeats itself leaves open the shortest.
    as_good = apart <= (1 + CONSTANTS.lag_tie) * np.min(apart) + CONSTANTS.lag_rounding * float(np.mean(a**2))
    lag = int(min(lags[as_good], key=abs))
    begin, end = max(0, -lag), min(a.size, b.size - lag)
    here = {key: column[begin:end] for key, column in one.inputs.items()}
    there = {key: column[begin + lag : end + lag] for key, column in other.inputs.items()}
    return lag if _agree(here, there, CONSTANTS.alike_inputs, CONSTANTS.in_step) else None


def _one_run(one: Trial, other: Trial) -> bool:
    """Whether they have all in common but what was recorded."""
    if one.condition != other.condition or one.times.size != other.times.size or dict(one.values) != dict(other.values):
        return False
    if set(one.inputs) != set(other.inputs) or set(one.outputs) != set(other.outputs):
        return False
    step = one.sampling_interval if one.times.size > 1 else 0.0
    begun = (one.times[0], other.times[0]) if one.inputs else (0.0, 0.0)  # what moves by itself does so by its clock
    apart = np.abs((one.times - begun[0]) - (other.times - begun[1]))
    return float(np.max(apart, initial=0.0)) <= CONSTANTS.clock_jitter * step


def _agree(
    one: Mapping[str, FloatArray],
    other: Mapping[str, FloatArray],
    noises: float,
    share: float,
    known: tuple[Mapping[str, float], Mapping[str, float]] = ({}, {}),
) -> bool:
    """Whether inputs differ by no more than so many times their noise, which is `known` of some, and this share of their root mean
    square."""
    for name, column in one.items():
        sds = [own[name] if name in own else noise_sd(each) for own, each in zip(known, (column, other[name]), strict=True)]
        if rms(column - other[name]) > noises * math.hypot(*sds) + share * rms(column):
            return False
    return True
