"""Is a moved mass that is stated wrong told as that, and not as an effect? Its inertia was taken off the friction force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap import diagnose, diagnose_with
from evat.gap.report import headline
from evat.inference.prediction import Prediction
from known_rigs import MODEL, STEP, TIMES, TO_AND_FRO, TRUTH, experiment, force, trial

MASS, MORE, NAME = 20.0, 6.0, "setup.friction_force.mass"
FASTER = 0.03 * np.sin(2 * np.pi * 2.3 * TIMES) + 0.001 * np.sin(2 * np.pi * 9.1 * TIMES)


def rig(stated: float, more: float) -> Experiment:
    """Two motions, each twice; what moves is so much heavier than its owner states."""
    trials = []
    for place, motion in enumerate((TO_AND_FRO, FASTER)):
        measured = force(motion) + more * np.gradient(motion, STEP)
        trials += [trial(motion, f"c{place}", seed=10 * place + repeat, measured=measured) for repeat in range(2)]
    return replace(experiment(*trials, nominal=TRUTH), mass=stated)


def test_what_is_heavier_adds_its_inertia() -> None:
    prediction = Prediction(MODEL, rig(MASS, 0.0))
    parameter = next(each for each in prediction.setup.parameters if each.name == NAME)
    assert (parameter.unit, parameter.sd, parameter.low) == ("kg", pytest.approx(0.05 * MASS), -MASS)
    heavier = prediction.one({NAME: MORE}) - prediction.one()
    expected = MORE * np.concatenate([np.gradient(motion, STEP) for motion in (TO_AND_FRO, TO_AND_FRO, FASTER, FASTER)])
    assert heavier == pytest.approx(expected, abs=1e-9)
    assert prediction.setup.slopes(prediction.one(), NAME, {}) == pytest.approx(expected / MORE, abs=1e-9)
    assert prediction.jacobian({"F_C": 9.0, NAME: MORE}, ("F_C",), {"F_C": 1.0})[1] == pytest.approx(
        prediction.jacobian({"F_C": 9.0}, ("F_C",), {"F_C": 1.0})[1], abs=1e-12
    )


def test_where_no_mass_is_stated_one_is_no_part_of_a_fit() -> None:
    """Of a usual inertia of 3 % of the force, and never below 0, it is there where it is clear alone: it stands beside effects."""
    prediction = Prediction(MODEL, rig(0.0, 0.0))
    mass = prediction.setup.unstated_mass
    assert mass is not None
    inertia = mass.sd * np.concatenate([np.gradient(motion, STEP) for motion in (TO_AND_FRO, FASTER)])
    assert np.sqrt(np.mean(inertia**2) / np.mean(prediction.measured**2)) == pytest.approx(0.03)
    assert (mass.name, mass.low) == (NAME, 0.0)
    assert mass not in prediction.setup.parameters
    at_rest = replace(rig(0.0, 0.0), trials=tuple(trial(np.zeros_like(TIMES), f"c{n}", seed=n) for n in range(2)))
    assert NAME not in Prediction(MODEL, at_rest).setup.names
    assert "mass" not in diagnose(rig(0.0, 0.0), MODEL).recalibration.setup["friction_force"]


def test_a_mass_that_nobody_stated_is_told() -> None:
    """Its inertia was taken for friction that follows the acceleration, and so for mis-tuned values or for something unknown."""
    answer, comparison = diagnose_with(rig(0.0, MORE), MODEL)
    said = headline(answer, comparison)
    assert answer.verdict == "no_gap"
    assert not answer.effects
    assert said.sentence == "No effect is named: the moved mass, beyond the tolerance of the set-up, takes up most of the gap."
    assert said.next.endswith("state it as nominal.mass.")
    value, sd, _ = answer.recalibration.setup["friction_force"]["mass"]
    assert value == pytest.approx(MORE, abs=max(3 * sd, 0.05))


def test_a_mass_that_is_stated_wrong_is_told_with_what_it_has_to_become() -> None:
    """It was a line, a position or a delay of the input that stood in for it."""
    answer, comparison = diagnose_with(rig(MASS, MORE), MODEL)
    said = headline(answer, comparison)
    assert answer.verdict == "no_gap"  # the values of the law are right
    assert not answer.effects
    assert (said.status, said.tone) == ("set-up wrong", "attention")
    assert said.first[0].startswith("The stated mass is not credible: 20 kg has to become 2")
    assert said.sentence == "No effect is named: the moved mass, beyond the tolerance of the set-up, takes up most of the gap."
    assert said.next.endswith("state it as nominal.mass.")
    value, sd, unit = answer.recalibration.setup["friction_force"]["mass"]
    assert unit == "kg"
    assert value == pytest.approx(MORE, abs=max(3 * sd, 0.05))
    right = diagnose(rig(MASS, 0.0), MODEL)
    assert right.verdict == "no_gap"
    assert not any("mass" in line for line in right.cannot_tell)


def test_a_force_that_is_late_shows_its_inertia_late() -> None:
    """What was taken off it was of the motion as recorded: of 15 kg a clock that is off by a sample left 16 N at each start and stop."""
    late, gain = 0.6 * STEP, 0.02
    prediction = Prediction(MODEL, rig(MASS, 0.0))
    values = {"setup.friction_force.clock": late, "setup.friction_force.gain": gain, NAME: MORE}
    moves = [np.gradient(motion, STEP) for motion in (TO_AND_FRO, TO_AND_FRO, FASTER, FASTER)]

    def shown(column: np.ndarray) -> np.ndarray:
        return (1 + gain) * np.interp(TIMES - late, TIMES, column)

    own = prediction.one().reshape(4, -1)
    expected = [shown(force + (MASS + MORE) * each) - MASS * each for force, each in zip(own, moves, strict=True)]
    assert prediction.one(values) == pytest.approx(np.concatenate(expected), abs=1e-9)
    many = prediction.many({**values, "setup.friction_force.clock": np.array([0.0, late, -late])})
    assert many[1] == pytest.approx(prediction.one(values), abs=1e-12)
    assert many[2] == pytest.approx(prediction.one({**values, "setup.friction_force.clock": -late}), abs=1e-12)
    for name, step in (("clock", CONSTANTS.clock_shift * STEP), ("gain", 1e-3), ("mass", 1e-3)):
        name = f"setup.friction_force.{name}"
        after, before = (prediction.one({**values, name: float(values[name]) + side * step}) for side in (1, -1))
        slope = prediction.setup.slopes(prediction.one(), name, values)
        assert slope == pytest.approx((after - before) / (2 * step), rel=1e-6, abs=1e-3 * float(np.max(np.abs(slope))))
    own_clock = {"setup.friction_force.gain": gain, "setup.friction_force.clock": late}
    massless = Prediction(MODEL, rig(0.0, 0.0)).sampled_at({"friction_force": late}).one(own_clock)
    sampled = prediction.sampled_at({"friction_force": late}).one({**own_clock, NAME: MORE})
    inertia = [(MASS + MORE) * shown(each) - MASS * each for each in moves]
    assert sampled == pytest.approx(massless + np.concatenate(inertia), abs=1e-9)
