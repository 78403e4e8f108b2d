"""Is a gap found where it was put, also across the end of a cycle?"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from evat.gap.location import locate
from evat.gap.smallest_region import smallest_place, within
from evat.inference.prediction import Prediction
from toy import Toy, measured

PERIOD = 0.37  # s


class Turning(Toy):
    """A toy that says that it has a cycle."""

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        return PERIOD


@pytest.mark.parametrize(("low", "high"), [(0.2, 0.5), (0.85, 0.15), (0.0, 0.3), (0.7, 1.0)])
def test_a_gap_is_found_between_two_phases(low: float, high: float) -> None:
    """A box holds four fifths of the squares, so it may lie a fifth of the range inside; a bin is a fortieth of the cycle."""
    prediction = Prediction(Turning(), measured())
    gap = np.zeros(prediction.measured.size)
    for segment in prediction.segments:
        times = prediction.experiment.trials[segment.trial].times
        gap[segment.at] = within(np.mod(times / PERIOD, 1.0), (low, high))
    (region,) = locate(prediction, gap).regions
    assert list(region.box) == ["phase"]
    start, end = region.box["phase"]
    wide = (high - low) % 1.0 or 1.0
    assert (start - low) % 1.0 < 0.2 * wide + 0.05 or (low - start) % 1.0 < 0.03
    assert (high - end) % 1.0 < 0.2 * wide + 0.05 or (end - high) % 1.0 < 0.03
    assert 0.75 < region.share < 1.0 + 1e-9


def test_a_range_of_a_signal_does_not_run_over_its_end() -> None:
    prediction = Prediction(Turning(), measured())
    x = np.concatenate([prediction.experiment.trials[s.trial].inputs["x"] for s in prediction.segments])
    low, high = 0.5 * x.max(), 0.8 * x.max()
    (region,) = locate(prediction, ((x > low) & (x < high)).astype(float)).regions
    bounds = region.box["x"]
    assert low - 0.05 < bounds[0] < bounds[1] < high + 0.05


def test_two_ranges_are_told_apart() -> None:
    """What happens at both reversals of a cycle lies in two ranges, of which one runs over the end."""
    phase, speed = (np.arange(4000) + 0.5) / 4000, np.cos(np.linspace(0, 9, 4000))
    lies = within(phase, (0.9, 0.1)) | within(phase, (0.45, 0.6))
    regions = smallest_place(lies + 0.01, {"phase": phase, "speed": speed}, "phase")
    assert sum(share for _, share in regions) == pytest.approx(0.8, abs=0.06)
    (first, _), (second, _) = sorted(regions, key=lambda place: place[0]["phase"])
    for box, wide in ((first, (0.44, 0.61)), (second, (0.89, 0.11))):
        assert list(box) == ["phase"]
        assert all(within(np.array(box["phase"]), wide))


def test_a_corner_of_two_quantities_is_found() -> None:
    draw = np.random.default_rng(4)
    speed, load, time = draw.uniform(0, 3, 5000), draw.uniform(-1, 1, 5000), np.arange(5000.0)
    ((box, share),) = smallest_place(((speed > 2) & (load < 0)) * 1.0, {"speed": speed, "load": load, "time": time})
    assert set(box) == {"speed", "load"}
    assert share > 0.79
    assert box["speed"][0] == pytest.approx(2, abs=0.3)
    assert box["load"][1] == pytest.approx(0, abs=0.3)


def test_what_lies_all_over_has_no_place() -> None:
    draw = np.random.default_rng(4)
    assert smallest_place(draw.uniform(0.9, 1.1, 500), {"speed": draw.uniform(0, 3, 500)}) == [({}, 1.0)]


@pytest.mark.parametrize("turns", [False, True])
def test_no_other_place_of_that_kind_is_smaller(turns: bool) -> None:
    """Against every range and every two ranges over few bins."""
    draw = np.random.default_rng(5)
    values = np.arange(12) / 12 + 1 / 24
    for _ in range(20):
        energy = draw.uniform(0, 1, 12) ** 4
        regions = smallest_place(energy, {"it": values}, "it" if turns else "")
        held, cost = (_in(regions, values) @ energy) / energy.sum(), _in(regions, values).sum() / (0.75 if len(regions) > 1 else 1)
        least = _least(energy, turns)
        assert held >= 0.8 - 1e-9
        assert cost <= least + 1e-9 if regions[0][0] else least > 0.72 * energy.size


def _in(regions: list[tuple[dict[str, tuple[float, float]], float]], values: np.ndarray) -> np.ndarray:
    inside = np.zeros(values.size, dtype=bool)
    for box, _ in regions:
        inside |= within(values, box["it"]) if box else True
    return inside


def _least(energy: np.ndarray, turns: bool) -> float:
    """The least cost of one window; those of two are more than a quarter smaller or do not count."""
    size, best = energy.size, float(energy.size)
    for begin in range(size):
        for length in range(1, size + 1):
            if turns or begin + length <= size:
                rows = np.arange(begin, begin + length) % size
                if energy[rows].sum() >= 0.8 * energy.sum():
                    best = min(best, float(length))
    return best
