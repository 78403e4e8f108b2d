"""`evat build`, `evat run`: the FMUs as files, and what they do with the paper's materials or a measured motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from evat import parameter_sets
from evat.commands.shared import Json, SpeedUnit, Values, grouped, lines_done, only, print_json, share_done, typed_seconds, typed_values
from evat.commands.tables import WholeTable
from evat.console import out
from evat.files.writing import usable
from evat.native import kernel
from evat.paper.tables import materials, mean_relative_error

if TYPE_CHECKING:
    from evat.studies.record import Columns


def build(
    to: Annotated[Path, typer.Option("--out", "-o", help="Folder for the FMUs.")] = Path("build/out/fmus"),
    host_only: Annotated[bool, typer.Option(help="Binaries for this machine's platform only.")] = False,
    as_json: Json = False,
) -> None:
    """Build the FMUs (contact and partners, native, FMI 2.0 and 3.0, for five platforms), the pythonfmu twin, and the systems (.ssp)."""
    from evat import fmu
    from evat.fmu import host, python_fmu
    from evat.native.compile import TARGETS, host_target
    from evat.systems.declared import names
    from evat.systems.ssp import write, write_full

    usable(to)
    count = 2 * len(fmu.parts()) * (3 if host_only else 2 + len(TARGETS))
    with lines_done(count + 2 * len(names()) + 1) as progress:
        paths = [*(host.build_all(to, progress) if host_only else host.build_for_all(to, progress))]
        paths += [*write.write_all(to, to, progress), *write_full.write_all(to, to, progress)]
        progress("pythonfmu twin")
        paths.append(python_fmu.build_python_fmu(to / "EvatContactPython.fmu"))
    if as_json:
        targets = [host_target().fmi3_folder] if host_only else list(TARGETS)
        print_json({"platforms": targets, "written": [{"path": str(path), "bytes": path.stat().st_size} for path in paths]})
    for path in paths:
        out.print(f"wrote {path} ({path.stat().st_size / 1e6:.2f} MB)")


@dataclass(frozen=True)
class RecordOptions:
    """Where the columns of a record are, and how much of it is used."""

    time: Annotated[str, typer.Option("--time", help="With --record: header of the clock.")] = "time"
    velocity: Annotated[str | None, typer.Option(help="With --record: header of the slip velocity.")] = None
    position: Annotated[str | None, typer.Option(help="With --record: header of the position, where no velocity was measured.")] = None
    force: Annotated[str, typer.Option(help="With --record: header of the friction force.")] = "friction_force"
    force_sign: Annotated[float, typer.Option(help="With --record: -1 where the force counts against the motion.")] = 1.0
    begin: Annotated[str | None, typer.Option(help="With --record: first time used, such as '20 ms'.")] = None
    end: Annotated[str | None, typer.Option(help="With --record: last time used, such as '1 min'.")] = None


@grouped
def run(
    *,
    context: typer.Context,
    record: Annotated[Path | None, typer.Option(help="A measured motion to drive the FMU with, instead of the paper's materials.")] = None,
    parameters: Annotated[str, typer.Option("--set", "-s", help="With --record: parameter set.")] = "tribometer-5n",
    value: Values = None,
    columns: RecordOptions,
    family: Annotated[str, typer.Option(help="Without --record: regularised or published sets.")] = "regularised",
    speed_unit: SpeedUnit = "m/min",
    to: Annotated[Path, typer.Option("--out", "-o", help="Folder for figures, tables and report.")] = Path("runs"),
    as_json: Json = False,
) -> None:
    """Reproduce the paper's figures and mean forces by the FMU, for its four materials and three models, or follow a measured motion.

    Example: evat run --record test.txt --time 'Time [s]' --position 'Position [mm]' --force 'Friction [uN]' --force-sign -1
    """
    only(context, record is not None, "with --record", "parameters", "value", *vars(columns))
    only(context, record is None, "without --record", "family")
    usable(to)
    if record is None:
        _run_materials(family, speed_unit, to, as_json)
        return
    from evat.studies.record import Columns

    parameter_set = parameter_sets.load(parameters, speed_unit=speed_unit)
    values = kernel.check_values({**parameter_set.values, **typed_values(value)})
    first, last = typed_seconds(columns.begin, "--begin"), typed_seconds(columns.end, "--end")
    between = (float("-inf") if first is None else first, float("inf") if last is None else last)
    named = Columns(columns.time, columns.force, columns.velocity, columns.position, columns.force_sign)
    _run_record(record, named, parameter_set, values, between, to, as_json)


def _host_fmu(version: Literal[2, 3], to: Path) -> Path:
    """The contact's FMU for this machine beside the results that it gives."""
    from evat.files.writing import put
    from evat.fmu.host import host_fmu

    with lines_done(3) as progress:
        built = host_fmu(version, progress=progress)
    return put(to / built.name, built.read_bytes())


def _run_record(
    record: Path,
    columns: Columns,
    parameter_set: parameter_sets.ParameterSet,
    values: dict[str, float],
    between: tuple[float, float],
    to: Path,
    as_json: bool,
) -> None:
    from evat.plots.cycles import plot_record
    from evat.studies.record import follow_record

    built = _host_fmu(2, to)
    with share_done(f"following {record.name}") as progress:
        result = follow_record(built, record, columns, kernel.by_choice(values), parameter_set.effects, between=between, progress=progress)
    residual = f"residual {result.residual_rms:.3g} N RMS, {100 * result.residual_share:.1f} % of the measured force"
    title = f"{record.name}, {parameter_set.name}: {residual}"
    picture = plot_record(result.times, result.velocity, result.measured, result.trace["friction_force"], to / "record.png", title)
    if as_json:
        rms = {"residual_rms": {"value": result.residual_rms, "unit": "N"}, "residual_share": result.residual_share}
        print_json({"record": str(record), "set": parameter_set.name, **rms, "samples": result.times.size, "picture": str(picture)})
    out.print(title)
    out.print(f"wrote {picture}")


def _run_materials(family: str, speed_unit: str, to: Path, as_json: bool) -> None:
    from evat.studies import main_job, main_job_report
    from evat.studies.paper.domain import condition_caveats, domain_shares

    built, total = _host_fmu(3, to), main_job.case_count()
    with share_done("driving the FMU") as progress:
        cases = main_job.run_cases(built, family, speed_unit, lambda n: progress(n / total))
    figures = main_job.plot_cases(cases, to)
    shares = tuple(domain_shares(material) for material in materials())
    main_job_report.write_means(cases, to / "means.csv")
    page = main_job_report.write_report(cases, figures, shares, family, speed_unit, to, built)
    if as_json:
        written = [str(path) for path in (*figures, to / "means.csv", page)]
        print_json({"means": main_job_report.means(cases), "caveats": list(condition_caveats(shares)), "written": written})
    recomputed = ", ".join(f"{model.title} {100 * mean_relative_error(name):.1f} %" for name, model in main_job.MODELS.items())
    out.print(f"mean error of the paper's own calculation, recomputed from its table 2: {recomputed}", highlight=False)
    for conditions, what in (
        (main_job.INFERRED, "from the measured means themselves (evat study paper), not known"),
        (
            main_job.GUESSED,
            "the component's start values, not those of the paper's tests; compare models with each other, not with measurements",
        ),
    ):
        table = WholeTable(*main_job_report.means_columns(), title_justify="left", collapse_padding=True)
        for line in main_job_report.means_table(cases, conditions):
            table.add_row(*line)
        table.title = f"{conditions} conditions: {what}; cycle means [N]"
        out.print(table)
    for text in condition_caveats(shares):
        out.print(f"note: {text}", highlight=False)
    for path in (*figures, to / "means.csv", page):
        out.print(f"wrote {path}")
