"""Is it told why a recalibration leaves more newtons than plain least squares did?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Nominal, Trial
from evat.gap.search.compare import compare
from evat.gap.verdict.raised import raised
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel
from rig import VALUES
from scipy.optimize import least_squares
from scipy.signal import lfilter

NAMES = ("F_C", "F_S", "v_s", "sigma0", "sigma1", "sigma2")
START = np.array([float(VALUES[name]) for name in NAMES])
MODEL = ContactModel(threads=1)
MODEL.effects = ()


def by_plain_least_squares(made: Experiment) -> Experiment:
    """The same with nominal values that were fitted to it, as most people's are."""
    prediction = Prediction(MODEL, made)

    def residual(u: FloatArray) -> FloatArray:
        return prediction.one(dict(zip(NAMES, START * np.exp(u), strict=True))) - prediction.measured

    def slopes(u: FloatArray) -> FloatArray:
        values = dict(zip(NAMES, map(float, START * np.exp(u)), strict=True))
        return prediction.jacobian(values, NAMES, values)[1]

    u = least_squares(residual, np.zeros(len(NAMES)), slopes, bounds=(-2.5, 2.5), max_nfev=25).x
    fitted = dict(zip(NAMES, map(float, START * np.exp(u)), strict=True))
    return replace(made, nominal=Nominal({**VALUES, **fitted}, (), {}, initial_bristle="relaxed"))


def made_with(scatter: float) -> Experiment:
    """Strokes of three sizes after a rest, twice each; the force comes late, and its gain changes from trial to trial."""
    draw, times, trials = np.random.default_rng(1), np.arange(500) * 1e-3, list[Trial]()
    for place in range(3):
        slip = 0.004 * (1 + place) * np.sin(2 * np.pi * 5 * np.maximum(times - 0.08, 0))
        run = Run(times, {"slip_velocity": slip}, ("friction_force",))
        force = MODEL.simulate(run, (), {**VALUES, "sigma0": 2e5})["friction_force"]
        force = np.interp(times - 0.002, times, force)
        for repeat in range(2):
            gain = 1 + 0.05 * np.sign(force) + scatter * draw.normal()
            noise = lfilter([1.0], [1.0, -0.9], 0.02 * draw.normal(size=times.size + 500))[500:]
            trials.append(Trial(f"{place}{repeat}", f"c{place}", {}, times, run.inputs, {"friction_force": gain * force + noise}))
    return Experiment(Path(), "rig", "", Nominal(VALUES, (), {}, initial_bristle="relaxed"), {}, tuple(trials), None, "")


@pytest.mark.parametrize("scatter", [0.0, 0.4])
def test_gains_that_differ_raise_the_plain_rms(scatter: float) -> None:
    """Levels are worth little there, shapes much; without the scatter the plain rms falls."""
    comparison = compare(Prediction(MODEL, by_plain_least_squares(made_with(scatter))))
    residuals = [comparison.prediction.measured - fit.predicted for fit in (comparison.nominal, comparison.recalibrated)]
    before, after = (float(np.sqrt(np.mean(row**2))) for row in residuals)
    assert comparison.recalibrated.likelihood.evidence > comparison.nominal.likelihood.evidence
    said = raised(comparison)
    if not scatter:
        assert not said
        return
    assert after > CONSTANTS.noticeable_rise * before
    (sentence,) = said
    assert f"raises the plain rms from {before:.4g} to {after:.4g}" in sentence
    assert "gains differ by" in sentence
