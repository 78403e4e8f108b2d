"""Within which range can a record show anything of a quantity?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Trial
from evat.inference.parameters import Scales
from evat.model import Variable
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
