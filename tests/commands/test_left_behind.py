"""What does a killed process leave for ever? Nothing: the next run that writes there clears it, and nothing of a living one."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from evat.experiment.write import write_experiment
from evat.files import writing
from known_rigs import GUESS, TO_AND_FRO, experiment, trial

WRITES = """
import sys, time
from pathlib import Path
from evat.files import writing
with writing.whole(Path(sys.argv[1]) / "result.csv") as made:
    made.write_text("half")
    print("ready", flush=True)
    time.sleep(600)
"""
IDENTIFIES = """
import sys, time
from evat.commands.main import main
from evat.identification.report import output
def stop(identification):
    print("ready", flush=True)
    time.sleep(600)
output.figures = stop
main()
"""


@contextmanager
def stopped_half_way(code: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A process that writes, stopped where it has half done so; killed at the end if it lives then."""
    with subprocess.Popen([sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        while (line := process.stdout.readline()) and "ready" not in line:
            pass
        assert line, "it ended before it was asked to"
        try:
            yield process
        finally:
            process.kill()


def write(folder: Path) -> None:
    """In a process of its own, as any later run is."""
    code = "import sys; from pathlib import Path; from evat.files import writing; writing.put(Path(sys.argv[1]) / 'other.csv', 'whole')"
    subprocess.run([sys.executable, "-c", code, str(folder)], check=True)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_what_a_killed_process_has_left_is_cleared(tmp_path: Path) -> None:
    with stopped_half_way(WRITES, str(tmp_path)) as process:
        process.kill()
    assert len(names(tmp_path)) == 2  # its folder and the lock
    write(tmp_path)
    assert names(tmp_path) == {"other.csv"}


def test_what_a_living_process_has_is_left_to_it(tmp_path: Path) -> None:
    with stopped_half_way(WRITES, str(tmp_path)):
        before = names(tmp_path)
        write(tmp_path)
        assert names(tmp_path) == before | {"other.csv"}
        (half,) = (path for path in tmp_path.iterdir() if path.is_dir())
        assert [path.read_text(encoding="utf-8") for path in half.iterdir()] == ["half"]


def test_what_another_machine_has_on_a_shared_disk_is_left_to_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lock of its processes may look free from here."""
    with stopped_half_way(WRITES, str(tmp_path)) as process:
        process.kill()
    before = names(tmp_path)
    monkeypatch.setattr(writing, "_OURS", ".evat-another_machine-")
    monkeypatch.setattr(writing, "_cleared", set())
    writing.put(tmp_path / "other.csv", "whole")
    assert names(tmp_path) == before | {"other.csv"}


def test_what_is_not_ours_is_left_alone(tmp_path: Path) -> None:
    """Files of that name which hold no lock, and a lock that is a link to somebody's file."""
    (tmp_path / f"{writing._OURS}notes.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "thesis.txt").write_text("years", encoding="utf-8")
    try:
        (tmp_path / f"{writing._OURS}0.lock").symlink_to(tmp_path / "thesis.txt")
    except OSError:
        pytest.skip("links cannot be made here")
    before = names(tmp_path)
    write(tmp_path)
    assert names(tmp_path) == before | {"other.csv"}
    assert (tmp_path / "thesis.txt").read_text(encoding="utf-8") == "years"


def test_an_identification_that_was_killed_in_its_report(tmp_path: Path) -> None:
    rig = write_experiment(experiment(trial(TO_AND_FRO[:200]), nominal=GUESS), tmp_path / "rig")
    out = tmp_path / "found"
    asked = ["identify", str(rig), "-f", "F_C", "--search", "none", "-o", str(out)]
    with stopped_half_way(IDENTIFIES, *asked) as process:
        process.kill()
    assert any(name.startswith(".") for name in names(out))
    subprocess.run([sys.executable, "-c", "from evat.commands.main import main; main()", *asked], check=True)
    assert names(out) == {"search.journal", "identified.ssv", "identification.json", "report.html"}
