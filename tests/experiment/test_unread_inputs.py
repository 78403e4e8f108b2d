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
        assert unread_inputs(MODEL, made.nominal.values, made.given) == tuple(doubt for doubt in doubts if wanted in doubt)
    assert said == [[True, True], [False, False]]
