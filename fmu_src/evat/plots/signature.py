"""What does an effect's signature look like? One figure: a vibration cycle, a friction rig, and the conditions in which it shows most."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import MaxNLocator

from evat.model import FloatArray
from evat.native import kernel
from evat.plots.cycles import COLOURS, STYLE, label, new_figure, save_figure
from evat.signature import Signature, SignaturePanel
from evat.signature.runs import Axis
from evat.units import affine, display

CONDITION_PANELS = 3


def _shown(axis: Axis, column: FloatArray) -> tuple[FloatArray, str]:
    """The column as people read it, and its label; a time in the unit that fits its span."""
    unit = axis.display_unit
    if unit == "s" and not axis.logarithmic:
        span = float(np.max(np.abs(column)))
        unit = "us" if span < 1e-3 else "ms" if span < 1 else "s"
    factor, offset = affine(axis.unit, unit)
    return column * factor + offset, label(axis.name, unit)


def _draw(axes: Any, panel: SignaturePanel) -> None:
    for over, values, style in (
        (panel.over[0], panel.without, {"color": COLOURS[5], "lw": 2.4, "alpha": 0.55, "label": "without"}),
        (panel.over[1], panel.with_effect, {"color": COLOURS[0], "lw": 1.3, "label": "with"}),
    ):
        across, across_label = _shown(panel.across, over)
        up, up_label = _shown(panel.up, values)
        axes.plot(across, up, **style)
    axes.set(xlabel=across_label, ylabel=up_label)
    axes.set_title(f"{panel.title}\n", loc="left")
    if panel.across.logarithmic:
        axes.set_xscale("log")
    else:
        axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.ticklabel_format(axis="y", useOffset=False)
    low, high = axes.get_ylim()
    least = 0.02 * max(abs(low), abs(high))  # a line that is all but constant is drawn as one
    if high - low < least:
        axes.set_ylim(0.5 * (low + high - least), 0.5 * (low + high + least))
    share = panel.share
    much = "less than 0.1" if share < 1e-3 else f"{100 * share:.{0 if share > 0.1 else 1}f}"
    text = f"differs by {much} % (rms)" if panel.shows else "no difference"
    axes.text(0, 1.02, text, transform=axes.transAxes, va="bottom", fontsize="small", color=COLOURS[0])


def plot_signature(signature: Signature, path: Path) -> Path:
    """Six panels: two quantities over a vibration cycle, force over slip on a rig, three conditions; each says by how much it differs."""
    friction, principal, feed, proxy = signature.cycle
    only_proxy = proxy.shows and not any(force.shows for force in (friction, principal, feed))
    # friction itself is shown on the rig
    panels = (principal, proxy if only_proxy else feed, signature.rig, *signature.conditions[:CONDITION_PANELS])
    values = ", ".join(
        f"{name.partition('.')[2]} = {display(value, kernel.variable(name), digits=4)}" for name, value in signature.values.items()
    )
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(2, 3, (14, 7.6), sharex=False)
        for each, panel in zip(axes.ravel(), panels, strict=False):
            _draw(each, panel)
        for each in axes.ravel()[len(panels) :]:
            each.set_visible(False)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.suptitle(f"{signature.effect.name} ({values})\n{signature.effect.signature}", fontsize="medium")
        return save_figure(figure, path)
