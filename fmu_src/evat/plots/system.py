"""What does a run of a system look like, and a sweep? A panel for each signal; the means over what was swept, or over the speed ratio."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np

from evat.model import Trace
from evat.plots.cycles import COLOURS, STYLE, clock_unit, label, new_figure, save_figure
from evat.systems.sweep import Row, SweepAxis

MOST_PANELS = 12
MAPPED = ("mean_principal_force", "mean_feed_force", "mean_contact_ratio")  # of a cut
RATIO = "speed_ratio"


def plot_run(trace: Trace, path: Path, names: Sequence[str], title: str) -> Path:
    """One panel for each of `names` over time."""
    names = list(names)[:MOST_PANELS]
    factor, unit = clock_unit(float(trace.times[-1] - trace.times[0]))
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(len(names), 1, (9, 1.0 + 1.3 * len(names)))
        for axis, name, colour in zip(axes[:, 0], names, COLOURS * 10, strict=False):
            axis.plot(trace.times * factor, trace[name], color=colour, lw=1.0)
            axis.set_ylabel(label(name.replace(".", ".\n", 1), trace.units[name]), fontsize=8)
        axes[-1, 0].set_xlabel(label("time", unit))
        axes[0, 0].set_title(title)
        return save_figure(figure, path)


def plot_sweep(axes: Sequence[SweepAxis], rows: Sequence[Row], units: Mapping[str, str], path: Path, beside: Sequence[Row] = ()) -> Path:
    """Means over the first axis, a line for each place on the others; over the speed ratio where the system shows one. What stood
    beside the rows is dashed, at the speed ratio of the rows."""
    names = next((list(row.means) for row in rows if row.means), [])
    mapped = [name for name in names if name.rpartition(".")[2] in MAPPED] or names[:MOST_PANELS]
    ratio = next((name for name in names if name.rpartition(".")[2] == RATIO), None)
    numbers, others = axes[0].numbers, {row.place: row.means for row in beside if row.means}
    with mpl.rc_context(STYLE):
        figure, panels = new_figure(len(mapped), 1, (8, 1 + 2.4 * len(mapped)))
        for panel, name in zip(panels[:, 0], mapped, strict=True):
            for colour, rest in enumerate(sorted({row.place[1:] for row in rows})):
                line = [row for row in rows if row.place[1:] == rest and row.means]
                if ratio is not None:
                    abscissa = np.array([row.means[ratio] for row in line])
                else:
                    abscissa = np.array([row.place[0] if numbers is None else numbers[row.place[0]] for row in line], dtype=float)
                order = np.argsort(abscissa)
                words = ", ".join(each.texts[place] for each, place in zip(axes[1:], rest, strict=True))
                values = np.array([row.means[name] for row in line])
                panel.plot(abscissa[order], values[order], "o-", ms=4, color=COLOURS[colour % len(COLOURS)], label=words or None)
                if others:
                    values = np.array([others[row.place][name] if row.place in others else np.nan for row in line])
                    panel.plot(abscissa[order], values[order], "--", lw=1, color=COLOURS[colour % len(COLOURS)])
            panel.set_ylabel(label(name.rpartition(".")[2], units[name]))
        if len(axes) > 1:
            figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        if ratio is not None:
            panels[-1, 0].set_xlabel("speed ratio HSR = cutting speed over the highest speed of the vibration")
        else:
            panels[-1, 0].set_xlabel(label(axes[0].label, axes[0].unit))
            if numbers is None:
                panels[-1, 0].set_xticks(range(len(axes[0].texts)), axes[0].texts)
        return save_figure(figure, path)
