"""How far does the gap shrink where the fit has not looked? Cross-validation over conditions: a third of them left out in turn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.budget import is_visible, squares, structural_share, variance_along
from evat.gap.held_out import folds
from evat.gap.search.audit import zeros
from evat.gap.search.compare import Comparison
from evat.gap.values_alone import ValuesAlone, values_alone
from evat.inference.fit import Fit, fit
from evat.model import BoolArray, FloatArray


@dataclass(frozen=True)
class Closure:
    """`closed_share` of the structural gap by the effects on `held_out_conditions`, each by fits that have not seen it, nan where none
    could be held out, with its 90 % interval, nan where one recording tells none; `rms[channel]`: nominal, recalibrated, corrected and
    noise floor [unit of the channel], there or, where there are none, everywhere; `unit`: what these are in, "N rms" or, where channels
    differ, each with its own; `by_recalibration`: share of the nominal model's gap that recalibration alone closes there, with its
    interval. `closed_share_where_fitted` is, of all conditions, which the fits have seen, what the effects close, or recalibration where
    there are none; nan where some are held out. `unforeseen`: conditions that were held out, too, and tell nothing, since what the models
    do there hangs on values that the others do not tell. `values_alone`: what is left at the conditions of `rms` by values alone, those
    that were fitted to all conditions; `values_with_set_up`: the same with what the set-up is off by put right."""

    closed_share: float
    interval: tuple[float, float]
    held_out_conditions: tuple[str, ...]
    rms: dict[str, dict[str, float]]
    unit: str
    by_recalibration: tuple[float, tuple[float, float]] = (math.nan, (math.nan, math.nan))
    closed_share_where_fitted: tuple[float, tuple[float, float]] = (math.nan, (math.nan, math.nan))
    unforeseen: tuple[str, ...] = ()
    values_alone: ValuesAlone = field(default_factory=ValuesAlone)
    values_with_set_up: ValuesAlone = field(default_factory=ValuesAlone)


class HeldOut:
    """Models fitted without the conditions of a fold, and judged on them, fold by fold; `conditions` are those of all folds, empty where
    there are too few to hold any out."""

    def __init__(self, comparison: Comparison) -> None:
        self.comparison = comparison
        seen = {group.condition for group in comparison.whitening.groups}  # of a slow sensor some conditions may tell nothing
        prediction = comparison.prediction
        counted_from = {variable.name: zeros(prediction, variable.name) for variable in prediction.model.variables if variable.unit == "K"}
        told = tuple(tuple(each for each in fold if each in seen) for fold in folds(prediction.experiment, counted_from))
        self.folds = tuple(filter(None, told)) if len(seen) >= CONSTANTS.fewest_conditions else ()
        self._fold_of = {condition: fold for fold in self.folds for condition in fold}
        self.conditions = tuple(each for each in comparison.prediction.experiment.conditions if each in self._fold_of)
        self._kept: dict[tuple[int, tuple[str, ...]], tuple[Fit, Fit]] = {}  # by what has no hash; held, lest another get its number

    def fitted(self, whole: Fit, condition: str) -> Fit:
        """The same model, fitted without the fold of a condition."""
        fold = self._fold_of.get(condition)
        if fold is None:
            return whole
        if (id(whole), fold) not in self._kept:
            mask = np.array([group.condition in fold for group in self.comparison.whitening.groups])
            self._kept[id(whole), fold] = whole, _again(self.comparison, whole, mask)
        return self._kept[id(whole), fold][1]

    def predicted(self, whole: Fit) -> FloatArray:
        """(N,), each condition by the fit that has not seen it."""
        predicted = whole.predicted.copy()
        for segment in self.comparison.prediction.segments:
            if segment.condition in self._fold_of:
                predicted[segment.at] = self.fitted(whole, segment.condition).predicted[segment.at]
        return predicted

    def foreseen(self, chosen: Fit) -> tuple[str, ...]:
        """Held-out conditions of which the others tell what the models do there: by the covariance of their parameters, predictions are
        surer than what is left. A slow condition without which nothing tells the Stribeck velocity is no test of any model."""
        whitening, wholes = self.comparison.whitening, (self.comparison.recalibrated, chosen)
        left, unsure = dict.fromkeys(self.conditions, 0.0), dict.fromkeys(self.conditions, 0.0)
        for place, group in enumerate(whitening.groups):
            if group.condition not in left:
                continue
            fits = [self.fitted(whole, group.condition) for whole in wholes]
            level = whitening.levels[group.channel] ** 2
            left[group.condition] += float(np.sum(whitening.residual_of_any_start(fits[0].predicted, place) ** 2)) / level
            unsure[group.condition] += max(_unsure(fit, group.at) for fit in fits) / level
        return tuple(condition for condition in left if unsure[condition] < CONSTANTS.foreseen_condition * left[condition])

    def closed(self, chosen: Fit, conditions: Sequence[str], *, away: bool = False) -> tuple[float, tuple[float, float]]:
        """Share of the recalibrated model's gap that the model closes on held-out conditions, and its 90 % interval over recordings; nan
        where there are none, or no gap to speak of. away : from jumps, beside which a clock that is off by a part of a sample leaves
        more than any model closes."""
        if chosen is self.comparison.recalibrated:
            return math.nan, (math.nan, math.nan)
        return self._shrinks(self.predicted(self.comparison.recalibrated), self.predicted(chosen), conditions, away=away)

    def recalibrated(self, conditions: Sequence[str]) -> tuple[float, tuple[float, float]]:
        """The same of the nominal model's gap, by recalibration."""
        return self._shrinks(self.comparison.nominal.predicted, self.predicted(self.comparison.recalibrated), conditions)

    def where_fitted(self, chosen: Fit, *, away: bool = False) -> tuple[float, tuple[float, float]]:
        """What the model closes of all conditions, which its fit has seen: of the recalibrated model's gap, or by it of the nominal one's.
        Its interval over recordings is nan where these are too few to tell one. away : from jumps."""
        comparison = self.comparison
        before = comparison.nominal if chosen is comparison.recalibrated else comparison.recalibrated
        conditions = comparison.prediction.experiment.conditions
        share, interval = self._shrinks(before.predicted, chosen.predicted, conditions, away=away)
        recordings = set(_recordings(comparison, conditions))
        return share, interval if len(recordings) >= CONSTANTS.fewest_recordings else (math.nan, math.nan)

    def _shrinks(
        self, before: FloatArray, after: FloatArray, conditions: Sequence[str], *, away: bool = False
    ) -> tuple[float, tuple[float, float]]:
        rows = _rows(self.comparison, before, after, conditions, away=away)
        if not len(rows):  # no conditions, or a sensor that is too slow for what was held out
            return math.nan, (math.nan, math.nan)
        share = _share(rows.sum(axis=0))
        # Channels of one recording share its motion and its faults: they are drawn together.
        numbers = np.unique(_recordings(self.comparison, conditions), return_inverse=True)[1]
        rows = np.array([rows[numbers == number].sum(axis=0) for number in range(numbers.max() + 1)])
        if math.isnan(share) or len(rows) == 1:  # one recording drawn again and again is an interval of no width
            return share, (math.nan, math.nan)
        draws = np.random.default_rng(CONSTANTS.bootstrap_seed).integers(len(rows), size=(CONSTANTS.bootstrap_draws, len(rows)))
        spread = np.array([_share(rows[draw].sum(axis=0)) for draw in draws])
        low, high = np.nanquantile(spread, [0.05, 0.95]) if np.any(np.isfinite(spread)) else (np.nan, np.nan)
        return share, (float(low), float(high))

    def left(self, chosen: Fit) -> float:
        """Share of the structural gap that the model leaves there; nan where none are held out, no gap can be seen there, or the others do
        not tell what the models do there."""
        before, where = self.predicted(self.comparison.recalibrated), set(self.foreseen(chosen))
        table = squares(self.comparison.whitening, before, where) if where else {}
        if not is_visible(table):
            return math.nan
        return structural_share(self.comparison.whitening, self.predicted(chosen), before, where)

    def worse(self, chosen: Fit) -> dict[str, tuple[float, float]]:
        """Conditions that the model makes worse there, by more than noise and its parameters' spread would if it were true: root mean
        squares before and after, in that of the channel's measured one."""
        if not self.conditions:
            return {}
        worse = {}
        rows, conditions, where = self._rows(chosen), self._conditions(), self.foreseen(chosen)
        for condition in self.conditions:
            before, after, floor, size = rows[[own == condition for own in conditions]].sum(axis=0)
            larger = after > CONSTANTS.worse_condition**2 * before and after - before > 2 * CONSTANTS.noise_floor_error * floor
            if condition in where and larger and self._surprise(chosen, condition, after - before) > CONSTANTS.surprising:
                worse[condition] = math.sqrt(before / size), math.sqrt(after / size)
        return worse

    def _surprise(self, chosen: Fit, condition: str, more: float) -> float:
        """By how many standard deviations more is left with the model than without it, if it were true. more : sum of squares, channels
        by their rms; that of both predictions' difference d is what a true model leaves less, give or take 2 d (noise and what parameters
        are off)."""
        whitening, own = self.comparison.whitening, self.fitted(chosen, condition)
        apart = own.predicted - self.fitted(self.comparison.recalibrated, condition).predicted
        less, variance, along = 0.0, 0.0, np.zeros(own.point.size)
        for place, group in enumerate(whitening.groups):
            if group.condition != condition:
                continue
            level, repeats = whitening.levels[group.channel] ** 2, len(group.members)
            less += repeats * float(np.sum(apart[group.at] ** 2)) / level
            variance += 4 * repeats * variance_along(whitening, place, apart[group.at], own.predicted) / level**2
            along += 2 * repeats * (own.slopes[group.at].T @ apart[group.at]) / level
        sd = math.sqrt(variance + float(along @ own.likelihood.covariance @ along))
        return (more + less) / sd if sd > 0 else 0.0

    def _conditions(self) -> list[str]:
        groups = [group for group in self.comparison.whitening.groups if group.condition in self.conditions]
        return [group.condition for group in groups for _ in group.members]

    def _rows(self, chosen: Fit) -> FloatArray:
        return _rows(self.comparison, self.predicted(self.comparison.recalibrated), self.predicted(chosen), self.conditions)


def close(comparison: Comparison, chosen: Fit, held: HeldOut) -> Closure:
    whitening = comparison.whitening
    foreseen = held.foreseen(chosen)
    before, after = (held.predicted(fit) if foreseen else fit.predicted for fit in (comparison.recalibrated, chosen))
    where = set(foreseen) or None
    tables = {
        "nominal": squares(whitening, comparison.nominal.predicted, where),
        "recalibrated": squares(whitening, before, where),
        "corrected": squares(whitening, after, where),
    }
    rms = {
        channel: {
            **{name: float(np.sqrt(table[channel].left)) for name, table in tables.items()},
            "noise_floor": float(np.sqrt(tables["recalibrated"][channel].floor)),
        }
        for channel in tables["nominal"]
    }
    closed, unit = held.closed(chosen, foreseen), _unit(comparison, rms)
    others = tuple(condition for condition in held.conditions if condition not in foreseen)
    floors = {channel: row["noise_floor"] for channel, row in rms.items()}
    there = foreseen or comparison.prediction.experiment.conditions
    alone, put_right = (values_alone(comparison, chosen, there, floors, set_up) for set_up in (False, True))
    if foreseen:
        shares = held.recalibrated(foreseen)
        return Closure(*closed, foreseen, rms, unit, shares, unforeseen=others, values_alone=alone, values_with_set_up=put_right)
    shares = held.where_fitted(chosen)
    return Closure(
        *closed, foreseen, rms, unit, closed_share_where_fitted=shares, unforeseen=others, values_alone=alone, values_with_set_up=put_right
    )


def _unit(comparison: Comparison, channels: Iterable[str]) -> str:
    """One for all channels, or one for each in their order, in SI."""
    known = {variable.name: variable.unit for variable in comparison.prediction.model.variables}
    units = [known[channel] for channel in channels]
    return f"{', '.join(units if len(set(units)) > 1 else units[:1])} rms"


def _unsure(fit: Fit, at: slice) -> float:
    """Sum of the variances of the prediction's samples by what is not known of the parameters."""
    slopes = fit.slopes[at]
    return float(np.sum((slopes @ fit.likelihood.covariance) * slopes))


def _again(comparison: Comparison, whole: Fit, mask: BoolArray) -> Fit:
    """The same model, fitted without the groups of a mask (groups,)."""
    again = fit(
        comparison.prediction, comparison.whitening, whole.parameters, whole.point, whole.on, fixed=whole.fixed, held_out=mask, most_steps=5
    )
    return again or whole


def _rows(comparison: Comparison, before: FloatArray, after: FloatArray, held: Sequence[str], *, away: bool = False) -> FloatArray:
    """Of each channel of each held-out recording, in the order of `_recordings`: sums of squares before, after and of the noise floor,
    channels by their rms, and how many they are. away : from jumps."""
    whitening, prediction = comparison.whitening, comparison.prediction
    rows = []
    for place, group in enumerate(whitening.groups):
        if group.condition not in held:
            continue
        starts = [whitening.residual(each, place) - whitening.residual_of_any_start(each, place) for each in (before, after)]
        floor = squares(whitening, after, {group.condition})[group.channel].floor
        level = whitening.levels[group.channel] ** 2
        for member in group.members:
            at = prediction.segments[member].at
            measured = prediction.measured[at]
            counted = whitening.jumps[place].weights ** 2 if away else np.ones(measured.size)
            size = float(counted.sum())
            rows.append(
                [
                    float(counted @ (measured - before[at] - starts[0]) ** 2) / level,
                    float(counted @ (measured - after[at] - starts[1]) ** 2) / level,
                    size * floor / level,
                    size,
                ]
            )
    return np.array(rows)


def _recordings(comparison: Comparison, held: Sequence[str]) -> list[int]:
    """Of each channel of each held-out recording, of which that is: the trial, or the row of a table of means, whose numbers follow."""
    prediction = comparison.prediction
    first = {segment.channel: segment.at.start for segment in reversed(prediction.segments) if segment.trial < 0}
    members = [member for group in comparison.whitening.groups if group.condition in held for member in group.members]
    own = [prediction.segments[member] for member in members]
    count = len(prediction.experiment.trials)
    return [segment.trial if segment.trial >= 0 else count + segment.at.start - first[segment.channel] for segment in own]


def _share(sums: FloatArray) -> float:
    before, after, floor, _ = sums
    return float((before - after) / (before - floor)) if before > (1 + CONSTANTS.noise_floor_error) * floor else float("nan")
