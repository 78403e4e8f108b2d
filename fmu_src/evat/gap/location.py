"""Where does a gap lie? In which channel, and in which range of a signal, the phase, the time or the condition most of its square lies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.smallest_region import smallest_place
from evat.inference.cycles import cycle_time
from evat.inference.prediction import Prediction
from evat.model import FloatArray

PHASE = "phase"


@dataclass(frozen=True)
class Region:
    """A box: ranges of signals, `phase` (0 to 1; [0.9, 0.1] runs over the end), `time` or values of the condition; `share` of the whole
    squared gap lies in it."""

    channel: str
    box: Mapping[str, tuple[float, float]]
    share: float


@dataclass(frozen=True)
class Location:
    """`channels` and `trials`: their shares of the squared gap; `regions`: the boxes that hold most of it, the largest first; a channel may
    have two of them."""

    channels: Mapping[str, float]
    regions: tuple[Region, ...]
    trials: Mapping[str, float]


def samples_of(prediction: Prediction, place: int) -> dict[str, FloatArray]:
    """What a sample of a trial can be told by: its inputs, phase, time, and what its trial was run at."""
    trial = prediction.experiment.trials[place]
    size = trial.times.size
    coordinates = {name: column for name, column in trial.inputs.items()}
    period = cycle_time(prediction, place)
    if math.isfinite(period):
        coordinates[PHASE] = np.mod(trial.times / period, 1.0)
    coordinates["time"] = trial.times
    coordinates.update({name: np.full(size, value) for name, value in trial.values.items()})
    return coordinates


def locate(prediction: Prediction, gap: FloatArray) -> Location:
    """gap : (N,), what is to be placed: an effect's contribution, or a residual."""
    squares = gap**2
    total = float(squares.sum()) or 1.0
    channels, trials = dict[str, float](), dict[str, float]()
    for segment in prediction.segments:
        share = float(squares[segment.at].sum()) / total
        channels[segment.channel] = channels.get(segment.channel, 0.0) + share
        if segment.trial >= 0:
            file = prediction.experiment.trials[segment.trial].file
            trials[file] = trials.get(file, 0.0) + share
    regions = list[Region]()
    for channel, share in sorted(channels.items(), key=lambda item: -item[1]):
        if share < CONSTANTS.least_described_share:
            continue
        energy, columns = _gathered(prediction, channel, squares)
        regions += [Region(channel, box, inside * share) for box, inside in smallest_place(energy, columns, PHASE)]
    return Location(channels, tuple(sorted(regions, key=lambda region: -region.share)), trials)


def _gathered(prediction: Prediction, channel: str, squares: FloatArray) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Squares of one channel, sample by sample, and what each sample is told by (only what all of them have)."""
    energy, rows = list[FloatArray](), list[dict[str, FloatArray]]()
    means, at = prediction.experiment.means, 0
    for segment in prediction.segments:
        if segment.channel != channel:
            continue
        energy.append(squares[segment.at])
        if segment.trial >= 0:
            rows.append(samples_of(prediction, segment.trial))
        elif means is not None:
            rows.append({name: column[at : at + 1] for name, column in means.values.items()})
            at += 1
    names = set(rows[0]).intersection(*rows[1:])
    return np.concatenate(energy), {name: np.concatenate([row[name] for row in rows]) for name in rows[0] if name in names}
