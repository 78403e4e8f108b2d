"""Is a filter or a delay of a sensor left out where only means were measured, and is that said?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from evat.experiment import Experiment, Means, Nominal, Signal
from evat.gap import diagnose_with
from evat.gap.report.explanation import explain
from evat.models.contact import ContactModel

FORCE = "mean_principal_force"
VALUES: dict[str, float | str] = {"kinematics": "internal", "friction_law": "coulomb", "F_C": 3.0, "initial_state": "periodic"}


def test_they_are_no_candidates_there() -> None:
    model = ContactModel(threads=1)
    model.effects = tuple(effect for effect in model.effects if effect.name in ("sensor_lowpass", "sensor_delay", "edge_force"))
    sets = {"cutting_speed": np.repeat([0.1, 0.25, 0.5], 4), "feed": np.tile([0.5e-5, 1e-5, 1.5e-5, 2e-5], 3)}
    force = model.settled((f"mean_measured_{FORCE.removeprefix('mean_')}",), ("edge_force",), {**VALUES, **sets, "edge_force.K_ep": 3e4})
    column = force["mean_measured_principal_force"] * (1 + 1e-3 * np.random.default_rng(1).normal(size=12))
    means = Means("means.csv", tuple(f"row {k}" for k in range(12)), sets, {FORCE: column}, {})
    experiment = Experiment(
        Path(), "cuts", "", Nominal(VALUES, (), {"F_C": 0.1}), {FORCE: Signal(FORCE, FORCE, "N", "output")}, (), means, ""
    )
    answer, comparison = diagnose_with(experiment, model)
    assert {name for on in comparison.rough for name in on.effects} == {"edge_force"}
    assert comparison.silent == ()  # what was tried, and does nothing
    assert "It was not tried: it is a filter or a delay, and passes means as they are." in explain(comparison, answer, "sensor_lowpass")
