"""What does friction do before it slides? The elasto-plastic gate against plain LuGre, which creeps under any load that oscillates.

Dupont, Hayward, Armstrong and Altpeter, Single state elastoplastic friction models, IEEE Transactions on Automatic Control 47 (2002).
"""

from __future__ import annotations

from itertools import pairwise
from math import exp, pi, sin

import lugre_1995 as published
import numpy as np
import pytest
from asking import OUTSIDE, begun, follow
from driving import Values
from evat import parameter_sets
from evat.model import Run
from evat.models.contact import ContactModel
from scipy.integrate import solve_ivp

GATE = ("elasto_plastic",)
SET = parameter_sets.load("lugre-1995").values
P, F_S = SET["sigma0"], SET["F_S"]

# A contact with one friction level: the steady deflection is Z at every speed, and the force is the stiffness times the deflection.
STIFFNESS, Z = 4e4, 5e-5  # N/m, m
BARE: Values = {"friction_law": "lugre", "sigma0": STIFFNESS, "F_C": STIFFNESS * Z, "F_S": STIFFNESS * Z, "sigma1": 0.0, "sigma2": 0.0}


def gated(break_away: float, share: float = 1.0) -> dict[str, float | str]:
    return {**BARE, "elasto_plastic.break_away": break_away, "elasto_plastic.share": share}


def along(way: np.ndarray, values: Values, on: tuple[str, ...] = GATE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Way slid, bristle deflection and energy taken at 200 samples a leg between the turning points of the way, at 1 mm/s."""
    legs = [1e-3 * float(np.sign(stop - start)) for start, stop in pairwise(way)]
    times, speed = [0.0], [legs[0]]
    for leg, (start, stop) in zip(legs, pairwise(way), strict=True):
        times += list(times[-1] + (stop - start) / leg * np.arange(1, 201) / 200)
        times[-200] = times[-200] if leg == speed[-1] else times[-201] + 1e-12  # where the slip turns, as good as at once
        speed += [leg] * 200
    t, v = np.array(times), np.array(speed)
    z, energy = follow(t, {"slip_velocity": v}, values, on, "bristle_deflection", "dissipated_energy")
    return np.concatenate([[0.0], np.cumsum(np.diff(t) * (v[1:] + v[:-1]) / 2)]), z, energy


def shaken_mass(on: tuple[str, ...]) -> published.Motion:
    """1 kg under a load that never reaches half of the static friction: 0.4 N, and 0.25 N at 5 Hz, brought up within a second."""
    contact = begun({**SET, **published.DRIVEN_FROM_OUTSIDE}, on)

    def friction(t: float, v: float, z: float) -> tuple[float, float]:
        contact.set("slip_velocity", v)
        contact.set("bristle_deflection", z)
        contact.evaluate()
        return contact.get("friction_force"), contact.get("bristle_rate")

    plant = published.pushed_mass(lambda t, x: min(t, 1) * (0.4 + 0.25 * sin(10 * pi * t)), np.linspace(0, 6, 1201))
    return published.follow(plant, friction)


def mean_places(motion: published.Motion) -> np.ndarray:
    """Mean position of each whole cycle after the first two seconds."""
    means: np.ndarray = motion.x[400:-1].reshape(-1, 40).mean(axis=1)
    return means


@pytest.mark.filterwarnings("ignore:overflow encountered in multiply")  # Radau's probe of a position that matters to nothing
def test_the_gate_holds_a_mass_where_lugre_drifts() -> None:
    """The load goes to and fro within the break-away force of 1.05 N. Plain LuGre creeps on by the same way each cycle, past the whole
    break-away deflection; the gate leaves the mass on its spring, at 0.4 N / sigma0, to the integration's 1e-8 of 1e-4 m a step."""
    plain, held = mean_places(shaken_mass(())), mean_places(shaken_mass(GATE))
    creep = np.diff(plain)
    assert np.all(creep > 1e-7)
    assert creep[10:] == pytest.approx(creep[-1], rel=0.05)  # it never comes to rest
    assert 1 < (plain[-1] - plain[0]) / (F_S / P) < 10
    assert held == pytest.approx(np.full(20, 0.4 / P), abs=2e-4 * 0.4 / P)


@pytest.mark.parametrize("break_away", [0.2, 0.7, 0.95])
def test_below_break_away_the_contact_is_a_spring(break_away: float) -> None:
    """To and fro by 0.99 of the break-away deflection: sigma0 x everywhere, no loop, no work, but for rounding. LuGre has both."""
    reach = 0.99 * break_away * Z
    way = np.array([0, 1, -1, 1, -0.5, 0.3, 0]) * reach
    x, z, energy = along(way, gated(break_away))
    assert x[200::200] == pytest.approx(way[1:], abs=1e-3 * reach)  # it went there
    assert np.max(np.abs(z - x)) < 1e-9 * reach
    assert abs(energy[-1]) < 1e-8 * STIFFNESS * reach**2
    _, plain, lost = along(way, gated(break_away), ())
    assert np.max(np.abs(plain - x)) > 0.1 * break_away * reach
    assert lost[-1] > 0.1 * break_away * STIFFNESS * reach**2


@pytest.mark.parametrize("break_away", [0.3, 0.7, 0.95])
def test_what_slid_stays_and_what_bent_springs_back(break_away: float) -> None:
    """Pushed into sliding and let back, the contact unloads along its spring: after the way Z it comes to no force, having kept the rest,
    and is elastic up to break-away the other way. LuGre unloads twice as steeply, F' = sigma0 (1 + z/Z). 1e-3: one sample's turn."""
    x, z, _ = along(np.array([0, 12, 11, 11 - 0.99 * break_away]) * Z, gated(break_away))
    plain = along(np.array([0, 12, 11]) * Z, gated(break_away), ())[1]
    assert z[200] == pytest.approx(Z, rel=1e-4)
    back = slice(201, None)
    assert (z[back] - z[201]) / Z == pytest.approx((x[back] - x[201]) / Z, abs=1e-6)
    assert z[400] == pytest.approx(0, abs=1e-2 * Z)
    assert (z[201] - z[202]) / (x[201] - x[202]) == pytest.approx(1, abs=1e-6)
    assert (plain[201] - plain[202]) / (x[201] - x[202]) == pytest.approx(2, abs=0.01)


@pytest.mark.parametrize("speed", [-3.0, -1e-2, -1e-4, 1e-5, 1e-3, 0.2, 5.0])
def test_steady_sliding_is_that_of_lugre(speed: float) -> None:
    """After 30 break-away ways both are on the Stribeck curve: what is left of LuGre is exp(-30), and the gate has fewer ways to go."""
    values: Values = {"friction_law": "lugre", "sigma0": 1e6, "sigma1": 3.0, "sigma2": 0.7, "F_C": 9.0, "F_S": 12.0, "v_s": 1e-3}
    forces = []
    for on in ((), GATE):
        contact = begun({**values, "kinematics": "external", "slip_velocity": speed}, on)
        contact.advance(30 * 1.2e-5 / abs(speed))
        forces.append(contact.get("friction_force"))
    steady = np.sign(speed) * (9 + 3 * exp(-((speed / 1e-3) ** 2))) + 0.7 * speed
    assert forces == pytest.approx([steady, steady], rel=1e-8)


def test_half_the_share_lies_between() -> None:
    """On the way in from rest the fewer bristles are plastic the further they bend; with none of them it is LuGre to the last bit."""
    way = np.array([0, 2.5]) * Z
    plain = along(way, gated(0.5), ())[1]
    none, half, all_of_them = (along(way, gated(0.5, share))[1] for share in (0, 0.5, 1))
    assert np.array_equal(none, plain)
    inside = slice(10, 150)  # before that they agree, later all of them slide
    assert np.all(half[inside] > plain[inside] * (1 + 1e-3))
    assert np.all(half[inside] < all_of_them[inside] * (1 - 1e-3))
    assert half[15] - plain[15] == pytest.approx(0.5 * (all_of_them[15] - plain[15]), rel=0.1)  # to first order in the way


def by_lsoda(times: np.ndarray, speed: np.ndarray, break_away: float) -> np.ndarray:
    """Deflection by Dupont's equations 6 and 10, written anew: in units of Z, piece by piece between the corners and turns of the slip."""

    def plastic(z: float) -> float:
        if z <= break_away:
            return 0.0
        return 1.0 if z >= 1 else 0.5 + 0.5 * sin(pi * (z - 0.5 * (1 + break_away)) / (1 - break_away))

    deflections = [0.0]
    for (t0, t1), (v0, v1) in zip(pairwise(times), pairwise(speed / Z), strict=True):
        z, slope = deflections[-1], (v1 - v0) / (t1 - t0)
        turn = [t0 - v0 / slope] if v0 * v1 < 0 else []
        for start, stop in pairwise([t0, *turn, t1]):
            side = 1 if v0 + slope * (0.5 * (start + stop) - t0) > 0 else -1

            def rate(t: float, y: np.ndarray, side: int = side, t0: float = t0, v0: float = v0, slope: float = slope) -> list[float]:
                v = v0 + slope * (t - t0)
                return [v - plastic(side * y[0]) * side * v * y[0]]

            z = solve_ivp(rate, (start, stop), [z], "LSODA", rtol=1e-12, atol=1e-14, max_step=(t1 - t0) / 10).y[0, -1]
        deflections.append(float(z))
    return np.array(deflections)


def test_the_kernels_steps_hold_their_tolerance_at_the_gate() -> None:
    """Slips that swing ever less, given at their corners only, so that every step is the kernel's own choice; against LSODA at 1e-12.
    Down to 1e-5 the worst stays within 20 tolerances of the break-away force. A step is chosen from the change that a lower order makes,
    (10 tolerance)^0.6, whose power 5/3 it hopes for; where it ends just past the corner of the gate it gets the change itself, and so
    the worst below is a share of that. All together fall by a power between 0.6 and 1 of the tolerance."""
    times, tolerances = np.arange(0, 1.21, 0.05), 10.0 ** -np.arange(3, 9)
    errors = []
    for break_away, phase in ((0.3, 0.0), (0.7, 1.0), (0.95, 0.0), (0.95, 1.0)):
        speed = 80 * Z * np.cos(6 * pi * times + phase) * np.exp(-1.5 * times)
        exact = by_lsoda(times, speed, break_away)
        assert np.ptp(exact) > 1.8  # it slides both ways
        values = [{**gated(break_away), "relative_tolerance": tolerance} for tolerance in tolerances]
        z = np.array([follow(times, {"slip_velocity": speed}, each, GATE, "bristle_deflection")[0] for each in values])
        errors.append(np.max(np.abs(z / Z - exact), axis=1))
    worst, typical = np.max(errors, axis=0), np.exp(np.mean(np.log(errors), axis=0))
    assert np.all(worst[:3] < 20 * tolerances[:3]), worst
    assert np.all(worst[3:] < 0.3 * (10 * tolerances[3:]) ** 0.6), worst
    assert np.all(typical < 3 * tolerances * (1e-3 / tolerances) ** 0.25), typical
    assert 0.6 < np.polyfit(np.log(tolerances), np.log(typical), 1)[0] < 1, typical


@pytest.mark.parametrize("exponent", [0.6, 2.0, 4.0])
def test_a_gate_without_a_share_leaves_the_law_to_yield_as_it_does(exponent: float) -> None:
    """share = 0: all as in LuGre, with its presliding exponent; and in a block of contacts each goes by its own share."""
    times = np.linspace(0, 0.04, 401)
    run = Run(times, {"slip_velocity": 2e-3 * np.sin(100 * pi * times)}, ("friction_force", "dissipated_energy"))
    values: Values = {**OUTSIDE, **BARE, "sigma1": 30.0, "lugre.presliding_exponent": exponent}
    shares = np.array([0.0, 1.0, 0.0, 0.5])
    model = ContactModel(threads=1)
    together = model.simulate_many(run, GATE, {**values, "elasto_plastic.share": shares})
    for name in run.outputs:
        plain = model.simulate_many(run, (), values)[name][0]
        assert together[name][0] == pytest.approx(plain, rel=1e-6, abs=1e-7 * np.abs(plain).max()), name
        for lane, share in enumerate(shares):
            alone = model.simulate_many(run, GATE, {**values, "elasto_plastic.share": float(share)})[name]
            assert np.array_equal(together[name][lane], alone[0]), (name, share)
        gated_alike = model.simulate_many(run, GATE, {**values, "elasto_plastic.share": 1.0, "lugre.presliding_exponent": 1.0})[name]
        assert np.array_equal(together[name][1], gated_alike[0]), name
