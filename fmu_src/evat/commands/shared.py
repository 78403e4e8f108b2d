"""What do all commands share? Consoles, progress bars, and how a typed value is read."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from evat.commands.statuses import STOPPED
from evat.console import err, note, out, shows_bars, told_of
from evat.files.json_values import json_value
from evat.files.writing import OutputError, usable
from evat.model import ParameterError, nearest
from evat.native import kernel
from evat.units import to_si

Values = Annotated[
    list[str] | None,
    typer.Option("--value", "-v", help="NAME=VALUE of a parameter or constant input, units allowed; repeat it for more."),
]
SpeedUnit = Annotated[str, typer.Option(help="Unit in which a set's speeds from the paper's table 1 are read: m/min or m/s.")]


Json = Annotated[bool, typer.Option("--json", help="The answer as JSON on standard output; nothing else is printed there.")]
Whole = Annotated[
    bool,
    typer.Option(
        "--whole", help="Take a record as it is, and all of it, however long; without it trials of more than a million rows are compressed."
    ),
]
PATIENCE = 2.5  # s after Ctrl-C
TABLES = (".csv", ".parquet", ".pq")
KEYWORD = inspect.Parameter.KEYWORD_ONLY


def _bar() -> Progress:
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TextColumn("{task.percentage:3.0f} %"), TimeRemainingColumn())
    return Progress(*columns, console=err, transient=True, disable=not shows_bars())


@contextmanager
def share_done(what: str) -> Iterator[Callable[[float], None]]:
    """A bar that is told the share that is done."""
    with _bar() as bar, noted(what):
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def noted(what: str) -> Iterator[None]:
    """A stage, told with the time it took."""
    began = time.monotonic()
    note(what)
    yield
    note(f"{what}: {time.monotonic() - began:.1f} s")


@contextmanager
def lines_done(count: int) -> Iterator[Callable[[str], None]]:
    """A bar that is told what comes next, `count` times in all."""
    with _bar() as bar:
        task = bar.add_task("", total=count)

        def tell(text: str) -> None:
            note(text)
            bar.update(task, description=text, advance=1)

        yield tell


def picture_beside(table: Path) -> Path:
    """Where the picture of a table goes; OutputError where the table is of no kind that is written, or nothing can be written there."""
    if table.suffix.lower() not in TABLES:
        raise OutputError(f"--out {table}: a table of the kind {table.suffix!r} cannot be written; name it .csv or .parquet.")
    if table.is_dir():
        raise OutputError(f"--out {table}: this is a folder; name a file in it, such as {table / 'table.csv'}.")
    usable(table.parent)
    return table.with_suffix(".png")


def keep_record(record: Path | None, to: Path) -> None:
    """ParameterError where a result would take the place of the record that it is made from."""
    if record is not None and record.exists() and to.exists() and to.samefile(record):
        raise ParameterError(f"--input and --out are both {to}: the result would take the record's place; name another table (--out).")


def print_json(document: Any) -> None:
    """The answer of a command as JSON, the only thing on standard output; quiet or not."""
    try:
        with told_of("standard output"):
            sys.stdout.write(json.dumps(json_value(document), indent=1, ensure_ascii=False, allow_nan=False) + "\n")
            sys.stdout.flush()
    except BrokenPipeError:  # as of all else that is printed
        out.on_broken_pipe()
    out.quiet = True


def one_of(name: str, known: Iterable[str], what: str) -> str:
    """The name, where it is known; ParameterError with the nearest otherwise."""
    names = list(known)
    if name not in names:
        raise ParameterError(f"there is no {what} {name!r}; {nearest(name, names, len(names))}")
    return name


def only(context: typer.Context, acts: bool, where: str, *names: str) -> None:
    """ParameterError where one of these parameters of a command was typed and does not act, which it does "with" or "without" another."""
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if not acts and parameter.name in names and source is not None and source.name == "COMMANDLINE":
            todo = "leave out one of both" if where.startswith("without") else "give both, or leave it out"
            raise ParameterError(f"{parameter.opts[0]} acts only {where}; {todo}.")


def typed_values(texts: list[str] | None, options: Mapping[str, str] | None = None) -> dict[str, float | str]:
    """NAME=VALUE texts as values in SI; choices stay names. ParameterError for what is neither, and for a name that is there twice.
    options: names that other options of the command say already, such as "--law lugre"."""
    values: dict[str, float | str] = {}
    said = dict(options or {})
    for text in texts or []:
        name, equals, value = text.partition("=")
        name, value = name.strip(), value.strip()
        if not equals or not value:
            raise ParameterError(f"{text!r}: write NAME=VALUE, for example 'cutting_speed=30 m/min'.")
        if name in said:
            raise ParameterError(f"{name} is given twice, by {said[name]} and by --value '{name}={value}'; keep one.")
        said[name] = f"--value '{name}={value}'"
        known = kernel.variable(name)
        if known.causality not in ("parameter", "input") and name not in kernel.states():
            raise ParameterError(f"{name} is computed by the component and cannot be set.")
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


@contextmanager
def stoppable(kept: Callable[[], str]) -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed. What does not come to its end within PATIENCE after that is ended; `kept` says what remains then."""
    asked, before = list[bool](), signal.getsignal(signal.SIGINT)

    def end() -> None:
        err.print(f"stopped: {kept()}", highlight=False)
        err.show_cursor()
        os._exit(STOPPED)  # what is at work now asks nobody

    late = threading.Timer(PATIENCE, end)
    late.daemon = True

    def stop(number: int, frame: object) -> None:
        asked.append(True)
        signal.signal(signal.SIGINT, before)  # pressed again it ends the process as usual
        late.start()

    signal.signal(signal.SIGINT, stop)
    try:
        yield lambda: bool(asked)
    finally:
        late.cancel()
        signal.signal(signal.SIGINT, before)


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """A command that takes options that belong together as one value, a dataclass of them: Typer, which knows single ones, is given its
    fields, and nothing of it shows on the command line."""
    signature, hints = inspect.signature(command), get_type_hints(command, include_extras=True)
    groups = {name: hints[name] for name in signature.parameters if dataclasses.is_dataclass(hints[name])}
    options: dict[str, inspect.Parameter] = {}
    for name, parameter in signature.parameters.items():
        own = _options_of(groups[name]) if name in groups else [parameter.replace(kind=KEYWORD, annotation=hints[name])]
        options |= {option.name: option for option in own}

    @functools.wraps(command)
    def called(**given: Any) -> None:
        held = {name: group(**{field.name: given.pop(field.name) for field in dataclasses.fields(group)}) for name, group in groups.items()}
        command(**given, **held)

    vars(called)["__signature__"] = signature.replace(parameters=list(options.values()))
    called.__annotations__ = {name: option.annotation for name, option in options.items()}
    return called


def _options_of(group: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    return [
        inspect.Parameter(
            field.name,
            KEYWORD,
            default=inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default,
            annotation=hints[field.name],
        )
        for field in dataclasses.fields(group)
    ]
