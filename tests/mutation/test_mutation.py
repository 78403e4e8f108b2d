"""Are mutants made where there is code, are those killed that once survived, and how many does a campaign kill?"""

from __future__ import annotations

import ast
import inspect
import json
import re
from pathlib import Path

import pytest
from evat.native import compile as compiling
from mistakes import in_c, in_python, places_in_python
from workshop import LEFT_OUT, PARTS, ROOT, SOURCES, Workshop, campaign, drawn, every_mistake, known

C = """/* a + b */
#define TWICE(x) ((x) + (x))
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "x - y", .start = 2, .meaning = "1 < 2"},
    [ON + 1] = {.name = "x + y", .start = 0.3},
};
double f(double *x, int n)
{
    for (int i = 0; i < n; ++i) /* i < n */
        x[i] += -2.5 * larger(x[i], 10);
    return x[0] && !n;
}
"""


def test_mistakes_in_c_are_made_in_code_alone(tmp_path: Path) -> None:
    (tmp_path / "f.c").write_text(C, encoding="utf-8")
    mistakes = {(mistake.line, mistake.becomes) for mistake in in_c(tmp_path / "f.c", tmp_path)}
    loop, sum_ = "for (int i = 0; i {} n; ++i) /* i < n */", "x[i] += -2.5 * larger(x[i], 10);"
    expected = {(9, loop.format("<=")), (9, loop.format(">")), (9, "for (int i = 1; i < n; ++i) /* i < n */")}
    changes = (("+=", "-="), ("-2.5", "2.5"), ("*", "/"), ("larger", "smaller"), ("10", "20"))
    expected |= {(10, sum_.replace(*change)) for change in changes}
    expected |= {
        (10, sum_.replace("2.5", "(2.5 * 2)")),
        (10, ";"),
        (11, "return x[1] && !n;"),
        (11, "return x[0] || !n;"),
        (11, "return x[0] && n;"),
    }
    assert mistakes == expected


def test_mistakes_in_python_are_those_of_cosmic_ray(tmp_path: Path) -> None:
    pytest.importorskip("cosmic_ray")
    (tmp_path / "f.py").write_text("def f(x: int | None) -> int:\n    return 2 * x if x > 0 else -x\n", encoding="utf-8")
    mistakes = {in_python(tmp_path / "f.py", tmp_path, *place).becomes for place in places_in_python(tmp_path / "f.py")}
    assert {"return 2 / x if x > 0 else -x", "return 2 * x if x >= 0 else -x", "return 2 * x if x > 0 else +x"} <= mistakes
    assert not any("def" in line for line in mistakes)


def test_what_the_workshop_asks_of_the_compilation_is_there() -> None:
    """It uses more of it than others may, and only the campaign would tell."""
    text = Path(inspect.getfile(Workshop)).read_text(encoding="utf-8")
    asked = set(re.findall(r"\bcompiling\.(\w+)", text))
    assert len(asked) >= 5
    assert [name for name in asked if not hasattr(compiling, name)] == []


def test_tests_that_load_other_libraries_are_left_out() -> None:
    """The workshop builds those of this processor: a test of others compiles them, is ended for its time, and would kill any mistake."""
    files = [
        file for tests in PARTS["kernel"].tests for file in ([ROOT / tests] if tests.endswith(".py") else (ROOT / tests).rglob("test_*.py"))
    ]
    some = {
        f"{file.relative_to(ROOT).as_posix()}::{function.name}"
        for file in files
        for function in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(function, ast.FunctionDef)
        and any(isinstance(n, ast.Name) and n.id == "kernel_library_path" for n in ast.walk(function))
    }
    assert some
    assert some <= set(LEFT_OUT)


@pytest.mark.parametrize("kind", ["equivalent", "killed"])
def test_what_is_known_is_of_lines_that_are_there(kind: str) -> None:
    """A line that was changed, or a file that was moved, takes what was said of it along."""
    names = {mistake.name for part in ("kernel", "machines", "shells") for mistake in every_mistake(part)}
    lines = {file: _lines(file) for file, _, _ in known(kind) if file.endswith(".py")}
    gone = [name for name in known(kind) if (name[1] not in lines[name[0]] if name[0] in lines else name not in names)]
    assert gone == []


def _lines(file: str) -> list[str]:
    path = ROOT / SOURCES / file
    return [line.strip() for line in path.read_text(encoding="utf-8").splitlines()] if path.is_file() else []


@pytest.mark.campaign
@pytest.mark.parametrize("part", ["kernel", "machines", "shells"])
def test_a_mutant_that_once_survived_is_killed(part: str, tmp_path: Path, fmus: dict[str, Path]) -> None:
    """By the test that was made for it, alone."""
    rows = {name: row["by"] for name, row in known("killed").items()}
    there = {mistake.name: mistake for mistake in every_mistake(part)}
    verdicts = {}
    for by in sorted(set(rows.values())):
        some = [there[name] for name in rows if rows[name] == by and name in there]
        workshop = Workshop(tmp_path / Path(by).stem, part, fmus["fmi2"].parent, [by])
        if some:
            workshop.prepare(longest=60)
            verdicts |= {mistake.name: verdict for mistake, verdict, _ in campaign(workshop, some, longest=60)}
    assert verdicts
    assert [name for name, verdict in verdicts.items() if verdict != "killed"] == []


@pytest.mark.campaign
@pytest.mark.parametrize("part", PARTS)
def test_most_mutants_are_killed(part: str, tmp_path: Path, fmus: dict[str, Path]) -> None:
    """Of thirty drawn at random. What survives is printed: to be killed by a test, or written down with the reason."""
    workshop = Workshop(tmp_path, part, fmus["fmi2"].parent)
    workshop.prepare()
    verdicts = [(verdict, mistake.name) for mistake, verdict, _ in campaign(workshop, drawn(part, 30, seed=1))]
    survived = [name for verdict, name in verdicts if verdict == "survived"]
    print(json.dumps(survived, indent=1))
    tried = sum(verdict in ("killed", "survived") for verdict, _ in verdicts)
    assert tried >= 20
    assert len(survived) < 0.5 * tried  # of the first draws 60 to 75 % were killed by the quick tests
