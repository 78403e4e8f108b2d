"""What does a real rig make of a record? Set-up errors, trials that differ, noisy and quantised channels, lost samples: all of it, always.

A good rig has little of each, a bad one more: `grade` scales them. Every error here is a nuisance; none is what a diagnosis should name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy import signal

from .drive import Array, Channels, Drive, shifted
from .world import World

Draw = np.random.Generator
GRADES = {"good": 0.3, "ordinary": 1.0, "bad": 1.8}
CLOCK = {"good": 0.25, "ordinary": 0.6, "bad": 1.0}  # samples, of either sign, in all trials alike
FORCE_PER_CURRENT = 40.0  # N/A of an axis
TOLERANCE = 0.01  # of gain, and of zero over the rms: what set-ups of an ordinary rig are off by


@dataclass(frozen=True)
class Shared:
    """What all trials of a rig have alike: of each channel gain, zero (of its rms) and clock (samples), noise and its colour."""

    grade: str
    gain: Mapping[str, float]
    zero: Mapping[str, float]
    clock: Mapping[str, float]
    noise: Mapping[str, float]
    colour: float
    tail: float
    outliers: float
    hysteresis: float
    bits: int
    input_noise: float
    input_bits: int
    trial_gain: float
    trial_zero: float
    trial_clock: float
    repeats_out_of_step: float
    ragged: float
    speed_scatter: float
    clock_drift: float
    lost: float
    lost_in_a_row: int
    mass_error: float

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def drawn(world: World, rng: Draw, noise: Mapping[str, float]) -> Shared:
    """noise: rms of each output channel over its own."""
    grade = str(rng.choice(list(GRADES), p=[0.3, 0.5, 0.2]))
    q, names = GRADES[grade], (*world.channels, *world.inputs)

    def own(scale: float) -> dict[str, float]:
        return {name: float(np.clip(rng.normal(0, scale * q), -2.5 * scale, 2.5 * scale)) for name in names}

    chance = rng.random(8)
    return Shared(
        grade=grade, gain=own(TOLERANCE), zero=own(0.6 * TOLERANCE),
        clock={name: float(rng.uniform(-1, 1) * CLOCK[grade]) if not world.means else 0.0 for name in names}, noise=dict(noise),
        colour=float(rng.uniform(0.0, 0.7)), tail=float(rng.choice([3.0, 4.0, 6.0])) if chance[0] < 0.4 else 0.0,
        outliers=float(rng.uniform(0.001, 0.004) * q) if chance[1] < 0.3 else 0.0,
        hysteresis=float(rng.uniform(0.0005, 0.003) * q) if chance[2] < 0.6 else 0.0, bits=int(rng.choice([12, 14, 16])),
        input_noise=float(np.exp(rng.uniform(np.log(0.001), np.log(0.008))) * q), input_bits=int(rng.choice([11, 12, 14])),
        trial_gain=0.004 * q, trial_zero=0.004 * q, trial_clock=(0.04 if world.kind == "ellipse" else 0.1) * q,
        repeats_out_of_step=0.3 if chance[3] < 0.45 else 0.0,
        ragged=float(rng.uniform(0.05, 0.25)) if chance[4] < 0.45 else 0.0, speed_scatter=0.003 * q,
        clock_drift=float(rng.choice([-1, 1]) * 10 ** rng.uniform(-5, -3.3)) * q,
        lost=float(rng.uniform(0.0005, 0.004) * q) if chance[5] < 0.4 else 0.0,
        lost_in_a_row=int(rng.integers(3, 12)) if chance[6] < 0.15 else 0, mass_error=float(rng.normal(0, TOLERANCE * q)),
    )  # fmt: skip


@dataclass(frozen=True)
class Trial:
    """One recording as it reaches the disk. place: of its condition; true: the forces without any error of measurement; ideal: with all
    errors but the noise."""

    place: int
    times: Array
    inputs: dict[str, Array]
    outputs: Channels
    true: Channels
    ideal: Channels
    beside: dict[str, Array]


def schedule(world: World, shared: Shared, rng: Draw) -> tuple[list[int], Drive]:
    """Which conditions are repeated how often, and the lanes of all trials as they run."""
    count = world.conditions.lanes
    repeats = np.where(rng.random(count) < 0.3, 1, rng.integers(2, 4, count))
    if world.means or rng.random() < 0.1:
        repeats[:] = 1
    if world.means and rng.random() < 0.4:
        repeats[rng.permutation(count)[: count // 3]] = 2
    places = np.repeat(np.arange(count), repeats).tolist()
    n = len(places)
    step = shared.repeats_out_of_step * rng.random(n)
    lengths = 1 - shared.ragged * rng.random(n)
    drive = world.trial(places, step, lengths, 1 + shared.speed_scatter * rng.standard_normal(n))
    return places, drive


def noise_of(rng: Draw, count: int, shared: Shared) -> Array:
    """Samples of rms 1."""
    lead = 100
    white = rng.standard_normal(count + lead)
    if shared.tail:
        white = rng.standard_t(shared.tail, count + lead) / np.sqrt(shared.tail / (shared.tail - 2))
    a = shared.colour
    return np.asarray(signal.lfilter([np.sqrt(1 - a * a)], [1.0, -a], white)[lead:])


def quantised(values: Array, bits: int, span: float) -> Array:
    """By a converter whose range is `span`."""
    step = span / 2**bits
    return np.asarray(np.round(values / step) * step)


def hysteretic(force: Array, share: float) -> Array:
    """A sensor that lags by a share of its range, however slowly: half of it behind a play."""
    if not share:
        return force
    half = share * float(np.ptp(force))
    y, last = np.empty_like(force), float(force[0])
    for k, f in enumerate(force.tolist()):
        last = min(max(last, f - half), f + half)
        y[k] = last
    return 0.5 * force + 0.5 * y


def recorded(world: World, drive: Drive, places: list[int], fine: Channels, unknown: list[Channels] | None, shared: Shared,
             seed: list[int]) -> list[Trial]:  # fmt: skip
    """All trials on disk. fine: the true forces on the drive's grid; unknown: what comes beside them, at the samples of each lane."""
    late = {name: (shared.clock[name] + np.zeros(drive.lanes)) for name in (*world.channels, *world.inputs)}
    scatter = np.random.default_rng([*seed, 0])
    for name in late:
        late[name] = late[name] + shared.trial_clock * scatter.uniform(-1, 1, drive.lanes)
    drift = {"drift": shared.clock_drift, "first": drive.first}  # of the forces' clock against that of the motion
    moved = {name: shifted(fine[name], late[name] * drive.every, **drift) for name in world.channels}
    units = {name: float(np.sqrt(np.mean(fine[name][drive.first :] ** 2))) for name in world.channels}
    trials = []
    for lane, place in enumerate(places):
        rng = np.random.default_rng([*seed, 1, lane])
        keep = np.ones(drive.count[lane], dtype=bool)
        if shared.lost:
            keep = rng.random(keep.size) >= shared.lost
        if shared.lost_in_a_row and rng.random() < 0.4:
            at = int(rng.integers(5, keep.size - 20))
            keep[at : at + shared.lost_in_a_row] = False
        keep[[0, -1]] = True
        outputs, true, ideal, beside = {}, {}, {}, {}
        for name in world.channels:
            clean, sensed = drive.sampled(fine[name], lane), drive.sampled(moved[name], lane)
            more = unknown[lane][name] if unknown else 0.0
            true[name] = (clean + more)[keep]
            sensed = hysteretic(sensed + more, shared.hysteresis)
            inertia = np.zeros_like(sensed)
            if world.kind.startswith("axis"):
                sensed, inertia = _of_motor(world, drive, lane, sensed, shared)
            gain = (1 + shared.gain[name]) * (1 + shared.trial_gain * rng.standard_normal())
            zero = units[name] * (shared.zero[name] + shared.trial_zero * rng.standard_normal())
            noise = shared.noise[name] * units[name] * noise_of(rng, sensed.size, shared)
            if shared.outliers:
                hit = rng.random(sensed.size) < shared.outliers
                noise = noise + hit * rng.choice([-1, 1], sensed.size) * rng.uniform(4, 15, sensed.size) * shared.noise[name] * units[name]
            ideal[name] = (gain * sensed + zero)[keep]
            outputs[name] = quantised(gain * sensed + zero + noise, shared.bits, 6 * units[name])[keep]
            if world.kind.startswith("axis"):  # as it was recorded, before its owner made a friction force of it
                step = 1e-5 * float(np.ptp(drive.x))
                position = np.round(drive.sampled(drive.x, lane) / step) * step
                beside = {"current [A]": (outputs[name] + inertia[keep]) / FORCE_PER_CURRENT, "position [m]": position[keep]}
        inputs = {name: _input(world, drive, lane, name, float(late[name][lane]), shared, rng)[keep] for name in world.inputs}
        trials.append(Trial(place, drive.sampled(drive.t, lane)[keep], inputs, outputs, true, ideal, beside))
    return trials


def _of_motor(world: World, drive: Drive, lane: int, force: Array, shared: Shared) -> tuple[Array, Array]:
    """Friction as an axis shows it: motor force less mass times the acceleration of a filtered velocity, the mass not quite known; and what
    was taken off."""
    mass = float(world.notes["mass"])
    a = np.gradient(drive.v[:, lane], drive.h)
    width = 2 * drive.every + 1
    smooth = shifted(np.convolve(a, np.ones(width) / width, mode="same")[:, None], 0.3 * drive.every)[:, 0]
    inertia = mass * (1 + shared.mass_error) * drive.picked(smooth, lane)
    return force + mass * drive.picked(a, lane) - inertia, inertia


def _input(world: World, drive: Drive, lane: int, name: str, late: float, shared: Shared, rng: Draw) -> Array:
    """An input as it is recorded."""
    gain, zero = 1 + 0.5 * shared.gain[name], 0.3 * shared.zero[name]
    if name == "slip_velocity":
        source = drive.x if world.kind.startswith("axis") else drive.v
        values = drive.picked(shifted(source[:, lane : lane + 1], late * drive.every)[:, 0], lane)
        unit, sample = float(np.sqrt(np.mean(drive.v[:, lane] ** 2))), drive.every * drive.h
        if world.kind.startswith("axis"):  # encoder: differences of counts, smoothed by who wrote the record
            step = max(shared.input_noise, 2e-4) * unit * sample * 1.5
            counts = np.round(values / step) * step
            values = np.convolve(np.gradient(counts, sample), [0.25, 0.5, 0.25], mode="same")
            values[0], values[-1] = values[1], values[-2]
            return gain * values
        noisy = gain * values + unit * (zero + shared.input_noise * rng.standard_normal(values.size))
        return quantised(noisy, shared.input_bits, 6 * float(world.notes["fast"]))
    source = drive.load if name == "normal_load" else drive.theta
    assert source is not None
    values = drive.picked(shifted(source[:, lane : lane + 1], late * drive.every)[:, 0], lane)
    unit = float(np.mean(values))
    noisy = np.maximum(gain * values + unit * (zero + shared.input_noise * rng.standard_normal(values.size)), 0.0)
    noisy = np.maximum(quantised(noisy, shared.input_bits, 4 * unit), 0.0)
    return temperature_of(world, noisy) if name == "contact_temperature" else noisy


def temperature_of(world: World, theta: Array) -> Array:
    """The temperature whose proxy, by the component's own rule, is theta."""
    low, high = float(world.exact["ambient_temperature"]), float(world.exact["reference_temperature"])
    return np.asarray(low + (high - low) * (theta / float(world.exact["theta_ref"])) ** float(world.exact["alpha_T"]))


def as_recorded(drive: Drive, trials: list[Trial]) -> Drive:
    """The motion that the records show: what a perfect model of the contact would be driven by."""
    if not trials or "slip_velocity" not in trials[0].inputs:
        return drive
    v = drive.v.copy()
    for lane, trial in enumerate(trials):
        t = drive.t[:, lane]
        v[:, lane] = np.where(t >= trial.times[0], np.interp(t, trial.times, trial.inputs["slip_velocity"]), v[:, lane])
    return replace(drive, v=v, x=np.cumsum(v, axis=0) * drive.h)
