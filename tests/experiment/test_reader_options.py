"""Are files read as they are written: decimal commas, other encodings, lines above the headers? And is a wrong line named?"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import ExperimentError
from evat.experiment.keys import TABLES, keys
from evat.experiment.read import read_experiment, scan_experiment
from evat.models.contact import ContactModel

MODEL = ContactModel()
HEAD = """
format = 1
title = "Rig"
[nominal]
friction = "coulomb"
kinematics = "external"
values = { F_C = 5.0 }
[signals.time]
column = "Zeit"
unit = "s"
[signals.slip_velocity]
column = "Geschw. Schlitten \u00fc"
unit = "mm/s"
role = "input"
[signals.friction_force]
column = "Kraft"
unit = "N"
role = "output"
[[trials]]
file = "a.csv"
condition = "1"
[reader]
"""
MESSY = "Pr\u00fcfstand 3;;;\r\nZeit;Geschw. Schlitten \u00fc;Kraft;Bemerkung\r\ns;mm/s;N;\r\n0,5;1000;3,25;kalt\r\n0,75;2e3;-4,5;\r\n"


def folder(tmp_path: Path, reader: str, data: bytes) -> Path:
    (tmp_path / "experiment.toml").write_text(HEAD + reader, encoding="utf-8")
    (tmp_path / "a.csv").write_bytes(data)
    return tmp_path


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig", "utf-16", "mac-roman"])
def test_numbers_come_in_as_they_are_meant(tmp_path: Path, encoding: str) -> None:
    reader = f'encoding = "{encoding}"\ndecimal = ","\ndelimiter = ";"\nskip_rows = 1\nrows_after_header = 1'
    trial = read_experiment(folder(tmp_path, reader, MESSY.encode(encoding)), MODEL).trials[0]
    np.testing.assert_array_equal(trial.times, [0.5, 0.75])
    np.testing.assert_array_equal(trial.inputs["slip_velocity"], [1.0, 2.0])
    np.testing.assert_array_equal(trial.outputs["friction_force"], [3.25, -4.5])
    assert scan_experiment(tmp_path, MODEL).trials[0].rows == 2


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32"])
def test_text_that_is_not_as_wide_as_is_said(tmp_path: Path, encoding: str) -> None:
    with pytest.raises(ExperimentError, match=rf"a.csv: this is no text in {encoding} \(.*\); see reader.encoding"):
        scan_experiment(folder(tmp_path, f'encoding = "{encoding}"', b"Zeit,Kraft\n0,1\n1,2\n"), MODEL)


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
@pytest.mark.parametrize("columns", ["", 'columns = ["Zeit", "Geschw. Schlitten \u00fc", "Kraft"]'])
def test_text_that_is_wider_than_is_said(tmp_path: Path, encoding: str, columns: str) -> None:
    place = folder(tmp_path, f'encoding = "{encoding}"\n{columns}', "Zeit,Kraft\n0,1\n1,2\n".encode("utf-16"))
    with pytest.raises(ExperimentError, match=r'a.csv: this is text in UTF-16, and .* write encoding = "utf-16" in \[reader\]'):
        scan_experiment(place, MODEL)


@pytest.mark.parametrize(
    ("units", "said"),
    [
        ("s;mm/s;kN;", "'Kraft': the line of units below its header states kN, the document says N"),
        ("ms;mm/s;N;", "'Zeit': .* states ms"),
        ("[s];[mm/s];[daN];", "states daN"),
        ("s;mm/s;V;", "states V"),
    ],
)
def test_a_line_of_units_that_says_another_is_refused(tmp_path: Path, units: str, said: str) -> None:
    """As brackets in a header are."""
    data = MESSY.replace("s;mm/s;N;", units, 1).encode("cp1252")
    at = folder(tmp_path, 'encoding = "cp1252"\ndecimal = ","\ndelimiter = ";"\nskip_rows = 1\nrows_after_header = 1', data)
    for read in (read_experiment, scan_experiment):
        with pytest.raises(ExperimentError, match=said):
            read(at, MODEL)


@pytest.mark.parametrize("units", ["[s];[mm/s];[N];", "sec;mm / s;Newton;-", "raw;raw;raw;text", ";;;", "s;;N;"])
def test_a_line_that_says_the_same_or_nothing_is_passed_over(tmp_path: Path, units: str) -> None:
    data = MESSY.replace("s;mm/s;N;", units, 1).encode("cp1252")
    at = folder(tmp_path, 'encoding = "cp1252"\ndecimal = ","\ndelimiter = ";"\nskip_rows = 1\nrows_after_header = 1', data)
    np.testing.assert_array_equal(read_experiment(at, MODEL).trials[0].outputs["friction_force"], [3.25, -4.5])


def test_a_line_of_units_above_averages_is_compared_too(tmp_path: Path) -> None:
    (tmp_path / "experiment.toml").write_text(
        'format = 1\ntitle = "m"\nnominal = { friction = "coulomb", kinematics = "internal", values = { F_C = 9 } }\n'
        'reader = { rows_after_header = 1 }\nmeans = { file = "m.csv" }\n'
        '[signals.mean_feed_force]\ncolumn = "Ff"\nunit = "N"\nrole = "output"\n'
    )
    (tmp_path / "m.csv").write_text("cutting_speed,Ff\nm/s,kN\n0.1,8\n0.2,7\n")
    with pytest.raises(ExperimentError, match=r"m\.csv, column 'Ff': the line of units below its header states kN"):
        read_experiment(tmp_path, MODEL)


def test_averages_go_by_the_same_options_and_leave_out_what_is_named(tmp_path: Path) -> None:
    (tmp_path / "experiment.toml").write_text(
        'format = 1\ntitle = "m"\nnominal = { friction = "coulomb", kinematics = "internal", values = { F_C = 9 } }\n'
        'reader = { decimal = ",", encoding = "cp1252", skip_rows = 1 }\nmeans = { file = "m.csv", ignore = ["Werkst\u00fcck"] }\n'
        '[signals.cutting_speed]\ncolumn = "vc"\nunit = "m/min"\nrole = "input"\n',
        encoding="utf-8",
    )
    (tmp_path / "m.csv").write_bytes(
        "Mittelwerte\nvc;mean_feed_force [N];Werkst\u00fcck\n6,0;8,5;St\u00fcck A\n12,0;7,5;B\n".encode("cp1252")
    )
    means = read_experiment(tmp_path, MODEL).means
    assert means is not None
    np.testing.assert_allclose(means.values["cutting_speed"], [0.1, 0.2], rtol=1e-15)
    np.testing.assert_array_equal(means.outputs["mean_feed_force"], [8.5, 7.5])
    path = tmp_path / "experiment.toml"
    path.write_text(path.read_text(encoding="utf-8").replace("Werkst\u00fcck", "St\u00fcck"), encoding="utf-8")
    with pytest.raises(ExperimentError, match=r"ignore names 'St\u00fcck', and there is no such column"):
        read_experiment(tmp_path, MODEL)


@pytest.mark.parametrize(
    ("reader", "said"),
    [
        ('delimiter = ";;"', "one character"),
        ('decimal = "."\ndelimiter = "5"', "one character"),
        ('decimal = "comma"', "allowed are"),
        ('decimal = ","\ndelimiter = ","', "between the columns, too"),
        ('encoding = "klingon"', "no such encoding"),
        ('encoding = "base64"', "no such encoding"),
        ("skip_rows = -1", "whole number of lines"),
        ("skip_rows = true", "whole number of lines"),
        ("rows_after_header = 1000000000", "whole number of lines"),
        ('columns = "t, v"', "a list of headers"),
        ('columns = ["t", "v", "t"]', "'t' stands there twice"),
        ("skiprows = 1", "did you mean skip_rows"),
    ],
)
def test_an_option_that_is_none_is_named(tmp_path: Path, reader: str, said: str) -> None:
    with pytest.raises(ExperimentError, match=said) as error:
        read_experiment(folder(tmp_path, reader, MESSY.encode("cp1252")), MODEL)
    assert "reader" in str(error.value)


COLUMNS = 'columns = ["Zeit", "Geschw. Schlitten \u00fc", "Kraft", ""]'
BARE = "0,5;1000;3,25;kalt\r\n0,75;2e3;-4,5;\r\n"


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize(
    ("more", "data"),
    [
        ('delimiter = ";"', BARE),
        ("", BARE),
        ("skip_rows = 1", "Pr\u00fcfstand 3;;;\n" + BARE),
        ("skip_rows = 2\nrows_after_header = 1", BARE),  # as its neighbours would have
        ('delimiter = " "', BARE.replace("kalt", "0").replace(";", "  ").replace("-4,5  ", " -4,5 0")),
        ("skip_rows = 1\nrows_after_header = 1", MESSY.replace("Bemerkung", "")),  # its own headers count
        ("skip_rows = 1\nrows_after_header = 1", MESSY.replace("Bemerkung", "").replace("Pr\u00fcfstand 3;;;", "7;8;9;")),
    ],
)
def test_a_file_without_headers_goes_by_columns(tmp_path: Path, more: str, data: str, encoding: str) -> None:
    reader = f'{COLUMNS}\nencoding = "{encoding}"\ndecimal = ","\n{more}'
    trial = read_experiment(folder(tmp_path, reader, data.encode(encoding)), MODEL).trials[0]
    np.testing.assert_array_equal(trial.times, [0.5, 0.75])
    np.testing.assert_array_equal(trial.inputs["slip_velocity"], [1.0, 2.0])
    np.testing.assert_array_equal(trial.outputs["friction_force"], [3.25, -4.5])


@pytest.mark.parametrize(
    ("columns", "data", "said"),
    [
        (COLUMNS, BARE.replace(";kalt", "").replace("-4,5;", "-4,5"), "line 1: 3 numbers where reader.columns names 4 columns"),
        (COLUMNS, BARE.replace("2e3", "n.A."), "line 2, column 'Geschw. Schlitten \u00fc': 'n.A.' is no number"),
        (COLUMNS, BARE + "1;2\n", "line 3: 2 cells where the headers are 4"),
        (COLUMNS.replace("Kraft", "F"), BARE, "there is no column 'Kraft' for friction_force; it has 'Zeit'"),
    ],
)
def test_a_file_that_does_not_fit_columns_is_refused(tmp_path: Path, columns: str, data: str, said: str) -> None:
    with pytest.raises(ExperimentError) as error:
        read_experiment(folder(tmp_path, f'{columns}\ndecimal = ","\ndelimiter = ";"', data.encode()), MODEL)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (MESSY.replace("2e3", "n.A."), "line 5, column 'Geschw. Schlitten \u00fc': 'n.A.' is no number"),
        (MESSY.replace("-4,5", "-4.5"), "line 5, column 'Kraft': '-4.5' is no number; the decimal mark is ',', see reader.decimal"),
        (MESSY.replace("0,75;", "0,75;;"), "line 5: 5 cells where the headers are 4"),
        (MESSY + "\r\nEnde der Messung\r\n", "line 7: 1 cells where the headers are 4: 'Ende der Messung'"),
    ],
)
def test_a_wrong_line_is_named(tmp_path: Path, data: str, said: str) -> None:
    reader = 'encoding = "cp1252"\ndecimal = ","\nskip_rows = 1\nrows_after_header = 1'
    with pytest.raises(ExperimentError) as error:
        read_experiment(folder(tmp_path, reader, data.encode("cp1252")), MODEL)
    assert said in str(error.value)


def test_a_large_file_in_another_encoding_lets_the_program_end(tmp_path: Path) -> None:
    """Arrow's own transcoding hangs here: its threads wait for an interpreter that is gone."""
    text = (
        "Zeit;Geschw. Schlitten \u00fc;Kraft\n" + "".join(f"0,{i:07d};1;2\n" for i in range(1, 600_000)) + "x;1;2\n" + "1,5;1;2\n" * 900_000
    )
    folder(tmp_path, 'encoding = "cp1252"\ndecimal = ","', text.encode("cp1252"))
    ask = "import sys, pathlib\nfrom evat.experiment.read import read_experiment\nfrom evat.models.contact import ContactModel\n"
    ask += "try:\n    read_experiment(sys.argv[1], ContactModel())\nexcept Exception as error:\n    print(error); sys.exit(2)"
    done = subprocess.run([sys.executable, "-c", ask, str(tmp_path)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2, done.stderr
    assert "line 600001, column 'Zeit': 'x' is no number" in done.stdout


def test_every_key_that_is_declared_is_read(tmp_path: Path) -> None:
    """A key of the declaration, and no other, passes where it stands."""
    assert {"sign", "scale", "offset", "from", "radius"} <= set(keys("[signals.NAME]"))
    path = folder(tmp_path, 'decimal = ","', MESSY.encode("cp1252")) / "experiment.toml"
    text = path.read_text(encoding="utf-8")
    for table in TABLES:
        for key in (*keys(table), "nonsense"):
            if table == "":
                written = f"{key} = {{}}\n" + text.replace(f"\n{key} = ", "\n#")
            elif table == "[nominal]":
                written = text.replace(f"\n{key} = ", "\n#").replace("[nominal]", f"[nominal]\n{key} = {{}}")
            else:
                before = text if table == "[setup_sd.NAME]" else 'format = 1\ntitle = ""\n' + "nominal = {}\n"
                written = f"{before}\n{table.replace('NAME', 'friction_force')}\n{key} = {{}}\n"
            path.write_text(written, encoding="utf-8")
            with pytest.raises(ExperimentError) as error:
                read_experiment(tmp_path, MODEL)
            assert ("is not known" in str(error.value)) == (key == "nonsense"), (table, key, str(error.value))


def test_a_wrong_cell_names_its_file_once(tmp_path: Path) -> None:
    """As it is called in the experiment."""
    reader = 'encoding = "cp1252"\ndecimal = ","\ndelimiter = ";"\nskip_rows = 1\nrows_after_header = 1'
    wrong = folder(tmp_path, reader, MESSY.replace("3,25", "drei").encode("cp1252"))
    (wrong / "trials").mkdir()
    (wrong / "a.csv").rename(wrong / "trials" / "a.csv")
    toml = wrong / "experiment.toml"
    toml.write_text(toml.read_text(encoding="utf-8").replace('"a.csv"', '"trials/a.csv"'), encoding="utf-8")
    with pytest.raises(ExperimentError, match=r"^trials/a\.csv\b(?!.*a\.csv)"):
        read_experiment(wrong, MODEL)


def test_an_empty_line_is_passed_over(tmp_path: Path) -> None:
    """As the guide says, and nothing else is; rows are counted without it."""
    data = "Zeit,Geschw. Schlitten \u00fc,Kraft\n0,1000,3\n\n1,2000,4\n\n2,2000,{}\n\n"
    trial = read_experiment(folder(tmp_path, "", data.format("5").encode()), MODEL).trials[0]
    np.testing.assert_array_equal(trial.times, [0, 1, 2])
    with pytest.raises(ExperimentError, match="data row 3: no finite number"):
        read_experiment(folder(tmp_path, "", data.format("").encode()), MODEL)
