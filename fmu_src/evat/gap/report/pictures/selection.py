"""Which pictures does a report have? The models beside the measurement, what they leave, averages, and where the gap lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.signal import welch

from evat.gap.location import Region
from evat.gap.report.pictures.chart import DARK, GREEN, Chart, Line, Panel, axis
from evat.gap.report.pictures.location import location_charts
from evat.gap.report.pictures.series import CONDITIONS, LOOKS, POINTS, Record, Series, extremes, lines_of, stretch, telling
from evat.gap.report.words import shown_unit
from evat.inference.noise.autoregression import impulse_response
from evat.model import FloatArray
from evat.plots.cycles import clock_unit

EVEN = 1.01  # longest over shortest step up to which a spectrum is made
LONGEST = 1024  # samples of a piece of it


def charts(series: Series, regions: Sequence[Region], unlike: FloatArray) -> dict[str, list[Chart]]:
    """By where they stand in the report."""
    prediction = series.comparison.prediction
    by_section: dict[str, list[Chart]] = {"where": [], "models": [], "left": []}
    for number, channel in enumerate(dict.fromkeys(region.channel for region in regions)):
        by_section["where"] += location_charts(series, [region for region in regions if region.channel == channel], unlike, number)
    for number, channel in enumerate(dict.fromkeys(segment.channel for segment in prediction.segments if segment.trial >= 0)):
        records = [series.record(place) for place in series.recorded(channel)]
        box = next((region.box for region in regions if region.channel == channel), {})
        choices = [record.condition for record in records]
        by_section["models"].append(_models(series, records, choices, box, number))
        by_section["left"].append(_left(series, records, choices, number))
    if prediction.experiment.means is not None:
        by_section["models"] += _means(series)
    return by_section


def _models(series: Series, records: Sequence[Record], choices: Sequence[str], box: Mapping[str, object], number: int) -> Chart:
    """Measured and all models over time, and over the telling signal."""
    names = ["measured", *series.vectors]
    prediction, channel = series.comparison.prediction, records[0].channel
    force = axis(channel, series.unit(channel))
    factor, clock = clock_unit(max(float(np.ptp(record.signals["time"])) for record in records))
    signal = telling(records[0], box, list(prediction.experiment.trials[0].inputs))
    over_time, over_signal = list[Line](), list[Line]()
    for record, choice in zip(records, choices, strict=True):
        at = extremes(record.lines["measured"])
        over_time += lines_of(record, names, record.signals["time"][at] * factor, at, choice)
        if signal is not None and signal in record.signals:
            part = stretch(record.lines["measured"] - record.lines["nominal"])
            over_signal += lines_of(record, names, record.signals[signal][part], part, choice)
    panels = [Panel(axis("time", clock), force, tuple(over_time))]
    if signal is not None:
        panels.append(Panel(axis(signal, series.unit(signal)), force, tuple(over_signal)))
    return Chart(
        f"models-{number}",
        f"{channel.replace('_', ' ')}: mean of the repeats of one condition, and the models. {_which(records)}",
        tuple((panel,) for panel in panels) if len(panels) == 1 else (tuple(panels),),
        tuple(choices),
    )


def _which(records: Sequence[Record]) -> str:
    most = max(record.lines["measured"].size for record in records)
    thinned = f" Of {most} samples, at most {POINTS} are drawn in a line." if most > POINTS else ""
    return f"The conditions with the largest gap, at most {CONDITIONS}, stand in the menu.{thinned}"


def _left(series: Series, records: Sequence[Record], choices: Sequence[str], number: int) -> Chart:
    """What each model leaves, over time and frequency, beside the noise of the repeats."""
    channel = records[0].channel
    name_of = axis(channel, series.unit(channel)).rpartition("[")
    factor, clock = clock_unit(max(float(np.ptp(record.signals["time"])) for record in records))
    over_time, spectra = list[Line](), list[Line]()
    for record, choice in zip(records, choices, strict=True):
        times = record.signals["time"]
        steps = np.diff(times)
        even = times.size > 16 and float(steps.max()) < EVEN * float(steps.min())
        for name in series.vectors:
            left = record.lines["measured"] - record.lines[name]
            at = extremes(left)
            colour, style = LOOKS[name]
            over_time.append(Line(name, times[at] * factor, left[at], colour, style, None, choice))
            if even:
                rate = 1 / float(np.median(steps))
                frequency, power = welch(left, rate, nperseg=min(times.size, LONGEST), detrend=False)
                spectra.append(Line(name, frequency[1:], np.sqrt(power[1:]), colour, style, None, choice))
        if even:
            spectra.append(_noise(series, record, rate, frequency[1:], choice))
    panels = [Panel(axis("time", clock), f"measured less model [{name_of[2]}", tuple(over_time))]
    if spectra:
        root = f"{name_of[2].rstrip(']')}/sqrt(Hz)]"
        panels.append(Panel(axis("frequency", "Hz"), f"spectrum [{root}", tuple(spectra), logarithmic=True))
    return Chart(
        f"left-{number}",
        f"{channel.replace('_', ' ')}: what the models leave of the mean of the repeats.",
        (tuple(panels),),
        tuple(choices),
    )


def _noise(series: Series, record: Record, rate: float, frequency: FloatArray, choice: str) -> Line:
    """Spectrum of the noise that the mean of the repeats has."""
    whitening = series.comparison.whitening
    place = next(n for n, g in enumerate(whitening.groups) if g.channel == record.channel and g.condition == record.condition)
    size, response = float(whitening.sizes[place]), impulse_response(whitening.noise.filters[record.channel])
    gain = np.abs(np.exp(-2j * np.pi * np.outer(frequency / rate, np.arange(response.size))) @ response)
    _, factor, _ = shown_unit(series.comparison.prediction, record.channel)
    return Line("noise", frequency, factor * gain * size * np.sqrt(2 / rate / record.repeats), GREEN, "dot", None, choice)


def _means(series: Series) -> list[Chart]:
    """Averages, a mark for each condition."""
    prediction = series.comparison.prediction
    means = prediction.experiment.means
    if means is None:
        return []
    panels, x = [], np.arange(len(means.conditions), dtype=np.float64)
    for channel, measured in means.outputs.items():
        at = [segment.at.start for segment in prediction.segments if segment.trial < 0 and segment.channel == channel]
        sd, (_, factor, _) = means.sd.get(channel), shown_unit(prediction, channel)
        lines = [Line("measured", x, series.shown(channel, measured), DARK, "marks", None if sd is None else factor * sd)]
        lines += [Line(name, x, series.shown(channel, row[at]), LOOKS[name][0], LOOKS[name][1]) for name, row in series.vectors.items()]
        panels.append(Panel("condition", axis(channel, series.unit(channel)), tuple(lines), ticks=means.conditions))
    return [
        Chart(
            "means",
            "Averages, measured (with their standard deviation, where it was given) and by the models.",
            tuple((p,) for p in panels),
        )
    ]
