"""What does a vibrating tool cut, if every earlier pass over a place is looked up? Slow, without the kernel's formulas or choices.

Lengths in amplitudes along the cut, angles psi = w t: x = r psi + sin(psi), y = -aspect cos(psi + lead). The surface at a place is the
lower of the nominal one and the lowest height at which the tool has ever stood there before it last began to move into the material (the
stroke that cuts now is no earlier pass, and with a rake it may turn back while it still cuts).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, ceil, cos, pi, sin

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Ellipse:
    r: float  # speed ratio, below 1
    aspect: float = 1.0  # amplitude_y over amplitude_x
    lead: float = 0.0  # [rad], 0 upright; beyond a quarter turn the tool runs through it backward
    rake: float = 0.0  # [rad]
    feed: float = 1.0  # nominal surface over the lowest point

    def x(self, psi: Array) -> Array:
        return self.r * psi + np.sin(psi)

    def y(self, psi: Array) -> Array:
        return -self.aspect * np.cos(psi + self.lead)

    def approach(self, psi: Array) -> Array:
        """Velocity into the material, normal to the rake face."""
        return (self.r + np.cos(psi)) * cos(self.rake) + self.aspect * np.sin(psi + self.lead) * sin(self.rake)

    def stroke_begins(self) -> float:
        """An angle at which the tool begins to move into the material; nan: it never does, or always does."""
        grid = np.linspace(0, 2 * pi, 20001)
        into = self.approach(grid) > 0
        places = np.flatnonzero(~into[:-1] & into[1:])
        if places.size != 1:
            return float("nan")
        return float(bisect(lambda s: self.approach(s), grid[places], grid[places + 1])[0])

    def surface(self, psi: Array) -> Array:
        """Height of what stands at the place of each psi."""
        begins = self.stroke_begins()
        return self.left(self.x(psi), begins + 2 * pi * np.floor((psi - begins) / (2 * pi)))

    def left(self, place: Array, begun: Array) -> Array:
        """Height of what stands at each place, of all passes until the angle begun."""
        last = acos(-self.r)
        lowest = np.full(place.shape, self.feed - self.aspect)
        if not place.size:
            return lowest
        cycles = [int(np.floor(each / (2 * pi))) for each in (begun.min(), begun.max())]
        first = ceil((np.ptp(place) + 2 * pi * self.r + 4) / (2 * pi * self.r)) + 2  # so many cycles ago the tool was nowhere near
        for n in range(cycles[0] - first, cycles[1] + 3):
            for low, high in ((-last + 2 * pi * n, last + 2 * pi * n), (last + 2 * pi * n, 2 * pi - last + 2 * pi * n)):
                ends = np.sort(self.x(np.array([low, high])))
                there = np.flatnonzero((place >= ends[0]) & (place <= ends[1]) & (low < begun))
                if not there.size:
                    continue
                way = 1.0 if self.x(np.array([high]))[0] > self.x(np.array([low]))[0] else -1.0
                at = place[there]
                passed = bisect(lambda s, at=at, way=way: way * (self.x(s) - at), np.full(there.size, low), np.full(there.size, high))
                # a stroke that is over counts whole: near its ends the place says little of the angle
                before = (passed <= begun[there]) | (high <= begun[there] + 1e-9)
                lowest[there[before]] = np.minimum(lowest[there[before]], self.y(passed[before]))
        return lowest

    def thickness(self, psi: Array) -> Array:
        """Uncut thickness, 0 out of contact."""
        deep = self.surface(psi) - self.y(psi)
        return np.where((self.approach(psi) > 0) & (deep > 0), deep, 0.0)

    def flank_depth(self, clearance: float) -> float:
        """How deep a straight face that rises behind the tip by the clearance angle stands in what the tip has left, at most.

        The best of a grid of angles and places behind, then of ever finer ones around it.
        """
        rise, best = np.tan(clearance), 0.0
        psi = np.linspace(0, 2 * pi, 121)
        places = np.linspace(self.x(psi).min() - 2 * pi * self.r, self.x(psi).max(), 181)
        for _ in range(7):
            at, place = (grid.ravel() for grid in np.meshgrid(psi, places, indexing="ij"))
            behind = self.x(at) - place
            at, place, behind = at[behind >= 0], place[behind >= 0], behind[behind >= 0]
            deep = self.left(place, at + 1e-7) - self.y(at) - rise * behind
            n = int(np.argmax(deep))
            best = max(best, float(deep[n]))
            psi = at[n] + (psi[1] - psi[0]) * np.linspace(-1.2, 1.2, 13)
            places = place[n] + (places[1] - places[0]) * np.linspace(-1.2, 1.2, 13)
        return best

    def turns(self, start: float, count: int = 1200) -> list[float]:
        """Angles within a cycle from start at which contact begins or ends; those closer than 1e-7 to each other are of rounding, where the
        tool turns and its place says no more than half the digits of its height."""
        last = acos(-self.r)
        marks = [start + (angle - start) % (2 * pi) + side for angle in (last, -last, self.stroke_begins()) for side in (-1e-9, 1e-9)]
        edges = np.sort(np.concatenate([np.linspace(start, start + 2 * pi, count + 1), marks]))
        cuts = self.thickness(edges) > 0
        places = np.flatnonzero(cuts[:-1] != cuts[1:])
        low, high = edges[places], edges[places + 1]
        side = cuts[places]
        for _ in range(48):
            middle = (low + high) / 2
            same = (self.thickness(middle) > 0) == side
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        angles: list[float] = []
        for angle in high:
            if angles and angle - angles[-1] < 1e-7:
                angles.pop()
            else:
                angles.append(float(angle))
        return angles


def bisect(f, low: Array, high: Array) -> Array:
    """Where f, below 0 at low, has risen above it, to rounding."""
    for _ in range(56):
        middle = (low + high) / 2
        below = f(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return (low + high) / 2


def draw(number: int, *, retrograde: bool, raked: bool) -> Ellipse:
    """One of many ellipses that cut."""
    seed = np.random.default_rng([number, retrograde, raked])
    while True:
        lead = seed.uniform(0.5 * pi, 1.5 * pi) if retrograde else seed.uniform(-0.5 * pi, 0.5 * pi)
        ellipse = Ellipse(
            r=seed.uniform(0.08, 0.95),
            aspect=10 ** seed.uniform(-0.5, 0.5),
            lead=lead if lead <= pi else lead - 2 * pi,
            rake=seed.uniform(-0.4, 0.4) if raked else 0.0,
            feed=10 ** seed.uniform(-1, 1),
        )
        if not np.isnan(ellipse.stroke_begins()) and ellipse.turns(0.1, 200):
            return ellipse
