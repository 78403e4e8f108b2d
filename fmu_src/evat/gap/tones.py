"""Does a tone stand out of what repeats do not share? It comes and goes with the motion, at another phase in each repeat, as of a squeal,
and passes for noise.

What repeats do not share is cut into short stretches, in which a tone stands still though its frequency follows the speed, and the spectrum
of each is held against its own broad band.
"""

from __future__ import annotations

import math

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.prediction import Prediction
from evat.inference.recorded_inputs import same_motion
from evat.model import FloatArray
from evat.required_inputs import MOTION


def tones(prediction: Prediction) -> tuple[str, ...]:
    """The tones that were recorded, a sentence for each channel; none where nothing stands out in several recordings."""
    said = list[str]()
    trials, units = prediction.experiment.trials, {variable.name: variable.unit for variable in prediction.model.variables}
    for channel in prediction.channels:
        seen, recordings = list[tuple[float, float, float]](), set[str]()
        for group in same_motion(trials):
            segments = [segment for segment in prediction.segments if segment.channel == channel and segment.trial in group]
            if len(segments) < 2:
                continue
            rows = np.array([prediction.measured[segment.at] for segment in segments])
            apart = (rows - rows.mean(axis=0)) * math.sqrt(len(rows) / (len(rows) - 1))
            for segment, row in zip(segments, apart, strict=True):
                trial = trials[segment.trial]
                own = stretches(row, trial.sampling_interval)
                speeds = np.abs(trial.inputs[MOTION]) if MOTION in trial.inputs else np.full(row.size, math.nan)
                seen += [(frequency, amplitude, float(np.mean(speeds[at]))) for at, frequency, amplitude in own]
                recordings |= {trial.file} if own else set()
        if len(recordings) < CONSTANTS.fewest_recordings_of_a_tone:
            continue
        table = np.array(seen)
        low, high = np.quantile(table[:, 0], [0.1, 0.9])
        least, most = np.quantile(table[:, 2], [0.1, 0.9])
        where = f", where the speed is {least:.2g} to {most:.2g} m/s" if math.isfinite(least) else ""
        said.append(
            f"{channel}: unknown is a tone of {low:.3g} to {high:.3g} Hz and {np.median(table[:, 1]):.2g} {units[channel]}, in "
            f"{len(recordings)} recordings{where}; repeats do not share its phase, as of a squeal, and no model here has it"
        )
    return tuple(said)


def stretches(row: FloatArray, step: float) -> list[tuple[slice, float, float]]:
    """Where a row (n,) of samples `step` [s] apart has a tone: the samples, its frequency [Hz], its amplitude."""
    size, slowest = CONSTANTS.tone_samples, CONSTANTS.slowest_tone  # slower is a level that wanders
    if row.size < 2 * size:
        return []
    memory = float(np.clip(row[1:] @ row[:-1] / (row @ row + 1e-300), -0.99, 0.99))
    white = np.concatenate([[0.0], row[1:] - memory * row[:-1]])
    told = list[tuple[slice, float, float]]()
    for begin in range(0, row.size - size + 1, size // 2):
        at = slice(begin, begin + size)
        spectrum = np.abs(np.fft.rfft(white[at] * _window(size))) ** 2
        if tone := _tone(spectrum, slowest, memory, step):
            told.append((at, *tone))
    return told


def _window(size: int) -> FloatArray:
    return np.hanning(size + 1)[:-1]


def _tone(spectrum: FloatArray, slowest: int, memory: float, step: float) -> tuple[float, float] | None:
    """Frequency [Hz] and amplitude of what stands out of a spectrum; None where nothing does. At the slowest place the flank of a slower
    tone, or of a level, is as high as a tone: only what is higher than both its neighbours is one.

    A tone between two frequencies of the spectrum is told by the larger of its neighbours in Hann's window (Grandke 1983, not read).
    """
    size, inner = 2 * (spectrum.size - 1), spectrum[1:-1]
    tops = np.where((inner > spectrum[:-2]) & (inner >= spectrum[2:]), inner, 0.0)[slowest - 1 :]
    peak, around = slowest + int(np.argmax(tops)), float(np.median(spectrum[slowest:]))
    if not tops.max() > CONSTANTS.tone_height * around / math.log(2) > 0:  # the median of an exponential variable
        return None
    side = 1 if spectrum[peak + 1] > spectrum[peak - 1] else -1
    ratio = math.sqrt(spectrum[peak + side] / spectrum[peak])
    beside = (2 * ratio - 1) / (1 + ratio)
    frequency = (peak + side * beside) / (size * step)
    lower = float(np.sinc(beside)) / (1 - beside**2) if abs(beside) < 1 else 0.5
    passed = abs(1 - memory * np.exp(-2j * np.pi * frequency * step))
    return frequency, 2 * math.sqrt(spectrum[peak]) / float(_window(size).sum()) / lower / passed
