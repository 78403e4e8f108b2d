"""What does the study of the paper's table 2 look like? The table, the profiles, the draws with the predictions, the cycles behind it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.plots.cycles import COLOURS, STYLE, in_display_unit, label, new_figure, save_figure
from evat.studies.main_job import FORCES, MODELS
from evat.studies.paper.domain import DomainShares
from evat.studies.paper.means import Calculation, mean_error, measured
from evat.studies.paper.result import ACCEPTED, ConditionProfile, PaperStudy, ranked
from evat.studies.paper.study import FEED, chosen
from evat.units import SPEED_UNITS

OF_MODEL = dict(zip(MODELS, COLOURS, strict=False))
TABLE, PROFILES, DRAWS, CYCLES = "table-2.png", "profiles.png", "draws.png", "cycles.png"


def plot_all(study: PaperStudy, shares: Sequence[DomainShares], folder: Path) -> list[Path]:
    """All four figures."""
    return [
        plot_table(study, folder / TABLE),
        plot_profiles(study, folder / PROFILES),
        plot_draws(study, folder / DRAWS),
        plot_cycles_behind(shares, folder / CYCLES),
    ]


def plot_table(study: PaperStudy, path: Path) -> Path:
    """The eight measured means and those of each law at its own best; below, the mean error of each law in every reading."""
    titles = list(paper_tables.materials().values())
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(2, 2, (11, 7.4), sharex=False)
        for axis, (place, force) in zip(axes[0], enumerate(FORCES), strict=True):
            at = np.arange(len(titles))
            axis.bar(at - 0.3, measured()[:, place], 0.19, color=COLOURS[5], label="measured")
            for number, (model, known) in enumerate(MODELS.items()):
                best = study.best[Calculation(model, chosen().principle, chosen().speed_unit)]
                axis.bar(
                    at - 0.1 + 0.2 * number, best.forces[:, place], 0.19, color=OF_MODEL[model], label=f"{known.title}, at its own best"
                )
                printed = [_printed(material, force, model) for material in paper_tables.materials()]
                marks = axis.plot(at - 0.1 + 0.2 * number, printed, "_", ms=9, mew=2, color="black")[0]
            marks.set_label("the paper's calculation")
            axis.set_xticks(at, titles)
            axis.set_ylabel(label(f"mean {force}", "N"))
            axis.grid(axis="x", visible=False)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
        _plot_errors(study, axes[1, 0])
        _plot_deviations(study, axes[1, 1])
        figure.suptitle(f"The paper's table 2 under conditions that are inferred ({chosen().principle.replace('_', ' ')})")
        return save_figure(figure, path)


def _printed(material: str, force: str, model: str) -> float:
    row = next(row for row in paper_tables.table_2() if (row.material, row.force) == (material, force))
    return row.calculated[model][chosen().principle]


def _plot_errors(study: PaperStudy, axis: Axes) -> None:
    principles = kernel.variable("shear_angle_principle").choices
    rows = {
        "the paper, as printed": {model: paper_tables.mean_relative_error(model) for model in MODELS},
        "inferred, round values": {model: float(mean_error(means / measured() - 1)) for model, means in study.inferred.items()},
    }
    for unit in SPEED_UNITS:
        for principle in sorted(principles, key=lambda one: one != chosen().principle):
            rows[f"own best, {principle.replace('_', ' ')}, {unit}"] = study.ranking(principle, unit)
    for number, errors in enumerate(rows.values()):
        for place, (model, error) in enumerate(errors.items()):
            axis.barh(number - 0.25 + 0.25 * place, 100 * error, 0.23, color=OF_MODEL[model])
            axis.text(100 * error + 0.8, number - 0.25 + 0.25 * place, f"{100 * error:.1f}", va="center", fontsize=7)
    axis.set_yticks(range(len(rows)), list(rows), fontsize=8)
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("mean error of the eight means [%]")


def _plot_deviations(study: PaperStudy, axis: Axes) -> None:
    """By material, the share of the modified law and LuGre in the mean error under the inferred conditions."""
    titles = list(paper_tables.materials().values())
    at = np.arange(len(titles))
    for number, (model, means) in enumerate(study.inferred.items()):
        share = 100 * np.abs(means / measured() - 1) / measured().size
        left = at - 0.25 + 0.25 * number
        axis.bar(left, share[:, FEED], 0.23, color=OF_MODEL[model])
        axis.bar(left, share[:, 1 - FEED], 0.23, bottom=share[:, FEED], color=OF_MODEL[model], alpha=0.4)
    axis.set_xticks(at, titles)
    axis.grid(axis="x", visible=False)
    axis.set_ylabel("points of mean error under the inferred\nconditions (pale: principal force) [%]")


def plot_profiles(study: PaperStudy, path: Path) -> Path:
    """Least mean error of the modified law over each condition; what is inferred, what the main job guesses, what counts as well enough."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(2, 4, (13, 6.2), sharex=False)
        for axis, one in zip(axes.ravel(), study.profiles, strict=False):
            _plot_profile(one, axis)
        for axis in axes[:, 0]:
            axis.set_ylabel("least mean error [%]")
        for axis in axes.ravel()[len(study.profiles) :]:
            axis.set_visible(False)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.suptitle(f"{MODELS[chosen().model].title}: one condition held, all others free")
        return save_figure(figure, path)


def _plot_profile(one: ConditionProfile, axis: Axes) -> None:
    name = one.condition.variable
    at, text = in_display_unit(name, one.values)
    low, high = in_display_unit(name, np.array(one.interval))[0]
    axis.axvspan(low, high, color=COLOURS[2], alpha=0.12, label="as good as the paper's calculation")
    axis.semilogx(at, 100 * one.errors, "o-", color=COLOURS[2], ms=4, label="least mean error")
    axis.axhline(100 * one.threshold, color="black", lw=0.8, ls=":", label="the paper's, as printed")
    axis.axvline(float(in_display_unit(name, np.array([one.condition.inferred]))[0][0]), color=COLOURS[0], lw=1.3, label="inferred, round")
    axis.set_ylim(0, 100 * max(2 * one.threshold, 0.2))
    ticks = [float(f"{tick:.2g}") for tick in np.geomspace(at[0], at[-1], 4)]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()
    axis.set_xlabel(text.replace("\n", " "))
    axis.set_title(one.verdict)


def plot_draws(study: PaperStudy, path: Path) -> Path:
    """The draws: error of the modified law over that of LuGre, and the ranking; beside it feed forces predicted for a material left out."""
    errors = study.draw_errors(chosen().principle, chosen().speed_unit)
    met, kept = errors.min(axis=0) <= ACCEPTED, ranked(errors)
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(1, 2, (11, 4.8), sharex=False)
        cloud, prediction = axes[0]
        for some, colour, size, what in (
            (~met & np.isfinite(errors).all(axis=0), "#c8ccd0", 4, "no law meets the means"),
            (met & kept, COLOURS[2], 16, "met, ranking as in the paper"),
            (met & ~kept, COLOURS[0], 16, "met, another ranking"),
        ):
            cloud.scatter(100 * errors[1, some], 100 * errors[2, some], s=size, color=colour, label=f"{what} ({some.sum()})")
        cloud.axline((20, 20), slope=1, color="black", lw=0.8, ls=":")
        cloud.set(xlim=(8, 60), ylim=(8, 60), xlabel="mean error of LuGre [%]", ylabel="mean error of the modified LuGre [%]")
        cloud.set_title(f"draws; met: up to {100 * ACCEPTED:.0f} % by the best law")
        cloud.legend(loc="lower right")
        titles = paper_tables.materials()
        for number, model in enumerate(MODELS):
            some = [one for one in study.left_out if one.model == model]
            told = [one for one in some if one.predicted.size]
            at = np.array([some.index(one) for one in told]) - 0.12 + 0.12 * number
            middle = np.array([one.median for one in told])
            ends = np.array([np.percentile(one.predicted, [5, 95]) for one in told]).reshape(-1, 2)
            text = MODELS[model].title if told else f"{MODELS[model].title}: meets no three materials"
            prediction.errorbar(at, middle, np.abs(ends - middle[:, None]).T, fmt="o", capsize=3, ms=5, color=OF_MODEL[model], label=text)
        prediction.plot(range(len(titles)), measured()[:, FEED], "_", ms=26, mew=2, color=COLOURS[5], label="measured")
        prediction.set_xticks(range(len(titles)), list(titles.values()))
        prediction.set_ylabel(label("mean feed_force", "N"))
        prediction.set_title("predicted from the other three materials, 5 to 95 % of draws")
        prediction.legend()
        return save_figure(figure, path)


def plot_cycles_behind(shares: Sequence[DomainShares], path: Path) -> Path:
    """Friction and normal force over a cycle under the inferred conditions, and where they leave the model's domain."""
    titles = paper_tables.materials()
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(2, 2, (11, 6.4))
        for axis, one in zip(axes.ravel(), shares, strict=True):
            times, touching = 1e6 * one.cycle.times, one.cycle["in_contact"] > 0
            friction, normal = (np.where(touching, one.cycle[name], np.nan) for name in ("friction_force", "normal_force"))
            axis.plot(times, normal, color=COLOURS[1], lw=1.3, label="normal force N")
            axis.plot(times, friction, color=COLOURS[0], lw=1.3, label="friction force F")
            for some, colour, what in (
                (touching & (np.abs(friction) > normal), COLOURS[4], "|F| > N"),
                (touching & (normal <= 0), COLOURS[5], "N = 0"),
            ):
                axis.fill_between(times, 0, 1, where=some, transform=axis.get_xaxis_transform(), color=colour, alpha=0.18, lw=0, label=what)
            parts = {"N = 0": one.no_normal_force, "|F| > N": one.beyond_normal_force, "stiffness at its floor": one.stiffness_at_floor}
            told = ", ".join(f"{what}: {100 * share:.0f} %" for what, share in parts.items())
            axis.set_title(f"{titles[one.material]}; of the contact, {told}", fontsize="small")
            axis.set_ylabel(label("force", "N"))
        for axis in axes[1]:
            axis.set_xlabel("time in the vibration cycle [us]")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.suptitle(f"{MODELS[chosen().model].title} under the inferred conditions")
        return save_figure(figure, path)
