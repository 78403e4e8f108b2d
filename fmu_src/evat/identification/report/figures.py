"""What does an identification look like? Measured against calculated, residuals, convergence, profiles, correlation."""

from __future__ import annotations

import base64
import io
import itertools
import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from evat.identification.result import Curve, Estimate, Identification
from evat.model import FloatArray, ParameterError
from evat.plots.cycles import COLOURS, STYLE, as_it_stands, clock_unit, label, new_figure, save_figure
from evat.units import affine

POINTS = 2000  # of a line; longer ones are drawn as the envelope of their pieces
PANELS = 6
RISE = "rise of the misfit [sd^2]"
PANEL, SMALL = (5.4, 3.0), (3.6, 2.9)  # inches; a page sets them side by side, or one below the other where it is narrow


def figures(identification: Identification) -> dict[str, list[str]]:
    """Pictures as data URIs (SVG), one for each panel, by what they show."""
    with mpl.rc_context({**STYLE, "svg.fonttype": "path"}):
        made = {
            "measured against calculated": _records(identification, residual=False),
            "residuals: calculated less measured": _records(identification, residual=True),
            "means: measured against calculated": _means(identification),
            "convergence": _convergence(identification),
            "profiles": [_profile(*each) for each in _profiled(identification)],
            "correlation": _correlation(identification),
        }
        return {name: [_uri(panel) for panel in panels] for name, panels in made.items() if panels}


def _uri(figure: Figure) -> str:
    as_it_stands(figure)
    data = io.BytesIO()
    figure.savefig(data, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(data.getvalue()).decode("ascii")


def _thinned(times: FloatArray, column: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most POINTS points: of each piece the lowest and the highest."""
    if column.size <= POINTS:
        return times, column
    pieces = np.linspace(0, column.size, POINTS // 2 + 1).astype(int)
    kept = [
        place
        for first, last in itertools.pairwise(pieces)
        for place in sorted({first + int(np.argmin(column[first:last])), first + int(np.argmax(column[first:last]))})
    ]
    return times[kept], column[kept]


def _records(identification: Identification, residual: bool) -> list[Figure]:
    """One recording of each condition, channel by channel."""
    rows, at = [], 0
    for trial in identification.experiment.trials:
        for channel, measured in trial.outputs.items():
            rows.append((trial, channel, measured, identification.predicted[at : at + measured.size]))
            at += measured.size
    first = {(trial.condition, channel): row for row in reversed(rows) for trial, channel in [(row[0], row[1])]}
    panels = list[Figure]()
    for trial, channel, measured, calculated in list(first.values())[::-1][:PANELS]:
        figure, axes = new_figure(1, 1, PANEL)
        factor, unit = clock_unit(float(trial.times[-1] - trial.times[0]))
        lines = {"calculated less measured": calculated - measured} if residual else {"measured": measured, "calculated": calculated}
        for (name, column), colour in zip(lines.items(), COLOURS[2:] if residual else COLOURS, strict=False):
            times, values = _thinned(trial.times, column)
            axes[0, 0].plot(times * factor, values, color=colour, lw=0.9, label=name)
        axes[0, 0].set(
            xlabel=label("time", unit),
            ylabel=label(channel, identification.units[channel]),
            title=f"{trial.condition}: {trial.file}",
        )
        _legend(figure)
        panels.append(figure)
    return panels


def _means(identification: Identification) -> list[Figure]:
    means = identification.experiment.means
    if means is None:
        return []
    at = sum(column.size for trial in identification.experiment.trials for column in trial.outputs.values())
    panels = list[Figure]()
    for channel, measured in means.outputs.items():
        figure, axes = new_figure(1, 1, PANEL)
        places = np.arange(measured.size)
        axes[0, 0].errorbar(places, measured, yerr=means.sd.get(channel), fmt="o", color=COLOURS[0], label="measured")
        axes[0, 0].plot(places, identification.predicted[at : at + measured.size], "x", color=COLOURS[1], label="calculated")
        axes[0, 0].set_xticks(places, means.conditions, rotation=45)
        axes[0, 0].set(ylabel=label(channel, identification.units[channel]))
        _legend(figure)
        panels.append(figure)
        at += measured.size
    return panels


def _legend(figure: Figure) -> None:
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _convergence(identification: Identification) -> list[Figure]:
    if len(identification.history) < 2:
        return []
    figure, axes = new_figure(1, 1, PANEL)
    evaluations = [generation.evaluations for generation in identification.history]
    best = [generation.best for generation in identification.history]
    axes[0, 0].plot(evaluations, best, color=COLOURS[0], label=_of(identification, "best so far"))
    medians = np.array([generation.median for generation in identification.history])
    axes[0, 0].plot(evaluations, np.where(medians < 1e29, medians, np.nan), color=COLOURS[1], lw=0.8, label="median of the generation")
    axes[0, 0].axhline(identification.cost, color=COLOURS[5], ls=":", label="after the polish")
    axes[0, 0].set(xlabel="model runs", ylabel=f"objective: {identification.objective.replace('_', ' ')}", yscale="log")
    axes[0, 0].legend()
    return [figure]


def _of(identification: Identification, what: str) -> str:
    some = identification.searched_points < identification.predicted.size
    return f"{what}, of excerpts" if some else what


def save_profiles(identification: Identification, path: Path) -> Path:
    """The profiles alone, as a picture."""
    profiles = _profiled(identification)
    if not profiles:
        raise ParameterError("there are no profiles to draw: the search was stopped before them, or they were not asked for.")
    columns = min(4, len(profiles))
    rows = -(-len(profiles) // columns)
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(rows, columns, (2.9 * columns, 2.6 * rows), sharex=False)
        for axis, (estimate, curve) in zip(axes.ravel(), profiles, strict=False):
            _draw_profile(axis, estimate, curve)
        for axis in axes.ravel()[len(profiles) :]:
            axis.set_visible(False)
        for row in axes:
            row[0].set_ylabel(RISE)
        return save_figure(figure, path)


def _smooth(curve: Curve, centre: float) -> tuple[FloatArray, FloatArray]:
    """The line through a profile's points: its root is all but straight on either side."""
    root = np.sign(curve.values - centre) * np.sqrt(np.maximum(curve.rise, 0.0))
    between = np.concatenate([np.linspace(low, high, 20) for low, high in itertools.pairwise(curve.values)])
    rise: FloatArray = np.interp(between, curve.values, root) ** 2
    return between, rise


def _profiled(identification: Identification) -> list[tuple[Estimate, Curve]]:
    return [(each, each.profile) for each in identification.estimates if each.profile is not None and each.profile.values.size > 1]


def _profile(estimate: Estimate, curve: Curve) -> Figure:
    figure, axes = new_figure(1, 1, SMALL)
    _draw_profile(axes[0, 0], estimate, curve)
    axes[0, 0].set_ylabel(RISE)
    return figure


def _draw_profile(axis: Axes, estimate: Estimate, curve: Curve) -> None:
    colour = {"identified": COLOURS[2], "weak": COLOURS[4]}.get(estimate.verdict, COLOURS[0])
    unit = estimate.variable.display_unit or estimate.variable.unit
    factor, offset = affine(estimate.variable.unit, unit)
    axis.plot(factor * curve.values + offset, curve.rise, "o", ms=3, color=colour)
    between, rise = _smooth(curve, estimate.value)
    axis.plot(factor * between + offset, rise, lw=1, color=colour)
    axis.axhline(curve.threshold, color=COLOURS[5], ls=":", lw=1)
    axis.axvline(factor * estimate.value + offset, color=COLOURS[5], lw=0.6)
    axis.set(ylim=(-0.3, 2.5 * curve.threshold), title=estimate.verdict, xlabel=label(estimate.name, unit))
    decades = math.log10(float(curve.values[-1] / curve.values[0])) if estimate.bounds[0] > 0 and not offset else 0.0
    if decades > 1:
        axis.set_xscale("log")
        axis.xaxis.set_major_locator(LogLocator(numticks=4))
        axis.xaxis.set_minor_formatter(NullFormatter())
    else:
        axis.xaxis.set_major_locator(MaxNLocator(3))
        axis.ticklabel_format(axis="x", useOffset=False)
    axis.tick_params(labelsize="small")


def _correlation(identification: Identification) -> list[Figure]:
    count = len(identification.estimates)
    if count < 2:
        return []
    figure, axes = new_figure(1, 1, (1.5 + 0.75 * count, 1 + 0.6 * count))
    axis = axes[0, 0]
    axis.grid(visible=False)
    image = axis.imshow(identification.correlation, vmin=-1, vmax=1, cmap="RdBu_r")
    names = [estimate.name for estimate in identification.estimates]
    axis.set_xticks(range(count), names, rotation=45, ha="right")
    axis.set_yticks(range(count), names)
    for row in range(count):
        for column in range(count):
            number = float(identification.correlation[row, column])
            axis.text(column, row, f"{number:.2f}", ha="center", va="center", fontsize=7, color="white" if abs(number) > 0.6 else "black")
    figure.colorbar(image)
    return [figure]
