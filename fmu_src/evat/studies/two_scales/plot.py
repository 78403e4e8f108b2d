"""What do two time scales look like? A cut in both modes with its error, alone and on a machine; and what a step does to a coupled tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from evat.model import FloatArray
from evat.plots.cycles import COLOURS, STYLE, new_figure, save_figure
from evat.studies.two_scales.study import FORCES, TwoScales


def _plot_cut(cut: TwoScales, force: Axes, error: Axes) -> None:
    """Principal force of both modes over time, and the error of the mean forces below it."""
    middle = 0.5 * (cut.times[1:] + cut.times[:-1])
    place = FORCES.index("principal")
    force.plot(middle, cut.means["resolved"][:, place], color=COLOURS[1], lw=4, alpha=0.5, label="resolved: every cycle")
    force.plot(middle, cut.means["cycle"][:, place], color=COLOURS[0], lw=1, label="averaging = cycle: one cycle a step")
    force.set_ylabel("mean principal\nforce [N]")
    force.legend()
    error.semilogy(middle, cut.said, color=COLOURS[4], lw=1, label="what averaging_error says")
    error.semilogy(middle, cut.error, color=COLOURS[0], lw=1, label="error of the mean forces")
    error.set_ylabel("error [N]")
    error.set_xlabel("time [s]")
    error.legend()


def plot_cut(cut: TwoScales, path: Path, title: str) -> Path:
    """The cut alone: cutting speed, force, error."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(3, 1, (8, 6.4))
        speed, force, error = axes[:, 0]
        speed.plot(cut.times, 60 * cut.speed, color=COLOURS[2], lw=1)
        speed.set_ylabel("cutting speed\n[m/min]")
        speed.set_title(title, loc="left")
        _plot_cut(cut, force, error)
        return save_figure(figure, path)


def plot_two_scales(cut: TwoScales, others: Sequence[TwoScales], path: Path) -> Path:
    """The cut over time with the error of each step; and error and cost over the communication step, from `others`."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(2, 2, (11, 5.6), sharex=False)
        (force, error_over_step), (error, cost) = axes
        _plot_cut(cut, force, error)
        force.set_title(f"A cut of {np.ptp(cut.times):g} s at 20 kHz, steps of {1e3 * (cut.times[1] - cut.times[0]):g} ms", loc="left")
        error.sharex(force)
        steps = [1e3 * (one.times[1] - one.times[0]) for one in others]
        error_over_step.loglog(steps, [100 * one.relative_error for one in others], "o-", color=COLOURS[0], label="largest, at the jump")
        error_over_step.loglog(steps, [100 * one.typical_error for one in others], "s-", color=COLOURS[1], label="of half of the steps")
        error_over_step.axhline(1, color="black", lw=0.8, ls=":")
        error_over_step.set_ylabel("error of the mean\nforce [%]")
        error_over_step.set_title("Over the communication step", loc="left")
        error_over_step.legend()
        cheaper = [one.internal_steps["resolved"] / one.internal_steps["cycle"] for one in others]
        cost.loglog(steps, cheaper, "o-", color=COLOURS[2])
        cost.axhline(10, color="black", lw=0.8, ls=":")
        cost.set_ylabel("internal steps saved,\nresolved over averaged [-]")
        cost.set_xlabel("communication step [ms]")
        return save_figure(figure, path)


def plot_coupling(steps: Sequence[float], error: Mapping[str, FloatArray], made: Mapping[str, FloatArray], path: Path) -> Path:
    """Error of the tool's displacement, and energy that the interface makes, over the communication step [s]; by the way of coupling."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(1, 2, (11, 3.9), sharex=False)
        for axis, errors, name in zip(
            axes[0],
            (error, made),
            ("error of the tool's displacement [%]", "energy made or lost, share of\nwhat the tool holds [%]"),
            strict=True,
        ):
            for colour, marker, (way, numbers) in zip(COLOURS, "osv^D", errors.items(), strict=False):
                axis.loglog(1e3 * np.asarray(steps), 100 * numbers, f"{marker}-", color=colour, label=way)
            axis.set_xlabel("communication step [ms]")
            axis.set_ylabel(name)
        axes[0][0].axhline(1, color="black", lw=0.8, ls=":")
        figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
        return save_figure(figure, path)
