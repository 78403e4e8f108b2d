"""Does a tone stand out of what repeats do not share? It comes and goes with the motion, at another phase in each repeat, as of a squeal,
and passes for noise.

What repeats do not share is cut into short stretches, in which a tone stands still though its frequency follows the speed, and the spectrum
of each is held against its own broad band.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

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
    size = CONSTANTS.tone_samples
    if row.size < 2 * size:
        return []
    memory = float(np.clip(row[1:] @ row[:-1] / (row @ row + 1e-300), -0.99, 0.99))
    white, window = np.concatenate([[0.0], row[1:] - memory * row[:-1]]), np.hanning(size)
    spectra = np.abs(np.fft.rfft(sliding_window_view(white, size)[:: size // 2] * window, axis=1)) ** 2
    frequencies = np.fft.rfftfreq(size, step)
    spectra[:, : CONSTANTS.slowest_tone] = 0.0  # slower is a level that wanders
    band = np.median(spectra[:, CONSTANTS.slowest_tone :], axis=1) / math.log(2)  # the median of an exponential variable
    told = []
    for place, (spectrum, around) in enumerate(zip(spectra, band, strict=True)):
        peak = int(np.argmax(spectrum))
        if spectrum[peak] > CONSTANTS.tone_height * around > 0:
            begin, passed = place * (size // 2), abs(1 - memory * np.exp(-2j * np.pi * frequencies[peak] * step))
            amplitude = 2 * math.sqrt(spectrum[peak]) / float(window.sum()) / passed
            told.append((slice(begin, begin + size), float(frequencies[peak]), amplitude))
    return told
