"""How is a table printed? Whole: names that are too long for the terminal go on in the next line, none is cut."""

from __future__ import annotations

from typing import Any

import rich.table


class WholeTable(rich.table.Table):
    """A table of rich whose texts are never cut."""

    def add_column(self, *head: Any, overflow: Any = "fold", **named: Any) -> None:
        super().add_column(*head, overflow=overflow, **named)
