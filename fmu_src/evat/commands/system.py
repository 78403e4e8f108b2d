"""`evat system`: run a system of FMUs, sweep over its parameters, ask what averaging saves in it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from evat.commands.shared import Json, keep_record, lines_done, picture_beside, print_json, seconds, share_done, typed_seconds
from evat.commands.statuses import FAILED, STOPPED
from evat.commands.tables import WholeTable
from evat.console import err, marked, out
from evat.files.writing import temporary

if TYPE_CHECKING:
    from evat.systems.model import System
    from evat.systems.values import Value

system = typer.Typer(
    name="system",
    no_args_is_help=True,
    help="Systems of FMUs: the contact in a machine. Ours run by name; so does any flat .ssp of FMI 2 or 3 co-simulation FMUs.",
)
Ssp = Annotated[Path, typer.Argument(help="An .ssp file, or the name of a system of ours, such as stick_slip.")]
Step = Annotated[str | None, typer.Option(help="Communication step, such as '20 us'; a bare number is in s. Without it the system's own.")]
Stop = Annotated[str | None, typer.Option(help="Stop time, such as '20 ms'; a bare number is in s. Without it the system's own.")]
Order = Annotated[Literal["gauss-seidel", "jacobi"], typer.Option(help="One component after the other, or all from the same values.")]
Inputs = Annotated[Literal["linear", "constant"], typer.Option(help="How inputs go on within a step whose end is not known yet.")]
SystemValues = Annotated[
    list[str] | None, typer.Option("--value", "-v", help="COMPONENT.VARIABLE=VALUE, units allowed; repeat it for more.")
]
Sets = Annotated[
    list[str] | None, typer.Option("--set", "-s", help="COMPONENT=SET: an .ssv file or a shipped set of the contact; repeat it for more.")
]


@contextmanager
def _archive(ssp: Path) -> Iterator[Path]:
    """The file that is meant, while a bar shows which FMUs have to be built for it."""
    from evat.fmu import parts
    from evat.systems.ours import archive_of

    with ExitStack() as stack:
        with lines_done(3 * len(parts())) as progress:
            file = stack.enter_context(archive_of(ssp, progress))
        yield file


def _values(system: System, value: list[str] | None, sets: list[str] | None) -> dict[str, dict[str, Value]]:
    from evat.model import ParameterError
    from evat.systems.values import merged, of_work, typed

    of_sets: dict[str, dict[str, Value]] = {}
    for text in sets or []:
        name, equals, which = text.partition("=")
        if not equals or name not in system.components:
            raise ParameterError(f"--set {text!r}: write COMPONENT=SET; components are {', '.join(system.components)}.")
        if [each.partition("=")[0] for each in sets or []].count(name) > 1:
            raise ParameterError(f"--set {text!r}: component {name} has another set, too; keep one.")
        of_sets = merged(of_sets, of_work(system, name, which))
    return merged(of_sets, typed(system, value or []))


@system.command()
def run(
    ssp: Ssp,
    step: Step = None,
    stop: Stop = None,
    value: SystemValues = None,
    sets: Sets = None,
    record: Annotated[
        Path | None, typer.Option("--input", "-i", help="CSV or Parquet with 'time' and inputs as COMPONENT.VARIABLE [unit].")
    ] = None,
    every: Annotated[int | None, typer.Option(help="Keep every n-th step; without it as the system says.")] = None,
    order: Order = "gauss-seidel",
    inputs: Inputs = "linear",
    to: Annotated[
        Path, typer.Option("--out", "-o", help="Result, .csv or .parquet; beside it the plot as .png and a page as .html.")
    ] = Path("system.csv"),
    as_json: Json = False,
) -> None:
    """Run a system; write a table, a plot and a page, and say how the power balance at its bonds came out.

    They go to system.csv, system.png and system.html in the present folder, or to --out and beside it.

    Example: evat system run stick_slip -o stick-slip.parquet
    """
    from evat.files.table import write_trace
    from evat.files.writing import put
    from evat.plots.system import plot_run
    from evat.plots.system_page import page
    from evat.systems.couple import MEANS, NO_INPUTS, Coupled, means_of_last_half, plan
    from evat.systems.model import SystemInterrupted, SystemStopped
    from evat.systems.ssp.read import read
    from evat.systems.values import record as read_record

    beside, report = picture_beside(to), to.with_suffix(".html")
    keep_record(record, to)
    step_size, end = typed_seconds(step, "--step"), typed_seconds(stop, "--stop")
    with _archive(ssp) as file, temporary() as folder:
        system = read(file, folder)
        wanted = plan(system, step_size, end, every, order, inputs)
        given, values = NO_INPUTS if record is None else read_record(system, record), _values(system, value, sets)
        coupled = Coupled(system, values, given)
        for note in (*coupled.notes, *given.beyond(wanted)):
            err.print(marked("note:", "yellow", note), soft_wrap=True)
        with coupled, share_done(f"running {system.name}") as progress:
            try:
                trace, power = coupled.run(wanted, progress)
            except SystemStopped as stopped:
                if stopped.trace.times.size:
                    out.print(f"wrote {write_trace(stopped.trace, to)}, the results until the stop")
                raise
            except SystemInterrupted as interrupted:
                if interrupted.trace.times.size:
                    err.print(f"stopped: wrote {write_trace(interrupted.trace, to)}, the results until then", highlight=False)
                raise typer.Exit(STOPPED) from None
    out.print(f"wrote {write_trace(trace, to)}")
    picture, untold = plot_run(trace, beside, system.title)
    out.print(f"wrote {picture}{f'; {untold}' if untold else ''}", soft_wrap=True)
    files = {to.name: "all signals", beside.name: "the picture", report.name: "this page"}
    out.print(f"wrote {put(report, page(coupled, trace, power, wanted, files, picture, untold), 'the page')}", soft_wrap=True)
    for line in power.advice(wanted.longest, 2 if inputs == "linear" else 1):
        out.print(line, soft_wrap=True)
    if as_json:
        means = {name: {"value": mean, "unit": trace.units[name]} for name, mean in means_of_last_half(trace).items()}
        shares = {name: {"passed": passed, "made": made, "made_or_lost": moved} for name, (passed, made, moved) in power.shares().items()}
        print_json(
            {
                "table": str(to),
                "picture": str(beside),
                "page": str(report),
                MEANS: means,
                "energy": shares,
                "made_by": trace.made_by,
            }
        )


@system.command()
def sweep(
    ssp: Ssp,
    over: Annotated[
        list[str],
        typer.Option(
            help="NAME=FIRST:LAST:COUNT, NAME=VALUE,VALUE or COMPONENT=SET,SET, units allowed; several NAMEs joined by commas get the same."
        ),
    ],
    beside: Annotated[
        list[str] | None,
        typer.Option(help="COMPONENT.VARIABLE=VALUE: the grid once more with this value, dashed in the map; repeat it for more values."),
    ] = None,
    step: Step = None,
    stop: Stop = None,
    value: SystemValues = None,
    sets: Sets = None,
    order: Order = "gauss-seidel",
    inputs: Inputs = "linear",
    dask: Annotated[str | None, typer.Option(help="Address of a dask scheduler on whose workers the runs go.")] = None,
    to: Annotated[Path, typer.Option("--out", "-o", help="Table, .csv or .parquet; the map is written beside it as .png.")] = Path(
        "sweep.csv"
    ),
    as_json: Json = False,
) -> None:
    """Run a system over a grid of its parameters: a table of means over the last half of each run, and a map. Ends with status 1 where a
    run has failed; Ctrl-C keeps the runs that are done.

    Example: evat system sweep evat_turning --over 'contact.amplitude_x=3:9 um:4' --stop '5 ms'

    Beside it conventional turning: --beside contact.amplitude_x=0 --beside contact.amplitude_y=0

    On other machines: `dask scheduler` on one, `dask worker tcp://HOST:8786` on each (evat installed there), --dask tcp://HOST:8786
    """
    from evat.files.table import write_columns
    from evat.identification.searching.cluster import Cluster
    from evat.plots.system import plot_sweep
    from evat.systems import sweep as sweeping
    from evat.systems.couple import plan
    from evat.systems.ssp.read import read
    from evat.systems.values import typed

    picture, broken_off = picture_beside(to), list[bool]()
    wishes = {"step": typed_seconds(step, "--step"), "stop": typed_seconds(stop, "--stop"), "order": order, "inputs": inputs}
    with _archive(ssp) as file, temporary() as folder:
        system = read(file, folder)
        axes = tuple(sweeping.axis(system, text) for text in over)
        sweeping.check_beside_axes(axes, typed(system, value or []))
        values = _values(system, value, sets)
        grids = [{}, typed(system, beside)] if beside else [{}]
        steps = plan(system, **wishes).count  # type: ignore[arg-type]
        workers = sweeping.worth(math.prod(len(each.texts) for each in axes), steps)
        with nullcontext() if dask is None else Cluster(dask) as cluster, share_done(f"sweeping {system.name}") as progress:
            rows, *again = [
                sweeping.sweep(
                    file,
                    axes,
                    values,
                    wishes,
                    lambda done, n=n: progress((n + done) / len(grids)),  # type: ignore[misc]
                    cluster,
                    grid,
                    lambda: broken_off.append(True),
                    workers,
                )
                for n, grid in enumerate(grids)
                if not broken_off
            ]
        swept = sweeping.Sweep(axes, tuple(rows), sweeping.units_of(system), tuple(again[0]) if again else (), system.title)
    if as_json:
        over_axes = [{"name": each.label, "unit": each.unit, "places": each.texts} for each in axes]
        runs = [[{"place": row.place, "means": row.means, "failure": row.failure} for row in some] for some in (swept.rows, swept.beside)]
        print_json({"table": str(to), "axes": over_axes, "units": swept.units, "rows": runs[0], "beside": runs[1]})
    out.print(f"wrote {write_columns(sweeping.columns(axes, rows, swept.units, swept.beside), to)}")
    if swept:
        out.print(f"wrote {plot_sweep(swept, picture)}")
    failed = [row for row in (*swept.rows, *swept.beside) if row.failure and row.failure != sweeping.NOT_RUN]
    table = WholeTable("run", "why it failed")
    for row in failed:
        table.add_row(", ".join(each.texts[place] for each, place in zip(axes, row.place, strict=True)), row.failure)
    if failed:
        err.print(table)
        err.print(f"{len(failed)} of {len(rows) + len(swept.beside)} runs failed; the table holds the others.")
    if broken_off:
        done = sum(not row.failure for row in (*swept.rows, *swept.beside))
        err.print(f"stopped: {done} of {len(grids) * len(rows)} runs were done, and are written.")
        raise typer.Exit(STOPPED)
    if failed:
        raise typer.Exit(FAILED)


@system.command()
def averaging(
    ssp: Ssp,
    step: Annotated[str, typer.Option(help="Step of the averaged run; a whole multiple of the fine one.")] = "1 ms",
    fine: Annotated[str | None, typer.Option(help="Step of the run that follows every cycle; without it the system's own.")] = None,
    stop: Stop = None,
    value: SystemValues = None,
    sets: Sets = None,
    to: Annotated[Path, typer.Option("--out", "-o", help="Table, .csv or .parquet; the plot is written beside it as .png.")] = Path(
        "averaging.csv"
    ),
    as_json: Json = False,
) -> None:
    """Run a system with averaging = cycle in long steps, and again with every cycle: cost and error of both.

    Example: evat system averaging evat_turning --stop 0.1 -v spindle.speed_set=25
    """
    from evat.files.table import write_columns
    from evat.studies.two_scales.plot import plot_cut
    from evat.studies.two_scales.system import compare
    from evat.systems.ssp.read import read

    beside = picture_beside(to)
    long_step, fine_step, end = seconds(step, "--step"), typed_seconds(fine, "--fine"), typed_seconds(stop, "--stop")
    with _archive(ssp) as file, temporary() as folder:
        system = read(file, folder)
        with share_done("following every cycle") as progress:
            comparison = compare(
                system,
                _values(system, value, sets),
                step=long_step,
                fine=fine_step,
                stop=end,
                progress=lambda mode, share: progress(share if mode == "resolved" else 0.0),
            )
    cut = comparison.cut
    if as_json:
        machine = {name: {"largest": largest, "difference": apart} for name, (largest, apart) in comparison.machine().items()}
        facts = {"cheaper": cut.cheaper, "relative_error": cut.relative_error, "typical_error": cut.typical_error, "seconds": cut.seconds}
        print_json({"table": str(to), "picture": str(beside), **facts, "steps": comparison.steps, "machine": machine})
    out.print(f"wrote {write_columns(comparison.columns(), to)}")
    out.print(f"wrote {plot_cut(cut, beside, f'{system.title}, averaged in steps of {1e3 * long_step:g} ms')}")
    for mode, name in (("resolved", "every cycle"), ("cycle", "averaged")):
        out.print(f"{name}: {cut.seconds[mode]:.3g} s for {cut.times[-1] - cut.times[0]:g} s, in steps of {comparison.steps[mode]:g} s")
    worst = cut.times[int(cut.error.argmax())]
    out.print(
        f"{cut.cheaper:.0f} times cheaper; mean forces to {100 * cut.relative_error:.2g} % of the largest, worst from t = {worst:g} s on, "
        f"to {100 * cut.typical_error:.2g} % in half of the steps",
        soft_wrap=True,
    )
    table = WholeTable(
        "output of the machine", "largest value", "largest difference", title="at the ends of the steps, 20 kHz of it and all"
    )
    for name, (largest, apart) in comparison.machine().items():
        table.add_row(name, f"{largest:.3g}", f"{apart:.2g}")
    out.print(table)
