"""Where does the power of the cut go? Friction and shear take what the tool gives, and shear gives none back."""

from __future__ import annotations

import numpy as np
import pytest
from driving import AMPLITUDE, OMEGA, PERIOD, started

LAWS = ("coulomb", "lugre", "dahl", "bristle", "reset_integrator")


def drawn(seed: int) -> tuple[dict[str, float | str], np.random.Generator]:
    """A cut with any rake, flow angle, ellipse and law."""
    luck = np.random.default_rng(seed)
    values: dict[str, float | str] = {
        "friction_law": LAWS[seed % len(LAWS)],
        "rake_angle": float(luck.uniform(-0.3, 0.5)),
        "chip_flow_shear_angle": float(luck.uniform(0.3, 0.7)),
        "shear_angle_principle": str(luck.choice(["maximum_shear_stress", "minimum_energy"])),
        "chip_flow_angle": "current_shear_angle" if seed % 3 == 0 else "constant",
        "cutting_speed": float(luck.uniform(0.1, 1.5)) * AMPLITUDE * OMEGA,
        "amplitude_y": float(luck.uniform(0.2, 1.5)) * AMPLITUDE,
        "phase_y": float(np.pi + luck.uniform(-0.5, 0.5)),
        "F_C": float(luck.uniform(1, 20)),
        "F_S": float(luck.uniform(1, 20)),
    }
    return values, luck


@pytest.mark.parametrize("seed", range(24))
def test_friction_and_shear_take_what_the_tool_gives(seed: int) -> None:
    """Force on the chip times tool velocity, from the ellipse itself. With the current shear angle it is also k V_s/sin(phi)."""
    values, luck = drawn(seed)
    contact = started(values)
    seen = 0
    for _ in range(60):
        contact.advance(float(luck.uniform(0.01, 0.05)) * PERIOD)
        get = contact.get
        t = contact.time * OMEGA
        u_x = get("cutting_speed") - get("amplitude_x") * OMEGA * np.sin(t + get("phase_x"))
        u_y = -get("amplitude_y") * OMEGA * np.sin(t + get("phase_y"))
        given = get("principal_force") * u_x - get("feed_force") * u_y
        scale = abs(get("principal_force") * u_x) + abs(get("feed_force") * u_y)
        assert get("dissipated_power") + get("shear_power") == pytest.approx(given, abs=1e-9 * (scale + 1e-9))
        if not get("in_contact"):
            assert get("shear_power") == 0
            continue
        seen += 1
        if values["chip_flow_angle"] == "current_shear_angle" and get("normal_force") > 0:
            phi, alpha = get("shear_angle"), get("rake_angle")
            k = get("shear_stress") * get("width") * get("uncut_thickness_used")
            V_s = (u_x * np.cos(alpha) + u_y * np.sin(alpha)) / np.cos(phi - alpha)
            if k**2 + k * get("friction_force") * np.cos(alpha) > 0:  # within the domain of the principles
                assert get("shear_power") == pytest.approx(k * V_s / np.sin(phi), rel=1e-6)
    assert seen > 5


@pytest.mark.parametrize("seed", range(24))
def test_with_friction_that_the_chip_bears_shear_gives_nothing_back(seed: int) -> None:
    """|F| <= N: then F_s = N cos(phi - alpha) - F sin(phi - alpha) is no pull while phi - alpha stays below 45 degrees."""
    values, luck = drawn(seed)
    values |= {"F_C": 200.0, "F_S": 200.0, "rake_angle": float(luck.uniform(0, 0.4))}
    contact = started(values, ("sticking_limit",))
    powers = []
    for _ in range(200):
        contact.advance(float(luck.uniform(0.005, 0.03)) * PERIOD)
        powers.append(contact.get("shear_power"))
    assert max(powers) > 0.01
    assert min(powers) >= -1e-9 * max(powers)


def test_the_energies_are_the_integrals_and_the_means_theirs_over_the_window() -> None:
    contact = started({"relative_tolerance": 1e-8})
    contact.advance(3 * PERIOD)
    first = {name: contact.get(name) for name in ("dissipated_energy", "shear_energy")}
    samples = 4000
    sums = dict.fromkeys(first, 0.0)
    for _ in range(samples):
        for name, power in (("dissipated_energy", "dissipated_power"), ("shear_energy", "shear_power")):
            sums[name] += contact.get(power) * PERIOD / samples
        contact.advance(PERIOD / samples)
    for name, before in first.items():
        gained = contact.get(name) - before
        assert gained > 0
        assert gained == pytest.approx(sums[name], rel=2e-3)  # rectangles, and a jump at entry
        assert contact.get(f"mean_{name.replace('energy', 'power')}") == pytest.approx(gained / PERIOD, rel=1e-9)


@pytest.mark.parametrize("alpha", [-0.2, 0.0, 0.3])
def test_a_given_slip_shears_the_chip_as_a_steady_cut_does(alpha: float) -> None:
    """The same slip, once from a tool that moves straight on, once given: shear_power is the same, and total the force times the speed."""
    speed, phi = 0.4, 0.6
    values = {"rake_angle": alpha, "chip_flow_shear_angle": phi, "friction_law": "coulomb", "shear_angle_principle": "minimum_energy"}
    straight = started({**values, "amplitude_x": 0.0, "amplitude_y": 0.0, "cutting_speed": speed})
    slip = straight.get("slip_velocity_used")
    assert slip == pytest.approx(speed * np.sin(phi) / np.cos(phi - alpha), rel=1e-12)
    given = started({**values, "kinematics": "external", "slip_velocity": slip, "uncut_thickness": 1e-4})
    for name in ("shear_power", "dissipated_power"):
        assert given.get(name) == pytest.approx(straight.get(name), rel=1e-12)
    assert given.get("shear_power") + given.get("dissipated_power") == pytest.approx(given.get("principal_force") * speed, rel=1e-12)
    given.set("slip_velocity", -slip)
    given.event()
    assert given.get("shear_power") == 0


def test_a_cycle_that_stands_for_many_shows_the_mean_powers() -> None:
    values = {"cutting_speed": 0.2}
    resolved, averaged = started(values), started({**values, "averaging": "cycle"})
    resolved.advance(5 * PERIOD)
    averaged.advance(5 * PERIOD)
    for name in ("dissipated", "shear"):
        mean = resolved.get(f"mean_{name}_power")
        assert averaged.get(f"{name}_power") == pytest.approx(mean, rel=2e-3)
        assert averaged.get(f"mean_{name}_power") == averaged.get(f"{name}_power")
        assert averaged.get(f"{name}_energy") == pytest.approx(5 * PERIOD * mean, rel=2e-3)
