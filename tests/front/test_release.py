"""Do the files that state the version, the authors and the checks agree with each other?"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from evat.files.read_toml import read_toml
from evat.fmu.archive import RELEASED
from evat.paper.tables import table_1_source

ROOT = Path(__file__).resolve().parents[2]
yaml = pytest.importorskip("yaml")


def project() -> dict[str, Any]:
    table: dict[str, Any] = read_toml(ROOT / "pyproject.toml")["project"]
    return table


def test_the_version_is_one_everywhere() -> None:
    version = project()["version"]
    releases = re.findall(r"^## (\S+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert next(each for each in releases if each != "Unreleased") == version
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (cited["version"], cited["date-released"]) == (version, RELEASED)
    package = (ROOT / "ssp" / "modelica" / "EvatSystems" / "package.mo").read_text(encoding="utf-8")
    assert re.findall(r'^\s*version = "(.*)",$', package, flags=re.MULTILINE) == [version]


def test_the_citation_names_authors_and_paper_as_the_project_does() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["authors"] == project()["authors"]
    assert cited["license"] == project()["license"]
    paper = cited["references"][0]
    names = ", ".join(author["family-names"] for author in paper["authors"])
    assert table_1_source().startswith(f"{names}, {paper['title']}, pp. {paper['start']}-{paper['end']}")


def test_the_hooks_are_checks_of_the_test_script(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever commits with the hooks is not surprised by build/test.py."""
    monkeypatch.syspath_prepend(str(ROOT / "build"))
    import environment

    steps: dict[str, list[str]] = {}

    def kept(title: str, command: list[str], more: object = None) -> int:
        steps[title] = command
        return 0

    monkeypatch.setattr(environment, "step", kept)
    environment.test(Path(".venv/bin"), [])
    (local,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"]
    assert [hook["name"] for hook in local["hooks"]] == ["format", "C format", "lint", "types"]
    for hook in local["hooks"]:
        words = [word for word in hook["entry"].split() if not word.startswith("-") or word == "-m"]
        assert words == steps[hook["name"]][: len(words)], hook["name"]
