"""Does it matter how bristles were bent before a recording began? Judged by an independent LuGre of a few lines, whose trials slid in."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.experiment import Experiment, InitialBristle, Nominal, Trial
from evat.experiment.read import read_experiment
from evat.experiment.write import write_experiment
from evat.gap import diagnose_with
from evat.gap.report.corrected import content
from evat.identification import Settings, identify
from evat.inference.band_whitening import BandWhitening
from evat.inference.law.initial_state import beginnings, begun, in_motion, with_initial_state
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import BRISTLE, Prediction
from evat.model import Run
from evat.models.contact import ContactModel
from independent_lugre import NOISE, STEADY, TIMES, VALUES, lugre, world
from toy import Toy
from toy import measured as toy_measured

SLID = (0.8 * STEADY, -0.7 * STEADY, 0.75 * STEADY)


def model() -> ContactModel:
    contact = ContactModel(threads=1)
    contact.effects = tuple(effect for effect in contact.effects if effect.name in ("direction_asymmetry", "sensor_offset"))
    return contact


def test_another_start_shows_as_the_model_says() -> None:
    """Linear in the deflection, to the last percent, though only one other was run."""
    prediction = with_initial_state(Prediction(model(), world(SLID, "free")))
    assert pytest.approx(STEADY, rel=0.01) == prediction.steady["00.csv"]
    away = {trial.file: 0.3 * STEADY for trial in prediction.experiment.trials}
    change = prediction.starting(away, None).one() - prediction.one()
    assert pytest.approx(change, abs=0.01 * np.abs(change).max()) == 0.3 * STEADY / prediction.steady["00.csv"] * prediction.bent


def test_what_slid_in_is_no_gap() -> None:
    """Taken for relaxed, it is a gap of 3 N that no effect closes; left open, it is none, and its size is told."""
    wrong, _ = diagnose_with(world(SLID, "relaxed"), model())
    assert wrong.verdict not in ("no_gap", "mistuned")
    assert wrong.closure.rms["friction_force"]["recalibrated"] > 10 * NOISE
    answer, comparison = diagnose_with(world(SLID, "free"), model())
    assert answer.verdict == "no_gap"
    assert answer.closure.rms["friction_force"]["nominal"] < 1.1 * answer.closure.rms["friction_force"]["noise_floor"]
    for place, z in enumerate(SLID):
        assert pytest.approx(z, abs=0.03 * STEADY) == comparison.prediction.starts[f"{place}0.csv"]
    assert any("began with bent bristles" in said and " um of steady slip" in said for said in answer.cannot_tell)


def test_repeats_of_one_motion_begin_each_in_its_own_way() -> None:
    """Taken for one start, their difference was noise of 3 N that no model could be told from."""
    made = world((0.0, 0.0, 0.0), "free")
    trials = []
    for place, trial in enumerate(made.trials):
        force = lugre(trial.inputs["slip_velocity"], (SLID[0], -SLID[0])[place % 2])
        noise = NOISE * np.random.default_rng(place).normal(size=TIMES.size)
        trials.append(replace(trial, outputs={"friction_force": force + noise}))
    answer, comparison = diagnose_with(replace(made, trials=tuple(trials)), model())
    assert answer.verdict == "no_gap"
    assert answer.closure.rms["friction_force"]["noise_floor"] < 2 * NOISE
    assert comparison.prediction.starts["10.csv"] == pytest.approx(SLID[0], abs=0.03 * STEADY)
    assert comparison.prediction.starts["11.csv"] == pytest.approx(-SLID[0], abs=0.03 * STEADY)


def test_a_repeat_begins_in_its_own_way_also_where_each_is_compared_by_itself() -> None:
    """As where a hum goes through repeats, out of phase: the start of the second was taken off twice, and then told as twice as bent."""
    made = world((0.0, 0.0, 0.0), "free")
    forces = [lugre(trial.inputs["slip_velocity"], (SLID[0], -SLID[0])[place % 2]) for place, trial in enumerate(made.trials)]
    trials = tuple(replace(trial, outputs={"friction_force": force}) for trial, force in zip(made.trials, forces, strict=True))
    prediction = with_initial_state(Prediction(model(), replace(made, trials=trials)))
    prediction = begun(prediction, prediction.one())
    noise = replace(estimate_noise(prediction, prediction.one()), sizes=np.full(len(prediction.segments), NOISE))
    for each in (prediction, prediction.each_apart()):
        for _ in range(2):
            assert each.starts["10.csv"] == pytest.approx(SLID[0], abs=0.03 * STEADY)
            assert each.starts["11.csv"] == pytest.approx(-SLID[0], abs=0.03 * STEADY)
            predicted = each.one()
            whitening = BandWhitening(each, noise, predicted)
            assert max(float(np.max(np.abs(whitening.residual(predicted, n)))) for n in range(len(whitening.groups))) < 0.5
            each = begun(with_initial_state(each), predicted)


def test_what_starts_relaxed_is_as_before() -> None:
    before, _ = diagnose_with(world((0.0, 0.0, 0.0), "relaxed"), model())
    answer, comparison = diagnose_with(world((0.0, 0.0, 0.0), "free"), model())
    assert (before.verdict, answer.verdict) == ("no_gap", "no_gap")
    assert not comparison.prediction.starts
    for name in ("F_C", "sigma0"):
        _, was, sd = before.recalibration.parameters[name]
        assert abs(answer.recalibration.parameters[name][1] - was) < sd, name


@pytest.mark.parametrize("believed", ["free", "relaxed"])
def test_identified_is_what_is_there(believed: InitialBristle) -> None:
    """Taken for relaxed, trials that slid in have another static friction, by 5 %."""
    made = world(SLID, believed)
    result = identify(made, model(), ["sigma0", "F_S"], Settings(search="none", profiles=False))
    off = abs(result["F_S"].value - VALUES["F_S"]) / VALUES["F_S"]
    assert (off < 0.01) == (believed == "free")
    assert any("began with bent bristles" in doubt for doubt in result.doubts) == (believed == "free")


def test_steady_slip_from_the_first_sample() -> None:
    """slid_in: bent as the first velocity bends them, though nothing was fitted."""
    made = world((0.0,), "slid_in")
    trials = tuple(replace(trial, inputs={"slip_velocity": np.full(TIMES.size, -0.03)}) for trial in made.trials)
    prediction = with_initial_state(Prediction(model(), replace(made, trials=trials)))
    force = prediction.one()[: TIMES.size]
    assert pytest.approx(force[-1], abs=0.25 * abs(force[-1])) == force[0]
    assert prediction.starts["00.csv"] < -0.8 * STEADY


def test_a_model_without_bristles_is_left_alone() -> None:
    prediction = Prediction(Toy(), toy_measured())
    assert with_initial_state(prediction) is prediction
    rigid = world((0.0,), "free")
    rigid = replace(rigid, nominal=replace(rigid.nominal, values={"kinematics": "external", "friction_law": "coulomb", "F_C": 9.0}))
    prediction = Prediction(model(), rigid)
    assert with_initial_state(prediction) is prediction
    assert begun(prediction, prediction.one()).starts == {}
    assert BRISTLE in {variable.name for variable in model().variables}


def test_a_filter_has_heard_the_force_before_the_record_begins() -> None:
    """Of records that begin in motion the first sample, too, is as a slow sensor shows it; begun at 0, each beginning spoke against one."""
    made = world((0.0,), "free")
    speed = 0.03 * np.cos(2 * np.pi * 5 * TIMES)
    trials = tuple(replace(trial, inputs={"slip_velocity": speed}) for trial in made.trials)
    prediction = in_motion(Prediction(ContactModel(1), replace(made, trials=trials)))
    plain, slow = prediction.one(), prediction.one({"sensor_lowpass.time_constant": 1e-6}, ("sensor_lowpass",))
    assert pytest.approx(plain, abs=0.02 * np.abs(plain).max()) == slow
    relaxed = Prediction(ContactModel(1), replace(made, trials=trials, nominal=replace(made.nominal, initial_bristle="relaxed")))
    assert in_motion(relaxed) is relaxed


def test_a_belief_is_written_and_read(tmp_path: Path) -> None:
    write_experiment(world((0.0,), "slid_in"), tmp_path / "rig")
    assert read_experiment(tmp_path / "rig", model()).nominal.initial_bristle == "slid_in"


def vibrating(start: str, believed: InitialBristle = "free", **more: str) -> Experiment:
    """Two records of two and a half cycles of the ellipse, begun in the midst of a stroke, from rest or from the periodic motion."""
    times = 0.1 / 2e4 + np.arange(100) / (2e4 * 40)
    truth: dict[str, float | str] = {"friction_law": "lugre", "kinematics": "internal", "vibration_frequency": 2e4}
    trials = []
    for speed in (0.1, 0.3):
        values = {**truth, "cutting_speed": speed, "initial_state": start}
        trace = ContactModel(1).simulate(Run(times, {}, ("principal_force", "feed_force")), (), values)
        trials.append(Trial(f"{speed}.csv", str(speed), {"cutting_speed": speed}, times, {}, dict(trace.columns)))
    nominal = Nominal({**truth, "F_C": 11.0, **more}, (), {}, initial_bristle=believed)
    return Experiment(Path(), "ellipse", "", nominal, {}, tuple(trials), None, "")


@pytest.mark.parametrize(
    ("start", "believed", "more", "periodic"),
    [
        ("periodic", "free", {}, True),
        ("at_rest", "free", {}, False),
        ("periodic", "relaxed", {}, False),
        ("at_rest", "slid_in", {}, True),
        ("periodic", "free", {"initial_state": "at_rest"}, False),
    ],
)
def test_a_record_of_a_vibration_begins_in_the_midst_of_it_unless_it_does_not(
    start: str, believed: InitialBristle, more: dict[str, str], periodic: bool
) -> None:
    """The owner's word counts before what the first cycle looks like; a force that is 10 % off does not hide it."""
    prediction = Prediction(ContactModel(1), vibrating(start, believed, **more))
    assert (in_motion(prediction).nominal.get("initial_state") == "periodic") == periodic


def test_a_sensor_has_heard_the_force_before_a_vibration_begins_with_relaxed_bristles() -> None:
    """A dynamometer that stood at nothing while the tool cuts rang from the first sample on, and was not believed."""
    prediction = in_motion(Prediction(ContactModel(1), vibrating("at_rest")))
    ringing = {"dynamometer_resonance.natural_period": 4e-6, "dynamometer_resonance.damping_ratio": 0.1}
    plain, shown = (prediction.one(*own) for own in ((), (ringing, ("dynamometer_resonance",))))
    for segment in prediction.segments:
        assert shown[segment.at][0] == pytest.approx(plain[segment.at][0], abs=1e-3 * np.abs(plain[segment.at]).max())


def test_of_records_from_the_midst_of_a_vibration_the_parameters_come_back() -> None:
    """Begun at rest, the first stroke of each pulled them away."""
    experiment = vibrating("periodic")
    answer = identify(experiment, ContactModel(1), ["F_C", "sigma0"], Settings(search="none"))
    assert answer["F_C"].value == pytest.approx(9.0, rel=1e-3)
    assert answer.fits["feed_force"].rms < 1e-3
    assert answer.values["initial_state"] == "periodic"  # so that an FMU with these values begins alike


def test_a_corrected_model_begins_as_the_records_do_and_says_so() -> None:
    written = content(*diagnose_with(vibrating("periodic"), model()))
    assert written.values["initial_state"] == 1
    assert written.sources["initial_state"] == "the records begin in the midst of a vibration"


def test_where_the_motion_is_given_nothing_begins_by_itself() -> None:
    prediction = Prediction(model(), world(SLID, "free"))
    assert in_motion(prediction).nominal["initial_state"] == "steady"


def test_what_is_said_of_bent_bristles_names_the_trial_that_was_bent_most() -> None:
    """By its magnitude; how many others there are, and nothing of what is below the least that is told."""
    steady = {"a": 4e-6, "b": 4e-6, "c": 5e-6}

    def said(**starts: float) -> tuple[str, ...]:
        told: Any = SimpleNamespace(starts=starts, steady=steady)
        return beginnings(told)

    assert said(a=1e-6, b=-3e-6, c=0.0)[0].startswith("b and 1 more began with bent bristles, up to -3 um of the 4 um of steady slip")
    assert said(a=0.0, c=2e-6)[0].startswith("c began with bent bristles, up to 2 um of the 5 um")
    assert said(a=0.0, b=0.0) == ()
