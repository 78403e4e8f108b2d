"""Do the pages that an FMU carries read well in a real browser, on a phone and on paper, and do their links lead somewhere?"""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import check_layout
from evat import fmu
from evat.fmu.documentation import contact, partner
from lxml import html

PART = "tool_heat"


@pytest.fixture(scope="module")
def documentation() -> dict[str, dict[str, bytes]]:
    """Of the contact and of a partner, file by file."""
    facts = fmu.facts(2)
    return {
        "evat_contact": contact.documentation_files(facts.fmu, facts.variables),
        PART: partner.documentation_files(fmu.fmu_facts_of(PART), PART),
    }


@pytest.mark.parametrize("part", ["evat_contact", PART])
def test_every_link_leads_somewhere(documentation: dict[str, dict[str, bytes]], part: str) -> None:
    """To a place on the page or to a file of the same archive; the page says what it is, and lists the files beside it."""
    files = documentation[part]
    page = html.fromstring(files["documentation/index.html"])
    places = {element.get("id") for element in page.iter() if element.get("id")}
    targets = [link.get("href") for link in page.iter("a")]
    assert len(targets) > 5
    for target in targets:
        assert target[1:] in places if target.startswith("#") else f"documentation/{target}" in files, target
    assert any(target.endswith("license.txt") for target in targets)
    assert page.find(".//meta[@name='viewport']") is not None
    assert "http" not in page.find(".//meta[@http-equiv='Content-Security-Policy']").get("content")


@pytest.mark.parametrize("part", ["evat_contact", PART])
def test_the_page_fits_screen_phone_and_paper(documentation: dict[str, dict[str, bytes]], part: str, tmp_path: Path) -> None:
    (tmp_path / "index.html").write_bytes(documentation[part]["documentation/index.html"])
    check_layout(tmp_path / "index.html")
