"""Does the place that a diagnosis gives hold the gap? Its boxes against those of the label, counted over the samples of the case."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow.parquet as pq
from answers import Answer

Flags = npt.NDArray[np.bool_]


@functools.lru_cache(maxsize=8)
def _samples(path: Path) -> dict[str, npt.NDArray[np.float64]]:
    table = pq.read_table(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def inside(box: dict[str, Any], samples: dict[str, npt.NDArray[np.float64]]) -> Flags:
    """Samples in a box. A phase may run over its end: [0.9, 0.1]. A bound on what is not known of the samples is no bound."""
    within = np.ones(next(iter(samples.values())).size, dtype=bool)
    for name, (low, high) in box.items():
        values = samples.get(f"at {name}")
        if values is None:
            continue
        if name == "phase" and low > high:
            within &= (values >= low) | (values <= high)
        else:
            slack = 1e-9 * (abs(low) + abs(high))
            within &= (values >= low - slack) & (values <= high + slack)
    return within


def mask(regions: Any, channels: list[str], samples: dict[str, npt.NDArray[np.float64]]) -> Flags:
    """All samples of all channels that lie in any region of their channel."""
    count = next(iter(samples.values())).size
    covered = np.zeros((len(channels), count), dtype=bool)
    for region in regions:
        if region.get("channel") in channels:
            covered[channels.index(region["channel"])] |= inside(region.get("box") or {}, samples)
    return covered


def _iou(one: Flags, other: Flags) -> float:
    either = int(np.sum(one | other))
    return int(np.sum(one & other)) / either if either else 1.0


def overlap(label: dict[str, Any], answer: Answer, out: Path) -> tuple[float, float]:
    """F1 and IoU of the samples inside; 0 where the diagnosis gives no place. Of the places that a label allows, that nearest counts."""
    samples = _samples(out / "oracle" / f"{label['name']}.parquet")
    told = mask(answer.regions, label["channels"], samples)
    true = np.zeros_like(told)
    for row, channel in enumerate(label["channels"]):
        ways = [mask(regions, [channel], samples)[0] for regions in label["places"].get(channel, [])]
        if ways:
            true[row] = max(ways, key=lambda way: _iou(way, told[row]))
    both, either = int(np.sum(true & told)), int(np.sum(true | told))
    total = int(np.sum(true)) + int(np.sum(told))
    return (2 * both / total if total else 0.0), (both / either if either else 0.0)
