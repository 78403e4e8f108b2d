"""Does anything that stands in somebody's file act on the terminal that shows it? Titles, names of files, columns and parts; markup."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
import warnings
import zipfile
from pathlib import Path

import command_line
import pytest
from evat import console
from evat.console import PrintableConsole, printable
from rich.progress import Progress, TextColumn
from rich.table import Table

TITLE = "\x1b]0 owned\x07"  # a command to the terminal, up to the bell
RED = "\x9b31m"  # the same as ESC [ 31 m, and allowed in XML
CLOSED = "[/nope]"  # markup of nothing that is open, an error to rich
ACTS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
UTF8 = pytest.mark.skipif(sys.platform != "linux", reason="names of files are text there")


def evat(*arguments: str, folder: Path, colour: bool = False) -> str:
    """All that the command prints; with colour as a terminal gets it, from a process of its own, since consoles ask for that once."""
    if not colour:
        shown = command_line.evat(*arguments, folder=folder, columns=200)
        return shown.stdout + shown.stderr
    environment = {**os.environ, "FORCE_COLOR": "1", "COLUMNS": "200", "PYTHONIOENCODING": "utf-8"}
    line = [sys.executable, "-c", "from evat.commands.main import main; main()", *arguments]
    done = subprocess.run(line, cwd=folder, stdout=-1, stderr=-2, env=environment, timeout=120, check=False)
    said = done.stdout.decode()
    assert "Traceback" not in said, said
    return said


DOCUMENT = r"""format = 1
title = "\u001b]0 owned\u0007 [/nope]"
[nominal]
friction = "coulomb"
kinematics = "external"
values = {F_C = 3.0}
[signals.time]
column = "t"
unit = "s"
[signals.slip_velocity]
column = "v \u001b]0 owned\u0007"
unit = "m/s"
role = "input"
[signals.friction_force]
column = "F \u009b31m [/nope]"
unit = "N"
role = "output"
[[trials]]
file = "a.csv"
condition = "\u001b]0 owned\u0007 [/nope]"
"""


@pytest.mark.parametrize("colour", [False, True])
def test_an_experiment(tmp_path: Path, colour: bool) -> None:
    (tmp_path / "experiment.toml").write_text(DOCUMENT, encoding="utf-8")
    (tmp_path / "a.csv").write_text(f"t,v {TITLE},F {RED} [/nope]\n0,1,3\n1,1,3\n2,1,3\n", encoding="utf-8")
    said = evat("experiment", "check", ".", folder=tmp_path, colour=colour)
    assert r"\x1b]0 owned\x07 [/nope]" in said
    assert not any(sign in said for sign in (TITLE, "\x07", "\x9b"))
    assert colour or not ACTS.search(said)
    (tmp_path / "a.csv").write_text(f"t,v {TITLE},F {TITLE}\n0,1,3\n1,1,3\n", encoding="utf-8")
    said = evat("experiment", "check", ".", folder=tmp_path)
    assert "there is no column" in said
    assert not ACTS.search(said)


@UTF8
@pytest.mark.parametrize("name", [TITLE.encode(), b"\xff\xfe", b"[/nope]", b":smile:"])
def test_a_name_of_a_file(tmp_path: Path, name: bytes) -> None:
    """Also one that is no text at all, and one that looks like markup or an emoji: shown as it stands, and written under that name."""
    asked = os.fsdecode(name) + ".csv"
    said = evat("simulate", "--cycles", "1", "--samples", "10", "-o", asked, folder=tmp_path)
    assert f"wrote {printable(asked)}" in said
    assert not ACTS.search(said)
    assert (tmp_path / asked).is_file()
    said = evat("simulate", "-i", asked, "-o", "again.csv", folder=tmp_path)
    assert (f"{printable(asked)}: the file's name is no text (UTF-8); rename it" in said) == (name == b"\xff\xfe")
    said = evat("experiment", "check", os.fsdecode(name), folder=tmp_path)
    assert f"evat: {printable(os.fsdecode(name))}" in said
    assert not ACTS.search(said)


@pytest.mark.parametrize("colour", [False, True])
def test_a_system_and_its_archive(systems: dict[str, Path], tmp_path: Path, colour: bool) -> None:
    with zipfile.ZipFile(systems["stick_slip"]) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    text = files["SystemStructure.ssd"].decode()
    text = re.sub(
        r'version="1.0" name="[^"]*" description="[^"]*"', f'version="1.0" name="{RED}{CLOSED}" description="{RED}{CLOSED}"', text
    )
    files["SystemStructure.ssd"] = text.replace('"drive"', f'"d{CLOSED}"').replace("drive.table", f"d{CLOSED}.table").encode()
    named = {"SystemStructure.ssd": text.replace('"drive"', f'"d{RED}"').replace("drive.table", f"d{RED}.table").encode()}
    for path, more in (
        ("good.ssp", {}),
        ("bad.ssp", {f"../{TITLE}": b"x"}),
        ("worse.ssp", {f"{RED}{CLOSED}.fmu": b"x"}),
        ("worst.ssp", named),
    ):
        with zipfile.ZipFile(tmp_path / path, "w") as packed:
            for name, data in {**files, **more}.items():
                packed.writestr(name, data)
        said = evat("system", "run", path, "--stop", "0.01", "-o", "out.csv", folder=tmp_path, colour=colour)
        assert not any(sign in said for sign in (TITLE, "\x07", "\x9b"))
        assert colour or not ACTS.search(said)
        assert ("wrote out.csv" in re.sub("\x1b\\[[0-9;]*m", "", said)) == (path == "good.ssp")


def test_a_parameter_set(tmp_path: Path) -> None:
    for name, text in {
        "mine.ssv": f'<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="{RED}" '
        f'description="{RED}{CLOSED}"><ssv:Parameters><ssv:Parameter name="F_C" description="{RED}{CLOSED}"><ssv:Real value="1" unit="N"/>'
        "</ssv:Parameter></ssv:Parameters></ssv:ParameterSet>",
        "mine.toml": 'title = "\\u001b]0 owned\\u0007"\n'
        'notes = ["[/nope] \\u009b31m"]\n[values.F_C]\nvalue = 1\nunit = "N"\nsource = "\\u0007"\n',
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        said = evat("sets", name, folder=tmp_path)
        assert r"\x9b31m" in said
        assert "[/nope]" in said
        assert not ACTS.search(said)


def test_the_text_beside_a_bar_and_a_warning_of_a_library(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both come from other places than what is printed."""
    shown = io.StringIO()
    terminal = PrintableConsole(file=shown, force_terminal=True, width=100)
    with Progress(TextColumn("{task.description}", markup=False), console=terminal) as bar:
        bar.add_task(f"running {TITLE}{CLOSED}")
    monkeypatch.setattr(console, "err", terminal)
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    console.show_warnings()
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning(UserWarning(f"no glyph for {TITLE}"), UserWarning, "", 0)
    assert r"running \x1b]0 owned" in shown.getvalue()
    assert r"no glyph for \x1b]0 owned\x07" in shown.getvalue()
    assert "\x1b]" not in shown.getvalue()


def test_columns_stay_in_line() -> None:
    """What is shown for a sign is counted where widths are measured."""
    shown = io.StringIO()
    table = Table("name", "value")
    table.add_row(f"a{TITLE}b", "1")
    table.add_row("plain", "2")
    PrintableConsole(file=shown, width=100).print(table)
    assert len({len(line) for line in shown.getvalue().splitlines()}) == 1


def test_what_writers_use_is_left_as_it_is() -> None:
    text = "µm, °C, 20 °C, 中文, naïve, \t-\n, 🙂, λ → ∞"
    assert printable(text) == text
    assert printable("\u202egpj.exe\u2066") == r"\u202egpj.exe\u2066"
