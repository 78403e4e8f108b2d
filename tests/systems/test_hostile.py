"""What does a broken or hostile .ssp get? A clear error, and nothing written outside."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import evat
import numpy as np
import pytest
from coupled import run
from evat.files import unpack
from evat.files.table import read_table
from evat.model import EvatError, FmuError, ParameterError, Run
from evat.models.drive import Driver
from evat.systems.couple import Coupled, Given, plan
from evat.systems.model import SspError, SystemStopped
from evat.systems.ssp import write_full
from evat.systems.ssp.read import read
from evat.systems.sweep import axis, check_axes
from evat.systems.values import from_set, record, typed
from typer.testing import CliRunner

SSD = "SystemStructure.ssd"


@pytest.fixture
def remade(systems: dict[str, Path], tmp_path: Path) -> Callable[..., Path]:
    """stick_slip.ssp with its files changed: a dict of replacements, or None to leave one out."""

    def make(changed: dict[str, bytes | None], words: dict[str, str] | None = None) -> Path:
        with zipfile.ZipFile(systems["stick_slip"]) as packed:
            files: dict[str, bytes | None] = {name: packed.read(name) for name in packed.namelist()}
        for old, new in (words or {}).items():
            text = (files[SSD] or b"").decode()
            assert old in text
            files[SSD] = text.replace(old, new, 1).encode()
        files |= changed
        path = tmp_path / "remade.ssp"
        with zipfile.ZipFile(path, "w") as packed:
            for name, data in files.items():
                if data is not None:
                    packed.writestr(name, data)
        return path

    return make


def refused(path: Path, tmp_path: Path, match: str) -> None:
    folder = tmp_path / "deep" / "inside"
    folder.mkdir(parents=True)
    before = {each for each in tmp_path.rglob("*") if not each.is_relative_to(folder)}
    with pytest.raises(SspError, match=match):
        read(path, folder)
    assert {each for each in tmp_path.rglob("*") if not each.is_relative_to(folder)} == before


@pytest.mark.parametrize("name", ["../escaped.txt", "resources/../../escaped.txt", "/tmp/escaped.txt", "..\\escaped.txt", "C:/escaped.txt"])
def test_a_path_that_leaves_the_archive(remade: Callable[..., Path], tmp_path: Path, name: str) -> None:
    refused(remade({name: b"x"}), tmp_path, "outside of the archive's folder")
    assert not Path("/tmp/escaped.txt").exists()


def test_a_link(remade: Callable[..., Path], tmp_path: Path) -> None:
    path = remade({})
    with zipfile.ZipFile(path, "a") as packed:
        entry = zipfile.ZipInfo("resources/link")
        entry.create_system, entry.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
        packed.writestr(entry, "/etc/passwd")
    refused(path, tmp_path, "is a link")


def test_an_fmu_that_would_write_outside(remade: Callable[..., Path], systems: dict[str, Path], tmp_path: Path) -> None:
    inner = tmp_path / "inner.fmu"
    with zipfile.ZipFile(systems["stick_slip"]) as packed:
        inner.write_bytes(packed.read("resources/EvatFeedDrive.fmu"))
    with zipfile.ZipFile(inner, "a") as packed:
        packed.writestr("../../escaped-from-fmu.txt", "x")
    refused(remade({"resources/EvatFeedDrive.fmu": inner.read_bytes()}), tmp_path, "component drive.*outside of the archive's folder")


def test_no_archive_at_all(tmp_path: Path) -> None:
    path = tmp_path / "text.ssp"
    path.write_text("no zip")
    refused(path, tmp_path, "corrupt or no ZIP")


def test_an_archive_that_is_cut_or_corrupt(systems: dict[str, Path], tmp_path: Path) -> None:
    whole = systems["stick_slip"].read_bytes()
    (tmp_path / "cut.ssp").write_bytes(whole[: len(whole) // 2])
    refused(tmp_path / "cut.ssp", tmp_path, "corrupt or no ZIP")
    spoilt = bytearray(whole)
    spoilt[len(whole) // 3 : len(whole) // 3 + 2000] = b"\0" * 2000
    (tmp_path / "spoilt.ssp").write_bytes(bytes(spoilt))
    with pytest.raises(SspError, match="corrupt or no ZIP"):
        read(tmp_path / "spoilt.ssp", tmp_path / "spoilt")


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "bomb.ssp"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        for n in range(5000):
            packed.writestr(f"{n}", b"")
    refused(path, tmp_path, "it unpacks to more than")


def packed_with(extra: Callable[[zipfile.ZipFile], None], base: Path, to: Path) -> bytes:
    """An archive with more in it."""
    to.write_bytes(base.read_bytes())
    with zipfile.ZipFile(to, "a", zipfile.ZIP_DEFLATED) as packed:
        extra(packed)
    return to.read_bytes()


def bomb(packed: zipfile.ZipFile) -> None:
    """400 MiB that take 0.4."""
    with packed.open("resources/zeros", "w") as entry:
        for _ in range(400):
            entry.write(b"\0" * 2**20)


def test_a_bomb_in_an_fmu_in_the_archive_is_not_unpacked(remade: Callable[..., Path], fmus: dict[str, Path], tmp_path: Path) -> None:
    inner = packed_with(bomb, fmus["evat_guideway-fmi2"], tmp_path / "inner.fmu")
    assert len(inner) < 2**20 + fmus["evat_guideway-fmi2"].stat().st_size
    refused(
        remade({"resources/EvatGuideway.fmu": inner}), tmp_path, r"component guideway, EvatGuideway.fmu: .* unpacks to 40\d MiB; .*bomb"
    )
    with pytest.raises(FmuError, match=r"inner.fmu: .* unpacks to 40\d MiB; .*bomb"):
        Driver(tmp_path / "inner.fmu", {})


def test_what_lies_in_one_another_counts_as_one(systems: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit of the whole is just above what the archive itself takes; an FMU in it takes more than the rest."""
    with zipfile.ZipFile(systems["stick_slip"]) as packed:
        monkeypatch.setattr(unpack, "MOST_BYTES", sum(entry.file_size for entry in packed.infolist()) + 100_000)
    refused(systems["stick_slip"], tmp_path, "component .*: with it, archives that lie in one unpack to more than")


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize(
    ("first", "second"), [("a.txt", "a.txt"), ("a.txt", "./a.txt"), ("a.txt", "a.txt/b.txt"), ("a/b.txt", "a"), ("a.txt", "A.TXT")]
)
def test_a_name_that_is_there_twice(remade: Callable[..., Path], fmus: dict[str, Path], tmp_path: Path, first: str, second: str) -> None:
    """One reader would take the first, another the second: what was looked at is then not what runs."""

    def twice(packed: zipfile.ZipFile) -> None:
        packed.writestr(first, "one")
        packed.writestr(second, "two")

    path = tmp_path / "twice.ssp"
    packed_with(twice, remade({}), path)
    refused(path, tmp_path, "is there twice")
    inner = packed_with(twice, fmus["evat_guideway-fmi2"], tmp_path / "inner.fmu")
    with pytest.raises(SspError, match=r"component guideway, EvatGuideway.fmu: the entry .* is there twice"):
        read(remade({"resources/EvatGuideway.fmu": inner}), tmp_path / "two")
    with pytest.raises(FmuError, match="is there twice"):
        Driver(tmp_path / "inner.fmu", {})


def flagged(packed: bytes, header: bytes, place: int, byte: int) -> bytes:
    """An archive with a byte of the head of its first entry changed."""
    at = packed.index(header) + place
    return packed[:at] + bytes([byte]) + packed[at + 1 :]


@pytest.mark.parametrize(
    ("header", "place", "byte", "match"),
    [
        (b"PK\1\2", 8, 1, "the entry .* is encrypted; pack the archive without a password"),
        (b"PK\1\2", 8, 0x41, "the entry .* is encrypted; pack the archive without a password"),
        (b"PK\1\2", 10, 99, "the entry .* is packed by method 99, which is not read; repack it with Deflate"),
    ],
)
def test_what_is_sound_and_cannot_be_unpacked_is_not_called_corrupt(
    systems: dict[str, Path], tmp_path: Path, header: bytes, place: int, byte: int, match: str
) -> None:
    path = tmp_path / "other.ssp"
    path.write_bytes(flagged(systems["stick_slip"].read_bytes(), header, place, byte))
    refused(path, tmp_path, rf"^other.ssp: {match}\.$")


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("resources/\x1b[31mred", r"the entry 'resources/\\x1b\[31mred' has control characters in its name"),
        ("resources/" + "a" * 300, "the entry 'resources/a{70}' has a name of 300 bytes, and no disk takes more than 255; rename it"),
    ],
)
def test_a_name_that_no_disk_or_terminal_takes(remade: Callable[..., Path], tmp_path: Path, name: str, match: str) -> None:
    refused(remade({name: b"x"}), tmp_path, match)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no file's size")
@pytest.mark.parametrize("what", ["a system", "an FMU"])
def test_a_temporary_disk_that_is_full_is_not_the_archives_fault(
    systems: dict[str, Path], fmus: dict[str, Path], tmp_path: Path, what: str
) -> None:
    """The size of files is limited instead, to half of the largest one."""
    path = systems["stick_slip"] if what == "a system" else fmus["evat_guideway-fmi2"]
    with zipfile.ZipFile(path) as packed:
        largest = max(entry.file_size for entry in packed.infolist())
    code = f"""
import resource
from pathlib import Path
from evat.models.drive import Driver
from evat.systems.ssp.read import read
resource.setrlimit(resource.RLIMIT_FSIZE, ({largest // 2},) * 2)
path = Path({str(path)!r})
read(path, Path({str(tmp_path / "unpacked")!r})) if {what == "a system"} else Driver(path, {{}}).__enter__()
"""
    (tmp_path / "small").mkdir()
    here = {**os.environ, "TMPDIR": str(tmp_path / "small")}
    command = [sys.executable, "-B", "-c", code]  # Python would keep half of a compiled module
    done = subprocess.run(command, capture_output=True, text=True, env=here, timeout=120, check=False)
    assert "evat.files.writing.OutputError: " in done.stderr
    assert "cannot be written: File too large" in done.stderr
    assert "corrupt" not in done.stderr
    assert ("TMPDIR" in done.stderr) == (what == "an FMU")
    assert list((tmp_path / "small").iterdir()) == []


def test_no_system_in_it(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(remade({SSD: None}), tmp_path, "there is no SystemStructure.ssd")


def test_a_missing_fmu(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(remade({"resources/EvatGuideway.fmu": None}), tmp_path, "component guideway: the FMU resources/EvatGuideway.fmu is missing")


def test_a_missing_parameter_file(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(remade({"resources/drive.ssv": None}), tmp_path, "component drive: the parameter file resources/drive.ssv is missing")


def test_an_fmu_that_is_none(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(
        remade({"resources/EvatGuideway.fmu": b"nothing"}), tmp_path, "component guideway, EvatGuideway.fmu: this archive cannot be read"
    )


def test_a_source_outside(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(remade({}, {'source="resources/EvatGuideway.fmu"': 'source="../EvatGuideway.fmu"'}), tmp_path, "lies outside of the archive")


def test_entities_and_broken_xml(remade: Callable[..., Path], tmp_path: Path) -> None:
    bomb = b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "b">]><x>&a;</x>'
    refused(remade({SSD: bomb}), tmp_path, "document type declaration")
    with pytest.raises(SspError, match="no readable XML"):
        read(remade({SSD: b"<ssd:"}), tmp_path / "two")
    with pytest.raises(SspError, match=r"line .*not valid by the schema"):
        read(remade({}, {"<ssd:Connections>": "<ssd:Connections><ssd:Wire/>"}), tmp_path / "three")


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('<evat:system step="0.001" every="1">', '<evat:system every="1">', r"line \d+: step is missing; a finite number"),
        ('<evat:system step="0.001"', '<evat:system step="abc"', r"line \d+: step = 'abc'; a finite number"),
        ('<evat:system step="0.001"', '<evat:system step="1e999"', r"line \d+: step = '1e999'; a finite number"),
        ('every="1"', 'every="often"', r"line \d+: every = 'often'; a whole number from 1"),
        ('every="1"', 'every="0"', r"line \d+: every = '0'; a whole number from 1"),
        ('every="1"', 'every="1.5"', r"line \d+: every = '1.5'; a whole number from 1"),
        ('every="1"', 'every="1e99"', r"line \d+: every = '1e99'; a whole number from 1"),
        ('stopTime="20.0"', 'stopTime="INF"', r"line \d+: stopTime = 'INF'; a finite number"),
        ('startTime="0.0"', 'startTime="-INF"', r"line \d+: startTime = '-INF'; a finite number"),
        ('force="guideway.friction_force"', "", "'' is no COMPONENT.VARIABLE"),
    ],
)
def test_numbers_that_are_none(remade: Callable[..., Path], tmp_path: Path, old: str, new: str, match: str) -> None:
    refused(remade({}, {old: new}), tmp_path, match)


@pytest.mark.parametrize("every", [0, -3, 10**13, 10**20])
def test_rows_that_are_kept_of_no_number_of_steps(systems: dict[str, Path], tmp_path: Path, every: int) -> None:
    system = read(systems["stick_slip"], tmp_path / "in")
    with pytest.raises(ParameterError, match=r"every .*: .*a whole number from 1 to 1e\+12 are needed"):
        plan(system, every=every)


def test_a_large_whole_number_is_one(remade: Callable[..., Path], tmp_path: Path) -> None:
    assert read(remade({}, {'every="1"': 'every="1e9"'}), tmp_path / "in").every == 1_000_000_000


@pytest.mark.parametrize(
    ("parameter", "match"),
    [
        ('<ssv:Real value="1e999999999"/>', "value = '1e999999999'; a finite number"),
        ('<ssv:Real value="NaN"/>', "value = 'NaN'; a finite number"),
        ('<ssv:Binary mime-type="text/plain" value="DEADBEEF"/>', "given as Binary"),
        ('<ssv:Real value="1"/></ssv:Parameter><ssv:Parameter name="table_mass"><ssv:Real value="2"/>', "table_mass is there twice"),
    ],
)
def test_values_that_are_none(remade: Callable[..., Path], tmp_path: Path, parameter: str, match: str) -> None:
    text = (
        '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="x">'
        f'<ssv:Parameters><ssv:Parameter name="table_mass">{parameter}</ssv:Parameter></ssv:Parameters></ssv:ParameterSet>'
    )
    refused(remade({"resources/drive.ssv": text.encode()}), tmp_path, f"drive.ssv, line 1: .*{match}")


@pytest.mark.parametrize(
    ("value", "units", "wanted"),
    [
        ('value="2" unit="kg"', "", 2.0),
        ('value="2"', "", 2.0),
        ('value="2" unit="t"', "", 2000.0),
        ('value="2" unit="g"', "", 0.002),
        ('value="2" unit="mine"', '<ssc:Unit name="mine"><ssc:BaseUnit kg="1" factor="50"/></ssc:Unit>', 100.0),
        ('value="2" unit="m"', "", "table_mass = 2 m: the FMU has this in kg, and the one does not measure"),
        ('value="2" unit="stones of old"', "", "table_mass = 2 stones of old: the FMU has this in kg"),
    ],
)
def test_values_come_in_the_unit_of_the_fmu(
    remade: Callable[..., Path], tmp_path: Path, value: str, units: str, wanted: float | str
) -> None:
    """2 g is not 2 kg."""
    text = (
        '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
        'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="x">'
        f'<ssv:Parameters><ssv:Parameter name="table_mass"><ssv:Real {value}/></ssv:Parameter></ssv:Parameters>'
        f"{units and f'<ssv:Units>{units}</ssv:Units>'}</ssv:ParameterSet>"
    )
    (tmp_path / "mine.ssv").write_text(text, encoding="utf-8")
    path = remade({"resources/drive.ssv": text.encode()})
    if isinstance(wanted, str):
        refused(path, tmp_path, wanted)
        return
    system = read(path, tmp_path / "in")
    assert system.components["drive"].values["table_mass"] == pytest.approx(wanted, rel=1e-15)
    assert from_set(system, "drive", str(tmp_path / "mine.ssv"))["table_mass"] == pytest.approx(wanted, rel=1e-15)


def test_a_bond_that_says_neither_way_of_its_force(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(remade({}, {'against="true"': 'against="yes"'}), tmp_path, "against = 'yes' of a bond; allowed are true and false")
    assert not read(remade({}, {' against="true"': ""}), tmp_path / "in").bonds[0].against


def test_a_unit_that_does_not_match(remade: Callable[..., Path], tmp_path: Path) -> None:
    """What the connector says must be what the FMU says; and both ends of a connection must agree."""
    connector = '<ssd:Connector name="slip_velocity" kind="input">\n            <ssc:Real unit="m'
    path = remade({}, {f'{connector}/s"': f'{connector}"'})
    refused(path, tmp_path, "connector slip_velocity is in m, the FMU's variable in m/s")
    crossed = {
        'startElement="drive" startConnector="table_velocity"': 'startElement="drive" startConnector="table_position"',
    }
    with pytest.raises(SspError, match=r"units do not match: drive.table_position is in m, guideway.slip_velocity in m/s"):
        read(remade({}, crossed), tmp_path / "two")


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('startConnector="table_velocity"', 'startConnector="speed"', "component drive has no connector 'speed'"),
        ('startElement="drive"', 'startElement="motor"', "component 'motor', which is not there"),
        ('startConnector="table_velocity" endElement="guideway"', 'startConnector="friction_force" endElement="guideway"', "both inputs"),
        (
            'endElement="drive" endConnector="friction_force"',
            'endElement="guideway" endConnector="slip_velocity"',
            "fed twice|do not match",
        ),
        ('<ssd:Connector name="position_x"', '<ssd:Connector name="position_z"', "no variable 'position_z'"),
        ('name="slip_velocity" kind="input"', 'name="slip_velocity" kind="output"', "the FMU's variable is input"),
    ],
)
def test_connections_that_make_no_sense(remade: Callable[..., Path], tmp_path: Path, old: str, new: str, match: str) -> None:
    refused(remade({}, {old: new}), tmp_path, match)


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("=cmd|x", r"component '=cmd\|x': a spreadsheet takes what begins with = \+ - @ for a formula"),
        ("@SUM(A1)", "for a formula"),
        ("+1", "for a formula"),
        ("-1", "for a formula"),
        ("x" * 100_000, r"component 'x{40}' has 100000 characters; a name has at most 1000"),
        ("a&#9;b", "has control characters in it"),
        ("a&#x85;b", "has control characters in it"),
        ("a&#x202e;b", "has control characters in it"),
        ("DRIVE", "(component DRIVE and drive|component drive and DRIVE) differ by case alone"),
        ("drive", "component drive is there twice"),
    ],
)
def test_a_name_of_a_component_that_is_no_name_where_it_is_shown(
    remade: Callable[..., Path], tmp_path: Path, name: str, match: str
) -> None:
    refused(remade({}, {'name="guideway"': f'name="{name}"'}), tmp_path, match)


def test_a_component_that_fails_in_mid_run_is_named_and_the_results_are_kept(systems: dict[str, Path]) -> None:
    """The injected error: from 0.1 s on the record pulls the guideway out of its bounds; the run stops there and keeps what it has."""
    times = np.array([0.0, 0.1, 0.2])
    given = Given((("drive", "load_force"),), times, np.array([[0.0], [0.0], [5e6]]))
    with pytest.raises(
        SystemStopped, match=r"component (guideway|drive) failed in the step at t = 0\.1\d* s, after \d+ of 1000 steps"
    ) as stopped:
        run(systems["stick_slip"], {}, given, step=1e-3, stop=1.0)
    trace = stopped.value.trace
    assert 0.1 <= trace.times[-1] < 0.2
    assert trace.times.size >= 101
    assert np.all(np.isfinite(trace["drive.table_position"]))
    reference, _ = run(systems["stick_slip"], step=1e-3, stop=0.1)
    assert np.allclose(trace["drive.table_position"][:100], reference["drive.table_position"][:100], rtol=1e-12, atol=0)


def test_a_component_that_fails_at_the_start_leaves_no_row(systems: dict[str, Path], tmp_path: Path) -> None:
    """A row of zeros would be taken for a result."""
    from evat.commands.main import app

    with pytest.raises(SystemStopped, match=r"component contact failed in the start at t = 0 s, after 0 of 1000 steps") as stopped:
        run(systems["evat_turning"], {"contact": {"reference_temperature": 200.0}}, step=1e-6, stop=1e-3)
    assert stopped.value.trace.times.size == 0
    assert stopped.value.trace["contact.mean_feed_force"].size == 0
    to = tmp_path / "none.csv"
    result = CliRunner().invoke(
        app, ["system", "run", str(systems["evat_turning"]), "-v", "contact.reference_temperature=200", "-o", str(to)]
    )
    assert isinstance(result.exception, SystemStopped)
    assert not to.exists()


def test_the_command_keeps_what_came_before_the_stop(systems: dict[str, Path], tmp_path: Path) -> None:
    from evat.commands.main import app

    pushed, to = tmp_path / "pushed.csv", tmp_path / "kept.parquet"
    pushed.write_text("time [s],drive.load_force [kN]\n0,0\n0.1,0\n0.2,5000\n")
    asked = ["system", "run", str(systems["stick_slip"]), "-i", str(pushed), "--step", "1e-3", "--stop", "1", "--every", "1", "-o", str(to)]
    result = CliRunner().invoke(app, asked)
    assert isinstance(result.exception, SystemStopped)
    assert "the results until the stop" in " ".join(result.output.split())
    assert 0.1 <= read_table(to).clock("time [s]")[-1] < 0.2


def test_a_version_of_ssp_that_is_not_read(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(remade({}, {'version="1.0" name': 'version="3.0" name'}), tmp_path, r"it is of SSP 3.0; SSP 1.0, 1.1 and 2.0 are read")


MAPPED = '<ssm:MappingEntry source="drive_table_mass" target="drive.table_mass"/>'
OVER_BUS = (
    'startElement="guideway" startConnector="friction_force" endElement="drive"',
    'startElement="bus" startConnector="guideway_friction_force" endElement="drive"',
)
INTO_BUS = 'startElement="guideway" startConnector="friction_force" endElement="bus" endConnector="guideway_friction_force"'


@pytest.mark.parametrize(
    ("file", "old", "new", "complaint"),
    [
        (SSD, 'implementation="CoSimulation"', 'implementation="ModelExchange"', "component path: it is to run by ModelExchange"),
        (SSD, 'source="resources/EvatPathReference.fmu" ', "", "component path: it has no source"),
        (SSD, 'kind="inout"', 'kind="both"', "not valid by the schema of SSP 2.0"),
        (SSD, 'endElement="bus"', 'endElement="bass"', "names component 'bass', which is not there"),
        (SSD, 'endElement="bus" endConnector="', 'endElement="bus" endConnector="x', "component bus has no connector 'x"),
        (SSD, 'resources/system.ssm', "../system.ssm", "lies outside of the archive"),
        (write_full.MAPPING, MAPPED, "", "its parameter mapping says nothing of 'drive_table_mass'"),
        (write_full.MAPPING, '"drive_table_mass"', '"table_mass"', "its parameter mapping names 'table_mass'; did you mean"),
        (write_full.MAPPING, '"drive.table_mass"', '"drive.mass"', "drive_table_mass is for drive.mass, which no component has"),
        (write_full.MAPPING, '"drive.table_mass"', '"table_mass"', "'table_mass' is no COMPONENT.VARIABLE"),
        (
            write_full.MAPPING, MAPPED, MAPPED.replace("/>", '><ssc:LinearTransformation factor="2"/></ssm:MappingEntry>'),
            "the entry has a transformation",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_system_of_ssp_2(full: Path, tmp_path: Path, file: str, old: str, new: str, complaint: str) -> None:
    refused(_reworded(full, tmp_path, file, old, new), tmp_path, complaint)


@pytest.mark.parametrize(
    ("new", "complaint"),
    [
        (
            'startElement="bus" startConnector="guideway_friction_force" endElement="bus" endConnector="guideway_friction_force"',
            "by itself",
        ),
        ('startElement="drive" startConnector="friction_force" endConnector="guideway_friction_force"', "there is no output, or no input"),
        ('startElement="drive" startConnector="table_position" endConnector="guideway_friction_force"', "is fed twice"),
    ],
)
def test_a_signal_that_goes_wrong_on_its_way(full: Path, tmp_path: Path, new: str, complaint: str) -> None:
    """The friction goes to the drive over the bus, so that what is on the bus matters."""
    path = _reworded(full, tmp_path, SSD, *OVER_BUS)
    refused(_reworded(path, tmp_path, SSD, INTO_BUS, new), tmp_path, complaint)


def test_a_signal_arrives_over_the_bus_however_its_connections_are_written(full: Path, tmp_path: Path) -> None:
    over = _reworded(full, tmp_path, SSD, *OVER_BUS)
    turned = 'startElement="bus" startConnector="guideway_friction_force" endElement="guideway" endConnector="friction_force"'
    for number, path in enumerate((full, over, _reworded(over, tmp_path, SSD, INTO_BUS, turned))):
        (tmp_path / str(number)).mkdir()
        assert read(path, tmp_path / str(number)).connections["drive", "friction_force"] == ("guideway", "friction_force")


def _reworded(path: Path, folder: Path, file: str, old: str, new: str) -> Path:
    """The archive with the first such words of a file changed."""
    with zipfile.ZipFile(path) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    assert old in files[file].decode()
    files[file] = files[file].decode().replace(old, new, 1).encode()
    changed = folder / "reworded.ssp"
    with zipfile.ZipFile(changed, "w") as packed:
        for name, data in files.items():
            packed.writestr(name, data)
    return changed


@pytest.fixture(scope="module")
def full(fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """stick_slip of SSP 2.0."""
    return write_full.write("stick_slip", tmp_path_factory.mktemp("full") / "stick_slip-full.ssp", fmus["fmi2"].parent)


def test_a_component_that_is_there_twice(remade: Callable[..., Path], tmp_path: Path) -> None:
    refused(
        remade({}, {'<ssd:Component name="drive"': '<ssd:Component name="path"'}), tmp_path, "component path is there twice|not valid by"
    )


def test_a_value_that_an_fmu_refuses_names_the_component(systems: dict[str, Path]) -> None:
    with pytest.raises(Exception, match=r"component drive.*table_mass = -1"):
        run(systems["stick_slip"], {"drive": {"table_mass": -1.0}}, stop=0.01)


def test_typed_values_are_checked(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["stick_slip"], tmp_path)
    assert typed(system, ["path.speed=6 m/min", "drive.rigid=false"]) == {"path": {"speed": pytest.approx(0.1)}, "drive": {"rigid": False}}
    for text, match in (
        ("drive.speed=1", "component drive has no variable 'speed'"),
        ("motor.speed=1", "no component 'motor'"),
        ("drive.table_mass=3 s", "does not measure"),
        ("drive.motor_force=3", "is output and computed"),
        ("guideway.slip_velocity=1", "is fed by drive.table_velocity"),
        ("guideway.friction_law=coulom", r"allowed are coulomb \(1\), .*; did you mean coulomb\?"),
        ("drive.rigid=2", "true and false"),
    ):
        with pytest.raises((SspError, ParameterError), match=match):
            typed(system, [text])
    with pytest.raises(SspError, match=r"fed by drive.table_velocity; a record cannot"):
        Coupled(system, {}, Given((("guideway", "slip_velocity"),), np.zeros(1), np.zeros((1, 1))))
    with pytest.raises(ParameterError, match="a step above 0"):
        plan(system, step=-1.0)
    with pytest.raises(ParameterError, match=r"steps of 4.94066e-324 s from 0 to 20 s are more than 1e\+12"):
        plan(system, step=5e-324)
    for places in ("0:1:1000000000000", "0:inf:3", "nan:1:3"):
        with pytest.raises(ParameterError, match="with a count from 1 to 100000"):
            axis(system, f"path.speed={places}")


def test_the_command_says_it_in_one_line(systems: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from evat.commands.main import app

    result = CliRunner().invoke(app, ["system", "run", str(systems["stick_slip"]), "--stop", "0.2", "-o", str(tmp_path / "out.csv")])
    assert result.exit_code == 0
    assert "energy through guideway.friction_force" in result.output
    assert (tmp_path / "out.csv").is_file()
    assert (tmp_path / "out.png").stat().st_size > 10_000
    result = CliRunner().invoke(app, ["system", "run", str(tmp_path / "no.ssp")])
    assert isinstance(result.exception, SspError)


def test_what_would_change_nothing_or_mean_something_else_is_refused(systems: dict[str, Path], tmp_path: Path) -> None:
    """Each of these once ran, and answered as if it had not been said."""
    late = Run(np.array([0.5, 0.6]), {"drive.position_reference": np.zeros(2)}, ())
    swapped = Run(np.array([0.0, 0.2, 0.1]), {"drive.position_reference": np.zeros(3)}, ())
    ragged = Run(np.array([0.0, 0.2]), {"drive.position_reference": np.zeros(3)}, ())
    for name, said, match in (
        ("stick_slip", {"order": "foo"}, "allowed are 'gauss-seidel' and 'jacobi'"),
        ("stick_slip", {"inputs": "Linear"}, "allowed are 'linear' and 'constant'"),
        ("stick_slip", {"every": 2.5}, "whole number"),
        ("stick_slip", {"values": {"guideway": {"slip_velocity": 1.0}}}, "is fed by drive.table_velocity; a value for it"),
        ("stick_slip", {"values": {"drive": {"table_mass": True}}}, "table_mass = True: a number in kg"),
        ("stick_slip", {"values": {"drive": {"table_mass": None}}}, "table_mass = None: a number in kg"),
        ("stick_slip", {"sets": {"drive": "regularised/copper"}}, "is of the contact, and component drive is none"),
        ("emps", {"record": Run(late.times, {"drv.position_reference": np.zeros(2)}, ())}, "no component 'drv'"),
        ("emps", {"record": Run(late.times, {"drive.table_mass": np.zeros(2)}, ())}, "is no input"),
        ("emps", {"record": late, "stop": 0.1}, "covers the run"),
        ("emps", {"record": swapped, "stop": 0.1}, "increasing"),
        ("emps", {"record": ragged, "stop": 0.1}, "3 samples, the clock has 2"),
        ("emps", {"record": late, "stop": 1.0, "values": {"drive": {"position_reference": 1.0}}}, "is fed by the record"),
    ):
        wishes: dict[str, Any] = {"stop": 0.01, **said}
        with pytest.raises(EvatError, match=match):
            evat.run_system(systems[name], wishes.pop("values", None), **wishes)
    table = tmp_path / "twice.csv"
    table.write_text("time [s],drive.position_reference [m],drive.position_reference [mm]\n0,0,0\n1,1,1\n")
    with pytest.raises(EvatError, match="is there twice"):
        record(read(systems["emps"], tmp_path / "emps"), table)


def test_what_a_record_does_not_cover_is_told(systems: dict[str, Path]) -> None:
    short = Run(np.array([0.01, 0.02]), {"drive.position_reference": np.zeros(2)}, ())
    notes = str(evat.run_system(systems["emps"], record=short, stop=0.03).made_by["notes"])
    assert "begins at 0.01 s: until then its first values are held" in notes
    assert "ends at 0.02 s: from there on its last values are held" in notes


def test_axes_that_hide_one_another_or_mix_units_are_refused(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["evat_turning"], tmp_path)
    with pytest.raises(ParameterError, match=r"spindle.speed_set is in rad/s, heat.ambient_temperature is in K|is in rad/s, .* is in K"):
        axis(system, "spindle.speed_set,heat.ambient_temperature=3000:3100 rpm:2")
    twice = [axis(system, "spindle.speed_set=2,3"), axis(system, "spindle.speed_set=4:5:2")]
    with pytest.raises(ParameterError, match="would hide it"):
        check_axes(twice)
    sets, amplitude = axis(system, "contact=regularised/copper"), axis(system, "contact.amplitude_x=3 um,6 um")
    check_axes([sets, amplitude])
    both, phase = axis(system, "contact.amplitude_x,contact.amplitude_y=3 um,6 um"), axis(system, "contact.phase_y=0,1")
    other = axis(system, "contact.amplitude_y,contact.feed=3 um,6 um")
    for overlapping in ([both, amplitude], [amplitude, both], [both, other], [both, phase, other]):
        with pytest.raises(ParameterError, match="would hide"):  # rows of the table had told a value that was not run
            check_axes(overlapping)


def test_flags_of_foreign_fmus_are_heeded(systems: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No shorter last step where a component takes none; not two instances of what can be there only once."""
    system = read(systems["stick_slip"], tmp_path)
    with Coupled(system) as coupled:
        monkeypatch.setattr(coupled.members[0].driver.description.coSimulation, "canHandleVariableCommunicationStepSize", False)
        with pytest.raises(ParameterError, match="component path takes no other step"):
            coupled.run(plan(system, step=1e-3, stop=0.0105))
        coupled.run(plan(system, step=1e-3, stop=0.010))
    twin = replace(system, components={**system.components, "twin": replace(system.components["guideway"], name="twin")})
    monkeypatch.setattr("evat.systems.couple.only_once", lambda source: source.stem)
    with pytest.raises(SspError, match="components guideway and twin are one FMU"):
        Coupled(twin)


def test_means_do_not_hang_on_which_rows_are_kept(systems: dict[str, Path]) -> None:
    """Ten rows of each cycle, at the same places of it, had a mean of 44 N where it is 26."""
    means = [
        evat.run_system(systems["evat_turning"], stop=4e-4, step=1e-6, every=every).made_by["mean_of_last_half"] for every in (1, 10, 400)
    ]
    assert means[0] == means[1] == means[2]
    trace = evat.run_system(systems["evat_turning"], stop=4e-4, step=1e-6, every=1)
    late = trace["contact.principal_force"][200:]
    assert means[0]["contact.principal_force"] == pytest.approx(np.mean((late[1:] + late[:-1]) / 2), rel=1e-12)
    assert means[0]["contact.principal_force"] == pytest.approx(trace["contact.mean_principal_force"][-1], rel=0.05)


def test_the_result_does_not_take_the_records_place(tmp_path: Path) -> None:
    from evat.commands.main import app

    table = tmp_path / "own.csv"
    table.write_text("time [s],drive.position_reference [m]\n0,0\n1,1\n")
    result = CliRunner().invoke(app, ["system", "run", "emps", "-i", str(table), "-o", str(table)])
    assert isinstance(result.exception, ParameterError)
    assert table.read_text().startswith("time [s],drive.position_reference [m]\n0,0")
