"""What was found out about this kernel before? A JSON file beside the compiled library, which holds for that library alone."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from evat.files.writing import OutputError, put


def key_of(library: Path, sources: Sequence[Path]) -> str:
    """Changes with the library and with the modules that ask it."""
    digest = hashlib.sha256()
    for path in (library, *sources):
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def place_of(library: Path) -> Path:
    """The file beside the library."""
    return library.with_name(f"{library.name}.structure.json")


def _digest(key: str, content: Any) -> str:
    return hashlib.sha256(f"{key}\n{json.dumps(content, sort_keys=True)}".encode()).hexdigest()


def recall(place: Path, key: str) -> Any:
    """What was kept under this key; None where there is nothing, or another key's, or it is not as it was written."""
    try:
        kept = json.loads(place.read_bytes())
        content = kept["content"]
        return content if kept["key"] == key and kept["digest"] == _digest(key, content) else None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def keep(place: Path, key: str, content: Any) -> None:
    """Write it whole or not at all. Where the folder cannot be written nothing is kept, and the next run finds out again."""
    with suppress(OutputError):
        put(place, json.dumps({"key": key, "digest": _digest(key, content), "content": content}, sort_keys=True))
