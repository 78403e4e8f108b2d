"""Are recordings that are clipped, turned round or out of step with their repeats told as that, before an effect is blamed?"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from evat.experiment import Experiment
from evat.gap import diagnose
from evat.gap.search.recordings import clipped_share, misrecorded
from evat.inference.prediction import Prediction
from toy import Toy, measured

NOISE = np.random.default_rng(5).normal(size=4000)
SINE = 10 * np.sin(np.arange(4000) / 40)


def changed(place: int, change: Any, made: Experiment | None = None) -> Experiment:
    """With the force of one recording changed."""
    made = made or measured()
    trials = list(made.trials)
    trials[place] = replace(trials[place], outputs={"F": change(trials[place].outputs["F"])})
    return replace(made, trials=tuple(trials))


def told(made: Experiment) -> tuple[list[str], list[str]]:
    prediction = Prediction(Toy(), made)
    return misrecorded(prediction, prediction.one())


@pytest.mark.parametrize(
    ("values", "share"),
    [
        (SINE + NOISE, 0),
        (np.clip(SINE + NOISE, -8.0, 8.0), pytest.approx(float(np.mean(np.abs(SINE + NOISE) >= 8.0)))),
        (np.minimum(SINE + NOISE, 6.0), pytest.approx(float(np.mean(SINE + NOISE >= 6.0)))),
        (np.round(SINE + NOISE, 1), 0),  # quantised
        (np.round(SINE), 0),  # quantised, no noise: the last level has neighbours that have as many
        (np.round(SINE, 2), 0),
        (9.0 * np.sign(SINE), 0),  # Coulomb friction without noise
        (9.0 * np.sign(SINE) + 0.05 * NOISE, 0),
        (np.round(9.0 * np.sign(SINE) + 0.05 * NOISE, 1), 0),
    ],
)
def test_a_value_that_no_sample_goes_beyond_is_the_end_of_a_range(values: np.ndarray, share: Any) -> None:
    assert clipped_share(values) == share


def test_a_clipped_recording_is_refused() -> None:
    """It was a backlash, with 84 %."""
    made = measured()
    made = replace(made, trials=tuple(replace(t, outputs={"F": np.clip(t.outputs["F"], -1.5, 1.5)}) for t in made.trials))
    refused, notes = told(made)
    assert not notes
    assert "stand at its largest or smallest value" in refused[0]
    answer = diagnose(made, Toy())
    assert answer.verdict == "cannot_tell"
    assert told(measured()) == ([], [])


def test_some_peaks_that_are_cut_off_are_told() -> None:
    made = measured(conditions=2)
    most = float(np.quantile([np.abs(t.outputs["F"]) for t in made.trials], 0.97))
    made = replace(made, trials=tuple(replace(t, outputs={"F": np.clip(t.outputs["F"], -most, most)}) for t in made.trials))
    refused, (note,) = told(made)
    assert not refused
    assert note.startswith("F: 3 % of the samples")


def test_a_recording_with_its_sign_turned_is_named() -> None:
    """It was noise, and no gap."""
    refused, _ = told(changed(4, np.negative))
    assert refused == ["11.csv: F runs against the model where it runs with it in the other recordings; check its sign"]


def test_a_force_that_stays_on_one_side_has_its_sign() -> None:
    """Cuts of one thickness, in which heat had the force fall where the model has it rise, were refused."""
    made = measured(conditions=4)
    aside = [
        replace(trial, inputs={"x": trial.inputs["x"] + 20}, outputs={"F": trial.outputs["F"] + 20 * Toy.variables[2].start})
        for trial in made.trials
    ]
    force = aside[4].outputs["F"]
    aside[4] = replace(aside[4], outputs={"F": 2 * force.mean() - force})
    refused, _ = told(replace(made, trials=tuple(aside)))
    assert not [why for why in refused if "check its sign" in why]


@pytest.mark.parametrize(("by", "how"), [(50, "50 samples later"), (-30, "30 samples earlier")])
def test_a_repeat_that_is_out_of_step_is_named(by: int, how: str) -> None:
    refused, _ = told(changed(4, lambda force: np.roll(force, by)))
    assert refused == [f"11.csv: F comes {how} than in 10.csv, of which it is a repeat; check its trigger"]


def test_what_clocks_are_off_by_is_no_reason() -> None:
    """That is the set-up's, and fitted."""
    assert told(changed(4, lambda force: np.roll(force, 2))) == ([], [])
