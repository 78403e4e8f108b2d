"""How sure is a score? Wilson's interval for shares, the bootstrap for the rest, at 90 %."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

LEVEL = 0.9
DRAWS = 1000


@dataclass(frozen=True)
class Figure:
    """A score with its interval, and how many cases stand behind it; value None where there are none."""

    value: float | None
    low: float | None
    high: float | None
    count: int

    def as_json(self) -> dict[str, float | int | None]:
        return {"value": self.value, "low": self.low, "high": self.high, "count": self.count}

    @staticmethod
    def text(figure: dict[str, Any]) -> str:
        if figure["value"] is None:
            return f"- ({figure['count']})"
        return f"{figure['value']:.3g} [{figure['low']:.2f}, {figure['high']:.2f}] ({figure['count']})"


NOTHING = Figure(None, None, None, 0)


def share_of(right: Sequence[bool]) -> Figure:
    """Wilson 1927."""
    n = len(right)
    if n == 0:
        return NOTHING
    p, z = sum(map(bool, right)) / n, float(stats.norm.ppf(0.5 + LEVEL / 2))
    middle, half = (p + z * z / (2 * n)) / (1 + z * z / n), z / (1 + z * z / n) * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return Figure(p, max(float(middle - half), 0.0), min(float(middle + half), 1.0), n)


def _bootstrap(count: int, of: Callable[[Any], float], strata: Sequence[int] | None = None) -> tuple[float, float]:
    """Interval of a statistic of `count` cases, given as places; with strata each is drawn by itself."""
    rng = np.random.default_rng(0)
    groups = [np.flatnonzero(np.asarray(strata) == s) for s in sorted(set(strata))] if strata is not None else [np.arange(count)]
    resampled = [of(np.concatenate([rng.choice(group, group.size) for group in groups])) for _ in range(DRAWS)]
    low, high = np.quantile(resampled, [0.5 - LEVEL / 2, 0.5 + LEVEL / 2])
    return float(low), float(high)


def mean_of(values: Sequence[float], *, middle: bool = False, quantile: float | None = None) -> Figure:
    """Mean, median or another quantile."""
    if not values:
        return NOTHING
    x = np.asarray(values, dtype=float)

    def of(places: Any) -> float:
        if quantile is not None or middle:
            return float(np.quantile(x[places], 0.5 if quantile is None else quantile))
        return float(np.mean(x[places]))

    low, high = _bootstrap(x.size, of)
    return Figure(of(np.arange(x.size)), low, high, x.size)


def area_under_curve(positive: Sequence[float], negative: Sequence[float]) -> Figure:
    """Share of pairs in which the positive has the higher score, ties half: Mann and Whitney 1947."""
    if not positive or not negative:
        return NOTHING
    scores = np.asarray([*positive, *negative], dtype=float)
    label = np.array([1] * len(positive) + [0] * len(negative))

    def of(places: Any) -> float:
        ranks, known = stats.rankdata(scores[places]), label[places]
        p = int(np.sum(known))
        return float((np.sum(ranks[known == 1]) - p * (p + 1) / 2) / (p * (known.size - p)))

    low, high = _bootstrap(scores.size, of, label.tolist())
    return Figure(of(np.arange(scores.size)), low, high, scores.size)


def calibration_error(confidence: Sequence[float], right: Sequence[bool], bins: int = 10) -> Figure:
    """Mean distance of confidence and share of right ones, over bins of equal width, by their number: Naeini et al. 2015."""
    if not confidence:
        return NOTHING
    p, y = np.asarray(confidence, dtype=float), np.asarray(right, dtype=float)
    place = np.minimum((p * bins).astype(int), bins - 1)

    def of(places: Any) -> float:
        k = place[places]
        miss = np.bincount(k, (p - y)[places], minlength=bins)
        return float(np.sum(np.abs(miss)) / k.size)

    low, high = _bootstrap(p.size, of)
    return Figure(of(np.arange(p.size)), low, high, p.size)
