"""Is a search that was stopped, or killed at any moment, brought to the result that it would have had, and does nothing else change it?"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.identification import Execution, Identification, Settings, identify
from evat.identification.searching.journal import Journal, JournalError
from evat.identification.searching.search import Search, search
from evat.models.contact import ContactModel
from known_rigs import FREE, MODEL, TO_AND_FRO, experiment, trial
from threadpoolctl import threadpool_info, threadpool_limits

RIG = experiment(trial(TO_AND_FRO[:300]))
SETTINGS = {"population": 24, "generations": 12, "seed": 3, "profiles": False}


def same(one: Identification, other: Identification) -> bool:
    """To the last bit, but for the time it took."""
    return (
        [e.value for e in one.estimates] == [e.value for e in other.estimates] and one.history == other.history and one.cost == other.cost
    )


@pytest.mark.parametrize("kind", ["ga", "de"])
def test_a_search_that_was_cut_off_goes_on_to_the_same_result(kind: Search, tmp_path: Path) -> None:
    """Cut after each of several generations, and in the middle of a line; what the journal holds is not calculated again."""
    whole = identify(RIG, MODEL, FREE, Settings(search=kind, **SETTINGS), execution=Execution(journal=tmp_path / "whole"))  # type: ignore[arg-type]
    lines = (tmp_path / "whole").read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + len(whole.history)
    for held, torn in ((0, 0), (1, 7), (5, 300), (12, 0)):
        cut = tmp_path / f"{held}-{torn}"
        cut.write_bytes(b"".join(lines[: 1 + held]) + (lines[1 + held][:torn] if torn else b""))
        identification = identify(RIG, MODEL, FREE, Settings(search=kind, **SETTINGS), execution=Execution(journal=cut, resume=True))  # type: ignore[arg-type]
        assert same(identification, whole)
        assert cut.read_bytes() == (tmp_path / "whole").read_bytes()


def test_a_journal_is_read_instead_of_calculated(tmp_path: Path) -> None:
    """With costs that count: a resumed search asks for the missing generations only."""
    asked = []

    def costs(points: np.ndarray) -> np.ndarray:
        asked.append(len(points))
        return np.sum((points - 0.3) ** 2, axis=1)

    facts = {"a": 1}
    settings = {"population": 20, "generations": 10, "seed": 1}
    begun = [0]

    def five() -> bool:
        begun[0] += 1
        return begun[0] > 5

    first = search("ga", costs, np.full(3, 0.9), journal=Journal(tmp_path / "j", facts, False), cancelled=five, **settings)  # type: ignore[arg-type]
    assert first.stopped
    assert len(asked) == 5
    second = search("ga", costs, np.full(3, 0.9), journal=Journal(tmp_path / "j", facts, True), **settings)  # type: ignore[arg-type]
    assert len(asked) == 10
    alone = search("ga", costs, np.full(3, 0.9), **settings)  # type: ignore[arg-type]
    assert np.array_equal(alone.point, second.point)
    assert second.cost < 1e-2


def test_a_journal_of_another_search_is_refused(tmp_path: Path) -> None:
    identify(RIG, MODEL, FREE, Settings(**SETTINGS), execution=Execution(journal=tmp_path / "j"))  # type: ignore[arg-type]
    with pytest.raises(JournalError, match="of another search, which differs in seed"):
        identify(RIG, MODEL, FREE, Settings(**{**SETTINGS, "seed": 4}), execution=Execution(journal=tmp_path / "j", resume=True))  # type: ignore[arg-type]
    with pytest.raises(JournalError, match="differs in bounds"):
        identify(
            RIG, MODEL, FREE, Settings(bounds={"F_C": (1.0, 30.0)}, **SETTINGS), execution=Execution(journal=tmp_path / "j", resume=True)
        )  # type: ignore[arg-type]


def test_a_journal_of_other_data_is_refused(tmp_path: Path) -> None:
    """An experiment that was made in memory has no file by which to tell: costs of other records were taken on silently."""
    identify(RIG, MODEL, FREE, Settings(**SETTINGS), execution=Execution(journal=tmp_path / "j"))  # type: ignore[arg-type]
    louder = tuple(replace(trial, outputs={name: 2 * column for name, column in trial.outputs.items()}) for trial in RIG.trials)
    with pytest.raises(JournalError, match="differs in recorded"):
        identify(replace(RIG, trials=louder), MODEL, FREE, Settings(**SETTINGS), execution=Execution(journal=tmp_path / "j", resume=True))  # type: ignore[arg-type]


@pytest.mark.parametrize("stated", [{"values": {"F_S": 12.0}}, {"noise_sd": {"friction_force": 5.0}}])
def test_a_journal_of_what_was_stated_otherwise_is_refused(tmp_path: Path, stated: dict[str, dict[str, float]]) -> None:
    """Of the same records: with other costs where a trial has a value of its own, or a noise, which a search went on from."""
    free, settings = ["F_C", "sigma2"], Settings(**SETTINGS)  # type: ignore[arg-type]
    identify(RIG, MODEL, free, settings, execution=Execution(journal=tmp_path / "j"))
    otherwise = replace(RIG, trials=tuple(replace(trial, **stated) for trial in RIG.trials))
    with pytest.raises(JournalError, match="differs in recorded"):
        identify(otherwise, MODEL, free, settings, execution=Execution(journal=tmp_path / "j", resume=True))


@pytest.mark.parametrize("damage", ["empty", "torn", "a bit", "the sum", "not UTF-8", "no journal"])
def test_a_damaged_head_of_a_journal_is_said_to_be_damaged(tmp_path: Path, damage: str) -> None:
    """Not to be of another search with all of its facts changed; and the journal stays as it is."""
    path, facts = tmp_path / "j", {"seed": 3, "bounds": {"F_C": [1.0, 30.0]}}
    Journal(path, facts, resume=False).keep(np.zeros((2, 1)), np.ones(2))
    whole = path.read_bytes()
    head, line = whole.splitlines(keepends=True)
    hurt = {
        "empty": b"",
        "torn": head[: len(head) // 2],
        "a bit": head.replace(b'"seed": 3', b'"seed": 2') + line,
        "the sum": b"0" * 8 + head[8:] + line,
        "not UTF-8": b"\xff" + head[1:] + line,
        "no journal": b"no journal at all\n",
    }[damage]
    path.write_bytes(hurt)
    with pytest.raises(JournalError, match="j: the first line of this journal is damaged"):
        Journal(path, facts, resume=True)
    assert path.read_bytes() == hurt


KILLED = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_long_runs import RIG, SETTINGS, FREE, MODEL, Execution, Settings, identify
settings = Settings(search="de", **{**SETTINGS, "generations": 60})
identify(RIG, MODEL, FREE, settings, execution=Execution(journal=Path(sys.argv[1]), resume=True))
"""


@pytest.mark.slow
def test_kill_9_loses_at_most_one_generation(tmp_path: Path) -> None:
    """A process of its own, killed again and again while it searches."""
    path, survived = tmp_path / "journal", 0
    here = str(Path(__file__).resolve().parent)
    for _ in range(3):
        process = subprocess.Popen([sys.executable, "-c", KILLED, str(path), here])
        begin = time.monotonic()
        while time.monotonic() - begin < 60 and process.poll() is None:
            lines = path.read_bytes().count(b"\n") if path.is_file() else 0
            if lines > survived + 4:
                break
            time.sleep(0.002)
        if process.poll() is None:
            os.kill(process.pid, signal.SIGKILL)
        process.wait()
        left = path.read_bytes().count(b"\n")
        assert left >= lines  # what was in the journal before the signal is in it after
        survived = left
    settings = {**SETTINGS, "generations": 60}
    resumed = identify(RIG, MODEL, FREE, Settings(search="de", **settings), execution=Execution(journal=path, resume=True))  # type: ignore[arg-type]
    assert same(resumed, identify(RIG, MODEL, FREE, Settings(search="de", **settings)))  # type: ignore[arg-type]


def test_the_same_seed_gives_the_same_result_with_any_number_of_threads() -> None:
    identifications = [identify(RIG, ContactModel(threads=threads), FREE, Settings(search="ga", **SETTINGS)) for threads in (1, 2, 3)]  # type: ignore[arg-type]
    assert same(identifications[0], identifications[1])
    assert same(identifications[0], identifications[2])
    other = identify(RIG, MODEL, FREE, Settings(search="ga", **{**SETTINGS, "seed": 4}))  # type: ignore[arg-type]
    assert other.history != identifications[0].history


def test_algebra_has_one_thread_whatever_the_caller_has() -> None:
    """Two made some thousand rows of six columns take thirty times as long."""
    threads = set[int]()

    def look() -> bool:
        if not threads:
            threads.update(pool["num_threads"] for pool in threadpool_info())
        return False

    with threadpool_limits(2):
        identify(RIG, MODEL, FREE, Settings(search="none", profiles=False), execution=Execution(cancelled=look))
        assert 2 in {pool["num_threads"] for pool in threadpool_info()}
    assert threads == {1}


def test_stopping_gives_the_best_so_far() -> None:
    count = [0]

    def after_four() -> bool:
        count[0] += 1
        return count[0] > 4

    told = []
    identification = identify(
        RIG,
        MODEL,
        FREE,
        Settings(search="ga", **SETTINGS),
        execution=Execution(cancelled=after_four, progress=lambda what, share: told.append((what, share))),
    )
    assert identification.stopped
    assert len(identification.history) == 4
    assert all(np.isnan(estimate.low) for estimate in identification.estimates)
    assert [share for what, share in told if what.startswith("search")] == [place / 12 for place in range(1, 5)]
