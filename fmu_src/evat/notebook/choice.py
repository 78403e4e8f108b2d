"""Which of many signals are shown? Those that change, of each component in turn; what is left out is told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MOST_SHOWN = 12
NAMED = 6  # of what was left out


def chosen(columns: Mapping[str, FloatArray], most: int = MOST_SHOWN) -> list[str]:
    """Names of the columns to show where there are more than `most`: those that change, of each component in turn; then the others."""
    if len(columns) <= most:
        return list(columns)
    groups: dict[tuple[bool, str], list[str]] = {}
    for name, column in columns.items():
        finite = column[np.isfinite(column)]
        still = finite.size == 0 or float(np.ptp(finite)) <= 1e-9 * float(np.abs(finite).max())
        groups.setdefault((still, name.rpartition(".")[0]), []).append(name)
    ranked = []
    for still in (False, True):
        rows = [names for (each, _), names in groups.items() if each is still]
        ranked += [names[place] for place in range(max(map(len, rows), default=0)) for names in rows if place < len(names)]
    kept = set(ranked[:most])
    return [name for name in columns if name in kept]


def left_out(columns: Mapping[str, Any], names: Sequence[str], how: str = "drawn") -> str:
    """What is not shown where `names` are, in one line; empty where it shows all."""
    rest = [name for name in columns if name not in names]
    if not rest:
        return ""
    more = f" and {len(rest) - NAMED} more" if len(rest) > NAMED else ""
    return f"{len(rest)} of {len(columns)} are not {how}: {', '.join(rest[:NAMED])}{more}"
