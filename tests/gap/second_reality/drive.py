"""What does a contact go through? The true motion of all trials on one fine grid: a row for each instant, a column (lane) for each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Channels = dict[str, Array]


@dataclass(frozen=True)
class Drive:
    """The sample k of lane i is row first + every k, k < count[i]; the rows before are what the record does not show.

    t: time of the record; theta: temperature proxy as a speed; thickness, approach, u_y: of a cut; held: share of the step that ends at a
    row during which there is contact.
    """

    h: float
    t: Array
    v: Array
    x: Array
    first: int
    every: int
    count: npt.NDArray[np.int64]
    theta: Array | None = None
    load: Array | None = None
    thickness: Array | None = None
    approach: Array | None = None
    u_y: Array | None = None
    held: Array | None = None
    values: tuple[Mapping[str, float], ...] = ()
    path: tuple[Any, ...] = field(default=())

    @property
    def lanes(self) -> int:
        return int(self.v.shape[1])

    def tiled(self, times: int) -> Drive:
        """The same lanes several times over, beside each other."""
        if times == 1:
            return self

        def wide(a: Array | None) -> Array | None:
            return None if a is None else np.tile(a, (1, times))

        names = ("t", "v", "x", "theta", "load", "thickness", "approach", "u_y", "held")
        return replace(
            self, count=np.tile(self.count, times), values=self.values * times, path=self.path * times,
            **{name: wide(getattr(self, name)) for name in names},
        )  # fmt: skip

    def lane(self, places: list[int]) -> Drive:
        """Some of the lanes."""
        names = ("t", "v", "x", "theta", "load", "thickness", "approach", "u_y", "held")
        picked = {name: None if getattr(self, name) is None else getattr(self, name)[:, places] for name in names}
        return replace(
            self, count=self.count[places], values=tuple(self.values[p] for p in places) if self.values else (),
            path=tuple(self.path[p] for p in places) if self.path else (), **picked,
        )  # fmt: skip

    def sampled(self, fine: Array, lane: int) -> Array:
        """One lane's values at its samples."""
        return self.picked(fine[:, lane], lane)

    def picked(self, column: Array, lane: int) -> Array:
        """A column of the fine grid at the samples of a lane."""
        return np.asarray(column[self.first :: self.every][: self.count[lane]])

    @property
    def distance(self) -> Array:
        """Slid so far within the record [m]."""
        speed = np.abs(self.v) if self.held is None else np.abs(self.v) * (self.held > 0)
        grown = np.cumsum(speed, axis=0) * self.h
        return np.maximum(grown - grown[self.first], 0.0)

    @property
    def since(self) -> Array:
        """Time since the record began [s], never below 0."""
        return np.maximum(self.t - self.t[self.first], 0.0)


def shifted(fine: Array, steps: Array | float, *, drift: float = 0.0, first: int = 0) -> Array:
    """fine(t - steps h), each lane by its own number of steps, which need not be whole; the ends are held. drift: by which share the clock
    gets later from the row `first` on."""
    rows, out = np.arange(fine.shape[0], dtype=float), np.empty_like(fine)
    for lane, late in enumerate(np.broadcast_to(steps, fine.shape[1])):
        out[:, lane] = np.interp(rows - late - drift * np.maximum(rows - first, 0.0), rows, fine[:, lane])
    return out


def relaxed(target: Array, rate: Array | float, h: float, start: Array | None = None) -> Array:
    """y of dy/dt = rate (target - y), from the first target or `start`; exact where rate is constant and target straight within a step."""
    a = np.broadcast_to(np.asarray(rate, dtype=float) * h, target.shape)
    decay = np.exp(-a)
    mean = np.where(a > 1e-8, -np.expm1(-a) / np.maximum(a, 1e-300), 1 - a / 2)
    y, pulled = np.empty_like(target), np.empty_like(target)
    y[0] = target[0] if start is None else start
    pulled[1:] = (1 - mean[1:]) * target[1:] + (mean[1:] - decay[1:]) * target[:-1]
    for k in range(1, target.shape[0]):
        y[k] = decay[k] * y[k - 1] + pulled[k]
    return y
