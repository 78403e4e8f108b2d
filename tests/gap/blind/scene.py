"""What does the benchmark's contact go through in one condition? Motion, thickness, temperature and load, on a fine grid, whatever the law.

Row k of an array is the step that ends at grid time k; its two columns are the nodes of that step (radau.NODES), so column 1 is the grid.
Row 0 is the start: a step of no width.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from radau import NODES, Array

Signal = Callable[[Array], Array]
Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Scene:
    """One condition. `every`: fine steps between two samples; `values`: what the condition is run at, by the component's names."""

    times: Array  # of the samples
    every: int
    width: Array  # (steps,)
    t: Array  # (steps, 2), as all below
    v: Array
    h: Array
    theta: Array
    load: Array
    u_y: Array
    approach: Array
    on: Flags  # in contact
    fresh: Flags  # (steps,): contact begins within this step
    values: Mapping[str, float] = field(default_factory=dict)
    signals: Mapping[str, Signal] = field(default_factory=dict)

    @property
    def grid(self) -> Array:
        """Times of the fine grid."""
        return self.t[:, 1]

    @property
    def fine(self) -> float:
        """Spacing of the fine grid [s]."""
        return float(self.times[1] - self.times[0]) / self.every

    def sampled(self, on_grid: Array) -> Array:
        """Values on the fine grid at the samples."""
        return np.asarray(on_grid[:: self.every])

    @property
    def distance(self) -> Array:
        """Slid so far [m], at the nodes: trapezoids of |v| in contact."""
        speed = np.abs(self.v[:, 1]) * self.on[:, 1]
        done = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * self.fine)])
        before = np.concatenate([[0.0], done[:-1]])
        return np.stack([before + NODES[0] * (done - before), done], axis=1)


def fine_grid(times: Array, every: int) -> Array:
    """`every` steps between two samples."""
    count = (times.size - 1) * every
    return np.asarray(times[0] + (times[-1] - times[0]) * np.arange(count + 1) / count)


def nodes(grid: Array, entered: Array | None = None) -> tuple[Array, Array]:
    """Widths and node times of the steps; where `entered` (a time, nan for none) is given, the step begins there."""
    start = np.concatenate([grid[:1], grid[:-1]])
    if entered is not None:
        start = np.where(np.isnan(entered), start, entered)
    width = grid - start
    return width, np.stack([start + NODES[0] * width, grid], axis=1)


def entries(grid: Array, contact: Signal) -> tuple[Array, Flags]:
    """Where contact (a signal, above 0 in contact) begins within a step: the time, by bisection, else nan; and contact on the grid."""
    on = contact(grid) > 0
    begins = np.concatenate([[False], on[1:] & ~on[:-1]])
    at = np.full(grid.size, np.nan)
    low, high = grid[np.flatnonzero(begins) - 1], grid[begins]
    for _ in range(40 if begins.any() else 0):
        middle = (low + high) / 2
        inside = contact(middle) > 0
        low, high = np.where(inside, low, middle), np.where(inside, middle, high)
    at[begins] = high
    return at, on


def given(times: Array, every: int, signals: Mapping[str, Signal], values: Mapping[str, float], theta: Signal | None) -> Scene:
    """A scene whose motion is given: slip_velocity, and where there is a chip uncut_thickness; normal_load where it is measured.

    theta: the temperature proxy as a speed; None: the slip speed itself.
    """
    grid = fine_grid(times, every)
    chip = signals.get("uncut_thickness")
    at, on = entries(grid, chip) if chip else (np.full(grid.size, np.nan), np.ones(grid.size, dtype=bool))
    width, t = nodes(grid, at)
    flat = t.ravel()

    def seen(signal: Signal | None, otherwise: float) -> Array:
        return signal(flat).reshape(t.shape) if signal else np.full(t.shape, otherwise)

    v = seen(signals["slip_velocity"], 0.0)
    zero = np.zeros(t.shape)
    return Scene(
        times=times, every=every, width=width, t=t, v=v, h=seen(chip, 1e-4), theta=seen(theta, 0.0) if theta else np.abs(v),
        load=seen(signals.get("normal_load"), 10.0), u_y=zero, approach=zero, on=np.stack([on, on], axis=1), fresh=~np.isnan(at),
        values=dict(values), signals=dict(signals),
    )  # fmt: skip
