"""Which conditions are held out of a fit together? Thirds, each spread over the space of what was set and recorded, whatever the order of
the files.

Every third row of a table is every row of one width where that has three levels; so folds draw in turn, each a condition of whose levels
it has the least, rather within the space than one more at its edge, and as far as can be from those it has (maximin designs: Johnson, Moore
and Ylvisaker 1990).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Trial
from evat.model import FloatArray, IntArray


def folds(experiment: Experiment, zeros: Mapping[str, Sequence[float]] | None = None) -> tuple[tuple[str, ...], ...]:
    """Each condition is in one; in the order of the experiment; none where there are too few.

    zeros : what the size of an input is counted from, where that is not 0: between 293 and 295 K nothing would vary.
    """
    conditions = experiment.conditions
    if len(conditions) < CONSTANTS.fewest_conditions:
        return ()
    (names, inputs), (_, outputs) = (_table(experiment, conditions, of_outputs) for of_outputs in (False, True))
    order = sorted(range(len(conditions)), key=lambda place: (*inputs[place], *outputs[place], conditions[place]))
    drawn = _drawn(_levels(inputs[order], [(zeros or {}).get(name, [0.0]) for name in names]), CONSTANTS.folds)
    return tuple(tuple(conditions[place] for place in sorted(order[row] for row in fold)) for fold in drawn)


def _drawn(levels: IntArray, count: int) -> list[list[int]]:
    """The rows of a design (conditions, factors) in `count` folds."""
    highest = levels.max(axis=0, initial=0)
    at = levels / np.maximum(highest, 1)
    at_edge = np.sum((levels == 0) | (levels == highest), axis=1)
    usual = [np.bincount(column) for column in levels.T]
    free, folds = list(range(len(levels))), [list[int]() for _ in range(count)]

    def rank(fold: list[int], place: int) -> tuple[float, ...]:
        shares = [
            (np.count_nonzero(levels[fold, factor] == level) + 1) / usual[factor][level] for factor, level in enumerate(levels[place])
        ]
        apart = min((float(np.sum((at[place] - at[other]) ** 2)) for other in fold), default=np.inf)
        edges = float(np.sum(at_edge[fold]) + at_edge[place])
        return round(max(shares, default=0.0), 9), round(sum(shares), 9), edges, -round(apart, 9), place

    for turn in range(len(levels)):
        fold = folds[turn % count]
        fold.append(min(free, key=lambda place: rank(fold, place)))
        free.remove(fold[-1])
    return folds


def _levels(table: FloatArray, zeros: Sequence[Sequence[float]]) -> IntArray:
    """Of each column that varies the number of its level, (conditions, factors); of columns that go together the first alone."""
    columns = dict[bytes, IntArray]()
    for column, counted_from in zip(table.T, zeros, strict=True):
        order, span = np.argsort(column, kind="stable"), float(np.ptp(column))
        if not span > CONSTANTS.same_level * max(float(np.max(np.abs(column - zero))) for zero in counted_from):
            continue
        level = np.empty(column.size, dtype=np.intp)
        level[order] = np.concatenate([[0], np.cumsum(np.diff(column[order]) > CONSTANTS.same_level * span)])
        if (level.max() - level).tobytes() not in columns:  # the same, counted from the other end
            columns.setdefault(level.tobytes(), level)
    return np.array(list(columns.values()), dtype=np.intp).reshape(len(columns), len(table)).T


def _table(experiment: Experiment, conditions: tuple[str, ...], of_outputs: bool) -> tuple[list[str], FloatArray]:
    """Of each condition what was set and the size, pace and way of what was recorded, (conditions, columns), means over its repeats; 0
    where it has none."""
    rows: list[dict[str, list[float]]] = [{} for _ in conditions]
    for trial in experiment.trials:
        own = rows[conditions.index(trial.condition)]
        for name, number in _described(trial, of_outputs).items():
            own.setdefault(name, []).append(number)
    if (means := experiment.means) is not None:
        for name, column in (means.outputs if of_outputs else means.values).items():
            for condition, number in zip(means.conditions, column, strict=True):
                rows[conditions.index(condition)].setdefault(name, []).append(float(number))
    names = sorted({name for own in rows for name in own})
    table = np.array([[np.mean(sorted(own.get(name, [0.0]))) for name in names] for own in rows]).reshape(len(rows), len(names))
    return names, table


def _described(trial: Trial, of_outputs: bool) -> dict[str, float]:
    numbers = {} if of_outputs else {name: float(value) for name, value in trial.values.items()}
    for name, column in (trial.outputs if of_outputs else trial.inputs).items():
        rms, pace = float(np.sqrt(np.mean(column**2))), np.diff(column) / np.diff(trial.times)
        way = float(np.round(column.mean() / rms)) if rms > 0 else 0.0  # one or the other, or to and fro
        numbers |= {f"{name}": rms, f"{name}, pace": float(np.std(pace)), f"{name}, way": way}
    return numbers
