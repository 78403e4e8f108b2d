"""`evat diagnose`: why do measurement and model disagree?"""

from __future__ import annotations

import importlib.metadata
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from evat.commands.shared import Json, Whole, print_json
from evat.commands.tables import WholeTable
from evat.console import err, headline, marked, note, out, shows_bars

if TYPE_CHECKING:
    from evat.experiment import Experiment
    from evat.gap.answer import Diagnosis
    from evat.model import Model

SHOWN = 0.005  # of probability: less is not worth a line
READING = 0.1  # of the time, usually


def diagnose(
    experiment: Annotated[Path, typer.Argument(help="Folder with experiment.toml and its data files (CSV or Parquet).")],
    to: Annotated[
        Path,
        typer.Option("--out", "-o", help="Folder for diagnosis.json, report.html, corrected.ssv; an earlier diagnosis is replaced."),
    ] = Path("diagnosis"),
    why: Annotated[
        str,
        typer.Option(
            "--explain",
            help="An effect: say why it was chosen or not. A verdict, such as unknown: say by which gates it was reached or missed.",
            metavar="EFFECT|VERDICT",
        ),
    ] = "",
    whole: Whole = False,
    threads: Annotated[
        int | None, typer.Option(help="Threads; without it one per processor. The answer does not depend on it.", min=1)
    ] = None,
    fmu: Annotated[
        Path | None, typer.Option(help="The component's FMU that the report runs; without it one is built on first use and kept.")
    ] = None,
    no_fmu: Annotated[bool, typer.Option("--no-fmu", help="Do not run the FMU; the report says so.")] = False,
    as_json: Json = False,
) -> None:
    """Say where measurement and model disagree, which unmodelled effect causes it, and how far the gap shrinks with it.

    Reads an experiment, fits the nominal model and every effect that the component offers, and answers with probabilities. "None of these",
    "only mis-tuned" and "this data can't tell" are answers, too.

    Example: evat diagnose rig-copper --out rig-copper-diagnosed
    """
    from evat.constants import CONSTANTS
    from evat.experiment.compression import read_or_compress
    from evat.gap import diagnose_with, report
    from evat.gap.report import check_place, explain, explain_verdict, write_diagnosis
    from evat.gap.verdict.judgement import CANNOT_TELL, VERDICTS
    from evat.models.contact import ContactModel

    began, model = time.monotonic(), ContactModel(threads)
    _known(why, model)
    check_place(to)
    _there(fmu)
    with _progress() as tell:
        most = CONSTANTS.diagnosed_samples + 1
        recorded, compressed = read_or_compress(
            experiment, model, whole=whole, most=most, progress=lambda share: tell("reading", READING * share)
        )
        _rival(why, recorded, model)
        answer, comparison = diagnose_with(
            recorded,
            model,
            version=importlib.metadata.version("evat"),
            report=lambda doing, share: tell(doing, READING + (1 - READING) * share),
            whole=whole,
        )
        made_by = {**answer.made_by, "seconds": round(time.monotonic() - began, 1)}
        answer = replace(answer, made_by=made_by, cannot_tell=(*answer.cannot_tell, *compressed))
        tell("writing the report", 0.97)
        path, without = (None, "the command was called with --no-fmu") if no_fmu else _fmu(fmu)
        written = write_diagnosis(answer, comparison, to, fmu=path, without=without)
    if as_json:
        print_json(answer.document())
    headline(report.headline(answer, comparison))
    if answer.verdict != CANNOT_TELL:  # of data that were refused nothing was judged
        out.print(_table(answer))
    for text in compressed:
        out.print(text, highlight=False)
    if path is None and not no_fmu:
        err.print(marked("the FMU was not run:", "bold yellow", without))
    for each in written:
        out.print(f"wrote {each}", highlight=False)
    if why:
        out.print(explain_verdict(answer, why) if why in VERDICTS else explain(comparison, answer, why), highlight=False)


def _known(asked: str, model: Model) -> None:
    """Whether there is such an effect, base law or verdict to explain: asked before data are read."""
    from evat.gap.verdict.judgement import VERDICTS
    from evat.model import ParameterError, nearest
    from evat.native import kernel
    from evat.required_inputs import LAW

    effects, laws = [effect.name for effect in model.effects], [f"{LAW}={law.name}" for law in kernel.laws()]
    if asked and asked not in (*VERDICTS, *effects, *laws):
        names = [*effects, *laws, *VERDICTS]
        raise ParameterError(f"there is no effect, law or verdict {asked!r} to explain; {nearest(asked, names, len(names))}")


def _rival(asked: str, experiment: Experiment, model: Model) -> None:
    """A base law to explain must be one that stands against the experiment's own."""
    from evat.model import ParameterError
    from evat.required_inputs import LAW

    rivals = [rival.name for rival in model.rival_laws(experiment.nominal.values)]
    if asked.startswith(f"{LAW}=") and asked not in rivals:
        raise ParameterError(f"{asked} is not tried against the nominal law of this experiment; tried are {', '.join(rivals)}.")


def _there(fmu: Path | None) -> None:
    from evat.model import ParameterError

    if fmu is None:
        return
    if not fmu.is_file():
        raise ParameterError(f"--fmu {fmu}: there is no such file; leave the option out to have one built, or see --no-fmu.")
    from evat.models.drive import Driver

    Driver(fmu, {})  # asked before minutes of work: it reads the description


def _fmu(given: Path | None) -> tuple[Path | None, str]:
    """The FMU, or why there is none: a machine without a compiler, or without a place to keep an FMU, can diagnose, too."""
    from evat.files.writing import OutputError
    from evat.native.compile import CompileError

    if given is not None:
        return given, ""
    from evat.fmu.host import host_fmu

    try:
        return host_fmu(), ""
    except (CompileError, OutputError) as error:
        return None, str(error)


@contextmanager
def _progress() -> Iterator[Callable[[str, float], None]]:
    """A bar with time left, whose description follows what is done."""
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=err, transient=True, disable=not shows_bars()) as bar:
        task, last = bar.add_task("reading", total=1.0), [""]

        def tell(doing: str, share: float) -> None:
            if doing != last[0]:
                note(doing)
                last[0] = doing
            bar.update(task, description=doing, completed=share)

        yield tell


def _table(answer: Diagnosis) -> WholeTable:
    from evat.gap.report.words import percent

    table = WholeTable("effects", "probability")
    for on, probability in sorted(answer.judgement.probabilities.items(), key=lambda item: (-item[1], item[0]))[:6]:
        if probability > SHOWN:
            table.add_row(str(on), percent(probability))
    table.add_row("something else", percent(answer.judgement.unknown))
    return table
