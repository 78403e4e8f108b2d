"""Does friction ever give energy away? Work over closed cycles of slip, and what is stored in the bristles on the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, exp, pi, sin

import numpy as np
import pytest
from drawing import between
from driving import AMPLITUDE, OMEGA, PERIOD, at_speed_ratio, slide, started
from evat.native import kernel
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as some
from scipy.integrate import quad
from work import EFFECTS, SAMPLES, Cycles

BUSY = [HealthCheck.too_slow, HealthCheck.filter_too_much]
ordinary = settings(max_examples=100, deadline=None, derandomize=True, suppress_health_check=BUSY)
few = settings(ordinary, max_examples=25)  # of the law with many bonds, whose runs take some twenty times as long


friction = some.fixed_dictionaries(
    {
        "sigma0": between(1e4, 1e8),
        "sigma1": between(1e-3, 1e5),
        "sigma2": between(1e-4, 10),
        "F_C": between(0.05, 50),
        "F_S": between(0.05, 50),
        "v_s": between(1e-4, 1),
        "damping_margin": some.floats(0.01, 0.99),
        "rate_stiffness": some.sampled_from(["reference", "thermal"]),
        "theta_ref": between(1e-3, 1),
        "thermal_softening.k_Q": between(1, 1e8),
        "thermal_softening.Q": some.floats(0.1, 6),
        "thermal_damping.alpha2": some.floats(0, 2),
    }
)
effects = some.sampled_from([(), EFFECTS[:1], EFFECTS[1:], EFFECTS])
# up to three harmonics in m/s and their phases, a mean, and the way in break-away deflections F_C/sigma0
harmonic = some.tuples(between(1e-4, 2), some.floats(0, 2 * pi))
slip = some.tuples(some.lists(harmonic, min_size=1, max_size=3), some.sampled_from([0.0, 0.5, 1.5]))
way = between(1e-3, 30)


def sum_of(harmonics: list[tuple[float, float]], mean: float) -> Callable[[float], float]:
    level = mean * harmonics[0][0]
    return lambda angle: level + sum(v * cos((n + 1) * angle + phase) for n, (v, phase) in enumerate(harmonics))


def turns_per_second(values: Mapping[str, float], v: float, share: float) -> float:
    """Frequency at which a slip of amplitude v goes to and fro by a share of the break-away deflection; no faster than 1 MHz."""
    return min(v / (2 * pi * share * values["F_C"] / values["sigma0"]), 1e6)


@pytest.mark.parametrize("law", [law for law in kernel.variable("friction_law").choices if law != "bristle"])
@pytest.mark.parametrize("source", ["cutting_speed", "proxy_speed"])
@ordinary
@given(values=friction, on=effects, motion=slip, share=way, speed=between(1e-3, 1))
def test_at_a_steady_temperature_friction_takes_energy(
    law: str, source: str, values: dict, on: tuple[str, ...], motion: tuple, share: float, speed: float
) -> None:
    """From sample to sample, and so over every closed cycle: no more comes out than the bristles have stored."""
    harmonics, mean = motion
    frequency = turns_per_second(values, harmonics[0][0], share)
    cycles = Cycles(sum_of(harmonics, mean), frequency, {**values, "friction_law": law, "proxy_source": source, source: speed}, on)
    stored = cycles.stored
    if law in ("coulomb", "karnopp"):
        stored = np.zeros(cycles.energy.shape)
    if law == "reset_integrator":
        stored = stored * values["F_S"] / values["F_C"]
    assert np.all(np.diff(cycles.energy - stored) >= -cycles.slack)


@pytest.mark.parametrize("source", ["cutting_speed", "proxy_speed"])
@few
@given(values=friction, on=effects, motion=slip, share=way, speed=between(1e-3, 1))
def test_at_a_steady_temperature_bonds_give_no_more_than_they_began_with(
    source: str, values: dict, on: tuple[str, ...], motion: tuple, share: float, speed: float
) -> None:
    """The bonds' own energy does not show; they began with d^2/24 each, d = 3 F_C/P."""
    harmonics, mean = motion
    frequency = turns_per_second(values, harmonics[0][0], share)
    cycles = Cycles(sum_of(harmonics, mean), frequency, {**values, "friction_law": "bristle", "proxy_source": source, source: speed}, on)
    P = cycles.s0[0] if values["rate_stiffness"] == "thermal" else values["sigma0"]
    assert np.all(cycles.energy + cycles.s0[0] * (3 * values["F_C"] / P) ** 2 / 24 >= -cycles.slack)


@ordinary
@given(values=friction, on=effects, motion=slip, share=way)
def test_softening_by_the_slip_itself_gives_away_no_more_than_the_stiffening_of_loaded_bristles(
    values: dict, on: tuple[str, ...], motion: tuple, share: float
) -> None:
    """theta = slip speed: bristles stiffen as the slip slows. What that adds to the stored energy, z^2/2 times each rise of s0, is the
    most that can come out; this is what is left of the promise."""
    harmonics, mean = motion
    frequency = turns_per_second(values, harmonics[0][0], share)
    cycles = Cycles(sum_of(harmonics, mean), frequency, {**values, "friction_law": "lugre"}, on)
    rises, z = np.maximum(np.diff(cycles.s0), 0), np.maximum(np.abs(cycles.z[1:]), np.abs(cycles.z[:-1]))
    turns = cycles.speed[1:] * cycles.speed[:-1] < 0  # within such a sample s0 rises to sigma0, and z may have its peak
    rises[turns], z[turns] = values["sigma0"] - cycles.s0[:-1][turns], np.abs(cycles.z).max()
    assert np.all(np.diff(cycles.energy - cycles.stored) + rises * z**2 / 2 >= -cycles.slack)


@ordinary
@given(values=friction, amplitude=between(1e-3, 2), share=way, on=effects)
def test_one_harmonic_of_slip_takes_energy_also_from_bristles_that_soften_with_it(
    values: dict, amplitude: float, share: float, on: tuple[str, ...]
) -> None:
    """The way out is as fast as the way back at every deflection, so nothing is gained."""
    frequency = turns_per_second(values, amplitude, share)
    cycles = Cycles(lambda angle: amplitude * cos(angle), frequency, {**values, "friction_law": "lugre"}, on)
    assume(abs(np.diff(cycles.stored[::SAMPLES])[-1]) <= 1e-3 * abs(cycles.work[-1]))  # the cycle has closed
    assert cycles.work[-1] >= -cycles.slack


SOFTENING = {
    "friction_law": "lugre",
    "sigma0": 1e6,
    "sigma1": 0.0,
    "sigma2": 0.0,
    "F_C": 9.0,
    "F_S": 9.0,
    "theta_ref": 1.0,
    "thermal_softening.k_Q": 1e6,
    "thermal_softening.Q": 1.0,
}


@pytest.mark.parametrize("rate_stiffness", ["reference", "thermal"])
@pytest.mark.parametrize("share", [0.003, 0.03, 0.3])
def test_bristles_bent_fast_and_let_back_slowly_give_energy_away(share: float, rate_stiffness: str) -> None:
    """The limit of the promise, in its smallest case: to and fro by a share A of the break-away deflection g/sigma0, out at 0.5 m/s where
    s0 is half of sigma0, back at 0.01 m/s where it is 99 % of it. At a steady speed the bristle is an exponential of the way, so the
    work is known: each way back returns nearly A^2/2 times the difference of s0, and the sliding does not pay for it."""
    g, A, fast, slow = 9.0, share * 9e-6, 0.5, 0.01
    s_fast, s_slow = 1e6 * (1 - fast), 1e6 * (1 - slow)
    P_fast, P_slow = (s_fast, s_slow) if rate_stiffness == "thermal" else (1e6, 1e6)
    a, b = g / P_slow, g / P_fast
    back, out = exp(-A / a), exp(-A / b)
    turn = (b * (1 - out) + a * out * (1 - back)) / (1 + back * out)  # deflection at the turning point
    middle = (turn + a) * back - a
    work = 2 * s_slow * (a * A - (turn + a) * a * (1 - back)) + 2 * s_fast * (b * A - (middle + b) * b * (1 - out))

    times, speed = [0.0], [fast]
    for leg, length in ((fast, A / fast), (-slow, A / slow), (-fast, A / fast), (slow, A / slow)) * 3:
        times += [times[-1] + 1e-7 * A, times[-1] + length]
        speed += [leg, leg]
    values = {**SOFTENING, "rate_stiffness": rate_stiffness, "relative_tolerance": 1e-9, "bristle_deflection": -middle}
    soft, steady = (
        slide(np.array(times), np.array(speed), {**values, "proxy_source": source}, "dissipated_energy", on=EFFECTS[:1])[::8, 0]
        for source in ("slip_speed", "cutting_speed")
    )
    assert np.diff(soft) == pytest.approx(work, rel=1e-4)
    assert -(A**2) * (s_slow - s_fast) < work < 0
    assert np.all(np.diff(steady) > 0)


@pytest.mark.parametrize("twist", [-0.9, 0.9])
def test_two_harmonics_are_enough_to_give_energy_away(twist: float) -> None:
    """A smooth slip, v = V cos(p) (1 + twist sin(2 p)): a third harmonic in quadrature makes it faster on the way out, or back. By a
    thousandth of break-away the bristle is a spring, s0(v) z with z the way, and the work is the integral of that."""
    V, reach = 0.45, 1e-3 * 9e-6

    def v(p: float) -> float:
        return V * cos(p) * (1 + twist * sin(2 * p))

    def z(p: float) -> float:
        return reach * (sin(p) - twist * 2 / 3 * cos(p) ** 3)

    cycles = Cycles(v, V / (2 * pi * reach), {**SOFTENING, "bristle_deflection": z(0)}, EFFECTS[:1])
    work = quad(lambda p: 1e6 * (1 - abs(v(p))) * z(p) * v(p) * reach / V, 0, 2 * pi, limit=200)[0]
    assert np.sign(work) == -np.sign(twist)
    assert abs(work) > 0.1 * 1e6 * reach**2
    assert cycles.work == pytest.approx(work, rel=2e-2)  # sliding adds a share of the order of z sigma0/g


def test_a_vibration_cycle_takes_energy() -> None:
    """On the ellipse, softened by the slip: every cycle takes some, and no more than F_S and the viscous force along the whole slip."""
    r, phi, F_S, sigma2 = 0.3, pi / 6, 10.0, 1.0
    values = at_speed_ratio(r, feed=1e-4, sigma0=1e8, sigma1=0.0, F_S=F_S, sigma2=sigma2, chip_flow_shear_angle=phi)
    contact = started(values, EFFECTS[:1])
    energy = []
    for _ in range(4):
        contact.advance(PERIOD)
        energy.append(contact.get("dissipated_energy"))
    psi = np.linspace(0, 2 * pi, 10001)
    speed = np.abs(AMPLITUDE * OMEGA * ((r + np.cos(psi)) * np.tan(phi) - np.sin(psi)))
    most = (F_S + sigma2 * speed.max()) * speed.mean() * PERIOD
    assert np.all(np.diff(energy) > 0.1 * most)
    assert np.all(np.diff(energy) < most)
