"""Is a record whose channels are late by part of a sample compared with a run that is, jumps and all?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.gap import diagnose_with
from evat.gap.search import compare as comparing
from evat.gap.search import recalibration
from evat.identification import Settings, identify
from evat.inference.band_whitening import BandWhitening
from evat.inference.clocks import with_clocks
from evat.inference.fit import Fit
from evat.inference.noise.ends import unsure_ends
from evat.inference.prediction import Prediction
from evat.inference.setup.clock import sample_times
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

MODEL = ContactModel(threads=1)
STEP = 8e-7  # s, between samples: 60 a cycle
TIMES: FloatArray = 3e-5 + STEP * np.arange(240)
VALUES: dict[str, float | str] = {
    "kinematics": "internal", "friction_law": "lugre", "initial_state": "periodic", "F_C": 1.0, "F_S": 1.5, "sigma0": 8e6, "sigma1": 0.04,
    "sigma2": 0.6, "v_s": 0.06, "width": 1.5e-3, "feed": 4e-6, "shear_stress": 4.5e8,
}  # fmt: skip
LATE = {"principal_force": 0.45 * STEP, "feed_force": -0.4 * STEP}
FORCES = tuple(LATE)


def recorded(
    late: dict[str, float], noise: float = 0.0, first: float = 3e-5, drift: float = 0.0, effects: Mapping[str, float] | None = None
) -> Experiment:
    """effects : values of parameters, by the names of effects that act."""
    on, own = tuple(name.partition(".")[0] for name in effects or {}), dict(effects or {})
    chance, trials, times = np.random.default_rng(5), [], first - TIMES[0] + TIMES
    for place, speed in enumerate((0.1, 0.2, 0.35, 0.6)):
        outputs = {}
        for force in FORCES:
            shown = times - late.get(force, 0.0) - drift * (times - times[0])
            run = MODEL.simulate(Run(shown, {}, (force,)), on, {**VALUES, **own, "cutting_speed": speed})
            outputs[force] = run[force] + noise * chance.normal(size=TIMES.size)
        trials.append(Trial(f"{place}.csv", f"c{place}", {"cutting_speed": speed}, times, {}, outputs))
    signals = {force: Signal(force, force, "N", "output") for force in FORCES}
    sure = {name: 0.1 for name in ("F_C", "F_S", "sigma0", "sigma1", "sigma2", "v_s", "shear_stress")}
    return Experiment(Path(), "cut", "", Nominal(dict(VALUES), (), sure), signals, tuple(trials), None, "")


def test_one_run_is_sampled_where_each_channel_was() -> None:
    times = np.array([1.0, 2.0, 3.0])
    sampled, (late, early) = sample_times(times, [0.25, -0.25])
    assert np.array_equal(sampled[late], [1.0, 1.75, 2.75])  # none before the run begins
    assert np.array_equal(sampled[early], [1.25, 2.25, 3.25])
    assert np.all(np.diff(sampled) > 0)
    assert sample_times(times, [0.0, 0.0])[0] is times


def test_a_run_so_sampled_is_the_record() -> None:
    """And interpolation is not: half of the way between two samples friction has one sign or the other."""
    prediction = Prediction(MODEL, recorded(LATE, first=0.0))
    names = {f"setup.{force}.clock": late for force, late in LATE.items()}
    held = prediction.sampled_at(LATE)
    error = held.one() - prediction.measured
    for segment in prediction.segments:
        unsure = unsure_ends(prediction, segment, held.one()[segment.at])
        assert np.all(np.abs(error[segment.at]) < 2e-3 + unsure)  # a run shows nothing of before it begins
        assert set(np.flatnonzero(unsure)) <= {0, 1, TIMES.size - 2, TIMES.size - 1}
    assert np.max(np.abs(error)) > 0.05
    assert np.array_equal(held.one(), held.one(names))
    assert np.array_equal(held.one(), prediction.one(names))  # what is named counts, whatever the run was sampled at
    assert np.array_equal(prediction.one(), held.one(dict.fromkeys(names, 0.0)))
    interpolated = Prediction(MODEL, prediction.experiment)
    interpolated.jumps = False
    assert np.max(np.abs(interpolated.one(names) - prediction.measured)) > 0.3
    part = held.of(replace(held.experiment, trials=held.experiment.trials[:2]))
    assert np.array_equal(part.one(), held.one()[: part.measured.size])


def test_a_model_is_sampled_by_clocks_and_drifts_of_its_own() -> None:
    """Those of another model, shifted by interpolation, rounded its jumps: a phase of the ellipse was as unlikely as that was far."""
    drift = 4e-4
    recorded_late = Prediction(MODEL, recorded(LATE, first=0.0, drift=drift))
    prediction = recorded_late.sampled_at({"feed_force": 0.3 * STEP})
    values = {f"setup.{force}.{kind}": each for force, late in LATE.items() for kind, each in (("clock", late), ("clock_drift", drift))}
    assert set(values) <= set(prediction.setup.names)
    inner = ~np.isin(np.arange(prediction.measured.size) % TIMES.size, (0, 1, TIMES.size - 1))  # a run shows nothing of before it begins
    here, slopes = prediction.jacobian(values, list(values), dict.fromkeys(values, 1.0))
    assert np.max(np.abs((prediction.one(values) - prediction.measured)[inner])) < 0.06  # forces go by the steps between samples
    assert np.array_equal(here, prediction.one(values))
    assert np.all(np.any(slopes, axis=0))
    lanes = {**values, "F_C": np.array([1.0, 1.1])}
    assert np.array_equal(prediction.many(lanes)[0], prediction.one({**values, "F_C": 1.0}))


def test_a_jump_may_be_just_beyond_a_record() -> None:
    """The tool leaves the work just before the record begins: a channel that is a part of a sample late shows it once more. Where the
    motion is an input the ends tell what goes on there."""
    predicted = np.where(np.arange(TIMES.size) < 120, 0.0, 5.0)
    prediction = Prediction(MODEL, recorded({}))
    assert unsure_ends(prediction, prediction.segments[0], predicted)[[0, -1]].tolist() == [5.0, 5.0]
    prediction.jumps = False
    assert not np.any(unsure_ends(prediction, prediction.segments[0], predicted))


def test_clocks_are_told_by_jumps() -> None:
    held = with_clocks(Prediction(MODEL, recorded(LATE, noise=0.01)))
    assert held.setup.clocks == pytest.approx(LATE, abs=0.13 * STEP)
    assert with_clocks(Prediction(MODEL, recorded({}, noise=0.01))).setup.clocks == {}


def test_no_clock_is_held_where_the_motion_is_an_input() -> None:
    motion = {"slip_velocity": np.sin(1e5 * TIMES)}
    trial = Trial("a.csv", "a", {}, TIMES, motion, {"friction_force": np.sign(np.sin(1e5 * (TIMES - 0.4 * STEP)))})
    signals = {"friction_force": Signal("friction_force", "F", "N", "output")}
    rig = Experiment(Path(), "rig", "", Nominal({"kinematics": "external"}, (), {}), signals, (trial,), None, "")
    prediction = Prediction(MODEL, rig)
    assert with_clocks(prediction) is prediction


def test_an_identification_says_that_a_channel_is_late() -> None:
    settings = Settings(population=24, generations=10, seed=1)
    late = identify(recorded(LATE, noise=0.01), MODEL, ["F_C", "sigma1"], settings)
    words = [doubt for doubt in late.doubts if "than it was recorded" in doubt]
    assert [doubt.split(" better ")[0] for doubt in words] == ["the model meets principal force", "the model meets feed force"]
    assert "later" in words[0]
    assert "earlier" in words[1]
    assert not any(
        "than it was recorded" in doubt for doubt in identify(recorded({}, noise=0.01), MODEL, ["F_C", "sigma1"], settings).doubts
    )


def test_a_clock_is_no_error_of_an_input(monkeypatch: pytest.MonkeyPatch) -> None:
    """What as good inputs would change is nothing where they are the same: with runs of other clocks it was the clock."""
    monkeypatch.setattr(comparing, "_searched", lambda *_: comparing._Searched({}, {}, (), {}))
    prediction = Prediction(MODEL, recorded(LATE, noise=0.015))
    alone, beside = (comparing.compare(prediction, perturbed=other).recalibrated for other in (None, prediction))
    assert beside.likelihood.evidence == pytest.approx(alone.likelihood.evidence, abs=1e-6)


def test_no_parameter_stands_in_for_a_clock() -> None:
    """sigma1 went sixteen of its standard deviations away, and the gap was unknown."""
    answer, comparison = diagnose_with(recorded(LATE, noise=0.015), MODEL)
    assert answer.verdict in ("no_gap", "mistuned")
    away = dict(zip((p.name for p in comparison.recalibrated.parameters), comparison.recalibrated.point, strict=True))
    assert abs(away["sigma1"]) < 2
    for force, late in LATE.items():
        assert comparison.recalibrated.values[f"setup.{force}.clock"] == pytest.approx(late, abs=0.15 * STEP)


def test_what_a_late_force_shows_of_before_the_run_moves_no_parameter(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first sample of a late channel is of before the record, where no run is: sigma0 stood in for it, by 15 sd."""
    monkeypatch.setattr(comparing, "_offered", lambda _: [])
    recalibrated = comparing.compare(Prediction(MODEL, recorded({"feed_force": 0.63 * STEP}, 0.004, first=1e-5))).recalibrated
    fitted = {name: value for name, value in VALUES.items() if name in recalibrated.sd}
    assert {"F_C", "sigma0", "shear_stress"} < set(fitted)
    for name, value in fitted.items():
        assert recalibrated.values[name] == pytest.approx(value, abs=3 * recalibrated.sd[name]), name


def test_a_vibration_has_another_clock_than_its_record(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces come later and later: by 0.06 of a sample at the end, which is many times the noise where friction reverses."""
    monkeypatch.setattr(comparing, "_offered", lambda _: [])
    recalibrated = comparing.compare(Prediction(MODEL, recorded({}, 0.004, drift=2.5e-4))).recalibrated
    for force in FORCES:
        told = f"setup.{force}.clock_drift"
        assert recalibrated.values[told] == pytest.approx(2.5e-4, abs=3 * recalibrated.sd[told])
        assert recalibrated.sd[told] < 8e-5


def test_clocks_are_told_more_finely_beside_a_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """An eighth of a sample is what the first search tells; friction that reverses within one stands in for what is left."""
    monkeypatch.setattr(comparing, "_offered", lambda _: [])
    late = {"principal_force": 0.44 * STEP, "feed_force": -0.3 * STEP}
    prediction = Prediction(MODEL, recorded(late, 0.004))
    first, values = with_clocks(prediction).setup.clocks, comparing.compare(prediction).recalibrated.values
    told = {force: values[f"setup.{force}.clock"] for force in FORCES}
    assert max(abs(first[force] - late[force]) for force in FORCES) > 0.04 * STEP
    assert told == pytest.approx(late, abs=0.035 * STEP)
    sampled = comparing.compare(Prediction(MODEL, recorded({}, 0.004))).prediction.setup.clocks
    assert max(map(abs, sampled.values()), default=0.0) < 0.035 * STEP


def test_no_clock_stands_in_for_what_is_still_to_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sensor that rings leaves a tenth of the force: clocks beside a fit to that took its lag for theirs, and no effect was seen then."""
    monkeypatch.setattr(comparing, "_offered", lambda _: [])
    looked = list[float]()

    def noted(prediction: Prediction, whitening: BandWhitening, fitted: Fit) -> dict[str, float]:
        looked.append(fitted.likelihood.size)
        return {}

    monkeypatch.setattr(recalibration, "likeliest_clocks", noted)
    plain = recorded(LATE, 0.004)
    ringing = tuple(
        replace(trial, outputs={name: force + 0.1 * np.ptp(force) * np.sin(8e5 * trial.times) for name, force in trial.outputs.items()})
        for trial in plain.trials
    )
    told = comparing.compare(Prediction(MODEL, replace(plain, trials=ringing)))
    assert told.recalibrated.likelihood.size > 0.02
    assert not looked
    comparing.compare(Prediction(MODEL, plain))
    assert looked


def test_clocks_do_not_stand_in_for_a_phase(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both move entry and exit. In runs sampled at the clocks of the recalibrated model jumps of a phase were rounded: it gained 1.5."""
    phase = [effect for effect in MODEL.effects if effect.name == "ellipse_phase_error"]
    monkeypatch.setattr(comparing, "_offered", lambda _: phase)
    experiment = recorded(LATE, noise=0.01, effects={"ellipse_phase_error.delta": 0.04})
    compared = comparing.compare(Prediction(MODEL, experiment))
    (with_phase,) = compared.models.values()
    assert with_phase.likelihood.evidence - compared.recalibrated.likelihood.evidence > 30
    assert with_phase.values["ellipse_phase_error.delta"] == pytest.approx(0.04, abs=0.012)
    for force, late in LATE.items():
        assert with_phase.values[f"setup.{force}.clock"] == pytest.approx(late, abs=0.15 * STEP)
