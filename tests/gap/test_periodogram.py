"""Is a sine found whose frequency, period or phase nobody knows, also where each recording has a phase of its own?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Experiment
from evat.gap import diagnose
from evat.gap.search.starts import screen
from evat.gap.search.starts.periodogram import TIME, WAY, Peak, peaks
from evat.inference.band_whitening import BandWhitening
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import OWN, Prediction
from evat.model import FloatArray
from rig import MODEL, STEP, measured

HUM, PERIOD = 37.3, 1.3e-4  # Hz, m
LAG = np.random.default_rng(8).uniform(-np.pi, np.pi, 12)


def with_hum(experiment: Experiment, own: bool) -> Experiment:
    """A hum of 1 N, in step with every recording or with none."""
    trials = []
    for place, trial in enumerate(experiment.trials):
        hum = np.sin(2 * np.pi * HUM * trial.times + (LAG[place] if own else 0.4))
        trials.append(replace(trial, outputs={name: column + hum for name, column in trial.outputs.items()}))
    return replace(experiment, trials=tuple(trials))


def with_ripple(experiment: Experiment) -> Experiment:
    """A cogging force of 1 N; each condition begins elsewhere."""
    trials = []
    for place, trial in enumerate(experiment.trials):
        force = np.sin(2 * np.pi * position(trial.inputs["slip_velocity"]) / PERIOD + LAG[place // 3])
        trials.append(replace(trial, outputs={name: column + force for name, column in trial.outputs.items()}))
    return replace(experiment, trials=tuple(trials))


def position(velocity: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(STEP * (velocity[1:] + velocity[:-1]) / 2)])


def seen(experiment: Experiment, unit: str, apart: bool = False, fewest: float | None = None) -> list[Peak]:
    prediction = Prediction(MODEL, experiment)
    prediction = prediction.each_apart() if apart else prediction
    predicted = prediction.one()
    fewest = {TIME: 4, WAY: 0.5}[unit] if fewest is None else fewest
    return peaks(prediction, BandWhitening(prediction, estimate_noise(prediction, predicted), predicted), predicted, unit, fewest)


def test_the_highest_peak_is_the_hum() -> None:
    first, own, *_ = seen(with_hum(measured(repeats=2), own=False), TIME)
    assert first.value == pytest.approx(HUM, abs=0.25 / 0.4)
    assert not first.phases
    assert np.ptp(list(own.phases.values())) < 0.3  # of all conditions


def test_a_short_cut_is_a_turn_of_a_spindle_or_two() -> None:
    """What rises twice within the longest recording is a drift of a sensor, and may be the run-out of a work that turns."""
    experiment = with_hum(measured(repeats=2), own=False)
    long = max(float(np.ptp(trial.times)) for trial in experiment.trials)
    turns = HUM * long
    assert seen(experiment, TIME, fewest=1.2 * turns)[0].value != pytest.approx(HUM, abs=0.5 / long)
    assert seen(experiment, TIME, fewest=0.5 * turns)[0].value == pytest.approx(HUM, abs=0.5 / long)
    effects = {effect.name: effect for effect in MODEL.effects}
    run_out, line = (screen._fewest_periods(effects[name], TIME) for name in ("run_out", "line_disturbance"))
    assert run_out < 2 < line


def test_a_hum_out_of_step_has_a_phase_in_each_recording() -> None:
    experiment = with_hum(measured(), own=True)
    _, own, *_ = seen(experiment, TIME, apart=True)
    phases = np.array([own.phases[trial.file] for trial in experiment.trials])
    away = np.angle(np.exp(1j * (phases - (LAG - LAG[0]))))
    assert np.max(np.abs(away)) < 0.3


def test_a_ripple_over_the_position_has_a_phase_in_each_condition() -> None:
    shared, own, *_ = seen(with_ripple(measured()), WAY)
    assert shared.value == pytest.approx(PERIOD, rel=0.03)
    phases = np.array([own.phases[f"c{place}"] for place in range(4)])
    assert np.max(np.abs(np.angle(np.exp(1j * (phases - (LAG[:4] - LAG[0])))))) < 0.5


def test_phases_of_a_hum_are_told_from_where_the_clocks_of_the_files_begin() -> None:
    """They were told from where each recording begins; the model counts by its clock, and a hum of 20 times the noise was `unknown`."""
    made = measured()
    begins = np.repeat([0.0, 0.9, 1.807, 2.711], 3)
    late = [replace(trial, times=trial.times + begin) for trial, begin in zip(made.trials, begins, strict=True)]
    _, own, *_ = seen(with_hum(replace(made, trials=tuple(late)), own=True), TIME, apart=True)
    assert own.value == pytest.approx(HUM, abs=0.02 / 0.4)
    phases = np.array([own.phases[trial.file] for trial in made.trials])
    assert np.max(np.abs(np.angle(np.exp(1j * (phases - (LAG - LAG[0])))))) < 0.5


def test_phases_of_a_ripple_are_told_from_the_begin_of_the_lead_in() -> None:
    """They were told from where the recording begins; the model is run from the begin of the lead-in, of another length in each."""
    made, trials = with_ripple(measured()), []
    for place, trial in enumerate(made.trials):
        lead = 20 * (place // 3)
        trials.append(replace(trial.between(lead, trial.times.size), lead_in=trial.between(0, lead) if lead else None))
    _, own, *_ = seen(replace(made, trials=tuple(trials)), WAY)
    phases = np.array([own.phases[f"c{place}"] for place in range(4)])
    assert np.max(np.abs(np.angle(np.exp(1j * (phases - (LAG[:4] - LAG[0])))))) < 0.5


def test_a_value_of_its_own_acts_where_it_belongs() -> None:
    experiment = measured(repeats=2)
    prediction, name = Prediction(MODEL, experiment), "line_disturbance.phase"
    values = {"line_disturbance.friction_force": 1.0, "line_disturbance.frequency": HUM, name: 0.2}
    on = ("line_disturbance",)
    plain = prediction.one(values, on)
    for key, places in (("c1", [2, 3]), ("30.csv", [6])):
        moved = prediction.one({**values, f"{name}{OWN}{key}": 0.5}, on)
        other = prediction.one({**values, name: 0.7}, on)
        for place, segment in enumerate(prediction.segments):
            assert np.array_equal(moved[segment.at], (other if place in places else plain)[segment.at])


def test_two_phases_that_are_more_than_a_turn_together_are_less_a_turn() -> None:
    """A fit that went to 2 pi was beyond the bounds of a phase in each recording that has one of its own, and the diagnosis ended there."""
    prediction, name, on = Prediction(MODEL, measured()), "line_disturbance.phase", ("line_disturbance",)
    values = {"line_disturbance.friction_force": 1.0, "line_disturbance.frequency": HUM}
    for phase, own in ((2 * np.pi, 0.5), (-2 * np.pi, -3.0)):
        beyond = prediction.one({**values, name: phase, f"{name}{OWN}c1": own}, on)
        within = prediction.one({**values, name: 0.0, f"{name}{OWN}c1": own}, on)
        assert np.max(np.abs(beyond - within)) < 1e-9


def test_a_hum_out_of_step_with_all_recordings_is_a_line() -> None:
    answer = diagnose(with_hum(measured(), own=True), MODEL)
    assert (answer.verdict, [effect.name for effect in answer.effects]) == ("effect", ["line_disturbance"])
    assert answer.effects[0].parameters["frequency"][0] == pytest.approx(HUM, rel=1e-3)
    assert answer.effects[0].parameters["friction_force"][0] == pytest.approx(1.0, rel=0.1)


def test_a_ripple_is_named_where_each_condition_begins_elsewhere() -> None:
    answer = diagnose(with_ripple(measured()), MODEL)
    assert (answer.verdict, [effect.name for effect in answer.effects]) == ("effect", ["position_dependence"])
    assert answer.effects[0].parameters["period"][0] == pytest.approx(PERIOD, rel=0.01)
    (note,) = (note for note in answer.cannot_tell if note.startswith("position_dependence.phase"))
    assert all(f"in c{place}" in note for place in range(4))


def test_a_period_longer_than_the_travel_is_doubted() -> None:
    """A force that bends with the position: of a pitch of several strokes a hundredth of one was seen."""
    experiment, trials = measured(), []
    for trial in experiment.trials:
        x = position(trial.inputs["slip_velocity"])
        trials.append(replace(trial, outputs={name: column + 3 * (x / np.ptp(x)) ** 2 for name, column in trial.outputs.items()}))
    answer = diagnose(replace(experiment, trials=tuple(trials)), MODEL)
    assert answer.verdict != "effect" or "position_dependence" not in {effect.name for effect in answer.effects}
    doubts = [why for on, why in answer.judgement.features.doubts.items() if "position_dependence" in on]
    assert any("is longer than the way that was recorded" in " ".join(why) for why in doubts)
