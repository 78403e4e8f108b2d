"""What is a picture, before it is drawn? Panels of lines with named axes; one description for the screen and for paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from evat.model import FloatArray

Style = Literal["line", "thick", "dash", "dot", "dots", "marks", "bars"]

# By Okabe and Ito, told apart by eyes of all kinds.
DARK, GREY, BLUE, ORANGE, RED, GREEN, SKY, YELLOW = "#4d4d4d", "#a8a8a8", "#0072b2", "#e69f00", "#d55e00", "#009e73", "#56b4e9", "#f0e442"


@dataclass(frozen=True, slots=True)
class Line:
    """x and y of shape (n,); `thick` lies under the others, `dots` are samples, `marks` few and large, `bars` stand on the axis.

    `sd` is of marks, where it is known.
    """

    name: str
    x: FloatArray
    y: FloatArray
    colour: str
    style: Style = "line"
    sd: FloatArray | None = None
    choice: str = ""


@dataclass(frozen=True, slots=True)
class Panel:
    """`bands` are ranges of x that are shaded; `ticks` are names for x = 0, 1, ..."""

    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    title: str = ""
    bands: tuple[tuple[float, float], ...] = ()
    logarithmic: bool = False
    ticks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Chart:
    """Rows of panels. Of lines that belong to a choice, only those of one are shown at a time, first the first; paper shows no other."""

    key: str
    caption: str
    panels: tuple[tuple[Panel, ...], ...]
    choices: tuple[str, ...] = ()


def axis(name: str, unit: str) -> str:
    """The label of an axis."""
    return f"{name.replace('_', ' ').replace('.', ': ')} [{'-' if unit == '1' else unit}]"
