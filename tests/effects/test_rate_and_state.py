"""Does friction follow the logarithm of the slip speed as Dieterich and Ruina have it? Against their own equation in theta, by scipy."""

from __future__ import annotations

from itertools import pairwise
from math import exp, log1p

import numpy as np
import pytest
from asking import OUTSIDE, begun, course, follow
from driving import Values
from scipy.integrate import solve_ivp

F_C, SIGMA0 = 10.0, 1e9  # stiff bristles: their own way, 10 nm, is short against d_c
A, B, V_0, D_C = 0.03, 0.05, 1e-4, 2e-5
LEVEL: Values = {**OUTSIDE, "sigma0": SIGMA0, "F_C": F_C, "F_S": F_C, "sigma1": 0.0, "sigma2": 0.0}
OWN: Values = {"rate_and_state.a": A, "rate_and_state.b": B, "rate_and_state.v_0": V_0, "rate_and_state.d_c": D_C}
ON = ("rate_and_state",)


def stepped(before: float, after: float, ways: np.ndarray, values: Values = OWN) -> np.ndarray:
    """Friction force over ways slid [m], above 0, after a step of the speed from a steady slide."""
    contact = begun({**LEVEL, **values, "slip_velocity": before}, ON)
    rest = 60 * D_C / before
    contact.advance(rest)
    contact.set("slip_velocity", after)
    force: np.ndarray = course(contact, rest + np.append(0, ways) / after, "friction_force")[0, 1:]
    return force


@pytest.mark.parametrize("speed", [1e-6, 1e-4, 3e-3, 0.2])
def test_steady_friction_changes_with_the_logarithm_of_the_speed(speed: float) -> None:
    """By a - b for each factor of e, and not at all far below v_0."""
    force = stepped(speed, speed, np.array([D_C]))[0]
    assert force == pytest.approx(F_C * (1 + (A - B) * log1p(speed / V_0)), rel=1e-9)


@pytest.mark.parametrize(("before", "after"), [(1e-3, 1e-2), (1e-2, 1e-3), (1e-1, 1.0)])
def test_a_step_of_speed_shows_at_once_and_is_settled_over_d_c(before: float, after: float) -> None:
    """The direct effect at once, a ln of the ratio; then an exponential over the way, whatever the time that takes."""
    ways = D_C * np.array([0.02, 0.5, 1, 2, 5])
    jump = log1p(after / V_0) - log1p(before / V_0)
    steady = 1 + (A - B) * log1p(after / V_0)
    assert stepped(before, after, ways) == pytest.approx(
        F_C * (steady + B * jump * np.exp(-ways / D_C)), rel=1e-4
    )  # the bristles lag by 5e-4 of d_c


def test_without_a_state_there_is_no_memory() -> None:
    """b = 0: what is left is the direct effect."""
    force = stepped(1e-3, 1e-2, D_C * np.array([0.02, 1]), {**OWN, "rate_and_state.b": 0.0})
    assert force == pytest.approx([F_C * (1 + A * log1p(1e-2 / V_0))] * 2, rel=1e-9)


def test_a_contact_that_opens_begins_anew() -> None:
    """Fresh: the way to a steady slide is that of the first start."""
    contact = begun({**LEVEL, **OWN, "slip_velocity": 1e-2}, ON)
    ways = np.linspace(0, 3, 20) * D_C / 1e-2
    first = course(contact, ways, "friction_force")[0]
    contact.set("uncut_thickness", -1e-4)
    contact.advance(1e-3)
    contact.set("uncut_thickness", 1e-4)
    again = course(contact, contact.time + ways, "friction_force")[0]
    np.testing.assert_allclose(again, first, rtol=1e-7)
    assert first[1] / first[-1] > 1.1


def test_an_uneven_slide_is_that_of_ruinas_equation() -> None:
    """d theta/dt = -(v theta/d_c) ln(w theta/d_c) and dz/dt, w = v + v_0, by DOP853 at 1e-12, with stops, reversals and bursts; the memory
    is -ln(v_0 theta/d_c)."""
    values: Values = {**LEVEL, **OWN, "sigma0": 3e6, "F_S": 1.5 * F_C, "v_s": 2e-3}
    corners, speeds = np.array([0, 0.01, 0.02, 0.03, 0.035, 0.05]), np.array([1e-3, 2e-2, 0.0, -1e-2, -1e-4, 3e-2])
    times = np.linspace(0, 0.05, 101)
    slip = np.interp(times, corners, speeds)
    force, memory = follow(times, {"slip_velocity": slip}, values, ON, "friction_force", "rate_and_state.memory")

    def rates(t: float, y: np.ndarray) -> list[float]:
        z, theta = y
        v = float(np.interp(t, corners, speeds))
        level = 1 + A * log1p(abs(v) / V_0) + B * np.log(V_0 * theta / D_C)
        g = level * F_C * (1 + 0.5 * exp(-((v / 2e-3) ** 2)))
        return [v - 3e6 * abs(v) / g * z, -abs(v) * theta / D_C * np.log((abs(v) + V_0) * theta / D_C)]

    y, rows = np.array([0.0, D_C / V_0]), [[0.0, 0.0]]
    # the corners and the reversal between them are kinks
    stops = np.unique(np.concatenate([times, corners, [0.035 + 0.015 * 1e-4 / 3.01e-2]]))
    for low, high in pairwise(stops):
        y = solve_ivp(rates, (low, high), y, "DOP853", rtol=1e-12, atol=[1e-18, 1e-14]).y[:, -1]
        if high in times:
            rows.append([3e6 * y[0], -np.log(V_0 * y[1] / D_C)])
    right = np.array(rows).T
    np.testing.assert_allclose(memory, right[1], atol=1e-6 * right[1].max())
    np.testing.assert_allclose(force, right[0], atol=1e-6 * F_C)
