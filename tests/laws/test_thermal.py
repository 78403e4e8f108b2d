"""What does heat do to the contact, and where does it come from? The two thermal effects and the four sources of the proxy theta."""

from __future__ import annotations

from math import exp

import numpy as np
import pytest
from driving import OUTSIDE, at_speed_ratio, read, slide, started

EFFECTS = ("thermal_softening", "thermal_damping")
SET = {
    **OUTSIDE,
    "sigma0": 1e6,
    "sigma1": 30.0,
    "sigma2": 0.5,
    "F_C": 9.0,
    "F_S": 12.0,
    "v_s": 1e-2,
    "theta_ref": 0.05,
    "damping_mode": "as_published",
    "thermal_softening.k_Q": 1.3e5,
    "thermal_softening.Q": 0.7,
    "thermal_damping.alpha2": 0.4,
}
SHOWN = ("friction_force", "principal_force", "bristle_deflection", "dissipated_energy", "theta_used")


def swinging(values: dict[str, float | str], on: tuple[str, ...]) -> np.ndarray:
    times = np.linspace(0, 1e-2, 201)
    return slide(times, 0.02 + 0.05 * np.sin(900 * times), {**SET, **values}, *SHOWN, on=on)


@pytest.mark.parametrize(
    ("effect", "neutral"),
    [("thermal_softening", {"thermal_softening.k_Q": 0.0}), ("thermal_damping", {"thermal_damping.alpha2": 0.0})],
)
def test_at_its_neutral_value_an_effect_is_off_to_the_last_bit(effect: str, neutral: dict[str, float | str]) -> None:
    off = swinging({}, ())
    np.testing.assert_array_equal(swinging(neutral, (effect,)), off)
    assert np.abs(swinging({}, (effect,)) - off).max() > 1e-2  # and at its start value it is not


def test_the_order_of_switching_is_irrelevant() -> None:
    np.testing.assert_array_equal(swinging({}, EFFECTS), swinging({}, EFFECTS[::-1]))


@pytest.mark.parametrize("on", [(), EFFECTS[:1], EFFECTS[1:], EFFECTS])
@pytest.mark.parametrize("v", [-0.2, 3e-3, 0.04])
def test_force_is_the_papers_equation_8(v: float, on: tuple[str, ...]) -> None:
    """F = s0(theta) z + s1(theta) dz/dt + sigma2 v, the rate equation with the reference stiffness."""
    z, theta = 4e-6, abs(v) / 0.05
    s0 = 1e6 - (1.3e5 * theta**0.7 if EFFECTS[0] in on else 0)
    s1 = 30 * (theta**0.4 if EFFECTS[1] in on else 1)
    g = 9 + 3 * exp(-((v / 1e-2) ** 2))
    dz = v - 1e6 * abs(v) * z / g
    contact = started({**SET, "slip_velocity": v, "bristle_deflection": z}, on)
    assert read(contact, "bristle_rate", "friction_force") == pytest.approx([dz, s0 * z + s1 * dz + 0.5 * v], rel=1e-12)


@pytest.mark.parametrize("v", [2e-3, 0.04, -0.15])
def test_steady_slip_shows_the_softening_only_where_the_bristles_keep_their_reference_stiffness(v: float) -> None:
    """reference: F = g s0/sigma0; thermal: stiffness cancels and F = g, as without heat."""
    g, s0 = 9 + 3 * exp(-((v / 1e-2) ** 2)), 1e6 - 1.3e5 * (abs(v) / 0.05) ** 0.7
    for reading, expected in (("reference", g * s0 / 1e6), ("thermal", g)):
        contact = started({**SET, "slip_velocity": v, "rate_stiffness": reading}, EFFECTS)
        contact.advance(1e-3 / abs(v))
        assert contact.get("friction_force") == pytest.approx(np.sign(v) * expected + 0.5 * v, rel=1e-10)
        assert abs(contact.get("bristle_deflection")) == pytest.approx(g / (1e6 if reading == "reference" else s0), rel=1e-10)


@pytest.mark.parametrize("speed", [0.0, 0.003, 0.05, 0.4])
def test_four_sources_of_the_proxy_agree_where_they_should(speed: float) -> None:
    """One theta, from the slip, as a speed, as the cutting speed, and as a temperature by the paper's eq. 3."""
    exponent, ambient, reference = 0.4, 293.15, 393.15
    temperature = ambient + (reference - ambient) * (speed / 0.05) ** exponent
    sources = {
        "slip_speed": {},
        "proxy_speed": {"proxy_speed": speed},
        "cutting_speed": {"cutting_speed": speed},
        "contact_temperature": {"contact_temperature": temperature, "alpha_T": exponent},
    }
    for sign in (-1.0, 1.0):
        rows = []
        for source, given in sources.items():
            contact = started({**SET, "slip_velocity": sign * speed, "proxy_source": source, **given}, EFFECTS)
            contact.advance(1e-4)
            rows.append(read(contact, *SHOWN))
        assert rows[0][-1] == speed
        np.testing.assert_array_equal(rows[1:3], [rows[0], rows[0]])
        # eq. 3 turned round: the rise of the temperature loses digits to the ambient one, to the power 1/alpha_T
        assert rows[3] == pytest.approx(rows[0], rel=1e-10, abs=1e-300)


def test_an_input_proxy_leaves_the_slip_alone() -> None:
    """Heat from elsewhere at rest: the spring is soft although nothing slips."""
    contact = started({**SET, "proxy_source": "proxy_speed", "proxy_speed": 0.1, "bristle_deflection": 1e-6}, EFFECTS)
    assert contact.get("friction_force") == pytest.approx(1e-6 * (1e6 - 1.3e5 * 2**0.7), rel=1e-12)


def test_equation_7_is_kept_by_a_floor_that_speaks_and_counts() -> None:
    """P > v^Q broken above theta_ref (P/k_Q)^(1/Q) = 0.923 m/s: s0 stays at its floor, one warning, every step counted."""
    z, limit = 2e-6, 0.05 * (1e6 / 1.3e5) ** (1 / 0.7)
    values = {**SET, "sigma1": 0.0, "sigma2": 0.0, "bristle_deflection": z, "proxy_source": "proxy_speed", "stiffness_floor": 1e-3}
    for share, stiffness, warnings in ((0.99, 1e6 * (1 - 0.99**0.7), 0), (1.01, 1e3, 1), (100.0, 1e3, 1)):
        contact = started({**values, "proxy_speed": share * limit}, EFFECTS)
        for _ in range(3):
            contact.advance(1e-3)
        assert contact.get("friction_force") == pytest.approx(stiffness * z, rel=1e-9)
        assert len(contact.warnings()) == warnings
        assert contact.get("clamped_count") == warnings * contact.get("step_count")


@pytest.mark.parametrize(("P", "Q", "limit"), [(350000, 3.49, 38.8), (482200, 5.34, 11.6)])
def test_equation_7_binds_at_ordinary_speeds_when_table_1_is_in_metres_per_minute(P: float, Q: float, limit: float) -> None:
    """Al 6061 at 38.8 m/min, Inconel 718 at 11.6 m/min (P^(1/Q) of the paper's table 1)."""
    values = {**OUTSIDE, "sigma0": P, "thermal_softening.k_Q": 1.0, "thermal_softening.Q": Q, "theta_ref": 1 / 60}
    for speed, warned in ((limit - 0.05, 0), (limit + 0.05, 1)):
        contact = started({**values, "slip_velocity": speed / 60, "stiffness_floor": 1e-9}, ("thermal_softening",))
        assert len(contact.warnings()) == warned


def test_a_temperature_below_ambient_counts_as_ambient() -> None:
    contact = started({**SET, "proxy_source": "contact_temperature", "contact_temperature": 250.0, "slip_velocity": 0.01}, EFFECTS)
    contact.advance(1e-3)
    assert contact.get("theta_used") == 0
    assert contact.get("clamped_count") == contact.get("step_count") > 0
    assert len(contact.warnings()) == 1


def test_heat_acts_in_the_vibration_cycle_too() -> None:
    """On the ellipse: softer bristles give less friction in the mean, and off is off to the last bit there as well."""
    values = at_speed_ratio(0.3, **{"thermal_softening.k_Q": 2e5, "thermal_softening.Q": 1.0, "feed": 1e-4, "theta_ref": 0.5})
    mean = {}
    for name, given, on in (("off", {}, ()), ("neutral", {"thermal_softening.k_Q": 0.0}, EFFECTS[:1]), ("on", {}, EFFECTS[:1])):
        contact = started({**values, **given}, on)
        contact.advance(2e-4)
        mean[name] = contact.get("mean_friction_force")
    assert mean["neutral"] == mean["off"]
    assert 0.5 * mean["off"] < mean["on"] < 0.99 * mean["off"]
