"""Does the command line keep the habits of others: near names, typos before data, JSON, quiet, a log, a stop that leaves nothing behind?"""

from __future__ import annotations

import dataclasses
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import command_line
import evat
import numpy as np
import pytest
import typer
from evat.commands.main import COMMANDS, _for_all_first, app, loaded, main
from evat.commands.shared import picture_beside, stoppable
from evat.experiment import SetupSd
from evat.experiment.compression import read_or_compress
from evat.files.writing import OutputError, put
from evat.native import kernel
from evat.processes import process_pool
from evat.systems.couple import Coupled, plan
from evat.systems.model import SystemInterrupted
from evat.systems.ssp.read import read
from typer.testing import CliRunner


def said(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.stdout, str(result.exception or "") + result.stderr


@pytest.mark.parametrize(
    ("arguments", "near"),
    [
        (("check", "rig"), "Did you mean 'experiment check'?"),
        (("info", "lugr"), "did you mean lugre"),
        (("info", "nosuch"), "`evat info` lists the 3"),
        (("info", "SIGMA0"), "did you mean sigma0"),
        (("sets", "regularized/copper"), "did you mean regularised/copper"),
        (("simulate", "--law", "dahll"), "did you mean dahl"),
        (("simulate", "-e", "thermal_softning"), "did you mean thermal_softening"),
        (("simulate", "--principle", "minimal_energy"), "did you mean minimum_energy"),
        (("experiment", "orthogonal", "--motion", "revrsal", "-o", "x"), "did you mean reversal"),
        (("experiment", "example", "rigs", "-o", "x"), "did you mean rig"),
        (("identify", "nowhere", "-f", "F_CC"), "did you mean F_C"),  # before the experiment is looked for
        (("identify", "nowhere", "-f", "F_C", "-e", "sensor_gian"), "did you mean sensor_gain"),
        (("identify", "nowhere", "-f", "F_C", "--search", "gaa"), "did you mean ga"),
        (("diagnose", "nowhere", "--explain", "run_outs"), "did you mean run_out"),
    ],
)
def test_a_name_that_is_nearly_right_is_told_before_anything_is_read(
    arguments: tuple[str, ...], near: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    _, _, complaint = said(*arguments)
    assert near in complaint
    assert list(tmp_path.iterdir()) == []


def test_check_identify_and_diagnose_give_one_answer_on_a_gap_in_a_clock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=1, speeds=[0.5], rate=100.0)
    rig = evat.write_experiment(made, tmp_path / "rig")
    (recorded,) = (rig / "trials").iterdir()
    head, *rows = recorded.read_text(encoding="utf-8").splitlines()
    rig_commands = (("experiment", "check", str(rig)), ("identify", str(rig), "-f", "F_C"), ("diagnose", str(rig), "--no-fmu"))

    def answers(jump: int) -> set[tuple[int, str]]:
        recorded.write_text("\n".join([head, *rows[:10], *rows[10 + jump :]]), encoding="utf-8")
        told = [said(*command) for command in rig_commands[: 3 if jump > 100 else 1]]
        return {(code, complaint.strip()) for code, _, complaint in told}

    skipped = "the clock skips 0.51 s after sample 10 (t = 0.09 s), where its usual step is 0.01 s"
    ((code, complaint),) = answers(50)
    assert code == 0
    assert skipped in complaint
    (doubt,) = read_or_compress(rig, evat.ContactModel())[1]  # which identify and diagnose tell
    assert skipped in doubt
    recorded.write_text("\n".join([head, *rows[:60], *rows[60::20]]), encoding="utf-8")  # thinned, not cut: nothing is lost
    code, _, complaint = said(*rig_commands[0])
    assert (code, complaint.strip()) == (0, "")
    ((code, complaint),) = answers(150)
    assert code == 1
    assert "the clock jumps by 1.51 s after sample 10 (t = 0.09 s)" in complaint
    assert "cut the file there into two trials" in complaint


def test_check_asks_whether_a_large_zero_is_in_the_unit_of_its_column(tmp_path: Path) -> None:
    """In newtons, of a motor's current: 32 N of 68 N passed without a word."""
    made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=1, speeds=[0.5], rate=100.0)
    for zero, asked in ((0.1, False), (1.2, True)):
        stated = dataclasses.replace(made, setup_sd={"friction_force": SetupSd(zero=zero)})
        code, _, complaint = said("experiment", "check", str(evat.write_experiment(stated, tmp_path / f"rig {zero}")))
        assert code == 0
        assert ("setup_sd.friction_force.zero lets its zero be off by 1.2 N" in complaint) == asked
        assert ("It is in the unit of the column, N: is that meant?" in complaint) == asked


@pytest.mark.parametrize(("typed", "offered"), [("evat system ", {"run", "sweep"}), ("evat identify --se", {"--search", "--seed"})])
def test_a_shell_completes_commands_and_options_that_are_not_loaded_yet(typed: str, offered: set[str]) -> None:
    """As a shell asks the installed command: by the words so far and the place of the one that is typed."""
    asked = {"_EVAT_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": "2"}
    script = "import sys; sys.argv = ['/usr/bin/evat']; from evat.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", script], env={**os.environ, **asked}, capture_output=True, text=True, check=False)
    assert offered <= set(done.stdout.split())
    assert all(word.startswith(typed.split(" ")[-1]) for word in done.stdout.split())


def test_a_table_of_a_kind_that_is_not_written_is_refused_before_work(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"kind '.xlsx' cannot be written; name it .csv or .parquet"):
        picture_beside(tmp_path / "out.xlsx")
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(OutputError, match="this is a folder"):
        picture_beside(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("command", "work"),
    [
        (("experiment", "compress", "RIG", "-o"), "evat.experiment.compression.compress_experiment"),
        (("experiment", "example", "rig", "-o"), "evat.studies.examples.write_example"),
        (("experiment", "orthogonal", "-v", "F_C=8", "-o"), "evat.studies.orthogonal.orthogonal"),
        (("effects", "run_out", "-o"), "evat.signature.signature"),
        (("calibrate", "-o"), "evat.studies.calibration.campaign.campaign"),
    ],
)
def test_a_place_that_cannot_be_written_is_told_before_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], work: str
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setattr(work, lambda *_, **__: pytest.fail("it worked first"))
    status, _, complaints = command_line.typed(*command, str(tmp_path / "file" / "out.png"))
    assert status == 2
    assert "cannot be written" in complaints


@pytest.mark.parametrize("command", [("info", "F_C"), ("info",), ("sets",), ("sets", "published/copper"), ("experiment", "advise")])
def test_json_is_all_that_is_printed(command: tuple[str, ...]) -> None:
    code, printed, _ = said(*command, "--json")
    assert code == 0
    assert json.loads(printed)


def test_the_json_of_a_run_has_numbers_units_and_files(tmp_path: Path) -> None:
    to = tmp_path / "a.csv"
    code, printed, _ = said("simulate", "--law", "coulomb", "--cycles", "1", "--samples", "20", "-o", str(to), "--json")
    answer = json.loads(printed)
    assert code == 0
    assert answer["mean"]["mean_feed_force"]["unit"] == "N"
    assert Path(answer["table"]) == to
    assert to.is_file()


def test_info_cuts_no_name_at_any_width(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("evat.console.out._width", 60)
    _, printed, _ = said("info")
    assert max(map(len, printed.splitlines())) <= 60
    for name in (variable.name for variable in kernel.variables() if len(variable.name) < 55):
        assert name in printed
    assert "…" not in printed


def test_quiet_says_nothing_and_a_log_file_all(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "logs" / "evat.log"
    monkeypatch.setattr("sys.argv", ["evat", "sets", "published/copper", "--quiet", "--log-file", str(log)])
    with pytest.raises(SystemExit):
        main()
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "")
    kept = log.read_text(encoding="utf-8")
    assert re.match(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d evat sets published/copper", kept)
    assert "effects on: " in kept


def test_a_check_says_what_is_taken_off_the_force_and_how_bristles_begin(tmp_path: Path) -> None:
    rig = evat.write_experiment(
        evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=1, speeds=[0.5], rate=100.0), tmp_path / "rig"
    )
    document = rig / "experiment.toml"
    plain = document.read_text(encoding="utf-8")
    assert "off the friction force" not in said("experiment", "check", str(rig))[1]
    document.write_text(plain.replace("[nominal]\n", "[nominal]\nmass = 4.5\ngravity_load = -2.0\n"), "utf-8")
    printed = " ".join(said("experiment", "check", str(rig))[1].split())
    assert "off the friction force goes what moves: 4.5 kg, -2 N of load; bristles begin relaxed" in printed


def test_verbose_tells_stages_with_the_time(tmp_path: Path) -> None:
    rig = evat.write_experiment(
        evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=1, speeds=[0.5], rate=100.0), tmp_path / "rig"
    )
    _, _, told = said("--verbose", "experiment", "check", str(rig))
    assert re.search(r"\d\d:\d\d:\d\d checking rig: \d", told)


def test_options_for_all_commands_may_stand_anywhere() -> None:
    typed = ["system", "run", "a.ssp", "--quiet", "--log-file", "x", "-v", "a.b=1"]
    assert _for_all_first(typed) == ["--quiet", "--log-file", "x", "system", "run", "a.ssp", "-v", "a.b=1"]
    assert _for_all_first(["sets", "--", "--quiet"]) == ["sets", "--", "--quiet"]


def test_the_statuses_are_told_in_the_help() -> None:
    _, printed, _ = said("--help")
    assert re.search(r"status 0 when all is well, 1 .* 2 .* 130", " ".join(printed.split()))


def interrupt_after(seconds: float) -> None:
    threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()


def test_ctrl_c_stops_a_long_run_of_the_kernel() -> None:
    """One call of C, which no signal reaches: 1e7 samples take seconds."""
    times = np.arange(10_000_000) * 1e-6
    interrupt_after(0.5)
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        evat.simulate({"friction_law": "lugre"}, times=times, outputs=("friction_force",))
    assert time.monotonic() - began < 3


def sleep(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def test_ctrl_c_leaves_no_process_behind() -> None:
    before = set(multiprocessing.active_children())
    interrupt_after(0.5)
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), process_pool(2) as pool:
        list(pool.map(sleep, [60.0, 60.0]))
    assert time.monotonic() - began < 3
    assert set(multiprocessing.active_children()) == before


def test_ctrl_c_keeps_what_a_system_has_shown(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["stick_slip"], tmp_path / "in")

    shares: list[float] = []

    def stop(share: float) -> None:
        shares.append(share)
        if share > 0.01:
            raise KeyboardInterrupt

    with Coupled(system) as coupled, pytest.raises(SystemInterrupted) as stopped:
        coupled.run(plan(system, 1e-4, 10.0, every=10), stop)
    trace = stopped.value.trace
    assert shares[-1] < 1
    assert trace.times[-1] == pytest.approx(round(1e5 * shares[-1]) // 10 * 1e-3)  # each tenth step is kept
    assert all(column.size == trace.times.size for column in trace.values())


def test_ctrl_c_reaches_a_system_between_its_compiled_steps(systems: dict[str, Path], tmp_path: Path) -> None:
    """A signal, where nobody is told of the progress: 1e7 steps take more than ten seconds."""
    system = read(systems["stick_slip"], tmp_path / "in")
    with Coupled(system) as coupled:
        interrupt_after(0.5)
        began = time.monotonic()
        with pytest.raises(SystemInterrupted) as stopped:
            coupled.run(plan(system, 1e-5, 100.0, every=100))
    assert time.monotonic() - began < 3
    trace = stopped.value.trace
    assert 0 < trace.times[-1] < 100
    assert trace.times == pytest.approx(np.arange(trace.times.size) * 1e-3)
    assert all(np.all(np.isfinite(column)) and column.size == trace.times.size for column in trace.values())


def test_a_stop_is_asked_for_once(capsys: pytest.CaptureFixture[str]) -> None:
    with stoppable(lambda: "nothing") as asked:
        assert not asked()
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.05)
        assert asked()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert not any(isinstance(each, threading.Timer) and not each.finished.is_set() for each in threading.enumerate())  # none ends it later
    with stoppable(lambda: "nothing"):
        pass
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert capsys.readouterr().err == ""  # it came to its end in time


def test_everything_that_answers_answers_as_json() -> None:
    """All commands but those that only write a folder or open a browser."""
    silent = {"guide", "experiment orthogonal", "experiment example"}

    def commands(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
        for name, listed in group.commands.items():
            command = loaded(name) if not before and name in COMMANDS else listed
            if hasattr(command, "commands"):
                yield from commands(command, f"{before}{name} ")
            else:
                yield before + name, command

    answering = dict(commands(typer.main.get_command(app)))
    without = {name for name, command in answering.items() if not any("--json" in each.opts for each in command.params)}
    assert without == silent
    assert len(answering) > 15


def test_a_benchmark_tells_its_verdicts_as_json(tmp_path: Path) -> None:
    """Of answers that are there already, which are kept."""
    for name in ("a", "b"):
        put(tmp_path / "cases" / name / "experiment.toml", "format = 1")
        put(tmp_path / "out" / name / "diagnosis.json", json.dumps({"verdict": "no_gap"}))
    code, printed, _ = said("benchmark", str(tmp_path / "cases"), "-o", str(tmp_path / "out"), "--workers", "1", "--json")
    assert code == 0
    assert json.loads(printed)["verdicts"] == {"a": "no_gap", "b": "no_gap"}
