"""Does a search ask for what it is told to, end when nothing more is gained, and bring the best points that are apart?

Costs are formulas here, so that what is best is known.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from evat.identification.objective import FAILED
from evat.identification.searching.search import APART, GAIN, OTHERS, PATIENCE, Search, check_size, search
from evat.model import FloatArray, ParameterError

KINDS: tuple[Search, ...] = ("ga", "de")
START = np.array([0.9, 0.2])


class Asked:
    """Costs that keep what they were asked for; `of` knows the points and how many generations were before."""

    def __init__(self, of: object = None) -> None:
        self.points: list[FloatArray] = []
        self.costs: list[FloatArray] = []
        self._of = of or (lambda points, before: np.sum((points - 0.3) ** 2, axis=1))

    def __call__(self, points: FloatArray) -> FloatArray:
        self.costs.append(self._of(points, len(self.points)))  # type: ignore[operator]
        self.points.append(points.copy())
        return self.costs[-1]


def test_no_search_looks_at_the_start_alone() -> None:
    asked = Asked()
    told = []
    one = search("none", asked, START, population=20, generations=30, seed=1, progress=lambda *row: told.append(row))
    assert [points.tolist() for points in asked.points] == [[START.tolist()]]
    assert one.point.tolist() == START.tolist()
    assert told == [(1, 1, one.cost)]
    assert one.others == ()


@pytest.mark.parametrize("kind", KINDS)
def test_a_search_begins_at_the_start_and_tells_what_each_generation_came_to(kind: Search) -> None:
    asked = Asked()
    told = []
    one = search(kind, asked, START, population=20, generations=12, seed=1, progress=lambda *row: told.append(row))
    assert asked.points[0][0].tolist() == START.tolist()
    assert len(asked.points[0]) == 20
    assert all(np.all((points >= 0) & (points <= 1)) for points in asked.points)
    assert len(one.history) == len(asked.points) == 12
    assert [row.evaluations for row in one.history] == np.cumsum([len(points) for points in asked.points]).tolist()
    assert [row.median for row in one.history] == [np.median(costs) for costs in asked.costs]
    best = np.minimum.accumulate([costs.min() for costs in asked.costs]).tolist()
    assert [row.best for row in one.history] == best
    assert told == [(n + 1, 12, cost) for n, cost in enumerate(best)]
    every, costs = np.concatenate(asked.points), np.concatenate(asked.costs)
    assert one.point.tolist() == every[np.argmin(costs)].tolist()
    assert one.cost == best[-1] < 0.1 * costs[0]
    assert not one.stopped


def test_the_two_searches_are_two_and_a_seed_tells_their_course() -> None:
    asked = {}
    for name, kind, seed in (("ga", "ga", 1), ("de", "de", 1), ("again", "ga", 1), ("other", "ga", 2)):
        asked[name] = Asked()
        search(kind, asked[name], START, population=20, generations=3, seed=seed)  # type: ignore[arg-type]
    assert asked["ga"].points[0] == pytest.approx(asked["de"].points[0], abs=1e-12)
    assert not np.allclose(asked["ga"].points[1], asked["de"].points[1], atol=1e-3)
    assert all(np.array_equal(*pair) for pair in zip(asked["ga"].points, asked["again"].points, strict=True))
    assert not np.array_equal(asked["ga"].points[0], asked["other"].points[0])


@pytest.mark.parametrize(("gain", "generations"), [(0.0, 1 + PATIENCE), (0.9 * GAIN / PATIENCE, 1 + PATIENCE), (1.2 * GAIN / PATIENCE, 70)])
def test_a_search_ends_where_its_patience_gains_nothing(gain: float, generations: int) -> None:
    """The best cost falls by the same share in each generation: by less than what counts over all of the patience, or by more."""
    asked = Asked(lambda points, before: np.full(len(points), (1 - gain) ** before))
    one = search("ga", asked, START, population=8, generations=70, seed=1)
    assert len(one.history) == len(asked.points) == generations


def test_other_points_are_apart_and_the_best_of_their_surroundings() -> None:
    """The first of them is the best of all that are apart from the optimum, and so on; what the model failed for is none."""

    def of(points: FloatArray, _: int) -> FloatArray:
        return np.where(points[:, 0] > 0.8, FAILED, 1 + np.cos(12 * points[:, 0]) * np.cos(9 * points[:, 1]))

    asked = Asked(of)
    one = search("de", asked, np.array([0.5, 0.5]), population=60, generations=1, seed=3)
    (points,), (costs,) = asked.points, asked.costs
    kept: list[FloatArray] = []
    for place in np.argsort(costs):
        if costs[place] < FAILED and all(np.abs(points[place] - other).max() > APART for other in kept) and len(kept) <= OTHERS:
            kept.append(points[place])
    assert len(kept) == 1 + OTHERS
    assert [point.tolist() for point in (one.point, *one.others)] == [point.tolist() for point in kept]
    later = search("de", Asked(of), np.array([0.5, 0.5]), population=60, generations=9, seed=3)
    best = np.array([later.point, *later.others])
    assert min(np.abs(a - b).max() for a, b in combinations(best, 2)) > APART
    assert np.all(np.diff(of(best, 0)) >= 0)
    assert of(best, 0)[0] == later.cost


def test_a_search_that_finds_nothing_says_why() -> None:
    failing = Asked(lambda points, _: np.full(len(points), FAILED))
    with pytest.raises(ParameterError, match="the model fails for every value set"):
        search("ga", failing, START, population=8, generations=2, seed=1)
    with pytest.raises(ParameterError, match="stopped before its first generation"):
        search("ga", Asked(), START, population=8, generations=2, seed=1, cancelled=lambda: True)
    with pytest.raises(ParameterError, match="search 'best': allowed are ga, de, none"):
        search("best", Asked(), START, population=8, generations=2, seed=1)  # type: ignore[arg-type]


def test_the_size_of_a_search_has_bounds() -> None:
    for population, generations, seed in ((5, 1, 0), (100_000, 1, 0)):
        check_size(population, generations, seed)
    for population, generations, seed in ((4, 1, 0), (100_001, 1, 0), (5, 0, 0), (5, 1, -1)):
        with pytest.raises(ParameterError, match=f"population {population}, generations {generations}, seed {seed}: allowed"):
            check_size(population, generations, seed)
