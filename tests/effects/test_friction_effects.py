"""Does each effect on friction show the physics that it is named after? Rest, wear, heat, load, direction, speed."""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np
import pytest
from asking import OUTSIDE, begun, course, follow, line
from driving import Values

# One friction level, bristles that break away after 10 um, no damping: what changes is the effect's.
LEVEL: dict[str, float | str] = {**OUTSIDE, "friction_law": "lugre", "sigma0": 1e6, "F_C": 10.0, "F_S": 10.0, "sigma1": 0.0, "sigma2": 0.0}
CURVE = {**LEVEL, "F_C": 8.0, "F_S": 12.0, "v_s": 1e-2, "sigma2": 1.5}
REACH = 1e-5  # m


def steady(speed: float, values: Values, on: tuple[str, ...] = ()) -> float:
    """Friction force after 40 break-away ways at this slip velocity: what came before has decayed to exp(-25) at the least."""
    contact = begun({**values, "slip_velocity": speed}, on)
    contact.advance(40 * REACH / abs(speed))
    return contact.get("friction_force")


def curve(speeds: np.ndarray, values: Values, on: tuple[str, ...] = ()) -> np.ndarray:
    return np.array([steady(float(speed), values, on) for speed in speeds])


# Rest: contacts that grow with the logarithm of time.

DWELL = ("dwell_strengthening",)
AGEING = {"v_s": 100.0, "dwell_strengthening.beta": 0.04, "dwell_strengthening.t_ref": 1e-2, "dwell_strengthening.D_c": 1.0}


def after_rest(rest: float, speed: float, ways: float = 20, **values: float) -> np.ndarray:
    """Friction force over the way of a slip that sets in after a rest; 50 samples a break-away way."""
    contact = begun({**LEVEL, **AGEING, **{f"dwell_strengthening.{name}": value for name, value in values.items()}}, DWELL)
    contact.advance(rest)
    contact.set("slip_velocity", speed)
    force: np.ndarray = course(contact, rest + np.arange(0, 50 * ways + 1) * REACH / 50 / speed, "friction_force")[0]
    return force


def test_static_friction_grows_in_equal_steps_for_each_decade_of_rest() -> None:
    """The first peak after a rest, by slip that hardly renews the contact (2e-4 of D_c): beta F_S ln 10 a decade."""
    peaks = np.array([after_rest(rest, speed=0.1).max() for rest in (1.0, 10.0, 100.0, 1000.0, 1e4)])
    assert np.diff(peaks) == pytest.approx([0.04 * 10 * log(10)] * 4, rel=6e-3)  # 1 + 100 is not 100 yet
    assert peaks[-1] == pytest.approx(10 * (1 + 0.04 * log(1e4 / 1e-2)), rel=1e-3)


def test_a_rest_shorter_than_the_reference_time_does_nothing() -> None:
    """Below t_ref growth is in proportion to the rest, and small; at t_ref it is ln 2 of a step of e."""
    short = [after_rest(rest, speed=1.0, ways=40, t_ref=1e4).max() - 10 for rest in (1.0, 10.0, 100.0, 1e4)]
    assert short[:3] == pytest.approx([0.4 * 1e-4, 0.4 * 1e-3, 0.4 * 1e-2], rel=6e-3)  # ln(1 + x) = x - x^2/2
    assert short[3] == pytest.approx(0.4 * log(2), rel=1e-3)


def test_what_rest_has_built_is_forgotten_along_the_renewal_length() -> None:
    """The age falls as exp(-s/D_c), so the logarithm of it, and with it the force, falls on a straight line over the way: beta F_S/D_c;
    and is all gone after the ten lengths that a rest of e^10 t_ref is worth."""
    D_c = 100 * REACH
    force = after_rest(1e-6 * np.exp(14), speed=1.0, ways=2000, t_ref=1e-6, D_c=D_c)
    way = np.arange(force.size) * REACH / 50
    line_of = (way > 0.5 * D_c) & (way < 3 * D_c)
    fit = np.polyfit(way[line_of] / D_c, force[line_of] - 10, 1)
    # the slip's own age D_c/v is 1e-3 t_ref e^14 above; the bristle lags the line by its reach, a hundredth of D_c
    assert fit[0] == pytest.approx(-0.4, rel=0.02)
    assert force[50:].max() < 10 + 0.4 * 14
    assert force[-1] == pytest.approx(10 + 0.4 * log(1 + D_c / 1e-6), abs=4e-4)  # (v/v_s)^2 of 2.76 N


def test_slip_of_any_speed_has_the_age_of_its_renewal_length() -> None:
    """Steady slip: the age is D_c/v, so friction falls by beta F_S ln 10 for each decade of speed, and at speed nothing is left of it."""
    values = {**LEVEL, **AGEING, "dwell_strengthening.D_c": 2 * REACH, "dwell_strengthening.t_ref": 1e-3}
    slow, fast = curve(np.array([1e-7, 1e-6, 1e-5]), values, DWELL), curve(np.array([-10.0, 2.0, 20.0]), values, DWELL)
    assert np.diff(slow) == pytest.approx([-0.4 * log(10)] * 2, rel=1e-3)
    assert fast == pytest.approx([-10, 10, 10], rel=0.04 * 2 * REACH / 2e-3)


def test_a_contact_that_opens_begins_anew() -> None:
    contact = begun({**LEVEL, **AGEING}, DWELL)
    contact.advance(100.0)
    contact.set("uncut_thickness", -1e-4)
    contact.advance(1.0)
    contact.set("uncut_thickness", 1e-4)
    contact.set("slip_velocity", 1.0)
    peak = course(contact, 101 + np.linspace(0, 1e-3, 1001), "friction_force").max()
    assert 10 < peak < 10 + 0.4 * 2e-3 / 1e-2


# Wear: the way counts, not the time.

WEAR = ("friction_wear",)
WORN = {**LEVEL, "friction_wear.s_0": 0.1}


@pytest.mark.parametrize("delta", [-0.5, 0.3])
def test_wear_takes_a_way_to_two_thirds_and_then_saturates(delta: float) -> None:
    """63 % of the change after s_0, half after s_0 ln 2, all in the end."""
    ways = np.array([0.1 * log(2), 0.1, 2.0])
    times = np.concatenate([[0.0], ways / 0.5])
    force = follow(times, {"slip_velocity": np.full(4, 0.5)}, {**WORN, "friction_wear.delta": delta}, WEAR, "friction_force")[0, 1:]
    # the bristle lags by its reach, 1e-4 of s_0
    assert (force / 10 - 1) / delta == pytest.approx([0.5, 1 - np.exp(-1), 1], abs=2e-4)


def test_wear_counts_the_way_in_both_directions_and_no_time() -> None:
    """The same 0.08 m: fast, slowly, with a rest of an hour, and to and fro with as much of it backwards."""
    motions = {
        "fast": ([0, 0.008], [10, 10]),
        "slowly": ([0, 80], [1e-3, 1e-3]),
        "rested": ([0, 0.04, 0.0400001, 3600, 3600.0000001, 3600.04], [1, 1, 0, 0, 1, 1]),
        "to and fro": ([0, 0.02, 0.0200001, 0.0599999, 0.06, 0.08], [1, 1, -1, -1, 1, 1]),
    }
    force = {
        name: follow(np.array(times, float), {"slip_velocity": np.array(speed, float)}, WORN, WEAR, "friction_force")[0, -1]
        for name, (times, speed) in motions.items()
    }
    assert force["fast"] > 11
    for name in motions:
        assert force[name] == pytest.approx(force["fast"], rel=1e-6), name


# Heat.

LAG = ("proxy_lag",)


def test_the_temperature_takes_its_time_constant_for_a_step() -> None:
    T = 0.02
    contact = begun({**LEVEL, "proxy_source": "proxy_speed", "proxy_speed": 2.0, "proxy_lag.time_constant": T}, LAG)
    rise = course(contact, T * np.array([0, 1, 3, 40]), "theta_used")[0]
    assert rise == pytest.approx(2 * (1 - np.exp([0, -1, -3, -40])), abs=1e-9)
    contact.set("proxy_speed", 0.5)
    fall = course(contact, 40 * T + T * np.array([0, log(2), 40]), "theta_used")[0]
    assert fall == pytest.approx([2, 1.25, 0.5], rel=1e-9)


@pytest.mark.parametrize("w_T", [0.1, 1.0, 10.0])
def test_the_temperature_follows_a_sinusoid_late_and_less(w_T: float) -> None:
    """A first-order low pass: amplitude 1/sqrt(1 + (w T)^2), phase -atan(w T), the mean unchanged. 1e-4: 400 straight pieces a cycle."""
    f, T = 50.0, w_T / (2 * pi * 50.0)
    cycles = int(np.ceil(20 * T * f)) + 1  # the start has died out to e^-20
    times = np.arange(400 * (cycles + 1) + 1) / (400 * f)
    given_speed = 1 + 0.8 * np.cos(2 * pi * f * times)
    values = {**LEVEL, "proxy_source": "proxy_speed", "proxy_lag.time_constant": T}
    theta = follow(times, {"proxy_speed": given_speed}, values, LAG, "theta_used")[0]
    last = slice(-401, -1)
    assert line(f, times[last], theta[last]) == pytest.approx(0.8 / (1 + 1j * w_T), abs=1e-4)
    assert theta[last].mean() == pytest.approx(1, abs=1e-6)


HOT = {**CURVE, "proxy_source": "proxy_speed", "theta_ref": 0.5}


def test_a_hot_film_thins_by_equal_factors_for_equal_rises() -> None:
    """What is viscous halves again and again; nothing is left of it in the end; what is not viscous stays. Cold it is as without."""
    viscous = {
        theta: steady(2.0, {**HOT, "proxy_speed": theta, "thermal_viscosity.beta": log(2)}, ("thermal_viscosity",)) - 8
        for theta in (0.0, 0.5, 1.0, 1.5, 30.0)
    }
    assert viscous[0.0] == pytest.approx(1.5 * 2, rel=1e-9)
    assert [viscous[0.5] / viscous[0.0], viscous[1.0] / viscous[0.5], viscous[1.5] / viscous[1.0]] == pytest.approx([0.5] * 3, rel=1e-8)
    assert viscous[30.0] == pytest.approx(0, abs=1e-9)


SOFT = ("thermal_softening",)
SOFTER = {**HOT, "thermal_softening.k_Q": 1e5, "thermal_softening.Q": 1.7}


def stiffness(theta: float, values: Values) -> float:
    """Force over way in the first ten thousandth of the break-away way; LuGre's own bend of as much is taken off."""
    way = 1e-4 * REACH
    times = np.array([0, way / 1e-3])
    values = {**values, "sigma2": 0.0, "proxy_speed": theta}
    return float(follow(times, {"slip_velocity": np.full(2, 1e-3)}, values, SOFT, "friction_force")[0, -1]) / way


def test_bristles_soften_by_a_power_of_the_temperature_down_to_a_floor() -> None:
    """Cold: as without. The loss is a straight line of slope Q in logarithms. Never negative: a thousandth of sigma0 stays."""
    cold, *softer = (stiffness(theta, SOFTER) for theta in (0.0, 0.1, 0.2, 0.4, 0.8))
    assert cold == pytest.approx(1e6, rel=1e-4)
    assert np.diff(np.log(cold - np.array(softer))) == pytest.approx([1.7 * log(2)] * 3, rel=1e-3)
    assert stiffness(50.0, SOFTER) == pytest.approx(1e-3 * cold, rel=1e-3)


def test_softening_shows_in_steady_sliding_only_if_the_rate_keeps_its_stiffness() -> None:
    """rate_stiffness = thermal: softer bristles bend further, and the Stribeck curve stays. reference: the force falls as the stiffness."""
    values = {**SOFTER, "sigma2": 0.0, "proxy_speed": 1.0}
    softness = stiffness(1.0, SOFTER) / stiffness(0.0, SOFTER)
    assert softness == pytest.approx(1 - 0.1 * 2**1.7, rel=1e-3)
    assert steady(0.2, values) == pytest.approx(8, rel=1e-9)
    assert steady(0.2, {**values, "rate_stiffness": "thermal"}, SOFT) == pytest.approx(8, rel=1e-9)
    assert steady(0.2, {**values, "rate_stiffness": "reference"}, SOFT) == pytest.approx(8 * softness, rel=1e-4)


def test_thermal_damping_is_in_the_first_jolt_and_not_in_steady_sliding() -> None:
    """A slip that sets in at once meets bristles that are not bent yet: all of the force is damping, and goes by a power of the
    temperature; as without where theta = theta_ref. Once the slip is steady there is none."""
    values = {**HOT, "sigma1": 20.0, "sigma2": 0.0, "damping_mode": "as_published", "thermal_damping.alpha2": 0.6}

    def jolt(theta: float, on: tuple[str, ...] = ("thermal_damping",)) -> float:
        return begun({**values, "proxy_speed": theta, "slip_velocity": 1e-3}, on).get("friction_force")

    assert jolt(0.5) == jolt(0.5, ()) == pytest.approx(20 * 1e-3, rel=1e-12)
    hotter = np.log([jolt(theta) for theta in (0.25, 0.5, 1.0, 2.0)])
    assert np.diff(hotter) == pytest.approx([0.6 * log(2)] * 3, rel=1e-9)
    steadily = [steady(0.2, {**values, "proxy_speed": theta}, ("thermal_damping",)) for theta in (0.25, 2.0)]
    assert steadily == pytest.approx([8, 8], rel=1e-9)


@pytest.mark.parametrize("kinematics", ["external", "internal"])
def test_a_contact_that_starts_cold_warms_up_to_its_damping(kinematics: str) -> None:
    """From theta = 0, where a power below 1 is steepest: what friction has beyond its bristles' spring, per rate of deflection, goes by
    that power of the temperature that has been reached, over four decades; and the start takes no more than some steps."""
    own: Values = {"proxy_lag.time_constant": 1e-3, "thermal_damping.alpha2": 0.05, "proxy_source": "proxy_speed", "proxy_speed": 0.3}
    values: Values = {"kinematics": kinematics, "slip_velocity": 0.1 if kinematics == "external" else 0.0, "damping_mode": "as_published"}
    contact = begun({**values, **own, "sigma0": 1e4, "sigma1": 20.0, "sigma2": 0.0}, ("thermal_damping", "proxy_lag"))
    names = ("theta_used", "friction_force", "bristle_deflection", "bristle_rate")
    theta, F, z, rate = course(contact, np.concatenate([[0], 10.0 ** -np.arange(10.0, 5.5, -0.5)]), *names)[:, 1:]
    assert np.polyfit(np.log(theta), np.log((F - 1e4 * z) / rate), 1)[0] == pytest.approx(0.05, abs=1e-6)
    assert np.ptp(np.log10(theta)) > 3.9
    assert contact.get("step_count") < 1000


# Load, direction, speed.


@pytest.mark.parametrize("n", [0.0, 2 / 3, 1.0, 1.6])
@pytest.mark.parametrize("speed", [1e-5, -1.0])  # at F_S, at F_C
def test_friction_goes_by_a_power_of_the_load(n: float, speed: float) -> None:
    """Over four decades of load, a straight line of slope n in logarithms, through the force without the effect at N_ref."""
    values = {**CURVE, "sigma2": 0.0, "load_dependence.n": n, "load_dependence.N_ref": 5.0}
    loads = 5 * 10.0 ** np.arange(-2, 3)
    # more load bends the bristles further: here up to 100^1.6 break-away ways
    times = np.array([0, 40 * 1.2e-5 * 2000 / abs(speed)])

    def force(load: float) -> float:
        inputs = {"slip_velocity": np.full(2, speed), "normal_load": np.full(2, load)}
        return float(follow(times, inputs, values, ("load_dependence",), "friction_force")[0, -1])

    forces = np.array([force(float(load)) for load in loads])
    assert np.diff(np.log(np.abs(forces))) == pytest.approx([n * log(10)] * 4, abs=1e-6)
    assert forces[2] == pytest.approx(steady(speed, {**CURVE, "sigma2": 0.0}), rel=1e-6)


def test_friction_follows_a_load_that_swings() -> None:
    """Amontons' law, n = 1: while sliding the force is the load times a constant at each moment, within the bristle's reach of way."""
    times = np.linspace(0, 1, 401)
    load = 10 * (1 + 0.5 * np.sin(2 * pi * 3 * times))
    values = {**LEVEL, "load_dependence.n": 1.0, "load_dependence.N_ref": 10.0}
    force = follow(times, {"slip_velocity": np.full(401, 1.0), "normal_load": load}, values, ("load_dependence",), "friction_force")[0]
    assert force[1:] == pytest.approx(load[1:], abs=10 * 0.5 * 6 * pi * REACH * 2)


LEAN = ("direction_asymmetry",)


def test_the_even_part_of_friction_is_the_asymmetry() -> None:
    """Under reversal of the slip the odd part of the force is as without the effect; the even part is a share of it, a of what is
    Coulomb or static and a_viscous of what is viscous."""
    speeds = np.array([1e-5, 1e-2, 0.5, 3.0])
    viscous = 1.5 * speeds
    base = curve(speeds, CURVE)
    values = {**CURVE, "direction_asymmetry.a": 0.2, "direction_asymmetry.a_viscous": -0.3}
    ahead, back = curve(speeds, values, LEAN), curve(-speeds, values, LEAN)
    assert (ahead - back) / 2 == pytest.approx(base, rel=1e-8)
    assert (ahead + back) / 2 == pytest.approx(0.2 * (base - viscous) - 0.3 * viscous, rel=1e-8)


def test_a_lean_to_the_other_side_is_the_mirror_image() -> None:
    """Slip and lean turned round: the force is turned round at every moment, presliding and reversals with it."""
    times = np.linspace(0, 1, 301)
    speed = 1e-3 * np.sin(2 * pi * 4 * times + 0.3) + 3e-4
    force, mirrored = (
        follow(times, {"slip_velocity": side * speed}, {**CURVE, "direction_asymmetry.a": side * 0.4}, LEAN, "friction_force")[0]
        for side in (1, -1)
    )
    assert np.ptp(force) > 15
    assert np.array_equal(force, -mirrored)
    assert abs(force[100:].max() + force[100:].min()) > 0.5 * 0.4 * 24  # the loop is shifted by a F_S, here 12 N


STRIBECK = ("stribeck",)


def test_the_stribeck_effect_raises_slow_friction_and_leaves_the_fast() -> None:
    """On a nominal model without one: the rise at rest, half of it at v_s sqrt(ln 2), an e-th at v_s, none at speed; odd in the slip."""
    speeds = 1e-2 * np.array([1e-4, sqrt(log(2)), 1, 10])
    values = {**LEVEL, "v_s": 1e-2, "stribeck.rise": 4.0}
    assert curve(speeds, values, STRIBECK) - 10 == pytest.approx([4, 2, 4 / np.e, 0], abs=1e-6)
    assert curve(-speeds, values, STRIBECK) == pytest.approx(-curve(speeds, values, STRIBECK), rel=1e-12)


def test_the_ratio_of_stribeck_velocities_stretches_the_curve() -> None:
    """The same rise at a speed that is three times as high."""
    values = {**LEVEL, "v_s": 1e-2, "stribeck.rise": 4.0}
    speeds = np.array([2e-3, 1e-2, 1.5e-2])
    wide = curve(3 * speeds, {**values, "stribeck.v_s_ratio": 3.0}, STRIBECK)
    assert wide == pytest.approx(curve(speeds, values, STRIBECK), rel=1e-8)
    assert np.ptp(wide) > 3


def test_viscous_friction_is_a_straight_slope_and_nothing_at_rest() -> None:
    """The steady curve gains the same slope everywhere, on both sides of rest, where it gains nothing."""
    speeds = np.array([-5.0, -0.02, -1e-6, 1e-6, 0.02, 0.5, 5.0])
    more = curve(speeds, {**CURVE, "viscous_friction.coefficient": 2.5}, ("viscous_friction",)) - curve(speeds, CURVE)
    assert more / speeds == pytest.approx(np.full(7, 2.5), rel=1e-3)  # at the slowest, of 12 N: rounding
    resting = begun({**CURVE, "viscous_friction.coefficient": 2.5}, ("viscous_friction",))
    assert resting.get("friction_force") == 0
