"""What do half and twice each constant do to the score of a stored set of cases? As a campaign has found, kept beside the calibration."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from evat.model import EvatError

STORED = Path(__file__).with_name("sensitivity.json")


def read(path: Path = STORED) -> dict[str, Any]:
    """`constants`, by name, each with its cases and what it was `made` with (digests of kernel and table); empty where nothing is kept."""
    if not path.is_file():
        return {}
    try:
        held: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        if "constants" in held:
            return held
    except (OSError, ValueError, RecursionError, TypeError):
        pass
    raise EvatError(f"{path}: it is damaged. Install evat again, or make it anew with `evat calibrate --sensitivity --store`.")
