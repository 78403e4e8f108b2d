"""Does the campaign over constants tell those that matter from those that do not, go on where it stopped, and keep what it found?"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest
from evat.commands.main import app
from evat.constants import CONSTANTS
from evat.gap.verdict import sensitivity
from evat.model import EvatError, ParameterError
from evat.studies.calibration import constant_sensitivity as study
from evat.studies.calibration.forks import can_fork
from toy import Toy, measured
from typer.testing import CliRunner

TRIED = ("most_lags", "least_named_probability", "fmu_samples")  # read before the comparison is done, after it, and never
NUMBERS = (1, 2)


@pytest.fixture(scope="module")
def case() -> study.KnownCase:
    return study.KnownCase(measured(["bend"], {"bend.c": 0.3}), "bend", Toy())


@pytest.fixture(scope="module")
def as_it_is(case: study.KnownCase) -> study.Outcome:
    return case.outcome()


def test_a_case_tells_what_it_reads(as_it_is: study.Outcome) -> None:
    assert {"most_lags", "least_named_probability", "temperature"} <= set(as_it_is.reads)
    assert "fmu_samples" not in as_it_is.reads
    assert as_it_is.right
    assert as_it_is.log_loss < 0.3


def test_a_constant_is_replaced_and_nothing_stays_replaced(case: study.KnownCase, as_it_is: study.Outcome) -> None:
    assert case.with_replaced("form_error", 50.0).answer != as_it_is.answer
    wary = case.with_replaced("unknown_offset", 20.0)
    assert wary.answer != as_it_is.answer
    assert wary.log_loss > as_it_is.log_loss + 0.05
    assert case.with_replaced("temperature", 1.0) == replace(as_it_is, reads=())
    assert dict(CONSTANTS.replacements) == {}


FORKED = """
import json, sys
sys.path[:0] = {paths!r}
from toy import Toy, measured
from evat.studies.calibration.constant_sensitivity import KnownCase
case = KnownCase(measured(["bend"], {{"bend.c": 0.3}}), "bend", Toy())
wanted = [(name, factor) for name in {names!r} for factor in (0.5, 2.0)]
held = []
case.each_replaced(wanted, lambda key, outcome: held.append((key, vars(outcome))))
print(json.dumps(held))
"""
READ = ("most_lags", "form_error", "unknown_offset", "least_candidate")


@pytest.mark.skipif(not can_fork(), reason="Windows does not fork")
def test_what_goes_on_from_a_fork_says_what_a_run_from_the_beginning_says(case: study.KnownCase, as_it_is: study.Outcome) -> None:
    """Of constants that are read early and late, and of one that is not: in a process of its own, which has one thread."""
    here = Path(__file__).parent
    script = FORKED.format(paths=[str(here), str(here.parent)], names=[*READ, "fmu_samples"])
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    held = {tuple(key): study.Outcome(**{**outcome, "reads": tuple(outcome["reads"])}) for key, outcome in json.loads(done.stdout)}
    assert held["", 1.0] == as_it_is
    assert len(held) == 1 + 2 * len([*READ, "fmu_samples"])
    for name in READ:
        for factor in study.FACTORS:
            assert held[name, factor] == case.with_replaced(name, factor), (name, factor)
    assert held["fmu_samples", 0.5] == replace(as_it_is, reads=())
    assert sum(held[name, factor].answer != as_it_is.answer for name in READ for factor in study.FACTORS) > 3


def test_no_constant_is_read_before_a_diagnosis_begins() -> None:
    """A default or a number of a module would keep what the constant was when it was imported, and a replaced one would not count."""
    script = """
import importlib, pkgutil
from evat.constants import CONSTANTS
with CONSTANTS.reading() as reads:
    import evat
    for package in ("experiment", "inference", "gap", "models"):
        whole = importlib.import_module(f"evat.{package}")
        for module in pkgutil.walk_packages(whole.__path__, f"evat.{package}."):
            importlib.import_module(module.name)
print(sorted(reads))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.fixture
def ran(as_it_is: study.Outcome, monkeypatch: pytest.MonkeyPatch) -> list[study.Key]:
    """What was really run: the toy stands for every number, and of the second case one constant fails."""
    done = list[study.Key]()

    def run(number: int, wanted: Iterable[tuple[str, float]], tell: Callable[[study.Key, study.Outcome | str], None]) -> None:
        done.append((number, "", 1.0))
        tell((number, "", 1.0), as_it_is)
        for name, factor in wanted:
            done.append((number, name, factor))
            worse = study.Outcome(as_it_is.log_loss + factor, False, "other")
            outcome: study.Outcome | str = as_it_is if name == "fmu_samples" else worse
            tell((number, name, factor), "it does not run" if (number, name) == (2, "most_lags") else outcome)

    monkeypatch.setattr(study, "_run", run)
    monkeypatch.setattr(study, "process_pool", ThreadPoolExecutor)
    return done


def test_a_campaign_goes_on_where_it_stopped_and_leaves_damage_behind(
    ran: list[study.Key], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "sensitivity.jsonl"
    assert len(study.campaign(path, TRIED[:1], 1, NUMBERS)) == 6
    held = study.campaign(path, TRIED, 1, NUMBERS)
    assert len(held) == 14
    assert len(ran) == 6 + 2 + 8  # each case is run once more as it is, since nothing of it is kept but its outcome
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join([*lines[:-1], lines[-1][:40]]), encoding="utf-8")
    assert len(study.outcomes(path)) == 13
    ran.clear()
    assert study.campaign(path, TRIED, 1, NUMBERS) == held
    assert len(ran) == 2
    monkeypatch.setattr(study, "kernel_digest", lambda: "another kernel")
    assert study.outcomes(path) == {}


def test_the_column_is_kept_and_damage_is_told(ran: list[study.Key], tmp_path: Path) -> None:
    held, path = study.campaign(tmp_path / "s.jsonl", TRIED, 1, NUMBERS), tmp_path / "sensitivity.json"
    study.store(held, TRIED[:2], NUMBERS, path)
    study.store(held, TRIED[2:], NUMBERS, path)
    rows = sensitivity.read(path)["constants"]
    assert set(rows) == set(TRIED)
    assert rows["least_named_probability"]["doubled"] == {"value": 0.999, "log_loss": 2.0, "right": -2, "changed": 2, "failed": 0}
    assert rows["most_lags"]["halved"]["failed"] == 1
    assert rows["fmu_samples"]["halved"]["changed"] == rows["fmu_samples"]["read_in"] == 0
    path.write_text(path.read_text(encoding="utf-8")[:100], encoding="utf-8")
    with pytest.raises(EvatError, match="damaged"):
        sensitivity.read(path)
    assert sensitivity.read(tmp_path / "none.json") == {}


def test_fewer_cases_do_not_replace_more(ran: list[study.Key], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    held, path = study.campaign(tmp_path / "s.jsonl", TRIED, 1, NUMBERS), tmp_path / "sensitivity.json"
    study.store(held, TRIED[:2], NUMBERS, path)
    study.store(held, TRIED[1:], NUMBERS[:1], path)
    rows = sensitivity.read(path)["constants"]
    assert all(set(row["made"]) == {"kernel", "table"} for row in rows.values())
    assert {name: row["cases"] for name, row in rows.items()} == dict(zip(TRIED, ([1, 2], [1, 2], [1]), strict=True))
    monkeypatch.setattr(study, "table_digest", lambda: "other values")
    study.store(held, TRIED[1:2], NUMBERS[:1], path)  # what belongs to other values of the constants is no better for its cases
    rows = sensitivity.read(path)["constants"]
    assert [rows[name]["cases"] for name in TRIED] == [[1, 2], [1], [1]]
    assert [rows[name]["made"]["table"] == "other values" for name in TRIED] == [False, True, False]


def test_some_constants_on_some_cases(ran: list[study.Key], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What `evat calibrate --sensitivity` runs where it is asked for a part, and that it stores that part alone."""
    monkeypatch.setattr(study.store, "__defaults__", (study.CASES, tmp_path / "sensitivity.json"))
    how = ["calibrate", "--sensitivity", "--constants", "least_b*", "--cases", "2", "--state", str(tmp_path / "s.jsonl"), "--store"]
    answer = CliRunner().invoke(app, how, catch_exceptions=False)
    assert answer.exit_code == 0, answer.output
    names = [name for name in CONSTANTS.declared() if name.startswith("least_b")]
    assert {key[0] for key in ran} == set(study.CASES[:2])
    assert {key[1] for key in ran} == {"", *names}
    assert {name: row["cases"] for name, row in sensitivity.read(tmp_path / "sensitivity.json")["constants"].items()} == {
        name: list(study.CASES[:2]) for name in names
    }
    with pytest.raises(ParameterError, match="warp"):
        study.named(["least_b*", "warp*"])


def test_a_name_that_is_no_constant_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="warp"):
        study.campaign(tmp_path / "s.jsonl", ["warp"], 1)


@pytest.mark.campaign
def test_each_stored_case_runs_and_most_constants_are_read(tmp_path: Path) -> None:
    held = study.campaign(tmp_path / "s.jsonl", ["temperature"], 2)
    assert len(held) == 3 * len(study.CASES)
    assert not any(isinstance(outcome, str) for outcome in held.values())
    reads = {name for outcome in held.values() if isinstance(outcome, study.Outcome) for name in outcome.reads}
    assert len(reads) > 0.9 * len(CONSTANTS.declared())
