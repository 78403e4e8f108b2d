"""Is an amplitude probed to where it does what is plausible, whatever the last bit of a response says?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap.search.screen import _spreads_of


@pytest.mark.parametrize("slope", [0.02, 0.727, 3.1, 40.0])
@pytest.mark.parametrize("rounding", [-1e-12, 0.0, 1e-12])
def test_a_linear_response_is_met_but_for_rounding(slope: float, rounding: float) -> None:
    spreads = _spreads_of(lambda tried, rows: slope * tried * (1 + rounding * tried), 1e-4, 1e6, 1)
    assert spreads == pytest.approx([CONSTANTS.plausible_effect / slope], rel=1e-6)


def test_what_never_shows_has_no_amplitude() -> None:
    assert np.isnan(_spreads_of(lambda tried, rows: 0 * tried, 1e-4, 1e6, 3)).all()
