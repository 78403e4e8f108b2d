"""What does a run look like? Figures for people, with matplotlib; every axis has a name and a unit."""

from __future__ import annotations

import base64
import io
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from evat.console import printable
from evat.files.writing import OutputError, whole
from evat.model import FloatArray, Trace, Variable
from evat.native import kernel
from evat.notebook.panels import COLOURS, NARROW, STYLE, clock_unit, draw, label, new_figure
from evat.units import affine

__all__ = [
    "COLOURS",
    "NARROW",
    "STYLE",
    "as_it_stands",
    "check_picture",
    "clock_unit",
    "cycles",
    "in_display_unit",
    "inline",
    "label",
    "new_figure",
    "plot_cycles",
    "plot_record",
    "plot_trace",
    "save_figure",
]


def as_it_stands(figure: Figure) -> None:
    """Titles and labels may quote a file: to matplotlib a dollar begins a formula, which may be a wrong one."""
    legends = [legend for legend in (*figure.legends, *(axes.get_legend() for axes in figure.axes)) if legend is not None]
    texts = [*figure.texts, *(text for legend in legends for text in legend.get_texts())]
    for axes in figure.axes:
        texts += [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts]
    for text in texts:
        text.set_parse_math(False)
        text.set_text(printable(text.get_text()))


def check_picture(path: Path) -> str:
    """The format of a picture by its suffix; OutputError where that is none."""
    form = path.suffix.removeprefix(".").lower()
    if form not in FigureCanvasAgg.get_supported_filetypes():
        raise OutputError(f"{path}: a picture of the kind {path.suffix!r} cannot be written; name it .png, .svg or .pdf.")
    return form


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a picture whole, in the format of its suffix; OutputError where it cannot be written."""
    form = check_picture(path)
    as_it_stands(figure)
    with whole(path, "the picture") as made:
        figure.savefig(made, format=form, dpi=120, metadata={"Software": None} if form == "png" else None)
    return path


def inline(picture: Figure | bytes) -> str:
    """A figure, or a .png that is there, as it stands in a page."""
    if isinstance(picture, Figure):
        as_it_stands(picture)
        data = io.BytesIO()
        picture.savefig(data, format="png", dpi=120, metadata={"Software": None})
        picture = data.getvalue()
    return "data:image/png;base64," + base64.b64encode(picture).decode("ascii")


def in_display_unit(shown: str | Variable, column: FloatArray) -> tuple[FloatArray, str]:
    """A column of a variable, which may be given by its name, in its display unit, and the label of its axis."""
    variable = kernel.variable(shown) if isinstance(shown, str) else shown
    unit = variable.display_unit or variable.unit
    factor, offset = affine(variable.unit, unit)
    return column * factor + offset, label(variable.name, unit)


def plot_trace(trace: Trace, path: Path, names: Sequence[str], title: str = "") -> Path:
    """One panel for each of `names` over time."""
    factor, unit = clock_unit(float(trace.times[-1] - trace.times[0]))
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(len(names), 1, (8, 1.2 + 1.7 * len(names)))
        for axis, name, colour in zip(axes[:, 0], names, COLOURS * 10, strict=False):
            values, text = in_display_unit(name, trace[name])
            draw(axis, trace.times * factor, values, colour)
            axis.set_ylabel(text)
        axes[-1, 0].set_xlabel(label("time", unit))
        axes[0, 0].set_title(title)
        return save_figure(figure, path)


def plot_cycles(panels: Mapping[str, Mapping[str, Trace]], force: str, path: Path, title: str) -> Path:
    """One vibration cycle of `force` for each panel: a line for each of its traces, dashed where the label names the second principle."""
    return save_figure(cycles(panels, force, title), path)


def cycles(panels: Mapping[str, Mapping[str, Trace]], force: str, title: str, *, narrow: bool = False) -> Figure:
    """The picture of `plot_cycles`; narrow, for a phone: its panels one below the other."""
    columns = 1 if narrow else 2
    rows = -(-len(panels) // columns)
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(rows, columns, (NARROW, 1.5 + 2.6 * rows) if narrow else (10, 3.2 * rows))
        for axis, (panel, traces) in zip(axes.ravel(), panels.items(), strict=False):
            for place, (line, trace) in enumerate(traces.items()):
                values, name = in_display_unit(force, trace[force])
                factor, unit = clock_unit(float(trace.times[-1] - trace.times[0]))
                style = "-" if place % 2 == 0 else "--"
                axis.plot((trace.times - trace.times[0]) * factor, values, style, color=COLOURS[place // 2], lw=1.3, label=line)
                axis.set_xlabel(f"time in the vibration cycle [{unit}]")
                axis.set_ylabel(name)
            axis.set_title(panel)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=1 if narrow else 3)
        figure.suptitle(textwrap.fill(title, 44) if narrow else title)
        return figure


def plot_record(times: FloatArray, velocity: FloatArray, measured: FloatArray, simulated: FloatArray, path: Path, title: str) -> Path:
    """Measured velocity, measured and simulated friction force over time (a window) and over the sliding distance, and the residual."""
    window = slice(0, int(np.searchsorted(times, times[0] + (times[-1] - times[0]) / 15)) + 2)
    distance = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(times))])
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(2, 2, (12, 7), sharex=False)
        (slip, force), (loop, residual) = axes
        values, name = in_display_unit("slip_velocity", velocity)
        slip.plot(times[window], values[window], color=COLOURS[5], lw=1)
        slip.set(xlabel=label("time", "s"), ylabel=name, title="measured motion (in)")
        travel, travelled = in_display_unit("tool_displacement_x", distance)  # for the unit in which the table shows a displacement
        along = label("displacement", travelled.rpartition("[")[2].rstrip("]"))
        both = {
            "measured": in_display_unit("friction_force", measured),
            "simulated by the FMU": in_display_unit("friction_force", simulated),
        }
        for axis, abscissa, clock in ((force, times, label("time", "s")), (loop, travel, along)):
            for (key, (values, name)), colour in zip(both.items(), COLOURS, strict=False):
                axis.plot(abscissa[window], values[window], color=colour, lw=1.2, label=key)
                axis.set(xlabel=clock, ylabel=name)
        force.set_title("friction force (out)")
        loop.set_title("friction force over the displacement")
        figure.legend(*force.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        values, name = in_display_unit("friction_force", simulated - measured)
        residual.plot(times, values, color=COLOURS[2], lw=0.6)
        residual.set(xlabel=label("time", "s"), ylabel=f"residual, {name}", title="simulated less measured, the whole record")
        figure.suptitle(title)
        return save_figure(figure, path)
