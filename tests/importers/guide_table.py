"""What does the guide tell of importers? The table of the page on machines: read, held to what a run has found, and written from it.

`EVAT_WRITE_TABLES=1 pytest tests/importers` writes the cells that the run has found, and the versions; `-m "campaign or not campaign"` all.
"""

from __future__ import annotations

import os
import re
from importlib.metadata import version

import pytest
from evat.native.compile import source_root

PAGE = source_root() / "guide" / "machine.md"
# The package whose version stands in the row of an importer, and what stands behind it.
ROWS = {
    "fmpy": ("fmpy", ""),
    "fmpy-container": ("fmpy", ", container FMU"),
    "libcosim": ("libcosimpy", ""),
    "ecos": ("ecospy", " (needs Debian's libtbb12)"),
    "toolbox-container": ("fmu-manipulation-toolbox", ", container FMU"),
}
# Numbers of a cell [%], as they are written.
COLUMNS = {"stick-slip": "{:+.2f} % / {:+.2f} %", "hunting": "{:+.1f} % / {:+.2f} %", "turning": "{:.1f} %"}
NUMBER = re.compile(r"[-+]?\d+\.(\d+)")


def _row(importer: str, text: str) -> re.Match[str]:
    package, rest = ROWS[importer]
    row = re.search(rf"^\| {re.escape(package)} [\d.]+{re.escape(rest)} \|.*$", text, re.MULTILINE)
    assert row, f"{PAGE.name} has no row of {package}{rest}"
    return row


def hold(importer: str, column: str, *percent: float) -> None:
    """Numbers that a run has found, against those of the guide: no more apart than the last digit that is told."""
    text, (package, rest) = PAGE.read_text(encoding="utf-8"), ROWS[importer]
    row = _row(importer, text)
    cells = [cell.strip() for cell in row[0].strip("|").split("|")]
    place = 1 + list(COLUMNS).index(column)
    if os.environ.get("EVAT_WRITE_TABLES"):
        cells[0], cells[place] = f"{package} {version(package)}{rest}", COLUMNS[column].format(*percent)
        PAGE.write_text(text[: row.start()] + f"| {' | '.join(cells)} |" + text[row.end() :], encoding="utf-8")
        return
    told = list(NUMBER.finditer(cells[place]))
    assert len(told) == (len(percent) if cells[place] else 0)
    for number, value in zip(told, percent, strict=False):  # an empty cell claims nothing
        assert float(number[0]) == pytest.approx(value, abs=1.01 * 10.0 ** -len(number[1])), (importer, column, cells[place], percent)
