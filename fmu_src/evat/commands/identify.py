"""`evat identify`: which parameters does a measured experiment tell, and what are they?"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, get_args

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from evat.commands.shared import Json, Values, Whole, grouped, one_of, print_json, share_done, stoppable, typed_values
from evat.commands.statuses import STOPPED
from evat.commands.tables import WholeTable
from evat.console import err, headline, marked, note, out, shows_bars
from evat.files.writing import usable_while
from evat.model import Model, ParameterError, Variable
from evat.native import kernel
from evat.units import display, to_si

if TYPE_CHECKING:
    from evat.identification import Identification

JOURNAL = "search.journal"
COLOURS = {"identified": "green", "weak": "yellow", "not identifiable": "red", "withheld": "bold yellow"}


@dataclass(frozen=True)
class HeldOptions:
    """What is held otherwise than the experiment's nominal model has it."""

    value: Values = None
    law: Annotated[str | None, typer.Option(help="Friction law; otherwise the experiment's.")] = None
    effect: Annotated[list[str] | None, typer.Option("--on", "-e", help="Switch on an effect, beside the experiment's; repeat it.")] = None


@dataclass(frozen=True)
class FitOptions:
    """What is minimised, how the least of it is looked for, and on which data."""

    objective: Annotated[str, typer.Option(help="least_squares, huber, or relative (eq. 9 of the paper).")] = "least_squares"
    search: Annotated[
        str, typer.Option(help="ga (genetic algorithm), de (differential evolution), none (start from the nominal model).")
    ] = "ga"
    population: Annotated[int, typer.Option(help="Members of a generation.")] = 64
    generations: Annotated[int, typer.Option(help="Generations at most; the search ends earlier where nothing more is gained.")] = 100
    seed: Annotated[int, typer.Option(help="Of the search; the same seed gives the same result, whatever the number of threads.")] = 0
    hold_out: Annotated[list[str] | None, typer.Option(help="A condition that is kept from the fit, to judge it; repeat it.")] = None
    whiten: Annotated[bool, typer.Option(help="least_squares: take in how noise goes on from sample to sample.")] = True


@dataclass(frozen=True)
class ExecutionOptions:
    """How the work is carried out; the answer does not depend on it."""

    threads: Annotated[int | None, typer.Option(help="Threads; without it one per processor.", min=1)] = None
    dask: Annotated[str | None, typer.Option(help="Address of a dask scheduler on whose workers the search runs.")] = None
    resume: Annotated[bool, typer.Option(help="Go on with the search that OUT holds, to the result it would have had.")] = False


@grouped
def identify(
    *,
    experiment: Annotated[Path, typer.Argument(help="Folder of the experiment, or its experiment.toml.")],
    free: Annotated[list[str], typer.Option("--free", "-f", help="A parameter to find; repeat it for more.")],
    bound: Annotated[
        list[str] | None,
        typer.Option("--bound", "-b", help="NAME=LOW..HIGH, units allowed; without it a 20th to 20 times the nominal value."),
    ] = None,
    held: HeldOptions,
    fit: FitOptions,
    by: ExecutionOptions,
    whole: Whole = False,
    to: Annotated[Path, typer.Option("--out", "-o", help="Folder for parameters (.ssv), JSON, report and the state of the search.")] = Path(
        "identified"
    ),
    as_json: Json = False,
) -> None:
    """Identify parameters from an experiment: estimates with intervals, and a verdict on what the data can tell.

    Ctrl-C stops with the best so far. Example: evat identify rig -f F_C -f sigma0 -b 'F_C=1..30 N' --search de -o fit
    """
    from evat.experiment.compression import read_or_compress
    from evat.identification import Execution, Settings
    from evat.identification import identify as run
    from evat.identification.report import output
    from evat.identification.searching.cluster import Cluster
    from evat.identification.searching.search import check_size
    from evat.models.contact import ContactModel

    model = ContactModel(by.threads)
    _check_names(model, free, held, fit)
    options = {"friction_law": f"--law {held.law}"} if held.law is not None else {}
    options |= {name: f"--on {name}" for name in held.effect or ()}
    settings = Settings(
        on=tuple(held.effect or ()),
        values=typed_values(held.value, options) | ({"friction_law": held.law} if held.law is not None else {}),
        bounds=dict(_bound(text) for text in bound or []),
        objective=fit.objective,  # type: ignore[arg-type]  # checked there, with what is allowed
        search=fit.search,  # type: ignore[arg-type]
        population=fit.population,
        generations=fit.generations,
        seed=fit.seed,
        whiten=fit.whiten,
        hold_out=tuple(fit.hold_out or ()),
    )
    check_size(fit.population, fit.generations, fit.seed)
    with share_done(f"reading {experiment}") as progress:
        read, doubts = read_or_compress(experiment, model, whole=whole, progress=progress)
    for each in doubts:
        note(each)
    with (
        usable_while(to),
        nullcontext() if by.dask is None else Cluster(by.dask) as cluster,
        _progress() as tell,
        stoppable(lambda: _way_on(to)) as cancelled,
    ):
        execution = Execution(to / JOURNAL, by.resume, None if cluster is None else cluster.costs, tell, cancelled)
        answer = run(read, model, free, settings, execution=execution)
        answer = replace(answer, doubts=(*answer.doubts, *doubts))
    if as_json:
        print_json(output.as_json(answer))
    _show(answer)
    for path in output.write(answer, to):
        out.print(f"wrote {path}")
    if answer.stopped:
        err.print(f"stopped: the best so far was written; go on with --resume --out {to}")
        raise typer.Exit(STOPPED)


def _way_on(to: Path) -> str:
    if not (to / JOURNAL).is_file():
        return "the search had not begun."
    return f"the search so far is kept in {to / JOURNAL}; go on with --resume --out {to}"


def _check_names(model: Model, free: list[str], held: HeldOptions, fit: FitOptions) -> None:
    """Typos, told before data are read."""
    from evat.identification.objective import Kind
    from evat.identification.searching.search import Search

    for name in free:
        one_of(name, (variable.name for variable in model.variables if variable.causality == "parameter"), "parameter")
    for name in held.effect or ():
        one_of(name, (each.name for each in model.effects), "effect")
    if held.law is not None:
        one_of(held.law, (each.name for each in kernel.laws()), "friction law")
    one_of(fit.objective, get_args(Kind), "objective")
    one_of(fit.search, get_args(Search), "search")


def _bound(text: str) -> tuple[str, tuple[float, float]]:
    """NAME=LOW..HIGH in SI; a unit after HIGH alone counts for both."""
    name, equals, rest = text.partition("=")
    low, dots, high = rest.partition("..")
    name, low, high = name.strip(), low.strip(), high.strip()
    if not (equals and dots and low and high):
        raise ParameterError(f"{text!r}: write NAME=LOW..HIGH, for example 'F_C=1 N..30 N'.")
    unit = kernel.variable(name).unit
    try:
        float(low)
        low = f"{low} {high.lstrip('+-.0123456789eE').strip()}".strip()
    except ValueError:
        pass
    return name, (to_si(low, unit, name=name), to_si(high, unit, name=name))


@contextmanager
def _progress() -> Iterator[Callable[[str, float], None]]:
    """A bar with time left, whose description follows what is done."""
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=err, transient=True, disable=not shows_bars()) as bar:
        task = bar.add_task("checks", total=1.0)
        last = ["checks"]

        def tell(what: str, share: float) -> None:
            stage = what.partition(",")[0].partition(" ")[0]
            if stage != last[0]:
                note(what)
                bar.reset(task)
                last[0] = stage
            bar.update(task, description=what, completed=share)

        yield tell


def _show(answer: Identification) -> None:
    from evat.identification.report import summary
    from evat.identification.result import error_text

    headline(summary.headline(answer))
    table = WholeTable(
        "parameter", "estimate", "standard error", "90 % interval", "verdict", title=answer.experiment.title, title_justify="left"
    )
    for estimate in answer.estimates:
        interval = (
            f"{_end(estimate.low, estimate.open_below, estimate.variable)} .. {_end(estimate.high, estimate.open_above, estimate.variable)}"
        )
        interval = "withheld" if estimate.verdict == "withheld" else interval
        word = Text(estimate.verdict, COLOURS[estimate.verdict])
        table.add_row(estimate.name, _shown(estimate.value, estimate.variable, 5), error_text(estimate), interval, word)
    out.print(table)
    for estimate in answer.estimates:
        if estimate.why and not answer.stopped:
            out.print(f"{estimate.name}: {estimate.verdict}: {estimate.why}", highlight=False)
        if estimate.advice:
            out.print(f"    to measure: {estimate.advice}", highlight=False)
    for title, fits in (("fitted", answer.fits), ("held out", answer.held_out)):
        for channel, fit in fits.items():
            unit = "" if answer.units[channel] == "1" else f" {answer.units[channel]}"
            known = next((each for each in (fit.noise, fit.of_replicates) if not math.isnan(each)), None)
            noise = "" if known is None else f", noise of the repeats {known:.3g}{unit}"
            rms = f"residual {fit.rms:.3g}{unit} rms"
            out.print(f"{title}, {channel}: error {100 * fit.relative_error:.2f} % (eq. 9), {rms}{noise}", highlight=False)
    for doubt in answer.doubts:
        err.print(marked("doubt:", "bold yellow", doubt))


def _shown(value: float, variable: Variable, digits: int) -> str:
    return display(value, variable, digits=digits)


def _end(value: float, is_open: bool, variable: Variable) -> str:
    return "?" if value != value else "bound" if is_open else _shown(value, variable, 6)
