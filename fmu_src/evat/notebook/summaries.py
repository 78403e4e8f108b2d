"""How does a fit read as text? The summary that users of lmfit know: what was fitted, each variable, correlations, doubts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

LEAST_CORRELATION = 0.1


@dataclass(frozen=True, slots=True)
class FitRow:
    """One variable of a fit; texts are ready to be read."""

    name: str
    value: str
    error: str
    interval: str
    start: str
    verdict: str


def summary(facts: Mapping[str, str], rows: Sequence[FitRow], correlations: Mapping[tuple[str, str], float], notes: Sequence[str]) -> str:
    """All of it, a line each."""
    wide = max(map(len, facts), default=0)
    lines = ["[[Fit]]", *(f"    {name:<{wide}} = {text}" for name, text in facts.items()), "[[Variables]]"]
    wide = max((len(row.name) for row in rows), default=0) + 1
    lines += [
        f"    {row.name + ':':<{wide}} {row.value} +/- {row.error}, 90 % {row.interval} (init = {row.start}): {row.verdict}" for row in rows
    ]
    strong = sorted(((pair, each) for pair, each in correlations.items() if abs(each) >= LEAST_CORRELATION), key=lambda item: -abs(item[1]))
    if strong:
        lines.append(f"[[Correlations]] (below {LEAST_CORRELATION:g} not shown)")
        lines += [f"    C({first}, {second}) = {each:+.4f}" for (first, second), each in strong]
    if notes:
        lines += ["[[Doubts]]", *(f"    {note}" for note in notes)]
    return "\n".join(lines)
