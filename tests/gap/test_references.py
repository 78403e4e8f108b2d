"""Is an amplitude told at the usual magnitude of the records, where only its quotient by a reference counts?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Means, Nominal, Signal
from evat.gap import diagnose_with
from evat.gap.report.corrected import content
from evat.inference.parameters import at_usual_references, shapes
from evat.models.contact import ContactModel

FORCES = ("mean_principal_force", "mean_feed_force")
VALUES: dict[str, float | str] = {"kinematics": "internal", "friction_law": "coulomb", "F_C": 3.0, "initial_state": "periodic"}
KAPPA, F_REF = 0.06, 10.0


def lossy() -> tuple[Experiment, ContactModel]:
    """A table of cuts by a tool that loses a part of its amplitude."""
    model = ContactModel(threads=1)
    model.effects = tuple(effect for effect in model.effects if effect.name in ("amplitude_loss", "edge_force", "viscous_friction"))
    sets = {"cutting_speed": np.repeat([0.1, 0.25, 0.5, 0.8], 5), "feed": np.tile(np.linspace(0.5e-5, 2.5e-5, 5), 4)}
    truth = {**VALUES, **sets, "amplitude_loss.kappa": KAPPA, "amplitude_loss.F_ref": F_REF, "amplitude_loss.response_time": 1e-3}
    forces = model.settled(tuple(f"mean_measured_{name.removeprefix('mean_')}" for name in FORCES), ("amplitude_loss",), truth)
    draw = np.random.default_rng(3)
    columns = {name: forces[f"mean_measured_{name.removeprefix('mean_')}"] * (1 + 2e-3 * draw.normal(size=20)) for name in FORCES}
    means = Means("means.csv", tuple(f"row {k}" for k in range(20)), sets, columns, {})
    signals = {name: Signal(name, name, "N", "output") for name in FORCES}
    return Experiment(Path(), "cuts", "", Nominal(VALUES, (), {"F_C": 0.1}), signals, (), means, ""), model


def test_the_load_at_which_an_amplitude_is_lost_is_no_parameter() -> None:
    """Only kappa over F_ref counts: fitted both, neither was known, and the effect was taken for no better known than its size."""
    experiment, model = lossy()
    assert "amplitude_loss.F_ref" not in {variable.name for effect in model.effects for variable in shapes(effect)}
    answer, comparison = diagnose_with(experiment, model)
    (named,) = answer.effects
    kappa, sd, _ = named.parameters["kappa"]
    told_at, exactly, unit = named.parameters["F_ref"]
    assert (named.name, exactly, unit) == ("amplitude_loss", 0.0, "N")
    assert kappa / told_at == pytest.approx(KAPPA / F_REF, rel=0.05)
    assert sd < 0.1 * kappa
    corrected = content(answer, comparison)
    assert corrected.values["amplitude_loss.F_ref"] == told_at
    assert "usual magnitude" in corrected.sources["amplitude_loss.F_ref"]


def test_what_the_nominal_model_says_of_its_effects_stands() -> None:
    """And what it says of none that is off is no part of the corrected model."""
    experiment, model = lossy()
    nominal = replace(experiment.nominal, effects=("amplitude_loss",), values={**VALUES, "amplitude_loss.kappa": KAPPA})
    assert "amplitude_loss.F_ref" not in at_usual_references(model, replace(experiment, nominal=nominal)).nominal.values
    assert at_usual_references(model, experiment).nominal.values["amplitude_loss.F_ref"] != F_REF
