"""Is told what the numbers of a recording hide: a sensor at the end of its range, an angle that begins anew, a load that reads below 0?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.commands.main import app
from evat.experiment import ExperimentError
from evat.experiment.compression import compress_experiment
from evat.experiment.read import read_experiment, scan_experiment
from evat.identification import Settings, identify
from evat.model import FloatArray
from evat.models.contact import ContactModel
from typer.testing import CliRunner

MODEL = ContactModel(threads=1)
TIMES = np.arange(2000) * 1e-3
VELOCITY = 0.05 * np.sin(2 * np.pi * TIMES)
TOML = """format = 1
title = "rig"
[nominal]
friction = "coulomb"
kinematics = "external"
{nominal}
values = {{ F_C = 9.0 }}
[signals.time]
column = "t"
unit = "s"
[signals.slip_velocity]
column = "v"
{slip}
role = "input"
[signals.friction_force]
column = "F"
unit = "N"
role = "output"
{force}
{more}
[[trials]]
file = "a.csv"
condition = "c"
"""
LOAD = """[signals.normal_load]
column = "N"
unit = "N"
role = "input"
"""


def folder(
    at: Path, slip: FloatArray, force: FloatArray, *, shown: str = 'unit = "m/s"', full_scale: str = "", nominal: str = "",
    load: FloatArray | None = None,
) -> Path:  # fmt: skip
    toml = TOML.format(slip=shown, force=full_scale, nominal=nominal, more="" if load is None else LOAD)
    (at / "experiment.toml").write_text(toml, encoding="utf-8")
    columns = {"t": TIMES[: slip.size], "v": slip, "F": force} | ({} if load is None else {"N": load})
    np.savetxt(at / "a.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return at


def cut_off(seed: int = 1) -> FloatArray:
    force = 8.0 * np.tanh(VELOCITY / 1e-3) + np.random.default_rng(seed).normal(0, 0.3, TIMES.size)
    return np.clip(force, -8.4, 8.4)


@pytest.mark.parametrize(
    ("full_scale", "sign"), [("full_scale = 8.4", 1), ("full_scale = 8.4\noffset = 2.0", 1), ("full_scale = 8.4\nsign = -1", -1)]
)
def test_a_sensor_at_the_end_of_its_range_is_told(tmp_path: Path, full_scale: str, sign: int) -> None:
    at = folder(tmp_path, VELOCITY, sign * cut_off(), full_scale=full_scale)
    count = int(np.count_nonzero(np.abs(cut_off()) >= 8.4 * 0.999))
    told = f"a.csv, column 'F': friction_force is at the end of the sensor's range (full_scale) in {count} of 2000 samples"
    assert count > 100
    assert [remark.text.startswith(told) for remark in scan_experiment(at, MODEL).remarks] == [True]
    assert told in CliRunner().invoke(app, ["experiment", "check", str(at)]).output
    if "offset" not in full_scale:
        answer = identify(read_experiment(at, MODEL), MODEL, ["F_C"], Settings(search="none", profiles=False))
        assert any(doubt.startswith(told) for doubt in answer.doubts)


def test_a_range_that_is_wide_enough_is_no_doubt(tmp_path: Path) -> None:
    assert read_experiment(folder(tmp_path, VELOCITY, cut_off(), full_scale="full_scale = 10.0"), MODEL).remarks == ()


def test_the_range_is_that_of_the_sensor_whatever_is_taken_off(tmp_path: Path) -> None:
    at = folder(tmp_path, VELOCITY, cut_off(), full_scale="full_scale = 8.4", nominal="mass = 3.0\ngravity_load = 1.0")
    assert [remark.doubt for remark in read_experiment(at, MODEL).remarks] == [True]


@pytest.mark.parametrize(
    ("unit", "turn", "radius"), [("deg", 360.0, "radius = 0.01"), ("rad", 2 * np.pi, "radius = 0.01"), ("deg", 360.0, "scale = 0.01")]
)
@pytest.mark.parametrize("lowest", [0.0, -0.5])
def test_an_angle_that_begins_anew_goes_on(tmp_path: Path, unit: str, turn: float, radius: str, lowest: float) -> None:
    """A shaft that turns five times ahead and back again; unlike in lines between its samples, no speed of 30 m/s comes of it."""
    turns = 2.5 * (1 - np.cos(2 * np.pi * TIMES / 2))
    angle = (np.remainder(turns - lowest, 1.0) + lowest) * turn
    at = folder(tmp_path, angle, TIMES, shown=f'unit = "{unit}"\nfrom = "position"\n{radius}')
    experiment = read_experiment(at, MODEL)
    speed = 2.5 * np.pi * np.sin(2 * np.pi * TIMES / 2) * 2 * np.pi * 0.01
    np.testing.assert_allclose(experiment.trials[0].inputs["slip_velocity"][2:-2], speed[2:-2], atol=2e-4)
    told = f"the angle begins a new turn at {int(np.count_nonzero(np.abs(np.diff(angle)) > turn / 2))} samples"
    assert told in experiment.remarks[0].text
    assert told in CliRunner().invoke(app, ["experiment", "check", str(at)]).output.replace("\n", " ")
    assert not experiment.remarks[0].doubt


def test_an_angle_that_goes_beyond_a_turn_stays_as_it_is(tmp_path: Path) -> None:
    """A fast shaft whose samples lie more than half a turn apart is not turned back."""
    angle = 300.0 * np.arange(TIMES.size)
    at = folder(tmp_path, angle, TIMES, shown='unit = "deg"\nfrom = "position"\nradius = 1e-4')
    experiment = read_experiment(at, MODEL)
    np.testing.assert_allclose(experiment.trials[0].inputs["slip_velocity"], np.deg2rad(300) * 1e3 * 1e-4, rtol=1e-6)
    assert experiment.remarks == ()


def test_what_is_compressed_is_remarked_on_as_well(tmp_path: Path) -> None:
    at = folder(tmp_path, VELOCITY, cut_off(), full_scale="full_scale = 8.4")
    assert compress_experiment(at, MODEL, samples=500).experiment.remarks == read_experiment(at, MODEL).remarks != ()


def test_a_load_that_reads_just_below_nothing_is_none(tmp_path: Path) -> None:
    """As public records of a tribometer do, by a few 1e-5 of the largest."""
    load = np.where(TIMES < 0.3, 5e-4 * np.sin(500 * TIMES), 20.0)
    experiment = read_experiment(folder(tmp_path, VELOCITY, VELOCITY, load=load), MODEL)
    np.testing.assert_allclose(experiment.trials[0].inputs["normal_load"], np.maximum(load, 0.0), atol=1e-5)  # as any bound
    (remark,) = experiment.remarks
    assert "normal_load reads below 0 in" in remark.text
    assert "by 0.0025 % of its largest value at most" in remark.text
    assert scan_experiment(tmp_path, MODEL).remarks == experiment.remarks
    assert scan_experiment(tmp_path, MODEL).trials[0].least["normal_load"] > -1e-5


@pytest.mark.parametrize("low", [-1.5, -20.0])
def test_a_load_that_is_clearly_below_nothing_is_refused(tmp_path: Path, low: float) -> None:
    at = folder(tmp_path, VELOCITY, VELOCITY, load=np.where(TIMES < 0.3, low, 20.0))
    with pytest.raises(ExperimentError, match=rf"'N', data row 1: normal_load = {low:g} N; allowed is 0 to .* for its noise and its zero"):
        read_experiment(at, MODEL)


def test_how_far_a_load_may_read_below_nothing_is_what_its_owner_says(tmp_path: Path) -> None:
    at = folder(tmp_path, VELOCITY, VELOCITY, load=np.where(TIMES < 0.3, -0.2, 20.0))
    assert len(read_experiment(at, MODEL).remarks) == 1
    document = (at / "experiment.toml").read_text()
    (at / "experiment.toml").write_text(document + "[setup_sd.normal_load]\nzero = 0.01\n")
    with pytest.raises(ExperimentError, match=r"normal_load = -0\.2 N"):
        read_experiment(at, MODEL)
