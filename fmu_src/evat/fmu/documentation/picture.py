"""What do contact and partners look like? Diagrams of what an FMU shows, tool, ellipse and chip or bodies that slide, blocks, and icons, as
PNG and SVG."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon, Rectangle

from evat.model import Variable

_TOOL, _CHIP, _WORK, _PATH, _FORCE = "#8a93a3", "#e8b06a", "#c9d3c0", "#2864a8", "#b3282d"
_PHI = math.radians(35)  # shear angle of the drawing
_EDGE = (0.0, 0.0)  # the cutting edge, lowest point of the ellipse


@dataclass(frozen=True, slots=True)
class Picture:
    """One drawing in both formats."""

    png: bytes
    svg: bytes


def _saved(figure: Figure, form: str, dpi: int, transparent: bool) -> bytes:
    stream = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if form == "svg" else {"Software": None}
    with matplotlib.rc_context({"svg.hashsalt": "evat", "svg.fonttype": "path"}):  # same drawing, same bytes
        figure.savefig(stream, format=form, dpi=dpi, transparent=transparent, metadata=metadata)
    return stream.getvalue()


def _draw(size: tuple[float, float], dpi: int, limits: Sequence[float], paint: Callable[[Axes], None], transparent: bool) -> Picture:
    figure = Figure(figsize=size)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=limits[:2], ylim=limits[2:], aspect="equal")
    axes.set_axis_off()
    paint(axes)
    return Picture(_saved(figure, "png", dpi, transparent), _saved(figure, "svg", dpi, transparent))


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], color: str, width: float = 1.6) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=9 * width, lw=width, color=color, shrinkA=0, shrinkB=0))


def _scene(axes: Axes, *, cusps_left: bool) -> None:
    """Work, chip and tool; the tool moves to the right (+x), away from the surface is up (+y)."""
    outline = 1.2
    depth, left, right, bottom = 1.0, -6.0, 7.0, -3.0
    shear_top = (depth / math.tan(_PHI), depth)
    cusps = np.linspace(left, 0.0, 121)
    floor = 0.14 * np.abs(np.sin(np.pi * cusps / 1.5)) * cusps_left
    work = [(left, bottom), *zip(cusps, floor, strict=True), shear_top, (right, depth), (right, bottom)]
    axes.add_patch(Polygon(work, fc=_WORK, ec="#5d6b52", lw=outline))
    lift, radius, turn = 1.3, 4.0, np.linspace(0.0, 0.6, 40)  # the chip leaves the rake face and curls
    thickness = shear_top[0]
    sides = [(radius - r * np.cos(turn), lift + r * np.sin(turn)) for r in (radius, radius - thickness)]
    inner, outer = (list(zip(x, y, strict=True)) for x, y in sides)
    axes.add_patch(Polygon([_EDGE, *inner, *outer[::-1], shear_top], fc=_CHIP, ec="#8a5a1c", lw=outline))
    clearance = math.radians(9)
    tool = [_EDGE, (0.0, 3.4), (-2.6, 3.4), (-2.6, 2.6 * math.tan(clearance))]
    axes.add_patch(Polygon(tool, fc=_TOOL, ec="#3d4450", lw=outline))
    axes.plot(*zip(_EDGE, shear_top, strict=True), ls="--", lw=outline, color="#5a3a10")


def _ellipse(axes: Axes, a: float, b: float, width: float) -> None:
    turn = np.linspace(0, 2 * np.pi, 200)
    axes.plot(a * np.cos(turn), b + b * np.sin(turn), color=_PATH, lw=width)
    for place in (0.35, 0.85):
        angle = 2 * np.pi * place
        tip, tail = angle + 0.1, angle - 0.1
        points = [(a * math.cos(t), b + b * math.sin(t)) for t in (tail, tip)]
        _arrow(axes, points[0], points[1], _PATH, width)


LABEL: dict[str, Any] = {"fontsize": 11, "ha": "center", "va": "center"}


def _forces(axes: Axes) -> None:
    """Of the chip on the tool."""
    _arrow(axes, (0.0, 2.1), (0.0, 3.3), _FORCE, 2)
    axes.text(-0.35, 3.15, r"$F$", color=_FORCE, **LABEL)
    _arrow(axes, (0.0, 2.1), (-1.2, 2.1), _FORCE, 2)
    axes.text(-1.15, 2.45, r"$N$", color=_FORCE, **LABEL)


def _cut(axes: Axes) -> None:
    """Tool, chip and the thickness h of the cut, with the angle of the shear plane."""
    _forces(axes)
    axes.text(-2.0, 2.95, "tool", **LABEL)
    axes.text(0.95, 2.0, "chip", **LABEL)
    arc = np.linspace(0, _PHI, 30)
    axes.plot(0.9 * np.cos(arc) + 0.0, 0.9 * np.sin(arc), lw=1, color="#5a3a10")
    axes.text(1.15, 0.33, r"$\phi$", color="#5a3a10", **LABEL)
    axes.annotate("", (5.6, 1.0), (5.6, 0.0), arrowprops={"arrowstyle": "<->", "lw": 1.2})
    axes.text(5.9, 0.5, r"$h$", **LABEL)
    axes.plot((0, 6.6), (0, 0), ls=":", lw=1, color="#5d6b52")


def _turning(axes: Axes) -> None:
    """The tool runs along its ellipse and leaves cusps."""
    _scene(axes, cusps_left=True)
    _ellipse(axes, 1.25, 0.8, 1.6)
    _cut(axes)
    _arrow(axes, (6.4, -0.85), (4.6, -0.85), "#3b4a2f")
    axes.text(5.5, -1.2, r"work, $v_c$", **LABEL)
    axes.text(-4.4, -0.9, "machined surface\nwith cusps", **LABEL)
    axes.text(-3.6, 1.55, "tool path\n" + r"$a\cos(\omega t+\varphi_x)$" + "\n" + r"$b\cos(\omega t+\varphi_y)$", color=_PATH, **LABEL)
    _arrow(axes, (4.2, 2.4), (5.4, 2.4), "black", 1.2)
    _arrow(axes, (4.2, 2.4), (4.2, 3.6), "black", 1.2)
    axes.text(5.65, 2.4, r"$x$", **LABEL)
    axes.text(4.2, 3.8, r"$y$", **LABEL)


def _turning_icon(axes: Axes) -> None:
    _scene(axes, cusps_left=True)
    _ellipse(axes, 1.5, 0.95, 2.4)


def _rake_face(axes: Axes) -> None:
    """The chip slides along the rake face, as fast as it is told to."""
    _scene(axes, cusps_left=False)
    _cut(axes)
    _arrow(axes, (0.45, 1.25), (0.45, 2.5), _PATH, 2)
    axes.text(0.75, 2.75, r"$v$", color=_PATH, **LABEL)
    axes.text(4.6, -0.9, "work", **LABEL)


def _rake_face_icon(axes: Axes) -> None:
    _scene(axes, cusps_left=False)
    _arrow(axes, (0.6, 0.9), (0.6, 3.2), _PATH, 2.4)


def _slide(axes: Axes, left: float, right: float, bottom: float) -> None:
    """A body that slides on another, on bent bristles."""
    foot, head = 0.5, 1.4
    axes.add_patch(Rectangle((left, bottom), right - left, foot - bottom, fc=_WORK, ec="#5d6b52", lw=1.2))
    axes.add_patch(Rectangle((-2.4, head), 4.8, 1.7, fc=_TOOL, ec="#3d4450", lw=1.2))
    rise = np.linspace(0.0, 1.0, 20)
    for place in np.linspace(-2.2, 1.7, 10):
        axes.plot(place + 0.5 * rise**2, foot + (head - foot) * rise, color=_CHIP, lw=2)


def _sliding(axes: Axes) -> None:
    """Slip velocity, load, friction, and the deflection z of the bristles."""
    _slide(axes, -5.2, 6.2, -1.2)
    _arrow(axes, (2.5, 2.6), (4.4, 2.6), _PATH, 2)
    axes.text(4.75, 2.6, r"$v$", color=_PATH, **LABEL)
    _arrow(axes, (-2.4, 1.6), (-4.2, 1.6), _FORCE, 2)
    axes.text(-4.55, 1.6, r"$F$", color=_FORCE, **LABEL)
    _arrow(axes, (0.0, 4.15), (0.0, 3.15), _FORCE, 2)
    axes.text(0.4, 3.75, r"$N$", color=_FORCE, **LABEL)
    axes.text(0.0, 2.2, "slide", **LABEL)
    axes.text(0.0, -0.4, "guideway", **LABEL)
    axes.plot((1.7, 1.7), (0.5, 1.4), ls=":", lw=1, color="#5a3a10")
    axes.text(2.75, 0.95, r"$z$", color="#5a3a10", **LABEL)


def _sliding_icon(axes: Axes) -> None:
    _slide(axes, -3.17, 3.57, -2.17)
    _arrow(axes, (-1.2, 3.8), (1.6, 3.8), _PATH, 2.4)


def _scene_of(shown: Collection[str]) -> tuple[Callable[[Axes], None], Callable[[Axes], None], str]:
    """Diagram, icon and words for what has these variables: it moves along the ellipse itself, is told its slip, or knows of no chip."""
    if "vibration_frequency" in shown:
        words = "Tool, ellipse and chip at rake angle 0; x along the cutting direction, y away from the machined surface. F and N are the "
        return _turning, _turning_icon, words + "forces of the chip on the tool."
    if "shear_stress" in shown:
        words = "Tool and chip at rake angle 0; the chip slides along the rake face at v. F and N are the forces of the chip on the tool."
        return _rake_face, _rake_face_icon, words
    return _sliding, _sliding_icon, "The slide moves at v and is pressed on by N; its bristles are bent by z, and F brakes it."


def diagram(shown: Collection[str]) -> tuple[Picture, str]:
    """What an FMU is that shows these variables of the contact, with the symbols of its equations, and a caption."""
    paint, _, words = _scene_of(shown)
    return _draw((7.0, 3.2), 160, (-6.0, 7.0, -1.7, 4.25), paint, transparent=False), words


def icon(shown: Collection[str]) -> Picture:
    """The same without terminals or words."""
    _, paint, _ = _scene_of(shown)

    def framed(axes: Axes) -> None:
        paint(axes)
        axes.add_patch(Rectangle((-3.17, -2.17), 6.74, 6.74, fc="none", ec="#3d4450", lw=2))

    return _draw((2.0, 2.0), 100, (-3.2, 3.6, -2.2, 4.6), framed, transparent=True)


def block(title: str, variables: Sequence[Variable]) -> Picture:
    """A partner as a block: what goes in on the left, what comes out on the right."""
    sides = {role: [v.name for v in variables if v.causality == role] for role in ("input", "output")}
    height = 0.3 * max(4, *(len(names) + 1 for names in sides.values()))

    def paint(axes: Axes) -> None:
        axes.add_patch(Rectangle((-1, 0), 2, height, fc=_WORK, ec="#3d4450", lw=1.5))
        axes.text(0, height / 2, title.replace("_", "\n").replace("Evat", ""), ha="center", va="center", fontsize=11)
        for role, edge, sign in (("input", -1.0, -1), ("output", 1.0, 1)):
            for place, name in enumerate(sides[role]):
                y = height * (1 - (place + 0.5) / len(sides[role]))
                ends = ((edge - 0.35, y), (edge, y)) if role == "input" else ((edge, y), (edge + 0.35, y))
                _arrow(axes, *ends, _PATH, 1.0)
                axes.text(edge + 0.4 * sign, y, name, ha="right" if sign < 0 else "left", va="center", fontsize=8)

    return _draw((6.6, 1.1 * height + 0.2), 120, (-3.3, 3.3, -0.1, height + 0.1), paint, transparent=False)


def terminal_icon(color: Sequence[int]) -> Picture:
    """A filled square, as mechanical flanges are drawn."""
    face = tuple(part / 255 for part in color)

    def paint(axes: Axes) -> None:
        axes.add_patch(Rectangle((-0.9, -0.9), 1.8, 1.8, fc=face, ec="black", lw=1))

    return _draw((0.4, 0.4), 100, (-1, 1, -1, 1), paint, transparent=True)
