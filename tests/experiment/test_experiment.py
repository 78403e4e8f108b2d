"""Does a measured experiment get from its folder into memory unharmed, and is one that cannot be trusted refused in so many words?"""

from __future__ import annotations

import dataclasses
import math
import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from evat import parameter_sets
from evat.commands.main import app
from evat.experiment import Experiment, ExperimentError, Means, Nominal, SetupSd, Signal, Trial, as_typed
from evat.experiment import write as experiment_writer
from evat.experiment.read import read_experiment, scan_experiment
from evat.experiment.write import write_experiment
from evat.files import stream
from evat.files.writing import OutputError
from evat.inference.parameters import nominal_parameters
from evat.inference.prediction import Prediction
from evat.models.contact import ContactModel
from evat.native import kernel
from evat.plots.cycles import in_display_unit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

MODEL = ContactModel()
VARIABLES = {variable.name: variable for variable in MODEL.variables}
VALUES = "values = { cutting_speed = 0.25 }"
TOML = """
format = 1
title = "Friction rig, copper on carbide"
intended_use = "feed-force prediction at 5 to 30 m/min"
[nominal]
friction = "lugre"
kinematics = "external"
parameters = "lugre-1995"
effects = []
[nominal.values]
F_C = 12.0
[nominal.relative_sd]
F_C = 0.2
[signals.time]
column = "t [ms]"
unit = "ms"
[signals.slip_velocity]
column = "v"
unit = "mm/s"
role = "input"
[signals.friction_force]
column = "F"
unit = "N"
role = "output"
full_scale = 50.0
[[trials]]
file = "trials/c1_a.csv"
condition = "c1"
values = { cutting_speed = 0.25 }
[[trials]]
file = "trials/c1_b.csv"
condition = "c1"
values = { cutting_speed = 0.25 }
[[trials]]
file = "trials/c2_a.csv"
condition = "c2"
"""
DATA = "t [ms],v,note,F\n0,1,a,2\n1,2.5,b,-3\n3,3,c,4\n"
MEANS_TOML = """
format = 1
title = "Cycle means"
[nominal]
friction = "coulomb"
kinematics = "internal"
values = { F_C = 9 }
[means]
file = "means.csv"
"""
MEANS = """cutting_speed [m/min],feed [mm],mean_principal_force,mean_feed_force [kN],mean_feed_force_sd [N]
6,0.1,10.5,0.008,2.2
12,0.1,8,5e-3,0.9
"""
MEANS_SIGNALS = """
[signals.cutting_speed]
column = "speed"
unit = "m/min"
role = "input"
[signals.mean_feed_force]
column = "Ff"
unit = "kN"
role = "output"
"""


def folder(at: Path, toml: str = TOML, data: str = DATA) -> Path:
    (at / "trials").mkdir(parents=True)
    (at / "experiment.toml").write_text(toml, encoding="utf-8")
    for name in ("c1_a", "c1_b", "c2_a"):
        (at / "trials" / f"{name}.csv").write_text(data, encoding="utf-8")
    return at


def means_folder(at: Path, toml: str = MEANS_TOML, data: str = MEANS) -> Path:
    at.mkdir(exist_ok=True)
    (at / "experiment.toml").write_text(toml, encoding="utf-8")
    (at / "means.csv").write_text(data, encoding="utf-8")
    return at


def refusal(at: Path) -> str:
    """What reading says; scanning says the same."""
    with pytest.raises(ExperimentError) as caught:
        read_experiment(at, MODEL)
    with pytest.raises(ExperimentError) as scanned:
        scan_experiment(at, MODEL)
    assert str(scanned.value) == str(caught.value)
    return str(caught.value)


# What is right is read.


def test_the_documented_folder_is_read_in_si(tmp_path: Path) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    assert (recorded.title, recorded.intended_use) == ("Friction rig, copper on carbide", "feed-force prediction at 5 to 30 m/min")
    assert recorded.conditions == ("c1", "c2")
    assert recorded.outputs == ("friction_force",)
    first = recorded.trials[0]
    assert (first.file, first.condition, first.values) == ("trials/c1_a.csv", "c1", {"cutting_speed": 0.25})
    assert first.times.tolist() == [0, 1e-3, 3e-3]
    assert first.inputs["slip_velocity"].tolist() == [1e-3, 2.5e-3, 3e-3]
    assert first.outputs["friction_force"].tolist() == [2, -3, 4]
    assert recorded.signals["friction_force"] == Signal("friction_force", "F", "N", "output", 50.0)
    assert recorded.signals["time"].role is None
    assert recorded.nominal.values["F_C"] == 12
    assert recorded.nominal.values["sigma0"] == parameter_sets.load("lugre-1995").values["sigma0"]
    assert (recorded.nominal.values["friction_law"], recorded.nominal.values["kinematics"]) == ("lugre", "external")
    assert (recorded.nominal.relative_sd, recorded.nominal.default_relative_sd, recorded.nominal.effects) == ({"F_C": 0.2}, 0.1, ())
    assert read_experiment(tmp_path / "rig" / "experiment.toml", MODEL).data_hash == recorded.data_hash


def test_full_scale_is_in_the_unit_of_its_column(tmp_path: Path) -> None:
    toml = TOML.replace('column = "F"\nunit = "N"', 'column = "F"\nunit = "mN"')
    assert read_experiment(folder(tmp_path / "rig", toml), MODEL).signals["friction_force"].full_scale == pytest.approx(0.05, rel=1e-15)


@pytest.mark.parametrize(
    ("nominal", "effects"),
    [
        ('parameters = "published/copper"\neffects = []', ()),
        ('parameters = "published/copper"\neffects = ["thermal_damping"]', ("thermal_damping",)),
        ('parameters = "published/copper"', ("thermal_softening", "thermal_damping")),  # what the set itself switches on
    ],
)
def test_effects_are_those_named_or_else_those_of_the_set(tmp_path: Path, nominal: str, effects: tuple[str, ...]) -> None:
    toml = TOML.replace('parameters = "lugre-1995"\neffects = []', nominal)
    recorded = read_experiment(folder(tmp_path / "rig", toml), MODEL)
    assert recorded.nominal.effects == effects
    assert recorded.nominal.values["damping_mode"] == "as_published"


def test_a_set_beside_the_document_is_loaded_and_counts_in_the_hash(tmp_path: Path) -> None:
    rig = folder(tmp_path / "rig", TOML.replace('"lugre-1995"', '"mine.ssv"'))
    parameter_sets.save_ssv(parameter_sets.ParameterSet("mine", "mine", {"sigma0": 3e4, "F_C": 1.0}), rig / "mine.ssv")
    first = read_experiment(rig, MODEL)
    assert (first.nominal.values["sigma0"], first.nominal.values["F_C"], first.nominal.parameters) == (3e4, 12, "mine.ssv")
    parameter_sets.save_ssv(parameter_sets.ParameterSet("mine", "mine", {"sigma0": 3e4 + 1, "F_C": 1.0}), rig / "mine.ssv")
    assert read_experiment(rig, MODEL).data_hash != first.data_hash


def test_names_with_a_dot_need_no_quotes(tmp_path: Path) -> None:
    toml = TOML.replace("F_C = 12.0", "thermal_softening.Q = 2\n'thermal_softening.k_Q' = 3")
    values = read_experiment(folder(tmp_path / "rig", toml), MODEL).nominal.values
    assert (values["thermal_softening.Q"], values["thermal_softening.k_Q"]) == (2, 3)


def test_conditions_of_means_have_six_digits(tmp_path: Path) -> None:
    """20 m/min was "cutting_speed=0.3333333333333333"."""
    recorded = read_experiment(means_folder(tmp_path, data=MEANS.replace("\n6,", "\n20,")), MODEL)
    assert recorded.conditions == ("cutting_speed=0.333333, feed=0.0001", "cutting_speed=0.2, feed=0.0001")


def test_means_are_read_in_si_and_named_after_what_varied(tmp_path: Path) -> None:
    recorded = read_experiment(means_folder(tmp_path), MODEL)
    assert recorded.means is not None
    assert recorded.means.values["cutting_speed"] == pytest.approx([0.1, 0.2], rel=1e-15)
    assert recorded.means.outputs["mean_feed_force"] == pytest.approx([8, 5], rel=1e-15)
    assert recorded.means.outputs["mean_principal_force"].tolist() == [10.5, 8]
    assert {name: column.tolist() for name, column in recorded.means.sd.items()} == {"mean_feed_force": [2.2, 0.9]}
    assert recorded.means.conditions == recorded.conditions == ("cutting_speed=0.1, feed=0.0001", "cutting_speed=0.2, feed=0.0001")
    assert recorded.outputs == ("mean_principal_force", "mean_feed_force")
    assert recorded.samples == 4


def test_signals_may_head_the_columns_of_means(tmp_path: Path) -> None:
    recorded = read_experiment(
        means_folder(tmp_path, MEANS_TOML + MEANS_SIGNALS, "speed,Ff,condition\n6,0.008,slow\n12,0.005,fast\n"), MODEL
    )
    assert recorded.means is not None
    assert recorded.means.conditions == ("slow", "fast")
    assert recorded.means.values["cutting_speed"] == pytest.approx([0.1, 0.2], rel=1e-15)
    assert recorded.means.outputs["mean_feed_force"] == pytest.approx([8, 5], rel=1e-15)


@pytest.mark.parametrize(
    ("more", "forces"),
    [
        ("sign = -1\n", [-8, -5]),
        ("scale = 2.0\n", [16, 10]),
        ("offset = 1.0\n", [9, 6]),
        ("sign = -1\nscale = 2.0\noffset = 1.0\n", [-15, -9]),
    ],
)
def test_signals_convert_the_columns_of_means(tmp_path: Path, more: str, forces: list[float]) -> None:
    """As those of trials: sign and scale of what stands in the file, then the offset."""
    data = "speed,Ff,mean_feed_force_sd\n6,0.008,0.001\n12,0.005,0.002\n"
    recorded = read_experiment(means_folder(tmp_path, MEANS_TOML + MEANS_SIGNALS + more, data), MODEL)
    assert recorded.means is not None
    assert recorded.means.outputs["mean_feed_force"] == pytest.approx(forces, rel=1e-15)
    assert recorded.means.sd["mean_feed_force"] == pytest.approx([2, 4] if "scale" in more else [1, 2], rel=1e-15)


def test_an_average_is_not_differentiated(tmp_path: Path) -> None:
    toml = MEANS_TOML + MEANS_SIGNALS.replace('unit = "m/min"', 'unit = "m"\nfrom = "position"')
    assert "column 'speed': signals.cutting_speed.from: an average is not differentiated" in refusal(
        means_folder(tmp_path, toml, "speed,Ff\n6,0.008\n12,0.005\n")
    )


@pytest.mark.parametrize(("header", "sd"), [("", [1, 2]), (" [kN]", [1, 2]), (" [N]", [1e-3, 2e-3])])
def test_a_standard_deviation_has_the_unit_of_its_mean_or_its_own(tmp_path: Path, header: str, sd: list[float]) -> None:
    data = f"speed,Ff,mean_feed_force_sd{header}\n6,0.008,0.001\n12,0.005,0.002\n"
    means = read_experiment(means_folder(tmp_path, MEANS_TOML + MEANS_SIGNALS, data), MODEL).means
    assert means is not None
    assert means.sd["mean_feed_force"] == pytest.approx(sd, rel=1e-15)


def test_a_spread_of_what_is_scaled_may_stand_in_volts_or_in_newtons(tmp_path: Path) -> None:
    signals = MEANS_SIGNALS.replace('unit = "kN"', 'unit = "V"\nscale = -10.0')
    for header, sd in ((" [mV]", [0.01, 0.02]), (" [N]", [1, 2]), ("", [10, 20])):
        data = f"speed,Ff,mean_feed_force_sd{header}\n6,0.8,1\n12,0.5,2\n"
        means = read_experiment(means_folder(tmp_path, MEANS_TOML + signals, data), MODEL).means
        assert means is not None
        assert means.outputs["mean_feed_force"] == pytest.approx([-8, -5], rel=1e-15)
        assert means.sd["mean_feed_force"] == pytest.approx(sd, rel=1e-15)


def test_names_of_conditions_are_names_whatever_they_spell(tmp_path: Path) -> None:
    names = ("NULL", "nan", "1.0", "N/A", "true")
    rows = "".join(f"{name},{place},1\n" for place, name in enumerate(names))
    assert read_experiment(means_folder(tmp_path, data="condition,cutting_speed,mean_feed_force\n" + rows), MODEL).conditions == names


def test_means_at_the_values_of_a_trial_are_of_its_condition(tmp_path: Path) -> None:
    rig = folder(tmp_path / "rig", TOML.replace('"external"', '"internal"') + '[means]\nfile = "means.csv"\n')
    (rig / "means.csv").write_text("cutting_speed,mean_feed_force\n0.25,3\n0.5,4\n")
    recorded = read_experiment(rig, MODEL)
    assert recorded.means is not None
    assert recorded.means.conditions == ("c1", "cutting_speed=0.5")
    assert recorded.conditions == ("c1", "c2", "cutting_speed=0.5")
    held_out = recorded.only(["c2", "cutting_speed=0.5"])
    assert held_out.means is not None
    assert (len(held_out.trials), held_out.means.outputs["mean_feed_force"].tolist()) == (1, [4])


def test_a_trial_may_say_how_far_the_contact_had_slid_and_how_noisy_it_is(tmp_path: Path) -> None:
    """The friction that has worn in comes back at once, not from the beginning; written and read again it is the same."""
    stated = "values = { sliding_distance = 30.0 }\nnoise_sd = { friction_force = 0.02 }"
    read = read_experiment(folder(tmp_path / "rig", TOML.replace(VALUES, stated)), MODEL)
    trial = read_experiment(write_experiment(read, tmp_path / "again"), MODEL).trials[0]
    assert (trial.values, trial.noise_sd) == ({"sliding_distance": 30.0}, {"friction_force": 0.02})
    times = np.linspace(0.0, 1.0, 101)
    slid = replace(trial, times=times, inputs={"slip_velocity": np.full(101, 0.1)}, outputs={"friction_force": np.ones(101)})
    new = replace(slid, file="new", values={})
    nominal = Nominal({"kinematics": "external", "friction_law": "coulomb", "F_C": 10.0}, ("friction_wear",), {})
    worn, fresh = np.split(Prediction(MODEL, replace(read, nominal=nominal, trials=(slid, new))).one(), 2)
    law = 10.0 * (1 + 0.2 * (1 - np.exp(-(30.0 + 0.1 * times[1:]) / 10.0)))  # delta and s_0 at their starts
    assert worn[1:] == pytest.approx(law, rel=1e-6)
    assert fresh[1] == pytest.approx(10.0, rel=1e-3)


@pytest.mark.parametrize(
    ("stated", "what"),
    [
        ('values = { sliding_distance = "far" }', "sliding_distance: 'far'; a finite number"),
        ("noise_sd = { friction_force = 0.0 }", "a standard deviation above 0"),
        ("noise_sd = { slip_velocity = 1.0 }", "name an output"),
        ("noise_sd = { frictionforce = 1.0 }", "did you mean friction_force"),
    ],
)
def test_what_a_trial_cannot_state_is_refused(tmp_path: Path, stated: str, what: str) -> None:
    assert what in refusal(folder(tmp_path, TOML.replace(VALUES, stated)))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("cell", "scale"), [("1e308", 1), ("-1e150", 1), ("1e13", 1), ("1e308", 1e6), ("10", 1e12)])
def test_a_number_that_no_sensor_tells_is_named_by_its_row(tmp_path: Path, cell: str, scale: float) -> None:
    toml = TOML.replace("full_scale = 50.0", f"scale = {scale}")
    message = refusal(folder(tmp_path, toml, f"t [ms],v,F\n0,1,2\n1,2.5,{cell}\n3,3,4\n"))
    assert message.startswith(f"trials/c1_a.csv, column 'F', data row {1 if scale == 1e12 else 2}: "), message
    assert "friction_force of more than 1e+12 N is no measurement" in message


def test_only_takes_conditions_and_nothing_else(tmp_path: Path) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    assert [trial.file for trial in recorded.only(["c1"]).trials] == ["trials/c1_a.csv", "trials/c1_b.csv"]
    assert recorded.only(["c2", "c1"]).trials == recorded.trials
    for wrong in (["c3"], []):
        with pytest.raises(ExperimentError, match="'c1', 'c2'"):
            recorded.only(wrong)


def test_numbers_cannot_be_changed_in_place(tmp_path: Path) -> None:
    trial = read_experiment(folder(tmp_path / "rig"), MODEL).trials[0]
    for column in (trial.times, *trial.inputs.values(), *trial.outputs.values()):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1


@pytest.mark.parametrize("header", ["v (rake face)", "v [raw]", "v (C)", "v [mm/s]", "v (mm/s)", "v"])
def test_brackets_may_hold_text_or_the_same_unit(tmp_path: Path, header: str) -> None:
    rig = folder(tmp_path / "rig", TOML.replace('column = "v"', f'column = "{header}"'), DATA.replace(",v,", f",{header},"))
    assert read_experiment(rig, MODEL).trials[0].inputs["slip_velocity"][0] == 1e-3


def test_a_column_is_read_by_its_whole_length_not_by_how_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """CSV readers guess a column's type from its first block: whole numbers first, then a fraction, then an exponent."""
    monkeypatch.setattr(stream, "CSV_BLOCK", 64)
    rows = [(str(k), "0", str(k)) for k in range(30)] + [("30.5", "1e-3", "0.25"), ("31", "-1E2", "1")]
    data = "t [ms],v,F\n" + "\n".join(",".join(row) for row in rows)
    trial = read_experiment(folder(tmp_path / "rig", data=data), MODEL).trials[0]
    assert trial.times == pytest.approx([float(row[0]) * 1e-3 for row in rows], rel=1e-15)
    assert trial.inputs["slip_velocity"] == pytest.approx([float(row[1]) * 1e-3 for row in rows], rel=1e-15)
    assert trial.outputs["friction_force"].tolist() == [float(row[2]) for row in rows]


def as_parquet(rig: Path, columns: dict[str, object]) -> Path:
    toml = (rig / "experiment.toml").read_text(encoding="utf-8")
    (rig / "experiment.toml").write_text(toml.replace(".csv", ".parquet"), encoding="utf-8")
    for name in ("c1_a", "c1_b", "c2_a"):
        pa.parquet.write_table(pa.table(columns), rig / "trials" / f"{name}.parquet", row_group_size=5)
    return rig


def test_parquet_is_read_as_csv_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream, "PARQUET_ROWS", 3)
    columns = {"t [ms]": np.arange(11.0), "v": pa.array(range(11)), "F": pa.array(np.arange(11) / 3, pa.float64()), "note": ["x"] * 11}
    trial = read_experiment(as_parquet(folder(tmp_path / "rig"), columns), MODEL).trials[0]
    assert trial.times == pytest.approx(np.arange(11) * 1e-3, rel=1e-15)
    assert trial.outputs["friction_force"].tolist() == (np.arange(11) / 3).tolist()
    assert trial.inputs["slip_velocity"].size == 11


# A scan is a reading that keeps nothing.


def test_a_scan_finds_what_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream, "CSV_BLOCK", 128)
    draw = np.random.default_rng(3)
    times, velocity, force = np.cumsum(draw.uniform(0.5, 1.5, 500)), draw.standard_normal(500), draw.standard_normal(500)
    data = "t [ms],v,F\n" + "".join(
        f"{t!r},{v!r},{f!r}\n" for t, v, f in zip(times.tolist(), velocity.tolist(), force.tolist(), strict=True)
    )
    rig = folder(tmp_path / "rig", data=data)
    told: list[float] = []
    recorded, scan = read_experiment(rig, MODEL), scan_experiment(rig, MODEL, progress=told.append)
    assert scan.data_hash == recorded.data_hash
    facts, trial = scan.trials[0], recorded.trials[0]
    assert (facts.rows, facts.begin, facts.end) == (500, trial.times[0], trial.times[-1])
    assert (facts.shortest, facts.longest) == (np.diff(trial.times).min(), np.diff(trial.times).max())
    for name, column in {**trial.inputs, **trial.outputs}.items():
        assert (facts.least[name], facts.most[name]) == (column.min(), column.max())
        assert facts.rms[name] == pytest.approx(np.sqrt(np.mean(column**2)), rel=1e-12)  # sums in another order
    assert told == sorted(told)
    assert 0 < told[0] < told[-1] == 1


def test_the_hash_knows_every_byte_of_every_file(tmp_path: Path) -> None:
    rig = folder(tmp_path / "rig")
    hashes = [read_experiment(rig, MODEL).data_hash]
    for file in ("trials/c1_a.csv", "trials/c2_a.csv", "experiment.toml"):
        with (rig / file).open("a") as opened:
            opened.write("\n")
        hashes.append(read_experiment(rig, MODEL).data_hash)
    assert len(set(hashes)) == 4
    (rig / "trials" / "not named.csv").write_text("1")
    assert read_experiment(rig, MODEL).data_hash == hashes[-1]


# What is wrong in the document is refused: the file, the key, what was found, what to do.


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("format = 1", "format = 2", r"format: 2; this version reads format 1"),
        ("format = 1", "format = true", r"format: True; this version reads format 1"),
        ("format = 1\n", "", r"key 'format' is missing"),
        ("format = 1", "format = 1\nformat = 1", r"no readable TOML file: Cannot overwrite a value"),
        ("format = 1", "format = 1\nx = " + "[" * 5000, r"line 3: a key or its value has more than 32 levels"),
        ("intended_use", "intended_usage", r"key 'intended_usage' is not known; did you mean intended_use\?"),
        ("[nominal.values]", "[nominal.value]", r"nominal: key 'value' is not known; did you mean values"),
        ("role =", "rôle =", r"no readable TOML|not known"),
        ("full_scale = 50.0", "fullscale = 50.0", r"signals.friction_force: key 'fullscale' is not known; did you mean full_scale"),
        ("full_scale = 50.0", "full_scale = -1", r"signals.friction_force.full_scale: -1; a number above 0 in N"),
        ("full_scale = 50.0", "full_scale = nan", r"full_scale: nan"),
        ('friction = "lugre"', 'friction = "lugr"', r"nominal.friction: friction_law = 'lugr': allowed is one of .*; did you mean lugre\?"),
        ('friction = "lugre"\n', "", r"nominal: friction is missing; allowed are .*lugre"),
        ('kinematics = "external"\n', "", r"nominal: kinematics is missing; allowed are internal, external"),
        ('kinematics = "external"', "kinematics = 1", r"nominal.kinematics: 1; allowed is one of internal"),
        (
            "effects = []",
            'effects = ["thermal_softning"]',
            r"nominal.effects: there is no effect 'thermal_softning'; did you mean thermal_softening",
        ),
        ("effects = []", 'effects = ["stribeck", "stribeck"]', r"'stribeck' is there twice"),
        ("effects = []", 'effects = "stribeck"', r"nominal.effects: 'stribeck'; a list of names"),
        ("effects = []", 'effects = ["cross_talk"]\nproxy = 1', r"key 'proxy' is not known"),
        ('"lugre-1995"', '"lugre-1996"', r"nominal.parameters: there is no file 'lugre-1996'"),
        ('"lugre-1995"', "1995", r"nominal.parameters: 1995; a text in quotes"),
        ('parameters = "lugre-1995"\n', "", None),
        ("F_C = 12.0", "F_c = 12.0", r"nominal.values.F_c: the component has no variable 'F_c'; did you mean F_C"),
        ("F_C = 12.0", "mass = 12.0", r"nominal.values.mass: it is no value of the component; mass stands in \[nominal\] itself"),
        ('friction = "lugre"', 'friction = "lugre"\nmasse = 1.0', r"nominal: key 'masse' is not known; did you mean mass\?"),
        ("F_C = 12.0", "F_C = -12.0", r"nominal.values.F_C: F_C = -12 N: allowed is 1e-06 to 1e\+06 N.*in SI: is the unit right"),
        ("F_C = 12.0", "F_C = nan", r"nominal.values.F_C: F_C = nan: a finite number in N"),
        ("F_C = 12.0", 'F_C = "12 N"', r"nominal.values.F_C: '12 N'; a bare number in N is needed"),
        ("F_C = 12.0", "F_C = 1" + "0" * 400, r"nominal.values.F_C: 10{11,13}\.\.\.0{12,16}; a bare number in N is needed"),
        ("F_C = 12.0", "F_C = 1" + "0" * 5000, r"no readable TOML file"),
        ("F_C = 12.0", "F_C = {}", r"nominal.values.F_C: {}; a bare number in N is needed"),
        ("F_C = 0.2", "F_C = 1e300", r"nominal.relative_sd.F_C: 1e\+300; a number of at least 0 and at most 1e\+12"),
        (
            'friction = "lugre"',
            'friction = "lugre"\nmass = 1e300',
            r"nominal.mass: 1e\+300; a number in kg of at least 0 and at most 1e\+12",
        ),
        ("full_scale = 50.0", "scale = 1e308", r"friction_force.scale: 1e\+308; a finite number is needed, not 0, of at most 1e\+12"),
        ("[signals.time]", "[setup_sd.friction_force]\ngain = 1e300\n[signals.time]", r"friction_force.gain: 1e\+300; .*from 0 to 1e\+12"),
        ("[signals.time]", "[setup_sd.friction_force]\nclock = 1e300\n[signals.time]", r"friction_force.clock: 1e\+300; .*from 0 to"),
        ("[signals.time]", '[reader]\ndelimiter = ""\n[signals.time]', "reader.delimiter: ''; one character between columns is needed"),
        ("trials/c1_a.csv", "a" * 5000, r"'a{30,40}\.\.\.a{30,40}' cannot be opened: File name too long"),
        ("F_C = 0.2", "F_C = 1" + "0" * 400, r"nominal.relative_sd.F_C: 10{11,13}\.\.\.0{12,16}; a number of at least 0"),
        ("F_C = 12.0", "F_C = true", r"nominal.values.F_C: True; a bare number in N is needed"),
        ("F_C = 12.0", "damping_mode = 1", r"nominal.values.damping_mode: 1; allowed is one of dissipative, as_published"),
        ("F_C = 12.0", "friction_force = 12.0", r"friction_force is an output of the component; only parameters and inputs can be set"),
        ("F_C = 12.0", 'friction_law = "dahl"', r"nominal.values.friction_law: the choice stands in \[nominal\] as friction"),
        ("F_C = 12.0", "run_out = 1", r"nominal.values.run_out: this is the switch of an effect; name it in nominal.effects"),
        ("F_C = 0.2", "F_C = -0.2", r"nominal.relative_sd.F_C: -0.2; a number of at least 0"),
        ("F_C = 0.2", "damping_mode = 0.2", r"nominal.relative_sd.damping_mode: only numbers"),
        ("F_C = 0.2", "F_D = 0.2", r"nominal.relative_sd.F_D: the component has no variable 'F_D'"),
        ("F_C = 0.2", "mass = 0.2", r"nominal.relative_sd.mass: mass has no standard deviation of its own: a mass is known to 5 %"),
        ('unit = "mm/s"', 'unit = "mm/fortnite"', r"signals.slip_velocity.unit: unit 'mm/fortnite'"),
        ('unit = "mm/s"', 'unit = "mm"', r"signals.slip_velocity.unit: 'mm' does not measure what 'm/s' measures"),
        ('unit = "mm/s"\n', "", r"signals.slip_velocity: key 'unit' is missing"),
        ('unit = "ms"', 'unit = "m"', r"signals.time.unit: 'm' does not measure what 's' measures"),
        ('unit = "ms"', 'unit = "ms"\nrole = "input"', r"signals.time.role: 'input'; the clock has no role"),
        ('role = "input"', 'role = "output"', r"signals.slip_velocity.role: role = 'output'; slip_velocity is an input of the component"),
        ('role = "output"\n', 'role = "input"\n', r"signals.friction_force.role: role = 'input'; friction_force is an output"),
        ('role = "input"\n', "", r"signals.slip_velocity.role: the role is missing"),
        ("[signals.friction_force]", "[signals.friction_forces]", r"no variable 'friction_forces'; did you mean friction_force"),
        ("[signals.friction_force]", "[signals.friction_impulse]", r"signals.friction_impulse: this is a local \(real\)"),
        ("[signals.friction_force]", "[signals.slip_velocity]", r"no readable TOML file: Cannot declare"),
        ('column = "v"', 'column = "F"', r"signals.friction_force: column 'F' already is slip_velocity"),
        ('[signals.time]\ncolumn = "t [ms]"\nunit = "ms"\n', "", r"signals: the clock is missing; add \[signals.time\]"),
        ("[signals.slip_velocity]", "[signals.proxy_speed]", r"trials/c1_a.csv: kinematics = external takes the motion from slip_velocity"),
        ("[signals.slip_velocity]", "[signals.feed]", r"signals.feed.unit: 'mm/s' does not measure"),
        ("[signals.slip_velocity]", "[signals.sigma2]", r"signals.sigma2.unit"),
        (
            "cutting_speed = 0.25",
            "cutting_speed = 250",
            r"trials/c1_a.csv\), values.cutting_speed: cutting_speed = 250 m/s: allowed is 0 to 100 m/s",
        ),
        ("cutting_speed = 0.25", 'friction_law = "dahl"', r"trials 1.values.friction_law: only numbers vary from trial to trial"),
        ("cutting_speed = 0.25", "speed = 0.25", r"trials 1.values.speed: the component has no variable 'speed'"),
        ("cutting_speed = 0.25", "slip_velocity = 0.25", r"trials/c1_a.csv: slip_velocity is a signal and among the trial's values too"),
        ('condition = "c1"\n', "", r"trials 1: key 'condition' is missing"),
        ('condition = "c1"', 'condition = " "', r"trials 1.condition: it is empty"),
        ('condition = "c1"', "condition = 1", r"trials 1.condition: 1; a text in quotes"),
        ('condition = "c1"', 'kondition = "c1"', r"trials 1: key 'kondition' is not known; did you mean condition"),
        ("[[trials]]", "[trials]", r"no readable TOML file|trials: write each recording"),
        ("c1_b.csv", "c1_a.csv", r"trials/c1_a.csv is named twice"),
        ("trials/c1_b.csv", "trials/./c1_a.csv", r"is named twice"),
        ("trials/c1_b.csv", "trials/c1_c.csv", r"trials 2.file: there is no file 'trials/c1_c.csv' in .*rig"),
    ],
)
def test_a_document_that_says_something_else_is_refused(tmp_path: Path, old: str, new: str, what: str | None) -> None:
    assert old in TOML
    rig = folder(tmp_path / "rig", TOML.replace(old, new, 1))
    if what is None:  # allowed: the values stand for themselves
        assert read_experiment(rig, MODEL).nominal.parameters == ""
        return
    message = refusal(rig)
    assert message.startswith("experiment.toml") or "trials/" in message
    assert re.search(what, message), message


def test_nothing_measured_is_said(tmp_path: Path) -> None:
    head = TOML.partition("[[trials]]")[0]
    assert "neither [[trials]] nor [means]" in refusal(folder(tmp_path / "a", head))
    no_output = TOML.replace('[signals.friction_force]\ncolumn = "F"\nunit = "N"\nrole = "output"\nfull_scale = 50.0\n', "")
    assert "there is no output" in refusal(folder(tmp_path / "b", no_output))
    bare = TOML.replace('parameters = "lugre-1995"\n', "").replace("[nominal.values]\nF_C = 12.0\n", "")
    assert "there are no values" in refusal(folder(tmp_path / "c", bare))
    assert "there is no such file" in refusal(tmp_path / "nowhere")
    assert "there is no such file; an experiment is a folder" in refusal(tmp_path)
    (tmp_path / "01.csv").write_text("t,v\n0,1\n")
    assert "01.csv: that is a file of data; name the folder in which experiment.toml says" in refusal(tmp_path / "01.csv")


def test_a_nominal_effect_without_its_input_is_refused(tmp_path: Path) -> None:
    message = refusal(folder(tmp_path / "rig", TOML.replace("effects = []", 'effects = ["load_dependence"]')))
    assert "trials/c1_a.csv: the nominal model's load_dependence cannot act without normal_load" in message


@pytest.mark.parametrize("key", ["trials/c1_b.csv", "lugre-1995"])
@pytest.mark.parametrize(
    "name",
    [
        "../outside.csv",
        "/etc/passwd",
        "trials/../../outside.csv",
        "trials/../trials/c1_b.csv",
        "C:\\\\data.csv",
        "trials\\\\c1_a.csv",
        "",
        "link.csv",
        "linked/outside.csv",
        "trials",
        "x" * 5000,
    ],
)
def test_files_elsewhere_are_not_opened(tmp_path: Path, key: str, name: str) -> None:
    (tmp_path / "outside.csv").write_text(DATA)
    (tmp_path / "outside.ssv").write_text("")
    rig = folder(tmp_path / "rig", TOML.replace(key, name))
    (rig / "link.csv").symlink_to(tmp_path / "outside.csv")
    (rig / "linked").symlink_to(tmp_path)
    if key == "lugre-1995" and not name:
        return  # no set is named then
    message = refusal(rig)
    assert any(words in message for words in ("inside the experiment's folder", "leads out of", "there is no file", "cannot be opened")), (
        message
    )
    assert "root:" not in message


@pytest.mark.parametrize("name", ["C:data.csv", "/data.csv", "trials/../trials/c1_b.csv", "trials\\\\c1_b.csv", ""])
def test_names_that_lead_out_on_any_platform_are_refused_by_name(tmp_path: Path, name: str) -> None:
    rig = folder(tmp_path / "rig", TOML.replace("trials/c1_b.csv", name))
    (rig / "C:data.csv").write_text(DATA)
    assert "a file inside the experiment's folder is needed, written like trials/a.csv" in refusal(rig)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes on this platform")
def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    rig = folder(tmp_path / "rig", TOML.replace("c1_b.csv", "pipe.csv"))
    os.mkfifo(rig / "trials" / "pipe.csv")
    assert "there is no file 'trials/pipe.csv'" in refusal(rig)


# What is wrong in the data is refused: file, column, row.


def broken(row: int, column: int, text: str) -> Callable[[int], str]:
    """Data of so many rows, one cell changed; rows count from 1."""

    def data(rows: int) -> str:
        cells = [[str(k), str(k / 8), str(k % 3)] for k in range(rows)]
        cells[row - 1][column] = text
        return "t [ms],v,F\n" + "\n".join(map(",".join, cells)) + "\n"

    return data


@pytest.mark.parametrize("block", [64, 1 << 20])
@pytest.mark.parametrize(
    ("data", "what"),
    [
        (broken(70, 2, ""), "'F', data row 70: no finite number. Nothing is filled in"),
        (broken(70, 2, "nan"), "'F', data row 70: no finite number"),
        (broken(1, 1, "inf"), "'v', data row 1: no finite number"),
        (broken(100, 0, "NULL"), "'t [ms]', data row 100: no finite number"),
        (broken(70, 0, "68"), "'t [ms]', data row 70: the clock must increase from row to row; it goes from 0.068 to 0.068 s"),
        (broken(41, 0, "0"), "'t [ms]', data row 41: the clock must increase from row to row; it goes from 0.039 to 0 s"),
        (broken(51, 0, "1e6"), "data row 52: the clock must increase from row to row; it goes from 1000 to 0.051 s"),
        (broken(33, 1, "2e6"), "'v', data row 33: slip_velocity = 2000 m/s; allowed is -1000 to 1000 m/s. Its unit is given as mm/s"),
        (broken(33, 1, "abc"), "no table of numbers"),
        (broken(33, 1, "0,5"), "no table of numbers"),
        (broken(33, 2, "1 N"), "no table of numbers"),
    ],
)
def test_a_number_that_cannot_be_used_is_named_by_its_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: Callable[[int], str], what: str, block: int
) -> None:
    monkeypatch.setattr(stream, "CSV_BLOCK", block)
    rig = folder(tmp_path / "rig")
    (rig / "trials" / "c1_b.csv").write_text(data(100))
    message = refusal(rig)
    assert "c1_b.csv" in message
    assert what in message


@pytest.mark.parametrize(
    ("data", "what"),
    [
        ("", "no table of numbers"),
        ("t [ms],v,F\n", "it has 0 rows of data; a recording has at least 3"),
        ("t [ms],v,F\n1,1,1\n", "it has 1 row of data; a recording has at least 3"),
        (
            "t [ms],v\n1,1\n2,2\n",
            "there is no column 'F' for friction_force; it has 't [ms]', 'v'. Name the right one as signals.friction_force.column",
        ),
        ("t [ms],F,F,v\n1,1,1,1\n2,2,2,2\n", "two columns have the header 'F'"),
        ("t [ms],v,F\n1,1\n2,2,2\n", "line 2: 2 cells where the headers are 3"),
        ("\0" * 50, "no table of numbers|there is no column"),
    ],
)
def test_a_file_that_is_no_such_table_is_refused(tmp_path: Path, data: str, what: str) -> None:
    rig = folder(tmp_path / "rig")
    (rig / "trials" / "c2_a.csv").write_text(data)
    message = refusal(rig)
    assert "c2_a.csv" in message
    assert any(each in message for each in what.split("|")), message


def test_text_in_another_encoding_is_refused(tmp_path: Path) -> None:
    rig = folder(tmp_path / "rig")
    (rig / "trials" / "c2_a.csv").write_bytes(b"t [\xb5s],v,F\n1,1,1\n")
    assert "not written in UTF-8" in refusal(rig)


@pytest.mark.parametrize(
    ("columns", "what"),
    [
        ({"t [ms]": [0.0, 1, 2], "v": ["a", "b", "c"], "F": [0.0, 1, 2]}, "column 'v': it holds string; numbers are needed"),
        ({"t [ms]": [0.0, 1, 2], "v": [True, False, True], "F": [0.0, 1, 2]}, "it holds bool"),
        ({"t [ms]": [0.0, 1, 2], "v": [1, None, 2], "F": [0.0, 1, 2]}, "'v', data row 2: no finite number"),
        ({"t [ms]": [0.0, 1, 1], "v": [1, 3, 2], "F": [0.0, 1, 2]}, "data row 3: the clock must increase"),
        ({"t [ms]": [0.0, 1, 2], "v": [1, 3, 2]}, "there is no column 'F'"),
    ],
)
def test_parquet_is_refused_as_csv_is(tmp_path: Path, columns: dict[str, object], what: str) -> None:
    assert what in refusal(as_parquet(folder(tmp_path / "rig"), columns))


@pytest.mark.parametrize("row", [3, 4, 5])
def test_a_clock_that_stands_still_is_found_between_batches_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, row: int) -> None:
    monkeypatch.setattr(stream, "PARQUET_ROWS", 3)
    times = np.arange(9.0)
    times[row - 1] = times[row - 2]
    message = refusal(as_parquet(folder(tmp_path / "rig"), {"t [ms]": times, "v": times, "F": times}))
    assert f"data row {row}: the clock must increase" in message
    assert f"from {(row - 2) * 1e-3:g} to {(row - 2) * 1e-3:g} s" in message


def test_a_broken_parquet_file_is_refused(tmp_path: Path) -> None:
    rig = as_parquet(folder(tmp_path / "rig"), {"t [ms]": [0.0, 1], "v": [0.0, 1], "F": [0.0, 1]})
    path = rig / "trials" / "c1_b.parquet"
    path.write_bytes(path.read_bytes()[:-20])
    assert "c1_b.parquet: this is no table of numbers" in refusal(rig)


@pytest.mark.parametrize("header", ["v [m/s]", "v (m/s)", "v [m/min]", "v [N]", "v [s]"])
def test_a_header_that_states_another_unit_is_refused(tmp_path: Path, header: str) -> None:
    rig = folder(tmp_path / "rig", TOML.replace('column = "v"', f'column = "{header}"'), DATA.replace(",v,", f",{header},"))
    message = refusal(rig)
    assert f"trials/c1_a.csv, column '{header}': its header states {header[3:-1]}, the document says mm/s" in message


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (
            "condition,cutting_speed,mean_feed_force\na,0.1,1\na,0.2,2\n",
            "data row 2: the condition 'a' is in row 1 already, at other values",
        ),
        ("condition,cutting_speed,mean_feed_force\na,0.1,1\n,0.2,2\n", "'condition', data row 2: it is empty"),
        ("condition,cutting_speed,mean_feed_force\na,0.1,1\n  ,0.2,2\n", "data row 2: the condition has no name"),
        ("cutting_speed,mean_feed_force\n0.1,1\n0.2,\n", "'mean_feed_force', data row 2: no finite number"),
        ("cutting_speed,mean_feed_force\n0.1,1\n250,2\n", "data row 2: cutting_speed = 250 m/s; allowed is 0 to 100 m/s"),
        ("cutting_speed [mm],mean_feed_force\n0.1,1\n", "column 'cutting_speed [mm]': 'mm' does not measure"),
        ("speed,mean_feed_force\n0.1,1\n", "'speed' is no number that can be set and no mean"),
        ("cutting_sped,mean_feed_force\n0.1,1\n", "did you mean cutting_speed"),
        ("cutting_speed,feed_force\n0.1,1\n", "'feed_force' is no number that can be set and no mean; did you mean"),
        ("cutting_speed,feed\n0.1,1e-4\n", "there is no column of averages; head at least one like mean_"),
        (
            "cutting_speed,mean_feed_force,mean_principal_force_sd\n0.1,1,1\n",
            "there is mean_principal_force_sd and no mean_principal_force",
        ),
        ("cutting_speed,mean_feed_force,mean_feed_force_sd\n0.1,1,-1\n", "data row 1: mean_feed_force_sd = -1 N; allowed is 0 to inf"),
        ("cutting_speed,mean_feed_force,mean_feed_force [kN]\n0.1,1,1\n", "there is another column of mean_feed_force"),
        ("cutting_speed,mean_feed_force\n0.1,one\n", "column 'mean_feed_force': not all of it is numbers"),
        ("friction_law,mean_feed_force\n1,1\n", "'friction_law' is no number that can be set"),
    ],
)
def test_averages_that_cannot_be_used_are_refused(tmp_path: Path, data: str, what: str) -> None:
    message = refusal(means_folder(tmp_path, data=data))
    assert "means.csv" in message
    assert what in message


def test_averages_of_one_condition_are_replicates(tmp_path: Path) -> None:
    """Named alike, or run at the same values."""
    for data in (
        "cutting_speed,mean_feed_force\n0.1,1\n0.2,3\n0.1,2\n",
        "condition,cutting_speed,mean_feed_force\na,0.1,1\nb,0.2,3\na,0.1,2\n",
    ):
        means = read_experiment(means_folder(tmp_path, data=data), MODEL).means
        assert means is not None
        assert means.conditions[0] == means.conditions[2] != means.conditions[1]


def test_averages_without_a_motion_are_refused(tmp_path: Path) -> None:
    toml = MEANS_TOML.replace("internal", "external")
    assert "means.csv: kinematics = external takes the motion from slip_velocity" in refusal(means_folder(tmp_path, toml))


# What is written is read.

FINITE = st.floats(-1e3, 1e3, allow_subnormal=True)
NAMES = st.text(st.characters(codec="utf-8", exclude_categories=("Cs",)), max_size=20)


@st.composite
def experiments(draw: st.DrawFn) -> Experiment:
    values: dict[str, float | str] = {"friction_law": "dahl", "kinematics": "external", "F_C": draw(st.floats(1e-6, 1e6))}
    values |= {"proxy_source": "cutting_speed", "thermal_softening.Q": draw(st.floats(0, 10))}
    nominal = Nominal(values, draw(st.sampled_from([(), ("stribeck",)])), {"F_C": draw(st.floats(0, 5))}, draw(st.sampled_from([0.1, 0.3])))
    signals = {
        "time": Signal("time", "t", "s", None),
        "slip_velocity": Signal("slip_velocity", draw(st.sampled_from(["v", '"v", [m/s]', "v;1"])), "m/s", "input"),
        "friction_force": Signal("friction_force", "friction, measured", "N", "output", draw(st.floats(1e-3, 1e3))),
    }
    trials = []
    for place in range(draw(st.integers(1, 3))):
        count = draw(st.integers(2, 20))
        times = np.cumsum(draw(st.lists(st.floats(1e-6, 10), min_size=count, max_size=count)))
        columns = [np.array(draw(st.lists(FINITE, min_size=count, max_size=count))) for _ in range(2)]
        condition = draw(NAMES.filter(str.strip))
        trial_values = {"cutting_speed": draw(st.floats(0, 100))}
        trials.append(
            Trial(f"deep/er/{place}.csv", condition, trial_values, times, {"slip_velocity": columns[0]}, {"friction_force": columns[1]})
        )
    means = None
    if draw(st.booleans()):
        conditions = tuple(
            draw(st.lists(NAMES.filter(lambda name: name.strip() and "\0" not in name), min_size=2, max_size=2, unique=True))
        )
        means = Means("m.csv", conditions, {"slip_velocity": np.array([0.1, 1 / 3])}, {"mean_feed_force": np.array([1.0, -2.0])}, {})
    return Experiment(Path(), draw(NAMES), draw(NAMES), nominal, signals, tuple(trials), means, "")


def test_a_standard_deviation_of_a_temperature_is_written_as_a_difference(tmp_path: Path) -> None:
    """0.5 K became -272.65 degC, and the folder was refused."""
    times = np.arange(30) * 0.1
    signals = {"time": Signal("time", "t", "s", None), "contact_temperature": Signal("contact_temperature", "T", "degC", "input")}
    signals["friction_force"] = Signal("friction_force", "F", "N", "output")
    trial = Trial("a.csv", "c", {}, times, {"contact_temperature": 300 + times}, {"friction_force": np.sin(times)})
    made = Experiment(
        Path(),
        "rig",
        "",
        Nominal({"friction_law": "coulomb", "kinematics": "external", "slip_velocity": 0.1}, (), {}),
        signals,
        (trial,),
        None,
        "",
    )
    made = replace(made, setup_sd={"contact_temperature": SetupSd(zero=0.5)})
    read = read_experiment(write_experiment(made, tmp_path / "rig"), MODEL)
    assert read.setup_sd["contact_temperature"].zero == pytest.approx(0.5)


def test_the_range_of_a_sensor_lies_about_its_offset_once_written_too(tmp_path: Path) -> None:
    """A sensor at the end of its range in 122 of 400 samples was none once the experiment had been written and read, and the other way
    round; the audit of a diagnosis asked for the range about 0."""
    toml = TOML.replace('column = "F"\nunit = "N"', 'column = "F"\nunit = "N"\noffset = 30.0')
    first = read_experiment(folder(tmp_path / "rig", toml), MODEL)
    again = read_experiment(write_experiment(first, tmp_path / "again"), MODEL)
    signal = again.signals["friction_force"]
    assert (signal.offset, signal.full_scale) == (30.0, first.signals["friction_force"].full_scale)
    for one, other in zip(first.trials, again.trials, strict=True):
        assert other.outputs["friction_force"] == pytest.approx(one.outputs["friction_force"], rel=1e-12)
    assert [remark.text for remark in again.remarks] == [remark.text for remark in first.remarks]


def test_an_offset_of_a_position_is_refused(tmp_path: Path) -> None:
    """It changed nothing, without a word."""
    toml = TOML.replace('column = "v"\nunit = "mm/s"', 'column = "v"\nunit = "mm"\nfrom = "position"\noffset = 0.02')
    with pytest.raises(ExperimentError, match=r"slip_velocity.offset: 0.02, added to a position: that changes no velocity"):
        read_experiment(folder(tmp_path / "rig", toml), MODEL)


def test_a_mean_below_nothing_is_refused_by_its_row(tmp_path: Path) -> None:
    """Of a record it is noise; a mean of -20 m/min was taken, and the model failed later, without a file or a row."""
    at = means_folder(tmp_path / "means")
    table = next(path for path in at.iterdir() if path.suffix == ".csv")
    rows = table.read_text(encoding="utf-8").splitlines()
    place = rows[0].split(",").index("cutting_speed [m/min]")
    cells = rows[2].split(",")
    cells[place] = "-20"
    rows[2] = ",".join(cells)
    table.write_text("\n".join(rows) + "\n", encoding="utf-8")
    signal = '\n[signals.cutting_speed]\ncolumn = "cutting_speed [m/min]"\nunit = "m/min"\nrole = "input"\n'
    for added in ("", signal):
        document = at / "experiment.toml"
        document.write_text(document.read_text(encoding="utf-8") + added, encoding="utf-8")
        with pytest.raises(ExperimentError, match=r"data row 2: cutting_speed = -0.333"):
            read_experiment(at, MODEL)


def test_what_no_signal_describes_is_not_written(tmp_path: Path) -> None:
    times = np.array([0.0, 1.0])
    trial = Trial("a.csv", "c", {}, times, {"slip_velocity": times}, {"friction_force": times})
    made = Experiment(Path(), "rig", "", Nominal({}, (), {}), {"time": Signal("time", "t", "s", None)}, (trial,), None, "")
    with pytest.raises(ExperimentError, match="friction_force, slip_velocity: recorded, but no signal"):
        write_experiment(made, tmp_path / "rig")
    assert not list(tmp_path.iterdir())


def test_how_well_a_value_is_known_may_be_stated_in_its_unit(tmp_path: Path) -> None:
    """As a data sheet has it; as a share of 293 K, or of what a parameter set has, it is a sum to be done by hand."""
    stated = TOML.replace("[nominal.relative_sd]", "[nominal.sd]\nv_s = 1e-4\n[nominal.relative_sd]")
    nominal = read_experiment(folder(tmp_path / "rig", stated), MODEL).nominal
    assert nominal.known_to(VARIABLES["v_s"]) == pytest.approx(1e-4 / float(nominal.values["v_s"]))
    for place, (line, words) in enumerate(
        (
            ("F_C = 1.0", "nominal.sd.F_C: it stands in nominal.relative_sd, too; keep one."),
            ("width = 1e-4", "nominal.sd.width: width is not stated, or 0, which stays as it is"),
            ("v_s = -1e-4", "nominal.sd.v_s: -0.0001; a number of at least 0 and at most 1e+12 is needed, such as 0.1 for 0.1 m/s"),
        )
    ):
        assert words in refusal(folder(tmp_path / str(place), stated.replace("v_s = 1e-4", line)))


def test_a_temperature_is_known_to_some_kelvins_unless_stated() -> None:
    """To a tenth of its kelvins, like all that nobody stated, an ambient one would be anything from 5 to 50 degrees."""
    ambient, friction = VARIABLES["ambient_temperature"], VARIABLES["F_C"]
    assert [Nominal({}, (), {}).known_to(each) for each in (ambient, friction)] == [0.01, 0.1]
    assert Nominal({}, (), {"ambient_temperature": 0.05}).known_to(ambient) == 0.05
    assert Nominal({}, (), {}, default_relative_sd=0.0).known_to(ambient) == 0.0
    (parameter,) = nominal_parameters(
        MODEL, Experiment(Path(), "rig", "", Nominal({"ambient_temperature": 293.15}, (), {}), {}, (), None, "")
    )
    assert parameter.value(1.0) - parameter.mean == pytest.approx(2.95, rel=0.01)


def test_a_nominal_value_may_be_off_where_a_trial_goes_by_it() -> None:
    """One that each trial states for itself, and each row of averages, is used nowhere; one that some of them state is."""

    def may_be_off(*stated: dict[str, float]) -> set[str]:
        trials = tuple(Trial(f"{place}.csv", "c", values, np.arange(2.0), {}, {}) for place, values in enumerate(stated))
        made = Experiment(Path(), "rig", "", Nominal({"F_C": 9.0, "sigma2": 40.0}, (), {}), {}, trials, None, "")
        return {each.name for each in nominal_parameters(MODEL, made)}

    assert may_be_off({}, {}) == may_be_off({}, {"sigma2": 30.0}) == {"F_C", "sigma2"}
    assert may_be_off({"sigma2": 40.0}, {"sigma2": 30.0}) == {"F_C"}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(made=experiments())
def test_what_is_written_is_read_to_the_last_bit(tmp_path_factory: pytest.TempPathFactory, suffix: str, made: Experiment) -> None:
    at = tmp_path_factory.mktemp("written") / "rig"
    recorded = read_experiment(write_experiment(made, at, suffix=suffix), MODEL)
    assert [each.name for each in at.parent.iterdir()] == ["rig"]  # nothing is left lying about
    assert (recorded.title, recorded.intended_use, recorded.signals) == (made.title, made.intended_use, made.signals)
    assert (recorded.nominal.values, recorded.nominal.effects) == (made.nominal.values, made.nominal.effects)
    for name in ("F_C", "thermal_softening.Q"):  # known as well as before, whether it is said for all or for each
        before, after = (some.nominal.known_to(VARIABLES[name]) for some in (made, recorded))
        assert before == after
    for ours, theirs in zip(made.trials, recorded.trials, strict=True):
        assert (ours.condition, dict(ours.values)) == (theirs.condition, theirs.values)
        assert Path(theirs.file) == Path(ours.file).with_suffix(suffix)
        assert ours.times.tobytes() == theirs.times.tobytes()
        assert ours.inputs["slip_velocity"].tobytes() == theirs.inputs["slip_velocity"].tobytes()
        assert ours.outputs["friction_force"].tobytes() == theirs.outputs["friction_force"].tobytes()
    assert (made.means is None) == (recorded.means is None)
    if made.means is not None and recorded.means is not None:
        assert made.means.conditions == recorded.means.conditions
        for name, column in {**made.means.values, **made.means.outputs}.items():
            assert column.tobytes() == {**recorded.means.values, **recorded.means.outputs}[name].tobytes()


def test_units_of_the_files_are_kept(tmp_path: Path) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    again = read_experiment(write_experiment(recorded, tmp_path / "again"), MODEL)
    assert (again.signals, again.nominal) == (recorded.signals, recorded.nominal)
    for before, after in zip(recorded.trials, again.trials, strict=True):
        assert after.inputs["slip_velocity"] == pytest.approx(before.inputs["slip_velocity"], rel=4e-16)  # to mm/s and back: two roundings
    assert "2.5" in (tmp_path / "again" / "trials" / "c1_a.csv").read_text()


def test_the_same_experiment_is_the_same_bytes(tmp_path: Path) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    for suffix in (".csv", ".parquet"):
        for name in ("one", "two"):
            write_experiment(recorded, tmp_path / f"{name}{suffix}", suffix=suffix)
        files = [sorted(path for path in (tmp_path / f"{name}{suffix}").rglob("*") if path.is_file()) for name in ("one", "two")]
        assert [path.read_bytes() for path in files[0]] == [path.read_bytes() for path in files[1]]
        assert len(files[0]) == 4


def test_measurements_are_not_overwritten(tmp_path: Path) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    before = (tmp_path / "rig" / "experiment.toml").read_bytes()
    (tmp_path / "file").write_text("")
    (tmp_path / "empty").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "empty")
    for name in ("rig", "file", "link"):
        with pytest.raises(ExperimentError, match="not overwritten; name a new folder"):
            write_experiment(recorded, tmp_path / name)
    assert (tmp_path / "rig" / "experiment.toml").read_bytes() == before
    assert read_experiment(write_experiment(recorded, tmp_path / "empty"), MODEL).conditions == ("c1", "c2")


def test_a_folder_appears_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    real, calls = experiment_writer.write_columns, []

    def full_disk(columns: dict[str, np.ndarray], path: Path) -> Path:
        calls.append(path)
        if len(calls) == 3:
            raise OSError(28, "No space left on device")
        return real(columns, path)

    def cut_off(*paths: Path) -> None:
        raise OSError(5, "Input/output error")

    for name, stand_in in (("write_columns", full_disk), ("os", SimpleNamespace(replace=cut_off))):
        with monkeypatch.context() as patched:
            patched.setattr(experiment_writer, name, stand_in)
            with pytest.raises(OutputError, match=r"No space left on device|Input/output error"):
                write_experiment(recorded, tmp_path / "new")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rig"]


@pytest.mark.parametrize("file", ["../out.csv", "/tmp/out.csv", "a\\b.csv", "trials/c1_a.csv"])
def test_names_that_lead_out_or_clash_are_not_written(tmp_path: Path, file: str) -> None:
    recorded = read_experiment(folder(tmp_path / "rig"), MODEL)
    trials = (recorded.trials[0], dataclasses.replace(recorded.trials[1], file=file))
    with pytest.raises(ExperimentError, match=r"inside the experiment's folder|two files of the name"):
        write_experiment(dataclasses.replace(recorded, trials=trials), tmp_path / "new")
    with pytest.raises(ExperimentError, match=r"written as \.csv or \.parquet"):
        write_experiment(recorded, tmp_path / "new", suffix=".xlsx")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rig"]


def test_suspicious_but_legal_data_are_read(tmp_path: Path) -> None:
    """All-zero force and saturation are judged by those who know what was to be expected, not here."""
    data = "t [ms],v,F\n" + "".join(f"{k},0,0\n" for k in range(50))
    recorded = read_experiment(folder(tmp_path / "rig", data=data), MODEL)
    assert math.fsum(recorded.trials[0].outputs["friction_force"]) == 0


def test_what_was_typed_in_mm_s_is_shown_in_mm_s(tmp_path: Path) -> None:
    """By the table of `evat experiment check` and on the axes of the picture; a value of the model as the component shows it."""
    shown = CliRunner().invoke(app, ["experiment", "check", str(folder(tmp_path / "rig"))], env={"COLUMNS": "250"}).output
    assert " 3 mm/s " in shown
    assert "m/min" not in shown.partition("nominal model")[0]
    experiment = read_experiment(tmp_path / "rig", MODEL)
    as_it_is, typed = kernel.variable("slip_velocity"), as_typed(kernel.variable("slip_velocity"), experiment.signals)
    assert in_display_unit(typed, np.array([0.003])) == (pytest.approx([3.0]), "slip velocity [mm/s]")
    assert in_display_unit("slip_velocity", np.array([0.003]))[1] == "slip velocity [m/min]"
    own = experiment.signals["slip_velocity"]
    turned, scaled = dataclasses.replace(own, sign=-1), dataclasses.replace(own, scale=2.0)
    moved, angle = (dataclasses.replace(own, unit=unit, of="position", radius=radius) for unit, radius in (("um", None), ("deg", 0.02)))
    for signal, unit in ((turned, "mm/s"), (scaled, "m/min"), (moved, "um/s"), (angle, "mm/s")):
        for name in ("slip_velocity", "v_s"):  # what is recorded, and what is of its kind
            assert as_typed(kernel.variable(name), {"slip_velocity": signal}).display_unit == unit
    assert as_typed(as_it_is, {"slip_velocity": scaled}) is as_it_is


def test_check_says_how_well_all_is_known_and_how_often_it_was_measured(tmp_path: Path) -> None:
    """A slip in [nominal.relative_sd] or [setup_sd], or a condition that was typed in two ways, passed unseen."""
    toml = TOML + "\n[setup_sd.friction_force]\ngain = 0.03\nzero = 0.5\nclock = 2\n"

    def shown(at: Path) -> str:
        return " ".join(CliRunner().invoke(app, ["experiment", "check", str(at)], env={"COLUMNS": "250"}).output.split())

    rig = shown(folder(tmp_path / "rig", toml))
    assert "2 conditions, 1 of them measured 2 times" in rig
    assert "values are known (standard deviation) to 20 %: F_C; to 10 %: " in rig
    vague = shown(folder(tmp_path / "vague", toml.replace("F_C = 0.2", "F_C = 12.5")))
    assert "values are known (standard deviation) to 1250 %: F_C; to 10 %: " in vague
    assert "bristles begin free, bent anyhow; " in vague
    assert "set-up is known (standard deviation) of friction_force to: gain 3 %, zero 0.5 N, clock 0.002 s" in rig
    table = shown(means_folder(tmp_path / "means"))
    assert "none of them repeated" in table
    assert "of mean_principal_force, mean_feed_force to: gain 1 %, zero 1 % of the rms data" in table


def test_conditions_of_a_table_that_have_no_name_are_not_told_twice(tmp_path: Path) -> None:
    """Their names were what varied, wrapped in mid-number, beside the columns of what varied."""
    plain = CliRunner().invoke(app, ["experiment", "check", str(means_folder(tmp_path / "plain"))], env={"COLUMNS": "80"}).output
    assert "cutting_speed=" not in plain
    assert "mean principal force ┃" in plain
    named = (
        MEANS.replace("cutting_speed [m/min]", "condition,cutting_speed [m/min]")
        .replace("\n6,", "\nslow,6,")
        .replace("\n12,", "\nfast,12,")
    )
    shown = (
        CliRunner().invoke(app, ["experiment", "check", str(means_folder(tmp_path / "named", data=named))], env={"COLUMNS": "120"}).output
    )
    assert "│ slow " in shown
    assert "┃ condition" in shown


def test_check_prints_names_whole_in_80_columns(tmp_path: Path) -> None:
    """Four files were `trace_00…`."""
    rig = folder(tmp_path / "rig")
    shown = CliRunner().invoke(app, ["experiment", "check", str(rig)], env={"COLUMNS": "80"}).output
    assert "…" not in shown
    assert all(f"│ {name} │" in " ".join(shown.split()) for name in ("trials/c1_a.csv", "trials/c2_a.csv"))
    assert max(map(len, shown.splitlines()[:-1])) <= 80
