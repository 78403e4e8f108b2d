"""Does the kernel's LuGre law show what LuGre showed in 1995? Its bristle is a state of the plant that Radau integrates."""

from __future__ import annotations

import evidence
import lugre_1995 as published
import numpy as np
import pytest
from evat import parameter_sets
from evat.native.kernel import Contact

SET = parameter_sets.load("lugre-1995").values


def contact(**values: float | str) -> Contact:
    made = Contact({**SET, **published.DRIVEN_FROM_OUTSIDE, **values})
    made.start()
    return made


@pytest.fixture
def friction() -> published.Friction:
    bristle = contact()

    def rates(t: float, v: float, z: float) -> tuple[float, float]:
        bristle.set("slip_velocity", v)
        bristle.set("bristle_deflection", z)
        bristle.evaluate()
        return bristle.get("friction_force"), bristle.get("bristle_rate")

    return rates


def test_presliding_displacement(friction: published.Friction) -> None:
    simulated = published.presliding(published.follow(published.presliding_plant(), friction))
    assert simulated == pytest.approx(published.PRESLIDING, abs=published.TOLERANCE["presliding"])
    evidence.hold("presliding", 100 * abs(simulated / published.PRESLIDING - 1))


@pytest.mark.parametrize("rate", published.BREAK_AWAY)
def test_break_away_force_falls_with_the_rate_of_the_force(friction: published.Friction, rate: float) -> None:
    simulated = published.break_away(published.follow(published.break_away_plant(rate), friction))
    assert simulated == pytest.approx(published.BREAK_AWAY[rate], abs=published.TOLERANCE["break_away"])


@pytest.mark.parametrize("w", published.LAG)
def test_friction_lags_the_velocity(friction: published.Friction, w: float) -> None:
    simulated = published.lag(published.follow(published.lag_plant(w), friction))
    assert simulated == pytest.approx(published.LAG[w], abs=published.TOLERANCE["lag"])


@pytest.mark.parametrize("w", published.LAG)
def test_friction_lags_the_velocity_in_the_kernels_own_steps(w: float) -> None:
    """The same by co-simulation: the velocity is an input, linear over less than 1/2000 of a cycle."""
    plant, bristle = published.lag_plant(w), contact(relative_tolerance=1e-7)
    times = np.linspace(0, plant.times[-1], 6001)
    times = np.union1d(times, plant.times)
    bristle.set("slip_velocity", plant.velocity(0, ()))
    F = bristle.run(times, {"slip_velocity": np.array([plant.velocity(t, ()) for t in times])}, ["friction_force"])[:, 0]
    simulated = tuple(F[np.searchsorted(times, plant.times[1:])])
    assert simulated == pytest.approx(published.LAG[w], abs=published.TOLERANCE["lag"])


def test_stick_slip(friction: published.Friction) -> None:
    simulated = published.stick_slip(published.follow(published.stick_slip_plant(), friction))
    assert simulated == pytest.approx(published.STICK_SLIP, abs=published.TOLERANCE["ms"])
    evidence.hold("stick_slip", max(100 * abs(simulated[name] / value - 1) for name, value in published.STICK_SLIP.items()))


def test_a_servo_with_integral_action_hunts(friction: published.Friction) -> None:
    simulated = published.hunting(published.follow(published.servo_plant(), friction))
    evidence.hold("hunting", max(100 * abs(simulated[name] / value - 1) for name, value in published.HUNTING.items()))
    period = simulated.pop("period")
    expected = dict(published.HUNTING)
    assert period == pytest.approx(expected.pop("period"), abs=published.TOLERANCE["hunting_period"])
    assert simulated == pytest.approx(expected, abs=published.TOLERANCE["ms"])
