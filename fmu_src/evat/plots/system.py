"""What does a run of a system look like, and a sweep? A panel for each signal that was chosen; the means over what was swept."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from evat.model import Trace
from evat.notebook.choice import chosen, left_out
from evat.notebook.panels import NARROW, over_time
from evat.plots.cycles import save_figure
from evat.systems.sweep import Sweep


def plot_run(trace: Trace, path: Path, title: str) -> tuple[Path, str]:
    """The picture of a run, and what it leaves out, in a line."""
    figure = over_time(trace.times, trace.columns, trace.units, title=title)
    return save_figure(figure, path), left_out(trace.columns, chosen(trace.columns))


def narrow_run(trace: Trace) -> Figure:
    """The same, as a phone shows it."""
    return over_time(trace.times, trace.columns, trace.units, width=NARROW)


def plot_sweep(sweep: Sweep, path: Path) -> Path:
    """The map of a sweep."""
    return save_figure(sweep.plot(), path)
