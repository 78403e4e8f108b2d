"""Does a velocity whose zero drifts from trial to trial make a gap, and is a slow motion taken for a rest?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Signal, Trial
from evat.gap import diagnose_with
from evat.inference.recorded_inputs import smoothed_inputs
from evat.inference.zeros_between_trials import (
    more_at_rest,
    where_at_rest,
    with_slow_motions_as_likeliest,
    without_zeros_between_trials,
    zeroed,
)
from evat.model import FloatArray
from evat.models.contact import ContactModel
from independent_lugre import NOISE, TIMES, lugre, world

WAIT = 0.25
ZEROS = (0.0, 4e-5, -3e-5, 6e-5, 1e-5, 2e-5)  # m/s: of 3e-3, by which bristles bend up to 1.5e-5 m while the contact rests


def drifting(zeros: Sequence[float] = ZEROS) -> Experiment:
    made = world((0.0, 0.0, 0.0), "relaxed", WAIT)
    trials = (replace(t, inputs={"slip_velocity": t.inputs["slip_velocity"] + zero}) for t, zero in zip(made.trials, zeros, strict=True))
    return replace(made, trials=tuple(trials))


def model() -> ContactModel:
    contact = ContactModel(threads=1)
    contact.effects = tuple(effect for effect in contact.effects if effect.name in ("direction_asymmetry", "dwell_strengthening"))
    return contact


def test_what_a_trial_reads_more_than_others_is_taken_from_it() -> None:
    freed, more = without_zeros_between_trials(model(), drifting())
    away = np.array(ZEROS) - np.mean(ZEROS)
    assert list(more.values()) == pytest.approx(away, abs=1e-12)
    for trial, before in zip(freed.trials, drifting([float(np.mean(ZEROS))] * 6).trials, strict=True):
        assert trial.inputs["slip_velocity"] == pytest.approx(before.inputs["slip_velocity"], abs=1e-12)


def test_it_is_no_gap_and_is_told() -> None:
    answer, _ = diagnose_with(drifting(), model())
    assert answer.verdict in ("no_gap", "mistuned")
    assert answer.closure.rms["friction_force"]["recalibrated"] < 1.2 * NOISE
    assert any("at rest 10.csv reads -4.67e-05 m/s beside the others" in each for each in answer.cannot_tell)
    assert answer.document()["setup"]["slip_velocity"]["zero"]["value"] == pytest.approx(np.mean(ZEROS), abs=3e-6)


def test_what_all_trials_read_is_left_to_the_fits() -> None:
    made = drifting([4e-5] * 6)
    assert not more_at_rest(made)
    assert without_zeros_between_trials(model(), made)[0] is made


def test_slow_motions_are_no_rests() -> None:
    """Each condition slides at a slow speed of its own between strokes: as recorded, the model has the force; as rests it has not."""
    made, trials = world((0.0, 0.0, 0.0), "relaxed", WAIT), []
    for trial in made.trials:
        speed = {"c0": 2e-5, "c1": 5e-5, "c2": 9e-5}[trial.condition]
        v = trial.inputs["slip_velocity"][::-1] + speed
        force = lugre(v, 0.0) + NOISE * np.random.default_rng(3).normal(size=TIMES.size)
        trials.append(replace(trial, inputs={"slip_velocity": v}, outputs={"friction_force": force}))
    slow = replace(made, trials=tuple(trials))
    assert len(more_at_rest(slow)) == 6
    assert without_zeros_between_trials(model(), slow) == (slow, {})


def test_what_ran_before_a_recording_has_its_zero() -> None:
    made = drifting()
    first = replace(made.trials[1], lead_in=made.trials[1].head(30))
    (trial,) = zeroed(replace(made, trials=(first,)), {first.file: ZEROS[1]}).trials
    assert trial.lead_in is not None
    assert trial.lead_in.inputs["slip_velocity"] == pytest.approx(0.0, abs=1e-15)


STEP, SD = 6e-5, 1.5e-5  # m/s: the last bit of a velocity, and its noise: at rest it reads 0, and now and then one bit less or more


def coarse(made: Experiment, offset: float = -2e-5) -> Experiment:
    """As a converter reads a velocity."""
    luck, trials = np.random.default_rng(5), []
    for trial in made.trials:
        read = trial.inputs["slip_velocity"] + offset + SD * luck.normal(size=TIMES.size)
        trials.append(replace(trial, inputs={"slip_velocity": STEP * np.round(read / STEP)}))
    return replace(made, trials=tuple(trials))


def test_a_contact_whose_velocity_reads_no_more_than_noise_rests() -> None:
    recorded = smoothed_inputs(coarse(world((0.0, 0.0, 0.0), "relaxed", WAIT)))
    slow = with_slow_motions_as_likeliest(model(), recorded, {"slip_velocity": "m/s"})
    waits = TIMES[0] + 0.9 * WAIT > TIMES
    for trial in slow.experiment.trials:
        assert not np.any(trial.inputs["slip_velocity"][waits])
    assert any(np.any(trial.inputs["slip_velocity"][waits]) for trial in recorded.experiment.trials)
    assert slow.perturbed is not None
    assert not np.any(slow.perturbed.trials[0].inputs["slip_velocity"][waits])
    assert "the contact was taken to rest" in slow.said


def test_slow_motions_within_the_noise_are_no_rests() -> None:
    made, trials = world((0.0, 0.0, 0.0), "relaxed", WAIT), []
    for trial in made.trials:
        v = trial.inputs["slip_velocity"] + {"c0": 2e-5, "c1": 5e-5, "c2": 4e-5}[trial.condition]
        force = lugre(v, 0.0) + NOISE * np.random.default_rng(3).normal(size=TIMES.size)
        trials.append(replace(trial, inputs={"slip_velocity": v}, outputs={"friction_force": force}))
    recorded = smoothed_inputs(coarse(replace(made, trials=tuple(trials)), 0.0))
    assert where_at_rest(recorded)
    slow = with_slow_motions_as_likeliest(model(), recorded, {"slip_velocity": "m/s"})
    assert "taken to rest" not in slow.said


def test_a_zero_that_changes_nothing_is_in_no_fit() -> None:
    """The load, which no friction level here follows. In the fit of the set-up alone it was held where it had been looked for."""
    made = world((0.0, 0.0, 0.0), "relaxed", WAIT)
    load = 50 + 5 * np.sin(30 * TIMES)
    trials = tuple(replace(trial, inputs={**trial.inputs, "normal_load": load}) for trial in made.trials)
    signals = {**made.signals, "normal_load": Signal("normal_load", "N", "N", "input")}
    _, comparison = diagnose_with(replace(made, trials=trials, signals=signals), model())
    names = {parameter.name for parameter in comparison.recalibrated.parameters}
    assert any("normal_load" in each.parameter.name for each in comparison.prediction.linearised)
    assert {parameter.name for parameter in comparison.set_up.parameters} <= names


SLIP_NOISE = 2e-3  # m/s


def read_twice(velocity: FloatArray) -> Experiment:
    """Two repeats at 8 samples a second, as of a pin on a disc; a velocity with noise, read to its last digit."""
    luck, made = np.random.default_rng(4), world((0.0, 0.0, 0.0), "relaxed", WAIT)
    times, force = np.arange(velocity.size) / 8, {"friction_force": np.zeros(velocity.size)}
    read = [velocity + SLIP_NOISE * luck.normal(size=velocity.size) for _ in range(2)]
    trials = [Trial(f"{k}.csv", "c0", {}, times, {"slip_velocity": each}, force) for k, each in enumerate(read)]
    return replace(made, trials=tuple(trials))


def test_short_rests_are_rests_and_end_where_the_motion_begins() -> None:
    """Runs of 1 m/s with ramps of four samples, and between them rests of a fiftieth of the recording: bristles crept there, and a motion
    began a sample too soon."""
    run = np.concatenate([[0.15, 0.5, 0.85], np.ones(74), [0.85, 0.5, 0.15]])
    velocity = np.concatenate([np.zeros(60), *[part for _ in range(4) for part in (run, np.zeros(8))], run])
    masks = where_at_rest(smoothed_inputs(read_twice(velocity)))
    assert np.array_equal(masks["0.csv"], velocity == 0)
    assert np.array_equal(masks["0.csv"], masks["1.csv"])


def test_a_motion_that_turns_round_is_no_rest() -> None:
    """Slowly enough for some 15 samples within the noise, from one end of it to the other."""
    velocity = np.concatenate([np.zeros(80), 0.1 * np.sin(np.linspace(0, 2.5 * np.pi, 500))[20:]])
    masks = where_at_rest(smoothed_inputs(read_twice(velocity)))
    assert np.count_nonzero(np.abs(velocity[100:]) < CONSTANTS.noise_at_rest * SLIP_NOISE) >= 20
    assert np.all(masks["0.csv"][:80])
    assert not np.any(masks["0.csv"][100:])
