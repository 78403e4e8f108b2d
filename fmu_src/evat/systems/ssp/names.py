"""Which names may the components of a stranger's system have? Such as are names in a page, a table and a file, too."""

from __future__ import annotations

from collections.abc import Iterable

from evat.systems.model import SspError

LONGEST_NAME = 1000
FORMULA = ("=", "+", "-", "@")  # OWASP, CSV injection; the control characters that do so, too, are refused anywhere


def check_name(name: str, others: Iterable[str], where: str) -> None:
    """SspError for a component's name that is there already, or that would be no name where it is shown: in a page, a table, a file."""
    if len(name) > LONGEST_NAME or not name.isprintable():
        kind = f"has {len(name)} characters" if len(name) > LONGEST_NAME else "has control characters in it"
        raise SspError(
            f"{where}: the name of the component {name[:40]!r} {kind}; a name has at most {LONGEST_NAME} that can be printed. Rename it."
        )
    if name.startswith(FORMULA):
        raise SspError(
            f"{where}: component {name[:40]!r}: a spreadsheet takes what begins with {' '.join(FORMULA)} for a formula, and "
            "a table of results has this name at the head of its columns. Rename it."
        )
    if same := [each for each in others if each.casefold() == name.casefold()]:
        twice = "is there twice" if same[0] == name else f"and {same[0]} differ by case alone"
        raise SspError(f"{where}: component {name} {twice}; give each a name of its own.")
