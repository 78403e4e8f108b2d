"""Is a gap found where it was put, also across the end of a cycle?"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from evat.gap.where import locate, within
from evat.prediction import Prediction
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
    found_low, found_high = region.box["phase"]
    wide = (high - low) % 1.0 or 1.0
    assert (found_low - low) % 1.0 < 0.2 * wide + 0.05 or (low - found_low) % 1.0 < 0.03
    assert (high - found_high) % 1.0 < 0.2 * wide + 0.05 or (found_high - high) % 1.0 < 0.03
    assert 0.75 < region.share < 1.0 + 1e-9


def test_a_range_of_a_signal_does_not_run_over_its_end() -> None:
    prediction = Prediction(Turning(), measured())
    x = np.concatenate([prediction.experiment.trials[s.trial].inputs["x"] for s in prediction.segments])
    low, high = 0.5 * x.max(), 0.8 * x.max()
    (region,) = locate(prediction, ((x > low) & (x < high)).astype(float)).regions
    bounds = region.box["x"]
    assert low - 0.05 < bounds[0] < bounds[1] < high + 0.05
