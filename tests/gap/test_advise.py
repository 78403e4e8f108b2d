"""Is what is advised something that can be set?"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Nominal, Trial
from evat.gap.advise import _options, scaled
from evat.model import Variable
from evat.models.contact import ContactModel

KNOWN: dict[str, Variable] = {variable.name: variable for variable in ContactModel(1).variables}


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0, 4.0])
def test_a_temperature_rises_more_or_less_above_the_ambient_one(factor: float) -> None:
    """A quarter of 340 K is no temperature of a rig."""
    warm = np.linspace(293.15, 340.0, 50)
    trial = Trial("a", "a", {}, np.arange(50.0), {"contact_temperature": warm}, {"friction_force": np.ones(50)})
    other = scaled(trial, KNOWN["contact_temperature"], factor)
    assert other is not None
    assert other.inputs["contact_temperature"] == pytest.approx(293.15 + factor * (warm - 293.15))


def test_a_speed_is_multiplied_and_a_bound_is_a_bound() -> None:
    trial = Trial(
        "a", "a", {"rake_angle": 0.6}, np.arange(3.0), {"slip_velocity": np.array([1.0, -1.0, 2.0])}, {"friction_force": np.ones(3)}
    )
    other = scaled(trial, KNOWN["slip_velocity"], 2.0)
    assert other is not None
    assert other.inputs["slip_velocity"].tolist() == [2.0, -2.0, 4.0]
    assert scaled(trial, KNOWN["rake_angle"], 4.0) is None


@pytest.mark.parametrize(("name", "zero"), [("contact_temperature", 293.15), ("slip_velocity", 0.0)])
def test_means_are_multiplied_from_the_same_zero(name: str, zero: float) -> None:
    """Each factor of the first condition's value, the others as they are there; what would be out of bounds is left out."""
    size = {"contact_temperature": 340.0, "slip_velocity": 0.4}[name]
    values = {name: np.array([size, 2 * size]), "rake_angle": np.array([0.1, 0.2])}
    means = Means("m.csv", ("a", "b"), values, {"friction_force": np.array([1.0, 2.0])}, {})
    rig = Experiment(Path(), "means", "", Nominal({}, (), {}), {}, (), means, "hash of no file")
    compared: Any = SimpleNamespace(prediction=SimpleNamespace(model=SimpleNamespace(variables=tuple(KNOWN.values()))))
    options = [(said[name], changed.means) for said, changed in _options(compared, rig) if name in said]
    assert [value for value, _ in options] == pytest.approx([zero + factor * (size - zero) for factor in CONSTANTS.next_experiment_factors])
    for value, changed in options:
        assert changed is not None
        assert changed.values[name].tolist() == [value]
        assert changed.values["rake_angle"].tolist() == [0.1]
    angles = [said["rake_angle"] for said, _ in _options(compared, rig) if "rake_angle" in said]
    assert angles == pytest.approx([0.1 * f for f in CONSTANTS.next_experiment_factors if 0.1 * f <= KNOWN["rake_angle"].max])
