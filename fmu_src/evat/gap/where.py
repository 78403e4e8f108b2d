"""Where does a gap lie? In which channel, and in which range of a signal, the phase, the time or the condition most of its square lies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evat.gap.cycles import cycle_time
from evat.model import BoolArray, FloatArray
from evat.prediction import Prediction

MOST = 0.8  # of the square of the gap that a box is to hold
BINS = 40
WORTH = 0.08  # a range must hold this much more of the gap than of the samples
PHASE = "phase"
SHOWN = 0.05  # channels with less of the gap are not described


@dataclass(frozen=True)
class Region:
    """A box: ranges of signals, `phase` (0 to 1; [0.9, 0.1] runs over the end), `time` or values of the condition; `share` of the whole
    squared gap lies in it."""

    channel: str
    box: Mapping[str, tuple[float, float]]
    share: float


@dataclass(frozen=True)
class Where:
    """`channels` and `trials`: their shares of the squared gap; `regions`: the boxes that hold most of it, the largest first."""

    channels: Mapping[str, float]
    regions: tuple[Region, ...]
    trials: Mapping[str, float]


def samples_of(prediction: Prediction, place: int) -> dict[str, FloatArray]:
    """What a sample of a trial can be told by: its inputs, phase, time, and what its trial was run at."""
    trial = prediction.experiment.trials[place]
    size = trial.times.size
    found = {name: column for name, column in trial.inputs.items()}
    period = cycle_time(prediction, place)
    if math.isfinite(period):
        found[PHASE] = np.mod(trial.times / period, 1.0)
    found["time"] = trial.times
    found.update({name: np.full(size, value) for name, value in trial.values.items()})
    return found


def locate(prediction: Prediction, gap: FloatArray) -> Where:
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
    regions = []
    for channel, share in sorted(channels.items(), key=lambda item: -item[1]):
        if share < SHOWN:
            continue
        energy, columns = _gathered(prediction, channel, squares)
        box, inside = _box(energy, columns)
        regions.append(Region(channel, box, inside * share))
    return Where(channels, tuple(sorted(regions, key=lambda region: -region.share)), trials)


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


def _box(energy: FloatArray, columns: Mapping[str, FloatArray]) -> tuple[dict[str, tuple[float, float]], float]:
    """One or two ranges, and the share of the energy inside."""
    total = float(energy.sum())
    if total <= 0:
        return {}, 0.0
    box, inside = dict[str, tuple[float, float]](), np.ones(energy.size, dtype=bool)
    for _ in range(2):
        best: tuple[float, str, tuple[float, float]] | None = None
        for name, column in columns.items():
            if name in box or np.ptp(column) == 0:
                continue
            wanted = (MOST if not box else math.sqrt(MOST)) * float(energy[inside].sum())
            found = _range(energy * inside, column, inside, wanted, name == PHASE)
            if found is None:
                continue
            kept = inside & within(column, found)
            gain = float(energy[kept].sum() / energy[inside].sum()) - float(kept.sum() / inside.sum())
            if gain > WORTH and (best is None or gain > best[0]):
                best = (gain, name, found)
        if best is None:
            break
        _, name, bounds = best
        box[name] = bounds
        inside &= within(columns[name], bounds)
    return box, float(energy[inside].sum()) / total


def within(column: FloatArray, bounds: tuple[float, float]) -> BoolArray:
    """Which samples lie in a range; one whose low end is above its high end (of a phase) runs over the end of the cycle."""
    low, high = bounds
    above, below = column >= low, column <= high
    return above & below if low <= high else above | below


def _range(energy: FloatArray, column: FloatArray, inside: BoolArray, wanted: float, turns: bool) -> tuple[float, float] | None:
    """The range with the fewest samples that holds the energy `wanted`; turns : it may run over the end."""
    low, high = (0.0, 1.0) if turns else (float(column[inside].min()), float(column[inside].max()))
    values = np.unique(column[inside])
    few = values.size <= BINS and not turns
    bins = values.size if few else BINS
    starts, ends = (values, values) if few else (np.linspace(low, high, BINS + 1)[:-1], np.linspace(low, high, BINS + 1)[1:])
    place = np.searchsorted(values, column) if few else ((column - low) / (high - low) * BINS).astype(int)
    place = np.clip(place, 0, bins - 1)
    sums, counts = (np.bincount(place[inside], weights, bins) for weights in (energy[inside], np.ones(int(inside.sum()))))
    if turns:
        sums, counts = np.tile(sums, 2), np.tile(counts, 2)
    sums, counts = np.concatenate([[0.0], np.cumsum(sums)]), np.concatenate([[0.0], np.cumsum(counts)])
    best: tuple[float, int, int] | None = None
    end, last = 0, sums.size - 1
    for begin in range(bins):
        end = max(end, begin)
        while end < last and sums[end + 1] - sums[begin] < wanted:
            end += 1
        if end == last:
            break
        size = float(counts[end + 1] - counts[begin])
        if best is None or size < best[0]:
            best = (size, begin, end)
    if best is None:
        return None
    _, begin, end = best
    if turns and end - begin >= bins - 1:
        return 0.0, 1.0
    return float(starts[begin]), float(ends[end % bins])
