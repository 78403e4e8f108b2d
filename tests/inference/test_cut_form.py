"""Do the forms that a cut may have take up what models of cutting differ in, in records and in means, and no more than that?"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means, Nominal, Signal, Trial
from evat.inference.law.cut_form import _averaged, cut_forms
from evat.inference.law.law_form import with_law_forms
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

MODEL = ContactModel(threads=1)
VALUES: dict[str, float | str] = {"kinematics": "internal", "friction_law": "lugre", "initial_state": "periodic"}
FREE = ("F_C", "F_S", "v_s", "sigma2", "shear_stress")
FORCES = ("principal_force", "feed_force")
SPEEDS = (0.1, 0.25, 0.5)  # m/s
TIMES: FloatArray = np.linspace(0, 1e-4, 161)  # two cycles
Truth = dict[str, float | str]


def recorded(on: tuple[str, ...], truth: Truth) -> Prediction:
    trials = []
    for place, speed in enumerate(SPEEDS):
        names = tuple(f"measured_{force}" for force in FORCES)
        run = MODEL.simulate(Run(TIMES, {}, names), on, {**VALUES, **truth, "cutting_speed": speed})
        outputs = {force: run[name] for force, name in zip(FORCES, names, strict=True)}
        trials.append(Trial(f"{place}.csv", f"c{place}", {"cutting_speed": speed}, TIMES, {}, outputs))
    signals = {force: Signal(force, force, "N", "output") for force in FORCES}
    return Prediction(MODEL, Experiment(Path(), "cut", "", Nominal(dict(VALUES), (), {}), signals, tuple(trials), None, ""))


def averaged(on: tuple[str, ...], truth: Truth) -> Prediction:
    speeds, feeds = (np.repeat(SPEEDS, 5), np.tile(np.linspace(0.5e-5, 2.5e-5, 5), 3))
    names = tuple(f"mean_{force}" for force in FORCES)
    sets = {"cutting_speed": speeds, "feed": feeds}
    rows = MODEL.settled(tuple(f"mean_measured_{force}" for force in FORCES), on, {**VALUES, **truth, **sets})
    outputs = {name: rows[f"mean_measured_{force}"] for name, force in zip(names, FORCES, strict=True)}
    means = Means("means.csv", tuple(f"row {k}" for k in range(speeds.size)), sets, outputs, {})
    signals = {name: Signal(name, name, "N", "output") for name in names}
    return Prediction(MODEL, Experiment(Path(), "cuts", "", Nominal(dict(VALUES), (), {}), signals, (), means, ""))


def slopes(prediction: Prediction) -> FloatArray:
    variables = {variable.name: float(variable.start) for variable in MODEL.variables if variable.name in FREE}
    return prediction.jacobian({**VALUES, **variables}, list(FREE), variables)[1]


def left(prediction: Prediction, forms: bool) -> float:
    """Share of the rms that parameters, and forms, cannot take up."""
    known, residual = slopes(prediction), prediction.measured - prediction.one()
    columns = [each.column for each in with_law_forms(prediction, known, VALUES).linearised] if forms else []
    basis = np.column_stack([known, *columns])
    basis = basis / np.linalg.norm(basis, axis=0)
    remainder = residual - basis @ np.linalg.lstsq(basis, residual, rcond=None)[0]
    return float(np.sqrt(np.mean(remainder**2) / np.mean(prediction.measured**2)))


OF_A_CUT: list[tuple[tuple[str, ...], Truth]] = [
    (("edge_force",), {"edge_force.K_ep": 2e3, "edge_force.K_ef": 1e3}),
    (("size_effect",), {"size_effect.exponent": 0.03}),
    (("minimum_chip_thickness",), {"minimum_chip_thickness.edge_radius": 5e-7}),
]


@pytest.mark.parametrize("made", [recorded, averaged])
@pytest.mark.parametrize(("on", "truth"), OF_A_CUT)
def test_they_take_up_what_models_of_a_cut_differ_in(
    on: tuple[str, ...], truth: Truth, made: Callable[[tuple[str, ...], Truth], Prediction]
) -> None:
    prediction = made(on, truth)
    without = left(prediction, forms=False)
    assert without > 1e-3
    assert left(prediction, forms=True) < 0.4 * without


def test_they_leave_what_no_cut_does() -> None:
    """A zero that stands while nothing is cut, and a hum."""
    for on, truth in (
        ("sensor_offset", {"sensor_offset.principal_force": 0.3}),
        ("line_disturbance", {"line_disturbance.feed_force": 0.3, "line_disturbance.frequency": 7e3}),
    ):
        prediction = recorded((on,), dict(truth))
        assert left(prediction, forms=True) > 0.6 * left(prediction, forms=False)


def test_rows_of_one_condition_share_a_motion_and_forces_do_not_share_forms() -> None:
    prediction = averaged((), {})
    table, at = cut_forms(prediction, {}, ())
    assert np.array_equal(at, np.arange(prediction.measured.size))
    half = table.shape[1] // 2
    principal, feed = prediction.places("mean_principal_force"), prediction.places("mean_feed_force")
    assert not np.any(table[principal][:, half:])
    assert not np.any(table[feed][:, :half])
    assert np.array_equal(table[principal][:, :half], table[feed][:, half:])


def test_where_the_motion_is_given_there_is_no_cut() -> None:
    times = np.linspace(0, 1, 50)
    trial = Trial("a.csv", "a", {}, times, {"slip_velocity": np.sin(9 * times)}, {"friction_force": np.cos(9 * times)})
    signals = {"friction_force": Signal("friction_force", "F", "N", "output")}
    rig = Experiment(Path(), "rig", "", Nominal({"kinematics": "external"}, (), {}), signals, (trial,), None, "")
    assert cut_forms(Prediction(MODEL, rig), {}, ())[1].size == 0


def test_a_mean_is_taken_over_the_whole_cycle_of_its_condition() -> None:
    """None of it is a lead-in; a condition that was measured twice is run once."""
    speeds = np.array([0.1, 0.2, 0.1])
    asked = []

    def simulate_many(run: Run, effects: Any, values: Truth) -> dict[str, FloatArray]:
        asked.append(values["cutting_speed"])
        return {name: np.full((1, run.times.size), float(values["cutting_speed"])) for name in run.outputs}

    means = Means("m.csv", ("a", "b", "a2"), {"cutting_speed": speeds}, {"principal_force": speeds}, {})
    model = SimpleNamespace(cycle_time=lambda values: 1e-4 / float(values["cutting_speed"]), simulate_many=simulate_many)
    prediction: Any = SimpleNamespace(model=model, experiment=SimpleNamespace(means=means))
    motions = list(_averaged(prediction, {"cutting_speed": 9.0}, ()).values())
    assert asked == [0.1, 0.2]
    assert [motion.before for motion in motions] == [0, 0]
    assert [motion.times[-1] for motion in motions] == pytest.approx([1e-3, 5e-4])
    assert [motion.slip.size for motion in motions] == 2 * [CONSTANTS.samples_of_a_cycle]
