"""Does a diagnosis hang on the few samples at the ends of a record, of which nobody knows what went on before and after?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Experiment, SetupSd
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.law.initial_state import with_initial_state
from evat.inference.noise.ends import dying_away, unsure_ends
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import Prediction
from evat.models.contact import ContactModel
from independent_lugre import NOISE, TIMES, VALUES, world

STEP = float(TIMES[1])


def in_motion(samples: int = TIMES.size) -> Experiment:
    """Records that begin in motion and end where it has just turned, which is where friction is steepest."""
    experiment, times = world((0.0, 0.0, 0.0), "free"), STEP * np.arange(samples)
    trials = []
    for place, trial in enumerate(experiment.trials):
        speed = 0.004 * (1 + place // 2) * np.sin(2 * np.pi * 5 * (times + 0.004))
        force = np.resize(trial.outputs["friction_force"], samples)
        trials.append(replace(trial, times=times, inputs={"slip_velocity": speed}, outputs={"friction_force": force}))
    return replace(experiment, trials=tuple(trials))


def test_what_moves_beyond_a_record_is_unsure_as_far_as_a_clock_reaches() -> None:
    prediction, longer = Prediction(ContactModel(threads=1), in_motion()), Prediction(ContactModel(threads=1), in_motion(TIMES.size + 2))
    predicted, early = prediction.one(), prediction.one({"setup.friction_force.clock": -2 * STEP})
    whole = longer.one()
    for segment, own in zip(prediction.segments, longer.segments, strict=True):
        error = np.abs(early[segment.at] - whole[own.at][2:])
        unsure = unsure_ends(prediction, segment, predicted[segment.at])
        assert np.flatnonzero(unsure).tolist() == [0, 1, 498, 499]
        assert np.flatnonzero(error > 0.01).tolist() == [498, 499]
        assert np.all(error[498:] <= 2 * unsure[498:])
        assert np.max(error) > 2 * NOISE


def test_a_clock_that_reaches_one_sample_leaves_the_first_and_the_last_unsure() -> None:
    prediction = Prediction(ContactModel(threads=1), replace(in_motion(), setup_sd={"friction_force": SetupSd(clock=0.4 * STEP)}))
    for segment in prediction.segments:
        assert np.flatnonzero(unsure_ends(prediction, segment, prediction.measured[segment.at])).tolist() == [0, 499]


def test_a_clock_that_is_known_leaves_the_ends_sure() -> None:
    sure = {"friction_force": SetupSd(clock=0.0)}
    prediction = Prediction(ContactModel(threads=1), replace(in_motion(), setup_sd=sure))
    assert not any(np.any(unsure_ends(prediction, s, prediction.measured[s.at])) for s in prediction.segments)


def test_a_start_dies_away_faster_or_slower_than_one_model_has_it() -> None:
    """By a stiffness that is a tenth off: what is left of it is a tenth of what was, where its rate is free."""
    prediction = with_initial_state(Prediction(ContactModel(threads=1), in_motion()))
    other = with_initial_state(Prediction(ContactModel(threads=1), in_motion()), {"sigma0": 1.1 * VALUES["sigma0"]})
    for segment in prediction.segments:
        columns, truth = dying_away(prediction, segment), other.bent[segment.at]
        left = [truth - own @ np.linalg.lstsq(own, truth)[0] for own in (columns[:, :1], columns)]
        assert np.max(np.abs(left[0])) > NOISE
        assert np.max(np.abs(left[1])) < 0.1 * np.max(np.abs(left[0]))


def test_the_ends_do_not_decide() -> None:
    """A model that is wrong nowhere but there, as far as it may be, lost a hundred of log likelihood to one that guessed right."""
    prediction = with_initial_state(Prediction(ContactModel(threads=1), in_motion()))
    predicted = prediction.one()
    whitening = BandWhitening(prediction, estimate_noise(prediction, predicted), predicted)
    wrong = predicted + np.concatenate([unsure_ends(prediction, s, predicted[s.at]) for s in prediction.segments])
    right, other = (likelihood(whitening, whitening.sums(row, np.empty((row.size, 0))), np.empty(0)).log for row in (predicted, wrong))
    assert right - other == pytest.approx(0, abs=15)
