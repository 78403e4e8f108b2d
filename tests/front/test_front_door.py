"""Does `import evat` give what a user needs: quickly, with types, and with documentation whose examples are true?"""

from __future__ import annotations

import ast
import doctest
import inspect
import os
import re
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import evat
import pytest

HEAVY = ("numpy", "scipy", "matplotlib", "plotly", "pyarrow", "cffi", "fmpy", "typer", "pint")
OF_SETS = ("names", "load", "load_ssv", "save_ssv")  # of the module parameter_sets
DOCUMENTED = [*evat.__all__, *(f"parameter_sets.{name}" for name in OF_SETS)]
SECTIONS = {
    "module": {"Examples"},
    "error": {"Examples"},
    "function": {"Returns", "Raises", "Examples"},
    "class": {"Examples"},
}


def named(name: str) -> Any:
    attribute: Any = evat
    for part in name.split("."):
        attribute = getattr(attribute, part)
    return attribute


def kind(attribute: Any) -> str:
    if isinstance(attribute, types.ModuleType):
        return "module"
    if not isinstance(attribute, type):
        return "function"
    return "error" if issubclass(attribute, Exception) else "class"


def sections(attribute: Any) -> dict[str, str]:
    """The parts of a numpy-style docstring by their headings."""
    parts = re.split(r"^(\w+)\n-{3,}\n", inspect.getdoc(attribute) or "", flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def test_the_import_loads_no_library() -> None:
    ask = "import sys, evat; print(*[name for name in sys.argv[1:] if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", ask, *HEAVY], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_an_error_is_caught_without_loading_what_raises_it() -> None:
    ask = "import sys, evat; evat.EvatError; print('fmpy' in sys.modules, 'matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_what_type_checkers_see_is_what_is_loaded() -> None:
    tree = ast.parse(Path(str(evat.__file__)).read_text(encoding="utf-8"))
    (checking,) = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {alias.name: node.module for node in checking.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert sorted(seen) == sorted(evat.__all__) == list(evat.__all__)
    assert seen.pop("parameter_sets") == "evat"
    assert seen == {name: module for module, names in evat._PLACES.items() for name in names}


def test_no_module_stands_in_the_way_of_a_name() -> None:
    """A module of that name, once loaded, would take the function's place."""
    folder = Path(str(evat.__file__)).parent
    modules = {path.stem for path in folder.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert modules & set(evat.__all__) == {"parameter_sets"}


def test_a_name_that_is_not_there_says_what_is() -> None:
    with pytest.raises(AttributeError, match=r"simulat'; it has .*simulate"):
        evat.simulat  # noqa: B018
    assert set(evat.__all__) <= set(dir(evat))


@pytest.mark.parametrize("name", DOCUMENTED)
def test_every_name_is_documented(name: str) -> None:
    attribute = named(name)
    told, what = sections(attribute), kind(attribute)
    assert SECTIONS[what] <= told.keys(), name
    if what == "class":
        assert {"Parameters", "Attributes"} & told.keys(), name
    if what in ("class", "function") and "Attributes" not in told:
        takes = [each for each in inspect.signature(attribute).parameters if each != "self"]
        described = re.findall(r"^(\w+) : ", told.get("Parameters", ""), flags=re.MULTILINE)
        assert described == takes, f"{name}: the docstring's parameters are not those of the signature"
    for error in re.findall(r"^(\w+)$", told.get("Raises", ""), flags=re.MULTILINE):
        assert error in evat.__all__, f"{name} raises {error}, which `import evat` does not give"


@pytest.mark.parametrize("name", DOCUMENTED)
def test_the_examples_are_true(name: str, tmp_path: Path, fmus: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    text = sections(named(name))["Examples"]
    examples = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    assert examples.examples, name
    if "fmus/" in text:
        place_fmus(tmp_path, fmus, systems=".ssp" in text)
    monkeypatch.chdir(tmp_path)
    told: list[str] = []
    result = doctest.DocTestRunner(verbose=False).run(examples, out=told.append)
    assert result.failed == 0, "".join(told)


def place_fmus(folder: Path, fmus: dict[str, Path], systems: bool) -> None:
    """What `evat build --host-only --out fmus` would leave in the folder."""
    from evat.systems.ssp.write import write_all

    made = folder / "fmus"
    made.mkdir()
    for path in fmus.values():
        if path.exists():
            os.symlink(path, made / path.name)
    if systems:
        write_all(made, fmus["fmi2"].parent)
