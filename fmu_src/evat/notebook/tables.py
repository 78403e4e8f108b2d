"""How does a result look where a notebook or a prompt shows it? A small table, in HTML or as text; texts from files stay texts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from evat.notebook.choice import MOST_SHOWN, chosen, left_out

MOST_ROWS = 40  # in a notebook


@dataclass(frozen=True, slots=True)
class ResultTable:
    """`rows` under their `header`, with a `title` above, `notes` below; as text only those at `brief`, and `rest` tells of the others."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str] = ()
    brief: Sequence[int] = ()
    rest: str = ""

    def html(self) -> str:
        """Beyond MOST_ROWS the rest is counted."""
        cells = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in self.rows[:MOST_ROWS])
        more = [f"and {len(self.rows) - MOST_ROWS} more"] if len(self.rows) > MOST_ROWS else []
        head = "".join(f"<th>{escape(text)}</th>" for text in self.header)
        below = "".join(f"<div>{escape(note)}</div>" for note in (*more, *self.notes) if note)
        return f"<div><b>{escape(self.title)}</b><table><thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table>{below}</div>"

    def text(self) -> str:
        """A line each; without `brief` the first MOST_SHOWN rows."""
        kept = self.brief or range(min(len(self.rows), MOST_SHOWN))
        more = [self.rest] if self.brief else [f"and {len(self.rows) - MOST_SHOWN} more"] if len(self.rows) > MOST_SHOWN else []
        lines = [self.header, *(self.rows[place] for place in kept)]
        wide = [max(map(len, column)) for column in zip(*lines, strict=True)]
        told = ["  " + "  ".join(text.ljust(width) for text, width in zip(line, wide, strict=True)).rstrip() for line in lines]
        return "\n".join([self.title, *told, *(f"  {note}" for note in (*more, *self.notes) if note)])


def number(value: float) -> str:
    return f"{value:.5g}"


def columns_table(title: str, columns: Mapping[str, Any], units: Mapping[str, str], notes: Sequence[str] = ()) -> ResultTable:
    """A row for each column: its unit, least, mean, largest and last value."""
    rows, flat = [], {name: np.ravel(np.asarray(column, dtype=np.float64)) for name, column in columns.items()}
    for name, values in flat.items():
        finite = values[np.isfinite(values)]
        facts = (finite.min(), finite.mean(), finite.max(), finite[-1]) if finite.size else (np.nan,) * 4
        rows.append((name, units.get(name, ""), *(number(float(fact)) for fact in facts)))
    kept = chosen(flat)
    brief, rest = [place for place, name in enumerate(flat) if name in kept], left_out(flat, kept, "shown")
    return ResultTable(title, ("name", "unit", "least", "mean", "largest", "last"), rows, notes, brief, rest)
