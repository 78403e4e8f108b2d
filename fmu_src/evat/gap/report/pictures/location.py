"""Where does the gap lie, as a picture: the force, and the share of the squared gap, over what bounds each region."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evat.gap.location import Region
from evat.gap.report.pictures.chart import DARK, Chart, Line, Panel, axis
from evat.gap.report.pictures.series import LOOKS, Record, Series, extremes, folded, lines_of, stretch, telling
from evat.gap.report.words import percent
from evat.model import FloatArray

BINS = 60
FOLDED = 3  # cycles, from which on means over the phase are drawn


def location_charts(series: Series, regions: Sequence[Region], unlike: FloatArray, number: int) -> list[Chart]:
    """The force and the share of the squared gap over what bounds the regions of a channel, the phase, and the telling signal."""
    channel, names = regions[0].channel, dict.fromkeys(name for each in regions for name in each.box)
    prediction, whitening = series.comparison.prediction, series.comparison.whitening
    groups = [place for place, g in enumerate(whitening.groups) if g.channel == channel and g.at.stop - g.at.start > 1]
    if not groups:
        return []
    strongest = max(groups, key=lambda place: float(np.sum(unlike[whitening.groups[place].at] ** 2)))
    record = series.record(strongest)
    inputs = list(prediction.experiment.trials[0].inputs)
    cycles = whitening.groups[strongest].cycles
    wanted = [*names, *(["phase"] if cycles >= FOLDED else []), telling(record, names, inputs) or "time", "time"]
    keys = [key for key in dict.fromkeys(wanted) if key in record.signals][:2]
    force, total = axis(channel, series.unit(channel)), float(np.sum(unlike**2)) or 1.0
    upper, lower = list[Panel](), list[Panel]()
    for key in keys:
        bands = tuple(piece for each in regions if key in each.box for piece in _pieces(series, key, each.box[key]))
        label = axis(key, series.unit(key))
        upper.append(Panel(label, force, _over(series, record, key, cycles), f"condition {record.condition}", bands))
        lower.append(Panel(label, "share of the squared gap [%]", (_shares(series, channel, key, unlike, total),), "all conditions", bands))
    ranges, share = "range holds" if len(regions) == 1 else "ranges hold", percent(sum(each.share for each in regions))
    held = f"the shaded {ranges} {share} of the squared gap of all channels" if names else "it lies in no range in particular"
    caption = f"{channel.replace('_', ' ')}: {held}."
    return [Chart(f"where-{number}", caption, (tuple(upper), tuple(lower)))]


def _over(series: Series, record: Record, key: str, cycles: float) -> tuple[Line, ...]:
    names = ["measured", "recalibrated", *(["corrected"] if "corrected" in series.vectors else [])]
    column = record.signals[key]
    if key == "phase" and cycles >= FOLDED:
        middles, lines = folded(column, {name: record.lines[name] for name in names})
        return tuple(Line(name, middles, lines[name], *LOOKS[name]) for name in names)
    if key == "time":
        at = extremes(record.lines["measured"])
        return lines_of(record, names, column[at], at, "")
    part = stretch(record.lines["measured"] - record.lines["nominal"])
    return lines_of(record, names, column[part], part, "", dots=True)


def _pieces(series: Series, key: str, bounds: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    """As it is drawn; a range of phase that runs over the end of the cycle is two."""
    low, high = (float(end) for end in series.shown(key, np.array(bounds)))
    return ((low, high),) if low <= high else ((low, 1.0), (0.0, high))


def _shares(series: Series, channel: str, key: str, unlike: FloatArray, total: float) -> Line:
    """Share of the squared gap in each bin of a signal, over all that was recorded of the channel [%]."""
    own = [segment for segment in series.comparison.prediction.segments if segment.channel == channel and segment.trial >= 0]
    columns = [series.signals(segment.trial).get(key) for segment in own]
    known = [(column, unlike[segment.at]) for column, segment in zip(columns, own, strict=True) if column is not None]
    low, high = min(float(column.min()) for column, _ in known), max(float(column.max()) for column, _ in known)
    if low == high:
        low, high = low - 0.5, high + 0.5
    edges = np.linspace(low, high, BINS + 1)
    sums = np.sum([np.histogram(column, edges, weights=gap**2)[0] for column, gap in known], axis=0)
    return Line("share of the squared gap", 0.5 * (edges[1:] + edges[:-1]), 100 * sums / total, DARK, "bars")
