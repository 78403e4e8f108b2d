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
            shared = rows.mean(axis=0)
            apart = (rows - shared) * math.sqrt(len(rows) / (len(rows) - 1))
            for segment, row in zip(segments, apart, strict=True):
                trial = trials[segment.trial]
                own = stretches(row, trial.sampling_interval, shared)
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


def stretches(row: FloatArray, step: float, shared: FloatArray | None = None) -> list[tuple[slice, float, float]]:
    """Where a row (n,) of samples `step` [s] apart has a tone: the samples, its frequency [Hz], its amplitude. One too slow for a short
    stretch is looked for in longer ones, each twice as long and for tones half as fast, and lasts for two that overlap.

    shared : what repeats share (n,). A slow tone in which they differ by less than they have in common is no tone: one sensor amplifies
    the motion a little more than another.
    """
    size, slowest = CONSTANTS.tone_samples, CONSTANTS.slowest_tone  # slower is a level that wanders
    if row.size < 2 * size:
        return []
    memory = float(np.clip(row[1:] @ row[:-1] / (row @ row + 1e-300), -0.99, 0.99))
    told = list[tuple[slice, float, float]]()
    for place, spectrum in enumerate(_spectra(row, memory, size)):
        around = float(np.median(spectrum[slowest:]))
        if tone := _tone(spectrum, around, slowest, size // 2, memory, step):
            told.append((_stretch(place, size), *tone))
    while 2 * size * slowest <= row.size:
        size *= 2
        common = np.zeros_like(row) if shared is None else shared
        told += _slow_tones(_spectra(row, memory, size), _spectra(common, memory, size), memory, step)
    return told


def _slow_tones(spectra: FloatArray, common: FloatArray, memory: float, step: float) -> list[tuple[slice, float, float]]:
    """Of the slowest octave. What wanders is larger the slower it is, by more than one memory tells: a slow tone stands out to either side,
    where few numbers tell how high it is in one stretch, so in the median of all stretches, too."""
    size, slowest, tones = 2 * (spectra.shape[1] - 1), CONSTANTS.slowest_tone, dict[int, tuple[float, float]]()
    for place, spectrum in enumerate(spectra):
        peak = slowest + int(np.argmax(spectrum[slowest : 2 * slowest]))
        beside = slice(1, max(peak - 1, 2)), slice(peak + 2, max(2 * peak, peak + 3))
        around = max(float(np.median(each[..., side])) for each in (spectrum, spectra) for side in beside)
        tone = _tone(spectrum, around, slowest, 2 * slowest - 1, memory, step)
        if tone and spectrum[peak] > common[place, peak]:
            tones[place] = tone
    near = 1 / (size * step)
    lasting = [p for p in tones if any(q in tones and abs(tones[q][0] - tones[p][0]) < near for q in (p - 1, p + 1))]
    return [(_stretch(place, size), *tones[place]) for place in lasting]


def _stretch(place: int, size: int) -> slice:
    return slice(place * (size // 2), place * (size // 2) + size)


def _spectra(row: FloatArray, memory: float, size: int) -> FloatArray:
    """Squares (stretches, frequencies) of the row less what one sample tells of the next, in stretches of so many that overlap by half."""
    white = np.concatenate([[0.0], row[1:] - memory * row[:-1]])
    spectra: FloatArray = np.abs(np.fft.rfft(sliding_window_view(white, size)[:: size // 2] * _window(size), axis=1)) ** 2
    return spectra


def _window(size: int) -> FloatArray:
    return np.hanning(size + 1)[:-1]


def _tone(spectrum: FloatArray, around: float, first: int, last: int, memory: float, step: float) -> tuple[float, float] | None:
    """Frequency [Hz] and amplitude of what stands out of `around`, a median, between two places of a spectrum; None where nothing does. At
    the edge of these places the flank of a slower tone, or of a level, is as high: only what is higher than both its neighbours is a tone.

    A tone between two frequencies of the spectrum is told by the larger of its neighbours in Hann's window (Grandke 1983).
    """
    size, inner = 2 * (spectrum.size - 1), spectrum[1:-1]
    tops = np.where((inner > spectrum[:-2]) & (inner >= spectrum[2:]), inner, 0.0)[first - 1 : last]
    peak = first + int(np.argmax(tops)) if tops.size else first
    if not tops.size or not tops.max() > CONSTANTS.tone_height * around / math.log(2) > 0:  # the median of an exponential variable
        return None
    side = 1 if spectrum[peak + 1] > spectrum[peak - 1] else -1
    ratio = math.sqrt(spectrum[peak + side] / spectrum[peak])
    beside = (2 * ratio - 1) / (1 + ratio)
    frequency = (peak + side * beside) / (size * step)
    lower = float(np.sinc(beside)) / (1 - beside**2) if abs(beside) < 1 else 0.5
    passed = abs(1 - memory * np.exp(-2j * np.pi * frequency * step))
    return frequency, 2 * math.sqrt(spectrum[peak]) / float(_window(size).sum()) / lower / passed
