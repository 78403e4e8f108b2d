"""How far does the gap shrink where no fit has looked? Both models fitted to some conditions, both run on the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evat.gap.budget import squares
from evat.gap.compare import Comparison
from evat.inference.fit import Fit, fit
from evat.model import BoolArray, FloatArray

FEWEST = 3  # conditions, below which none can be held out
DRAWS = 1000
SEED = 20240229


@dataclass(frozen=True)
class Closure:
    """`share` of the structural gap that the effects close on `held_out` conditions, nan where none could be held out, with its 90 %
    interval; `rms[channel]`: nominal, recalibrated, corrected and noise floor [unit of the channel], there or, where there are none,
    everywhere."""

    share: float
    interval: tuple[float, float]
    held_out: tuple[str, ...]
    rms: dict[str, dict[str, float]]


def held_out_conditions(conditions: Sequence[str]) -> tuple[str, ...]:
    """Every third, neither the first nor the last where that can be."""
    return tuple(conditions[1::3]) if len(conditions) >= FEWEST else ()


def close(comparison: Comparison, chosen: Fit) -> Closure:
    whitening, prediction = comparison.whitening, comparison.prediction
    held = held_out_conditions(prediction.experiment.conditions)
    before, after = comparison.recalibrated, chosen
    if held:
        mask = np.array([group.condition in held for group in whitening.groups])
        before = _again(comparison, before, mask)
        after = _again(comparison, after, mask) if chosen is not comparison.recalibrated else before
    where = set(held) if held else None
    tables = {
        "nominal": squares(whitening, comparison.nominal.predicted, where),
        "recalibrated": squares(whitening, before.predicted, where),
        "corrected": squares(whitening, after.predicted, where),
    }
    rms = {
        channel: {
            **{name: float(np.sqrt(table[channel].left)) for name, table in tables.items()},
            "noise_floor": float(np.sqrt(tables["recalibrated"][channel].floor)),
        }
        for channel in tables["nominal"]
    }
    if not held or chosen is comparison.recalibrated:
        return Closure(float("nan"), (float("nan"), float("nan")), held, rms)
    rows = _rows(comparison, before.predicted, after.predicted, held)
    share = _share(rows.sum(axis=0))
    draws = np.random.default_rng(SEED).integers(len(rows), size=(DRAWS, len(rows)))
    spread = np.array([_share(rows[draw].sum(axis=0)) for draw in draws])
    low, high = np.nanquantile(spread, [0.05, 0.95]) if np.any(np.isfinite(spread)) else (np.nan, np.nan)
    return Closure(share, (float(low), float(high)), held, rms)


def _again(comparison: Comparison, found: Fit, mask: BoolArray) -> Fit:
    """The same model, fitted without the held-out conditions."""
    again = fit(
        comparison.prediction, comparison.whitening, found.parameters, found.point, found.on, fixed=found.fixed, held_out=mask, most_steps=5
    )
    return again or found


def _rows(comparison: Comparison, before: FloatArray, after: FloatArray, held: Sequence[str]) -> FloatArray:
    """Of each held-out recording: sums of squares before, after and of the noise floor, channels by their noise."""
    whitening, prediction = comparison.whitening, comparison.prediction
    found = []
    for group in whitening.groups:
        if group.condition not in held:
            continue
        floor = squares(whitening, after, {group.condition})[group.channel].floor
        level = whitening.levels[group.channel] ** 2
        for member in group.members:
            measured = prediction.measured[prediction.segments[member].at]
            size = measured.size
            found.append(
                [
                    float(np.sum((measured - before[group.at]) ** 2)) / level,
                    float(np.sum((measured - after[group.at]) ** 2)) / level,
                    size * floor / level,
                ]
            )
    return np.array(found)


def _share(sums: FloatArray) -> float:
    before, after, floor = sums
    return float((before - after) / (before - floor)) if before > floor else float("nan")
