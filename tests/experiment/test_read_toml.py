"""Is a TOML file that takes for ever or breaks the library refused at once, and any other read as it stands?"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from evat.files.read_toml import MOST_LEVELS, TomlError, read_toml

DEEP = 50_000
KEY = ".".join(["a"] * DEEP)


def written(folder: Path, text: str, name: str = "deep.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("command", [("experiment", "check", "."), ("diagnose", "."), ("sets", "experiment.toml")])
def test_a_key_50_000_levels_deep_is_refused_at_once(tmp_path: Path, command: tuple[str, ...]) -> None:
    """In a process of its own: on one core the library alone would take hours."""
    written(tmp_path, f"title = 'x'\n{KEY} = 1\n", "experiment.toml")
    line = [sys.executable, "-c", "from evat.commands.main import main; main()", *command]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert f"experiment.toml, line 2: a key or its value has more than {MOST_LEVELS} levels; it is not read." in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "text",
    [
        f"[{KEY}]\n",
        f"[[{KEY}]]\n",
        f"x = {{{KEY} = 1}}\n",
        " . ".join(["'a'", '"b"', "c"] * DEEP) + " = 1\n",
        "x = " + "[" * DEEP,
        "x = [\n" * DEEP,
        "x = " + "{a = " * DEEP,
    ],
)
def test_every_way_to_be_deep(tmp_path: Path, text: str) -> None:
    with pytest.raises(TomlError, match=r"deep.toml, line \d+: a key or its value has more than"):
        read_toml(written(tmp_path, text))


def test_what_is_not_deep_is_read(tmp_path: Path) -> None:
    """Dots and brackets in texts and comments do not count, nor do many of them one after the other."""
    signs = "a." * 100 + "[{" * 100
    text = (
        f'one = "{signs} \\" {signs}"\ntwo = \'{signs}\'\nthree = """{signs}\n"" {signs}"""\n'
        f"four = '''{signs}\n{signs}'''\n# {signs}\n"
        f"numbers = [{', '.join(['1.5'] * 100)}]\ntables = [{', '.join(['{a.b = 1}'] * 100)}]\n"
        + "".join(f'[t{n}.a]\n"x.y" = 1979-05-27T07:32:00.5\n' for n in range(100))
    )
    table = read_toml(written(tmp_path, text))
    assert table["one"] == f'{signs} " {signs}'
    assert table["four"] == f"{signs}\n{signs}"
    assert len(table["tables"]) == 100
    assert table["t99"]["a"]["x.y"].year == 1979
    key = ".".join(["a"] * MOST_LEVELS)
    deepest = read_toml(written(tmp_path, f"{key} = 1\n"))
    for _ in range(MOST_LEVELS):
        deepest = deepest["a"]
    assert deepest == 1
    with pytest.raises(TomlError):
        read_toml(written(tmp_path, f"{key}.a = 1\n"))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("x = '''", "no readable TOML"),
        ('x = "' + "\\" * 1001, "no readable TOML"),
        ("x = 1" + "0" * 5000, "no readable TOML"),
        ("x = '" + "x" * (5 << 20) + "'", "more than 4 MiB is not read"),
    ],
)
def test_what_is_no_toml_says_so(tmp_path: Path, text: str, word: str) -> None:
    with pytest.raises(TomlError, match=rf"deep.toml.*{word}"):
        read_toml(written(tmp_path, text))


def test_what_is_no_text_says_so(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(TomlError, match="no readable TOML"):
        read_toml(tmp_path / "deep.toml")
    with pytest.raises(TomlError, match=r"no readable TOML file: (Is a directory|Permission denied)"):
        read_toml(tmp_path)


def test_the_mark_that_some_editors_put_in_front_of_utf_8_is_no_part_of_the_text(tmp_path: Path) -> None:
    path = tmp_path / "marked.toml"
    path.write_bytes('title = "\u00fc"\r\ntext = """a\r\nb"""\r\n'.encode("utf-8-sig"))
    assert read_toml(path) == {"title": "\u00fc", "text": "a\nb"}


@pytest.mark.parametrize("mark", [b"\xff\xfe", b"\xfe\xff"])
def test_utf_16_is_called_so(tmp_path: Path, mark: bytes) -> None:
    path = tmp_path / "wide.toml"
    path.write_bytes(mark + b"a\0")
    with pytest.raises(
        TomlError, match=r"wide.toml: this is no readable TOML file, but text in UTF-16; TOML is in UTF-8: save the file as that\."
    ):
        read_toml(path)
