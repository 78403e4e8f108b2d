"""Do the dampers of the tool's structure act on what moves against each other, and as strongly as their ratios say?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.native.machine import Machine

RIGID = {f"slide_{name}_{along}": value for along in "xy" for name, value in (("mass", 1e5), ("stiffness", 1e12))}


@pytest.mark.parametrize("along", ["x", "y"])
def test_holder_and_slide_that_move_together_have_no_damper_between_them(along: str) -> None:
    together = {f"velocity_{along}": 0.3, f"slide_velocity_{along}": 0.3, "slide_damping_ratio": 0.0}
    one = Machine("tool_structure", together)
    one.evaluate()
    assert one.get(f"acceleration_{along}") == one.get(f"slide_acceleration_{along}") == one.get("power_lost") == 0
    one = Machine("tool_structure", {**together, f"slide_velocity_{along}": -0.3})
    one.evaluate()
    assert one.get(f"acceleration_{along}") < 0 < one.get(f"slide_acceleration_{along}")
    assert one.get("power_lost") > 0


@pytest.mark.parametrize("along", ["x", "y"])
def test_a_holder_on_a_rigid_slide_dies_away_as_its_damping_ratio_says(along: str) -> None:
    """By exp(-2 pi zeta/sqrt(1 - zeta^2)) a period; the slide gives way by a ten-thousandth of the holder."""
    zeta = 0.1
    one = Machine("tool_structure", {**RIGID, "holder_damping_ratio": zeta, f"displacement_{along}": 1e-5})
    omega = np.sqrt(one.get(f"holder_stiffness_{along}") / one.get("holder_mass"))
    one.start()
    one.advance(2 * np.pi / (omega * np.sqrt(1 - zeta**2)))
    assert one.get(f"displacement_{along}") == pytest.approx(1e-5 * np.exp(-2 * np.pi * zeta / np.sqrt(1 - zeta**2)), rel=2e-3)
