"""What may reach a terminal? Text: what stands in somebody's file is neither a command to the terminal nor markup of ours."""

from __future__ import annotations

import os
import re
import sys
import time
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from evat.headline import Headline

# What a terminal acts on instead of showing it (but for the ends of lines and tabs), what turns the direction of writing round, and halves
# of characters, which stand for bytes of a file's name that are no UTF-8.
_ACTS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    """The text with a name, such as \\x1b, for each sign that a terminal would act on."""
    return _ACTS.sub(lambda match: match[0].encode("unicode_escape").decode("ascii"), text)


class PrintableConsole(Console):
    """A console that shows any text as it stands; style is for what is no plain str (rich.text.Text)."""

    def __init__(self, **named: Any) -> None:
        super().__init__(markup=False, emoji=False, **named)
        self.copied_to: Console | None = None  # where a copy of what is printed goes

    def on_broken_pipe(self) -> None:
        """Whoever reads has seen enough, such as `head`: no error, and what else there is to do is done."""
        self.quiet = True
        if not self.stderr:
            forget_output()

    def print(self, *shown: Any, **named: Any) -> None:
        with told_of("standard error" if self.stderr else "standard output"):
            super().print(*shown, **named)
        if self.copied_to is not None:
            self.copied_to.print(*shown, **named)

    def render_str(self, text: str, **named: Any) -> Text:
        return super().render_str(printable(text), **named)  # here, where it is measured

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):  # here, where all else passes, such as the text beside a bar
            acts = not segment.control and _ACTS.search(segment.text)
            yield Segment(printable(segment.text), segment.style) if acts else segment


@contextmanager
def told_of(stream: str) -> Iterator[None]:
    """An error of the system names the stream that it is of, as it does a file."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or stream
        raise


def forget_output() -> None:
    """What is still to go to standard output goes nowhere: it would be tried again, and complained of, at the very end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


out, err = PrintableConsole(), PrintableConsole(stderr=True)


# What the whole command line was asked for; the callback of every call sets them anew.
_asked: dict[str, Any] = {"verbose": False, "log": None}


def ask(quiet: bool = False, verbose: bool = False, log: Path | None = None) -> None:
    """quiet : only warnings, errors and JSON are shown, no bar; verbose : stages and how long they took; log : a file that gets all that
    is said, and the stages, with the time; it is added to."""
    if (before := _asked["log"]) is not None:
        before.file.close()
    copy = None if log is None else PrintableConsole(file=log.open("a", encoding="utf-8"), width=120, color_system=None)
    _asked.update(verbose=verbose, log=copy)
    out.quiet, out.copied_to, err.copied_to = quiet, copy, copy


def shows_bars() -> bool:
    """Whether a bar may be drawn."""
    return not out.quiet and not _asked["verbose"]


def note(text: str) -> None:
    """A stage: shown where the call is verbose, kept where it is logged."""
    stamped = f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}"
    if _asked["verbose"]:
        err.print(stamped, soft_wrap=True, highlight=False)
    elif _asked["log"] is not None:
        _asked["log"].print(stamped, soft_wrap=True, highlight=False)


def marked(mark: str, style: str, text: str) -> Text:
    """A text with a mark in front, such as "doubt:" in yellow."""
    return Text.assemble((mark, style), " ", printable(text))


def headline(said: Headline) -> None:
    """What is read first, as at the top of a page."""
    colour = {"good": "green", "note": "blue", "attention": "yellow", "bad": "red"}[said.tone]
    out.print(Text(f" {printable(said.status.upper())} ", f"bold reverse {colour}"))
    for line in said.first:
        out.print(Text(printable(line), "bold"))
    out.print(Text(printable(said.sentence), "bold"))
    for reason in said.reasons:
        out.print(Text(f"- {printable(reason)}"))
    if said.share:
        out.print(Text.assemble((printable(said.share), "bold"), " ", printable(said.share_of)))
    if said.next:
        out.print(marked("Next:", f"bold {colour}", said.next))


def show_warnings() -> None:
    """Warnings of libraries, which may quote a file, go the same way as all else."""

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        err.print(marked("warning:", "yellow", str(message)), soft_wrap=True)

    warnings.showwarning = show
