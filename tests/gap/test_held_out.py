"""Are conditions that are held out together spread over the design, whatever the order of the files?"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.experiment import Experiment, Means, Nominal
from evat.gap.closure import HeldOut
from evat.gap.held_out import folds
from evat.inference.prediction import Prediction
from evat.model import Variable
from toy import Toy, measured


def table(rows: list[tuple[float, ...]], names: str = "abc") -> Experiment:
    labels = tuple("/".join(map(str, row)) for row in rows)
    values = {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=False)}
    outputs = {"F": np.array([sum(row) for row in rows])}
    return Experiment(Path(), "table", "", Nominal({}, (), {}), {}, (), Means("m.csv", labels, values, outputs, {}), "hash of no file")


@pytest.mark.parametrize("shape", [(3, 3), (4, 3), (3, 3, 3), (2, 3, 3), (4, 3, 2)])
def test_no_level_of_a_full_factorial_is_held_out_whole(shape: tuple[int, ...]) -> None:
    """Every third row of such a table is every row of one width. Of each level about a third is held out, and of none all."""
    rows = list(product(*([0.1 * (1 + level) for level in range(count)] for count in shape)))
    for held in folds(table(rows)):
        for factor, count in enumerate(shape):
            own = Counter(condition.split("/")[factor] for condition in held)
            assert max(own.values()) <= -(-len(held) // count) + 1
            assert max(own.values()) - min(own.get(str(0.1 * (1 + level)), 0) for level in range(count)) <= 2


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_files_and_their_names_have_no_say(seed: int) -> None:
    def together(experiment: Experiment) -> set[frozenset[str]]:
        return {frozenset(fold) for fold in folds(experiment)}

    made, draw = measured(conditions=7, repeats=2), np.random.default_rng(seed)
    order = draw.permutation(len(made.trials))
    names = {condition: f"{name}" for condition, name in zip(made.conditions, draw.permutation(100), strict=False)}
    trials = tuple(replace(made.trials[place], file=f"{place}.csv", condition=names[made.trials[place].condition]) for place in order)
    assert together(replace(made, trials=trials)) == {frozenset(names[condition] for condition in fold) for fold in folds(made)}
    rows = list(product((0.1, 0.2, 0.3), (1.0, 2.0), (5.0, 6.0)))
    shuffled = [rows[place] for place in draw.permutation(len(rows))]
    assert together(table(shuffled)) == together(table(rows))


@pytest.mark.parametrize("count", range(3, 13))
def test_each_condition_is_held_out_once_and_both_ends_never_together(count: int) -> None:
    made = folds(table([(float(level),) for level in range(count)]))
    assert sorted(condition for fold in made for condition in fold) == sorted(str(float(level)) for level in range(count))
    assert max(map(len, made)) - min(map(len, made)) <= 1
    assert not any({"0.0", f"{count - 1.0}"} <= set(fold) for fold in made)


def test_of_two_conditions_none_is_held_out() -> None:
    assert folds(table([(1.0,), (2.0,)])) == ()


def test_conditions_that_are_set_alike_are_held_out_too() -> None:
    """Where nothing that varies was recorded or stated."""
    made = folds(table([(1.0,), *((1.0 + 1e-9 * level,) for level in range(1, 4))]))
    assert sorted(map(len, made)) == [1, 1, 2]


@pytest.mark.parametrize("speeds", [(0.1, 0.2), (0.1, 0.2, 0.3)])
def test_no_temperature_is_held_out_whole_where_all_are_near_each_other_beside_0_kelvin(speeds: tuple[float, ...]) -> None:
    """Each of 292, 293 and 294 K was, at all speeds."""
    for held in folds(table(list(product(speeds, (292.0, 293.0, 294.0)))), {"b": [293.15]}):
        assert len({condition.split("/")[1] for condition in held}) == len(held)


def test_temperatures_of_a_model_are_counted_from_those_that_it_states() -> None:
    """In a diagnosis, too: with two speeds both of one temperature were held out together."""
    made, draw, trials = measured(conditions=6, repeats=1), np.random.default_rng(1), []
    warm = Variable("y", "K", 293.15, 0.0, 5000.0, "temperature", "toy", causality="input")
    for place, trial in enumerate(made.trials):
        x = (0.3, 0.6)[place // 3] * np.sin(2 * np.pi * 0.5 * trial.times)
        force = 10 * x + 0.1 * draw.normal(size=x.size)
        trials.append(replace(trial, inputs={"x": x, "y": np.full(x.size, 292.0 + place % 3)}, outputs={"F": force}))
    prediction = Prediction(type("Warm", (Toy,), {"variables": (*Toy.variables, warm)})(), replace(made, trials=tuple(trials)))
    groups = [SimpleNamespace(condition=condition) for condition in made.conditions]
    comparison: Any = SimpleNamespace(prediction=prediction, whitening=SimpleNamespace(groups=groups))
    for held in HeldOut(comparison).folds:
        assert len({int(condition[1:]) % 3 for condition in held}) == 2
