"""Is turning without vibration diagnosed from records that are far too slow for a vibration, which there is none of?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.gap import diagnose
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

MODEL = ContactModel(threads=2)
TURNING: dict[str, float | str] = {
    "kinematics": "internal", "friction_law": "amontons", "amontons.mu": 0.6, "shear_stress": 4e8, "width": 2e-3, "amplitude_x": 0.0,
    "amplitude_y": 0.0,
}  # fmt: skip
OUTPUTS = ("principal_force", "feed_force")
TIMES: FloatArray = np.arange(800) / 2000.0
RUN_OUT = {"run_out.amplitude": 12e-6, "run_out.spindle_frequency": 14.0, "run_out.phase": 0.7}


def recorded(on: tuple[str, ...] = ()) -> Experiment:
    trials, luck = [], np.random.default_rng(5)
    for place, feed in enumerate((8e-5, 1.2e-4, 1.8e-4)):
        own = {**TURNING, **(RUN_OUT if on else {}), "feed": feed, "cutting_speed": 1.5 + place}
        rows = MODEL.simulate(Run(TIMES, {}, OUTPUTS), on, own)
        for repeat in range(2):
            noisy = {name: rows[name] + luck.normal(scale=2.0, size=TIMES.size) for name in OUTPUTS}
            values = {"feed": feed, "cutting_speed": 1.5 + place}
            trials.append(Trial(f"{place}-{repeat}.csv", f"c{place}", values, TIMES, {}, noisy))
    signals = {"time": Signal("time", "t", "s", None)} | {name: Signal(name, name, "N", "output") for name in OUTPUTS}
    nominal = Nominal({**TURNING, "shear_stress": 4.2e8}, (), {"width": 0.0, "amplitude_x": 0.0, "amplitude_y": 0.0})
    return Experiment(Path(), "turning", "", nominal, signals, tuple(trials), None, "hash of no file")


@pytest.mark.parametrize(("on", "named"), [((), set()), (("run_out",), {"run_out"})], ids=["none", "run-out"])
def test_a_record_of_turning_is_diagnosed_at_2_kHz(on: tuple[str, ...], named: set[str]) -> None:
    """The vibration frequency, which the component has whatever the amplitudes, is ten times the rate of sampling."""
    answer = diagnose(recorded(on), MODEL)
    assert answer.verdict in ({"effect"} if on else {"no_gap", "mistuned"})
    assert {effect.name for effect in answer.effects} == named
    assert not any("vibration" in line for line in answer.cannot_tell)
