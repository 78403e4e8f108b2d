"""Which point of the cube is best? A genetic algorithm (pymoo) or differential evolution (scipy), a generation in one call of the model.

pymoo, because its algorithms are asked for members and told their costs, and hold their random numbers in themselves; pygad, lighter by
ten small packages, seeds the global generators of Python and numpy, so that two searches in one process disturb each other.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from evat.identification.objective import FAILED
from evat.identification.searching.journal import Journal
from evat.model import FloatArray, ParameterError

Search = Literal["ga", "de", "none"]
Costs = Callable[[FloatArray], FloatArray]
MOST_MEMBERS = 100_000  # of a generation
PATIENCE = 25  # generations without GAIN before a search ends
GAIN = 1e-4  # of the best cost
APART = 0.2  # of the unit interval, in at least one parameter: points in different valleys, perhaps
OTHERS = 8  # of such points, from which a polish can start; measured: it then ends in the best valley from all seeds that were tried


class Stop(Exception):
    """The search has to end here: on request, or since nothing more is gained."""


@dataclass(frozen=True, slots=True)
class Generation:
    """What a generation has come to: the best cost so far and the median of the new members."""

    evaluations: int
    best: float
    median: float


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The best point of a search, others that are far from it and good for their surroundings, and how they were found."""

    point: FloatArray
    cost: float
    others: tuple[FloatArray, ...]
    history: tuple[Generation, ...]
    stopped: bool
    seconds: float


class _Book:
    """Evaluates generation after generation, keeps the best, ends the search."""

    def __init__(
        self,
        costs: Costs,
        generations: int,
        journal: Journal | None,
        progress: Callable[[int, int, float], None] | None,
        cancelled: Callable[[], bool] | None,
    ) -> None:
        self._costs, self._most, self._journal, self._progress, self._cancelled = costs, generations, journal, progress, cancelled
        self.history: list[Generation] = []
        self.point, self.cost, self.stopped = np.empty(0), float("inf"), False
        self._last_gain, self._gain_from = 0, float("inf")
        self._good: list[tuple[float, FloatArray]] = []

    def others(self) -> tuple[FloatArray, ...]:
        """The best points apart from the best one and from each other."""
        return tuple(point for _, point in self._good[1:])

    def __call__(self, points: FloatArray) -> FloatArray:
        if self._cancelled is not None and self._cancelled():
            self.stopped = True
            raise Stop
        costs = self._journal.recall(points) if self._journal is not None else None
        if costs is None:
            costs = self._costs(points)
            if self._journal is not None:
                self._journal.keep(points, costs)
        place = int(np.argmin(costs))
        if costs[place] < self.cost:
            self.point, self.cost = points[place].copy(), float(costs[place])
        rows = [(float(cost), point.copy()) for cost, point in zip(costs, points, strict=True)]
        self._good = _apart(sorted([*self._good, *rows], key=lambda one: one[0]))
        done = (self.history[-1].evaluations if self.history else 0) + len(points)
        self.history.append(Generation(done, self.cost, float(np.median(costs))))
        if self._progress is not None:
            self._progress(len(self.history), self._most, self.cost)
        if self.cost < (1 - GAIN) * self._gain_from:
            self._gain_from, self._last_gain = self.cost, len(self.history)
        if len(self.history) >= self._most or len(self.history) - self._last_gain >= PATIENCE:
            raise Stop
        return costs


def _apart(rows: list[tuple[float, FloatArray]]) -> list[tuple[float, FloatArray]]:
    """The best of rows that are sorted, each apart from those before it."""
    apart = list[tuple[float, FloatArray]]()
    for cost, point in rows:
        if len(apart) > OTHERS:
            break
        if cost < FAILED and all(np.max(np.abs(point - one)) > APART for _, one in apart):
            apart.append((cost, point))
    return apart


def check_size(population: int, generations: int, seed: int) -> None:
    """ParameterError where no search is of that size: asked before any work."""
    if not 5 <= population <= MOST_MEMBERS or generations < 1 or seed < 0:
        raise ParameterError(
            f"population {population}, generations {generations}, seed {seed}: allowed are a population of 5 to {MOST_MEMBERS}, 1 or "
            "more generations, and a seed of 0 or more."
        )


def search(
    kind: Search,
    costs: Costs,
    start: FloatArray,
    *,
    population: int,
    generations: int,
    seed: int,
    journal: Journal | None = None,
    progress: Callable[[int, int, float], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> SearchResult:
    """The best of the unit cube; `start` is a member of the first generation.

    costs : (K, p) -> (K,); progress : told the generation, how many there are at most, and the best cost.
    """
    if kind not in get_args(Search):
        raise ParameterError(f"search {kind!r}: allowed are {', '.join(get_args(Search))}.")
    check_size(population, generations, seed)
    begin, book = time.perf_counter(), _Book(costs, 1 if kind == "none" else generations, journal, progress, cancelled)
    first = qmc.LatinHypercube(start.size, rng=np.random.default_rng(seed)).random(population)
    first[0] = start
    try:
        if kind == "none":
            book(start[None, :])
        elif kind == "ga":
            _genetic(book, first, seed)
        else:
            _differential(book, first, seed)
    except Stop:
        pass
    if book.point.size == 0 or book.cost >= FAILED:
        if book.stopped:
            raise ParameterError("the search was stopped before its first generation; there is nothing to show.")
        raise ParameterError("the model fails for every value set that was tried; check the nominal values and the bounds.")
    return SearchResult(book.point, book.cost, book.others(), tuple(book.history), book.stopped, time.perf_counter() - begin)


def _genetic(book: _Book, first: FloatArray, seed: int) -> None:
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    problem = Problem(n_var=first.shape[1], n_obj=1, xl=0.0, xu=1.0)
    algorithm = GA(pop_size=len(first), sampling=first, eliminate_duplicates=True)
    algorithm.setup(problem, seed=seed, verbose=False, termination=("n_gen", 10**9))
    while True:
        members = algorithm.ask()
        if members is None or len(members) == 0:
            return  # no new members: the population has come down to one point
        costs = book(members.get("X").astype(np.float64))
        algorithm.evaluator.eval(StaticProblem(problem, F=costs[:, None]), members)
        algorithm.tell(infills=members)


def _differential(book: _Book, first: FloatArray, seed: int) -> None:
    differential_evolution(
        lambda points: book(np.ascontiguousarray(points.T)),
        [(0.0, 1.0)] * first.shape[1],
        init=first,
        maxiter=10**9,
        rng=np.random.default_rng(seed),
        polish=False,
        strategy="rand1bin",  # slower than the default, which runs into the first good valley
        updating="deferred",
        vectorized=True,
        tol=1e-3,
    )
