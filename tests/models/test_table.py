"""Do numbers and their units get from a file to SI and back unharmed, and is a file that cannot be trusted refused?"""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from evat.files import stream
from evat.files.read_toml import read_toml
from evat.files.table import read_table, write_trace
from evat.files.text import RecordError
from evat.files.writing import OutputError
from evat.model import EvatError, Trace

AWKWARD = np.array([0.1, -0.0, 1 / 3, 5e-324, 1.7976931348623157e308, 2.0**53 + 2])  # nothing but all 17 digits brings them back


def trace(column: np.ndarray = AWKWARD) -> Trace:
    times = np.arange(column.size) / 3
    return Trace(
        times, {"friction_force": column, "in_contact": np.ones(column.size)}, {"friction_force": "N", "in_contact": "1"}, {"by": "us"}
    )


def written(folder: Path, text: str | bytes, name: str = "file.csv") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize("name", ["out.csv", "out.parquet", "deep/er/OUT.PARQUET", "out.pq", "no suffix"])
def test_what_is_written_is_read_to_the_last_bit(tmp_path: Path, name: str) -> None:
    path = write_trace(trace(), tmp_path / name)
    table = read_table(path)
    assert list(table.columns) == ["time [s]", "friction_force [N]", "in_contact [1]"]
    assert table.clock("time [s]").tobytes() == trace().times.tobytes()
    assert table.column("friction_force [N]", "N").tobytes() == AWKWARD.tobytes()
    assert [each.name for each in path.parent.iterdir()] == [path.name]  # nothing is left lying about


@pytest.mark.parametrize("name", ["out.csv", "out.parquet"])
def test_the_same_trace_is_the_same_bytes_and_replaces_what_was_there(tmp_path: Path, name: str) -> None:
    other = write_trace(trace(np.zeros(3)), tmp_path / name).read_bytes()
    first = write_trace(trace(), tmp_path / name).read_bytes()
    assert first == write_trace(trace(), tmp_path / f"again-{name}").read_bytes() != other


def test_parquet_says_how_it_was_made(tmp_path: Path) -> None:
    metadata = pa.parquet.read_table(write_trace(trace(), tmp_path / "out.parquet")).schema.metadata
    assert json.loads(metadata[b"made_by"]) == {"by": "us"}


@pytest.mark.skipif(os.name == "nt", reason="Windows has no permission bits for others")
def test_others_may_read_the_result_as_they_may_any_new_file(tmp_path: Path) -> None:
    plain = written(tmp_path, "")
    assert stat.S_IMODE(write_trace(trace(), tmp_path / "out.csv").stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


@pytest.mark.parametrize("name", ["taken/out.csv", "folder", "x" * 300 + ".csv"])
def test_where_nothing_can_be_written_is_said(tmp_path: Path, name: str) -> None:
    written(tmp_path, "a file, no folder", "taken")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OutputError, match="cannot be written"):
        write_trace(trace(), tmp_path / name)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["folder", "taken"]


@pytest.mark.parametrize(
    ("header", "unit", "factor"),  # of the file's 2.0 to the unit that is wanted, exact by definition of the units
    [
        ("v [mm/s]", "m/s", 2e-3),
        ("v (mm/s)", "m/s", 2e-3),
        (" v  [ m/min ] ", "m/s", 2 / 60),
        ("F", "N", 2.0),
        ("F friction (chip side) [kN]", "N", 2e3),
        ("F friction (chip side) (uN)", "N", 2e-6),
        ("F (chip side), raw", "N", 2.0),
        ("sigma2 [N/(m/min)]", "N.s/m", 120.0),
        ("sigma2 (N/(m/min))", "N.s/m", 120.0),
        ("T [degC]", "K", 275.15),
        ("x [µm]", "m", 2e-6),
        ('=cmd|"/c calc"!A1 [N]', "N", 2.0),  # a name is a name
        ("../../x [m]", "m", 2.0),
    ],
)
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_header_says_its_unit(tmp_path: Path, header: str, unit: str, factor: float, delimiter: str) -> None:
    quoted = '"' + header.replace('"', '""') + '"'
    table = read_table(written(tmp_path, f"n{delimiter}{quoted}\r\n1{delimiter}2\r\n2{delimiter}2\r\n"))
    assert table.column(header, unit) == pytest.approx([factor, factor], rel=1e-15)


@pytest.mark.parametrize(
    ("header", "what"),
    [
        ("F [lbs per fortnight]", "does not measure what 'N'"),
        ("F [s]", "does not measure what 'N'"),
        ("F []", "unit"),
        ("F [N)", "hold no unit"),
        ("F N]", "hold no unit"),
        ("F [[N]]", "hold no unit"),
        ("F (measured)", "not defined"),
        ("F [__import__('os').abort()]", "no such unit"),
    ],
)
def test_a_unit_that_is_none_is_no_newton(tmp_path: Path, header: str, what: str) -> None:
    table = read_table(written(tmp_path, f'"{header}"\n1\n'))
    with pytest.raises(RecordError, match=what) as caught:
        table.column(header, "N")
    assert "file.csv, column" in str(caught.value)


@pytest.mark.parametrize("hole", ["", "nan", "inf", "-inf", "NULL"])
def test_a_hole_is_named_by_its_row_and_not_filled(tmp_path: Path, hole: str) -> None:
    table = read_table(written(tmp_path, f"t,F\n0,1\n1,{hole}\n2,3\n"))
    with pytest.raises(RecordError, match="'F', data row 2: no finite number"):
        table.column("F", "N")
    assert table.column("t", "s").tolist() == [0, 1, 2]


@pytest.mark.parametrize(("rows", "row"), [("0\n1\n1\n", 3), ("0\n2\n1\n", 3), ("3\n2\n1\n", 2), ("0\n", 1)])
def test_a_clock_that_does_not_run_on_is_refused(tmp_path: Path, rows: str, row: int) -> None:
    with pytest.raises(RecordError, match=f"'t', data row {row}: the clock must increase"):
        read_table(written(tmp_path, f"t\n{rows}")).clock("t")


def test_a_clock_in_milliseconds_runs_in_seconds(tmp_path: Path) -> None:
    assert read_table(written(tmp_path, "t [ms]\n0\n1\n5\n")).clock("t [ms]") == pytest.approx([0, 1e-3, 5e-3], rel=1e-15)


@pytest.mark.parametrize("text", ["F,note\n1,a\n2,b\n", "F,note\n1,0.5 N\n", "F;note\n1;0,5\n", "F,note\n1,true\n"])
def test_a_column_that_is_not_all_numbers_is_called_so(tmp_path: Path, text: str) -> None:
    table = read_table(written(tmp_path, text))
    assert table.column("F", "N")[0] == 1
    with pytest.raises(RecordError, match="'note': not all of it is numbers"):
        table.column("note", "N")
    with pytest.raises(RecordError, match="no column 'force'; it has 'F'"):
        table.column("force", "N")


@pytest.mark.parametrize(
    ("content", "name", "what"),
    [
        (b"a,a\n1,2\n", "file.csv", "two columns have the header 'a'"),
        (b"t [\xb5s],F\n1,2\n", "file.csv", "UTF-8"),
        (b"a,b\n1\n", "file.csv", "line 2: 1 cells where the headers are 2"),
        (b"a,b\nx,y\n", "file.csv", "no column of numbers"),
        (b"\0" * 100, "file.csv", "no table of numbers"),
        (b"", "file.parquet", "no table of numbers"),
        (b"PAR1" + b"\xff" * 50 + b"PAR1", "file.parquet", "no table of numbers"),
        (b"a,b\n1,2\n", "file.parquet", "no table of numbers"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path: Path, content: bytes, name: str, what: str) -> None:
    with pytest.raises(RecordError, match=what) as caught:
        read_table(written(tmp_path, content, name))
    assert name in str(caught.value)


def test_a_folder_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "nowhere.csv", tmp_path / "nowhere.parquet", tmp_path / "no\nwhere.csv"):
        with pytest.raises(RecordError):
            read_table(path)


def test_integers_and_holes_of_parquet_are_numbers(tmp_path: Path) -> None:
    table = pa.table(
        {"n": pa.array([1, 2, 3]), "F": pa.array([1, None, 3]), "half": pa.array([0.5, 1, 2], pa.float32()), "s": ["a", "b", "c"]}
    )
    pa.parquet.write_table(table, tmp_path / "in.parquet")
    read_back = read_table(tmp_path / "in.parquet")
    assert read_back.column("n", "1").tolist() == [1, 2, 3]
    assert read_back.column("half", "1").tolist() == [0.5, 1, 2]
    with pytest.raises(RecordError, match="data row 2"):
        read_back.column("F", "N")
    with pytest.raises(RecordError, match="not all of it is numbers"):
        read_back.column("s", "1")


def test_writing_a_table_does_not_load_pandas(tmp_path: Path) -> None:
    """Which takes most of the time between Ctrl-C and the end."""
    code = (
        "import sys, numpy as np; from pathlib import Path; from evat.files.table import write_columns;"
        "write_columns({'t [s]': np.arange(3.0), 'x [N]': np.arange(6.0)[::2]}, Path(sys.argv[1]));"
        "sys.exit('pandas' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "a.csv")], check=True)
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()[1:] == ["0,0", "1,2", "2,4"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such files")
@pytest.mark.parametrize("kind", ["device", "pipe"])
@pytest.mark.parametrize("read", [read_table, stream.headers, stream.rows_about, read_toml], ids=["table", "headers", "rows", "TOML"])
def test_a_file_without_an_end_is_not_begun(tmp_path: Path, read: Callable[[Path], object], kind: str) -> None:
    path = Path("/dev/zero")
    if kind == "pipe":
        path = tmp_path / "pipe.csv"
        os.mkfifo(path)
    with pytest.raises(EvatError, match=rf"{path.name}: .*it is no regular file, but a device, pipe or socket"):
        read(path)
