"""Does a velocity that is recorded with a wrong zero make a gap? Judged by a LuGre that stands still where the record creeps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import ExperimentError, SetupSd, Signal
from evat.experiment.read import read_experiment
from evat.experiment.write import write_experiment
from evat.gap import diagnose_with
from evat.inference.prediction import Prediction
from evat.inference.setup.setup_errors import ZERO_OF_MOTION as ZERO
from evat.models.contact import ContactModel
from independent_lugre import NOISE, world

STILL, WAIT = (0.0, 0.0, 0.0), 0.25
OFF = 2e-5  # m/s


def model() -> ContactModel:
    contact = ContactModel(threads=1)
    contact.effects = tuple(effect for effect in contact.effects if effect.name in ("direction_asymmetry", "dwell_strengthening"))
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
    assert not part.input_zeros
    assert part.one({ZERO: OFF}) == pytest.approx(Prediction(model(), parts[1]).one(), abs=1e-9)


def test_where_nothing_rests_there_is_none() -> None:
    """Strokes to and fro without a wait: what a lean of the force does there, a zero would do as well."""
    assert Prediction(model(), world(STILL, "relaxed", WAIT, OFF)).input_zeros
    assert not Prediction(model(), world(STILL, "relaxed", 0.0, OFF)).input_zeros


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
