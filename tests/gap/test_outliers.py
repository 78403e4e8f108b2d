"""Is a sample that lies far from its repeats taken from the others, and nothing else, in whatever unit?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.inference.whitening import _without_outliers

LUCK = np.random.default_rng(3)
TRUE = 5 + np.sin(np.linspace(0, 20, 400))


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_far_sample_is_taken_from_the_others(count: int, unit: float) -> None:
    """40 sd off in one repeat: within a few sd of the truth afterwards, the other samples as they were, the repeats' own levels kept."""
    rows = TRUE + 0.01 * LUCK.normal(size=(count, TRUE.size)) + 0.3 * np.arange(count)[:, None]
    spoilt = rows.copy()
    spoilt[1, 77] += 0.4
    cleaned = _without_outliers(unit * spoilt, unit * TRUE) / unit
    assert cleaned[1, 77] == pytest.approx(rows[1, 77], abs=0.06)
    changed = np.abs(cleaned - spoilt) > 1e-9
    assert changed[1, 77]
    assert not changed[:, np.arange(TRUE.size) != 77].any()
