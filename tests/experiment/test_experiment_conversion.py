"""Are records as people have them read right: positions, currents, torques, turned signs, moved masses?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, ExperimentError, Nominal, trigger
from evat.experiment.read import read_experiment
from evat.experiment.smoothing import derivative, mean_step
from evat.experiment.write import write_experiment
from evat.inference.checks import rms
from evat.inference.prediction import Prediction
from evat.inference.recorded_inputs import same_motion, smoothed_inputs
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


@pytest.mark.parametrize(("rate", "tick"), [(3e4, 1e-6), (45.0, 1e-3), (30.0, 1e-3)])
def test_a_rounded_clock_makes_no_velocity_faster(tmp_path: Path, rate: float, tick: float) -> None:
    """A step of 33.3 us is written as 33, 33 and 34: by 33 the velocity is 1 % too fast, and so is one that is differentiated once more."""
    clock, slow = np.round(np.arange(2000) / rate / tick) * tick, 1e3 / rate
    noise = 1e-6 * np.random.default_rng(1).normal(size=clock.size)
    at = folder(tmp_path, 1e3 * (POSITION + noise), TIMES, slip='unit = "mm"\nfrom = "position"')
    np.savetxt(at / "a.csv", np.column_stack([clock, 1e3 * (POSITION + noise), TIMES]), delimiter=",", header="t,x,F", comments="")
    recorded = smoothed_inputs(read_experiment(at, MODEL))
    assert recorded.perturbed is not None
    for made in (recorded.experiment, recorded.perturbed):
        slip = slow * made.trials[0].inputs["slip_velocity"]
        assert slip @ VELOCITY / (VELOCITY @ VELOCITY) == pytest.approx(1, abs=5e-4)


def test_lost_samples_make_no_step_longer() -> None:
    clock = np.round(np.delete(np.arange(3000) / 3e4, np.s_[1000:1500]), 6)
    assert mean_step(clock) == pytest.approx(1 / 3e4, rel=1e-4)


def test_few_samples_of_a_period_are_no_filter() -> None:
    """Of 12 samples a period plain differences lose 4.5 % of the velocity, and at the ends they are half a sample off."""
    times = np.arange(60) / 12
    slope = derivative(np.sin(2 * np.pi * times), 1 / 12)
    assert np.max(np.abs(slope - 2 * np.pi * np.cos(2 * np.pi * times))[2:-2]) < 0.003 * 2 * np.pi
    assert np.max(np.abs(slope - 2 * np.pi * np.cos(2 * np.pi * times))) < 0.02 * 2 * np.pi


@pytest.mark.parametrize("seed", range(1, 4))
def test_the_first_and_the_last_velocity_are_as_sure_as_their_neighbours(seed: int) -> None:
    """Noise of 5 um at 5 kHz is 35 mm/s in the slope of three samples; a first velocity that is so far off bends bristles at once."""
    times = np.arange(4000) / 5000
    x = 0.02 * (1 - np.cos(2 * np.pi * times)) + 5e-6 * np.random.default_rng(seed).normal(size=times.size)
    off = derivative(x, 1 / 5000) - 0.02 * 2 * np.pi * np.sin(2 * np.pi * times)
    assert np.max(np.abs(off[[0, 1, -2, -1]])) < 0.006


def test_the_top_of_a_velocity_is_not_cut_off_by_noise() -> None:
    x = POSITION + 5e-6 * np.random.default_rng(3).normal(size=TIMES.size)
    slip = derivative(x, 1e-3)
    assert slip @ VELOCITY / (VELOCITY @ VELOCITY) == pytest.approx(1, abs=7e-4)


def test_a_motion_run_backward_has_the_velocities_of_it_turned_round() -> None:
    """No window looks ahead more than it looks back: velocities stand at their samples."""
    x = np.where(TIMES < 0.7, 0.0, 0.03 * (TIMES - 0.7)) + 5e-6 * np.random.default_rng(4).normal(size=TIMES.size)
    assert derivative(x[::-1], 1e-3) == pytest.approx(-derivative(x, 1e-3)[::-1], abs=1e-9)


def test_second_derivatives_follow_a_corner() -> None:
    bent = np.where(TIMES < 1, 0.0, 0.5 * 3.0 * (TIMES - 1) ** 2) + 1e-6 * np.random.default_rng(2).normal(size=TIMES.size)
    second = derivative(bent, 1e-3, 2)
    assert pytest.approx(0.0, abs=0.3) == second[:900].mean()
    assert pytest.approx(3.0, rel=0.05) == second[1100:-20].mean()


def test_second_derivatives_follow_a_start_and_a_stop() -> None:
    """Of an encoder of 5 um at 300 Hz: a parabola was off by half more, by a tenth of the peak where the axis speeds up."""
    times = np.arange(0, 2.4, 1 / 6000)
    share = np.clip((times[:, None] - [0.3, 0.9, 1.05, 1.65, 1.8]) / 0.06 + 0.5, 0, 1)
    speed = 0.2 * (share - np.sin(2 * np.pi * share) / (2 * np.pi)) @ [1.0, -0.5, -1.5, 0.5, 1.5]
    position, acceleration = (np.cumsum(speed) / 6000)[::20], np.gradient(speed, 1 / 6000)[::20]
    off = derivative(np.round(position / 5e-6) * 5e-6, 1 / 300, 2) - acceleration
    assert np.sqrt(np.mean(off**2)) < 0.055


def test_sign_scale_and_offset(tmp_path: Path) -> None:
    """A motor's current, counted the other way, with a zero of its own that is added as it stands; a spindle in turns per minute."""
    at = folder(
        tmp_path, np.full(2000, 60.0), TIMES, slip='unit = "rpm"\nscale = 0.025', shown='unit = "mA"\nscale = 5.0\nsign = -1\noffset = 0.2'
    )
    slip, force = columns(at)
    assert pytest.approx(2 * np.pi * 0.025) == slip[0]
    assert pytest.approx(-5e-3 * TIMES + 0.2) == force


def test_a_zero_is_stated_in_the_unit_of_the_column(tmp_path: Path) -> None:
    """How far the zero of a current may be off is a current, and that of a scaled force so much force."""
    at = folder(tmp_path, VELOCITY, TIMES, shown='unit = "mA"\nscale = -5.0')
    (at / "experiment.toml").write_text((at / "experiment.toml").read_text() + "[setup_sd.friction_force]\nzero = 20.0\n")
    assert read_experiment(at, MODEL).setup_sd["friction_force"].zero == pytest.approx(0.1)


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


@pytest.mark.parametrize(
    ("slip", "column"),
    [
        ('unit = "rad/s"\nradius = 0.05', VELOCITY / 0.05),
        ('unit = "deg/s"\nradius = 0.05', np.degrees(VELOCITY / 0.05)),
        ('unit = "rpm"\nradius = 0.05', VELOCITY / 0.05 / (2 * np.pi) * 60),
        ('unit = "deg"\nradius = 0.05\nfrom = "position"', np.degrees(POSITION / 0.05)),
    ],
)
def test_a_lever_arm_turns_angles_into_ways(tmp_path: Path, slip: str, column: FloatArray) -> None:
    """And a torque into a force: 3 N at 50 mm are 0.15 N m."""
    got, force = columns(folder(tmp_path, column, np.full(2000, 150.0), slip=slip, shown='unit = "mN.m"\nradius = 0.05'))
    assert pytest.approx(VELOCITY[2:-2], abs=1e-5) == got[2:-2]
    assert pytest.approx(3.0) == force


@pytest.mark.parametrize(
    ("slip", "what"),
    [
        ('unit = "m/s"\nradius = 0.05', "'m/s' does not measure what 'rad/s' measures"),
        ('unit = "rad/s"\nradius = 0.0', "signals.slip_velocity.radius: 0.0; a lever arm above 0 in m"),
        ('unit = "rad/s"\nradius = 0.1\nscale = 2.0', "signals.slip_velocity.radius: there is a scale, too"),
    ],
)
def test_a_lever_arm_that_fits_nothing_is_refused(tmp_path: Path, slip: str, what: str) -> None:
    with pytest.raises(ExperimentError) as caught:
        columns(folder(tmp_path, VELOCITY, TIMES, slip=slip))
    assert what in str(caught.value)


def marked(at: Path, on: FloatArray, force: FloatArray, unit: str = 'unit = "V"\n') -> Path:
    """The folder with a trigger column."""
    toml = TOML.format(slip='unit = "m/s"', force='unit = "N"', nominal="").replace(
        "[signals.slip_velocity]", '[signals.trigger]\ncolumn = "cut"\n' + unit + "[signals.slip_velocity]"
    )
    (at / "experiment.toml").write_text(toml, encoding="utf-8")
    np.savetxt(at / "a.csv", np.column_stack([TIMES, VELOCITY, force, on]), delimiter=",", header="t,x,F,cut", comments="")
    return at


def test_a_trigger_marks_what_counts(tmp_path: Path) -> None:
    """Two cuts in one file, by a logic level with noise; between them the force is that of something else."""
    place = np.arange(2000)
    cut = ((place > 200) & (place < 700)) | (place > 1400)
    level = 5.0 * cut + 0.2 * np.sin(1e3 * TIMES)
    (tmp_path / "rig").mkdir()
    experiment = read_experiment(marked(tmp_path / "rig", level, np.where(cut, 9.0 * np.sign(VELOCITY), 1e3)), MODEL)
    assert [trial.file for trial in experiment.trials] == ["a-part1.csv", "a-part2.csv"]
    first, second = experiment.trials
    assert (first.times[0], first.times[-1], second.times[0]) == (TIMES[201], TIMES[699], TIMES[1401])
    assert first.lead_in is not None
    assert second.lead_in is not None
    assert (first.lead_in.times.size, second.lead_in.times[0]) == (201, TIMES[700])
    assert all(np.max(np.abs(trial.outputs["friction_force"])) < 10 for trial in experiment.trials)
    again = read_experiment(write_experiment(experiment, tmp_path / "copy"), MODEL)
    for one, other in zip(experiment.trials, again.trials, strict=True):
        assert np.array_equal(one.outputs["friction_force"], other.outputs["friction_force"])
        assert other.lead_in is not None
        assert np.array_equal(one.lead_in.inputs["slip_velocity"], other.lead_in.inputs["slip_velocity"])
    (tmp_path / "unitless").mkdir()
    same = read_experiment(marked(tmp_path / "unitless", level, np.where(cut, 9.0 * np.sign(VELOCITY), 1e3), unit=""), MODEL)
    assert [trial.times.size for trial in same.trials] == [first.times.size, second.times.size]


def test_a_contact_wears_on_between_the_stretches_that_a_trigger_marks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction wears by 30 % over 0.1 m, of which the record shows 0.16: each stretch, and one that begins late, is predicted as the whole
    record is there, though few rows lead in. Without wear stretches of one motion stay repeats of each other."""
    monkeypatch.setattr(trigger, "LEAD_IN", 100)
    values = {"kinematics": "external", "friction_law": "coulomb", "F_C": 9.0, "friction_wear.delta": 0.3, "friction_wear.s_0": 0.1}
    ons = {
        "whole": np.ones(2000),
        "cut": 1.0 * (np.arange(2000) % 1000 > 10),
        "late": 1.0 * (TIMES >= 1.5),
    }
    runs = dict[str, Experiment]()
    for name, on in ons.items():
        (tmp_path / name).mkdir()
        at = marked(tmp_path / name, on, TIMES)
        plain = read_experiment(at, MODEL)
        assert all("sliding_distance" not in trial.values for trial in plain.trials)
        text = (at / "experiment.toml").read_text(encoding="utf-8")
        text = text.replace('friction = "coulomb"', 'friction = "coulomb"\neffects = ["friction_wear"]').replace(
            'condition = "c"', 'condition = "c"\nvalues = { sliding_distance = 0.02 }'
        )
        (at / "experiment.toml").write_text(text, encoding="utf-8")
        runs[name] = read_experiment(at, MODEL)
    whole = Prediction(MODEL, runs["whole"]).one(values)
    for name in ("cut", "late"):
        for trial in runs[name].trials:
            part = Prediction(MODEL, replace(runs[name], trials=(trial,))).one(values)
            first = int(np.searchsorted(TIMES, trial.times[0]))
            assert part == pytest.approx(whole[first : first + part.size], abs=0.02)
    first, second = runs["cut"].trials
    assert first.values["sliding_distance"] == 0.02
    assert second.values["sliding_distance"] == pytest.approx(0.02 + 0.08, rel=5e-3)


def test_a_lead_in_is_simulated_and_does_not_count(tmp_path: Path) -> None:
    """A part of a record is predicted as the whole record is there; from its own first row the bristles would begin relaxed."""
    values = {"kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e4, "v_s": 0.01}
    whole = read_experiment(marked(tmp_path, np.ones(2000), TIMES), MODEL)
    part = read_experiment(marked(tmp_path, 1.0 * (TIMES >= 0.1), TIMES), MODEL)
    run = {"experiment": whole, "part": part}
    rows = {name: Prediction(MODEL, replace(made, nominal=Nominal(values, (), {}))).one() for name, made in run.items()}
    assert rows["part"].size == 1900
    assert pytest.approx(rows["experiment"][100:], abs=1e-3) == rows["part"]
    alone = replace(part, nominal=Nominal(values, (), {}), trials=tuple(replace(trial, lead_in=None) for trial in part.trials))
    assert np.max(np.abs(Prediction(MODEL, alone).one() - rows["part"])) > 1.0


@pytest.mark.parametrize(
    ("on", "what"),
    [
        (np.zeros(2000), "a.csv, column 'cut': the trigger is never on"),
        (np.where(np.arange(2000) == 40, 1.0, 0.0), "a.csv, column 'cut', data row 41: the trigger is on for 1 rows only"),
    ],
)
def test_a_trigger_that_marks_nothing_is_refused(tmp_path: Path, on: FloatArray, what: str) -> None:
    with pytest.raises(ExperimentError, match=what):
        read_experiment(marked(tmp_path, on, TIMES), MODEL)


def test_repeats_of_a_noisy_position_are_one_motion(tmp_path: Path) -> None:
    """By white noise their velocities are far apart; what is left of it after both were averaged is told by differentiating anew."""
    at, draw = folder(tmp_path, 1e3 * POSITION, TIMES, slip='unit = "mm"\nfrom = "position"'), np.random.default_rng(7)
    text = (at / "experiment.toml").read_text(encoding="utf-8")
    for name in "abc":
        x = 1e3 * (POSITION + 5e-6 * draw.normal(size=TIMES.size))
        np.savetxt(at / f"{name}.csv", np.column_stack([TIMES, x, TIMES]), delimiter=",", header="t,x,F", comments="")
    more = "".join(f'[[trials]]\nfile = "{name}.csv"\ncondition = "c"\n' for name in "bc")
    (at / "experiment.toml").write_text(text + more, encoding="utf-8")
    experiment = read_experiment(at, MODEL)
    alone = experiment.trials[0].inputs["slip_velocity"] - VELOCITY
    assert experiment.trials[0].position_sd["slip_velocity"] == pytest.approx(5e-6, rel=0.1)
    assert same_motion(experiment.trials) == [[0, 1, 2]]
    recorded = smoothed_inputs(experiment)
    assert recorded.perturbed is not None
    one = recorded.experiment.trials[0].inputs["slip_velocity"]
    assert rms(one - VELOCITY) < rms(alone)
    assert rms(recorded.perturbed.trials[0].inputs["slip_velocity"] - one) == pytest.approx(rms(one - VELOCITY), rel=0.6)
