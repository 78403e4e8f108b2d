"""Which numbers are drawn? Measured, nominal, recalibrated, corrected of each condition, thinned to what a screen shows."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from evat.gap.location import samples_of
from evat.gap.report.pictures.chart import BLUE, GREY, ORANGE, RED, Line, Style
from evat.gap.report.words import shown_unit
from evat.gap.search.compare import Comparison
from evat.inference.band_whitening import Group
from evat.model import FloatArray

POINTS = 2000  # of a line
CONDITIONS = 6  # that a picture lets choose from, those with the largest gap first
LOOKS: dict[str, tuple[str, Style]] = {
    "measured": (GREY, "thick"), "nominal": (RED, "dot"), "recalibrated": (ORANGE, "dash"), "corrected": (BLUE, "line"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Record:
    """One channel at one condition: `lines[name]` and `signals[name]` (what a sample is told by) of shape (n,), in the units in which they
    are drawn. `repeats` were averaged."""

    condition: str
    channel: str
    file: str
    repeats: int
    lines: Mapping[str, FloatArray]
    signals: Mapping[str, FloatArray]


class Series:
    """All that was compared, as lines; `corrected` (N,) is missing where no effect was chosen."""

    def __init__(self, comparison: Comparison, corrected: FloatArray | None) -> None:
        self.comparison = comparison
        self.vectors = {"nominal": comparison.nominal.predicted, "recalibrated": comparison.recalibrated.predicted}
        if corrected is not None:
            self.vectors["corrected"] = corrected
        self._signals = dict[int, dict[str, FloatArray]]()

    @property
    def last(self) -> str:
        """The best of the models that are drawn."""
        return list(self.vectors)[-1]

    def signals(self, trial: int) -> dict[str, FloatArray]:
        """What the samples of a trial are told by, in the units in which it is drawn."""
        if trial not in self._signals:
            known = samples_of(self.comparison.prediction, trial)
            self._signals[trial] = {name: self.shown(name, column) for name, column in known.items()}
        return self._signals[trial]

    def record(self, place: int) -> Record:
        """A group of repeats that are one run."""
        whitening, prediction = self.comparison.whitening, self.comparison.prediction
        group = whitening.groups[place]
        trial = prediction.segments[group.members[0]].trial
        lines = {"measured": whitening.means[place], **{name: row[group.at] for name, row in self.vectors.items()}}
        lines = {name: self.shown(group.channel, line) for name, line in lines.items()}
        return Record(
            group.condition, group.channel, prediction.experiment.trials[trial].file, len(group.members), lines, self.signals(trial)
        )

    def unit(self, name: str) -> str:
        """In which a signal or channel is drawn: that of its owner's files."""
        return shown_unit(self.comparison.prediction, name)[0]

    def shown(self, name: str, values: FloatArray) -> FloatArray:
        """Values of a signal or channel in that unit."""
        _, factor, offset = shown_unit(self.comparison.prediction, name)
        return values * factor + offset

    def recorded(self, channel: str) -> list[int]:
        """Of each condition one group, the one with most repeats; those with the largest nominal gap first."""
        best: dict[str, int] = {}
        groups = self.comparison.whitening.groups
        for place, group in enumerate(groups):
            if group.channel != channel or self._trial(group) < 0:
                continue
            before = best.get(group.condition)
            if before is None or len(group.members) > len(groups[before].members):
                best[group.condition] = place
        return sorted(best.values(), key=lambda place: -self.gap(place))[:CONDITIONS]

    def gap(self, place: int) -> float:
        """Mean square that the nominal model leaves."""
        return float(np.mean(self.comparison.whitening.residual(self.vectors["nominal"], place) ** 2))

    def _trial(self, group: Group) -> int:
        return self.comparison.prediction.segments[group.members[0]].trial


def unlike(comparison: Comparison, chosen: FloatArray | None, reference: FloatArray) -> FloatArray:
    """(N,) what the diagnosis has placed: what the effects change; without any, what `reference` leaves of the means of repeats."""
    if chosen is not None:
        return chosen - comparison.recalibrated.predicted
    return comparison.whitening.residuals(reference)


def extremes(column: FloatArray, most: int = POINTS) -> npt.NDArray[np.intp]:
    """Places of at most `most` samples: of each piece the lowest and the highest."""
    if column.size <= most:
        return np.arange(column.size)
    pieces = np.linspace(0, column.size, most // 2 + 1).astype(int)
    return np.array(
        [
            place
            for first, end in itertools.pairwise(pieces)
            for place in sorted({first + int(np.argmin(column[first:end])), first + int(np.argmax(column[first:end]))})
        ]
    )


def stretch(gap: FloatArray, most: int = POINTS) -> slice:
    """At most `most` samples in a row, where the gap is largest."""
    if gap.size <= most:
        return slice(0, gap.size)
    sums = np.concatenate([[0.0], np.cumsum(gap**2)])
    first = int(np.argmax(sums[most:] - sums[:-most]))
    return slice(first, first + most)


def folded(phase: FloatArray, lines: Mapping[str, FloatArray], bins: int = 200) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Means over the bins of a phase that have samples: their middles, and each line."""
    place = np.minimum((phase * bins).astype(int), bins - 1)
    counts = np.bincount(place, minlength=bins)
    some = np.flatnonzero(counts)
    return (some + 0.5) / bins, {name: np.bincount(place, line, bins)[some] / counts[some] for name, line in lines.items()}


def telling(record: Record, box: Mapping[str, object], inputs: Sequence[str]) -> str | None:
    """The signal that a force is best drawn over: one that the gap is bounded in, else an input, else the phase."""
    order = [*(name for name in box if name not in ("phase", "time")), *inputs, "phase"]
    return next((name for name in order if name in record.signals and np.ptp(record.signals[name]) > 0), None)


def lines_of(
    record: Record, names: Sequence[str], x: FloatArray, at: slice | npt.NDArray[np.intp], choice: str, dots: bool = False
) -> tuple[Line, ...]:
    lines = []
    for name in names:
        colour, style = LOOKS[name]
        lines.append(Line(name, x, record.lines[name][at], colour, "dots" if dots else style, None, choice))
    return tuple(lines)
