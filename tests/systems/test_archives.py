"""Are the .ssp files what the standards say, portable where they claim it, and the same bytes each time?"""

from __future__ import annotations

import importlib.util
import io
import re
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from evat import fmu
from evat.fmu import host
from evat.native.compile import seal
from evat.paper.tables import materials as materials_of_work
from evat.systems import declared
from evat.systems.declared import Declared, load, materials, names
from evat.systems.model import SspError
from evat.systems.run import run_system
from evat.systems.ssp import write, write_full
from evat.systems.ssp.read import read
from lxml import etree

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
KINDS = {".ssd": "Description", ".ssv": "ParameterValues", ".ssm": "ParameterMapping", ".ssb": "SignalDictionary"}


def validate(path: Path, schemas: Path) -> int:
    """Check every SSP file in the archive; how many there were."""
    count = 0
    with zipfile.ZipFile(path) as packed:
        for name in packed.namelist():
            kind = KINDS.get(Path(name).suffix)
            if kind is not None:
                etree.XMLSchema(file=str(schemas / f"SystemStructure{kind}.xsd")).assertValid(etree.parse(io.BytesIO(packed.read(name))))
                count += 1
    return count


@pytest.mark.parametrize("name", names())
def test_the_portable_form_is_valid_and_portable(systems: dict[str, Path], name: str) -> None:
    of_heat = materials_of_work() if "heat" in load(name).parts else ()
    assert validate(systems[name], SCHEMAS) == 1 + len(load(name).parts) + len(materials(load(name))) + len(of_heat)
    with zipfile.ZipFile(systems[name]) as packed:
        text, inside = packed.read("SystemStructure.ssd").decode(), set(packed.namelist())
        values = [packed.read(entry).decode() for entry in inside if entry.endswith(".ssv")]
    for unwanted in ("LinearTransformation", "ParameterMapping", "SignalDictionary", "<ssd:System name", "Enumeration"):
        assert text.count(unwanted) <= (1 if unwanted == "<ssd:System name" else 0)
    assert re.search(r'oms:FixedStepMaster [^>]*stepSize="([^"]*)"', text)[1] == f"{load(name).step_of_held_inputs:g}"  # type: ignore[index]
    assert not [value for value in values if "Enumeration" in value]
    for part in load(name).parts.values():
        assert {f"resources/{part.name}.ssv", write.fmu_entry(part)} <= inside


@pytest.mark.parametrize("name", names())
def test_the_full_form_is_valid_by_ssp_2(fmus: dict[str, Path], name: str, tmp_path: Path) -> None:
    spec = importlib.util.find_spec("pyssp_standard")
    if spec is None or not spec.submodule_search_locations:
        pytest.skip("pyssp-standard, which has the schemas of SSP 2.0, is not installed: pip install 'evat[importers]'")
    path = write_full.write(name, tmp_path / "full.ssp", fmus["fmi2"].parent)
    assert validate(path, Path(spec.submodule_search_locations[0]) / "resources" / "ssp2") == 4
    wanted = load(name)
    with zipfile.ZipFile(path) as packed:
        ssd, ssm, ssv = (etree.fromstring(packed.read(entry)) for entry in ("SystemStructure.ssd", write_full.MAPPING, write_full.VALUES))
        versions = {fmpy.read_model_description(io.BytesIO(packed.read(write.fmu_entry(p)))).fmiVersion for p in wanted.parts.values()}
    assert versions == {"3.0"}
    assert {entry.get("source") for entry in ssm} == {each.get("name") for each in ssv[0]}
    assert {entry.get("target") for entry in ssm} == {f"{part.name}.{key}" for part in wanted.parts.values() for key in part.values}
    connectors = {(element.getparent().getparent().get("name"), element.get("name")) for element in ssd.iter("{*}Connector")}
    for connection in ssd.iter("{*}Connection"):
        for end in ("start", "end"):
            assert (connection.get(f"{end}Element") or wanted.name, connection.get(f"{end}Connector")) in connectors


@pytest.mark.parametrize("name", names())
def test_both_forms_are_read_as_one_system(systems: dict[str, Path], fmus: dict[str, Path], name: str, tmp_path: Path) -> None:
    full = write_full.write(name, tmp_path / "full.ssp", fmus["fmi2"].parent)
    for folder in ("portable", "full"):
        (tmp_path / folder).mkdir()
    portable, in_full = read(systems[name], tmp_path / "portable"), read(full, tmp_path / "full")
    nowhere = {"components": {}}
    assert replace(portable, **nowhere) == replace(in_full, **nowhere)  # type: ignore[arg-type]
    assert list(portable.components) == list(in_full.components)
    assert any(component.values for component in portable.components.values())
    for component, ours in portable.components.items():
        assert (ours.values, ours.connectors) == (in_full.components[component].values, in_full.components[component].connectors)


def test_a_system_of_ssp_2_runs_as_its_portable_form(systems: dict[str, Path], fmus: dict[str, Path], tmp_path: Path) -> None:
    """As near as inputs by their mean over a step (FMI 3) come to inputs by their slopes (FMI 2): half the step, a quarter of the
    difference."""
    full = write_full.write("stick_slip", tmp_path / "full.ssp", fmus["fmi2"].parent)
    apart = []
    for step in (2e-4, 1e-4):
        one, other = (run_system(ssp, step=step, stop=0.02)["drive.table_position"] for ssp in (systems["stick_slip"], full))
        apart.append(np.abs(one - other).max() / np.abs(one).max())
    assert 0 < apart[0] < 1e-4
    assert apart[0] / apart[1] == pytest.approx(4, rel=0.1)


def test_the_same_declaration_gives_the_same_bytes(systems: dict[str, Path], fmus: dict[str, Path], tmp_path: Path) -> None:
    again = write.write(
        "evat_turning", tmp_path / "again.ssp", {part: fmus["fmi2"].parent / fmu.file_name(2, part) for part in fmu.parts()}
    )
    assert again.read_bytes() == systems["evat_turning"].read_bytes()


@pytest.mark.parametrize(
    ("stated", "packed", "day"),
    [
        ("2024-05-03T10:00:00Z", (2025, 1, 2), "2024-05-03"),
        (None, (2025, 1, 2), "2025-01-02"),
        (None, (1980, 1, 1), ""),
    ],
)
def test_a_system_is_as_old_as_it_says_or_its_newest_file(
    systems: dict[str, Path], tmp_path: Path, stated: str | None, packed: tuple[int, int, int], day: str
) -> None:
    """Of another's making: not all say when."""
    with zipfile.ZipFile(systems["stick_slip"]) as ours, zipfile.ZipFile(tmp_path / "other.ssp", "w") as other:
        for name in ours.namelist():
            data = ours.read(name)
            if name == "SystemStructure.ssd":
                top = etree.fromstring(data)
                top.attrib.pop("generationDateAndTime")
                top.attrib.update({} if stated is None else {"generationDateAndTime": stated})
                data = etree.tostring(top)
            other.writestr(zipfile.ZipInfo(name, (*packed, 0, 0, 0)), data)
    (tmp_path / "unpacked").mkdir()
    assert read(tmp_path / "other.ssp", tmp_path / "unpacked").day == day


def test_a_system_of_ours_runs_by_its_name_with_the_fmus_of_a_wheel(
    systems: dict[str, Path], fmus: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a compiler, and with nothing kept from before."""
    for part in {part.part for part in load("stick_slip").parts.values()}:
        brought = shutil.copy(fmus["fmi2"].parent / fmu.file_name(2, part), tmp_path)
        seal(Path(brought), host.made_from())
    monkeypatch.setattr(host, "BROUGHT", tmp_path)
    monkeypatch.setattr(host, "_kept", lambda *_: pytest.fail("the FMU of the wheel was not taken"))
    of_file, by_name = (run_system(ssp, stop="5 ms") for ssp in (systems["stick_slip"], "stick_slip"))
    assert all(np.array_equal(of_file[name], by_name[name]) for name in of_file)
    with pytest.raises(SspError, match=r"there is no such file, and none of our systems is called so; did you mean stick_slip\?"):
        run_system("stickslip")


def test_every_material_that_needs_no_choice_is_in_the_archive(systems: dict[str, Path]) -> None:
    with zipfile.ZipFile(systems["evat_turning"]) as packed:
        archived = {Path(name).stem for name in packed.namelist() if name.startswith("resources/contact/")}
    assert {"regularised-copper", "regularised-al-6061", "regularised-al-7075-t6", "regularised-inconel-718"} <= archived
    assert not {name for name in archived if name.startswith("published")}  # as_published is a choice


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('"drive.friction_force" = "guideway.friction_force"', '"drive.friction_force" = "drive.table_velocity"', "is in m/s.*in N"),
        ('part = "feed_drive"', 'part = "feed"', "there is no part 'feed'"),
        ("table_mass = 1.0", "mass = 1.0", "'mass' is no parameter"),
        ('damping_mode = "dissipative"', 'damping_mode = "as_published"', "some importers cannot set choices"),
        ("stop_time =", "end_time =", "unknown end_time"),
        ('"drive.motor_force"', '"drive.pid_gain"', "is no output"),
    ],
)
def test_a_wrong_declaration_is_refused(old: str, new: str, match: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (declared.folder() / "stick_slip" / "system.toml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "stick_slip").mkdir()
    (tmp_path / "stick_slip" / "system.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    monkeypatch.setattr(declared, "folder", lambda: tmp_path)
    with pytest.raises(SspError, match=match):
        load("stick_slip")


def test_the_names_of_our_systems() -> None:
    assert {"evat_turning", "feed_drive", "emps", "circular_path", "stick_slip", "hunting"} <= set(names())
    assert isinstance(load("evat_turning"), Declared)
