"""Of a sine whose frequency is tried, which phase is the best? Its two quadrature components tell of all phases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.starts.linear import expected_evidence
from evat.gap.search.starts.periodogram import TIME, WAY, Peak
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import known
from evat.inference.fit import Fit
from evat.inference.parameters import Parameter
from evat.model import FloatArray


def sine_of(unknown: Sequence[Parameter]) -> tuple[int, int] | None:
    """Places of a frequency or period and of a phase, where these two are all that is unknown of a sine."""
    units = [parameter.unit for parameter in unknown]
    if len(units) != 2 or "rad" not in units:
        return None
    phase = units.index("rad")
    return (1 - phase, phase) if units[1 - phase] in (TIME, WAY) else None


def quadrature(tops: Sequence[Peak], unknown: Sequence[Parameter], sine: tuple[int, int]) -> FloatArray:
    """Points (2 k, 2) at peaks of a periodogram, each at phases of 0 and a quarter of a turn."""
    frequency, phase = (unknown[place] for place in sine)
    design = np.zeros((2 * len(tops), 2))
    design[:, sine[0]] = np.repeat([frequency.within(frequency.place(top.value)) for top in tops], 2)
    design[1::2, sine[1]] = phase.place(np.pi / 2)
    return design


def in_phase(
    whitening: BandWhitening, base: Fit, design: FloatArray, slopes: FloatArray, amplitudes: Sequence[Parameter], sine: tuple[int, int]
) -> tuple[FloatArray, FloatArray]:
    """Of quadrature points and their slopes (N, 2 k q): each frequency at its best phase, (k, 2), and the slopes there (N, k q)."""
    first, width = base.slopes.shape[1], len(amplitudes)
    everything = whitening.sums(base.predicted, np.column_stack([base.slopes, slopes])).grams
    information = known(everything, base.likelihood.weights * whitening.trust)
    start, best, turned = np.concatenate([base.point, np.zeros(width)]), design[::2].copy(), list[FloatArray]()
    phases = np.arange(CONSTANTS.phases) * 2 * np.pi / CONSTANTS.phases
    quarter = float(design[1, sine[1]]) if len(design) else 1.0
    for row in range(len(best)):
        own = first + 2 * row * width + np.arange(2 * width)
        kept = np.concatenate([np.arange(first), own, [-1]])
        block, gains = information[np.ix_(kept, kept)], list[float]()
        for phase in phases:
            mix = np.zeros((kept.size, first + width + 1))
            mix[:first, :first], mix[-1, -1] = np.eye(first), 1.0
            mix[first : first + width, first:-1], mix[first + width : -1, first:-1] = (
                np.cos(phase) * np.eye(width),
                np.sin(phase) * np.eye(width),
            )
            gains.append(expected_evidence(mix.T @ block @ mix, start, amplitudes))
        phase = float(phases[int(np.argmax(gains))])
        phase = phase if phase <= np.pi else phase - 2 * np.pi
        best[row, sine[1]] = phase / (np.pi / 2) * quarter
        raw = slopes[:, 2 * row * width : 2 * (row + 1) * width]
        turned.append(np.cos(phase) * raw[:, :width] + np.sin(phase) * raw[:, width:])
    return best, np.column_stack(turned) if turned else np.empty((slopes.shape[0], 0))
