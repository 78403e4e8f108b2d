"""Which commands are there? Wiring only: each command reads what was typed, calls the package, shows what came out.

The module of a command is loaded when that command is typed: no command waits for what others need, and the list of them shows at once.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import itertools
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from evat.commands.statuses import REFUSED, STOPPED
from evat.console import ask, err, forget_output, marked, note, out, show_warnings

HABITS: dict[str, Any] = {"context_settings": {"help_option_names": ["-h", "--help"]}, "rich_markup_mode": "markdown"}
# Each command: the module of this folder that has it, and the first paragraph of its help, which a test compares.
COMMANDS = {
    "simulate": (
        "contact",
        "Run the contact with a parameter set, a friction law and a motion; write a table and a plot.",
    ),
    "run": (
        "fmus",
        "Reproduce the paper's figures and mean forces by the FMU, for its four materials and three models, or follow a measured motion.",
    ),
    "build": (
        "fmus",
        "Build the FMUs (contact and partners, native, FMI 2.0 and 3.0, for five platforms), the pythonfmu twin, and the systems (.ssp).",
    ),
    "system": (
        "system",
        "Systems of FMUs: the contact in a machine. Ours run by name; so does any flat .ssp of FMI 2 or 3 co-simulation FMUs.",
    ),
    "experiment": (
        "experiment",
        "Measured experiments: begin with a folder of data files, check one, or simulate tests of a contact whose parameters are known.",
    ),
    "identify": (
        "identify",
        "Identify parameters from an experiment: estimates with intervals, and a verdict on what the data can tell.",
    ),
    "diagnose": (
        "diagnose",
        "Say where measurement and model disagree, which unmodelled effect causes it, and how far the gap shrinks with it.",
    ),
    "effects": (
        "effects",
        "List the effects, or show one and plot its signature: forces with and without it, over a cycle and over the conditions.",
    ),
    "sets": (
        "contact",
        "List the shipped parameter sets, or show one: every value with unit and source.",
    ),
    "info": (
        "contact",
        "List variables, friction laws and effects: unit, start, bounds, meaning, source.",
    ),
    "study": (
        "study",
        "Studies of the paper that take a minute: each writes figures and JSON.",
    ),
    "guide": (
        "guide",
        "Open the guide in the browser: a manual with tables of everything, offline.",
    ),
    "calibrate": (
        "calibrate",
        "Fit the constants of the diagnosis's judgement to simulated cases whose truth is known.",
    ),
    "benchmark": (
        "calibrate",
        "Diagnose every experiment in a folder; tests/gap/blind/score.py compares the answers with sealed labels.",
    ),
}


class Commands(TyperGroup):
    """The commands, each loaded when it is typed, listed without loading any, and ended by Ctrl-C with one line and a status of its own."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """As plain text: what draws boxes around it takes twice as long to load as all else that the list of commands needs."""
        super(TyperGroup, self).format_help(ctx, formatter)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args and args[0] not in COMMANDS and (inner := _commands_of_groups(args[0])):
            ctx.fail(f"No such command '{args[0]}'. Did you mean {' or '.join(inner)}?")
        name, listed, rest = super().resolve_command(ctx, args)
        return name, loaded(name) if name in COMMANDS else listed, rest

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            err.print("stopped: what was whole by then is kept.", highlight=False)
            raise typer.Exit(STOPPED) from None


app = typer.Typer(
    name="evat",
    cls=Commands,
    help="Chip-tool friction and elliptical vibration assisted turning as a component.\n\n"
    "`evat build` makes the FMUs, `evat run` shows what they do, `evat simulate` answers a question of your own, "
    "`evat effects` shows what can be switched on, `evat experiment` checks measurements, `evat system` runs the contact in a machine, "
    "`evat study` looks for the conditions of the paper's tests, "
    "`evat guide` opens the manual. "
    "Numbers take units: `--value 'cutting_speed=30 m/min'`; a bare number is SI.\n\n"
    "Ends with status 0 when all is well, 1 when the work was done and something in it failed, 2 when what was asked cannot be done, "
    "130 when it was stopped.",
    **HABITS,
)


def loaded(name: str) -> Any:
    """A command with its options."""
    command = getattr(importlib.import_module(f"evat.commands.{COMMANDS[name][0]}"), name)
    if isinstance(command, typer.Typer):
        return typer.main.get_command(command)
    alone = typer.Typer(add_completion=False, **HABITS)
    alone.command(name)(command)
    return typer.main.get_command(alone)


def _commands_of_groups(name: str) -> list[str]:
    """Where a command of this name is one of a group's: with the group's name before it."""
    groups = {group: getattr(loaded(group), "commands", {}) for group in COMMANDS}
    return [f"'{group} {name}'" for group, commands in groups.items() if name in commands]


def _listed() -> None:
    """Stands in the list for a command that is not loaded."""


for _name, (_, _help) in COMMANDS.items():
    app.command(_name, help=_help)(_listed)


@app.callback(invoke_without_command=True)
def _everything(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show the version and stop.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show warnings, errors and what --json asks for alone.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Tell each stage and how long it took, with the time, instead of a bar.")
    ] = False,
    log_file: Annotated[Path | None, typer.Option("--log-file", help="Add all that is said, and the stages, to this file.")] = None,
) -> None:
    if log_file is not None:
        _log_to(log_file, quiet, verbose)
    else:
        ask(quiet, verbose)
    if version:
        from evat import __version__
        from evat.native import kernel

        out.print(f"evat {__version__}, model {kernel.token()}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(REFUSED)


def _log_to(log_file: Path, quiet: bool, verbose: bool) -> None:
    from evat.files.writing import OutputError, usable

    usable(log_file.parent)
    try:
        ask(quiet, verbose, log_file)
    except OSError as error:
        raise OutputError(f"--log-file {log_file}: it cannot be written ({error.strerror}).") from error
    note(f"evat {' '.join(sys.argv[1:])}")


def _for_all_first(words: list[str]) -> list[str]:
    """The words of a command line with those for all commands in front, wherever they were typed."""
    front, rest = list[str](), list[str]()
    left = iter(words)
    for word in left:
        if word == "--":
            rest += [word, *left]
        elif word == "--log-file":
            front += [word, *itertools.islice(left, 1)]
        elif word in ("--quiet", "--verbose") or word.startswith("--log-file="):
            front.append(word)
        else:
            rest.append(word)
    return front + rest


def main() -> None:
    """The command `evat`: errors of ours, and what the system refuses, as one line on stderr and exit status 2; 130 when stopped."""
    show_warnings()
    atexit.register(gc.freeze)  # looking for circles in all that was loaded takes a second, after which it all goes anyhow
    with suppress(ValueError):  # in a thread that is not the first one nobody sends signals
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # what a scheduler sends ends it as Ctrl-C does: nothing is left behind
    try:
        app(_for_all_first(sys.argv[1:]))
    except OSError as error:  # of what is read, or of standard output; what is written says more (evat.files.writing)
        what = f"{error.filename}: " if error.filename is not None else ""
        _refused(f"{what}{error.strerror or error}. The operating system refuses it; check that file, disk or pipe, and try again.")
    except Exception as error:
        from evat.model import EvatError  # loads numpy, which the help need not wait for

        if not isinstance(error, EvatError):
            raise
        _refused(str(error))
    finally:
        _flush()
        ask()


def _refused(text: str) -> NoReturn:
    with suppress(OSError):
        err.print(marked("evat:", "bold red", text), soft_wrap=True)
    sys.exit(REFUSED)


def _flush() -> None:
    """What standard output does not take is forgotten."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        forget_output()
