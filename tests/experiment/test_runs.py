"""Are recordings that stand below each other in one file told apart, by the column that counts them?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.experiment import ExperimentError
from evat.experiment.begin.guess import begin
from evat.experiment.begin.understood import Answers, Begun
from evat.experiment.begin.write import Believed, write_begun
from evat.experiment.read import read_experiment, scan_experiment
from evat.models.contact import ContactModel
from numpy.typing import NDArray

MODEL = ContactModel(1)
TIMES = np.arange(100) / 100


def stacked(path: Path, counters: dict[str, list[float]], speeds: list[float], remark: str = "") -> None:
    """Strokes of these speeds below each other, each with its own clock and what the counters say of it."""
    rows = [",".join(["time [s]", *counters, "v [mm/s]", "Kraft [N]", *([remark] if remark else [])])]
    for place, speed in enumerate(speeds):
        for t in TIMES:
            velocity = speed * np.sin(2 * np.pi * t)
            told = [f"{values[place]:g}" for values in counters.values()]
            force = 5 * np.tanh(velocity / 1e-3)
            rows.append(",".join([f"{t:.6g}", *told, f"{1e3 * velocity:.7g}", f"{force:.7g}", *(["ok"] if remark else [])]))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def begun(folder: Path) -> Begun:
    answer, questions = begin(folder, Answers())
    assert not questions
    assert answer is not None
    write_begun(answer, Believed(), force=True)
    return answer


def sine(speed: float) -> NDArray[np.float64]:
    expected: NDArray[np.float64] = speed * np.sin(2 * np.pi * TIMES)
    return expected


def test_a_counter_of_runs_parts_a_file(tmp_path: Path) -> None:
    """Two speeds, twice each, in one file with a column of remarks; and again in a second file."""
    for name in ("a.csv", "b.csv"):
        stacked(tmp_path / name, {"Lauf": [1, 2, 3, 4]}, [0.01, 0.05, 0.01, 0.05], "remark")
    guess = begun(tmp_path)
    assert [dict(trial.rows) for trial in guess.trials] == 2 * [{"Lauf": number} for number in (1.0, 2.0, 3.0, 4.0)]
    assert any("'Lauf'" in each for each in guess.look)
    assert not any("Lauf" in each for each in guess.left)
    text = (tmp_path / "experiment.toml").read_text(encoding="utf-8")
    assert "rows = {Lauf = 1.0}  # guessed: its clock begins anew there" in text
    experiment = read_experiment(tmp_path, MODEL)
    assert [trial.file for trial in experiment.trials][:2] == ["a-Lauf-1.csv", "a-Lauf-2.csv"]
    assert [trial.condition for trial in experiment.trials] == 4 * ["a-Lauf-1", "a-Lauf-2"]  # by how they move
    for trial, speed in zip(experiment.trials, 4 * [0.01, 0.05], strict=True):
        assert trial.inputs["slip_velocity"] == pytest.approx(sine(speed), abs=1e-8)
        assert trial.times == pytest.approx(TIMES)
    assert [facts.rows for facts in scan_experiment(tmp_path, MODEL).trials] == 8 * [100]


def test_runs_that_are_counted_anew_at_each_load_need_both_columns(tmp_path: Path) -> None:
    stacked(tmp_path / "all.csv", {"run": [1, 2, 1, 2], "load_no": [1, 1, 2, 2]}, [0.01, 0.01, 0.05, 0.05])
    guess = begun(tmp_path)
    assert [tuple(trial.rows.items()) for trial in guess.trials] == [
        (("load_no", load), ("run", run)) for load in (1.0, 2.0) for run in (1.0, 2.0)
    ] or [tuple(trial.rows.items()) for trial in guess.trials] == [
        (("run", run), ("load_no", load)) for load in (1.0, 2.0) for run in (1.0, 2.0)
    ]
    assert len(read_experiment(tmp_path, MODEL).conditions) == 2


def test_one_recording_to_a_file_stays_one(tmp_path: Path) -> None:
    """A column that never changes, or changes within the recording, parts nothing."""
    stacked(tmp_path / "a.csv", {"run": [1]}, [0.01])
    stacked(tmp_path / "b.csv", {"run": [2]}, [0.05])
    assert all(not trial.rows for trial in begun(tmp_path).trials)
    assert len(read_experiment(tmp_path, MODEL).trials) == 2


def test_a_clock_that_begins_anew_where_nothing_counts_is_refused_with_its_row(tmp_path: Path) -> None:
    stacked(tmp_path / "all.csv", {}, [0.01, 0.05])
    begun(tmp_path)
    with pytest.raises(
        ExperimentError, match=r"all.csv, column 'time \[s\]', data row 101: .* goes from 0.99 to 0 s.*give each trial its `rows`"
    ):
        read_experiment(tmp_path, MODEL)


DOCUMENT = """format = 1
title = "runs"
[nominal]
friction = "lugre"
kinematics = "external"
[nominal.values]
F_C = 5.0
[signals.time]
column = "time [s]"
unit = "s"
[signals.slip_velocity]
column = "v [mm/s]"
unit = "mm/s"
role = "input"
[signals.friction_force]
column = "Kraft [N]"
unit = "N"
role = "output"
"""


def documented(folder: Path, *trials: str) -> None:
    entries = "".join(f'[[trials]]\nfile = "all.csv"\ncondition = "a"\n{each}\n' for each in trials)
    (folder / "experiment.toml").write_text(DOCUMENT + entries, encoding="utf-8")


@pytest.mark.parametrize(
    ("trials", "said"),
    [
        (["rows = { run = 3 }"], "all.csv: it has 0 rows with run = 3; a recording has at least 3"),
        (["rows = { lap = 1 }"], "all.csv: there is no column 'lap' to tell rows by; it has 'time"),
        (['rows = { run = "one" }'], "trials 1.rows: 'run' = 'one'; a number is needed"),
        (["rows = { run = 1 }", "rows = { run = 1 }"], "all.csv is named twice"),
        (["rows = { run = 1 }", ""], "all.csv is named twice"),
    ],
)
def test_rows_that_are_none(tmp_path: Path, trials: list[str], said: str) -> None:
    stacked(tmp_path / "all.csv", {"run": [1, 2]}, [0.01, 0.05])
    documented(tmp_path, *trials)
    with pytest.raises(ExperimentError) as refused:
        read_experiment(tmp_path, MODEL)
    assert said in str(refused.value)


def test_a_row_is_named_as_it_stands_in_the_file(tmp_path: Path) -> None:
    stacked(tmp_path / "all.csv", {"run": [1, 2]}, [0.01, 0.05])
    lines = (tmp_path / "all.csv").read_text(encoding="utf-8").splitlines()
    lines[151] = lines[151].rsplit(",", 1)[0] + ",nan"
    (tmp_path / "all.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    documented(tmp_path, "rows = { run = 1 }", "rows = { run = 2 }")
    with pytest.raises(ExperimentError, match="data row 151: no finite number"):
        read_experiment(tmp_path, MODEL)
