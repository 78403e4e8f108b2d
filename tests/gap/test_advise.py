"""Is what is advised something that can be set?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.experiment import Trial
from evat.gap.advise import scaled
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
