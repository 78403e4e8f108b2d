"""How do tests tell what the FMUs say of themselves? By fmus/evidence.toml: a test holds what it has found to the figure there.

With EVAT_WRITE_TABLES=1 it writes the figure, upwards only: set it to 0 before, where it has become less.
"""

from __future__ import annotations

import math
import os
import re

from evat.fmu.credibility import evidence
from evat.native.compile import source_root

FILE = source_root() / "fmus" / "evidence.toml"
SLACK = 1.1  # other platforms round otherwise


def hold(name: str, deviation: float) -> None:
    """`deviation` [%] is no worse than what is told."""
    told = next(each.largest_deviation for each in evidence() if each.name == name)
    if os.environ.get("EVAT_WRITE_TABLES") and deviation > told:
        digit = 10.0 ** (math.floor(math.log10(deviation)) - 1)
        text = FILE.read_text(encoding="utf-8")
        place = text.index(f'name = "{name}"')
        row = re.compile(r"^largest_deviation = (.*)$", re.MULTILINE).search(text, place)
        assert row
        if deviation > float(row[1]):
            FILE.write_text(f"{text[: row.start(1)]}{math.ceil(deviation / digit) * digit:.2g}{text[row.end(1) :]}", encoding="utf-8")
        return
    assert deviation <= SLACK * told, f"{name}: {deviation:.3g} % is found, {told:.3g} % is told in {FILE.name}"
