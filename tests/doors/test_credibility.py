"""Does an FMU say what was checked of it, as readers of SSP's meta data expect? And does each test that it names hold the figure?"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import evidence as told
import pytest
from evat import fmu
from evat.fmu import credibility
from evat.fmu.credibility import credibility_files, evidence
from evat.fmu.part_model import fmu_facts_of
from evat.fmu.python_fmu import MODEL_NAME, PART
from evat.systems.declared import names
from lxml import etree

ROOT = Path(__file__).resolve().parents[2]


def classes(srmd: bytes) -> list[tuple[str, Mapping[str, str]]]:
    return [(each.get("type"), {entry.get("keyword"): entry.text for entry in each}) for each in etree.fromstring(srmd)]


def of(part: str) -> bytes:
    title = part if part in names() else fmu_facts_of(part).model_name
    (content,) = credibility_files(title, part, "{token}").values()
    return content


@pytest.mark.parametrize("part", [*fmu.parts(), *names()])
def test_every_fmu_and_system_tells_both_what_was_checked_and_what_was_not(part: str) -> None:
    listed = classes(of(part))
    for kind in ("verification", "validation"):
        own = [entries for name, entries in listed if name == f"org.evat.{kind}"]
        known = [each for each in evidence() if each.kind == kind and part in each.parts]
        assert [entries["claim"] for entries in own] == ([each.claim for each in known] or ["none that a test holds"])
        assert [entries.get("test") for entries in own] == ([each.test for each in known] or [None])
    assert part in names() or any(name == "org.evat.verification" and "test" in entries for name, entries in listed)


def test_it_lies_in_fmus_and_systems(fmus: dict[str, Path], systems: dict[str, Path]) -> None:
    with zipfile.ZipFile(fmus["evat_guideway-fmi3"]) as archive:
        listed = classes(archive.read("extra/org.ssp-standard.srmd/EvatGuideway.srmd"))
    assert "Canudas de Wit" in listed[0][1]["against"]
    with zipfile.ZipFile(fmus["python"]) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".srmd"))
        assert name == f"extra/org.ssp-standard.srmd/{MODEL_NAME}.srmd"
        assert [entries["claim"] for _, entries in classes(archive.read(name))] == [
            *(each.claim for each in evidence() if PART in each.parts), "none that a test holds",
        ]  # fmt: skip
    with zipfile.ZipFile(systems["stick_slip"]) as archive:
        assert classes(archive.read("extra/org.ssp-standard.srmd/stick_slip.srmd")) == classes(of("stick_slip"))


def test_the_schema_of_the_standard_takes_it(tmp_path: Path) -> None:
    reader = pytest.importorskip("pyssp_standard.srmd", reason="pyssp-standard is not installed: pip install 'evat[importers]'")
    path = tmp_path / "EvatContact.srmd"
    path.write_bytes(of("evat_contact"))
    with reader.SRMD(path) as read:
        read.__check_compliance__()
        assert [each.classification_type for each in read.classifications] == [name for name, _ in classes(path.read_bytes())]


@pytest.mark.parametrize("one", evidence(), ids=lambda one: one.name)
def test_each_figure_is_held_by_the_test_that_it_names(one: credibility.Evidence) -> None:
    path, name = one.test.split("::")
    text = (ROOT / path).read_text(encoding="utf-8")
    body = text[text.index(f"def {name}(") :].split("\n\n\n")[0]
    assert f'evidence.hold("{one.name}"' in body
    assert 0 < one.largest_deviation < 100
    assert set(one.parts) <= {*fmu.parts(), *names(), PART}


def test_what_is_worse_than_told_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("EVAT_WRITE_TABLES", raising=False)
    one = replace(evidence()[0], largest_deviation=1.0)
    monkeypatch.setattr(told, "evidence", lambda: (one,))
    told.hold(one.name, 1.09)
    with pytest.raises(AssertionError, match=r"1.2 % is found, 1 % is told"):
        told.hold(one.name, 1.2)
