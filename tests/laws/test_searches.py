"""Does each search end where it has arrived, and not before? Its own equation, to rounding or to the tolerance that it states."""

from __future__ import annotations

from math import acos, cos, pi, sin

import numpy as np
import pytest
from driving import AMPLITUDE, ELLIPSE, OMEGA, PERIOD, Values, at_angle, at_speed_ratio, events, read, started
from evat.native import kernel
from scipy.optimize import brentq

STATES = {effect.name: tuple(state.name for state in effect.states) for effect in kernel.effects() if effect.states}
GOES_ON = ("position_dependence.position",)  # from cycle to cycle: no state of it comes back
KEPT = {name for name in STATES if name != "dwell_strengthening"}  # of which a separation lets nothing outlive it


@pytest.mark.parametrize("alpha", [0.0, 0.15])
@pytest.mark.parametrize("law", kernel.variable("friction_law").choices)
def test_slip_and_shear_angle_belong_to_each_other(law: str, alpha: float) -> None:
    """chip_flow_angle = current_shear_angle: v = V(phi(F(v))) at any angle of the cut, also where the law jumps at the slip found."""
    own: Values = {"friction_law": law, "chip_flow_angle": "current_shear_angle", "rake_angle": alpha, "F_C": 30.0, "F_S": 30.0}
    r, sticking = 0.3, 0
    for psi in np.linspace(-0.6, 1.5, 43):
        v, phi = at_angle(psi, {**at_speed_ratio(r, feed=2e-5), **own}, "slip_velocity_used", "shear_angle")
        u_x, u_y = AMPLITUDE * OMEGA * (r + cos(psi)), AMPLITUDE * OMEGA * sin(psi)
        phi = max(phi, 0.02)  # flatter planes form no chip
        V_s = (u_x * cos(alpha) + u_y * sin(alpha)) / cos(phi - alpha)
        slip = V_s * sin(phi - alpha) + u_x * sin(alpha) - u_y * cos(alpha)
        assert v == pytest.approx(slip, abs=1e-12 * AMPLITUDE * OMEGA)
        sticking += abs(v) < 1e-9
    assert law != "coulomb" or sticking > 3  # where friction balances over a range of angles


def test_the_slip_that_is_followed_is_kept_over_communication_steps() -> None:
    """Friction that falls with speed leaves slip and shear angle two answers. In 100 steps a cycle each began the search anew, and the
    other one was followed from where both are: 8 % more way. A copy in mid-cycle goes on alike, to the last bit."""
    values: Values = {
        "chip_flow_angle": "current_shear_angle", "cutting_speed": 0.225222, "F_C": 1.97181, "F_S": 5.61852, "v_s": 0.128739,
        "sigma1": 84.579, "feed": 3.20166e-5, "shear_stress": 80937117.0,
    }  # fmt: skip
    names = ("friction_impulse", "dissipated_energy", "sliding_distance")
    slid = {}
    for parts in (1, 10, 100):
        contact = twin = started(values)
        for _ in range(parts):
            twin = contact.copy()
            for each in (contact, twin):
                each.advance(5e-5 / parts)
        slid[parts] = read(contact, *names)
        assert (read(twin, *names) == slid[parts]).all()
    assert slid[10] == pytest.approx(slid[1], rel=3e-4)
    assert slid[100] == pytest.approx(slid[1], rel=3e-4)


@pytest.mark.parametrize("r", [0.02, 0.3, 0.9])
def test_the_surface_of_the_cycle_before_is_found_to_rounding(r: float) -> None:
    """Thickness = what stands at the same place x after the cycle before, by its own equation; close to its turning point, too, where two
    roots meet and a digit of the place is worth half a digit of the height."""
    last = acos(-r)
    top = r * last + sin(last)
    entry = brentq(lambda psi: r * (pi + psi) + sin(psi), -pi * (1 - 1e-6 * r), -1e-6, xtol=1e-15)
    ends = brentq(lambda psi: r * (psi + 2 * pi) + sin(psi) - top, entry, last, xtol=1e-15)  # beyond it the nominal surface stands
    checked = 0
    for psi in [*np.linspace(entry + 1e-3, ends, 40)[1:-1], ends - 1e-6]:
        X = r * (psi + 2 * pi) + sin(psi)
        chi = brentq(lambda a, X=X: r * a + sin(a) - X, -last, last, xtol=4e-16)
        (h,) = at_angle(psi, at_speed_ratio(r, feed=1e-2), "uncut_thickness_used")
        assert h / AMPLITUDE == pytest.approx(cos(psi) - cos(chi), abs=1e-12 + 4e-16 / max(top - X, 1e-15) ** 0.5)
        checked += 1
    assert checked == 39


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-8])
@pytest.mark.parametrize("r", [0.05, 0.3])
def test_an_event_is_where_its_indicator_is_zero(r: float, tolerance: float) -> None:
    """Entry and exit of a cut, just past and never before: by a thousandth of the tolerance, of a step of a twentieth of a cycle."""
    contact = started(at_speed_ratio(r, relative_tolerance=tolerance), time=PERIOD / 2)
    turned = [t for t, before, after in events(contact, PERIOD, "in_contact") if before[0] != after[0]]
    entry = brentq(lambda psi: r * (pi + psi) + sin(psi), -pi * (1 - 1e-6 * r), -1e-6, xtol=1e-15)
    late = np.array(turned) / PERIOD - 1 - np.array([entry, acos(-r)]) / (2 * pi)
    assert np.all(late > -1e-15)
    assert np.all(late < 1e-3 * tolerance / 20 + 1e-15)


@pytest.mark.parametrize("name", sorted(KEPT))
def test_a_periodic_start_is_periodic_in_the_states_of_effects(name: str) -> None:
    """A cycle leads back to a tenth of the tolerance; and no warning says that none was found. A position goes on for ever unless
    nothing outlives a separation."""
    own_states, goes_on = STATES[name], any(state in GOES_ON for state in STATES[name])
    tolerance, states = 1e-6, ("bristle_deflection", *own_states)
    own: Values = {"initial_state": "periodic", "cutting_speed": 0.2, "release_time": 0.0 if goes_on else 1e-5}
    contact = started({**ELLIPSE, **own, "relative_tolerance": tolerance}, (name,))
    before = read(contact, *states)
    contact.advance(PERIOD)
    after = read(contact, *states)
    scale = np.maximum(np.abs(before), [10 / 1e6, *(1e-3 * kernel.variable(state).nominal for state in own_states)])
    assert np.all(np.abs(after - before) <= 0.5 * tolerance * scale)
    assert contact.warnings() == ()
    assert np.abs(before).max() > 0


def test_a_cycle_of_thousands_of_steps_is_not_searched_through() -> None:
    """Bonds break at random, 1 500 a cycle: no state comes back, and the slopes of ten states would take minutes: one cycle does."""
    values: Values = {"friction_law": "bristle", "vibration_frequency": 1300.0, "amplitude_x": 1e-4, "cutting_speed": 0.3, "sigma0": 3e6}
    values |= {"F_C": 0.4, "F_S": 0.4, "release_time": 1e-9}
    on = ("proxy_lag", "amplitude_loss", "dynamometer_resonance")
    searched, run = kernel.Contact({**values, "initial_state": "periodic"}, on), kernel.Contact(values, on)
    searched.start()
    run.start()
    run.advance(1 / 1300)
    assert run.get("step_count") > 5000
    for name in ("bristle_deflection", "dynamometer_resonance.friction_force"):
        assert searched.get(name) == pytest.approx(run.get(name), rel=1e-9), name
    assert "periodic" in " ".join(searched.warnings())


def test_a_search_that_comes_no_nearer_leaves_the_nearest() -> None:
    """A stiff bristle rings the dynamometer, whose cycles differ by the errors of their steps: slopes lead on to cycles that miss more."""
    motion: Values = {
        "vibration_frequency": 493.3277103685363,
        "amplitude_x": 2.4370141544172218e-06,
        "amplitude_y": 5.9473420587962945e-06,
    }
    motion |= {"cutting_speed": 0.0109627892, "feed": 0.00012208689080684342, "phase_x": -1.6149580898964702, "phase_y": 3.0496424144611995}
    motion |= {"rake_angle": -0.03380768010858137, "chip_flow_shear_angle": 0.33143300388606356}
    law: Values = {"sigma0": 962800.0, "sigma1": 51090.0, "sigma2": 0.954, "F_C": 8.97, "F_S": 7.49, "v_s": 0.0001645}
    law |= {"damping_mode": "as_published", "lugre.presliding_exponent": 2.167281696465162, "lugre.viscous_exponent": 1.563475010590384}
    law |= {"direction_asymmetry.a": 0.04999793933600651, "direction_asymmetry.a_viscous": 0.02759113736170616}
    law |= {"dynamometer_resonance.natural_period": 0.0001605032585974962, "dynamometer_resonance.damping_ratio": 0.05066866238388084}
    own: Values = {"initial_state": "periodic", "relative_tolerance": 1e-4, "shear_angle_principle": "minimum_energy"}
    contact = kernel.Contact({**motion, **law, **own}, ("direction_asymmetry", "dynamometer_resonance"))
    contact.start()
    names = [name for name in STATES["dynamometer_resonance"] if not name.endswith("rate")]
    assert "periodic" in " ".join(contact.warnings())
    before = read(contact, *names)
    contact.advance(1 / motion["vibration_frequency"])
    assert np.all(np.abs(read(contact, *names) - before) < 0.01 * np.abs(before).max())
