"""What does an experiment look like? Its inputs and outputs over time, and its outputs over its first input, condition by condition."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from evat.experiment import Experiment, ExperimentError, as_typed
from evat.model import FloatArray, IntArray
from evat.native import kernel
from evat.plots.cycles import COLOURS, NARROW, STYLE, clock_unit, in_display_unit, label, new_figure, save_figure

MOST_POINTS = 20_000  # of a line; beyond that the least and the most of every so many are drawn


def plot_experiment(experiment: Experiment, path: Path, left_out: str = "") -> Path:
    """The picture of an experiment. left_out : what it does not show of the record, said below the title."""
    return save_figure(drawn(experiment, left_out=left_out), path)


def drawn(experiment: Experiment, narrow: bool = False, left_out: str = "") -> Figure:
    """One row for each input and output over time, beside it the outputs over the first input; a colour for each condition. Narrow, for a
    phone: the latter below the others. left_out : what is not shown, said below the title."""
    if not experiment.trials:
        raise ExperimentError(f"{experiment.title!r}: it has no recordings that could be drawn.")
    first = experiment.trials[0]
    inputs, outputs = list(first.inputs), list(first.outputs)
    colours = dict(zip(experiment.conditions, COLOURS * (1 + len(experiment.conditions) // len(COLOURS)), strict=False))
    factor, unit = clock_unit(max(float(trial.times[-1] - trial.times[0]) for trial in experiment.trials))
    over = outputs if inputs else []
    typed = {name: as_typed(kernel.variable(name), experiment.signals) for name in (*inputs, *outputs)}
    with mpl.rc_context(STYLE):
        count = len(inputs) + len(outputs)
        rows, size = (count + len(over), NARROW) if narrow else (count, 12 if over else 8)
        figure, axes = new_figure(rows, 1 if narrow else 1 + bool(over), (size, 1.2 + 2.4 * rows), False)
        beside = axes[count:, 0] if narrow else axes[:, -1]
        for trial in experiment.trials:
            times = (trial.times - trial.times[0]) * factor
            line = {"color": colours[trial.condition], "lw": 0.8, "alpha": 0.8}
            for row, (name, column) in enumerate({**trial.inputs, **trial.outputs}.items()):
                at = thinned(column)
                values, text = in_display_unit(typed[name], column[at])
                axes[row, 0].plot(times[at], values, label=trial.condition, **line)
                axes[row, 0].set(xlabel=label("time", unit), ylabel=text)
            for row, name in enumerate(over):
                at = thinned(trial.inputs[inputs[0]], trial.outputs[name])
                against, along = in_display_unit(typed[inputs[0]], trial.inputs[inputs[0]][at])
                values, text = in_display_unit(typed[name], trial.outputs[name][at])
                beside[row].plot(against, values, **line)
                beside[row].set(xlabel=along.replace("\n", " "), ylabel=text)
        for unused in beside[len(over) :] if over else ():
            unused.remove()
        handles = dict(zip(*reversed(axes[0, 0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2 if narrow else min(6, len(handles)))
        figure.suptitle("\n".join(filter(None, (experiment.title.replace("$", r"\$"), left_out))), wrap=True)
        return figure


def thinned(*columns: FloatArray, most: int = MOST_POINTS) -> IntArray:
    """Places of columns (n,) that show a line through them: of every so many the least and the most of each column, so that no peak is
    lost; all where these are no more than `most`."""
    count = columns[0].size
    if count <= most:
        return np.arange(count)
    bins = most // (2 * len(columns))
    begins = np.linspace(0, count, bins + 1).astype(np.intp)
    width = int(np.max(np.diff(begins)))
    places = np.minimum(begins[:-1, None] + np.arange(width), begins[1:, None] - 1)  # of a shorter bin the last one is there twice
    kept = [
        np.take_along_axis(places, pick(column[places], axis=1)[:, None], axis=1) for column in columns for pick in (np.argmin, np.argmax)
    ]
    at: IntArray = np.unique(np.concatenate([[0, count - 1], *(each[:, 0] for each in kept)]))
    return at
