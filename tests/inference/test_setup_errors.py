"""Are gain, zero and clock of a whole set-up found, and are their derivatives right?"""

from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Experiment, SetupSd
from evat.gap import diagnose_with
from evat.inference.prediction import Prediction
from toy import Toy, measured

GAIN, ZERO, CLOCK = (f"setup.F.{kind}" for kind in ("gain", "zero", "clock"))


def set_up(made: Experiment, gain: float, zero: float, late: float) -> Experiment:
    """The same records by a set-up that is off in all trials alike."""
    trials = tuple(
        replace(trial, outputs={"F": (1 + gain) * np.interp(trial.times - late, trial.times, trial.outputs["F"]) + zero})
        for trial in made.trials
    )
    return replace(made, trials=trials)


def test_derivatives_are_those_of_the_prediction() -> None:
    prediction = Prediction(Toy(), measured())
    values = {"k": 11.0, GAIN: 0.02, ZERO: 0.1, CLOCK: -0.004}
    _, slopes = prediction.jacobian(values, ["k", GAIN, ZERO, CLOCK], {"k": 2.0, GAIN: 0.01, ZERO: 0.3, CLOCK: 0.01})
    inner = np.concatenate([np.arange(s.at.start + 1, s.at.stop - 1) for s in prediction.segments])  # a shift holds the ends
    for place, (name, scale) in enumerate({"k": 2.0, GAIN: 0.01, ZERO: 0.3, CLOCK: 0.01}.items()):
        h = 1e-4 * scale
        up, down = (prediction.one({**values, name: values[name] + side * h}) for side in (1, -1))
        slope = slopes[inner, place]
        assert pytest.approx((up - down)[inner] / 2e-4, abs=0.02 * np.abs(slope).max()) == slope, name


def test_a_late_jump_moves_by_whole_samples() -> None:
    """A clock is a shift in time, not a slope at a jump."""
    prediction = Prediction(Toy(), measured(conditions=1, repeats=1))
    row = np.where(np.arange(400) < 200, 0.0, 1.0)[None]
    assert np.array_equal(prediction.setup.applied(row, {CLOCK: 0.03})[0], np.where(np.arange(400) < 203, 0.0, 1.0))
    assert np.array_equal(prediction.setup.applied(row, {CLOCK: -0.03})[0], np.where(np.arange(400) < 197, 0.0, 1.0))


@pytest.mark.parametrize(("gain", "zero", "late"), [(0.015, 0.05, 0.008), (-0.015, -0.05, -0.008)])
def test_what_all_trials_share_is_the_set_up(gain: float, zero: float, late: float) -> None:
    """Either sign: no effect is named for it, and it is told with its size."""
    made = set_up(measured(noise=0.02, conditions=5), gain, zero, late)
    exact = replace(made.nominal, relative_sd={"k": 0.001})
    answer, _ = diagnose_with(replace(made, nominal=exact), Toy())
    assert answer.verdict == "no_gap"
    assert not answer.effects
    errors = answer.document()["setup"]["F"]
    for kind, truth in (("gain", gain), ("zero", zero), ("clock", late)):
        assert abs(errors[kind]["value"] - truth) < max(4 * errors[kind]["sd"], 0.1 * abs(truth)), kind


def test_what_is_stated_counts() -> None:
    """A clock that is exact is no parameter; a gain that is known to a tenth has that as its standard deviation."""
    made = replace(measured(), setup_sd={"F": SetupSd(gain=0.1, zero=0.5, clock=0.0, clock_drift=0.0)})
    known = {parameter.name: parameter.sd for parameter in Prediction(Toy(), made).setup.parameters}
    assert known == {GAIN: 0.1, ZERO: 0.5}
