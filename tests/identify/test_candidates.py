"""Is an advised motion called what it is?"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from evat import motions
from evat.identification.verdicts.advice import candidates


def test_a_vibration_is_advised_by_its_amplitude_and_frequency() -> None:
    """F_S/sigma0 is a bristle's reach, sigma0/sigma1 the rate at which its damping bears as much as its stiffness."""
    record = SimpleNamespace(trials=[SimpleNamespace(inputs={"slip_velocity": np.array([0.0, 0.1, -0.2])})])
    values = {"F_C": 8.0, "F_S": 10.0, "sigma0": 1e6, "sigma1": 1e4, "v_s": 1e-3}
    advised = candidates(record, values, {})  # type: ignore[arg-type]
    (name,) = (name for name in advised if name.startswith("presliding vibration"))
    amplitude, frequency = motions.AMPLITUDES[0] * 1e-5, 100 / (2 * np.pi)
    told = name.removeprefix("presliding vibration of ").split(" at ")
    scale = {"u": 1e-6, "n": 1e-9, "m": 1e-3}
    number, unit = told[0].split()
    assert float(number) * scale[unit[0]] == pytest.approx(amplitude, rel=0.01)
    assert float(told[1].split()[0].removesuffix("Hz")) == pytest.approx(frequency, rel=0.01)
    assert any("0.2 m/s" in other or "200 mm/s" in other for other in advised)
