"""Does presliding by four elements remember where the slip turned round? Generalised Maxwell slip against elements of our own, by scipy."""

from __future__ import annotations

from itertools import pairwise
from math import exp

import numpy as np
import pytest
from asking import OUTSIDE, follow
from driving import Values
from evat.models.contact import ContactModel
from evat.native import kernel
from scipy.integrate import solve_ivp

ON = ("maxwell_slip",)
STROKE, RATIO, F_C, SIGMA0 = 4e-5, 2.5, 8.0, 1e6
ROUNDED = 0.1  # kernel/effects/stop_operator.h
LEVEL: Values = {**OUTSIDE, "sigma0": SIGMA0, "F_C": F_C, "F_S": F_C, "sigma1": 0.0, "sigma2": 0.0}
OWN: Values = {"maxwell_slip.stroke": STROKE, "maxwell_slip.ratio": RATIO}
STROKES = STROKE / RATIO ** np.arange(3, -1, -1)


def led(turns: list[float], samples: int = 100) -> tuple[np.ndarray, np.ndarray]:
    """Times and slip velocity of a way that leads from turning point to turning point [m], each leg half a sine in 10 ms."""
    legs = np.diff(turns)
    phase = np.arange(samples) / samples
    speed = np.concatenate([leg * np.pi / 0.02 * np.sin(np.pi * phase) for leg in legs] + [[0.0]])
    return 0.01 * np.arange(samples * len(legs) + 1) / samples, speed


def slid(times: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """What a slip that is straight between the samples has slid."""
    return np.concatenate([[0.0], np.cumsum(np.diff(times) * (speed[1:] + speed[:-1]) / 2)])


def shown(turns: list[float], values: Values, on: tuple[str, ...] = ON) -> tuple[np.ndarray, np.ndarray]:
    """Way and friction force."""
    times, speed = led(turns)
    return slid(times, speed), follow(times, {"slip_velocity": speed}, {**LEVEL, **OWN, **values}, on, "friction_force")[0]


def elements(turns: list[float]) -> np.ndarray:
    """The force of the elements alone, from way to way, at 1e-11: dy/dx = s min(1, (1 - s y)/ROUNDED)/stroke."""
    way = slid(*led(turns))
    y, rows = np.zeros(4), [0.0]
    for low, high in pairwise(way):
        s = 1.0 if high > low else -1.0  # driven the other way they are the mirror image
        if high != low:
            bent = solve_ivp(
                lambda x, u: np.minimum(1, (1 - u) / ROUNDED) / STROKES, (0, abs(high - low)), s * y, rtol=1e-11, atol=1e-12, max_step=2e-7
            )
            y = s * bent.y[:, -1]
        rows.append(F_C * float(np.mean(y)))
    return np.array(rows)


def test_a_way_to_and_fro_is_that_of_four_elements() -> None:
    """Small loops in large ones, in both directions, and a long slide."""
    turns = [0.0, 2e-5, 1.2e-5, 6e-5, 3e-5, 4.5e-5, -5e-5, -4.9e-5, -4.95e-5, 2e-5]
    np.testing.assert_allclose(shown(turns, {})[1], elements(turns), atol=1e-6 * F_C)


def test_a_small_loop_closes_and_is_forgotten_by_the_large_one() -> None:
    """Where the way is as without the loop, so is the force, but for what round corners leave; LuGre's one bristle drifts."""
    plain, loop = [0.0, 1.5e-5, 4e-5], [0.0, 1.5e-5, 1e-5, 1.5e-5, 4e-5]

    def left_by_the_loop(on: tuple[str, ...]) -> float:
        (_, without), (_, within) = shown(plain, {}, on), shown(loop, {}, on)
        return float(np.abs(within[300:] - without[100:]).max() / F_C)

    assert left_by_the_loop(ON) < 0.025
    assert left_by_the_loop(()) > 0.3


@pytest.mark.parametrize("law", ["lugre", "dahl"])
def test_a_long_slide_has_the_laws_own_force(law: str) -> None:
    """g(v) + sigma2 v of the law, whatever share the elements carry."""
    values: Values = {**LEVEL, **OWN, "friction_law": law, "F_S": 1.4 * F_C, "v_s": 5e-3, "sigma2": 3.0, "sigma1": 50.0}
    times, speed = np.array([0.0, 0.5]), np.full(2, 4e-3)
    right = F_C * (1 + 0.4 * exp(-((0.8) ** 2))) + 3.0 * 4e-3 if law == "lugre" else F_C
    for share in (0.0, 0.4, 1.0):
        force = follow(times, {"slip_velocity": speed}, {**values, "maxwell_slip.share": share}, ON, "friction_force")[0, -1]
        assert force == pytest.approx(right, rel=1e-8)


def test_half_the_share_is_the_mean_of_both() -> None:
    turns = [0.0, 2e-5, 1.2e-5, 6e-5]
    _, force = shown(turns, {"maxwell_slip.share": 0.5})
    _, all_of_them = shown(turns, {"maxwell_slip.share": 1.0})
    _, none = shown(turns, {}, ())
    np.testing.assert_allclose(force, (all_of_them + none) / 2, atol=1e-6 * F_C)
    assert np.abs(all_of_them - none).max() > 0.2 * F_C


@pytest.mark.parametrize("seed", range(5))
def test_closed_ways_take_energy(seed: int) -> None:
    """Each run through a loop of random turns takes work from the second on; and of an amplitude X beyond all strokes 4 F_C (X - mean
    stroke) but for the round corners."""
    luck = np.random.default_rng(seed)
    turns = [0.0, *luck.uniform(-3e-5, 3e-5, 5)]
    times, speed = led([*turns, *turns, *turns, 0.0], 50)
    energy = follow(times, {"slip_velocity": speed}, {**LEVEL, **OWN}, ON, "dissipated_energy")[0]
    assert energy[50 * 12] - energy[50 * 6] > 0
    wide = 2e-4 * (1 + seed)
    times, speed = led([0.0, *([wide, -wide] * 2)])
    energy = follow(times, {"slip_velocity": speed}, {**LEVEL, **OWN}, ON, "dissipated_energy")[0]
    assert energy[400] - energy[200] == pytest.approx(4 * F_C * (wide - STROKES.mean()), rel=0.01)


@pytest.mark.parametrize("law", ["lugre", "dahl"])
@pytest.mark.parametrize("share", [1e-51, 1e-3, 0.1, 1.0])
def test_turning_without_vibration_has_the_friction_of_steady_sliding(law: str, share: float) -> None:
    """Whatever the share. Each cycle loads an element by as much as the one before, until it gives way: a slope of 1 but for roundings, by
    which a search for a cycle that comes back went to a load of 1e13 that a cycle hardly changes, and to a force of -1e67 N."""
    speeds = np.geomspace(0.15, 3.0, 60)
    values = {"kinematics": "internal", "friction_law": law, "amplitude_x": 0.0, "amplitude_y": 0.0, "cutting_speed": speeds}
    own = {"maxwell_slip.share": share, "maxwell_slip.stroke": 1.6e-4, "maxwell_slip.ratio": 5.2}
    model, outputs = ContactModel(threads=1), ("mean_feed_force", "mean_principal_force")
    slipped, steady = (model.settled(outputs, on, {**values, **given}) for on, given in ((ON, own), ((), {})))
    for name in outputs:
        np.testing.assert_allclose(slipped[name], steady[name], rtol=1e-4)


@pytest.mark.parametrize("bent", [0.3, -0.7, 1.0])
def test_elements_begin_loaded_as_the_bristle_is_bent(bent: float) -> None:
    """A rig that has moved before: they began unloaded, and a small loop goes on for ever beside where it should."""
    way = [0.0, -1.2e-5, 1.5e-5, -0.5e-5, 4e-5]
    force = shown(way, {"bristle_deflection": bent * F_C / SIGMA0})[1]
    assert force[0] == pytest.approx(bent * F_C, abs=1e-6 * F_C)

    def after(first: float) -> np.ndarray:
        """The same way, from where another has led from elements without a load."""
        return shown([0.0, first, *(first + x for x in way[1:])], {})[1][100:]

    low, high = sorted((0.0, np.sign(bent) * 8e-5))
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if after(middle)[0] < force[0] else (low, middle)
    np.testing.assert_allclose(force, after((low + high) / 2), atol=2e-3 * F_C)


def test_loads_that_are_stated_stand() -> None:
    stated = {f"maxwell_slip.load_{k}": 0.25 for k in range(1, 5)}
    _, force = shown([0.0, 1e-6], {"bristle_deflection": F_C / SIGMA0, **stated})
    assert force[0] == pytest.approx(0.25 * F_C, rel=1e-6)


@pytest.mark.parametrize("exponent", [0.5, 2.0, 6.0])
def test_however_the_laws_own_bristle_yields_the_elements_are_the_same(exponent: float) -> None:
    """Their limit is what the bristle has in steady sliding, not what it strives for on its way there: that force was next to none."""
    turns: list[float] = [0.0, 2e-5, 1.2e-5, 6e-5, 3e-5]
    np.testing.assert_allclose(shown(turns, {"lugre.presliding_exponent": exponent})[1], elements(turns), atol=1e-6 * F_C)
    bent = {"lugre.presliding_exponent": exponent, "bristle_deflection": 0.3 * F_C / SIGMA0}
    assert shown([0.0, 1e-6], bent)[1][0] == pytest.approx(0.3 * F_C, rel=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_bristles_that_heat_softens_leave_the_elements_as_much_as_they_have(share: float) -> None:
    """Steady friction falls with s0, the stiffness that stands in the force, over P, by which bristles yield. What stands for them has
    that limit, as the equation says."""
    values: Values = {**LEVEL, **OWN, "maxwell_slip.share": share, "thermal_softening.k_Q": 0.4 * SIGMA0, "thermal_softening.Q": 0.0}
    force = follow(np.array([0.0, 0.5]), {"slip_velocity": np.full(2, 4e-3)}, values, (*ON, "thermal_softening"), "friction_force")[0, -1]
    assert force == pytest.approx(0.6 * F_C, rel=1e-8)
    assert "share s0/P g(v) sum(y_k)/4" in next(effect.equation for effect in kernel.effects() if effect.name == "maxwell_slip")
