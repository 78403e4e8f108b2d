"""Are records as people have them read right: positions, currents, torques, turned signs, moved masses?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.experiment import ExperimentError
from evat.experiment.read import read_experiment, write_experiment
from evat.experiment.smoothing import derivative
from evat.model import FloatArray
from evat.models.contact import ContactModel

MODEL = ContactModel(threads=1)
TIMES = np.arange(2000) * 1e-3
POSITION = 0.02 * (1 - np.cos(2 * np.pi * TIMES)) + 0.05
VELOCITY = 0.02 * 2 * np.pi * np.sin(2 * np.pi * TIMES)
ACCELERATION = 0.02 * (2 * np.pi) ** 2 * np.cos(2 * np.pi * TIMES)
TOML = """format = 1
title = "axis"
[nominal]
friction = "coulomb"
kinematics = "external"
{nominal}
[nominal.values]
F_C = 9.0
[signals.time]
column = "t"
unit = "s"
[signals.slip_velocity]
column = "x"
{slip}
role = "input"
[signals.friction_force]
column = "F"
{force}
role = "output"
[[trials]]
file = "a.csv"
condition = "c"
"""


def folder(at: Path, x: FloatArray, force: FloatArray, *, slip: str = 'unit = "m/s"', shown: str = 'unit = "N"', nominal: str = "") -> Path:
    (at / "experiment.toml").write_text(TOML.format(slip=slip, force=shown, nominal=nominal), encoding="utf-8")
    np.savetxt(at / "a.csv", np.column_stack([TIMES, x, force]), delimiter=",", header="t,x,F", comments="")
    return at


def columns(at: Path) -> tuple[FloatArray, FloatArray]:
    (trial,) = read_experiment(at, MODEL).trials
    return trial.inputs["slip_velocity"], trial.outputs["friction_force"]


@pytest.mark.parametrize(
    ("noise", "step", "allowed"), [(0.0, 0.0, 2e-6), (2e-6, 0.0, 6e-4), (2e-5, 0.0, 2.5e-3), (0.0, 1e-6, 5e-4), (0.0, 2e-5, 3e-3)]
)
def test_a_position_is_differentiated(tmp_path: Path, noise: float, step: float, allowed: float) -> None:
    """Exact, noisy, and by an encoder; plain differences of 2 um of noise are off by 1.4e-3 m/s, of an encoder of 20 um by 6e-3 m/s."""
    x = POSITION + noise * np.random.default_rng(1).normal(size=TIMES.size)
    x = np.round(x / step) * step if step else x
    slip, _ = columns(folder(tmp_path, 1e3 * x, TIMES, slip='unit = "mm"\nfrom = "position"'))
    assert np.sqrt(np.mean((slip - VELOCITY)[5:-5] ** 2)) < allowed


def test_second_derivatives_follow_a_corner() -> None:
    bent = np.where(TIMES < 1, 0.0, 0.5 * 3.0 * (TIMES - 1) ** 2) + 1e-6 * np.random.default_rng(2).normal(size=TIMES.size)
    second = derivative(bent, 1e-3, 2)
    assert pytest.approx(0.0, abs=0.3) == second[:900].mean()
    assert pytest.approx(3.0, rel=0.05) == second[1100:-20].mean()


def test_sign_scale_and_offset(tmp_path: Path) -> None:
    """A motor's current, counted the other way, with a zero of its own; a spindle in turns per minute."""
    at = folder(
        tmp_path, np.full(2000, 60.0), TIMES, slip='unit = "rpm"\nscale = 0.025', shown='unit = "mA"\nscale = 5.0\nsign = -1\noffset = 0.2'
    )
    slip, force = columns(at)
    assert pytest.approx(2 * np.pi * 0.025) == slip[0]
    assert pytest.approx(-(5e-3 * TIMES + 0.2)) == force


def test_a_mass_and_a_load_are_taken_off(tmp_path: Path) -> None:
    measured = 3.0 * np.sign(VELOCITY) + 2.0 * ACCELERATION + 9.81
    slip, force = columns(folder(tmp_path, VELOCITY, measured, nominal="mass = 2.0\ngravity_load = 9.81"))
    assert np.array_equal(slip, VELOCITY.round(18)) or pytest.approx(VELOCITY) == slip
    assert np.sqrt(np.mean((force - 3.0 * np.sign(VELOCITY))[5:-5] ** 2)) < 0.01


def test_what_was_converted_is_written_in_si(tmp_path: Path) -> None:
    (tmp_path / "rig").mkdir()
    at = folder(tmp_path / "rig", 1e3 * POSITION, TIMES, slip='unit = "mm"\nfrom = "position"', shown='unit = "kN"\nsign = -1')
    experiment = read_experiment(at, MODEL)
    (again,) = read_experiment(write_experiment(experiment, tmp_path / "copy"), MODEL).trials
    assert np.array_equal(again.inputs["slip_velocity"], experiment.trials[0].inputs["slip_velocity"])
    assert np.array_equal(again.outputs["friction_force"], experiment.trials[0].outputs["friction_force"])


@pytest.mark.parametrize(
    ("slip", "shown", "nominal", "what"),
    [
        ('unit = "mm/s"\nfrom = "position"', 'unit = "N"', "", "signals.slip_velocity.unit: 'mm/s' does not measure"),
        ('unit = "mm"\nfrom = "place"', 'unit = "N"', "", "signals.slip_velocity.from: 'place'; allowed is 'position'"),
        ('unit = "m/s"', 'unit = "m"\nfrom = "position"', "", "friction_force is no velocity"),
        ('unit = "m/s"\nsign = 2', 'unit = "N"', "", "signals.slip_velocity.sign: 2; allowed are 1 and -1"),
        ('unit = "m/s"', 'unit = "A"', "", "signals.friction_force.unit: 'A' does not measure"),
        ('unit = "m/s"', 'unit = "A"\nscale = 0', "", "signals.friction_force.scale: 0; a finite number is needed, not 0"),
        ('unit = "m/s"', 'unit = "N"', "mass = -1.0", "nominal.mass: -1.0; a number in kg of at least 0"),
    ],
)
def test_what_cannot_be_converted_is_refused(tmp_path: Path, slip: str, shown: str, nominal: str, what: str) -> None:
    with pytest.raises(ExperimentError) as caught:
        columns(folder(tmp_path, VELOCITY, TIMES, slip=slip, shown=shown, nominal=nominal))
    assert what in str(caught.value)


def test_an_uneven_clock_cannot_be_differentiated(tmp_path: Path) -> None:
    at = folder(tmp_path, 1e3 * POSITION, TIMES, slip='unit = "mm"\nfrom = "position"')
    uneven = TIMES + 3e-4 * np.sin(TIMES * 300)
    np.savetxt(at / "a.csv", np.column_stack([uneven, POSITION, TIMES]), delimiter=",", header="t,x,F", comments="")
    with pytest.raises(ExperimentError, match=r"a.csv: the clock is uneven"):
        columns(at)
