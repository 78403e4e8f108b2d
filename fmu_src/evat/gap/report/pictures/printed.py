"""How is a picture drawn on paper, and where no script runs? As SVG by matplotlib, of the first choice."""

from __future__ import annotations

import base64
import io

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, NullFormatter

from evat.gap.report.pictures.chart import SKY, Chart, Line, Panel
from evat.plots.cycles import STYLE

SMALL = 1e-2  # numbers below are written with a prefix, 20u
POINTS = 500  # of a line; paper shows no more
STYLES = {"line": "-", "thick": "-", "dash": "--", "dot": ":"}


def drawn(chart: Chart) -> str:
    """The picture as a data URI."""
    rows, columns = len(chart.panels), max(len(row) for row in chart.panels)
    with mpl.rc_context({**STYLE, "svg.fonttype": "path", "text.parse_math": False}):
        width, height = 5.2 * columns, 2.8 * rows + 0.4
        figure = Figure(figsize=(width, height))
        FigureCanvasSVG(figure)
        axes = figure.subplots(rows, columns, squeeze=False)
        # Margins in inches: a layout that is computed takes as long as the drawing.
        figure.subplots_adjust(
            left=0.75 / width, right=1 - 0.1 / width, bottom=0.9 / height, top=1 - 0.3 / height, wspace=0.75 / 4.2, hspace=0.75 / 2.0
        )
        for row, panels in zip(axes, chart.panels, strict=True):
            for axis, panel in zip(row, panels, strict=False):
                _panel(axis, panel, chart.choices[0] if chart.choices else "")
            for axis in row[len(panels) :]:
                axis.set_visible(False)
        legends = [axis.get_legend_handles_labels() for axis in axes.ravel()]
        handles = {label: handle for own, labels in legends for handle, label in zip(own, labels, strict=True)}
        figure.legend(handles.values(), handles.keys(), loc="lower center", ncols=4)
        data = io.BytesIO()
        figure.savefig(data, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(data.getvalue()).decode("ascii")


def _panel(draw: Axes, panel: Panel, choice: str) -> None:
    for line in panel.lines:
        if line.choice in ("", choice):
            _line(draw, line)
    for low, high in panel.bands:
        draw.axvspan(low, high, color=SKY, alpha=0.25, lw=0, zorder=0)
    draw.set(xlabel=panel.x_label, ylabel=panel.y_label, title=panel.title)
    if panel.logarithmic:
        draw.set(xscale="log", yscale="log")
        draw.xaxis.set_minor_formatter(NullFormatter())
        draw.yaxis.set_minor_formatter(NullFormatter())
    for axis in (draw.xaxis, draw.yaxis):
        if panel.logarithmic or max(map(abs, axis.get_view_interval())) < SMALL:
            axis.set_major_formatter(EngFormatter(sep=""))
    if panel.ticks:
        draw.set_xticks(range(len(panel.ticks)), panel.ticks, rotation=45, ha="right")


def _line(draw: Axes, line: Line) -> None:
    rising = bool(np.all(np.diff(line.x) > 0))
    kept = slice(None, None, -(-line.x.size // POINTS)) if rising or line.style == "dots" else slice(POINTS)  # of a loop, some turns
    x, y = line.x[kept], line.y[kept]
    if line.style == "bars":
        draw.bar(line.x, line.y, width=float(np.min(np.diff(line.x))) if line.x.size > 1 else 0.8, color=line.colour, label=line.name)
    elif line.style == "marks":
        draw.errorbar(line.x, line.y, yerr=line.sd, fmt="o", ms=5, color=line.colour, label=line.name)
    elif line.style == "dots":
        draw.plot(x, y, ".", ms=2, color=line.colour, label=line.name)
    else:
        draw.plot(x, y, STYLES[line.style], lw=3.0 if line.style == "thick" else 1.1, color=line.colour, label=line.name)
