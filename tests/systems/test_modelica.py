"""Does the Modelica package compile and move as it should, and does it name what the FMUs have?

The compiler from PyPI imports no FMUs and brings no standard library: modelica/ has what the package uses of that, and blocks with the
FMUs' connectors whose motion is known.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from evat.fmu.part_model import model_of
from evat.systems.declared import folder

PACKAGE = folder() / "modelica" / "EvatSystems"
BENCH = Path(__file__).resolve().with_name("modelica")
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


def simulated(name: str) -> dict[str, np.ndarray]:
    """Variables of a model of the bench over 5 s, every 0.5 s."""
    rumoca = pytest.importorskip("rumoca", reason="rumoca is not installed: pip install 'evat[importers]'")
    session = rumoca.Session(roots=[str(PACKAGE), str(BENCH / "Modelica.mo")])
    result = session.load(str(BENCH / "Bench.mo"), model=f"Bench.{name}").simulate(t=(0, 5), dt=0.5)
    return {"time": np.asarray(result.time), **dict(zip(result.names, result.to_numpy(), strict=True))}


def test_the_guideway_compiles_and_moves() -> None:
    """A mass of 1 kg on a spring of 2 N/m, pulled at 0.1 m/s against 0.5 N.s/m: with w the damped frequency, exact."""
    moved = simulated("StickSlip")
    t, decay, w = moved["time"], 0.25, np.sqrt(2 - 0.25**2)
    velocity = 0.1 * (1 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
    assert t[-1] == 5.0
    assert moved["friction.v_rel"] == pytest.approx(velocity, abs=1e-5)
    assert moved["ground.flange.f"] == pytest.approx(0.5 * velocity, abs=1e-5)


def test_the_cut_compiles_and_moves() -> None:
    moved = simulated("Turning")
    t = moved["time"]
    assert moved["along.v"] == pytest.approx(np.exp(-3 * t), abs=1e-4)
    assert moved["across.s"] == pytest.approx(0.01 * np.cos(20 * t), abs=1e-4)
    assert moved["spindle.flange.tau"] == pytest.approx(np.full(t.size, -0.1 * (10 * 2 + 2 * 50)), rel=1e-9)
    assert moved["tool.port.Q_flow"] == pytest.approx(np.full(t.size, 2.0 * 120), rel=1e-9)


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
