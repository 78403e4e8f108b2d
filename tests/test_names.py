"""Does a name stand for one thing? No two public classes of the package are called alike."""

from __future__ import annotations

import ast
from pathlib import Path

import evat


def test_no_two_classes_have_one_name() -> None:
    """Classes of a module, as they are defined: what a module hands on is defined once, and what begins with _ is its own."""
    folder, by_class = Path(evat.__file__).parent, dict[str, list[str]]()
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                by_class.setdefault(node.name, []).append(f"{path.relative_to(folder)}:{node.lineno}")
    assert len(by_class) > 100
    assert {name: places for name, places in by_class.items() if len(places) > 1} == {}
