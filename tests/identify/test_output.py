"""Do the files that an identification leaves say what it found, and does the FMU with the .ssv give the calculated force?"""

from __future__ import annotations

import json
import math
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat import parameter_sets
from evat.experiment.read import read_experiment
from evat.experiment.write import write_experiment
from evat.files.writing import OutputError
from evat.identification import Identification, Settings, identify
from evat.identification.report import output
from evat.model import Run
from evat.models.drive import drive
from evat.native import kernel
from known_rigs import FREE, GUESS, MODEL, TIMES, TO_AND_FRO, experiment, trial
from lxml import html
from typer.testing import CliRunner


@pytest.fixture(scope="module")
def identification() -> Identification:
    rig = experiment(trial(TO_AND_FRO), trial(TO_AND_FRO, seed=2), trial(0.6 * TO_AND_FRO, "c1", seed=3))
    return identify(rig, MODEL, FREE, Settings(seed=1, generations=4, hold_out=("c1",)))


@pytest.fixture(scope="module")
def written(identification: Identification, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of its files, which no test changes."""
    folder = tmp_path_factory.mktemp("written") / "out"
    output.write(identification, folder)
    return folder


def test_the_fmu_with_the_identified_set_gives_the_calculated_force(identification: Identification, written: Path, fmi2_fmu: Path) -> None:
    """Relative to the force, within the tolerance of either run."""
    read = parameter_sets.load_ssv(written / "identified.ssv")
    run = Run(TIMES, {"slip_velocity": TO_AND_FRO}, ("friction_force",))
    force = drive(fmi2_fmu, run, kernel.by_choice(dict(read.values)), relative_tolerance=1e-6)["friction_force"]
    calculated = identification.predicted[: TIMES.size]
    assert np.max(np.abs(force - calculated)) < 1e-3 * np.max(np.abs(calculated))
    for estimate in identification.estimates:
        assert read.values[estimate.name] == estimate.value
        assert estimate.verdict in read.sources[estimate.name]
    notes = " ".join(read.notes)
    for word in ("hash of no file", "seed 1", "least_squares", kernel.token(), "eq. 9", "held out (c1)"):
        assert word in notes


def test_the_json_is_what_was_found(identification: Identification, written: Path) -> None:
    read = json.loads(
        (written / "identification.json").read_text(encoding="utf-8"), parse_constant=lambda text: pytest.fail(f"{text} is no JSON")
    )
    for estimate in identification.estimates:
        entry = read["parameters"][estimate.name]
        assert entry["value"] == estimate.value
        assert entry["interval_90"] == [estimate.low, estimate.high]
        assert entry["verdict"] == estimate.verdict
        assert min(entry["profile"]["rise"]) == pytest.approx(0.0, abs=0.1)
    assert read["held_out"]["conditions"] == ["c1"]
    assert read["fit"]["friction_force"]["noise"] == identification.fits["friction_force"].noise
    assert len(read["search"]["best"]) == len(identification.history)


def test_the_report_stands_alone_and_escapes(identification: Identification, tmp_path: Path) -> None:
    """A title and file names that are markup stay text; nothing is loaded from elsewhere; the same answer gives the same bytes."""
    evil = "<script>alert(1)</script>"
    shown = replace(identification, experiment=replace(identification.experiment, title=evil), doubts=(evil,), seconds=1.0)
    _, _, path = output.write(shown, tmp_path)
    text = path.read_text(encoding="utf-8")
    assert evil not in text
    page = html.fromstring(text)
    assert page.findtext(".//h1") == evil
    sources = [image.get("src") for image in page.iter("img")]
    assert len(sources) == 2 + 2 + 5 + 1  # conditions, twice; profiles; correlations
    assert all(source.startswith("data:image/svg+xml;base64,") for source in sources)
    assert not re.search(r"https?://", text)
    output.write(shown, tmp_path / "again")
    assert (tmp_path / "again" / "report.html").read_bytes() == path.read_bytes()


def test_nothing_half_written_is_left(
    identification: Identification, written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert set(before) == {"identified.ssv", "identification.json", "report.html"}

    def fails(*_: object) -> dict[str, str]:
        raise OSError("no space left")

    monkeypatch.setattr(output, "figures", fails)
    with pytest.raises(OutputError, match="cannot be written"):
        output.write(replace(identification, cost=math.pi), tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_command(tmp_path: Path) -> None:
    """From the folder of an experiment to the three files; a second run with --resume gives the same bytes but for the seconds."""
    from evat.commands.main import app

    folder = write_experiment(experiment(trial(TO_AND_FRO[:400]), nominal=GUESS), tmp_path / "rig")
    assert read_experiment(folder, MODEL).samples == 400
    arguments = ["identify", str(folder), "-f", "F_C", "-f", "sigma0", "-b", "F_C=1..30 N", "-b", "sigma0=1e4..1e6 N/m", "--search", "de"]
    arguments += ["--generations", "6", "--population", "16", "--seed", "4", "-o", str(tmp_path / "out")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "F_C" in result.output
    read = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))
    assert read["parameters"]["F_C"]["bounds"] == [1.0, 30.0]
    assert read["made_by"]["data"] == read_experiment(folder, MODEL).data_hash
    again = CliRunner().invoke(app, [*arguments, "--resume"])
    assert again.exit_code == 0, again.output
    read_again = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))
    for one in (read, read_again):
        one["search"].pop("seconds")
    assert read == read_again


@pytest.mark.skipif(sys.platform == "win32", reason="there Ctrl-C goes to a whole console")
def test_ctrl_c_stops_with_the_best_so_far(tmp_path: Path) -> None:
    """A process of its own, interrupted after some generations: results are written, marked as stopped, and --resume goes on from there."""
    folder = write_experiment(experiment(trial(TO_AND_FRO[:400])), tmp_path / "rig")
    free = [text for name in FREE for text in ("-f", name)]
    arguments = ["identify", str(folder), *free, "--search", "ga", "--generations", "3000", "-o", str(tmp_path / "out")]
    process = subprocess.Popen(
        [sys.executable, "-c", "from evat.commands.main import main; main()", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    journal, begin = tmp_path / "out" / "search.journal", time.monotonic()
    while time.monotonic() - begin < 60 and not (journal.is_file() and journal.read_bytes().count(b"\n") > 3):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert "stopped: the best so far was written" in said
    read = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))
    assert read["stopped"]
    assert len(read["search"]["best"]) == journal.read_bytes().count(b"\n") - 1
    assert "stopped by its user" in " ".join(parameter_sets.load_ssv(tmp_path / "out" / "identified.ssv").notes)


def test_a_record_with_holes(tmp_path: Path) -> None:
    """Five per cent of the force are not numbers: refused, with file, column and row."""
    from evat.commands.main import app

    folder = write_experiment(experiment(trial(TO_AND_FRO[:200])), tmp_path / "rig")
    (path,) = folder.rglob("*.csv")
    lines = path.read_text(encoding="utf-8").splitlines()
    holes = [line if place % 20 else ",".join([*line.split(",")[:-1], "nan"]) for place, line in enumerate(lines[1:], 1)]
    path.write_text("\n".join([lines[0], *holes]) + "\n", encoding="utf-8")
    result = CliRunner().invoke(app, ["identify", str(folder), "-f", "F_C", "-o", str(tmp_path / "out")])
    assert result.exit_code != 0
    assert path.name in str(result.exception)
    assert "data row 20" in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_a_bound_that_is_none(tmp_path: Path) -> None:
    from evat.commands.main import app

    folder = write_experiment(experiment(trial(TO_AND_FRO[:50])), tmp_path / "rig")
    result = CliRunner().invoke(app, ["identify", str(folder), "-f", "F_C", "-b", "F_C=3 N"])
    assert result.exit_code != 0
    assert "NAME=LOW..HIGH" in str(result.exception)
