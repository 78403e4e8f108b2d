"""What do the numbers of a motion and a force tell? Which way friction points, how large it is, and which motions are alike."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping

import numpy as np

from evat.model import FloatArray

ALIKE = 0.02  # relative: recordings whose motions differ by less repeat each other
ALIKE_BESIDE = 0.05  # relative: what is set by hand or by a control loop comes back less exactly
MOVING = 0.05  # of the highest speed: below it friction is not read off

Rows = Mapping[str, FloatArray]  # of one recording, by column (n,)


def speed(rows: Rows, motion: str, is_position: bool) -> FloatArray:
    """The slip velocity in units of its column (over a sample, of a position); its size does not matter here."""
    column = rows[motion]
    return np.gradient(column) if is_position and column.size > 1 else column


def sliding(recordings: Iterable[Rows], motion: str, is_position: bool, force: str) -> tuple[FloatArray, FloatArray]:
    """Slip velocity and force in units of their columns, over all recordings, where the contact moves."""
    speeds, forces = [], []
    for rows in recordings:
        own = speed(rows, motion, is_position)
        moving = np.abs(own) > MOVING * np.max(np.abs(own), initial=0.0)
        speeds.append(own[moving])
        forces.append(rows[force][moving])
    return np.concatenate(speeds), np.concatenate(forces)


def with_direction(recordings: Iterable[Rows], motion: str, is_position: bool, force: str) -> float:
    """Correlation of the force with the direction of motion, over all recordings."""
    speeds, column = sliding(recordings, motion, is_position, force)
    direction = np.sign(speeds)
    if direction.size < 3 or not np.ptp(direction) or not np.ptp(column) > 0:
        return float(np.sign(np.mean(direction * column))) if direction.size else math.nan
    return float(np.corrcoef(direction, column)[0, 1])


def repeating(
    recordings: Mapping[str, Rows], motion: str, is_position: bool, beside: Collection[str], conditions: Mapping[str, str]
) -> dict[str, str]:
    """The condition of each file, where recordings as long as each other, whose motions are as large, repeat each other. beside : columns
    of what else a test is made at, such as the normal load, whose medians are alike, too."""
    groups: list[tuple[tuple[float, int, list[float]], str]] = []
    alike = {}
    for file, rows in recordings.items():
        own = speed(rows, motion, is_position)
        size, count = float(np.sqrt(np.mean(own**2))) if own.size else 0.0, own.size
        levels = [float(np.median(rows[each])) if rows[each].size else 0.0 for each in beside]
        for (other, samples, theirs), condition in groups:
            same_test = all(_is_close(one, two, ALIKE_BESIDE) for one, two in zip(levels, theirs, strict=True))
            if _is_close(size, other, ALIKE) and _is_close(count, samples, ALIKE) and same_test:
                alike[file] = condition
                break
        else:
            groups.append(((size, count, levels), conditions[file]))
            alike[file] = conditions[file]
    return alike


def _is_close(one: float, other: float, share: float) -> bool:
    return abs(one - other) <= share * max(abs(one), abs(other))
