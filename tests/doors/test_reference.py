"""Does the second writing of the laws, in plain Python, answer as physics says, and as the C kernel does?

The reference is held to printed numbers and exact answers first, so that where it and the kernel differ one knows whom to ask.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Mapping
from itertools import pairwise
from math import acos, asin, atan2, cos, hypot, pi, sin, sqrt, tan
from typing import Any

import lugre_1995 as published
import numpy as np
import pytest
from evat.models import reference
from evat.models.reference import LAWS, ContactError, ReferenceContact
from evat.native import kernel
from scipy.optimize import brentq

FREQUENCY, AMPLITUDE = 20e3, 5e-6  # Hz, m: the kernel's starts
OMEGA, PERIOD = 2 * pi * FREQUENCY, 1 / FREQUENCY
TIGHT = 1e-12  # relative_tolerance at which both are held to 1e-9: the kernel controls its steps, not what they add up to

# Section 3: HSR: entry, exit [rad], duty, cusp over amplitude; printed to four digits (five for the cusp).
TABLE = {
    0.05: (0.1501, 1.6208, 0.2819, 0.01125),
    0.1: (0.2893, 1.6710, 0.3120, 0.04154),
    0.2: (0.5459, 1.7722, 0.3689, 0.14532),
    0.3: (0.7852, 1.8755, 0.4235, 0.29272),
    0.5: (1.2461, 2.0944, 0.5317, 0.68098),
}
LUGRE_1995 = {"sigma0": 1e5, "sigma1": sqrt(1e5), "sigma2": 0.4, "F_C": 1.0, "F_S": 1.5, "v_s": 1e-3}


def complete(values: Mapping[str, Any]) -> dict[str, Any]:
    """Every start of the kernel's tables, in the words of the reference, and `values` over them."""
    starts = {
        v.name: v.choices[int(v.start)] if v.choices else v.start for v in kernel.variables() if v.causality in ("input", "parameter")
    }
    return {**starts, **dict.fromkeys(kernel.states(), 0.0), **values}


def started(values: Mapping[str, Any], time: float = 0.0) -> ReferenceContact:
    contact = ReferenceContact(complete({"relative_tolerance": TIGHT, **values}))
    contact.start(time)
    return contact


def sliding(values: Mapping[str, Any]) -> ReferenceContact:
    return started({"kinematics": "external", **values})


# ---- against printed numbers and exact answers ------------------------------------------------------------------------------------------


def entry_and_exit(values: Mapping[str, Any]) -> tuple[float, float]:
    """Angles before and behind the bottom of the path, from the time in contact of the halves of the second cycle."""
    contact = started({"friction_law": "coulomb", "relative_tolerance": 1e-4, **values})
    contact.advance(PERIOD)
    times = [contact.integral["contact_time"]]
    for _ in range(2):
        contact.advance(PERIOD / 2)
        times.append(contact.integral["contact_time"])
    assert contact.get("mean_contact_ratio") == pytest.approx((times[2] - times[0]) / PERIOD, rel=1e-14)
    return OMEGA * (times[2] - times[1]), OMEGA * (times[1] - times[0])


@pytest.mark.parametrize("r", TABLE)
def test_entry_exit_duty_and_cusp(r: float) -> None:
    theta_s, theta_e, duty, cusp = TABLE[r]
    values = {"cutting_speed": r * AMPLITUDE * OMEGA, "feed": 1e-2}
    entry, leave = entry_and_exit(values)
    assert (entry, leave) == pytest.approx((theta_s, theta_e), abs=5.1e-5)
    assert (entry + leave) / (2 * pi) == pytest.approx(duty, abs=5.1e-5)
    assert entry == pytest.approx(brentq(lambda theta: r * (pi - theta) - sin(theta), 1e-3, 3, xtol=1e-14), abs=1e-12)
    assert leave == pytest.approx(acos(-r), abs=1e-12)
    above, below = (entry_and_exit({**values, "feed": (cusp + shift) * AMPLITUDE})[0] for shift in (5.1e-6, -5.1e-6))
    assert above == pytest.approx(entry, abs=1e-12)  # cusps that stay below the nominal surface leave the entry alone
    assert below == pytest.approx(acos(1 - cusp + 5.1e-6), abs=1e-10)  # else the tool enters where it dips under that surface


@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
def test_textbook_cut(principle: str) -> None:
    """Rake 10 deg, chip 0.2 mm by 2 mm, mu = 0.5, 400 MPa: Merchant's circle, with the friction that mu gives put in as F_C."""
    alpha, k, beta = math.radians(10), 400e6 * 2e-3 * 0.2e-3, math.atan(0.5)
    phi = pi / 4 - (beta - alpha) * (1 if principle == "maximum_shear_stress" else 0.5)
    R = k / (sin(phi) * cos(phi + beta - alpha))
    values = {"rake_angle": alpha, "uncut_thickness": 0.2e-3, "width": 2e-3, "shear_stress": 400e6, "F_C": R * sin(beta)}
    contact = sliding({**values, "friction_law": "coulomb", "shear_angle_principle": principle, "slip_velocity": 1.0})
    names = ("shear_angle", "normal_force", "principal_force", "feed_force", "tool_force_x", "tool_force_y")
    F_p, F_f = R * cos(beta - alpha), R * sin(beta - alpha)
    assert [contact.get(name) for name in names] == pytest.approx([phi, R * cos(beta), F_p, F_f, -F_p, F_f], rel=1e-13)


@pytest.mark.parametrize("principle", ["maximum_shear_stress", "minimum_energy"])
def test_closed_form_has_limits_where_its_angles_have_poles(principle: str) -> None:
    """For no load, no friction, and friction that pulls: a number, and a chip that never pulls. N is continuous at f = 0 and 1e-3."""

    def N(f: float, alpha: float = 0.15) -> float:
        return reference.normal_force(F=f * 50, k=50, alpha=alpha, principle=principle)

    for near in (0.0, 1e-3, -1e-3):
        assert N(near + 1e-13) == pytest.approx(N(near - 1e-13), rel=1e-11)
    for alpha in (-0.5, 0.0, 0.5):
        for F, h in ((9.0, 0.0), (-9.0, 0.0), (9.0, 1e-12), (-9.0, 1e-6), (9.0, 1.0), (1e6, 1e-4), (-1e6, 1e-4)):
            values = {"friction_law": "coulomb", "F_C": abs(F), "slip_velocity": math.copysign(1, F), "rake_angle": alpha, "feed": 1e-2}
            contact = sliding({**values, "shear_angle_principle": principle, "uncut_thickness": max(h, 1e-15)})
            forces = [float(contact.get(name)) for name in ("normal_force", "principal_force", "feed_force", "shear_angle")]
            assert all(map(math.isfinite, forces))
            assert forces[0] >= 0


@pytest.fixture
def friction() -> published.Friction:
    bristle = sliding({**published.DRIVEN_FROM_OUTSIDE, **LUGRE_1995})

    def rates(t: float, v: float, z: float) -> tuple[float, float]:
        bristle.set("slip_velocity", v)
        bristle.z = z
        bristle.evaluate()
        return float(bristle.get("friction_force")), float(bristle.get("bristle_rate"))

    return rates


def test_presliding_displacement(friction: published.Friction) -> None:
    simulated = published.presliding(published.follow(published.presliding_plant(), friction))
    assert simulated == pytest.approx(published.PRESLIDING, abs=published.TOLERANCE["presliding"])


@pytest.mark.parametrize("rate", [1, 10, 50])
def test_break_away_force_falls_with_the_rate_of_the_force(friction: published.Friction, rate: float) -> None:
    simulated = published.break_away(published.follow(published.break_away_plant(rate), friction))
    assert simulated == pytest.approx(published.BREAK_AWAY[rate], abs=published.TOLERANCE["break_away"])


@pytest.mark.parametrize("w", published.LAG)
def test_friction_lags_the_velocity(friction: published.Friction, w: int) -> None:
    simulated = published.lag(published.follow(published.lag_plant(w), friction))
    assert simulated == pytest.approx(published.LAG[w], abs=published.TOLERANCE["lag"])


def test_stick_slip(friction: published.Friction) -> None:
    simulated = published.stick_slip(published.follow(published.stick_slip_plant(16), friction))
    assert simulated == pytest.approx(published.STICK_SLIP, abs=published.TOLERANCE["ms"])


@pytest.mark.parametrize("stiff", [1e2, 1e5, 1e8])
def test_at_constant_speed_the_bristle_is_an_exponential(stiff: float) -> None:
    """From sticking soft to 1e8 per second; the integral of the force with it. a T from 1e-3 to 1e3."""
    v, F_C, T = 0.3, 2.0, 1e-5
    sigma0 = stiff * F_C / v
    values = {"sigma0": sigma0, "sigma1": 1e-3, "sigma2": 0.7, "F_C": F_C, "F_S": F_C, "slip_velocity": v, "damping_mode": "as_published"}
    contact = sliding(values)
    contact.advance(T)
    left = math.exp(-stiff * T)
    assert contact.get("bristle_deflection") == pytest.approx(F_C / sigma0 * -math.expm1(-stiff * T), rel=1e-12)
    assert contact.get("friction_force") == pytest.approx(F_C * (1 - left) + 1e-3 * v * left + 0.7 * v, rel=1e-12)
    impulse = (F_C + 0.7 * v) * T + (1e-3 * v - F_C) / stiff * -math.expm1(-stiff * T)
    assert contact.get("friction_impulse") == pytest.approx(impulse, rel=1e-12)
    assert contact.get("dissipated_energy") == pytest.approx(v * impulse, rel=1e-12)


def test_ramp_through_reversal_is_dahls_own_answer() -> None:
    """Over the slipped way s Dahl's law is dz/ds = 1 - sgn(v) z/z0 whatever the speed: forth by s, back by s."""
    z0, rate, T = 9.0 / 1e6, 4e4, 2e-5
    contact = sliding({"friction_law": "dahl", "F_C": 9.0, "sigma0": 1e6, "slip_velocity": rate * T / 2})
    contact.slope["slip_velocity"] = -rate
    contact.advance(T)
    way = rate * (T / 2) ** 2 / 2
    turned = z0 * -math.expm1(-way / z0)
    assert contact.get("bristle_deflection") == pytest.approx(-z0 + (turned + z0) * math.exp(-way / z0), rel=1e-11)


def test_karnopp_holds_the_applied_force_within_its_band() -> None:
    """Coulomb's impulse over a ramp through zero, less the time within the band, in which the applied force stands, at most F_S."""
    rate, T, band = 4e4, 2e-5, 0.05
    values = {"friction_law": "karnopp", "F_C": 9.0, "F_S": 7.0, "karnopp.zero_velocity_band": band}
    for applied in (3.0, 50.0):
        contact = sliding({**values, "applied_force": applied, "slip_velocity": 0.3})
        contact.slope["slip_velocity"] = -rate
        contact.advance(T)
        times = (0.3 - band) / rate, 2 * band / rate
        exact = 9.0 * times[0] + min(applied, 7.0) * times[1] - 9.0 * (T - sum(times))
        assert contact.get("friction_impulse") == pytest.approx(exact, abs=1e-13 * 9.0 * T)


def test_reset_integrator_peaks_at_F_S_and_slides_at_F_C() -> None:
    contact = sliding({"friction_law": "reset_integrator", "sigma1": 0.0, "F_C": 9.0, "F_S": 12.0, "sigma0": 1e6, "slip_velocity": 0.1})
    z0 = 9.0 / 1e6
    contact.advance(z0 / 0.1 * (1 - 1e-9))
    assert contact.get("friction_force") == pytest.approx(12.0, rel=2e-9)
    contact.advance(z0 / 0.1)
    assert contact.get("friction_force") == pytest.approx(9.0, rel=1e-14)
    assert contact.get("bristle_deflection") == pytest.approx(z0, rel=1e-14)
    assert contact.get("friction_impulse") == pytest.approx((12.0 / 2 + 9.0) * z0 / 0.1, rel=1e-8)  # 1e-9 of z0 short of two times z0/v


@pytest.mark.parametrize("law", LAWS)
def test_mirrored_slip_mirrors_the_force(law: str) -> None:
    impulses = []
    for sign in (1, -1):
        contact = sliding({"friction_law": law, "slip_velocity": sign * 0.4, "applied_force": sign * 2.0})
        contact.slope["slip_velocity"] = sign * -4e4
        for _ in range(7):
            contact.advance(3e-6)
            impulses.append(sign * float(contact.get("friction_impulse")))
    assert impulses[:7] == pytest.approx(impulses[7:], rel=1e-14)


def test_coulomb_chip_that_flows_along_the_current_angle_sticks_at_reversal() -> None:
    """Between F_C and -F_C a range of frictions, and so of shear angles, belongs to v = 0: the chip sticks, V(phi(F)) = 0."""
    contact = started({"friction_law": "coulomb", "chip_flow_angle": "current_shear_angle", "relative_tolerance": 1e-6})
    stuck = 0
    for n in range(1, 21):
        contact.advance(0.7e-6)
        if contact.get("in_contact") and contact.get("slip_velocity_used") == 0:
            stuck += 1
            turn = OMEGA * 0.7e-6 * n
            flow = (0.16666666666666666 + AMPLITUDE * OMEGA * cos(turn)) * tan(float(contact.get("shear_angle"))) - AMPLITUDE * OMEGA * sin(
                turn
            )
            assert abs(float(contact.get("friction_force"))) < 9.0
            assert flow == pytest.approx(0, abs=1e-12)
    assert 1 <= stuck <= 5
    assert contact.get("friction_force") == -9.0


# ---- against the kernel ------------------------------------------------------------------------------------------------------------------

# Alongside: the kernel chooses its steps for deflection and forces.
INTEGRATED = (
    "dissipated_energy",
    "shear_energy",
    "recent_dissipated_energy",
    "recent_shear_energy",
    "sliding_distance",
    "mean_dissipated_power",
    "mean_shear_power",
)
SHOWN = [
    v.name
    for v in kernel.variables()
    if v.causality in ("output", "local")
    and v.name not in ("step_count", "clamped_count", *INTEGRATED)
    and "." not in v.name  # states of effects that the reference does not have
]


def both(values: Mapping[str, Any], steps: list[float], slopes: Mapping[str, float] | None = None) -> dict[str, np.ndarray]:
    """Every output of reference and kernel at the start and after each step: name -> shape (2, n)."""
    values = {"relative_tolerance": TIGHT, **values}
    python, c = started(values), kernel.Contact(values)
    python.slope = dict(slopes or {})
    times = np.cumsum([0.0, *steps])
    c.start()
    names = [*SHOWN, *INTEGRATED]
    columns = {name: c.get(name) + slope * times for name, slope in python.slope.items()}
    rows = [[float(python.get(name)) for name in names]]
    for step in steps:
        python.advance(step)
        rows.append([float(python.get(name)) for name in names])
    in_c = c.run(times, columns, names)
    return {name: np.array([[row[n] for row in rows], in_c[:, n]]) for n, name in enumerate(names)}


def assert_same(answers: Mapping[str, np.ndarray], tolerance: float = 1e-9) -> None:
    """Relative to the largest value that a variable takes. Energy and distance are looser: the kernel chooses its steps for deflection
    and forces."""
    for name, (python, c) in answers.items():
        bound = (100 * tolerance if name in INTEGRATED else tolerance) * max(float(np.abs(c).max()), 1e-300)
        miss = float(np.abs(python - c).max())
        assert miss <= bound, name


CYCLE = [1.3e-6] * 45
SETTINGS: dict[str, dict[str, Any]] = {
    "starts": {},
    "minimum energy, positive rake": {"rake_angle": 0.2, "shear_angle_principle": "minimum_energy"},
    "negative rake, bristles relax": {"rake_angle": -0.2, "cutting_speed": 0.5, "release_time": 1e-5},
    "no separation": {"cutting_speed": 1.0},
    "nominal surface binds, periodic": {"feed": 2e-6, "initial_state": "periodic"},
    "thermal effects": {"thermal_softening": True, "thermal_damping": True, "thermal_softening.k_Q": 10.0, "sigma1": 100.0},
    "temperature given": {"proxy_source": "contact_temperature", "contact_temperature": 500.0, "thermal_softening": True, "sigma1": 40.0},
    "odd ellipse": {"phase_x": -1.0, "phase_y": 2.9, "amplitude_y": 3e-6, "averaging_window": 3e-5},
}


@pytest.mark.parametrize(
    ("law", "setting"),
    [
        # Of the other laws every second setting, so that each setting is run with two laws or more; the campaign runs all.
        pytest.param(law, setting, marks=() if law == "lugre" or (row + place) % 2 == 0 else pytest.mark.campaign)
        for row, law in enumerate(LAWS)
        for place, setting in enumerate(SETTINGS)
    ],
)
def test_ellipse_as_the_kernel_does(law: str, setting: str) -> None:
    assert_same(both({"friction_law": law, **SETTINGS[setting]}, CYCLE))


@pytest.mark.parametrize("law", ["lugre", "dahl"])
def test_floor_of_the_stiffness_as_the_kernel_does(law: str) -> None:
    """At the floor the force has a kink, which the kernel's steps approach by halving: 3e-8."""
    values = {"thermal_softening": True, "rate_stiffness": "thermal", "thermal_softening.k_Q": 20.0, "damping_mode": "as_published"}
    answers = both({"friction_law": law, **values}, CYCLE)
    assert_same(answers, 3e-8)


@pytest.mark.parametrize("law", ["coulomb", "lugre", "reset_integrator"])
def test_current_shear_angle_as_the_kernel_does(law: str) -> None:
    assert_same(both({"friction_law": law, "chip_flow_angle": "current_shear_angle"}, [1.3e-6] * 12), 4e-9)


@pytest.mark.parametrize("law", LAWS)
def test_machine_that_carries_the_ellipse_as_the_kernel_does(law: str) -> None:
    moving = {"tool_displacement_y": 2e-2, "tool_velocity_x": -2e3, "tool_velocity_y": 3e3, "cutting_speed": 1e3, "applied_force": 2e4}
    assert_same(both({"friction_law": law, "kinematics": "combined", "feed": 4e-6}, CYCLE, moving))


@pytest.mark.parametrize("law", LAWS)
def test_slip_from_outside_as_the_kernel_does(law: str) -> None:
    """Through reversal and, at 4e-5 s, out of the material."""
    moving = {"slip_velocity": -2e4, "uncut_thickness": -2.5}
    assert_same(both({"friction_law": law, "kinematics": "external", "slip_velocity": 0.31, "averaging_window": 7e-6}, CYCLE, moving))


def drawn(luck: random.Random) -> dict[str, Any]:
    """A contact at random, within an order of magnitude of the starts."""

    def about(name: str) -> float:
        return kernel.variable(name).start * 10 ** luck.uniform(-0.5, 0.5)

    scaled = ("F_C", "F_S", "v_s", "sigma0", "sigma1", "sigma2", "cutting_speed", "amplitude_x", "amplitude_y", "shear_stress")
    words = ("shear_angle_principle", "proxy_source", "damping_mode", "initial_state")
    return {
        **{name: about(name) for name in scaled},
        **{name: luck.choice(kernel.variable(name).choices) for name in words},
        "friction_law": luck.choice(["coulomb", "lugre", "dahl", "reset_integrator"]),
        "rake_angle": luck.uniform(-0.4, 0.4),
        "phase_x": luck.uniform(-3, 3),
        "phase_y": luck.uniform(-3, 3),
        "feed": 10 ** luck.uniform(-6, -4),
        "proxy_speed": luck.uniform(0, 1),
        "contact_temperature": luck.uniform(280, 700),
        "thermal_damping": luck.random() < 0.5,
        "release_time": luck.choice([0.0, 1e-5]),
    }


@pytest.mark.parametrize("seed", range(12))
def test_random_contacts_as_the_kernel_does(seed: int) -> None:
    luck = random.Random(seed)
    assert_same(both(drawn(luck), [luck.uniform(0.2e-6, 6e-6) for _ in range(25)]))


@pytest.mark.parametrize("seed", [5047, 5262, 5276, 5429, 5655])
def test_shortest_contacts_are_found(seed: int) -> None:
    """Cycles with two contacts, one of them below a hundredth of the cycle: found by looking at 20 000 moments one by one."""
    values, count = {**drawn(random.Random(seed)), "friction_law": "coulomb", "relative_tolerance": 1e-4}, 20000
    contact = started(values)
    looked = sum(contact._moment(PERIOD * (n + 0.5) / count).in_contact for n in range(count)) / count
    contact.advance(PERIOD)
    assert contact.get("mean_contact_ratio") == pytest.approx(looked, abs=4 / count)  # one moment at each end of two contacts


@pytest.mark.parametrize("seed", [6, 34, 411, 988, 5047, 108925])
@pytest.mark.parametrize("step", [PERIOD, 1.3e-6, 1e-7])
def test_shortest_contacts_are_found_by_the_kernel(seed: int, step: float) -> None:
    """Contacts of 0.0005 to 0.02 of a cycle, at which the kernel does not look: where the tool turns, at the end of the earlier surface,
    where the next cycle is counted."""
    values = {**drawn(random.Random(seed)), "friction_law": "coulomb"}
    python, c = started(values), kernel.Contact({**values, "relative_tolerance": 1e-4})
    python.advance(PERIOD)
    c.start()
    count = math.ceil(PERIOD / step - 1e-9)
    for n in range(count):
        c.advance(min(step, PERIOD - n * step))
    assert c.get("contact_time") == pytest.approx(python.get("contact_time"), abs=1e-6 * PERIOD)


# ---- life --------------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_splitting_a_step_changes_nothing_beyond_tolerance(law: str) -> None:
    values = {"friction_law": law, "rake_angle": 0.1, "relative_tolerance": 1e-9}
    whole, split = started(values), started(values)
    whole.advance(1.2e-4)
    for _ in range(300):
        split.advance(4e-7)
    for name in ("friction_impulse", "normal_impulse", "dissipated_energy", "contact_time", "mean_friction_force", "mean_principal_force"):
        assert split.get(name) == pytest.approx(whole.get(name), rel=1e-9), name


def test_state_goes_through_json_and_back_to_the_last_bit() -> None:
    one = started({"initial_state": "periodic", "release_time": 1e-5})
    one.advance(1.7e-6)
    kept = json.loads(json.dumps(one.state()))
    one.advance(6e-5)
    other = ReferenceContact(complete({}))
    other.restore(kept)
    other.advance(6e-5)
    assert one.state() == other.state()
    with pytest.raises(ContactError, match="no state of a contact"):
        other.restore({"time": 0.0})


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"friction_law": "bristle"}, "bristle: not written here, allowed are coulomb, lugre"),
        ({"friction_law": "karnopp", "chip_flow_angle": "current_shear_angle"}, "no single slip"),
        ({"proxy_source": "contact_temperature", "ambient_temperature": 400.0}, "reference_temperature must lie above"),
    ],
)
def test_what_it_cannot_do_is_refused(values: dict[str, Any], text: str) -> None:
    with pytest.raises(ContactError, match=text):
        started(values)


def test_bad_values_are_refused() -> None:
    contact = started({})
    for step in (0.0, -1e-6, math.nan, math.inf):
        with pytest.raises(ContactError, match="positive finite"):
            contact.advance(step)
    with pytest.raises(ContactError, match="F_C = nan"):
        contact.set("F_C", math.nan)
    with pytest.raises(ContactError, match="no input, parameter or state"):
        contact.set("friction", 1.0)
    with pytest.raises(ContactError, match="no variable 'friction'"):
        contact.get("friction")


# ---- arithmetic --------------------------------------------------------------------------------------------------------------------------


def test_collocation_has_the_order_of_its_name() -> None:
    """Radau IIA with 5 nodes is of order 9: dz/dt = -2 t z over 1, in 1, 2 and 4 steps."""
    errors = []
    for count in (1, 2, 4):
        z, h = 1.0, 1 / count
        for n in range(count):

            def rate(i: int, z: float, t: float = n * h, h: float = h) -> float:
                return -2 * (t + h * reference.NODES[i]) * z

            z = reference.collocate(rate, z, h, 1.0)[-1]
        errors.append(abs(z - math.exp(-1)))
    slopes = [math.log2(a / b) for a, b in pairwise(errors)]
    assert slopes == pytest.approx([9, 9], abs=0.7)  # 0.5 and less from the next order, the last error being near 1e-13


def test_root_closes_on_a_change_of_sign_from_both_sides() -> None:
    low, high = reference.root(lambda t: cos(t) - t, 0.0, 2.0, 1e-15)
    assert low <= 0.7390851332151607 <= high
    assert high - low <= 2e-15
    jump = reference.root(lambda t: 1.0 if t < 0.3 else -1.0, 0.0, 1.0, 1e-15)
    assert jump[0] < 0.3 <= jump[1]
    assert reference.root(lambda t: t + 1, 0.0, 1.0, 1e-15) == (0.0, 0.0)  # no change: the end that is nearer to zero


def test_angles_of_the_closed_form_are_those_of_paper() -> None:
    """asin and atan2 as section 4 prints them, f = F/k, where they have no poles."""
    for alpha in (-0.3, 0.0, 0.3):
        for f in (-0.4, 0.1, 3.0):
            A, B, s = 2 + f * cos(alpha), f * sin(alpha), pi / 4 + alpha
            angles = {
                "minimum_energy": asin(f / hypot(A, B)) + atan2(B, A),
                "maximum_shear_stress": math.atan(f * sin(s) / (sqrt(2) + f * cos(s))),
            }
            for principle, beta in angles.items():
                N = reference.normal_force(F=f * 7, k=7, alpha=alpha, principle=principle)
                assert pytest.approx(f * 7 / tan(beta), rel=1e-13) == N
