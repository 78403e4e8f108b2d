"""Does a name stand for one thing, and is a file soon seen? No two public classes are called alike, no result is just found, no room is
crowded."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

import evat

MOST_FILES = 16  # of a room


def test_no_two_classes_have_one_name() -> None:
    """Classes of a module, as they are defined: what a module hands on is defined once, and what begins with _ is its own."""
    folder, by_class = Path(evat.__file__).parent, dict[str, list[str]]()
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                by_class.setdefault(node.name, []).append(f"{path.relative_to(folder)}:{node.lineno}")
    assert len(by_class) > 100
    assert {name: places for name, places in by_class.items() if len(places) > 1} == {}


def test_no_result_is_called_found() -> None:
    """A result is named by what it is: a fit, a row of forces, a place. In Python each name, in C what is declared; a test may say that
    something is found."""
    root = Path(__file__).parents[2]
    called = []
    for path in (*(root / "fmu_src").rglob("*.py"), *(root / "tests").rglob("*.py"), *(root / "build").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = getattr(node, "id", None) or getattr(node, "arg", None) or getattr(node, "attr", None) or getattr(node, "name", None)
            if isinstance(name, str) and "found" in name.lower().split("_") and not name.startswith("test_"):
                called.append(f"{path.relative_to(root)}:{getattr(node, 'lineno', 0)}")
    for path in (*(root / "fmu_src").rglob("*.[ch]"), *(root / "tests").rglob("*.[ch]")):
        code = re.sub(r"/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        called += [f"{path.relative_to(root)}: {name}" for name in re.findall(r"\b\w+", code) if "found" in name.lower().split("_")]
    assert called == []


def test_no_room_is_crowded() -> None:
    """About a dozen files side by side, headers aside; of effects and laws each is a file, and there may be as many as there are."""
    root = Path(__file__).parents[2] / "fmu_src"
    rooms = Counter(path.parent for path in (*root.rglob("*.py"), *root.rglob("*.c")) if path.name != "__init__.py")
    crowded = {str(room.relative_to(root)): count for room, count in rooms.items() if count > MOST_FILES}
    assert crowded.pop("kernel/effects") > 30
    assert crowded == {}
