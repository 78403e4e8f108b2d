"""Does every number of smoothing, inference and diagnosis stand in the one table, under a name of its own, and does it count?"""

from __future__ import annotations

import ast
from collections import Counter
from dataclasses import fields
from pathlib import Path

import evat.gap
import evat.inference
import numpy as np
import pytest
from evat import constants
from evat.constants import CONSTANTS
from evat.experiment import periods, smoothing
from evat.gap.verdict.constants import Constants, in_use, stored
from evat.gap.verdict.judgement import judge
from evat.inference.noise.autoregression import autoregression
from evat.model import ParameterError
from test_gates import features

ROOMS = [Path(evat.inference.__file__).parent, Path(evat.gap.__file__).parent]
# What draws the report has measures of pictures; they move no answer.
PICTURES = (ROOMS[1] / "report" / "html_report.py", *(ROOMS[1] / "report" / "pictures").glob("*.py"))
NO_CHOICE = {  # the version of a file, the filter that changes nothing, and how many things differ between trials
    ("answer.py", "FORMAT"),
    ("autoregression.py", "WHITE"),
    ("initial_state.py", "RANDOM"),
}
BESIDE = [Path(module.__file__) for module in (periods, smoothing)]
MODULES = sorted([*BESIDE, *(path for room in ROOMS for path in room.rglob("*.py") if path not in PICTURES)])


def numbers(path: Path) -> list[str]:
    """Names at the top of a module that are given a number, or anything made of numbers."""
    given = list[str]()
    for statement in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
            numeric = any(isinstance(n, ast.Constant) and type(n.value) in (int, float) for n in ast.walk(statement.value))
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            given += [n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name)] if numeric else []
    return given


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_no_number_stands_outside_the_table(path: Path) -> None:
    assert [name for name in numbers(path) if (path.name, name) not in NO_CHOICE] == []


def test_each_name_is_given_once_and_read_somewhere() -> None:
    tree = ast.parse(Path(constants.__file__).read_text(encoding="utf-8"))
    (table,) = (n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "_Constants")
    given = Counter(n.targets[0].id for n in table.body if isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Name))
    assert set(given) == set(CONSTANTS.declared())
    assert max(given.values()) == 1
    trees = [ast.parse(path.read_text(encoding="utf-8")) for room in ROOMS for path in room.rglob("*.py")]
    trees += [ast.parse(path.read_text(encoding="utf-8")) for path in BESIDE]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    read = {node.attr for node in nodes if isinstance(node.value, ast.Name) and node.value.id == "CONSTANTS"}
    assert set(given) - read == {field.name for field in fields(Constants)}


def test_each_says_what_it_is_in_which_unit_and_where_it_is_from() -> None:
    for name, each in CONSTANTS.declared().items():
        assert each.unit, name
        assert each.meaning, name
        assert each.source or each.origin != "derived", f"{name} is derived; say from what"
        values = np.atleast_1d(each.value)
        assert np.all(values >= each.low), name
        assert np.all(values <= each.high), name


def test_what_the_calibration_fits_is_what_the_table_calls_calibrated() -> None:
    calibrated = {name for name, each in CONSTANTS.declared().items() if each.origin == "calibrated"}
    assert {field.name for field in fields(Constants)} == calibrated
    assert in_use()["temperature"] == stored()[0].temperature
    assert in_use()["bands"] == CONSTANTS.bands


def test_a_replaced_constant_counts_until_the_block_ends() -> None:
    draw = np.random.default_rng(1)
    row = draw.normal(size=4000)
    for n in range(1, row.size):
        row[n] += 0.8 * row[n - 1]
    with CONSTANTS.replaced(most_lags=0):
        assert autoregression([row]).size == 1
        with CONSTANTS.replaced(temperature=3.0):
            assert stored()[0].temperature == 3.0
            assert CONSTANTS.most_lags == 0
    assert autoregression([row]).size > 1
    assert stored()[0].temperature != 3.0


def test_a_replaced_number_of_the_judgement_moves_a_verdict() -> None:
    """Two effects that are as likely: the first is one of several only where a half is too little."""
    seen = features(30, {"a": (300, 0.01), "b": (300, 0.01)}, exact=-50)
    assert judge(seen, Constants()).verdict == "ambiguous"
    with CONSTANTS.replaced(least_named_probability=0.4):
        assert judge(seen, Constants()).verdict == "effect"


def test_what_is_no_constant_is_refused() -> None:
    with pytest.raises(ParameterError, match="none of that name"), CONSTANTS.replaced(warp=9.0):
        pass
    with pytest.raises(ParameterError, match="of the form"), CONSTANTS.replaced(smoothing_windows=3):
        pass


def test_half_and_twice_stay_within_bounds() -> None:
    declared = CONSTANTS.declared()
    assert declared["pair_fits"].times(0.5) == 1
    assert declared["saturation_level"].times(2.0) == 1.0
    assert declared["nugget_range"].times(2.0) == (4e-4, 0.4)
    assert declared["gap_offset"].times(2.0, -0.2) == -0.4
