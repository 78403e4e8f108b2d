"""What do friction and shear load together put on the tool? One thin shear plane, Merchant's circle, both shear-angle principles."""

from __future__ import annotations

from math import asin, atan, atan2, cos, hypot, inf, isfinite, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from driving import OUTSIDE, read, started
from scipy.optimize import minimize_scalar

PRINCIPLES = ("maximum_shear_stress", "minimum_energy")
RAKES = (-0.35, 0.0, radians(10), 0.5)


def forces(F: float, k: float, alpha: float, principle: str) -> dict[str, float]:
    """The kernel's answer to a friction force and a shear load: Coulomb friction gives the one, thickness the other."""
    values = {
        **OUTSIDE,
        "friction_law": "coulomb",
        "F_C": abs(F) or 1.0,
        "slip_velocity": float(np.sign(F)),
        "shear_stress": 4e8,
        "width": 2e-3,
        "uncut_thickness": k / 8e5,
        "rake_angle": alpha,
        "shear_angle_principle": principle,
    }
    contact = started(values)
    names = ("friction_force", "normal_force", "principal_force", "feed_force", "shear_angle", "tool_force_x", "tool_force_y")
    values_by_name = dict(zip(("F", "N", "F_p", "F_f", "phi", "x", "y"), read(contact, *names), strict=True))
    values_by_name["warned"] = bool(contact.warnings())
    assert values_by_name["F"] == F
    return values_by_name


def angle(beta: float, alpha: float, principle: str) -> float:
    return pi / 4 + alpha - beta if principle == "maximum_shear_stress" else pi / 4 - (beta - alpha) / 2


def friction_angle(f: float, alpha: float, principle: str) -> float:
    """beta by the angles themselves, from f = F/k; the kernel never forms them."""
    if principle == "maximum_shear_stress":
        s = pi / 4 + alpha
        return atan2(f * sin(s), sqrt(2) + f * cos(s))
    A, B = 2 + f * cos(alpha), f * sin(alpha)
    return asin(f / hypot(A, B)) + atan2(B, A)


def resultant(k: float, beta: float, phi: float, alpha: float) -> float:
    return k / (sin(phi) * cos(phi + beta - alpha))


@pytest.mark.parametrize("principle", PRINCIPLES)
def test_textbook_case(principle: str) -> None:
    """Rake 10 degrees, h 0.2 mm, w 2 mm, mu 0.5, 400 MPa: from mu forwards, by the circle."""
    alpha, beta, k = radians(10), atan(0.5), 400e6 * 2e-3 * 0.2e-3
    phi = angle(beta, alpha, principle)
    R = resultant(k, beta, phi, alpha)
    solved = forces(R * sin(beta), k, alpha, principle)
    assert solved["phi"] == pytest.approx(phi, abs=1e-13)
    assert solved["N"] == pytest.approx(2 * solved["F"], rel=1e-13)  # mu = F/N
    assert (solved["F_p"], solved["F_f"]) == pytest.approx((R * cos(beta - alpha), R * sin(beta - alpha)), rel=1e-13)


def test_textbook_case_in_numbers() -> None:
    """By hand: phi = 28.435 and 36.717 degrees; R = k/(sin(phi) cos(phi + beta - alpha)), 160 N of shear load."""
    for principle, degrees, F_p, F_f in (("maximum_shear_stress", 28.435, 455.48, 135.48), ("minimum_energy", 36.717, 429.04, 127.62)):
        beta = atan(0.5)
        F = resultant(160, beta, radians(degrees), radians(10)) * sin(beta)
        solved = forces(F, 160, radians(10), principle)
        assert np.degrees(solved["phi"]) == pytest.approx(degrees, abs=1e-3)
        assert (solved["F_p"], solved["F_f"]) == pytest.approx((F_p, F_f), abs=0.02)


@pytest.mark.parametrize("alpha", RAKES)
@pytest.mark.parametrize("principle", PRINCIPLES)
def test_closed_form_agrees_with_the_angles(principle: str, alpha: float) -> None:
    """Over the domain, from a strong pull to a push: N = R cos(beta), F = R sin(beta), phi by the principle."""
    k = 120.0
    for f in (-0.6, -0.2, -1e-3, 1e-6, 0.1, 0.5, 0.9, 1.4):
        beta = friction_angle(f, alpha, principle)
        phi = angle(beta, alpha, principle)
        solved = forces(f * k, k, alpha, principle)
        if not -pi / 2 < beta < pi / 2:
            assert (solved["N"], solved["warned"]) == (0, True)
            continue
        R = resultant(k, beta, phi, alpha)
        assert R * sin(beta) == pytest.approx(f * k, rel=1e-12)  # the angles close the circle
        assert solved["N"] == pytest.approx(R * cos(beta), rel=1e-12, abs=1e-12 * k)
        assert solved["phi"] == pytest.approx(phi, abs=1e-12)
        assert not solved["warned"]


@pytest.mark.parametrize("alpha", RAKES)
@pytest.mark.parametrize("principle", PRINCIPLES)
@pytest.mark.parametrize("F", [-30.0, 15.0, 90.0])
def test_force_triangle(principle: str, alpha: float, F: float) -> None:
    """One resultant, seen from the rake, from the cutting direction and from the shear plane."""
    k = 150.0
    solved = forces(F, k, alpha, principle)
    N, F_p, F_f, phi = (solved[name] for name in ("N", "F_p", "F_f", "phi"))
    R = hypot(F, N)
    assert hypot(F_p, F_f) == pytest.approx(R, rel=1e-14)
    assert F_p * sin(alpha) + F_f * cos(alpha) == pytest.approx(F, rel=1e-12)  # back onto the rake
    assert F_p * cos(phi) - F_f * sin(phi) == pytest.approx(k / sin(phi), rel=1e-12)  # along the shear plane: tau_s w h/sin(phi)
    assert phi == pytest.approx(angle(atan2(F, N), alpha, principle), abs=1e-14)
    assert (solved["x"], solved["y"]) == (-F_p, F_f)


@pytest.mark.parametrize("alpha", RAKES)
@pytest.mark.parametrize("beta", [-0.2, 0.1, 0.4])
def test_each_principle_does_what_it_is_named_after(alpha: float, beta: float) -> None:
    """Least cutting force over all shear angles at one friction angle; and 45 degrees between resultant and shear plane."""
    k = 100.0

    def F_p(phi: float) -> float:
        return resultant(k, beta, phi, alpha) * cos(beta - alpha)

    lowest = minimize_scalar(F_p, bounds=(0.01, pi / 2 + alpha - beta - 0.01), method="bounded", options={"xatol": 1e-10})
    solved = forces(resultant(k, beta, lowest.x, alpha) * sin(beta), k, alpha, "minimum_energy")
    assert solved["phi"] == pytest.approx(lowest.x, abs=1e-6)  # a minimum is found to the root of the rounding
    assert solved["F_p"] == pytest.approx(lowest.fun, rel=1e-6)

    phi = pi / 4 + alpha - beta
    solved = forces(resultant(k, beta, phi, alpha) * sin(beta), k, alpha, "maximum_shear_stress")
    along, across = solved["F_p"] * cos(phi) - solved["F_f"] * sin(phi), solved["F_p"] * sin(phi) + solved["F_f"] * cos(phi)
    assert along == pytest.approx(across, rel=1e-12)


def test_at_zero_rake_feed_force_is_friction_and_principal_force_is_normal() -> None:
    for principle in PRINCIPLES:
        solved = forces(20.0, 100.0, 0.0, principle)
        assert (solved["F_f"], solved["F_p"]) == (20.0, solved["N"])


@pytest.mark.parametrize("alpha", RAKES)
@pytest.mark.parametrize("principle", PRINCIPLES)
def test_without_friction_only_the_shear_plane_resists(principle: str, alpha: float) -> None:
    k, phi = 80.0, angle(0, alpha, principle)
    frictionless = forces(0.0, k, alpha, principle)
    assert frictionless["phi"] == pytest.approx(phi, abs=1e-15)
    assert frictionless["N"] == pytest.approx(resultant(k, 0, phi, alpha), rel=1e-13)
    for F in (1e-5, -1e-5):  # and the way there is smooth
        assert forces(F, k, alpha, principle)["N"] == pytest.approx(frictionless["N"], abs=5e-5)


@pytest.mark.parametrize("alpha", RAKES)
@pytest.mark.parametrize("principle", PRINCIPLES)
def test_a_vanishing_chip_leaves_a_limit(principle: str, alpha: float) -> None:
    """k -> 0 at F = 10 N: tan(beta) -> tan(s), so N = F (1 - tan(alpha))/(1 + tan(alpha)); or beta -> pi/2 + alpha, N = -F tan(alpha)."""
    F = 10.0
    limit = F * (1 - tan(alpha)) / (1 + tan(alpha)) if principle == "maximum_shear_stress" else -F * tan(alpha)
    for k in (1e-6, 1e-9):
        solved = forces(F, k, alpha, principle)
        assert all(isfinite(value) for value in solved.values())
        assert solved["N"] == pytest.approx(max(limit, 0), abs=5 * (k + sqrt(k * F)))  # minimum energy nears it with the root of k
        assert solved["warned"] == (limit < 0)


@pytest.mark.parametrize("alpha", RAKES)
@pytest.mark.parametrize("principle", PRINCIPLES)
def test_a_chip_cannot_pull_the_tool(principle: str, alpha: float) -> None:
    """However strong the reversed friction: finite forces, no negative normal force, and a word about it."""
    for f in (-1.2, -5.0, -1e3, -1e6):
        solved = forces(f * 0.5, 0.5, alpha, principle)
        assert all(isfinite(value) for value in solved.values())
        assert 0 <= solved["N"] < inf
        outside = f <= -1 / cos(alpha) if principle == "minimum_energy" else sqrt(2) + f * cos(pi / 4 + alpha) < 0
        assert solved["warned"] == outside


@pytest.mark.parametrize("principle", PRINCIPLES)
def test_forces_are_continuous_across_the_end_of_the_domain(principle: str) -> None:
    k, alpha = 1.0, 0.2
    edge = -1 / cos(alpha) if principle == "minimum_energy" else -sqrt(2) / cos(pi / 4 + alpha)
    inside, outside = (forces(edge * (1 + step), k, alpha, principle) for step in (-1e-9, 1e-9))
    assert inside["N"] == pytest.approx(outside["N"], abs=1e-3)  # minimum energy ends in a root: sqrt(1e-9)
