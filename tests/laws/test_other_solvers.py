"""Do other solvers find what the kernel's own integrator finds? Radau on its derivatives and events, and on equations written anew."""

from __future__ import annotations

from math import atan2, pi, tan

import numpy as np
import pytest
from driving import AMPLITUDE, ELLIPSE, OMEGA, PERIOD, at_speed_ratio, read, started
from exchange import exchange
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


@pytest.mark.parametrize(
    ("law", "values"),
    [
        ("lugre", {"sigma1": 0.0}),
        ("lugre", {"sigma1": 20.0, "rake_angle": 0.1, "shear_angle_principle": "minimum_energy"}),
        ("dahl", {"release_time": 1e-5}),
        ("coulomb", {}),
        ("reset_integrator", {"sigma0": 1e7}),
        ("bristle", {"sigma0": 1e7}),
    ],
)
def test_model_exchange_and_the_kernels_own_steps_agree(law: str, values: dict[str, float | str]) -> None:
    """Two and a half cycles, with every entry, exit, reversal, jump of the thickness and event of the law."""
    given = {**at_speed_ratio(0.3, feed=1e-4), "friction_law": law, "relative_tolerance": 1e-10, **values}
    own, host = started(given), started(given)
    own.advance(2.5 * PERIOD)
    exchange(host, 2.5 * PERIOD, rtol=1e-9)
    names = ("friction_impulse", "principal_impulse", "feed_impulse", "normal_impulse", "contact_time", "dissipated_energy")
    assert read(host, *names) == pytest.approx(read(own, *names), rel=2e-6)
    means = ("mean_friction_force", "mean_principal_force", "mean_feed_force", "mean_normal_force", "mean_contact_ratio")
    assert read(host, *means) == pytest.approx(read(own, *means), rel=2e-6)
    assert host.get("bristle_deflection") == pytest.approx(own.get("bristle_deflection"), rel=1e-5, abs=1e-13)


def test_model_exchange_and_the_kernels_own_steps_agree_for_karnopp() -> None:
    """Sticking within the band while the slip reverses, at the ends of the band an event."""
    given = {**at_speed_ratio(0.3, feed=1e-4), "friction_law": "karnopp", "relative_tolerance": 1e-10, "applied_force": 4.0}
    given["karnopp.zero_velocity_band"] = 0.05
    own, host = started(given), started(given)
    own.advance(2.5 * PERIOD)
    exchange(host, 2.5 * PERIOD, rtol=1e-9)
    assert read(host, "friction_impulse", "dissipated_energy") == pytest.approx(
        read(own, "friction_impulse", "dissipated_energy"), rel=2e-6
    )


@pytest.mark.parametrize("sigma2", [0.0, 1.0])
def test_the_shear_angle_that_goes_with_its_own_friction(sigma2: float) -> None:
    """chip_flow_angle = current_shear_angle: v = V(phi(F(v, z))) is solved with the bristle. Here by Brent's rule under Radau, at a
    continuous cut with reversals, zero rake, maximum shear stress: tan(beta) = F/(2 k + F), phi = pi/4 - beta."""
    r, b, feed, load = 1.5, 2 * AMPLITUDE, 1e-4, 4e5  # load: N of shear for each m of thickness
    P, F_C, F_S, v_s = 1e6, 9.0, 10.0, 1e-2

    def slip_and_force(angle: float, z: float) -> tuple[float, float]:
        u_x, u_y = AMPLITUDE * OMEGA * (r + np.cos(angle)), b * OMEGA * np.sin(angle)
        k = load * (feed - b + b * np.cos(angle))

        def miss(v: float) -> float:
            F = P * z + sigma2 * v
            return v - (u_x * tan(pi / 4 - atan2(F, 2 * k + F)) - u_y)

        v = brentq(miss, -10, 10, xtol=1e-16)
        return v, P * z + sigma2 * v

    def rates(angle: float, y: np.ndarray) -> list[float]:
        v, F = slip_and_force(angle, y[0])
        g = F_C + (F_S - F_C) * np.exp(-((v / v_s) ** 2))
        return [(v - P * abs(v) / g * y[0]) / OMEGA, F / OMEGA]

    end = 0.83 * 2 * pi
    exact = solve_ivp(rates, (0, end), [0, 0], "LSODA", rtol=1e-10, atol=[1e-16, 1e-13], max_step=0.01).y[:, -1]
    values = {**ELLIPSE, "amplitude_y": b, "cutting_speed": r * AMPLITUDE * OMEGA, "feed": feed, "chip_flow_angle": "current_shear_angle"}
    values |= {"sigma0": P, "F_C": F_C, "F_S": F_S, "v_s": v_s, "sigma1": 0.0, "sigma2": sigma2}
    for tolerance, allowed in ((1e-4, 2e-2), (1e-6, 2e-3), (1e-8, 2e-5)):  # a reversal is no event here, so steps cross its kink
        contact = started({**values, "relative_tolerance": tolerance})
        contact.advance(end / OMEGA)
        assert read(contact, "bristle_deflection", "friction_impulse") == pytest.approx(exact, rel=allowed)
        angle, z = OMEGA * contact.time, contact.get("bristle_deflection")
        assert read(contact, "slip_velocity_used", "friction_force") == pytest.approx(slip_and_force(angle, z), rel=1e-9)
        beta = atan2(contact.get("friction_force"), contact.get("normal_force"))
        assert contact.get("shear_angle") == pytest.approx(pi / 4 - beta, abs=1e-12)
