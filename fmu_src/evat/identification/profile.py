"""How far can one parameter go until the data object, all others following it? The profile of the loss, and the interval that it gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from evat.identification.covariance import Optimum
from evat.identification.objective import Objective
from evat.identification.polish import descend, losses
from evat.model import FloatArray

LEVEL = 0.90
NEAR = 0.05  # of the root of the threshold: how exactly an end of the interval is hit
MOST = 12  # points of a side
PROBES, ELSEWHERE, DESCENTS = (
    96,
    0.3,
    3,
)  # points tried beyond an end; share of a point that is not as at the optimum; descents from the best
VALLEYS, FIRST = 3, 0.02  # how often an interval is widened by another valley; the first step there, of the unit interval
BETTER = 0.1  # a profile point that is this much (in units of one sd squared) below the optimum shows that it was none


@dataclass(frozen=True, eq=False)
class Profile:
    """u : points in the unit interval, rising; rise : how much worse the best fit there is, in units of one sd squared.

    `low` and `high` are the ends of the interval in u; an end that is open lies on the bound: the data do not object there.
    """

    u: FloatArray
    rise: FloatArray
    threshold: float
    low: float
    high: float
    open_below: bool
    open_above: bool
    valleys: bool  # whether it holds a second valley, apart from that of the optimum


class BetterPoint(Exception):
    """A profile went through a point that is better than the optimum: the search has to go on from there."""

    def __init__(self, point: FloatArray) -> None:
        super().__init__()
        self.point = point


def threshold(optimum: Optimum, place: int) -> float:
    """Rise at the ends of a parameter's interval: Fisher's F, since its variance is estimated, too, from so many degrees of freedom."""
    return float(f_distribution.ppf(LEVEL, 1, float(optimum.degrees[place])))


def profile(objective: Objective, optimum: Optimum, place: int, strict: bool = True) -> Profile:
    """The profile of one parameter; strict : raises BetterPoint where the optimum turns out to be none."""
    limit = threshold(optimum, place)
    sides = [_side(objective, optimum, place, way, limit, strict) for way in (-1.0, 1.0)]
    points = sorted([*sides[0][0], (float(optimum.point[place]), 0.0), *sides[1][0]])
    u, rise = (np.array(column) for column in zip(*points, strict=True))
    return Profile(u, rise, limit, sides[0][1], sides[1][1], sides[0][2], sides[1][2], sides[0][3] or sides[1][3])


def _side(
    objective: Objective, optimum: Optimum, place: int, way: float, limit: float, strict: bool
) -> tuple[list[tuple[float, float]], float, bool, bool]:
    """Points (u, rise), the end of the interval, whether it is open, and whether another valley was found beyond the end; what that holds
    is part of the interval."""
    sd = float(np.sqrt(optimum.covariance[place, place]))
    points, end, is_open = _walk(objective, optimum, place, way, limit, strict, optimum.point, 0.0, sd)
    valleys = False
    for again in range(VALLEYS):
        beyond = None if is_open else _beyond(objective, optimum, place, way, limit, strict, end, again)
        if beyond is None:
            break
        point, rise = beyond
        valleys = True
        points.append((float(point[place]), rise))
        more, end, is_open = _walk(objective, optimum, place, way, limit, strict, point, float(np.sqrt(max(rise, 0.0))), FIRST)
        points += more
    return points, end, is_open, valleys


def _walk(
    objective: Objective,
    optimum: Optimum,
    place: int,
    way: float,
    limit: float,
    strict: bool,
    begin: FloatArray,
    begin_root: float,
    sd: float,
) -> tuple[list[tuple[float, float]], float, bool]:
    """From a point of the profile outward to where the rise passes the limit, or to the bound."""
    centre, bound, root = float(begin[place]), 0.0 if way < 0 else 1.0, float(np.sqrt(limit))
    points = list[tuple[float, float]]()
    if abs(bound - centre) < 1e-6:
        return points, bound, True
    inner, inner_root, outer, outer_root = centre, begin_root, bound, np.inf
    at, warm = centre + way * root * sd, begin
    for _ in range(MOST):
        at = bound if (bound - at) * way <= 0 else at
        rise, warm = _rise(objective, optimum, place, at, warm, strict)
        points.append((at, rise))
        rise_root = float(np.sqrt(max(rise, 0.0)))
        if abs(rise_root - root) < NEAR * root:
            return points, at, False
        if rise_root < root:
            if at == bound:
                return points, bound, True
            inner, inner_root = at, rise_root
        else:
            outer, outer_root = at, rise_root
        if np.isfinite(outer_root):  # between two points: as a straight line, but well inside
            share = (root - inner_root) / (outer_root - inner_root)
            at = inner + min(max(share, 0.1), 0.9) * (outer - inner)
        else:  # beyond all points: at most four times as far
            at = centre + (at - centre) * min(max(root / max(rise_root, 1e-3), 1.3), 4.0)
    end = inner + (root - inner_root) / (outer_root - inner_root) * (outer - inner) if np.isfinite(outer_root) else inner
    return points, float(end), False


def _beyond(
    objective: Objective, optimum: Optimum, place: int, way: float, limit: float, strict: bool, end: float, again: int
) -> tuple[FloatArray, float] | None:
    """A point beyond the end of the interval to which the data do not object either, and its rise; None where none was found.

    A descent stays in its valley, so many points are tried: some of the other parameters as at the optimum, some anywhere. From the best
    ones the others go down first, then all: a valley may be narrower than the points are apart.
    """
    bound, rng = 0.0 if way < 0 else 1.0, np.random.default_rng([place, int(way > 0), again])
    probes = np.where(rng.random((PROBES, optimum.point.size)) < ELSEWHERE, rng.random((PROBES, optimum.point.size)), optimum.point)
    probes[:, place] = end + (bound - end) * rng.uniform(0.05, 1.0, PROBES)
    free = np.ones(optimum.point.size, dtype=bool)
    free[place] = False
    best: tuple[FloatArray, float] | None = None
    for start in probes[np.argsort(losses(objective, optimum.loss, probes))[:DESCENTS]]:
        point, loss, _ = descend(objective, optimum.loss, start, free, most=12, exact=1e-4)
        rise = _scaled(optimum, place, loss)
        if rise >= limit:
            point, loss, _ = descend(objective, optimum.loss, point, np.ones_like(free), most=12, exact=1e-4)
            rise = _scaled(optimum, place, loss) if (point[place] - end) * way > 0 else np.inf
        if strict and rise < -BETTER:
            raise BetterPoint(point)
        if rise < limit and (best is None or (point[place] - best[0][place]) * way > 0):
            best = point, rise
    return best


def _scaled(optimum: Optimum, place: int, loss: float) -> float:
    return 2 * (loss - optimum.least) / (optimum.unit * float(optimum.stretch[place]))


def _rise(objective: Objective, optimum: Optimum, place: int, at: float, warm: FloatArray, strict: bool) -> tuple[float, FloatArray]:
    """How much worse the best fit with the parameter held at `at` is; from where the covariance says, and from the neighbouring point."""
    free = np.ones(optimum.point.size, dtype=bool)
    free[place] = False
    along = optimum.covariance[:, place] / optimum.covariance[place, place]
    guesses = [optimum.point + along * (at - optimum.point[place]), warm]
    starts = [np.clip(guess, 0.0, 1.0) for guess in guesses]
    for start in starts:
        start[place] = at
    if np.allclose(starts[0], starts[1]):
        starts = starts[:1]
    costs = losses(objective, optimum.loss, np.array(starts))
    point, loss, _ = descend(objective, optimum.loss, starts[int(np.argmin(costs))], free, most=12, exact=1e-5)
    rise = _scaled(optimum, place, loss)
    if strict and rise < -BETTER:
        raise BetterPoint(point)
    return rise, point
