"""What does the forecast look like? A map for each set: motions down, parameters across, the standard deviation as colour and number."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap

from evat.plots.cycles import STYLE, new_figure, save_figure
from evat.studies.recovery import IDENTIFIED, TOGETHER, WEAK, Recovery, percent

EDGES = (0.0, 0.001, 0.01, IDENTIFIED, 0.15, WEAK, np.inf)  # sd over the truth
COLOURS = ("#1e8449", "#58b27c", "#abdcbf", "#fbe7b0", "#f0b560", "#c9706a")


def plot_recovery(forecasts: Sequence[Recovery], path: Path) -> Path:
    columns = min(2, len(forecasts))
    rows = -(-len(forecasts) // columns)
    norm = BoundaryNorm([*EDGES[:-1], 1e3], len(COLOURS))
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure, axes = new_figure(rows, columns, (6.4 * columns, 0.9 + 2.75 * rows), sharex=False)
        for axis, one in zip(axes.ravel(), forecasts, strict=False):
            axis.imshow(np.minimum(one.sd, 999.0), cmap=ListedColormap(list(COLOURS)), norm=norm, aspect="auto")
            axis.set_xticks(range(len(one.truth)), [name.rpartition(".")[2] for name in one.truth])
            axis.set_yticks(range(len(one.sd)), [name.replace("_", " ") for name in (*one.motions, TOGETHER)])
            axis.axhline(len(one.motions) - 0.5, color="black", lw=1)
            axis.tick_params(length=0)
            axis.set_title(f"{one.name}: {one.title}".replace("$", r"\$"), loc="left")
            for (row, column), sd in np.ndenumerate(one.sd):
                axis.text(column, row, percent(float(sd)), ha="center", va="center", fontsize=8)
        for axis in axes.ravel()[len(forecasts) :]:
            axis.set_visible(False)
        lines = [mpl.patches.Patch(color=colour) for colour in COLOURS]
        figure.legend(lines, _labels(), loc="outside lower center", ncols=3)
        figure.suptitle("Standard deviation over the truth [%], all parameters free")
        return save_figure(figure, path)


def _labels() -> list[str]:
    said = ["identified"] * EDGES.index(IDENTIFIED) + ["weak"] * (EDGES.index(WEAK) - EDGES.index(IDENTIFIED)) + ["cannot come back"]
    ends = [f"{100 * low:g} to {100 * high:g} %" for low, high in itertools.pairwise(EDGES[:-1])]
    return [f"{word}: {text}" for word, text in zip(said, [*ends, f"above {100 * WEAK:g} %"], strict=True)]
