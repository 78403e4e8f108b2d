"""When does vibration turning become conventional turning? Thrust only when the friction no longer reverses, far above a speed ratio of 1.

The chip flows along the rake at u_x tan(phi) - u_y. At and above HSR = 1 the tool never leaves the chip, yet friction reverses while
u_y > u_x tan(phi), that is for arccos(HSR/HSR_0)/pi of the cycle, HSR_0 = sqrt(1 + (b/(a tan(phi)))^2): Coulomb's mean is exact.
"""

from __future__ import annotations

import numpy as np
import pytest
from evat.models.simulate import simulate

A, OMEGA, F_C = 5e-6, 2 * np.pi * 20e3, 9.0


def mean_thrust(ratio: float, b: float, phi: float) -> float:
    """Mean feed force over that of conventional turning, F_C."""
    values = {"friction_law": "coulomb", "F_C": F_C, "cutting_speed": ratio * A * OMEGA}
    path = {"amplitude_x": A, "amplitude_y": b, "chip_flow_shear_angle": phi}
    return float(simulate({**values, **path}, (), cycles=4)["mean_feed_force"][-1]) / F_C


@pytest.mark.parametrize("b", [5e-6, 2e-6])
@pytest.mark.parametrize("degrees", [20, 30, 40])
@pytest.mark.parametrize("ratio", [1.0, 1.3, 1.9])
def test_the_thrust_is_that_of_the_share_in_which_the_chip_flows_out(ratio: float, degrees: int, b: float) -> None:
    phi = np.radians(degrees)
    last = np.hypot(1, b / (A * np.tan(phi)))
    assert mean_thrust(ratio, b, phi) == pytest.approx(1 - 2 * np.arccos(min(1.0, ratio / last)) / np.pi, abs=1e-6)


def test_a_round_ellipse_at_a_ratio_of_one_has_a_third_of_the_thrust() -> None:
    """phi/(pi/2), and no reversal from HSR = 1/sin(phi) on."""
    assert mean_thrust(1.0, A, np.pi / 6) == pytest.approx(1 / 3, abs=1e-6)
    assert mean_thrust(1.99, A, np.pi / 6) < 0.98
    assert mean_thrust(2.01, A, np.pi / 6) == pytest.approx(1, abs=1e-6)


def test_without_thrust_vibration_a_ratio_of_one_is_conventional_turning() -> None:
    """The other limit: along the cut alone nothing drags the chip outwards, and thrust rises to the conventional one with the duty."""
    thrusts = [mean_thrust(ratio, 1e-9, np.pi / 6) for ratio in (0.5, 0.9, 0.999, 1.001)]
    assert np.all(np.diff(thrusts) > 0)
    assert thrusts[0] < 0.8
    assert thrusts[2:] == pytest.approx([1, 1], abs=0.04)


def test_friction_that_grows_with_speed_is_conventional_as_soon_as_the_tool_stays_in() -> None:
    """The mean of sigma2 v is sigma2 times the mean slip, and the thrust vibration has none: what reverses cancels (copper, Inconel)."""
    viscous = {"F_C": 1e-6, "F_S": 1e-6, "sigma0": 1e6, "sigma1": 0.0, "sigma2": 10.0}
    path = {"amplitude_x": A, "amplitude_y": A, "chip_flow_shear_angle": np.pi / 6}
    for ratio, bounds in ((0.5, (0.4, 0.9)), (1.001, (1 - 1e-4, 1 + 1e-4)), (1.5, (1 - 1e-4, 1 + 1e-4))):
        speed = ratio * A * OMEGA
        mean = simulate({**viscous, **path, "friction_law": "lugre", "cutting_speed": speed}, (), cycles=4)["mean_feed_force"][-1]
        assert bounds[0] < mean / (10.0 * speed * np.tan(np.pi / 6)) < bounds[1]
