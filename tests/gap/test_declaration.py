"""Is a column that was declared wrong told, and no record that is only hard to explain?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosed import MODEL, TIMES, experiment
from evat.experiment import Experiment, Nominal, Trial
from evat.experiment.read import read_experiment
from evat.gap import diagnose
from evat.gap.search.declaration import _with_columns, misdeclared
from evat.inference.prediction import Prediction, with_lead_in
from evat.model import Run
from evat.models.contact import ContactModel
from evat.studies.examples import EXAMPLES, write_example


def told(made: Experiment, model: ContactModel = MODEL) -> list[str]:
    prediction = Prediction(model, made)
    return misdeclared(prediction, prediction.one())


def as_written(made: Experiment, factor: float) -> Experiment:
    trials = tuple(replace(t, inputs={name: factor * column for name, column in t.inputs.items()}) for t in made.trials)
    return replace(made, trials=trials)


@pytest.mark.parametrize(
    ("factor", "declared", "meant"), [(1e3, "m/s", "mm/s"), (60.0, "m/s", "m/min"), (1e-3, "mm/s", "m/s"), (1e-3 / 60, "mm/min", "m/s")]
)
def test_a_speed_in_another_unit_is_told(factor: float, declared: str, meant: str) -> None:
    made = experiment()
    signals = {**made.signals, "slip_velocity": replace(made.signals["slip_velocity"], unit=declared)}
    (said,) = told(replace(as_written(made, factor), signals=signals))
    assert said.startswith(f"slip_velocity is declared in {declared}, and looks as if it were in {meant}: so the nominal model leaves 0.")


def test_what_was_recorded_before_is_in_another_unit_as_well() -> None:
    """It kept its numbers: a contact that wears in slid tens of metres before the recording, and nothing was told."""
    values = {**experiment().nominal.values, "sigma2": 0.0, "friction_wear.delta": 2.0, "friction_wear.s_0": 1.0}
    model, times, trials = ContactModel(1), np.arange(1500) * 1e-3, []
    for place in range(3):
        speed = 0.05 * (1 + place) * np.sign(np.sin(2 * np.pi * 2 * times))
        run = Run(times, {"slip_velocity": speed}, ("friction_force",))
        force = model.simulate_many(run, ("friction_wear",), values)["friction_force"][0]
        whole = Trial(f"{place}.csv", f"c{place}", {}, times, {"slip_velocity": 1e3 * speed}, {"friction_force": force})
        trials.append(replace(whole.between(500, 1500), lead_in=whole.between(0, 500)))
    nominal = Nominal(values, ("friction_wear",), {}, initial_bristle="relaxed")
    (said,) = told(replace(experiment(), nominal=nominal, trials=tuple(trials)), model)
    assert said.startswith("slip_velocity is declared in m/s, and looks as if it were in mm/s: so the nominal model leaves ")


def test_a_record_in_another_unit_has_no_effect() -> None:
    """It was "caused by another base law and maxwell_slip", with a probability above 99 %."""
    answer = diagnose(as_written(experiment(), 1e3), MODEL)
    assert (answer.verdict, answer.effects) == ("cannot_tell", ())
    assert answer.cannot_tell[0].startswith("slip_velocity is declared in m/s, and looks as if it were in mm/s")
    assert not any("check its unit" in line for line in answer.cannot_tell)


@pytest.mark.parametrize("name", EXAMPLES)
def test_what_is_declared_right_is_not_doubted(name: str, tmp_path: Path) -> None:
    write_example(name, tmp_path / name, 0)
    assert told(read_experiment(tmp_path / name, ContactModel(1)), ContactModel(1)) == []


def test_a_friction_that_is_far_off_is_no_wrong_unit() -> None:
    """Half and twice of what was believed, or a viscosity ten times as large: values, and no column, are wrong."""
    made = experiment()
    for wrong in ({"F_C": 4.5, "F_S": 5.5}, {"F_C": 18.0, "F_S": 22.0}, {"sigma2": 400.0}, {"sigma0": 1e3}, {"sigma0": 1e7}):
        nominal = replace(made.nominal, values={**made.nominal.values, **wrong})
        assert told(replace(made, nominal=nominal)) == []


def test_forces_that_changed_places_are_told(tmp_path: Path) -> None:
    """They came out as the cross talk of a sensor, likely, with 13 times the noise left."""
    write_example("cut", tmp_path / "cut", 0)
    made = read_experiment(tmp_path / "cut", ContactModel(1))
    trials = tuple(
        replace(t, outputs={"principal_force": t.outputs["feed_force"], "feed_force": t.outputs["principal_force"]}) for t in made.trials
    )
    (said,) = told(replace(made, trials=trials), ContactModel(1))
    assert said.startswith("principal_force and feed_force look as if they were exchanged")


def test_a_load_that_changed_places_with_the_friction_is_told() -> None:
    """Of a contact that slides one way: to and fro a load below 0 is refused as it is read. What was recorded before is exchanged, too."""
    made = experiment()
    load, trials = 40.0 + 4.0 * np.sin(2 * np.pi * TIMES), []
    for trial in made.trials:
        slip = {"slip_velocity": np.abs(trial.inputs["slip_velocity"])}
        friction = Prediction(MODEL, replace(made, trials=(replace(trial, inputs={**slip, "normal_load": load}),))).one()
        trials.append(replace(trial, inputs={**slip, "normal_load": np.maximum(friction, 0.0)}, outputs={"friction_force": load}))
    (said,) = told(replace(made, trials=tuple(trials)))
    assert said.startswith("normal_load and friction_force look as if they were exchanged")
    (first, *_), taken = trials, {"normal_load": "friction_force", "friction_force": "normal_load"}
    before = first.between(0, 50)
    for lead in (before, replace(before, outputs={})):  # averages of a long record have inputs alone there
        led = replace(first.between(50, 400), lead_in=lead)
        moved = _with_columns(Prediction(MODEL, replace(made, trials=(led,))), taken)
        assert moved is not None
        load = with_lead_in(moved.experiment.trials[0])[1]["normal_load"]
        assert np.array_equal(load, first.outputs["friction_force"][0 if lead.outputs else 50 :])
