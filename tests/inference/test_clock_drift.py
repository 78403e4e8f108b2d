"""Does a force whose clock runs faster than that of the motion make a gap? It is later in every period that follows, and no one clock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Experiment, SetupSd
from evat.gap import diagnose_with
from evat.inference.prediction import Prediction
from evat.models.contact import ContactModel
from independent_lugre import world

NAME = "setup.friction_force.clock_drift"
DRIFT = 3e-3  # s/s: 1.5 samples at the end of a recording


def drifting(drift: float, sd: float | None = None) -> Experiment:
    """What it measured, by a clock that drifts."""
    made = world((0.0, 0.0, 0.0), "relaxed")
    trials = []
    for trial in made.trials:
        late = drift * (trial.times - trial.times[0])
        shown = np.interp(trial.times - late, trial.times, trial.outputs["friction_force"])
        trials.append(replace(trial, outputs={"friction_force": shown}))
    stated = {} if sd is None else {"friction_force": SetupSd(clock_drift=sd)}
    return replace(made, trials=tuple(trials), setup_sd=stated)


def model() -> ContactModel:
    contact = ContactModel(threads=1)
    contact.effects = tuple(effect for effect in contact.effects if effect.name in ("direction_asymmetry", "dwell_strengthening"))
    return contact


def test_it_is_set_up_and_no_gap() -> None:
    wrong, _ = diagnose_with(drifting(DRIFT, 0.0), model())
    answer, _ = diagnose_with(drifting(DRIFT, 2e-3), model())
    assert answer.verdict in ("no_gap", "mistuned")
    told = answer.document()["setup"]["friction_force"]["clock_drift"]
    assert told["unit"] == "1"
    assert told["value"] == pytest.approx(DRIFT, rel=0.1)
    rows = [each.closure.rms["friction_force"] for each in (answer, wrong)]
    left, left_without = (row["recalibrated"] ** 2 - row["noise_floor"] ** 2 for row in rows)
    assert left < 0.4 * left_without


@pytest.mark.parametrize("clock", [0.0, 1.3e-3])
def test_its_slope_is_that_of_the_prediction(clock: float) -> None:
    prediction = Prediction(model(), drifting(0.0, 2e-3))
    values = {**{k: v for k, v in prediction.nominal.items() if isinstance(v, float)}, NAME: 1e-3, "setup.friction_force.clock": clock}
    _, slopes = prediction.jacobian(values, [NAME], {NAME: 2e-3})
    up, down = (prediction.one({**values, NAME: 1e-3 + side * 1e-4}) for side in (1, -1))
    smooth = np.abs(slopes[:, 0]) < 0.2 * np.abs(slopes).max()  # not where the force bends within a sample
    assert (up - down)[smooth] / 0.1 == pytest.approx(slopes[smooth, 0], abs=0.05 * np.abs(slopes).max())


def test_it_is_a_parameter_where_it_shows() -> None:
    """Not of 90 samples, in which two quartz clocks lose less than a fiftieth of one."""
    made = drifting(0.0)
    assert NAME in Prediction(model(), made).setup.names
    assert NAME not in Prediction(model(), replace(made, trials=tuple(trial.head(90) for trial in made.trials))).setup.names


def test_a_part_of_a_record_has_the_set_up_of_the_whole() -> None:
    """Too short to show a drift, it would take that for a variable of the model."""
    whole = Prediction(model(), drifting(0.0))
    part = whole.of(replace(whole.experiment, trials=tuple(trial.head(90) for trial in whole.experiment.trials)))
    assert part.setup.parameters == whole.setup.parameters
    assert not np.array_equal(part.one({NAME: 1e-3}), part.one())
