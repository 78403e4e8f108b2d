"""Which starts of an effect are fitted to their end, and what does a shape of the law do to a prediction that is linear in it?"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap.search.recalibration import _linearised
from evat.gap.search.singles import _apart

FAR = 1.1 * CONSTANTS.starts_apart


def test_starts_are_the_best_and_those_that_are_elsewhere() -> None:
    """In one coordinate at least, from all that were chosen before; no more than so many."""
    places = ([0.0, 0.0], [0.5 * FAR, -0.5 * FAR], [0.1, FAR], [0.1, 1.5 * FAR], *([n * FAR, -FAR] for n in range(1, 9)))
    starts: Any = [SimpleNamespace(point=np.array(place)) for place in places]
    chosen = [start.point.tolist() for start in _apart(starts)]
    assert chosen == [places[0], places[2], *places[4:]][: CONSTANTS.starts_of_an_effect]
    assert 1 < len(chosen) < len(places)


class Linear:
    """F = 2 a - 300 b + 7 c over three samples, `a` a shape of the law, `b` a zero of an input, which is one for all lanes."""

    setup_names = ("b",)
    setup = SimpleNamespace(names=("d",))

    def linearise(self, columns: Any) -> Any:
        return columns if columns else self

    def one(self, sets: dict[str, Any], on: Any) -> np.ndarray:
        assert "d" not in sets
        return np.array([1.0, 2.0, 3.0]) * (2 * sets["a"] - 300 * sets["b"] + 7 * sets["c"])

    def many(self, sets: dict[str, Any], on: Any) -> np.ndarray:
        return np.array([self.one({**sets, "a": a, "c": c}, on) for a, c in zip(sets["a"], sets["c"], strict=True)])


def test_a_shape_is_told_by_its_slope_where_it_stands() -> None:
    def form(name: str, sd: float) -> Any:
        return SimpleNamespace(name=name, value=lambda u: 1 + sd * u)

    prediction: Any = Linear()
    forms = [form("a", 0.1), form("b", 0.001), form("c", 1e-3)]
    told: Any = _linearised(prediction, {"a": 9.0, "d": 1.0}, (), forms, np.array([0.3, -0.2, 0.0]))
    assert [(one.parameter.name, one.at) for one in told] == [("a", 0.3), ("b", -0.2), ("c", 0.0)]
    for one, slope in zip(told, (0.2, -0.3, 7e-3), strict=True):
        assert one.column == pytest.approx(slope * np.array([1.0, 2.0, 3.0]), rel=1e-6)
