"""Does the campaign over constants tell those that matter from those that do not, go on where it stopped, and keep what it found?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from evat.commands.main import app
from evat.constants import CONSTANTS
from evat.gap.verdict import sensitivity
from evat.model import EvatError, ParameterError
from evat.studies.calibration import constant_sensitivity as study
from toy import Toy, measured
from typer.testing import CliRunner

TRIED = ("most_lags", "least_named_probability", "fmu_samples")  # read before the comparison is done, after it, and never
NUMBERS = (1, 2)


@pytest.fixture(scope="module")
def case() -> study.KnownCase:
    return study.KnownCase(measured(["bend"], {"bend.c": 0.3}), "bend", Toy)


def test_a_case_tells_what_it_reads_and_when(case: study.KnownCase) -> None:
    assert "most_lags" in case.compared
    assert "least_named_probability" in case.reads - case.compared
    assert "fmu_samples" not in case.reads
    assert case.as_it_is.right
    assert case.as_it_is.log_loss < 0.3


def test_each_constant_is_replaced_where_it_counts(case: study.KnownCase, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, and after what is compared; one that is never read is not tried, and nothing stays replaced."""
    compared = list[object]()

    def counted(self: study.KnownCase) -> Any:
        compared.append(CONSTANTS.replacements)
        return before(self)

    before = study.KnownCase._compared
    monkeypatch.setattr(study.KnownCase, "_compared", counted)
    assert case.with_replaced("form_error", 50.0).answer != case.as_it_is.answer
    assert [dict(replaced) for replaced in compared] == [{"form_error": pytest.approx(3.5)}]  # type: ignore[call-overload]
    wary = case.with_replaced("unknown_offset", 20.0)
    assert wary.answer != case.as_it_is.answer
    assert wary.log_loss > case.as_it_is.log_loss + 0.05
    assert case.with_replaced("fmu_samples", 0.5) == case.as_it_is
    assert len(compared) == 1
    assert case.with_replaced("temperature", 1.0).answer == case.as_it_is.answer
    assert dict(CONSTANTS.replacements) == {}


@pytest.fixture
def ran(case: study.KnownCase, monkeypatch: pytest.MonkeyPatch) -> list[study.Key]:
    """What was really run: the toy stands for every number, and of the second case one constant fails."""
    done = list[study.Key]()

    def run(number: int, wanted: Iterable[tuple[str, float]]) -> Iterator[tuple[study.Key, study.Outcome | str]]:
        done.append((number, "", 1.0))
        yield (number, "", 1.0), case.as_it_is
        for name, factor in wanted:
            done.append((number, name, factor))
            worse = study.Outcome(case.as_it_is.log_loss + factor, False, "other")
            outcome: study.Outcome | str = case.as_it_is if name == "fmu_samples" else worse
            yield (number, name, factor), "it does not run" if (number, name) == (2, "most_lags") else outcome

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


def test_fewer_cases_do_not_replace_more(ran: list[study.Key], tmp_path: Path) -> None:
    held, path = study.campaign(tmp_path / "s.jsonl", TRIED, 1, NUMBERS), tmp_path / "sensitivity.json"
    study.store(held, TRIED[:2], NUMBERS, path)
    study.store(held, TRIED[1:], NUMBERS[:1], path)
    rows = sensitivity.read(path)["constants"]
    assert {name: row["cases"] for name, row in rows.items()} == dict(zip(TRIED, ([1, 2], [1, 2], [1]), strict=True))


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
def test_the_stored_cases_are_what_they_are_said_to_be(tmp_path: Path) -> None:
    """A dozen, each of which runs; a constant of the judgement alone takes no second comparison."""
    held = study.campaign(tmp_path / "s.jsonl", ["temperature"], 2)
    assert len(held) == 3 * len(study.CASES)
    assert not any(isinstance(outcome, str) for outcome in held.values())
