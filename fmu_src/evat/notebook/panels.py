"""How are many signals drawn so that each can be read? Few enough panels, what was left out told, envelopes for what swings too fast.

A line that goes up and down more often than the picture has room for would be a solid band. Of such a signal the range and the mean within
short spans are drawn.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

from evat.notebook.choice import chosen, left_out

FloatArray = NDArray[np.float64]

COLOURS = ("#b03a2e", "#1f618d", "#1e8449", "#7d3c98", "#b9770e", "#34495e")
STYLE: Any = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": "medium",
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "legend.fontsize": "small",
    "svg.hashsalt": "evat",
}
NARROW = 5.0  # inches: of a picture that a phone shows
MOST_LINES = 10  # in one panel; more are drawn as their quantiles
MOST_TURNS = 240  # of a line across one panel, that can still be told from each other
SPANS = 240  # of an envelope
PREFIXES = ((1e-9, "n"), (1e-6, "u"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"), (1e9, "G"))
PREFIXED = ("m", "s", "N", "Pa", "W", "J", "Hz", "V", "A")  # units, alone or first of a product, that people read with a prefix


class NotebookFigure(Figure):
    """A figure that a notebook shows by itself, whether pyplot is loaded or not."""

    def _repr_png_(self) -> bytes:
        import io

        made = io.BytesIO()
        self.savefig(made, format="png", dpi=100)
        return made.getvalue()


def new_figure(rows: int, columns: int, size: tuple[float, float], sharex: bool = True) -> tuple[NotebookFigure, Any]:
    figure = NotebookFigure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, sharex=sharex, squeeze=False)


def label(name: str, unit: str) -> str:
    """The label of an axis; a pure number has the unit [-]. Long ones take two lines."""
    words, unit = name.replace("_", " ").replace(".", ": "), f"[{'-' if unit in ('1', '') else unit}]"
    return f"{words} {unit}" if len(words) + len(unit) < 23 else f"{words}\n{unit}"


def clock_unit(span: float) -> tuple[float, str]:
    """Factor and unit for a time axis of `span` seconds."""
    return (1e6, "us") if span < 5e-3 else (1e3, "ms") if span < 2 else (1.0, "s")


def prefixed(values: FloatArray, unit: str) -> tuple[float, str]:
    """Factor and unit in which numbers of an SI unit are read at ease: 3e-6 m as 3 um."""
    first = unit.replace("/", ".").partition(".")[0]
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if finite.size else 0.0
    if first not in PREFIXED or largest == 0 or 0.1 <= largest < 1e4:
        return 1.0, unit
    size, prefix = next(((size, prefix) for size, prefix in reversed(PREFIXES) if largest >= size), PREFIXES[0])
    return 1 / size, prefix + unit


def turns(values: FloatArray) -> int:
    """How often a line changes its direction."""
    steps = np.diff(values[np.isfinite(values)])
    signs = np.sign(steps[steps != 0])
    return int(np.count_nonzero(signs[1:] != signs[:-1]))


def envelope(times: FloatArray, values: FloatArray, spans: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Mid time, least, mean and largest value of each of `spans` runs of samples."""
    starts = np.linspace(0, values.size, spans + 1).astype(np.intp)[:-1]
    counts = np.diff(np.append(starts, values.size))
    return (
        np.add.reduceat(times, starts) / counts,
        np.minimum.reduceat(values, starts),
        np.add.reduceat(values, starts) / counts,
        np.maximum.reduceat(values, starts),
    )


def draw(axis: Any, times: FloatArray, values: FloatArray, colour: str, name: str | None = None) -> float:
    """One signal: a line, or its envelope where a line would be a band; then the span [of the clock] of each piece, else 0."""
    changes = turns(values)
    if changes <= MOST_TURNS or not np.all(np.isfinite(values)):
        axis.plot(times, values, color=colour, lw=1.0, label=name)
        return 0.0
    spans = max(1, min(SPANS, changes // 4))  # two cycles in each, or more
    middle, least, mean, largest = envelope(times, values, spans)
    axis.fill_between(middle, least, largest, color=colour, alpha=0.3, lw=0)
    axis.plot(middle, mean, color=colour, lw=1.0, label=name)
    return float((times[-1] - times[0]) / spans)


def over_time(
    times: FloatArray,
    columns: Mapping[str, FloatArray],
    units: Mapping[str, str],
    names: Sequence[str] = (),
    title: str = "",
    width: float = 9.0,
) -> NotebookFigure:
    """A panel for each of `names`, or of those that were `chosen`; columns of shape (n,), or (K, n) for several lines. width : [inch]."""
    means = {name: np.atleast_2d(column)[0] for name, column in columns.items()}
    shown = list(names) or chosen(means)
    factor, unit = clock_unit(float(times[-1] - times[0]))
    clock, spans = times * factor, 0.0
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(len(shown), 1, (width, 1.2 + 1.3 * len(shown)))
        for place, (axis, name) in enumerate(zip(axes[:, 0], shown, strict=True)):
            lines = np.atleast_2d(columns[name])
            scale, shown_unit = prefixed(lines, units.get(name, ""))
            colour = COLOURS[place % len(COLOURS)]
            if len(lines) > MOST_LINES:
                low, middle, high = np.nanquantile(lines * scale, (0.05, 0.5, 0.95), axis=0)
                axis.fill_between(clock, low, high, color=colour, alpha=0.3, lw=0)
                axis.plot(clock, middle, color=colour, lw=1.0)
            else:
                for number, line in enumerate(lines):
                    shade = colour if len(lines) == 1 else COLOURS[number % len(COLOURS)]
                    spans = max(spans, draw(axis, clock, line * scale, shade))
            axis.set_ylabel(label(name.replace(".", ".\n", 1), shown_unit), fontsize=8)
        axes[-1, 0].set_xlabel(label("time", unit))
        axes[0, 0].set_title(textwrap.fill(title, round(10 * width)))
        many = any(np.atleast_2d(columns[name]).shape[0] > MOST_LINES for name in shown)
        notes = [
            f"band: least to largest within {spans:.3g} {unit}; line: mean" if spans else "",
            "band: 5 to 95 % of the sets; line: median" if many else "",
            left_out(columns, shown) if not names else "",
        ]
        if told := "; ".join(filter(None, notes)):
            figure.supxlabel(textwrap.fill(told, round(15.5 * width)), fontsize=7)
        without_formulas(figure)
        return figure


Line = tuple[FloatArray, FloatArray]  # abscissa, values


def over_axis(
    lines: Mapping[str, Mapping[str, Line]],
    units: Mapping[str, str],
    axis_label: str,
    ticks: Sequence[str] | None = None,
    dashed: Mapping[str, Mapping[str, Line]] | None = None,
    note: str = "",
) -> NotebookFigure:
    """A panel for each quantity, in it a line for each of its labels; `dashed` in the same colours. `ticks` name the places 0, 1, 2, ..."""
    with mpl.rc_context(STYLE):
        figure, panels = new_figure(len(lines), 1, (8, 1.2 + 2.2 * len(lines)))
        for panel, (name, of_name) in zip(panels[:, 0], lines.items(), strict=True):
            scale, unit = prefixed(np.concatenate([values for _, values in of_name.values()]), units.get(name, ""))
            for number, (words, (abscissa, values)) in enumerate(of_name.items()):
                colour = COLOURS[number % len(COLOURS)]
                panel.plot(abscissa, values * scale, "o-", ms=4, color=colour, label=words or None)
                if words in (beside := (dashed or {}).get(name, {})):
                    panel.plot(beside[words][0], beside[words][1] * scale, "--", lw=1, color=colour)
            panel.set_ylabel(label(name.rpartition(".")[2], unit))
        if any(next(iter(lines.values()))):
            figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
        panels[-1, 0].set_xlabel(axis_label)
        if ticks is not None:
            panels[-1, 0].set_xticks(range(len(ticks)), ticks)
        if note:
            figure.supxlabel(textwrap.fill(note, 120), fontsize=7)
        without_formulas(figure)
        return figure


def bars(panels: Mapping[str, Mapping[str, Line]], names: Sequence[str], axis_label: str) -> NotebookFigure:
    """A panel for each key with a group of bars for each of `names`: by label the lengths and half their intervals."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(len(panels), 1, (8, 1.0 + len(panels) * (0.8 + 0.45 * len(names))))
        places = np.arange(len(names), dtype=np.float64)
        for axis, (title, groups) in zip(axes[:, 0], panels.items(), strict=True):
            height = 0.8 / len(groups)
            for number, (words, (lengths, errors)) in enumerate(groups.items()):
                at = places + (number - (len(groups) - 1) / 2) * height
                axis.barh(at, lengths, height, xerr=errors, color=COLOURS[number], alpha=0.8, label=words, error_kw={"lw": 1})
            axis.set_yticks(places, names)
            axis.invert_yaxis()
            axis.set_title(title)
        axes[-1, 0].set_xlabel(axis_label)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
        without_formulas(figure)
        return figure


def curves(
    panels: Mapping[str, tuple[FloatArray, FloatArray, float, float]], units: Mapping[str, str], axis_label: str, marked: str
) -> NotebookFigure:
    """A panel for each key: a curve (abscissa, values), a level across it, and its best place."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(len(panels), 1, (7, 1.0 + 2.0 * len(panels)), sharex=False)
        for axis, (name, (abscissa, values, level, best)) in zip(axes[:, 0], panels.items(), strict=True):
            scale, unit = prefixed(abscissa, units.get(name, ""))
            axis.plot(abscissa * scale, values, "o-", ms=3, color=COLOURS[1], lw=1.2)
            axis.axhline(level, color=COLOURS[5], ls="--", lw=0.8, label=marked)
            axis.axvline(best * scale, color=COLOURS[0], lw=1.0, label="estimate")
            axis.set_xlabel(label(name, unit).replace("\n", " "))
            axis.set_ylabel(axis_label)
            axis.set_ylim(0, 3 * level)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
        without_formulas(figure)
        return figure


def without_formulas(figure: Figure) -> None:
    """Titles and labels may quote a file: to matplotlib a dollar begins a formula, which may be a wrong one."""
    for text in figure.findobj(Text):
        text.set_parse_math(False)
