"""Does an input that is recorded with a wrong zero make a gap? Judged by a LuGre that stands still where the record creeps, by one that
reverses before the record does, and by friction in proportion to another load."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, ExperimentError, Nominal, SetupSd, Signal, Trial
from evat.experiment.read import read_experiment
from evat.experiment.write import write_experiment
from evat.gap import diagnose_with
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction
from evat.inference.setup.setup_errors import zero_of_input
from evat.models.contact import ContactModel
from independent_lugre import NOISE, TIMES, lugre, world

STILL, WAIT = (0.0, 0.0, 0.0), 0.25
OFF = 2e-5  # m/s
ZERO = zero_of_input("slip_velocity")


def model(*effects: str) -> ContactModel:
    contact, offered = ContactModel(threads=1), effects or ("direction_asymmetry", "dwell_strengthening")
    contact.effects = tuple(effect for effect in contact.effects if effect.name in offered)
    return contact


@pytest.mark.parametrize(
    "zero", [8e-5, pytest.param(-8e-5, marks=pytest.mark.campaign)]
)  # m/s: 1.5 % of the rms, by which the bristles bend 2e-5 m while the contact rests
def test_it_is_set_up_and_no_gap(zero: float) -> None:
    made = world(STILL, "relaxed", WAIT, zero)
    exact = replace(made, setup_sd={"slip_velocity": SetupSd(zero=0.0)})
    wrong, _ = diagnose_with(exact, model())
    assert wrong.closure.rms["friction_force"]["recalibrated"] > 2 * NOISE
    answer, _ = diagnose_with(made, model())
    assert answer.verdict in ("no_gap", "mistuned")
    told = answer.document()["setup"]["slip_velocity"]["zero"]
    assert told["unit"] == "m/s"
    assert told["value"] == pytest.approx(zero, rel=0.1)
    assert answer.closure.rms["friction_force"]["recalibrated"] < 1.2 * NOISE


def test_a_prediction_is_by_the_velocity_without_it() -> None:
    off, right = (Prediction(model(), world(STILL, "relaxed", WAIT, zero)) for zero in (5e-5, 0.0))
    assert off.one({ZERO: 5e-5}) == pytest.approx(right.one(), abs=1e-9)
    assert np.max(np.abs(off.one() - right.one())) > 10 * NOISE


def test_a_part_in_which_nothing_rests_knows_it_too() -> None:
    """The heads that effects are tried on, and the conditions that an FMU runs, need not hold a rest."""
    off, right = (world(STILL, "relaxed", WAIT, zero) for zero in (OFF, 0.0))
    late = slice(int(WAIT * 1000), None)
    parts = []
    for made in (off, right):
        trials = [replace(t, times=t.times[late], inputs={"slip_velocity": t.inputs["slip_velocity"][late]}) for t in made.trials]
        trials = [replace(t, outputs={"friction_force": t.outputs["friction_force"][late]}) for t in trials]
        parts.append(replace(made, trials=tuple(trials)))
    part = Prediction(model(), off).of(parts[0])
    assert part.one({ZERO: OFF}) == pytest.approx(Prediction(model(), parts[1]).one(), abs=1e-9)


def ramps(zero: float) -> Experiment:
    """Slow reversals, none of which waits: the bristles turn while the velocity is hardly more than its zero."""
    made, draw, trials = world(STILL, "relaxed", 0.0, zero), np.random.default_rng(6), list[Trial]()
    for place, trial in enumerate(made.trials):
        v = 0.02 * (1 + place // 2) * np.interp(TIMES, [0.0, 0.05, 0.2, 0.35, 0.5], [0.2, 1.0, -1.0, 1.0, -1.0])
        shown = lugre(v, 0.0) + NOISE * draw.normal(size=TIMES.size)
        trials.append(replace(trial, inputs={"slip_velocity": v + zero}, outputs={"friction_force": shown}))
    return replace(made, trials=tuple(trials))


@pytest.mark.parametrize("zero", [4e-4, pytest.param(-4e-4, marks=pytest.mark.campaign)])
def test_where_nothing_rests_it_is_no_asymmetry(zero: float) -> None:
    """Friction turns before or after the record does, earlier one way than the other."""
    made, lean = ramps(zero), Hypothesis(("direction_asymmetry",))
    wrong, _ = diagnose_with(replace(made, setup_sd={"slip_velocity": SetupSd(zero=0.0)}), model())
    assert wrong.judgement.features.gain[lean] > 3
    assert wrong.closure.rms["friction_force"]["recalibrated"] > 1.5 * NOISE
    answer, _ = diagnose_with(made, model())
    assert answer.verdict in ("no_gap", "mistuned")
    assert answer.judgement.features.gain[lean] < 0
    assert answer.closure.rms["friction_force"]["recalibrated"] < 1.1 * NOISE
    assert answer.document()["setup"]["slip_velocity"]["zero"]["value"] == pytest.approx(zero, rel=0.1)


MU = 0.3


def pressed(zero: float, least: float = 20.0) -> Experiment:
    """Friction in proportion to a load (from `least` on) [N] that varies from condition to condition and within each."""
    made, draw, trials = world(STILL, "relaxed"), np.random.default_rng(7), list[Trial]()
    for place in range(4):
        load = least * (1 + place) + 0.4 * least * np.sin(2 * np.pi * 3 * TIMES)
        v = 0.05 * np.sin(2 * np.pi * (4 + place) * TIMES + 0.1)
        for repeat in range(2):
            shown = MU * load * np.sign(v) + NOISE * draw.normal(size=TIMES.size)
            inputs = {"slip_velocity": v, "normal_load": load + zero}
            trials.append(Trial(f"{place}{repeat}.csv", f"c{place}", {}, TIMES, inputs, {"friction_force": shown}))
    values = {"kinematics": "external", "friction_law": "amontons", "amontons.mu": MU}
    signals = {**made.signals, "normal_load": Signal("normal_load", "N", "N", "input")}
    return replace(made, nominal=Nominal(values, (), {"amontons.mu": 0.1}), signals=signals, trials=tuple(trials))


def test_of_a_load_it_is_no_load_dependence() -> None:
    offered = model("load_dependence", "sensor_offset")
    made, zero = pressed(1.0), 1.0
    wrong, _ = diagnose_with(replace(made, setup_sd={"normal_load": SetupSd(zero=0.0)}), offered)
    assert wrong.judgement.features.gain[Hypothesis(("load_dependence",))] > 20
    answer, _ = diagnose_with(made, offered)
    assert answer.verdict in ("no_gap", "mistuned")
    assert answer.document()["setup"]["normal_load"]["zero"]["value"] == pytest.approx(zero, rel=0.1)


def test_inputs_that_show_their_zero_have_none() -> None:
    """A load that comes to 0 has left the contact; one that stays as it is has a gain; a temperature proxy has its reference."""
    names = {zero.name for zero in Prediction(model(), pressed(0.8)).input_zeros}
    assert names == {ZERO, zero_of_input("normal_load")}
    assert {zero.name for zero in Prediction(model(), pressed(0.8, 0.0)).input_zeros} == {ZERO}
    made = pressed(0.0)
    proxied = [replace(t, inputs={"slip_velocity": t.inputs["slip_velocity"], "proxy_speed": t.inputs["normal_load"]}) for t in made.trials]
    assert {zero.name for zero in Prediction(model(), replace(made, trials=tuple(proxied))).input_zeros} == {ZERO}


def test_a_velocity_that_is_0_at_rest_has_none() -> None:
    assert not Prediction(model(), world(STILL, "relaxed", WAIT)).input_zeros


def test_a_velocity_from_a_position_has_none() -> None:
    made = world(STILL, "relaxed", WAIT, OFF)
    signals = {**made.signals, "slip_velocity": Signal("slip_velocity", "x", "m", "input", of="position")}
    assert Prediction(model(), made).input_zeros
    assert not Prediction(model(), replace(made, signals=signals)).input_zeros


def test_what_is_stated_is_written_and_read(tmp_path: Path) -> None:
    write_experiment(replace(world(STILL, "relaxed", WAIT, OFF), setup_sd={"slip_velocity": SetupSd(zero=2e-5)}), tmp_path / "rig")
    experiment = read_experiment(tmp_path / "rig", model())
    (zero,) = Prediction(model(), experiment).input_zeros
    assert zero.sd == pytest.approx(2e-5)


def test_a_gain_of_the_velocity_is_refused(tmp_path: Path) -> None:
    write_experiment(world(STILL, "relaxed"), tmp_path / "rig")
    path = tmp_path / "rig" / "experiment.toml"
    path.write_text(path.read_text() + "\n[setup_sd.slip_velocity]\ngain = 0.01\n")
    with pytest.raises(ExperimentError, match=r"setup_sd\.slip_velocity: only the zero of slip_velocity is a set-up error"):
        read_experiment(tmp_path / "rig", model())


def test_what_is_stated_of_a_load_is_written_and_read_and_of_a_proxy_refused(tmp_path: Path) -> None:
    write_experiment(replace(pressed(0.8), setup_sd={"normal_load": SetupSd(zero=0.3)}), tmp_path / "rig")
    experiment = read_experiment(tmp_path / "rig", model())
    assert next(zero.sd for zero in Prediction(model(), experiment).input_zeros if "load" in zero.name) == pytest.approx(0.3)
    path = tmp_path / "rig" / "experiment.toml"
    path.write_text(path.read_text() + "\n[setup_sd.proxy_speed]\nzero = 0.01\n")
    with pytest.raises(ExperimentError, match=r"setup_sd\.proxy_speed: .*the temperature proxy, whose zero is one with"):
        read_experiment(tmp_path / "rig", model())
