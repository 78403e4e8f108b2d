"""Do the forms that a law may have take up what laws differ in, and no more than that?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.inference.law.law_form import with_law_forms
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

MODEL = ContactModel(threads=1)
VALUES: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 100.0, "sigma2": 5.0, "v_s": 0.01,
}  # fmt: skip
TIMES: FloatArray = np.arange(1200) * 1e-3


def recorded(on: tuple[str, ...] = (), truth: dict[str, float | str] | None = None) -> Prediction:
    """Strokes of three sizes, the smallest of them within presliding."""
    trials = []
    for place, speed in enumerate((0.002, 0.02, 0.08)):
        columns = {"slip_velocity": speed * np.sin(2 * np.pi * (2.5 + place) * TIMES) * (1 + 0.3 * np.sin(2 * np.pi * TIMES))}
        force = MODEL.simulate(Run(TIMES, columns, ("friction_force",)), on, {**VALUES, **(truth or {})})["friction_force"]
        trials.append(Trial(f"{place}.csv", f"c{place}", {}, TIMES, columns, {"friction_force": force}))
    signals = {"friction_force": Signal("friction_force", "F", "N", "output")}
    nominal = Nominal(dict(VALUES), (), {}, initial_bristle="relaxed")
    return Prediction(MODEL, Experiment(Path(), "rig", "", nominal, signals, tuple(trials), None, ""))


def slopes(prediction: Prediction) -> FloatArray:
    values = {name: float(value) for name, value in VALUES.items() if isinstance(value, float)}
    return prediction.jacobian({**VALUES}, list(values), values)[1]


def left(prediction: Prediction, forms: bool) -> float:
    """Share of the rms that parameters, and forms, cannot take up."""
    known, residual = slopes(prediction), prediction.measured - prediction.one()
    columns = [each.column for each in with_law_forms(prediction, known, VALUES).linearised] if forms else []
    basis = np.column_stack([known, *columns])
    basis = basis[:, np.any(basis, axis=0)]
    basis = basis / np.linalg.norm(basis, axis=0)
    remainder = residual - basis @ np.linalg.lstsq(basis, residual, rcond=None)[0]
    return float(np.sqrt(np.mean(remainder**2) / np.mean(prediction.measured**2)))


@pytest.mark.parametrize(
    ("on", "truth", "most"),
    [
        (("maxwell_slip",), {"maxwell_slip.share": 0.3}, 0.4),  # several elements that yield one after the other
        (("elasto_plastic",), {"elasto_plastic.share": 0.3}, 0.75),  # a sharp end of presliding
        ((), {"sigma1": 30.0, "lugre.presliding_exponent": 2.0}, 0.75),  # another approach to sliding, with less damping
    ],
)
def test_they_take_up_a_good_part_of_what_laws_differ_in(on: tuple[str, ...], truth: dict[str, float | str], most: float) -> None:
    prediction = recorded(on, truth)
    assert left(prediction, forms=False) > 0.001
    assert left(prediction, forms=True) < most * left(prediction, forms=False)


@pytest.mark.parametrize(
    ("on", "truth"),
    [
        (("direction_asymmetry",), {"direction_asymmetry.a": 0.05}),
        (("sensor_offset",), {"sensor_offset.friction_force": 0.4}),
        (("line_disturbance",), {"line_disturbance.friction_force": 0.5}),
    ],
)
def test_they_leave_what_no_law_has(on: tuple[str, ...], truth: dict[str, float | str]) -> None:
    """Sensors show what acts on them in what is measured alone, so that is added here."""
    prediction = recorded(on, truth)
    if on[0] != "direction_asymmetry":
        trials = [
            replace(
                trial,
                outputs={
                    "friction_force": MODEL.simulate(Run(trial.times, trial.inputs, ("measured_friction_force",)), on, {**VALUES, **truth})[
                        "measured_friction_force"
                    ]
                },
            )
            for trial in prediction.experiment.trials
        ]
        prediction = Prediction(MODEL, replace(prediction.experiment, trials=tuple(trials)))
    assert left(prediction, forms=True) > 0.8 * left(prediction, forms=False)


def test_together_they_are_as_large_as_laws_are_wrong() -> None:
    """A priori, where all of them have one standard deviation: and nothing that parameters do."""
    prediction = recorded()
    known = slopes(prediction)
    columns = np.array([each.column for each in with_law_forms(prediction, known, VALUES).linearised])
    level = np.sqrt(np.mean(prediction.measured**2))
    together = np.sqrt(np.sum(columns**2, axis=0).mean()) / level
    assert together == pytest.approx(CONSTANTS.accuracy_of_laws, rel=0.02)
    acts = known[:, np.any(known, axis=0)]
    assert np.max(np.abs((acts / np.linalg.norm(acts, axis=0)).T @ columns.T)) < 1e-6 * np.linalg.norm(columns)


def test_no_form_is_known_to_the_model() -> None:
    prediction = recorded()
    formed = with_law_forms(prediction, slopes(prediction))
    first = formed.linearised[0]
    moved = formed.one({first.parameter.name: 1.0})
    assert np.allclose(moved - formed.one(), first.column, rtol=0, atol=1e-12)
    assert np.allclose(
        formed.one({first.parameter.name: 1.0, "friction_law": "coulomb"}) - formed.one({"friction_law": "coulomb"}), first.column
    )


def test_where_no_slip_velocity_was_recorded_there_are_none() -> None:
    prediction = recorded()
    trials = tuple(replace(trial, inputs={}, values={"slip_velocity": 0.01}) for trial in prediction.experiment.trials)
    still = Prediction(MODEL, replace(prediction.experiment, trials=trials))
    assert with_law_forms(still, np.zeros((still.measured.size, 1))) is still
