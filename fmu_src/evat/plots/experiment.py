"""What does an experiment look like? Its inputs and outputs over time, and its outputs over its first input, condition by condition."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from evat.experiment import Experiment, ExperimentError, as_typed
from evat.native import kernel
from evat.plots.cycles import COLOURS, NARROW, STYLE, clock_unit, in_display_unit, label, new_figure, save_figure

MOST_POINTS = 20_000  # of a line; beyond that every so many are drawn


def plot_experiment(experiment: Experiment, path: Path) -> Path:
    """The picture of an experiment."""
    return save_figure(drawn(experiment), path)


def drawn(experiment: Experiment, narrow: bool = False) -> Figure:
    """One row for each input and output over time, beside it the outputs over the first input; a colour for each condition. Narrow, for a
    phone: the latter below the others."""
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
            every = slice(None, None, 1 + trial.times.size // MOST_POINTS)
            times = (trial.times[every] - trial.times[0]) * factor
            line = {"color": colours[trial.condition], "lw": 0.8, "alpha": 0.8}
            for row, (name, column) in enumerate({**trial.inputs, **trial.outputs}.items()):
                values, text = in_display_unit(typed[name], column[every])
                axes[row, 0].plot(times, values, label=trial.condition, **line)
                axes[row, 0].set(xlabel=label("time", unit), ylabel=text)
            for row, name in enumerate(over):
                against, along = in_display_unit(typed[inputs[0]], trial.inputs[inputs[0]][every])
                values, text = in_display_unit(typed[name], trial.outputs[name][every])
                beside[row].plot(against, values, **line)
                beside[row].set(xlabel=along.replace("\n", " "), ylabel=text)
        for unused in beside[len(over) :] if over else ():
            unused.remove()
        handles = dict(zip(*reversed(axes[0, 0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2 if narrow else min(6, len(handles)))
        figure.suptitle(experiment.title.replace("$", r"\$"), wrap=True)
        return figure
