"""Was the guide built from these very sources? A digest over all that it is made from. Packaging loads this file alone, so stdlib only."""

from __future__ import annotations

import hashlib
from pathlib import Path

SEAL = "made-from.sha256"
PARTS = ("guide", "kernel", "machines", "fmus", "evat")  # folders beside each other
MADE_FROM = (".c", ".css", ".h", ".js", ".md", ".png", ".py", ".toml", ".yml")
MADE_HERE = ("__pycache__", "_guide", "_lib", "_source")


def digest(root: Path) -> str:
    """Over pages, tables and docstrings in the folders below `root`."""
    hashed = hashlib.sha256()
    for part in PARTS:
        for path in sorted((root / part).rglob("*")):
            if path.suffix in MADE_FROM and not set(MADE_HERE) & set(path.relative_to(root).parts):
                hashed.update(f"{path.relative_to(root).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return hashed.hexdigest()


def is_fresh(site: Path, root: Path) -> bool:
    """Whether the site was built from what lies below `root` now."""
    return (site / SEAL).is_file() and (site / SEAL).read_text(encoding="ascii") == digest(root)
