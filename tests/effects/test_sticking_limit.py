"""Is friction on the rake face bounded as Zorev's two zones bound it? Against their stresses, integrated over the contact, and Merchant's
circle, drawn with the shear angle itself."""

from __future__ import annotations

from math import cos, exp, pi, sin

import numpy as np
import pytest
from asking import CONSTANT, OUTSIDE, begun, course, follow
from drawing import between
from driving import PERIOD, Values, at_speed_ratio, read
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as some
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

ON = ("sticking_limit",)
WIDTH, SHEAR_STRESS, H = 1e-3, 4e8, 1e-4
SHEAR_LOAD = WIDTH * SHEAR_STRESS * H  # N
MUCH: Values = {**OUTSIDE, **CONSTANT, "F_C": 1e5, "shear_stress": SHEAR_STRESS, "width": WIDTH, "uncut_thickness": H}
FORCES = ("friction_force", "normal_force", "principal_force", "feed_force")


def own(mu: float, length: float, exponent: float) -> Values:
    return {"sticking_limit.mu": mu, "sticking_limit.contact_length": length, "sticking_limit.exponent": exponent}


def forces(values: Values, on: tuple[str, ...] = ON) -> np.ndarray:
    contact = begun({**MUCH, **values}, on)
    contact.evaluate()
    return read(contact, *FORCES)


def circle(beta: float, rake: float, principle: str) -> tuple[float, float]:
    """Friction and normal force over the shear load at a friction angle: R from the shear plane, along which k/sin(phi) acts."""
    phi = pi / 4 - (beta - rake) * (0.5 if principle == "minimum_energy" else 1)
    R = 1 / sin(phi) / cos(phi + beta - rake)
    return R * sin(beta), R * cos(beta)


def zones(N: float, mu: float, length: float, exponent: float) -> float:
    """Friction stress over the contact, sum of 400 000 strips: mu sigma or the shear flow stress, whichever is less."""
    places = (np.arange(400_000) + 0.5) / 400_000
    sigma = (exponent + 1) * N / length * places**exponent
    return float(np.minimum(mu * sigma, 1).mean() * length)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
@pytest.mark.parametrize(
    ("rake", "mu", "length", "exponent"),
    [
        (0.0, 1.0, 2.0, 3.0),
        (0.2, 0.6, 1.0, 2.0),
        (-0.3, 2.0, 4.0, 0.5),
        (0.0, 0.4, 3.0, 0.0),
        (0.3, 3.0, 0.7, 10.0),
        (0.1, 0.3, 50.0, 3.0),
        (0.5, 2.5, 20.0, 3.0),  # mu tan(rake) > 1: against the flow it was 0 or, with N = 0, all of the shear load
    ],
)
def test_the_limit_is_that_of_both_zones(side: int, principle: str, rake: float, mu: float, length: float, exponent: float) -> None:
    """With more friction than any contact bears: the friction angle at which both zones give the friction of Merchant's circle."""

    def excess(beta: float) -> float:
        F, N = circle(side * beta, rake, principle)
        return abs(F) - zones(N, mu, length, exponent)

    steepest = pi / 2 + rake if principle == "minimum_energy" else pi / 4 + rake
    most = min(np.arctan(mu), (steepest if side > 0 else pi / 2) - 1e-9)
    beta = brentq(excess, 1e-9, most + 1e-12, xtol=1e-13) if excess(most) > 1e-5 else most
    right = np.array(circle(side * beta, rake, principle)) * SHEAR_LOAD
    F, N, F_p, F_f = forces(
        {**own(mu, length, exponent), "rake_angle": rake, "shear_angle_principle": principle, "slip_velocity": side * 0.5}
    )
    assert pytest.approx(right, rel=2e-5) == [F, N]  # of the strips
    assert [F_p, F_f] == pytest.approx([N * cos(rake) + F * sin(rake), F * cos(rake) - N * sin(rake)], rel=1e-12)


def test_no_contact_is_asked_for_more_than_it_bears() -> None:
    """At any rake, friction, contact length and exponent, along the flow and against it; against the slip it always stands."""
    rng = np.random.default_rng(20)
    for n in range(300):
        mu, length, side = 10 ** rng.uniform(-1.5, 1), 10 ** rng.uniform(-1, 1.5), (-1) ** n
        shape: Values = {
            "rake_angle": rng.uniform(-0.7, 0.7),
            "shear_angle_principle": ("minimum_energy", "maximum_shear_stress")[n // 2 % 2],
        }
        F, N, _, _ = forces({**own(mu, length, rng.uniform(0, 8)), **shape, "slip_velocity": 0.5 * side})
        assert 0 < side * F <= min(mu * N, length * SHEAR_LOAD) * (1 + 1e-9), (n, mu, length, shape)


@pytest.mark.parametrize("side", [1, -1])
def test_with_a_long_contact_the_chip_slides_and_with_a_short_one_it_sticks(side: int) -> None:
    sliding, sticking = (forces({**own(mu, length, 3.0), "slip_velocity": side}) for mu, length in ((0.3, 100.0), (10.0, 0.05)))
    assert abs(sliding[0]) == pytest.approx(0.3 * sliding[1], rel=1e-12)
    assert abs(sticking[0]) == pytest.approx(0.05 * SHEAR_LOAD, rel=0.1)
    even = forces({**own(10.0, 0.05, 0.0), "slip_velocity": side})
    assert abs(even[0]) == pytest.approx(0.05 * SHEAR_LOAD, rel=1e-12)


def test_friction_that_the_contact_bears_is_left_alone() -> None:
    """To the bit, at any thickness for which the limit lies above it."""
    small: Values = {"F_C": 1.0, "slip_velocity": 0.5}
    assert np.array_equal(forces(small), forces(small, ()))


@pytest.mark.parametrize("law", ["coulomb", "lugre", "dahl", "reset_integrator", "bristle", "karnopp"])
def test_no_law_and_no_damping_passes_the_limit(law: str) -> None:
    """Over a cut of the ellipse whose thickness begins and ends at nothing, with viscous friction beside that alone would be beyond."""
    values: Values = {**at_speed_ratio(0.5, feed=4e-5), "F_C": 40.0, "F_S": 50.0, "sigma0": 4e7, "sigma1": 50.0, "sigma2": 30.0}
    values |= {"friction_law": law, "width": 2e-4, "relative_tolerance": 1e-4, "damping_mode": "as_published", **own(0.6, 1.5, 3.0)}
    contact = begun(values, (*ON, "viscous_friction"))
    F, N, touching = course(contact, np.linspace(0, 2 * PERIOD, 2001), "friction_force", "normal_force", "in_contact")
    cuts = touching > 0
    assert 200 < np.count_nonzero(cuts) < 1900
    assert np.all(np.abs(F[cuts]) <= 0.6 * N[cuts] * (1 + 1e-12))
    assert np.all(F[~cuts] == 0)
    assert np.count_nonzero(F[cuts] < 0) > 20
    plain = begun(values, ("viscous_friction",))
    F, N = course(plain, np.linspace(0, 2 * PERIOD, 2001), "friction_force", "normal_force")
    assert np.any(np.abs(F) > 0.6 * N + 1)  # else nothing is asked


def test_where_nothing_presses_nothing_rubs() -> None:
    """Shear stress 0: a chip without normal force. And thinner and thinner chips: friction falls in proportion."""
    values: Values = {"friction_law": "lugre", "F_C": 9.0, "F_S": 12.0, "sigma2": 5.0, "slip_velocity": 0.5, **own(1.0, 2.0, 3.0)}
    contact = begun({**MUCH, **values, "shear_stress": 0.0}, ON)
    assert np.all(course(contact, np.linspace(0, 1e-3, 20), "friction_force", "normal_force") == 0)
    thin = [forces({**values, "friction_law": "coulomb", "F_C": 1e5, "uncut_thickness": h})[0] / h for h in (1e-5, 1e-8, 1e-12)]
    assert thin == pytest.approx([thin[0]] * 3, rel=1e-12)


@pytest.mark.parametrize("law", ["lugre", "dahl"])
def test_steady_deflection_follows_the_limit(law: str) -> None:
    """Of a slow change of thickness: bristles are bent by the limit over their stiffness, or by F_C where that is less; it never jumps."""
    times = np.linspace(0, 1, 2001)
    h = H * (0.5 + 0.4999 * np.cos(2 * pi * times))
    values: Values = {**MUCH, "friction_law": law, "F_C": 30.0, "F_S": 30.0, "sigma0": 1e6, "sigma1": 0.0, "sigma2": 0.0}
    inputs = {"slip_velocity": np.full(2001, 0.5), "uncut_thickness": h}
    z, F = follow(times, inputs, {**values, **own(0.8, 1.0, 3.0)}, ON, "bristle_deflection", "friction_force")
    limit = forces({**own(0.8, 1.0, 3.0), "slip_velocity": 0.5})[0] * h / H
    steady = np.minimum(limit, 30.0) / 1e6
    assert np.count_nonzero(steady < 29e-6) > 400
    lag = 25e-6 / 0.5 * np.abs(np.gradient(steady, times)).max()  # a bristle's own way, at the speed of the slip
    np.testing.assert_allclose(z[5:], steady[5:], rtol=1e-5, atol=lag)  # from 2.5 ms on, after 50 such ways
    np.testing.assert_allclose(F[5:], 1e6 * steady[5:], rtol=1e-5, atol=1e6 * lag)
    assert np.abs(np.diff(z[5:])).max() < 3 * np.abs(np.diff(limit)).max() / 1e6


def test_a_stroke_under_a_chip_that_grows_and_thins_is_that_of_its_equation() -> None:
    """LuGre between its own limit and the contact's, with viscous friction, through two reversals: DOP853 at 1e-11, and the bound written
    anew for minimum energy at rake angle 0, N^2 = 4 k (k + F)."""
    mu, length, n, sigma0, F_C, F_S, v_s, sigma2 = 0.8, 1.0, 3.0, 1e6, 20.0, 26.0, 0.05, 8.0
    values: Values = {
        **MUCH,
        "friction_law": "lugre",
        "F_C": F_C,
        "F_S": F_S,
        "v_s": v_s,
        "sigma0": sigma0,
        "sigma1": 0.0,
        "sigma2": sigma2,
    }
    values = {**values, **own(mu, length, n), "shear_angle_principle": "minimum_energy", "relative_tolerance": 1e-6}
    times = np.linspace(0, 2e-3, 801)
    corners, speeds, heights = np.array([0, 4e-4, 1.1e-3, 2e-3]), np.array([0.2, 0.5, -0.4, 0.6]), H * np.array([0.02, 1.2, 0.1, 0.9])
    slip, h = np.interp(times, corners, speeds), np.interp(times, corners, heights)
    F, z = follow(times, {"slip_velocity": slip, "uncut_thickness": h}, values, ON, "friction_force", "bristle_deflection")

    def most(side: int) -> float:
        return float(
            brentq(lambda X: X - zones_closed(2 * np.sqrt(max(1 + side * X, 0)), mu, length, n), 0, 1 if side < 0 else 9, xtol=1e-15)
        )

    along, against = most(1), most(-1)

    def state(t: float) -> tuple[float, float, float]:
        v, k = np.interp(t, corners, speeds), SHEAR_LOAD / H * np.interp(t, corners, heights)
        limit = k * (along if v >= 0 else against)
        g = min(F_C, limit) + (min(F_S, limit) - min(F_C, limit)) * exp(-((v / v_s) ** 2))
        return float(v), g, k

    def rate(t: float, y: np.ndarray) -> list[float]:
        v, g, _ = state(t)
        return [v - sigma0 * abs(v) / g * y[0]]

    right = solve_ivp(rate, (0, times[-1]), [0.0], "DOP853", t_eval=times, rtol=1e-11, atol=1e-16, max_step=1e-6).y[0]
    force = [min(max(sigma0 * y + sigma2 * v, -k * against), k * along) for y, (v, _, k) in zip(right, map(state, times), strict=True)]
    bounded = np.abs(sigma0 * right + sigma2 * slip - force) > 1e-3
    assert 50 < np.count_nonzero(bounded) < 750
    np.testing.assert_allclose(sigma0 * z, sigma0 * right, atol=1e-5 * F_S)
    np.testing.assert_allclose(F, force, atol=1e-5 * F_S)


def zones_closed(N: float, mu: float, length: float, n: float) -> float:
    """The integral of both zones: the chip slides over the share q^(-1/n) of the contact."""
    q = (n + 1) * mu * N / length
    return mu * N if q <= 1 else length * (1 - n / (n + 1) * q ** (-1 / n))


contacts = some.fixed_dictionaries(
    {
        "sigma0": between(1e5, 1e8),
        "sigma1": between(1e-3, 1e4),
        "sigma2": between(1e-4, 10),
        "F_C": between(0.5, 100),
        "F_S": between(0.5, 100),
        "v_s": between(1e-4, 1),
        "damping_margin": some.floats(0.01, 0.99),
        "rake_angle": some.floats(-0.5, 0.5),
        "shear_angle_principle": some.sampled_from(["maximum_shear_stress", "minimum_energy"]),
        "width": between(1e-4, 2e-3),
        "sticking_limit.severity": some.floats(0.2, 1),
        "sticking_limit.mu": between(0.02, 5),
        "sticking_limit.contact_length": between(0.05, 20),
        "sticking_limit.exponent": some.floats(0, 8),
    }
)
# Here the closed form of the limit turned its sign, and friction drove the chip back.
BEYOND_THE_DOMAIN: Values = {
    "sigma0": 1e5, "sigma1": 1.0, "sigma2": 1.0, "F_C": 1.0, "F_S": 1.0, "v_s": 1.0, "damping_margin": 0.5, "rake_angle": 0.5,
    "shear_angle_principle": "minimum_energy", "width": 1e-3, "sticking_limit.severity": 1.0, "sticking_limit.mu": 10**0.5,
    "sticking_limit.contact_length": 1.0, "sticking_limit.exponent": 0.0,
}  # fmt: skip
swings = some.lists(some.tuples(between(1e-3, 2), some.floats(0, 2 * pi)), min_size=1, max_size=3)


@settings(max_examples=100, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(values=contacts, shape=swings, mean=some.sampled_from([0.0, 0.5, 1.5]), share=between(1e-2, 30), phase=some.floats(0, 2 * pi))
def test_friction_takes_energy_while_the_chip_grows_and_thins(
    values: Values, shape: list[tuple[float, float]], mean: float, share: float, phase: float
) -> None:
    """Whatever bounds it, no more comes out from sample to sample than the bristles had stored. Slack as in test_energy_with_effects."""
    turns = np.arange(96 * 3 + 1) / 96
    speed = np.sum([v * np.cos(2 * pi * (n + 1) * turns + at) for n, (v, at) in enumerate(shape)], axis=0) + mean * shape[0][0]
    frequency = min(shape[0][0] / (2 * pi * share * float(values["F_C"]) / float(values["sigma0"])), 1e6)
    given = {**OUTSIDE, **values, "friction_law": "lugre", "relative_tolerance": 1e-6}
    inputs = {"slip_velocity": speed, "uncut_thickness": H * (1.001 + np.cos(4 * pi * turns + phase))}
    names = ("dissipated_energy", "friction_force", "bristle_deflection")
    energy, F, z = follow(turns / frequency, inputs, given, ON, *names)
    stored = 0.5 * float(values["sigma0"]) * z**2
    to_and_fro = float(np.abs(F * speed).mean() * 3 / frequency)
    slack = 1e-5**0.6 * (to_and_fro + stored.max())
    assert np.all(np.diff(energy - stored) >= -slack)


@settings(max_examples=60, deadline=None, derandomize=True)
@example(values=BEYOND_THE_DOMAIN, v=-1.0, h=1e-3, z=0.0)
@given(values=contacts, v=some.floats(-2, 2), h=between(1e-9, 1e-3), z=some.floats(-3, 3))
def test_bounded_friction_takes_power_beyond_what_bristles_store(values: Values, v: float, h: float, z: float) -> None:
    """At a point, without steps: F v >= s0 z dz/dt, also of bristles that are bent beyond what the contact bears now."""
    own_limit = forces({**values, **CONSTANT, "F_C": 1e5, "friction_law": "coulomb", "uncut_thickness": h, "slip_velocity": 1.0})[0]
    bent = z * min(own_limit, float(values["F_S"])) / float(values["sigma0"])
    contact = begun({**MUCH, **values, "friction_law": "lugre", "uncut_thickness": h, "slip_velocity": v, "bristle_deflection": bent}, ON)
    contact.evaluate()
    power, rate, F = read(contact, "dissipated_power", "bristle_rate", "friction_force")
    assert power == pytest.approx(F * v, rel=1e-12)
    stored = float(values["sigma0"]) * bent * rate
    assert power - stored >= -1e-9 * (abs(power) + abs(stored))
