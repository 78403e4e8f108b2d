"""Within which range can a record show anything of a quantity?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Nominal, Trial
from evat.inference.parameters import Scales, shape_parameters
from evat.model import Variable
from evat.models.contact import ContactModel
from toy import Toy


def test_a_quantity_of_another_unit_is_looked_for_about_its_start() -> None:
    """A fifth to five times that, of one that starts at nothing a fifth to five of its unit; a time between half a step and the record."""
    times = np.linspace(0.0, 2.0, 201)
    rig = Experiment(
        Path(), "a", "", Nominal({}, (), {}), {}, (Trial("a.csv", "a", {}, times, {"x": times}, {"F": times}),), None, "hash of no file"
    )
    scales = Scales(Toy(), rig)

    def span(unit: str, start: float) -> tuple[float, float]:
        return scales.span(Variable("p", unit, start, -100.0, 100.0, "of a test", "toy"))

    assert span("1", 0.0) == pytest.approx((0.2, 5.0))
    assert span("1", -3.0) == pytest.approx((0.6, 15.0))
    assert span("s", 1.0) == pytest.approx((0.005, 2.0))
    assert span("Hz", 1.0) == pytest.approx((0.25, 45.0))


def test_thicknesses_are_as_the_feeds_of_a_table() -> None:
    """Not as the width of the cut, which all rows share, nor as a way in a second that no table of means has: a power of the thickness was
    told at 2 mm, where no fit led back from."""
    feeds = np.geomspace(15e-6, 180e-6, 6)
    means = Means("means.csv", tuple("abcdef"), {"feed": feeds, "cutting_speed": np.ones(6)}, {"mean_principal_force": 1e6 * feeds}, {})
    model, nominal = ContactModel(threads=1), Nominal({"width": 2e-3, "amplitude_x": 0.0}, (), {})
    scales = Scales(model, Experiment(Path(), "a", "", nominal, {}, (), means, "hash of no file"))
    thickness = next(variable for variable in model.variables if variable.name == "size_effect.h_ref")
    low, high = scales.span(thickness)
    assert 15e-6 < low < high < 500e-6


def test_what_changes_for_good_does_so_along_the_recording() -> None:
    """Running-in that is over on the first hundredth of each recording, and begins anew in the next, was friction with a memory. A memory
    itself may be as short as it likes."""
    times = np.linspace(0.0, 4.0, 1601)
    slip = 0.003 * np.sign(np.sin(2 * np.pi * times))
    trials = (Trial("a.csv", "a", {}, times, {"slip_velocity": slip}, {"friction_force": 1e3 * slip}),)
    model = ContactModel(threads=1)
    scales = Scales(model, Experiment(Path(), "a", "", Nominal({}, (), {}), {}, trials, None, "hash of no file"))
    lengths = {p.name: p for effect in model.effects for p in shape_parameters(effect, scales) if p.unit == "m"}
    lasting, memory = lengths["friction_wear.s_0"], lengths["rate_and_state.d_c"]
    assert lasting.low == pytest.approx(CONSTANTS.shortest_lasting * 0.012, rel=1e-3)
    assert lasting.low < lasting.value(-2.0) < lasting.mean < lasting.value(2.0) <= lasting.high
    assert memory.low < 1e-5
