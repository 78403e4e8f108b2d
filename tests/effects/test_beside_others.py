"""Does an effect do beside others what it does alone? Sensors one behind the other, a delay behind an effect that does nothing."""

from __future__ import annotations

import numpy as np
import pytest
from asking import OUTSIDE, VISCOUS, begun, course, follow
from driving import PERIOD, Values, read
from evat.native import kernel

FORCES = ("friction_force", "principal_force", "feed_force")
MEASURED = tuple(f"measured_{name}" for name in FORCES)
TIMES = np.linspace(0, 1e-3, 41)
SLIP = {"slip_velocity": 2 + np.sin(9e3 * TIMES) + 0.4 * np.sign(np.sin(3e4 * TIMES + 0.1))}
FILTER = {"sensor_lowpass.time_constant": 7e-5}
RESONANCE = {"dynamometer_resonance.natural_period": 3e-4, "dynamometer_resonance.damping_ratio": 1.4}


def shown(on: list[str], **values: float) -> np.ndarray:
    """The measured forces along a slip with corners, in a cut whose three forces are not proportional to each other."""
    return follow(TIMES, SLIP, {**VISCOUS, "rake_angle": 0.2, "sigma2": 20.0, **values}, on, *MEASURED)


def test_a_filter_hears_the_mixture_of_the_channels_before_it() -> None:
    """A linear filter of a mixture is the mixture of filtered channels; to the rounding of two runs with the same steps."""
    part = {"cross_talk.principal_from_feed": 0.3, "cross_talk.feed_from_principal": -0.2}
    single, both = shown(["sensor_lowpass"], **FILTER), shown(["cross_talk", "sensor_lowpass"], **FILTER, **part)
    exact = np.array([[1, 0, 0], [0, 1, 0.3], [0, -0.2, 1]]) @ single
    assert both == pytest.approx(exact, rel=1e-9)
    assert np.abs(exact - single).max() > 1


def test_gain_and_offset_come_behind_the_filter() -> None:
    given = {f"sensor_{kind}.{name}": 1.5 for kind in ("gain", "offset") for name in FORCES}
    behind = shown(["sensor_lowpass", "sensor_gain", "sensor_offset"], **FILTER, **given)
    assert behind == pytest.approx(1.5 * shown(["sensor_lowpass"], **FILTER) + 1.5, rel=1e-12)


def test_a_filter_behind_a_creeping_platform_is_one_of_third_order() -> None:
    """Friction alone, linear in the slip between samples: the cascade of both transfer functions, straight between samples too."""
    from scipy.signal import lsim

    w, zeta, T = 2 * np.pi / 3e-4, 1.4, 7e-5
    drive = shown([])[0]
    system = (w**2, np.polymul([1, 2 * zeta * w, w**2], [T, 1]))
    filtered = shown(["dynamometer_resonance", "sensor_lowpass"], **FILTER, **RESONANCE)[0]
    exact = lsim(system, drive, TIMES, interp=True)[1]
    assert filtered == pytest.approx(exact, abs=2e-6 * np.abs(drive).max())  # both errors of the tolerance of 1e-8, and the bristle's start


@pytest.mark.parametrize("before", ["run_out", "viscous_friction", "load_dependence"])
def test_a_delay_is_as_careful_behind_an_effect_that_does_nothing(before: str) -> None:
    """Its steps follow what comes late as well; an effect of neutral values before it in the order changes no bit."""
    values: Values = {"cutting_speed": 0.2, "relative_tolerance": 1e-7, "sensor_delay.time": 1.237e-5}
    neutral = {
        v.name: v.neutral for effect in kernel.effects() if effect.name == before for v in effect.variables if np.isfinite(v.neutral)
    }
    times, names = np.linspace(0, 2 * PERIOD, 41), (*MEASURED, "step_count")
    alone = course(begun(values, ["sensor_delay"]), times, *names)
    beside = course(begun({**values, **neutral}, [before, "sensor_delay"]), times, *names)
    assert np.array_equal(beside, alone)
    assert np.ptp(alone[0]) > 1


def test_a_delay_within_a_hosts_step_is_straight() -> None:
    """Model exchange: 10 us after all that is known, 4 us late, the force is six tenths on the way from the last to the present one."""
    contact = begun({**OUTSIDE, **VISCOUS, "slip_velocity": 1.0, "sensor_delay.time": 4e-6}, ["sensor_delay"])
    contact.advance(1e-5)
    contact.time += 1e-5
    contact.set("slip_velocity", 3.0)
    contact.evaluate()
    force, late = read(contact, "friction_force", "measured_friction_force")
    assert (force, late) == pytest.approx((3.0, 1.0 + 0.6 * 2.0), abs=1e-5)  # the bristle holds 1e-6 N


def test_a_slope_of_an_input_lasts_over_averaged_steps_as_over_others() -> None:
    """0.2 m/s and a slope of 10 m/s^2: after two steps of 1 ms 0.22 m/s, whatever each step is made of."""
    _, library = kernel.library()
    for averaging in ("resolved", "cycle"):
        contact = begun({"averaging": averaging, "cutting_speed": 0.2})
        contact._contact.slope[kernel.variable("cutting_speed").index - library.INPUT_FIRST][0] = 10.0
        for end in (0.21, 0.22):
            contact.advance(1e-3)
            assert contact.get("cutting_speed") == pytest.approx(end, rel=1e-12)


def test_the_rate_of_a_filter_is_of_the_mixture_too() -> None:
    """What a host of model exchange is told: (mixture - state)/T."""
    on, part = ["cross_talk", "sensor_lowpass"], {"cross_talk.principal_from_feed": 0.3, "cross_talk.feed_from_principal": -0.2}
    contact = begun({**OUTSIDE, **VISCOUS, "rake_angle": 0.2, "sigma2": 20.0, "slip_velocity": 1.0, **FILTER, **part}, on)
    contact.advance(5e-5)
    forces = np.array([[1, 0, 0], [0, 1, 0.3], [0, -0.2, 1]]) @ read(contact, *FORCES)
    states = read(contact, *(f"sensor_lowpass.{name}" for name in FORCES))
    rates = read(contact, *(f"sensor_lowpass.{name}_rate" for name in FORCES))
    assert rates == pytest.approx((forces - states) / FILTER["sensor_lowpass.time_constant"], rel=1e-12)


@pytest.mark.parametrize("idle", ["maxwell_slip", "elasto_plastic"])
def test_presliding_that_has_nothing_to_replace_leaves_a_sliding_bristle_its_way(idle: str) -> None:
    """reset_integrator carries its bristle along while it slides, as far as the level is: it had stayed where it gave way."""
    times = np.linspace(0, 0.2, 401)
    slip = {"slip_velocity": 0.05 * np.sin(20 * np.pi * times)}
    own = {"position_dependence.friction": 0.5, "position_dependence.period": 1e-3, "position_dependence.phase": 0.7}
    values = {**OUTSIDE, "friction_law": "reset_integrator", "relative_tolerance": 1e-6, "position_dependence.cogging": 0.0, **own}
    names = ("friction_force", "bristle_deflection")
    alone, beside = (follow(times, slip, values, on, *names) for on in (["position_dependence"], [idle, "position_dependence"]))
    for name, without, with_it in zip(names, alone, beside, strict=True):
        assert with_it == pytest.approx(without, abs=1e-5 * np.abs(without).max()), name
