"""How is what goes on in a rig recorded? With errors of the whole set-up and of each recording, through a sensor, in noise, noisy inputs.

Gain, zero and clock are off by about what is expected of a set-up, sometimes by twice that; each recording differs a little more. Noise is
coloured, in every other case with heavy tails. Inputs have noise of their own and the steps of a converter. Repeats may begin at another
moment of the motion, and bristles may have slid in before the recording began.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, lfilter, lfilter_zi

from evat.experiment import SetupSd, Trial
from evat.model import FloatArray
from evat.studies.calibration.simulated_rigs import World

NOISE = (-2.5, -1.5)  # decimal logarithm of its share of the rms of the outputs
COLOUR = (0.0, 0.8)  # first coefficient of its autoregression
TAILS = (3.0, 6.0)  # degrees of freedom, where they are heavy
TWICE = 0.25  # share of the set-ups that are off by twice their tolerance
GAIN, ZERO, CLOCK = 0.003, 0.3, 0.2  # of a single recording, standard deviations: of 1, of the noise's rms, of a sample
SENSOR = (0.1, 0.3)  # cut-off of a sensor of the first or second order, of the sampling rate: far above the motion
INPUT_NOISE = (-3.5, -1.7)  # decimal logarithm of its share of the rms of an input, where inputs have noise
INPUT_STEP = (1e-4, 5e-3)  # of a converter, of the range of an input, there
NOISY_INPUTS, OUT_OF_STEP, SLID_IN, HEAVY = 0.6, 0.4, 0.5, 0.5  # shares of the cases
LAG = 0.2  # of a recording: so much later may a repeat begin at most
SPARE = 160  # samples of a motion that are not recorded: bristles slide in, and repeats begin elsewhere
EDGE = 8  # of them, that no clock moves beyond
RUN_IN = 60  # samples of noise before a recording
STRANGE = ("sweep", "sawtooth", "spikes", "wander", "bursts")


@dataclass(frozen=True)
class Stranger:
    """What no effect is, of some rms [N]: in every recording the same, or anew."""

    kind: str
    rate: float  # per sample
    size: float
    anew: bool

    def row(self, length: int, seed: int) -> FloatArray:
        own = np.random.default_rng(seed)
        n, phase = np.arange(length), float(own.uniform(0, 2 * np.pi))
        turns = self.rate * n * (1 + n / length)
        if self.kind == "sweep":
            shape = np.sin(2 * np.pi * turns + phase)
        elif self.kind == "sawtooth":
            shape = np.mod(0.3 * turns + phase, 1.0) - 0.5
        elif self.kind == "spikes":
            shape = (np.mod(0.5 * turns + phase, 1.0) < 0.06) * 1.0
        elif self.kind == "wander":
            shape = lfilter([1.0], [1.0, -0.995], own.normal(size=length))
        else:
            shape = np.sin(2 * np.pi * 3 * self.rate * n + phase) * (np.sin(2 * np.pi * turns / 9 + 3 * phase) > 0.8)
        row: FloatArray = self.size * shape / float(np.sqrt(np.mean(shape**2)) + 1e-12)
        return row


@dataclass(frozen=True)
class Bench:
    """The set-up of an experiment: `noise` [N rms], `setup` of each channel (gain, zero [N], clock [samples]), the sensor's filter, and of
    the inputs `input_noise` (of the rms) and `input_step` (of the range)."""

    noise: float
    colour: float
    degrees: float
    setup: dict[str, tuple[float, float, float]]
    sensor: tuple[FloatArray, FloatArray]
    input_noise: float
    input_step: float
    slid_in: int
    out_of_step: bool


def draw_bench(draw: np.random.Generator, world: World, noise: float) -> Bench:
    times = 2.0 if draw.random() < TWICE else 1.0
    setup = {}
    for channel in world.prediction.channels:
        level = float(np.sqrt(np.mean(world.clean[world.prediction.places(channel)] ** 2)))
        sizes = np.array([SetupSd().gain, SetupSd.ZERO_OF_RMS * level, 1.0])
        gain, zero, clock = times * sizes * np.clip(draw.normal(size=3), -1.5, 1.5)
        setup[channel] = float(gain), float(zero), float(clock)
    noisy = draw.random() < NOISY_INPUTS
    return Bench(
        noise=noise,
        colour=float(draw.uniform(*COLOUR)),
        degrees=float(draw.uniform(*TAILS)) if draw.random() < HEAVY else math.inf,
        setup=setup,
        sensor=butter(int(draw.integers(1, 3)), 2 * float(draw.uniform(*SENSOR))),
        input_noise=float(10 ** draw.uniform(*INPUT_NOISE)) if noisy else 0.0,
        input_step=float(draw.uniform(*INPUT_STEP)) if noisy else 0.0,
        slid_in=int(draw.integers(20, SPARE // 2)) if draw.random() < SLID_IN else 0,
        out_of_step=bool(draw.random() < OUT_OF_STEP),
    )


def record(
    draw: np.random.Generator, world: World, bench: Bench, row: FloatArray, repeats: Sequence[int], stranger: Stranger | None
) -> tuple[Trial, ...]:
    """Recordings of what goes on, row (N,): of each condition as many as `repeats` says."""
    trials, seed = list[Trial](), int(draw.integers(2**31))
    for place, (trial, count) in enumerate(zip(world.rig.experiment.trials, repeats, strict=True)):
        segments = [segment for segment in world.prediction.segments if segment.trial == place]
        for repeat in range(count):
            farthest = min(SPARE - EDGE - bench.slid_in, int(LAG * world.rig.samples))
            later = int(draw.integers(farthest)) if bench.out_of_step and repeat else 0
            window = slice(bench.slid_in + later, bench.slid_in + later + world.rig.samples)
            strange = stranger.row(trial.times.size, seed + stranger.anew * (10 * place + repeat)) if stranger else 0.0
            outputs = {s.channel: _output(draw, bench, s.channel, trial.times, row[s.at] + strange, window) for s in segments}
            inputs = {name: _input(draw, bench, column, window) for name, column in trial.inputs.items()}
            trials.append(replace(trial, file=f"{trial.file}{repeat}", times=trial.times[window], inputs=inputs, outputs=outputs))
    return tuple(trials)


def _output(draw: np.random.Generator, bench: Bench, channel: str, times: FloatArray, row: FloatArray, window: slice) -> FloatArray:
    gain, zero, clock = bench.setup[channel]
    seen, _ = lfilter(*bench.sensor, row, zi=lfilter_zi(*bench.sensor) * row[0])
    late = (clock + CLOCK * float(draw.normal())) * float(times[1] - times[0])
    shown = np.interp(times[window] - late, times, seen)
    factor = (1 + gain) * (1 + GAIN * float(draw.normal()))
    recorded: FloatArray = factor * shown + zero + ZERO * bench.noise * float(draw.normal()) + bench.noise * _noise(draw, bench, shown.size)
    return recorded


def _noise(draw: np.random.Generator, bench: Bench, count: int) -> FloatArray:
    """Of variance 1."""
    size = count + RUN_IN
    wide = math.sqrt(1 - 2 / bench.degrees)  # 1 where tails are a normal distribution's
    white = wide * (draw.normal(size=size) if math.isinf(bench.degrees) else draw.standard_t(bench.degrees, size))
    row: FloatArray = lfilter([math.sqrt(1 - bench.colour**2)], [1.0, -bench.colour], white)[RUN_IN:]
    return row


def _input(draw: np.random.Generator, bench: Bench, column: FloatArray, window: slice) -> FloatArray:
    own = column[window]
    if not bench.input_noise:
        return own
    noisy = own + bench.input_noise * float(np.sqrt(np.mean(own**2))) * draw.normal(size=own.size)
    step = bench.input_step * float(np.ptp(own))
    recorded: FloatArray = np.round(noisy / step) * step if step > 0 else noisy
    return recorded
