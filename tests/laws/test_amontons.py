"""Is friction mu N, with the load that is given and with that of the chip, and has a chip that cannot slide a finite answer?"""

from __future__ import annotations

from math import atan, cos, pi, sin, tan

import evat
import numpy as np
import pytest
from driving import PERIOD, Values, at_speed_ratio, read, started
from evat.native import kernel

LAW: Values = {"friction_law": "amontons", "relative_tolerance": 1e-6}
SHEAR_LOAD = 1e-3 * 4e8 * 1e-4  # N
GIVEN: Values = {**LAW, "kinematics": "external", "width": 1e-3, "shear_stress": 4e8, "uncut_thickness": 1e-4}


def test_under_a_given_load_friction_is_mu_of_it_and_nothing_else() -> None:
    times = np.linspace(0, 1, 101)
    slip, load = np.cos(2 * pi * times + 0.1), 10 - 10 * np.cos(6 * pi * times)
    contact = started({**GIVEN, "amontons.mu": 0.3, "slip_velocity": float(slip[0]), "normal_load": 0.0})
    rows = contact.run(times, {"slip_velocity": slip, "normal_load": load}, ("friction_force", "dissipated_power"))
    assert rows[:, 0] == pytest.approx(0.3 * load * np.sign(slip), rel=1e-12, abs=1e-12)
    assert rows[:, 1] == pytest.approx(0.3 * load * np.abs(slip), rel=1e-12, abs=1e-12)


def test_friction_that_rises_less_than_in_proportion_is_a_load_dependence_of_a_negative_exponent() -> None:
    """An elastic round contact: mu falls by the third root of the load, and force rises by the square of it (Archard 1957)."""
    load, times = np.array([1.0, 2.0, 10.0, 40.0, 80.0]), np.arange(5.0)
    values = {**GIVEN, "amontons.mu": 0.3, "load_dependence": True, "load_dependence.n": -1 / 3, "load_dependence.N_ref": 10.0}
    force = evat.simulate(values, times=times, inputs={"slip_velocity": np.full(5, 0.1), "normal_load": load})["friction_force"]
    assert force == pytest.approx(0.3 * 10 * (load / 10) ** (2 / 3), rel=1e-9)


def test_a_load_that_nobody_gives_is_asked_for() -> None:
    """In place of the 10 N that stand at the start, by every way to run a contact; where the chip gives it nothing is asked."""
    values, times = {"friction_law": "amontons", "kinematics": "external"}, np.linspace(0, 1, 11)
    slip = {"slip_velocity": np.ones(11)}
    run = evat.Run(times, slip, ("friction_force",))
    asks = r"friction_law = amontons takes its force from the input normal_load \(.*\), and this run has neither a column nor a value of it"
    with pytest.raises(evat.ParameterError, match=asks):
        evat.simulate(values, times=times, inputs=slip)
    with pytest.raises(evat.ParameterError, match=asks):
        evat.run_many(run, {**values, "amontons.mu": np.array([0.1, 0.2])})
    assert evat.ContactModel().missing_inputs((), values, ("slip_velocity",)) == {"normal_load": ["friction_law = amontons"]}
    given = evat.simulate({**values, "normal_load": 4.0}, times=times, inputs=slip)
    assert given["friction_force"] == pytest.approx(2.0)
    evat.simulate({**values, "kinematics": "internal"}, cycles=1)


@pytest.mark.parametrize("chip_flow_angle", ["constant", "current_shear_angle"])
@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
@pytest.mark.parametrize("rake", [-0.3, 0.0, 0.2])
def test_on_the_rake_face_it_is_mu_of_the_normal_force_that_comes_with_it(rake: float, principle: str, chip_flow_angle: str) -> None:
    """At both ways of slip over a vibration cycle, from entry to exit; no friction where no chip is."""
    values = {**at_speed_ratio(0.4, feed=4e-5), **LAW, "amontons.mu": 0.4, "rake_angle": rake, "shear_angle_principle": principle}
    contact = started({**values, "chip_flow_angle": chip_flow_angle})
    rows = contact.run(np.linspace(0, 2 * PERIOD, 801), {}, ("friction_force", "normal_force", "slip_velocity_used", "in_contact"))
    F, N, v, touching = rows.T
    assert 100 < np.count_nonzero(touching) < 750
    slides = (np.abs(v) > 1e-9) & (touching > 0)
    assert F[slides] == pytest.approx((0.4 * N * np.sign(v))[slides], rel=1e-9, abs=1e-9)
    assert np.all(F[touching == 0] == 0)
    assert min(np.count_nonzero(F > 0), np.count_nonzero(F < 0)) > 20


@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
def test_the_shear_angle_is_that_of_the_friction_angle(principle: str) -> None:
    """Merchant's circle: with mu = tan(beta) the resultant is k/(sin(phi) cos(phi + beta - alpha))."""
    beta, alpha = atan(0.5), 0.15
    phi = pi / 4 - (beta - alpha) * (0.5 if principle == "minimum_energy" else 1)
    R = SHEAR_LOAD / sin(phi) / cos(phi + beta - alpha)
    values = {**at_speed_ratio(1, feed=1e-4), **LAW, "amplitude_x": 0.0, "amplitude_y": 0.0, "rake_angle": alpha}
    contact = started({**values, "shear_angle_principle": principle, "width": 1e-3, "shear_stress": 4e8, "cutting_speed": 1.0})
    contact.evaluate()
    F, N, angle = read(contact, "friction_force", "normal_force", "shear_angle")
    assert pytest.approx([R * sin(beta), R * cos(beta)], rel=1e-12) == [F, N]
    assert angle == pytest.approx(phi, rel=1e-12)


@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
@pytest.mark.parametrize("rake", [-0.7, 0.0, 0.7])
def test_a_chip_that_cannot_slide_is_held_at_the_flattest_shear_plane(rake: float, principle: str) -> None:
    """mu = 10 asks for a shear plane below the surface; 0.02 rad is the flattest that there is."""
    values = {**at_speed_ratio(1, feed=1e-4), **LAW, "amplitude_x": 0.0, "amplitude_y": 0.0, "rake_angle": rake, "cutting_speed": 1.0}
    contact = started({**values, "shear_angle_principle": principle, "amontons.mu": kernel.variable("amontons.mu").max})
    contact.evaluate()
    F, N, angle = read(contact, "friction_force", "normal_force", "shear_angle")
    assert angle >= 0.02 * (1 - 1e-9)
    assert 0 < F <= 10 * N * (1 + 1e-12)
    if principle == "maximum_shear_stress":
        assert angle == pytest.approx(0.02, rel=1e-9)


@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
@pytest.mark.parametrize("rake", [-0.6, -0.2, 0.2, 0.6])
@pytest.mark.parametrize("mu", [0.5, 2.0, 10.0])
def test_against_the_flow_no_friction_drives_the_chip(mu: float, rake: float, principle: str) -> None:
    """It is mu N as long as the shear plane bears it, which by minimum energy is k/cos(alpha): reached where tan(alpha) < -1/mu. With
    mu tan(alpha) > 1 it did ten thousand times that once, along the slip."""
    values = {**at_speed_ratio(0.4, feed=4e-5), **LAW, "amontons.mu": mu, "rake_angle": rake, "shear_angle_principle": principle}
    contact = started({**values, "width": 1e-3, "shear_stress": 4e8})
    names = ("friction_force", "normal_force", "slip_velocity_used", "uncut_thickness_used", "dissipated_power")
    F, N, v, h, power = contact.run(np.linspace(0, PERIOD, 201), {}, names).T
    back = (v < -1e-9) & (h > 0)
    assert np.count_nonzero(back) > 10
    if principle == "minimum_energy" and mu * tan(-rake) > 1:
        assert F[back] == pytest.approx(-4e5 * h[back] / cos(rake), rel=1e-12)
    else:
        assert F[back] == pytest.approx(-mu * N[back], rel=1e-9, abs=1e-9)
    assert np.all(np.abs(F) <= mu * N * (1 + 1e-9) + 1e-12)
    assert power.min() >= 0


@pytest.mark.parametrize(
    ("effect", "values", "along", "against"),
    [
        ("direction_asymmetry", {"direction_asymmetry.a": 0.3}, 0.65, -0.35),
        ("friction_wear", {"friction_wear.s_0": 1e-6, "friction_wear.delta": 0.6}, 0.8, -0.8),
    ],
)
def test_what_raises_friction_raises_mu(effect: str, values: Values, along: float, against: float) -> None:
    """The load of the shear plane answers to the friction that acts, not to what it would be without the effect: F/N had come to -1.14."""
    traced = evat.simulate({"friction_law": "amontons", **values}, [effect], times=PERIOD * np.arange(0, 3, 0.01))
    friction, load = traced["friction_force"][200:], traced["normal_force"][200:]
    ratio = friction[load > 1] / load[load > 1]
    assert ratio[ratio > 0] == pytest.approx(along, rel=1e-5)
    assert ratio[ratio < 0] == pytest.approx(against, rel=1e-5)
    assert (ratio > 0).any()
    assert (ratio < 0).any()


@pytest.mark.parametrize("late", [0.0, 5e-6, 1e-3])
def test_a_load_that_has_come_to_nothing_is_measured_as_nothing(late: float) -> None:
    """Both ends of a step without a force, and without a level to measure its bend by: 0/0, and steps without end."""
    times = np.linspace(0, 0.02, 81)
    load = np.interp(times, [0, 0.01, 0.02], [10, 0, 0])
    contact = started({**GIVEN, "slip_velocity": 0.02, "normal_load": 10.0, "sensor_delay.time": late}, ("sensor_delay",))
    shown = contact.run(times, {"normal_load": load}, ("measured_friction_force",))[:, 0]
    assert shown == pytest.approx(0.5 * np.interp(times - late, times, load), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("effect", ["holder_compliance", "amplitude_loss"])
@pytest.mark.parametrize("phase", [1.0, 1.3])
def test_a_chip_that_ends_between_passes_over_a_step_has_an_end(effect: str, phase: float) -> None:
    """Where forces feed back, passes miss nothing of a friction that has vanished with its chip: 0/0, and steps without end. What does not
    yield leaves all as it is."""
    values = {**LAW, "phase_x": phase, "rake_angle": 0.1, "cutting_speed": 0.2}
    stiff = {name: 0.0 for name in ("holder_compliance.compliance_x", "holder_compliance.compliance_y", "amplitude_loss.kappa")}
    times, names = np.linspace(0, 1.5e-4, 31), ("friction_impulse", "dissipated_energy")
    plain = started(values).run(times, {}, names)
    assert started({**values, **stiff}, (effect,)).run(times, {}, names) == pytest.approx(plain, rel=1e-5, abs=1e-9)
    assert np.isfinite(started(values, (effect,)).run(times, {}, names)).all()
