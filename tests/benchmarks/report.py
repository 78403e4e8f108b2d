"""How are the figures of all benchmarks laid before the reader? One table: what, measured, wanted, limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO

from rich.console import Console
from rich.table import Table


@dataclass(frozen=True)
class Row:
    """One line of the table. wanted: the project's aim, where it has one. limit: what the figure could be at best, and why."""

    what: str
    measured: str
    wanted: str = ""
    limit: str = ""


class Summary:
    """Takes the lines as the benchmarks find them."""

    def __init__(self, rows: list[Row]) -> None:
        self._rows = rows

    def add(self, what: str, measured: str, *, wanted: str = "", limit: str = "") -> None:
        self._rows.append(Row(what, measured, wanted, limit))


def as_text(rows: Sequence[Row]) -> str:
    table = Table("what", "measured", "wanted", "limit", title="processor time: least of several rounds in turn", title_justify="left")
    for row in rows:
        table.add_row(row.what, row.measured, row.wanted, row.limit)
    text = StringIO()
    Console(file=text, width=170).print(table)
    return text.getvalue()
