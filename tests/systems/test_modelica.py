"""Can the Modelica package be read, and does it name what the FMUs have? No Modelica compiler is at hand here, so it is parsed only."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from evat.fmu.part_model import model_of
from evat.systems.declared import folder

PACKAGE = folder() / "modelica" / "EvatSystems"
FILES = sorted(PACKAGE.rglob("*.mo"))
WRAPPED = {"GuidewayFmu": "evat_guideway", "TurningFmu": "evat_turning"}
CONNECTOR = re.compile(r"Blocks\.Interfaces\.Real(Input|Output) (\w+)\(unit = \"([^\"]+)\"\)")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_it_parses(path: Path) -> None:
    parser = pytest.importorskip("pymoca.parser", reason="pymoca is not installed: pip install 'evat[importers]'")
    tree = parser.parse(path.read_text(encoding="utf-8"))
    assert tree is not None
    classes = [*tree.classes, *(inner for each in tree.classes.values() for inner in each.classes)]
    name = path.parent.name if path.stem == "package" else path.stem
    assert name in classes or "EvatSystems" in classes


@pytest.mark.parametrize("name", WRAPPED)
def test_connectors_are_variables_of_the_fmu(name: str) -> None:
    variables = {v.name: v for v in model_of(WRAPPED[name]).variables}
    connectors = CONNECTOR.findall((PACKAGE / "Interfaces" / f"{name}.mo").read_text(encoding="utf-8"))
    assert connectors
    for kind, variable, unit in connectors:
        assert variables[variable].causality == kind.lower()
        assert variables[variable].unit == unit


def test_only_variables_are_differentiated() -> None:
    """Not every compiler takes der of an expression."""
    derivatives = [argument for path in FILES for argument in re.findall(r"\bder\(([^)]*)\)", path.read_text(encoding="utf-8"))]
    assert len(derivatives) >= 4
    assert [argument for argument in derivatives if not re.fullmatch(r"[A-Za-z_][\w.]*", argument)] == []


def test_the_order_files_name_what_is_there() -> None:
    for path in PACKAGE.rglob("package.order"):
        there = {each.stem for each in path.parent.glob("*.mo")} | {each.name for each in path.parent.iterdir() if each.is_dir()}
        assert set(path.read_text(encoding="utf-8").split()) == there - {"package"}
