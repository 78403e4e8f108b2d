"""How does a result look where a notebook shows it? A small table in HTML; texts from files stay texts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

MOST_ROWS = 40


def table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]], notes: Sequence[str] = ()) -> str:
    """An HTML table with a title; beyond MOST_ROWS the rest is counted."""
    shown = list(rows)
    cells = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in shown[:MOST_ROWS])
    more = [f"and {len(shown) - MOST_ROWS} more"] if len(shown) > MOST_ROWS else []
    head = "".join(f"<th>{escape(text)}</th>" for text in header)
    below = "".join(f"<div>{escape(note)}</div>" for note in (*more, *notes) if note)
    return f"<div><b>{escape(title)}</b><table><thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table>{below}</div>"


def number(value: float) -> str:
    return f"{value:.5g}"


def columns_table(title: str, columns: Mapping[str, Any], units: Mapping[str, str], notes: Sequence[str] = ()) -> str:
    """A row for each column: its unit, least, mean, largest and last value."""
    rows = []
    for name, column in columns.items():
        values = np.asarray(column, dtype=np.float64)
        finite = values[np.isfinite(values)]
        facts = (finite.min(), finite.mean(), finite.max(), finite[-1]) if finite.size else (np.nan,) * 4
        rows.append((name, units.get(name, ""), *(number(float(fact)) for fact in facts)))
    return table(title, ("name", "unit", "least", "mean", "largest", "last"), rows, notes)
