"""How is a TOML file read that anybody may have written? As the standard library does, once it is not too large or deep for that.

The library takes time that grows with the cube of the parts of a dotted key, and gives up in the midst of nested brackets.
"""

from __future__ import annotations

import codecs
import re
import sys
from pathlib import Path
from typing import Any

from evat.files.regular import check_regular
from evat.model import EvatError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOST_BYTES, MOST_LEVELS = 4 << 20, 32
# Texts and comments, which may hold any sign, and what counts. A text that is not closed goes to its end, so that no sign is looked at
# twice; the library then says what is wrong.
_TOKEN = re.compile(
    r'"""(?:[^"\\]+|\\.|"(?!""))*(?:"""|\\?\Z)'
    r"|\'\'\'.*?(?:\'\'\'|\Z)"
    r'|"(?:[^"\\\n]+|\\[^\n])*"?'
    r"|\'[^\'\n]*\'?"
    r"""|\#[^\n]*|[^\s."'\#\[\]{}=,]+|[ \t]+|.""",
    re.DOTALL,
)


class TomlError(EvatError):
    """A TOML file that cannot be read."""


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a file."""
    try:
        check_regular(path)
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise TomlError(f"{path.name}: it has {size / 2**20:.3g} MiB; a TOML file of more than {MOST_BYTES >> 20} MiB is not read.")
        if path.read_bytes()[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
            raise TomlError(f"{path.name}: this is no readable TOML file, but text in UTF-16; TOML is in UTF-8: save the file as that.")
        text = path.read_text(encoding="utf-8-sig")  # some editors put a mark in front
        _check_depth(text, path.name)
        return tomllib.loads(text)
    except OSError as error:
        raise TomlError(f"{path.name}: this is no readable TOML file: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:  # ValueError: no TOML, no UTF-8, or a number of thousands of digits
        raise TomlError(f"{path.name}: this is no readable TOML file: {error}.") from error


def _check_depth(text: str, name: str) -> None:
    """TomlError where a dotted key or brackets in one another have more than MOST_LEVELS levels."""
    dots = brackets = 0
    for match in _TOKEN.finditer(text):
        token = match[0]
        if token == ".":
            dots += 1
        elif token in "[{":
            brackets += 1
        elif token in "]}":
            brackets -= 1
        if token in "\n=,[]{}":
            dots = 0
        if max(dots, brackets) >= MOST_LEVELS:
            line = text.count("\n", 0, match.start()) + 1
            raise TomlError(f"{name}, line {line}: a key or its value has more than {MOST_LEVELS} levels; it is not read.")
