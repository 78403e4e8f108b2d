"""What do all commands share? Consoles, progress bars, and how a typed value is read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from evat.console import err
from evat.files.writing import OutputError, usable
from evat.model import ParameterError
from evat.native import kernel
from evat.units import to_si

Values = Annotated[
    list[str] | None,
    typer.Option("--value", "-v", help="NAME=VALUE of a parameter or constant input, units allowed; repeat it for more."),
]
# Exit statuses; the page on first runs explains them.
FAILED = 1  # the work was done, and what it says is no
REFUSED = 2  # something was asked that cannot be done
STOPPED = 130  # as of a process that Ctrl-C ends; what was done by then is kept
SpeedUnit = Annotated[str, typer.Option(help="Unit in which the speeds of the paper's table 1 are read: m/min or m/s.")]


def _bar() -> Progress:
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TextColumn("{task.percentage:3.0f} %"), TimeRemainingColumn())
    return Progress(*columns, console=err, transient=True)


@contextmanager
def share_done(what: str) -> Iterator[Callable[[float], None]]:
    """A bar that is told the share that is done."""
    with _bar() as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def lines_done(count: int) -> Iterator[Callable[[str], None]]:
    """A bar that is told what comes next, `count` times in all."""
    with _bar() as bar:
        task = bar.add_task("", total=count)
        yield lambda text: bar.update(task, description=text, advance=1)


def picture_beside(table: Path) -> Path:
    """Where the picture of a table goes; OutputError where one would replace the other, or nothing can be written there."""
    picture = table.with_suffix(".png")
    if picture == table:
        raise OutputError(f"--out {table}: the picture is written beside the table under that name; name the table .csv or .parquet.")
    usable(table.parent)
    return picture


def typed_values(texts: list[str] | None) -> dict[str, float | str]:
    """NAME=VALUE texts as values in SI; choices stay names. ParameterError for what is neither."""
    values: dict[str, float | str] = {}
    for text in texts or []:
        name, equals, value = text.partition("=")
        name, value = name.strip(), value.strip()
        if not equals or not value:
            raise ParameterError(f"{text!r}: write NAME=VALUE, for example 'cutting_speed=30 m/min'.")
        known = kernel.variable(name)
        if known.causality not in ("parameter", "input") and name not in kernel.states():
            raise ParameterError(f"{name} is an {known.causality} of the component; it is computed and cannot be set.")
        if known.type == "choice":
            values[name] = value
        elif known.type == "boolean" and value.lower() in ("true", "false"):
            values[name] = float(value.lower() == "true")
        else:
            values[name] = to_si(value, known.unit, name=name)
        known.check(values[name])
    return values


def seconds(text: str, name: str) -> float:
    """A typed time in s."""
    return to_si(text, "s", name=name)


def typed_seconds(text: str | None, name: str) -> float | None:
    """A typed time in s, where one was typed."""
    return None if text is None else seconds(text, name)
