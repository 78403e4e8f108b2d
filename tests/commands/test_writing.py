"""What does a user see where nothing can be written, and what is left on the disk then? One line, and nothing half-written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from evat.files import writing
from evat.files.writing import OutputError, usable

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no file's size")
FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")


def evat(*arguments: str, folder: Path, most: int | None = None, **named: object) -> subprocess.CompletedProcess[str]:
    """The command, in a process whose files may have at most so many bytes: the system refuses to write, as a full disk does."""

    def limit() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (most or 0, most or 0))

    # -B: Python keeps a compiled module of which the limit let only a part through, and every later start would read it.
    command = [sys.executable, *(["-B"] if most else []), "-c", "from evat.commands.main import main; main()", *arguments]
    return subprocess.run(
        command, cwd=folder, stderr=subprocess.PIPE, text=True, timeout=120, preexec_fn=limit if most else None,
        **{"stdout": subprocess.PIPE, **named},
    )  # type: ignore[call-overload,no-any-return]  # fmt: skip


def refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    assert done.returncode == 2, done.stderr
    said = done.stderr.lstrip("\n")  # a bar that has ended leaves an empty line
    assert said.startswith("evat: "), said
    assert said.count("\n") == 1, said
    for word in words:
        assert word in done.stderr


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rig") / "rig"
    done = evat("experiment", "orthogonal", "-s", "published/copper", "--speed", "10 m/min", "--out", str(folder), folder=folder.parent)
    assert done.returncode == 0, done.stderr
    return folder


@POSIX
def test_a_plot_that_no_longer_fits_beside_its_table(tmp_path: Path) -> None:
    """The table is whole and stays."""
    done = evat("simulate", "--cycles", "1", "--samples", "10", "-o", "cut.csv", folder=tmp_path, most=8192)
    refused(done, "cut.png: the picture cannot be written: File too large")
    assert "wrote cut.csv" in done.stdout
    assert files(tmp_path) == ["cut.csv"]


@POSIX
@pytest.mark.parametrize(
    ("arguments", "most"),
    [
        (("simulate", "-o", "cut.csv"), 4096),
        (("simulate", "-o", "cut.parquet"), 4096),
        (("effects", "run_out", "-o", "run-out.png"), 4096),
        (("sets", "lugre-1995", "--save", "set.ssv"), 256),
        (("experiment", "orthogonal", "-s", "published/copper", "--out", "rig"), 4096),
        (("experiment", "recovery", "lugre-1995", "--motion", "ramp", "--csv", "all.csv"), 256),
    ],
)
def test_a_disk_that_is_full(tmp_path: Path, arguments: tuple[str, ...], most: int) -> None:
    refused(evat(*arguments, folder=tmp_path, most=most), arguments[-1], "cannot be written", "ame another place")
    assert files(tmp_path) == []


@POSIX
def test_a_disk_that_fills_while_a_search_goes_on(rig: Path, tmp_path: Path) -> None:
    """The journal keeps what was written of it, and the search goes on from there."""
    asked = ("identify", str(rig), "-f", "F_C", "--search", "de", "--population", "8", "--generations", "6", "-o", "found")
    refused(evat(*asked, folder=tmp_path, most=2048), str(Path("found") / "search.journal"), "the journal cannot be written")
    assert files(tmp_path) == ["found", str(Path("found") / "search.journal")]
    assert evat(*asked, "--resume", folder=tmp_path).returncode == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ("build", "--host-only", "--out", "file/fmus"),
        ("run", "--out", "file/runs"),
        ("simulate", "--out", "file/cut.csv"),
        ("identify", "{rig}", "-f", "F_C", "--out", "file/found"),
        ("diagnose", "{rig}", "--out", "file/diagnosed"),
        ("benchmark", "{rig}/..", "--out", "file/answers"),
        ("calibrate", "--cases", "20", "--state", "file/state.jsonl"),
        ("experiment", "orthogonal", "-s", "published/copper", "--out", "file/rig"),
        ("experiment", "recovery", "--csv", "file/all.csv"),
        ("experiment", "recovery", "--plot", "file/all.png"),
        ("effects", "run_out", "--out", "file/run-out.png"),
        ("study", "paper", "--out", "file/study"),
        ("system", "run", "no.ssp", "--out", "file/out.csv"),
        ("system", "sweep", "no.ssp", "--over", "a.b=1:2:2", "--out", "file/out.csv"),
        ("system", "averaging", "no.ssp", "--out", "file/out.csv"),
    ],
)
def test_a_place_that_is_none_is_told_before_any_work(rig: Path, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    from evat.commands.main import app
    from typer.testing import CliRunner

    (tmp_path / "file").write_text("a file, no folder", encoding="utf-8")
    here = [word.format(rig=rig).replace("file/", f"{tmp_path / 'file'}{os.sep}") for word in arguments]
    result = CliRunner().invoke(app, here)
    assert isinstance(result.exception, OutputError), result.output
    assert "cannot be written: Not a directory" in str(result.exception) or os.name == "nt"
    assert files(tmp_path) == ["file"]


@pytest.mark.parametrize("there", [False, True])
def test_a_question_that_is_refused_leaves_no_folder(rig: Path, tmp_path: Path, there: bool) -> None:
    from evat.commands.main import app
    from evat.model import EvatError
    from typer.testing import CliRunner

    if there:
        (tmp_path / "new").mkdir()
    result = CliRunner().invoke(app, ["identify", str(rig), "-f", "F_C", "-b", "F_C=20..10", "-o", str(tmp_path / "new" / "fit")])
    assert isinstance(result.exception, EvatError)
    assert [place.name for place in tmp_path.iterdir()] == ["new"] * there


@FULL
@pytest.mark.parametrize("arguments", [("info",), ("effects", "--json"), ("sets",)])
def test_standard_output_that_is_full(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("w") as full:
        refused(evat(*arguments, folder=tmp_path, stdout=full), "evat: standard output: No space left on device")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such pipes")
@pytest.mark.parametrize("arguments", [("info",), ("info", "--json"), ("effects", "--json"), ("simulate", "-o", "cut.csv")])
def test_a_reader_who_has_seen_enough_is_no_error(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    """`evat info | head -1`; what is to be written is written."""
    ours, theirs = os.pipe()
    os.close(ours)
    try:
        done = evat(*arguments, folder=tmp_path, stdout=theirs)
    finally:
        os.close(theirs)
    assert (done.returncode, done.stderr) == (0, "")
    assert files(tmp_path) == (["cut.csv", "cut.png"] if "simulate" in arguments else [])


@POSIX
def test_standard_output_that_is_closed_is_named(tmp_path: Path) -> None:
    code = "import os; os.close(1); from evat.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "sets"], cwd=tmp_path, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("evat: standard output: Bad file descriptor.")


@pytest.mark.parametrize("command", [("simulate",), ("system", "run", "no.ssp")])
def test_a_picture_does_not_replace_its_table(tmp_path: Path, command: tuple[str, ...]) -> None:
    refused(evat(*command, "-o", "cut.png", folder=tmp_path), "--out cut.png", "name it .csv or .parquet")
    assert files(tmp_path) == []


def test_a_picture_of_a_kind_that_is_none(tmp_path: Path) -> None:
    """Without a suffix matplotlib would write another file than the one that was asked for."""
    for name in ("picture", "picture.xyz"):  # before any work: the value is impossible, and is not yet looked at
        done = evat("effects", "run_out", "-v", "run_out.amplitude=-1", "-o", name, folder=tmp_path)
        refused(done, name, "name it .png, .svg or .pdf")
    assert files(tmp_path) == []


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old", encoding="utf-8")
    try:
        (tmp_path / "link").symlink_to(tmp_path / "real")
    except OSError:
        pytest.skip("links cannot be made here")
    writing.put(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text(encoding="utf-8") == "new"


@POSIX
def test_what_is_no_file_is_written_to_and_stays_what_it_is(tmp_path: Path) -> None:
    """A pipe: to move a file into its place would leave its reader waiting for ever."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE, text=True) as reader:
        writing.put(pipe, "through")
        assert reader.communicate(timeout=20)[0] == "through"
    assert pipe.is_fifo()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="it is Linux that has this folder")
def test_a_folder_that_takes_no_files_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not after the lock has tried for ten seconds: of what says that something is not there it believes that it may come."""
    asked = list[object]()
    monkeypatch.setattr("evat.files.writing._try", asked.append)
    with pytest.raises(OutputError, match=r"^/proc: a file in it cannot be written: No such file or directory\. Name another place\.$"):
        usable(Path("/proc"))
    assert asked == []
