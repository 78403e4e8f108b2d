"""Does a small fixed part of the blind benchmark stay within bounds? The whole is run by hand: tests/gap/blind/README.md."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from evat.commands.main import app
from typer.testing import CliRunner

pytestmark = pytest.mark.campaign  # minutes
BLIND = Path(__file__).resolve().parent / "blind"
CASES = ["--seed", "5", "--count", "4", "--kinematics", "rig"]
RIGHT, WITHIN = 3, 3  # of four single effects, two in another base form: named exactly, and in the set of 90 %


@pytest.fixture(scope="module")
def scores(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Labels stay with the generator and the scorer, which run in processes of their own."""
    out = tmp_path_factory.mktemp("blind")
    subprocess.run([sys.executable, str(BLIND / "generate.py"), str(out), *CASES], check=True, capture_output=True)
    result = CliRunner().invoke(app, ["benchmark", str(out / "cases"), "--out", str(out / "answers"), "--workers", "1"])
    assert result.exit_code == 0, result.output
    command = [sys.executable, str(BLIND / "score.py"), str(out), str(out / "answers"), "--json", str(out / "scores.json")]
    subprocess.run(command, check=True, capture_output=True)
    figures: dict[str, Any] = json.loads((out / "scores.json").read_text())
    return figures


def test_single_effects_are_named(scores: dict[str, Any]) -> None:
    each = scores["each"].values()
    assert scores["cases"] == len(each) == 4
    assert not scores["failed"]
    assert sum(case["top"] == case["effects"] for case in each) >= RIGHT


def test_the_truth_is_among_what_is_likely(scores: dict[str, Any]) -> None:
    share = scores["figures"]["all"]["truth in the 90 % set"]
    assert share["value"] * 4 >= WITHIN - 1e-9
    assert scores["figures"]["all"]["size of the 90 % set"]["value"] <= 4.5  # the constants were calibrated for fewer effects
