"""Is a recorded input that the model does not read told of?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from evat.commands.main import app
from evat.experiment.read import read_experiment
from evat.identification import Settings, identify
from evat.required_inputs import unread_inputs
from test_experiment_conversion import MODEL, TIMES, TOML, VELOCITY
from typer.testing import CliRunner


def test_an_input_that_nothing_reads_is_told(tmp_path: Path) -> None:
    """Whether it is checked, identified from or diagnosed; with the right proxy_source it is not."""
    column = '[signals.proxy_speed]\ncolumn = "p"\nunit = "m/s"\nrole = "input"\n[signals.friction_force]'
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([TIMES, VELOCITY, 9 * np.sign(VELOCITY), TIMES + 0.1]),
        delimiter=",",
        header="t,x,F,p",
        comments="",
    )
    said = []
    for nominal in ("", 'proxy_source = "proxy_speed"'):
        toml = TOML.format(slip='unit = "m/s"', force='unit = "N"', nominal=nominal).replace("[signals.friction_force]", column)
        (tmp_path / "experiment.toml").write_text(toml, encoding="utf-8")
        shown = " ".join(CliRunner().invoke(app, ["experiment", "check", str(tmp_path)]).output.split())
        made = read_experiment(tmp_path, MODEL)
        doubts = identify(made, MODEL, ["F_C"], Settings(search="none", profiles=False)).doubts
        wanted = 'Set proxy_source = "proxy_speed"'
        said.append([wanted in shown, any(wanted in doubt for doubt in doubts)])
        assert unread_inputs(MODEL, made.nominal.values, made.recorded) == tuple(doubt for doubt in doubts if wanted in doubt)
    assert said == [[True, True], [False, False]]


def test_the_speed_of_a_test_is_a_remark_and_its_temperature_is_none(tmp_path: Path) -> None:
    """Both are stated for a trial whose slip was recorded. Of the speed it was told that it is recorded and should be the proxy."""
    np.savetxt(tmp_path / "a.csv", np.column_stack([TIMES, VELOCITY, 9 * np.sign(VELOCITY)]), delimiter=",", header="t,x,F", comments="")
    toml = (
        TOML.format(slip='unit = "m/s"', force='unit = "N"', nominal="") + "values = {cutting_speed = 0.1, contact_temperature = 400.0}\n"
    )
    (tmp_path / "experiment.toml").write_text(toml, encoding="utf-8")
    shown = " ".join(CliRunner().invoke(app, ["experiment", "check", str(tmp_path)]).output.split())
    made = read_experiment(tmp_path, MODEL)
    (doubt,) = (each for each in identify(made, MODEL, ["F_C"], Settings(search="none", profiles=False)).doubts if "proxy" in each)
    assert doubt.startswith("contact_temperature is stated and the model does not read it")
    assert doubt in shown
    assert shown.count("does not read it") == 1


def test_a_load_that_the_law_does_not_read_is_told(tmp_path: Path) -> None:
    column = '[signals.normal_load]\ncolumn = "p"\nunit = "N"\nrole = "input"\n[signals.friction_force]'
    rows = np.column_stack([TIMES, VELOCITY, 9 * np.sign(VELOCITY), 50 + TIMES])
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="t,x,F,p", comments="")
    shown = {}
    for law in ("lugre", "amontons"):
        toml = TOML.format(slip='unit = "m/s"', force='unit = "N"', nominal="").replace("[signals.friction_force]", column)
        toml = toml.replace('"coulomb"', f'"{law}"')
        (tmp_path / "experiment.toml").write_text(toml, encoding="utf-8")
        shown[law] = " ".join(CliRunner().invoke(app, ["experiment", "check", str(tmp_path)]).output.split())
    assert "what reads it: friction_law = amontons, the effect load_dependence" in shown["lugre"]
    assert "what reads it" not in shown["amontons"]
