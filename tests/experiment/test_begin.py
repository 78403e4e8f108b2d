"""Does a folder of data files become an experiment, whatever laboratories call their columns, and is every guess marked as one?"""

from __future__ import annotations

import contextlib
import datetime
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import typed
from evat.commands import begin as command
from evat.experiment import Experiment, ExperimentError
from evat.experiment.begin.guess import begin
from evat.experiment.begin.names import named
from evat.experiment.begin.understood import Answers, Begun
from evat.experiment.begin.words import meant
from evat.experiment.begin.write import Believed, to_look_at, write_begun
from evat.experiment.read import read_experiment
from evat.files.sniff import encoding_of, sniff
from evat.files.table import write_columns
from evat.files.text import RecordError, TextForm
from evat.model import EvatError
from evat.models.contact import ContactModel
from evat.plots import experiment as drawing
from evat.plots import experiment_page
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from numpy.typing import NDArray

MODEL = ContactModel()
TIMES = np.arange(200) / 100
SPEED = 0.1 * np.sin(2 * np.pi * TIMES)
FORCE = 5 * np.tanh(SPEED / 0.001)


def table(path: Path, headers: str, columns: list[NDArray[np.float64]], delimiter: str = ",", above: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = (delimiter.join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([*([above] if above else []), headers, *rows]) + "\n", encoding="utf-8")
    return path


def understood(folder: Path, answers: Answers | None = None) -> Begun:
    begun, questions = begin(folder, answers or Answers())
    assert begun is not None, questions
    return begun


@pytest.mark.parametrize(
    ("header", "kind", "unit"),
    [
        ("Zeit_ms", "time", "ms"),
        ("t [s]", "time", "s"),
        ("temps (s)", "time", "s"),
        ("tiempo / s", "time", "s"),
        ("Время, с", "time", "s"),
        ("Timestamp", "time", ""),
        ("Gleitgeschw. in mm/s", "velocity", "mm/s"),
        ("vitesse [m/min]", "velocity", "m/min"),
        ("belt_speed_mm_per_s", "velocity", "mm/s"),
        ("Drehzahl [1/min]", "velocity", "rpm"),
        ("n (U/min)", "velocity", "rpm"),
        ("速度 [mm/s]", "velocity", "mm/s"),
        ("Weg_µm", "position", "um"),
        ("Encoder angle [°]", "position", "deg"),
        ("déplacement (mm)", "position", "mm"),
        ("F / N", "force", "N"),
        ("Kraft [N]", "force", "N"),
        ("Kraft [V]", "force", "V"),
        ("Reibkraft", "force", ""),
        ("force de frottement (N)", "force", "N"),
        ("Fuerza_N", "force", "N"),
        ("effort tangentiel (N)", "force", "N"),
        ("effort normal (N)", "normal_load", "N"),
        ("FRICTION FORCE(N)", "force", "N"),
        ("Normalkraft [N]", "normal_load", "N"),
        ("F_N [N]", "normal_load", "N"),
        ("Fn (N)", "normal_load", "N"),
        ("Schnittkraft Fc [N]", "principal_force", "N"),
        ("Vorschubkraft [N]", "feed_force", "N"),
        ("Motorstrom [A]", "current", "A"),
        ("iq_A", "current", "A"),
        ("Drehmoment [Nm]", "torque", "N.m"),
        ("Temperatur [°C]", "temperature", "degC"),
        ("v_s", "velocity", ""),
        ("CH 3", "", ""),
        ("Reibwert [-]", "coefficient", "1"),
        ("coefficient de frottement", "coefficient", ""),
        ("Fz_N", "force", "N"),
        ("fz_mm", "feed", "mm"),
        ("すべり速度(mm/s)", "velocity", "mm/s"),
        ("垂直荷重(N)", "normal_load", "N"),
        ("Axialkraft [N]", "normal_load", "N"),
        ("X_Value", "time", ""),
    ],
)
def test_a_header_is_understood(header: str, kind: str, unit: str) -> None:
    told = meant(header)
    assert (told.kind, told.unit) == (kind, unit)


@pytest.mark.parametrize(
    ("files", "conditions"),
    [
        (["run_50N_rep1.csv", "run_50N_rep2.csv", "run_80N_rep1.csv"], ["50N", "50N", "80N"]),
        (["slow_01.txt", "slow_02.txt", "fast_01.txt"], ["slow", "slow", "fast"]),
        (["Versuch 20mms Nr1.csv", "Versuch 20mms Nr2.csv", "Versuch 40mms Nr1.csv"], ["20mms", "20mms", "40mms"]),
        (["a/1.csv", "a/2.csv", "b/1.csv", "b/2.csv"], ["a", "a", "b", "b"]),
        (["m (1).csv", "m (2).csv", "k (1).csv"], ["m", "m", "k"]),
        (["test1.csv", "test2.csv"], ["test1", "test2"]),
        (["only.csv"], ["only"]),
    ],
)
def test_repeats_are_told_by_the_names_of_files(files: list[str], conditions: list[str]) -> None:
    told, _ = named(files)
    assert [told[file].condition for file in files] == conditions


def test_a_name_tells_what_a_cut_was_made_at() -> None:
    told, _ = named(["essai v50 rep 1.txt", "essai v50 rep 2.txt"])
    assert {each.condition for each in told.values()} == {"essai_v50"}
    told, _ = named(["al_vc120_f0.1_rep1.csv", "al_vc120_f0.1_rep2.csv", "al_vc60_f0p2_rep1.csv"])
    assert set(told["al_vc60_f0p2_rep1.csv"].values) == {("cutting_speed", 60.0, "m/min"), ("feed", 0.2, "mm")}


@pytest.mark.parametrize(
    ("text", "form"),
    [
        ("t;v\n0,5;1\n0,6;2\n", TextForm(";", ",")),
        ("t,v\n0.5,1\n0.6,2\n", TextForm(",", ".")),
        ("t\tv\n0,5\t1\n0,6\t2\n", TextForm("\t", ",")),
        ("a\nb\n\nt v\ns m/s\n0.5 1\n0.6 2\n", TextForm(" ", ".", skip_rows=3, rows_after_header=1)),
        ("Samples\t9\t9\nt\tv\tF\tnote\n" + 20 * "0.5\t1\t2\t\n", TextForm("\t", ".", skip_rows=1)),
        ("# t [s]  v [m/s]\n  0.5   1\n  0.6 -12.25\n", TextForm(" ", ".")),
        ("Messung 1;;\nt;v;F\n0,5;1;2\n0,6;2;2\n", TextForm(";", ",", skip_rows=1)),
    ],
)
def test_a_form_is_seen(tmp_path: Path, text: str, form: TextForm) -> None:
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    assert sniff(tmp_path / "a.csv").form == form


@pytest.mark.parametrize(
    "header",
    [
        "# time[s]   vel[mm/s]    force[N]",
        "t (s) v (mm/s) F (N)",
        "Zeit s   Gleitgeschwindigkeit mm/s   Kraft N",
        "t   speed   force\n(s) (mm/s) (N)",
    ],
)
def test_columns_set_apart_by_blanks_are_read(tmp_path: Path, header: str) -> None:
    rows = [f"{t:12.4f}{1e3 * v:14.5f} \t{f:12.5f}  " for t, v, f in zip(TIMES, SPEED, FORCE, strict=True)]
    (tmp_path / "a.dat").write_text("rig 2\n" + "\n".join([header, *rows]) + "\n\n", encoding="utf-8")
    write_begun(understood(tmp_path), Believed(), force=False)
    trial = read_experiment(tmp_path, MODEL).trials[0]
    np.testing.assert_allclose(trial.inputs["slip_velocity"], SPEED, atol=1e-8)
    np.testing.assert_allclose(trial.outputs["friction_force"], FORCE, atol=1e-5)
    (tmp_path / "a.dat").write_text("rig 2\n" + "\n".join([header, *rows, "3 4 five"]), encoding="utf-8")
    place = 203 + header.count("\n")
    with pytest.raises(ExperimentError, match=f"line {place}, column '.*': 'five' is no number"):
        read_experiment(tmp_path, MODEL)
    (tmp_path / "a.dat").write_text("rig 2\n" + "\n".join([header, *rows, "3 4"]), encoding="utf-8")
    with pytest.raises(ExperimentError, match=f"line {place}: 2 cells where the headers are 3"):
        read_experiment(tmp_path, MODEL)


@pytest.mark.parametrize(
    ("form", "header"),
    [
        ("%Y-%m-%dT%H:%M:%S.%f", "timestamp"),
        ("%d.%m.%Y %H:%M:%S.%fZ", "Zeit"),
        ("%I:%M:%S.%f %p", "Time of day"),
        ("%H:%M:%S.%f", "Aufnahme"),  # no word for time: the numbers tell
    ],
)
def test_a_clock_of_times_of_day_counts_seconds(tmp_path: Path, form: str, header: str) -> None:
    begin_at = datetime.datetime(2024, 5, 3, 23, 59, 59, 250_000)  # runs over midnight
    stamps = [(begin_at + datetime.timedelta(seconds=float(second))).strftime(form) for second in TIMES]
    rows = [f"{stamp},{1e3 * v:.5f},{f:.5f}" for stamp, v, f in zip(stamps, SPEED, FORCE, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join([f"{header},v [mm/s],F [N]", *rows]), encoding="utf-8")
    write_begun(understood(tmp_path), Believed(), force=False)
    np.testing.assert_allclose(read_experiment(tmp_path, MODEL).trials[0].times, TIMES, atol=1e-9)


@pytest.mark.parametrize(
    ("second", "said"),
    [
        ("2024-05-04 10:00:01", "row 2: '2024-05-04 10:00:01'; the date changes where the time of day runs over midnight"),
        ("later", "row 2: 'later' is no time of day; write it like 10:15:00.250"),
        ("2024-05-03 09:00:01", "row 2: the clock must increase"),
    ],
)
def test_a_clock_of_times_of_day_that_jumps_is_refused(tmp_path: Path, second: str, said: str) -> None:
    document = begun_stamps(tmp_path)
    rows = ["2024-05-03 10:00:00,1,1", f"{second},1,1", "2024-05-03 10:00:02,1,1"]
    (tmp_path / "a.csv").write_text("\n".join(["stamp,v [m/s],F [N]", *rows]), encoding="utf-8")
    with pytest.raises(ExperimentError, match=said):
        read_experiment(tmp_path, MODEL)
    document.write_text(document.read_text(encoding="utf-8").replace('unit = "s"', 'unit = "ms"', 1), encoding="utf-8")
    with pytest.raises(ExperimentError, match=r"reader.timestamp: 'stamp'; it must be signals.time.column, whose unit then is \"s\""):
        read_experiment(tmp_path, MODEL)


def begun_stamps(folder: Path) -> Path:
    rows = [f"2024-05-03 10:00:0{second},{second - 1},{second - 1}" for second in range(3)]
    (folder / "a.csv").write_text("\n".join(["stamp,v [m/s],F [N]", *rows]), encoding="utf-8")
    return write_begun(understood(folder), Believed(), force=False)


def test_encodings_are_told_by_the_lines_that_tell() -> None:
    digits = b"0,5;1\r\n" * 2000
    assert encoding_of("Gehäuse °C;Maß\r\n".encode("cp1252") + digits, "a") == "cp1252"
    assert encoding_of("Gehäuse °C".encode() + digits, "a") == "utf-8"
    assert encoding_of("t;v".encode("utf-16"), "a") == "utf-16"
    russian = "Время;Скорость скольжения;Сила трения;Температура\r\n"
    assert russian.encode("cp1251").decode(encoding_of(russian.encode("cp1251") + digits, "a")) == russian


@pytest.mark.parametrize(
    ("encoding", "headers"),
    [
        ("cp1252", "Temps (s);Système;Effort à vérifier (N)"),
        ("cp1252", "Tempo [s];Velocità [mm/s];Forza [N]"),
        ("cp1252", "Tempo;Posição;Força de fricção"),
        ("cp1252", "Tid;Kraft på verktøy"),
        ("cp1252", "Größe;Kräfte in m³/µm;Zählung °C"),
        ("cp1250", "Čas;Rychlost;Třecí síla"),
        ("cp1250", "Czas;Prędkość;Siła tarcia"),
        ("cp1250", "Siła"),
        ("cp1250", "Idő;Súrlódási erő"),
        ("cp932", "時間;速度;摩擦力;変位"),
    ],
)
def test_an_encoding_is_told_by_the_letters_of_a_language(encoding: str, headers: str) -> None:
    """French, Italian, Portuguese and Norwegian were read as cp1250 (Systčme), Polish as Chinese."""
    told = encoding_of(headers.encode(encoding) + b"\r\n0,5;1\r\n", "a")
    assert headers.encode(encoding).decode(told) == headers


def test_an_empty_file_is_left_aside_as_that(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, FORCE])
    (tmp_path / "b.csv").write_bytes(b"")
    assert understood(tmp_path).recorded.aside == ("b.csv: the file is empty.",)


def test_what_runs_against_the_motion_is_turned(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, -FORCE])
    begun = understood(tmp_path)
    assert {signal.name: signal.table.get("sign") for signal in begun.signals}["friction_force"] == -1
    assert any("runs against the motion" in sentence for sentence in begun.look)
    write_begun(begun, Believed(), force=False)
    trial = read_experiment(tmp_path, MODEL).trials[0]
    assert float(trial.inputs["slip_velocity"] @ trial.outputs["friction_force"]) > 0


def test_a_sample_that_is_missing_says_nothing_of_the_direction(tmp_path: Path) -> None:
    """A correlation that is no number was told as one that is small."""
    table(tmp_path / "a.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, np.where(np.arange(FORCE.size) == 7, np.nan, FORCE)])
    assert not any("hardly follows" in sentence for sentence in understood(tmp_path).look)


def test_a_clock_without_a_unit_is_read_off_its_steps(tmp_path: Path) -> None:
    for name, factor, unit in (("s", 1.0, "s"), ("ms", 1e3, "ms")):
        table(tmp_path / name / "a.csv", "time,v [m/s],F [N]", [TIMES * factor, SPEED, FORCE])
        begun = understood(tmp_path / name)
        clock = next(signal for signal in begun.signals if signal.name == "time")
        assert clock.table["unit"] == unit
        assert "the header states none" in clock.why


def test_recordings_alike_repeat_each_other_where_names_do_not_tell(tmp_path: Path) -> None:
    for name, share in (("test1", 1.0), ("test2", 1.001), ("test3", 3.0), ("test4", 3.003)):
        table(tmp_path / f"{name}.csv", "t [s],v [m/s],F [N]", [TIMES, share * SPEED, FORCE])
    begun = understood(tmp_path)
    assert [trial.condition for trial in begun.trials] == ["test1", "test1", "test3", "test3"]
    assert "repeat each other" in begun.repeats
    path = write_begun(begun, Believed(values={"friction_law": "coulomb", "F_C": 5.0}), force=False)
    text = path.read_text(encoding="utf-8")
    assert text.count('condition = "test1"  # guessed: recordings as long') == 2
    assert 'friction = "coulomb"\n' in text
    assert "F_S" not in text


def test_recordings_at_another_load_are_no_repeats(tmp_path: Path) -> None:
    for name, load in (("a", 50.0), ("b", 50.9), ("c", 100.0)):
        table(tmp_path / f"{name}.csv", "t [s],v [m/s],F [N],normal load [N]", [TIMES, SPEED, FORCE * load / 50, load + 0 * TIMES])
    begun = understood(tmp_path)
    assert [trial.condition for trial in begun.trials] == ["a", "a", "c"]
    assert "at as high a load" in begun.repeats
    assert any("normal_load is recorded, and friction_law = lugre" in said for said in to_look_at(begun, Believed()))
    assert not any("normal_load" in said for said in to_look_at(begun, Believed(friction="amontons")))


def test_turns_a_minute_and_a_torque_are_read_at_a_radius(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t [s],Drehzahl [1/min],Drehmoment [Nm]", [TIMES, 60 * SPEED, FORCE])
    begun, questions = begin(tmp_path, Answers())
    assert begun is None
    assert [question.option for question in questions] == ["--radius '20 mm'"]
    write_begun(understood(tmp_path, Answers(radius=0.5)), Believed(), force=False)
    trial = read_experiment(tmp_path, MODEL).trials[0]
    np.testing.assert_allclose(trial.inputs["slip_velocity"], 2 * np.pi * SPEED * 0.5, atol=1e-7)
    np.testing.assert_allclose(trial.outputs["friction_force"], FORCE / 0.5, atol=1e-5)


def test_an_angle_that_begins_anew_at_each_turn_turns_no_sign(tmp_path: Path) -> None:
    """Its jumps were the fastest motion of all, against which the torque ran."""
    times = np.arange(4000) * 1e-3
    speed = 20 * np.sin(np.pi * times)
    angle = np.degrees(np.mod(np.cumsum(speed) * 1e-3, 2 * np.pi))
    table(tmp_path / "a.csv", "t [s],angle [deg],torque [Nm]", [times, angle, 0.4 * np.tanh(speed)])
    begun = understood(tmp_path, Answers(radius=0.02))
    assert "sign" not in {signal.name: signal.table for signal in begun.signals}["friction_force"]
    write_begun(begun, Believed(), force=False)
    trial = read_experiment(tmp_path, MODEL).trials[0]
    assert np.corrcoef(np.sign(trial.inputs["slip_velocity"]), trial.outputs["friction_force"])[0, 1] > 0.9


@pytest.mark.parametrize(
    ("unit", "number", "given", "scale"), [("A", 52.0, "N/A", 52.0), ("mA", 0.5, "N.m/A", 25.0), ("V", 8.0, "N/V", 8.0)]
)
def test_a_motor_constant_becomes_a_scale(tmp_path: Path, unit: str, number: float, given: str, scale: float) -> None:
    table(tmp_path / "a.csv", f"t [s],v [m/s],CH1 [{unit}]", [TIMES, SPEED, FORCE])
    answers = Answers({"friction_force": f"CH1 [{unit}]"}, radius=0.02, motor_constant=(number, given))
    force = next(signal for signal in understood(tmp_path, answers).signals if signal.name == "friction_force")
    assert force.table["scale"] == pytest.approx(scale)


def test_a_torque_by_its_name_comes_before_a_force_by_its_unit(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t [s],speed [mm/s],Torque [N.mm],ch2 [N]", [TIMES, 1e3 * SPEED, 20 * FORCE, 50 + 0 * TIMES])
    signals = {signal.name: signal.table for signal in understood(tmp_path, Answers(radius=0.02)).signals}
    assert (signals["friction_force"]["column"], signals["friction_force"]["radius"]) == ("Torque [N.mm]", 0.02)


@pytest.mark.parametrize(("load", "answers"), [(0.05 + 0 * TIMES, Answers()), (0.05 + 0.02 * TIMES, Answers(motor_constant=(50.0, "N")))])
def test_a_friction_coefficient_is_scaled_by_the_load(tmp_path: Path, load: NDArray[np.float64], answers: Answers) -> None:
    table(tmp_path / "a.csv", "t [s],speed [mm/s],CoF,Load [kN]", [TIMES, 1e3 * SPEED, FORCE / 50, load])
    begun = understood(tmp_path, answers)
    write_begun(begun, Believed(), force=False)
    np.testing.assert_allclose(read_experiment(tmp_path, MODEL).trials[0].outputs["friction_force"], FORCE, atol=1e-5)
    if answers.motor_constant is None:
        assert any("times the load of 50 N" in sentence for sentence in begun.look)


def test_a_friction_coefficient_under_a_changing_load_is_no_force(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t [s],speed [mm/s],CoF,Load [N]", [TIMES, 1e3 * SPEED, FORCE / 50, 50 + 20 * TIMES])
    with pytest.raises(ExperimentError, match=r"'Load \[N\]' goes from 50 to 89.8 N"):
        begin(tmp_path, Answers())
    table(tmp_path / "a.csv", "t [s],speed [mm/s],CoF", [TIMES, 1e3 * SPEED, FORCE / 50])
    assert begin(tmp_path, Answers())[1][0].asked == "'CoF' is a friction coefficient; at which normal load?"


def test_a_folder_with_nothing_to_read_says_what_it_holds(tmp_path: Path) -> None:
    (tmp_path / "run.tdms").write_bytes(b"TDSm")
    with pytest.raises(ExperimentError, match=r"it holds 'run.tdms'. Export"):
        begin(tmp_path, Answers())


def test_what_was_measured_is_taken_and_not_what_was_commanded(tmp_path: Path) -> None:
    table(
        tmp_path / "a.csv", "Zeit[s];v_soll[mm/s];v_ist[mm/s];F_R[N];F_N[N];mu[-]", [TIMES, SPEED, SPEED, FORCE, 0 * TIMES + 10, FORCE], ";"
    )
    begun = understood(tmp_path)
    columns = {signal.name: signal.table["column"] for signal in begun.signals}
    assert columns == {"time": "Zeit[s]", "slip_velocity": "v_ist[mm/s]", "friction_force": "F_R[N]", "normal_load": "F_N[N]"}
    assert begun.left == ("column 'v_soll[mm/s]'", "column 'mu[-]'")


def test_a_trace_of_a_controller_is_read_with_one_option(tmp_path: Path) -> None:
    """Actual and nominal position, the motor's current, the feed and the run in the names; two columns were asked about, and conditions
    were called F12000_Lauf1 for both runs."""
    for feed, size in ((3000, 1.0), (12000, 4.0)):
        for run in (1, 2):
            position = size * np.cumsum(SPEED) * (TIMES[1] - TIMES[0])
            columns = [1e3 * TIMES, 1e3 * position, 1e3 * position + 1e-3, FORCE / 50]
            table(tmp_path / f"X-Achse_F{feed}_Lauf{run}.txt", "t_ms\ts_act_mm\ts_nom_mm\tI_act_A", columns, "\t")
    begun, questions = begin(tmp_path, Answers())
    assert begun is None
    assert [question.option.split()[0] for question in questions] == ["--motor-constant"]
    known = Answers(motor_constant=(50.0, "N/A"))
    begun = understood(tmp_path, known)
    assert [trial.condition for trial in begun.trials] == ["F12000", "F12000", "F3000", "F3000"]
    assert begun.left == ("column 's_nom_mm'",)
    # No data tell it, and it may be 15 times off: a diagnosis calls up to 4 standard deviations credible, and has to of our own guess.
    assert np.log(15) < 4 * begun.values["sigma0"][1]
    for path in tmp_path.glob("*Lauf*"):
        path.rename(path.with_name(path.name.replace("_Lauf", "_gang")))  # a word that is not known: by their likeness
    assert [trial.condition for trial in understood(tmp_path, known).trials] == ["F12000", "F12000", "F3000", "F3000"]


def test_three_forces_of_a_dynamometer_are_asked_about(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "Time,Fx,Fy,Fz,v\ns,N,N,N,m/s", [TIMES, FORCE, 0 * TIMES, 0 * TIMES + 20, SPEED])
    begun, questions = begin(tmp_path, Answers())
    assert begun is None
    assert [(question.option, question.choices) for question in questions] == [("--signal friction_force=COLUMN", ("Fx", "Fy", "Fz"))]


def test_a_long_record_is_drawn_whole_with_its_peaks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """30 000 samples, of which the last tenth of a second alone is loaded, with one peak: the picture ended after 20 000."""
    times = np.arange(30_000) * 1e-3
    force = np.where(times > 29.9, 5.0, 0.01 * np.sin(times))
    force[29_950] = 50.0
    columns = np.column_stack([times, 0.1 * np.sin(times), force])
    np.savetxt(tmp_path / "a.csv", columns, delimiter=",", header="t [s],v [m/s],F [N]", comments="", fmt="%.6g")
    shown, left = list[Figure](), list[str]()

    def keeping(experiment: Experiment, narrow: bool = False, left_out: str = "") -> Figure:
        shown.append(drawing.drawn(experiment, narrow, left_out))
        left.append(left_out)
        return shown[-1]

    monkeypatch.setattr(experiment_page, "drawn", keeping)
    assert typed("experiment", "init", str(tmp_path))[0] == 0
    over_time = next(each for each in shown[0].axes if each.get_xlabel().startswith("time") and "force" in each.get_ylabel())
    x, y = (np.asarray(data, dtype=float) for data in over_time.lines[0].get_data())
    assert x[-1] == pytest.approx(29.999)
    assert y.max() == 50.0
    assert x.size <= drawing.MOST_POINTS + 2
    assert left[0] == ""
    monkeypatch.setattr(command, "MOST_SAMPLES", 10_000)
    assert typed("experiment", "init", str(tmp_path), "--force")[0] == 0
    assert left[-1] == "the first 10000 samples of each recording; a.csv has 30000"
    assert left[-1] in shown[-1].get_suptitle()


def test_averages_become_means_and_remarks_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "means.csv"
    path.write_text(
        "vc [m/min];f [mm];Fc [N];Ff [N];Werkstoff\n60;0,1;120,5;80,1;Cu\n120;0,1;110,2;71;Cu\n180;0,1;101;66,4;Cu\n", encoding="utf-8"
    )
    begun = understood(tmp_path)
    write_begun(begun, Believed(), force=False)
    assert any("does not vibrate has amplitudes of 0" in said for said in to_look_at(begun, Believed()))
    made = read_experiment(tmp_path, MODEL)
    assert {name: made.nominal.values[name] for name in ("amplitude_x", "amplitude_y", "rake_angle")} == {
        "amplitude_x": 5e-6, "amplitude_y": 5e-6, "rake_angle": 0.0
    }  # fmt: skip
    means = made.means
    assert means is not None
    np.testing.assert_allclose(means.values["cutting_speed"], [1.0, 2.0, 3.0])
    np.testing.assert_allclose(means.values["feed"], 1e-4)
    np.testing.assert_array_equal(means.outputs["mean_principal_force"], [120.5, 110.2, 101.0])
    np.testing.assert_array_equal(means.outputs["mean_feed_force"], [80.1, 71.0, 66.4])


def test_a_cut_runs_along_its_own_path(tmp_path: Path) -> None:
    for name in ("al_vc60_rep1", "al_vc60_rep2", "al_vc120_rep1"):
        table(tmp_path / f"{name}.csv", "Time;Fx;Fc;Ff\ns;N;N;N", [TIMES, 0 * TIMES, 100 + FORCE, 60 + FORCE], ";")
    write_begun(understood(tmp_path), Believed(), force=False)
    experiment = read_experiment(tmp_path, MODEL)
    assert experiment.nominal.values["kinematics"] == "internal"
    assert experiment.outputs == ("principal_force", "feed_force")
    assert [trial.values["cutting_speed"] for trial in experiment.trials] == [2.0, 1.0, 1.0]
    assert experiment.conditions == ("vc120", "vc60")


def test_parquet_is_taken_too(tmp_path: Path) -> None:
    write_columns({"t [s]": TIMES, "v [m/s]": SPEED, "F [N]": FORCE}, tmp_path / "a.parquet")
    write_begun(understood(tmp_path), Believed(), force=False)
    np.testing.assert_array_equal(read_experiment(tmp_path, MODEL).trials[0].outputs["friction_force"], FORCE)


def test_without_a_terminal_the_missing_options_are_named(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "CH1,CH2,CH3", [TIMES, SPEED, FORCE])
    status, _, complaint = typed("experiment", "init", str(tmp_path))
    assert status == 2
    assert "--signal time=COLUMN" in complaint
    status, _, complaint = typed(
        "experiment", "init", str(tmp_path), *(f"--signal={name}" for name in ("time=CH1", "slip_velocity=CH2", "friction_force=CH3"))
    )
    assert status == 2
    assert "--unit 'CH2=UNIT'" in complaint
    assert not (tmp_path / "experiment.toml").exists()


def test_in_a_terminal_it_asks_until_it_knows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table(tmp_path / "a.csv", "CH1,CH2,CH3", [TIMES, SPEED, FORCE])
    told = iter(["9", "1", "CH2", "CH3", "furlong/", "mm/s"])
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(command.typer, "prompt", lambda *_, **__: next(told))
    status, printed, complaint = typed("experiment", "init", str(tmp_path))
    assert status in (0, None), complaint
    assert next(told, None) is None
    assert "evat experiment check" in printed
    np.testing.assert_allclose(read_experiment(tmp_path, MODEL).trials[0].inputs["slip_velocity"], SPEED / 1000, atol=1e-9)
    assert (tmp_path / "experiment.png").stat().st_size > 10_000
    signals = [f"--signal={name}={column}" for name, column in (("slip_velocity", "CH2"), ("time", "CH1"), ("friction_force", "CH3"))]
    status, printed, complaint = typed("experiment", "init", str(tmp_path), "--force", "--json", "--unit=CH2=mm/s", *signals)
    assert status in (0, None), complaint
    assert json.loads(printed)["signals"]["slip_velocity"]["unit"] == "mm/s"
    assert "mm/s</td>" in (tmp_path / "experiment.html").read_text(encoding="utf-8")


def test_headers_that_no_file_has_are_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bare(tmp_path / "a.csv")
    told = iter(["t", "t [s], v [mm/s], F [N]"])  # the first names one column
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(command.typer, "prompt", lambda *_, **__: next(told))
    status, _, complaint = typed("experiment", "init", str(tmp_path))
    assert status in (0, None), complaint
    assert "two headers or more are needed" in complaint
    assert next(told, None) is None
    np.testing.assert_allclose(read_experiment(tmp_path, MODEL).trials[0].inputs["slip_velocity"], SPEED, atol=1e-8)


def test_a_document_that_is_there_is_not_replaced(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, FORCE])
    (tmp_path / "experiment.toml").write_text("mine", encoding="utf-8")
    status, _, complaint = typed("experiment", "init", str(tmp_path))
    assert status == 2
    assert "--force" in complaint
    assert (tmp_path / "experiment.toml").read_text(encoding="utf-8") == "mine"
    assert typed("experiment", "init", str(tmp_path), "--force")[0] in (0, None)
    assert "# guessed:" in (tmp_path / "experiment.toml").read_text(encoding="utf-8")


def test_what_is_no_recording_is_refused_or_left_aside(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match="the folder is empty"):
        begin(tmp_path, Answers())
    (tmp_path / "dump.dat").write_bytes(bytes(range(256)) * 100)
    (tmp_path / "line.txt").write_text("1;2;" * 100_000, encoding="utf-8")
    (tmp_path / "bare.csv").write_text("1,2,3\n2,3,4\n3,4,5\n", encoding="utf-8")
    with pytest.raises(ExperimentError) as error:
        begin(tmp_path, Answers())
    for said in (
        "dump.dat: it holds bytes that no text has",
        "line.txt: a line of more than",
        "bare.csv: line 1 is the first of 3 numbers",
    ):
        assert said in str(error.value)
    (tmp_path / "in").mkdir()
    table(tmp_path / "in" / "a.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, FORCE])
    outside = table(tmp_path / "b.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, FORCE])
    (tmp_path / "in" / "link.csv").symlink_to(outside)
    begun = understood(tmp_path / "in")
    assert [trial.file for trial in begun.trials] == ["a.csv"]
    assert any("leads out of the folder" in reason for reason in begun.left)


def test_a_line_of_garbage_is_named(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", "t [s],v [m/s],F [N]", [TIMES, SPEED, FORCE])
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[100] = "1.0,overflow,3"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(ExperimentError, match=r"line 101, column 'v \[m/s\]': 'overflow' is no number"):
        begin(tmp_path, Answers())


def test_headers_are_text_in_the_document_whatever_stands_in_them(tmp_path: Path) -> None:
    """Quotes, an escape sequence and what looks like TOML."""
    hostile = 't [s],"v ""]\\n[x" [m/s],F\x1b[31m [N],note # = "a"'
    table(tmp_path / "a.csv", hostile, [TIMES, SPEED, FORCE, TIMES])
    path = write_begun(understood(tmp_path), Believed(title='a "b"\n[nominal]'), force=False)
    assert "\x1b" not in path.read_text(encoding="utf-8")
    assert read_experiment(tmp_path, MODEL).trials[0].times.size == TIMES.size


def test_files_written_differently_are_told_apart(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t,v,F", [TIMES, SPEED, FORCE])
    table(tmp_path / "b.csv", "t;v;F", [TIMES, SPEED, FORCE], ";")
    with pytest.raises(ExperimentError, match="are written differently") as error:
        begin(tmp_path, Answers())
    assert "a.csv" in str(error.value)
    with pytest.raises(RecordError, match="no rows of numbers"):
        sniff(tmp_path / "a.csv", TextForm(delimiter="|"), ["delimiter"])


def bare(path: Path, delimiter: str = ";") -> Path:
    """A recording that begins with numbers."""
    table(path, "", [TIMES, 1e3 * SPEED, FORCE], delimiter)
    path.write_text(path.read_text(encoding="utf-8").lstrip("\n"), encoding="utf-8")
    return path


def test_headers_of_one_file_are_taken_over_where_the_next_have_none(tmp_path: Path) -> None:
    """And said to be a guess; the reader goes by them."""
    table(tmp_path / "a.csv", "t;v [mm/s];F [N]", [TIMES, 1e3 * SPEED, FORCE], ";", "Rate;100\nbench 3")
    bare(tmp_path / "b.csv")
    begun = understood(tmp_path)
    text = write_begun(begun, Believed(), force=False).read_text(encoding="utf-8")
    assert 'columns = ["t", "v [mm/s]", "F [N]"]  # guessed: the headers of a.csv, for b.csv, which has none\n' in text
    assert to_look_at(begun, Believed())[0].startswith("columns go by the headers of a.csv, for b.csv")
    trials = read_experiment(tmp_path, MODEL).trials
    assert [trial.file for trial in trials] == ["a.csv", "b.csv"]
    for trial in trials:
        np.testing.assert_allclose(trial.inputs["slip_velocity"], SPEED, atol=1e-8)
    assert "2 trials of 400 rows in all; 1 condition, measured 2 times\n" in typed("experiment", "check", str(tmp_path))[1]


def test_a_table_that_is_no_recording_does_not_become_one(tmp_path: Path) -> None:
    """As many columns as the recordings, no headers, and no clock: what somebody noted beside them."""
    table(tmp_path / "a.csv", "t;v [mm/s];F [N]", [TIMES, 1e3 * SPEED, FORCE], ";")
    bare(tmp_path / "b.csv")
    (tmp_path / "loads.csv").write_text("50;1;2\n80;3;4\n50;5;6\n", encoding="utf-8")
    (tmp_path / "weights.csv").write_text("100;1;2\n200;3;4\n300;5;6\n", encoding="utf-8")
    begun = understood(tmp_path)
    assert begun.recorded.files == ("a.csv", "b.csv")
    for name in ("loads.csv", "weights.csv"):
        assert f"{name}: it has no headers, and by those of a.csv its 't' is no such clock" in begun.left
    (tmp_path / "b.csv").unlink()
    assert understood(tmp_path).recorded.sniffed.form.columns == ()


def test_headers_that_could_be_of_either_file_are_asked_for(tmp_path: Path) -> None:
    table(tmp_path / "a.csv", "t;v [mm/s];F [N]", [TIMES, SPEED, FORCE], ";")
    table(tmp_path / "b.csv", "F;v;t", [FORCE, SPEED, TIMES], ";")
    bare(tmp_path / "c.csv")
    bare(tmp_path / "d.csv", ",")
    aside = " ".join(understood(tmp_path).left)
    assert "c.csv: line 1 is the first of 3 numbers, without headers; the headers of a.csv and b.csv are as many, and others. Add" in aside
    assert "d.csv: line 1 is the first of 3 numbers, without headers; no file like it has headers. Add a line of headers, or" in aside


@pytest.mark.parametrize("head", ["t;v [mm/s];F [N]", "bench 3\nt;v;F\ns;mm/s;N"])
def test_rows_may_end_with_a_delimiter_that_the_headers_lack(tmp_path: Path, head: str) -> None:
    rows = (f"{t:.4f};{1e3 * v:.5f};{f:.5f};" for t, v, f in zip(TIMES, SPEED, FORCE, strict=True))
    (tmp_path / "a.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    begun = understood(tmp_path)
    assert begun.recorded.bare == ()
    assert "guessed: the headers of" not in write_begun(begun, Believed(), force=False).read_text(encoding="utf-8")
    trial = read_experiment(tmp_path, MODEL).trials[0]
    np.testing.assert_allclose(trial.inputs["slip_velocity"], SPEED, atol=1e-8)
    assert trial.times.size == TIMES.size


def test_columns_are_named_where_no_file_has_headers(tmp_path: Path) -> None:
    for name in ("a_1.csv", "a_2.csv"):
        bare(tmp_path / name)
    status, _, complaints = typed("experiment", "init", str(tmp_path))
    assert status == 2
    assert "a_1.csv, a_2.csv: line 1 is the first of 3 numbers, without headers" in complaints
    assert "--columns" in complaints
    status, _, complaints = typed("experiment", "init", str(tmp_path), "--columns", "t [s], v [mm/s]")
    assert "2 columns are named; name all" in complaints
    status, _, complaints = typed("experiment", "init", str(tmp_path), "--columns", "t, t")
    assert "each once" in complaints
    status, printed, complaints = typed("experiment", "init", str(tmp_path), "--columns", "t [s], v [mm/s], F [N]")
    assert status == 0, complaints
    assert "columns go by" not in printed
    np.testing.assert_allclose(read_experiment(tmp_path, MODEL).trials[1].inputs["slip_velocity"], SPEED, atol=1e-8)


HEADERS = st.text(st.characters(codec="utf-8", exclude_characters="\r\n"), max_size=12) | st.sampled_from(
    ["t [s]", "v [mm/s]", "F [N]", "Fn (N)", "time", "", '"', "angle [deg]", "i [A]", "M [Nm]", "Fc [N]", "vc", "s", "trigger [V]"]
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    headers=st.lists(HEADERS, min_size=1, max_size=5),
    delimiter=st.sampled_from([";", ",", "\t", "|", " "]),
    decimal=st.sampled_from([".", ","]),
    above=st.text(max_size=30),
    garbage=st.sampled_from(["", "x", "1e999", "nan", "\0", '"', "1,2.3"]),
    encoding=st.sampled_from(["utf-8", "cp1252", "utf-16"]),
)
def test_whatever_lies_there_is_understood_or_refused_in_words(
    tmp_path: Path, headers: list[str], delimiter: str, decimal: str, above: str, garbage: str, encoding: str
) -> None:
    """No other exception than ours; and what is written is read, or refused by the reader in its own words."""
    rows = [[f"{row * 0.5 + column}".replace(".", decimal) for column in range(len(headers))] for row in range(6)]
    rows[3][-1] += garbage
    text = "\n".join([above, delimiter.join(headers), *(delimiter.join(row) for row in rows)])
    (tmp_path / "a.csv").write_bytes(text.encode(encoding, errors="replace"))
    (tmp_path / "experiment.toml").unlink(missing_ok=True)
    with contextlib.suppress(EvatError):
        begun, _ = begin(tmp_path, Answers(radius=0.1, motor_constant=(1.0, "N/A")))
        if begun is not None:
            write_begun(begun, Believed(), force=False)
            read_experiment(tmp_path, MODEL)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=400))
def test_any_bytes_are_refused_in_words(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.csv").write_bytes(data)
    with contextlib.suppress(EvatError):
        begin(tmp_path, Answers())
