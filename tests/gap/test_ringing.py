"""Is a dynamometer that rings named, though what it does shows near its own period only?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from evat.experiment import Experiment, Nominal, Trial
from evat.gap import diagnose
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel
from scipy.signal import cont2discrete, lfilter

PERIOD, DAMPING, STEP, SAMPLES, BEFORE = 1 / 95e3, 0.06, 1e-6, 300, 250  # BEFORE: five cycles, which nobody records
CUT: dict[str, float | str] = {
    "kinematics": "combined",
    "amplitude_x": 5e-6,
    "amplitude_y": 4e-6,
    "vibration_frequency": 20e3,
    "width": 1e-3,
    "shear_stress": 4e8,
    "F_C": 3.0,
    "F_S": 3.4,
    "sigma0": 2e6,
    "sigma1": 1.0,
    "sigma2": 1.5,
    "v_s": 0.05,
}
CHANNELS = ("principal_force", "feed_force")


def ringing(force: FloatArray) -> FloatArray:
    """Behind a platform on its quartzes, made by scipy."""
    rate = 2 * np.pi / PERIOD
    numerator, denominator, _ = cont2discrete(([rate**2], [1, 2 * DAMPING * rate, rate**2]), STEP / 4, method="bilinear")
    return np.asarray(lfilter(numerator.ravel(), denominator, force))


def test_a_platform_that_rings_between_two_harmonics_of_the_vibration_is_named() -> None:
    """A resonance shows within a tenth of its own period only: of nine that were tried over the record none was that near, what is
    plausible lay a thousand prior standard deviations below it, and the cause was unknown."""
    model, draw, trials = ContactModel(threads=1), np.random.default_rng(4), list[Trial]()
    fine, times = np.arange(4 * (BEFORE + SAMPLES)) * STEP / 4, np.arange(SAMPLES) * STEP
    for place, speed in enumerate((0.1, 0.25, 0.35)):
        values = {"cutting_speed": speed, "feed": 1e-5}
        clean = model.simulate(Run(fine, {}, CHANNELS), (), {**CUT, **values})
        for repeat in range(2):
            outputs = {name: ringing(clean[name])[4 * BEFORE :: 4] + 0.3 * draw.normal(size=SAMPLES) for name in CHANNELS}
            trials.append(Trial(f"{place}{repeat}.csv", f"c{place}", values, times, {}, outputs))
    sd = dict.fromkeys(("shear_stress", "F_C", "F_S", "sigma0", "sigma1", "sigma2", "v_s"), 0.1)
    answer = diagnose(Experiment(Path(), "rings", "", Nominal(CUT, (), sd), {}, tuple(trials), None, ""), model)
    assert [each.name for each in answer.effects] == ["dynamometer_resonance"]
    period, sd_of_it, _ = answer.effects[0].parameters["natural_period"]
    assert abs(period / PERIOD - 1) < 0.02
    assert answer.closure.closed_share > 0.8
    assert sd_of_it < 0.02 * period
