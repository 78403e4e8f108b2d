"""Which commands are there? Wiring only: each command reads what was typed, calls the package, shows what came out."""

from __future__ import annotations

import atexit
import gc
import importlib.metadata
import itertools
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn

import typer
from rich.console import Group
from rich.padding import Padding
from rich.table import Column, Table
from rich.text import Text
from typer.core import TyperGroup

from evat import parameter_sets
from evat.commands.calibrate import benchmark, calibrate
from evat.commands.diagnose import diagnose
from evat.commands.effects import effects
from evat.commands.experiment import experiment
from evat.commands.guide import guide
from evat.commands.identify import identify
from evat.commands.shared import (
    REFUSED,
    STOPPED,
    Json,
    SpeedUnit,
    Values,
    lines_done,
    one_of,
    picture_beside,
    print_json,
    share_done,
    typed_seconds,
    typed_values,
)
from evat.commands.study import study
from evat.commands.system import system
from evat.console import ask, err, marked, note, out, printable, show_warnings
from evat.files.writing import OutputError, usable
from evat.model import Effect, EvatError, Law, ParameterError, Variable, nearest
from evat.native import kernel
from evat.paper_tables import materials
from evat.required_inputs import KINEMATICS, MOTION
from evat.units import display

if TYPE_CHECKING:
    from evat.studies.record import Columns


class Commands(TyperGroup):
    """The commands, each of which Ctrl-C ends with one line and a status of its own."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            err.print("stopped: what was whole by then is kept.", highlight=False)
            raise typer.Exit(STOPPED) from None


app = typer.Typer(
    name="evat",
    cls=Commands,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode="markdown",
    help="Chip-tool friction and elliptical vibration assisted turning as a component.\n\n"
    "`evat build` makes the FMUs, `evat run` shows what they do, `evat simulate` answers a question of your own, "
    "`evat effects` shows what can be switched on, `evat experiment` checks measurements, `evat system` runs the contact in a machine, "
    "`evat study` looks for the conditions of the paper's tests, "
    "`evat guide` opens the manual. "
    "Numbers take units: `--value 'cutting_speed=30 m/min'`; a bare number is SI.\n\n"
    "Ends with status 0 when all is well, 1 when the work was done and something in it failed, 2 when what was asked cannot be done, "
    "130 when it was stopped.",
)
Effects = Annotated[
    list[str] | None,
    typer.Option(
        "--effect", "-e", help="Switch on an effect (`evat effects` lists them); repeat it for more. A set's own effects stay on."
    ),
]

app.command()(effects)
app.add_typer(experiment)
app.command()(identify)
app.command()(diagnose)
app.command()(calibrate)
app.command()(benchmark)
app.add_typer(system)
app.add_typer(study)
app.command()(guide)


def _described(heading: str, facts: str, text: str) -> Group:
    """An entry of a list that reads at any width: names are never cut."""
    head = Text.assemble((printable(heading), "bold"), f"  {facts}" if facts else "", overflow="fold")
    return Group(Padding(head, (0, 0, 0, 2)), Padding(Text(printable(text), overflow="fold"), (0, 0, 0, 6)))


def _facts(variable: Variable) -> str:
    start = "" if variable.causality in ("output", "local", "independent") else display(variable.start, variable)
    bounds = (
        ""
        if variable.type in ("choice", "boolean")
        else f"{variable.min:g} .. {variable.max:g} {'' if variable.unit == '1' else variable.unit}"
    )
    return "; ".join(filter(None, (start, ", ".join(variable.choices) or bounds.strip())))


@app.command()
def info(
    name: Annotated[str | None, typer.Argument(help="A variable, friction law or effect; without it everything is listed.")] = None,
    as_json: Json = False,
) -> None:
    """List variables, friction laws and effects: unit, start, bounds, meaning, source.

    Example: evat info F_C
    """
    laws, effects = kernel.laws(), kernel.effects()
    entries: tuple[Law | Effect, ...] = (*laws, *effects)
    own = {v.name for entry in entries if entry.name == name for v in entry.variables}
    listed = [v for v in kernel.variables() if name is None or v.name == name or v.name in own]
    if not listed and name not in {entry.name for entry in entries}:
        names = [*(entry.name for entry in entries), *(v.name for v in kernel.variables())]
        raise ParameterError(f"there is no variable, friction law or effect {name!r}; {nearest(name or '', names, 0)}")
    if as_json:
        print_json(
            {
                "friction_laws": [_entry(law) for law in laws if name in (None, law.name)],
                "effects": [_entry(effect) for effect in effects if name in (None, effect.name)],
                "variables": [_variable(variable) for variable in listed],
            }
        )
    groups: dict[str, tuple[Law | Effect, ...]] = {"friction laws (friction_law)": laws, "effects": effects}
    for title, group in groups.items():
        shown = [entry for entry in group if name in (None, entry.name)]
        if shown:
            out.print(Text(title, "bold underline"))
        for entry in shown:
            out.print(_described(entry.name, "", f"{entry.meaning}. [{entry.source}]\n{entry.equation}"), highlight=False)
    for causality in ("input", "parameter", "output", "local"):
        rows = [v for v in listed if v.causality == causality]
        if rows:
            out.print(Text(f"{causality}s: start; allowed", "bold underline"))
        for variable in rows:
            out.print(_described(variable.name, _facts(variable), f"{variable.meaning}. [{variable.source}]"), highlight=False)


def _entry(entry: Law | Effect) -> dict[str, object]:
    return {
        "name": entry.name,
        "meaning": entry.meaning,
        "equation": entry.equation,
        "source": entry.source,
        "variables": [variable.name for variable in entry.variables],
    }


def _variable(variable: Variable) -> dict[str, object]:
    return {
        name: getattr(variable, name)
        for name in ("name", "unit", "start", "min", "max", "choices", "type", "causality", "variability", "meaning", "source")
    }


@app.command()
def sets(
    name: Annotated[str | None, typer.Argument(help="A shipped set or an .ssv file; without it the shipped sets are listed.")] = None,
    speed_unit: SpeedUnit = "m/min",
    strict: Annotated[bool, typer.Option(help="Refuse a set that violates the paper's eq. 7 within its speed range.")] = False,
    save: Annotated[Path | None, typer.Option(help="Write the set as an SSP parameter file (.ssv).")] = None,
    as_json: Json = False,
) -> None:
    """List the shipped parameter sets, or show one: every value with unit and source.

    Example: evat sets published/inconel-718
    """
    if name is None:
        titles = {each: parameter_sets.load(each, speed_unit=speed_unit).title for each in parameter_sets.names()}
        if as_json:
            print_json(titles)
        table = Table(Column("set", no_wrap=True), "what it is")
        for each, title in titles.items():
            table.add_row(each, title)
        out.print(table)
        return
    parameter_set = parameter_sets.load(name, speed_unit=speed_unit, strict=strict)
    if as_json:
        values = {key: {"value": value, "unit": kernel.variable(key).unit} for key, value in kernel.by_choice(parameter_set.values).items()}
        print_json(
            {
                "name": parameter_set.name,
                "title": parameter_set.title,
                "values": {key: {**each, "source": parameter_set.sources.get(key, "")} for key, each in values.items()},
                "effects": parameter_set.effects,
                "notes": parameter_set.notes,
            }
        )
    table = Table(
        Column("variable", no_wrap=True),
        "value",
        "SI",
        "source",
        title=f"{parameter_set.name}: {parameter_set.title}",
        title_justify="left",
    )
    for key, value in parameter_set.values.items():
        known = kernel.variable(key)
        si = "" if known.type in ("choice", "boolean") else f"{value:g} {known.unit}"
        table.add_row(key, display(value, known), si, parameter_set.sources.get(key, ""))
    out.print(table)
    out.print(f"effects on: {', '.join(parameter_set.effects) or 'none'}")
    for each in parameter_set.notes:
        out.print(f"note: {each}")
    if save is not None:
        out.print(f"wrote {parameter_sets.save_ssv(parameter_set, save)}")


@app.command()
def build(
    to: Annotated[Path, typer.Option("--out", help="Folder for the FMUs.")] = Path("build/out/fmus"),
    host_only: Annotated[bool, typer.Option(help="Binaries for this machine's platform only.")] = False,
    as_json: Json = False,
) -> None:
    """Build the FMUs (contact and partners, native, FMI 2.0 and 3.0, for five platforms), the pythonfmu twin, and the systems (.ssp)."""
    from evat import fmu
    from evat.fmu import python_fmu
    from evat.native.compile import TARGETS, host_target
    from evat.systems import write, write_full
    from evat.systems.declared import names

    targets = [host_target().fmi3_folder] if host_only else list(TARGETS)
    usable(to)
    with lines_done(2 * len(fmu.parts()) * (2 + len(targets)) + 2 * len(names()) + 1) as progress:
        paths = [*fmu.build_all(to, targets, progress)]
        paths += [*write.write_all(to, to, progress), *write_full.write_all(to, to, progress)]
        progress("pythonfmu twin")
        paths.append(python_fmu.build_python_fmu(to / "EvatContactPython.fmu"))
    if as_json:
        print_json({"platforms": targets, "written": [{"path": str(path), "bytes": path.stat().st_size} for path in paths]})
    for path in paths:
        out.print(f"wrote {path} ({path.stat().st_size / 1e6:.2f} MB)")


@app.command()
def simulate(
    parameters: Annotated[str | None, typer.Option("--set", "-s", help="A shipped set or an .ssv file.")] = None,
    value: Values = None,
    effect: Effects = None,
    law: Annotated[str | None, typer.Option(help="Friction law; the same as --value friction_law=...")] = None,
    principle: Annotated[str | None, typer.Option(help="Shear-angle principle.")] = None,
    motion: Annotated[
        Path | None,
        typer.Option(
            "--input", "-i", help="CSV or Parquet with a column 'time' and columns named after inputs, e.g. 'slip_velocity [mm/s]'."
        ),
    ] = None,
    cycles: Annotated[float, typer.Option(help="Without --input: how many vibration cycles.")] = 5,
    samples: Annotated[int, typer.Option(help="Without --input: samples per cycle.")] = 200,
    speed_unit: SpeedUnit = "m/min",
    to: Annotated[Path, typer.Option("--out", "-o", help="Result, .csv or .parquet; the plot is written beside it as .png.")] = Path(
        "evat.csv"
    ),
    as_json: Json = False,
) -> None:
    """Run the contact with a parameter set, a friction law and a motion; write a table and a plot.

    Example: evat simulate -s regularised/al-7075-t6 --law lugre -v 'cutting_speed=20 m/min' -v feed=50um -o cut.csv
    """
    if as_json:
        out.quiet = True
    from evat.files.table import read_table, write_trace
    from evat.files.text import RecordError
    from evat.models.simulate import SHOWN
    from evat.models.simulate import simulate as run_contact
    from evat.plots.cycles import plot_trace

    values: dict[str, float | str] = {}
    effects: list[str] = []
    for name in effect or ():
        one_of(name, (each.name for each in kernel.effects()), "effect")
    if law is not None:
        one_of(law, (each.name for each in kernel.laws()), "friction law")
    if principle is not None:
        one_of(principle, kernel.variable("shear_angle_principle").choices, "shear-angle principle")
    beside = picture_beside(to)
    if parameters is not None:
        parameter_set = parameter_sets.load(parameters, speed_unit=speed_unit)
        values, effects = dict(parameter_set.values), list(parameter_set.effects)
    values |= typed_values(value)
    effects += [name for name in effect or [] if name not in effects]
    values |= {name: choice for name, choice in (("friction_law", law), ("shear_angle_principle", principle)) if choice is not None}
    times, inputs = None, {}
    if motion is not None:
        table = read_table(motion)
        headers = {header.partition("[")[0].strip(): header for header in table.columns}
        unknown = set(headers) - set(kernel.inputs()) - {"time"}
        if "time" not in headers or unknown:
            raise RecordError(
                f"{motion.name}: columns {', '.join(map(repr, table.columns))}; needed are 'time' and inputs of the component "
                f"({', '.join(kernel.inputs())}), with a unit in brackets where it is not SI."
            )
        times = table.clock(headers.pop("time"))
        inputs = {name: table.column(header, kernel.variable(name).unit) for name, header in headers.items()}
        if MOTION in inputs:
            values.setdefault(KINEMATICS, kernel.variable(MOTION).required_with[0])
    trace = run_contact(values, effects, times=times, inputs=inputs, cycles=cycles, samples_per_cycle=samples)
    out.print(f"wrote {write_trace(trace, to)}")
    picture = plot_trace(trace, beside, ("principal_force", "feed_force", "friction_force", "slip_velocity_used"), to.stem)
    out.print(f"wrote {picture}")
    means = {name: float(trace[name][-1]) for name in SHOWN if name.startswith("mean_")}
    summary = Table("mean over the last window", "value")
    for name, mean in means.items():
        summary.add_row(name, display(mean, kernel.variable(name)))
    out.print(summary)
    if as_json:
        told = {name: {"value": mean, "unit": trace.units[name]} for name, mean in means.items()}
        print_json({"table": str(to), "picture": str(picture), "mean": told, "made_by": trace.made_by})
    if trace.made_by["warnings"]:
        err.print(f"warning: {trace.made_by['warnings']}")


@app.command()
def run(
    record: Annotated[Path | None, typer.Option(help="A measured motion to drive the FMU with, instead of the paper's materials.")] = None,
    parameters: Annotated[str, typer.Option("--set", "-s", help="With --record: parameter set.")] = "tribometer-5n",
    value: Values = None,
    time: Annotated[str, typer.Option("--time", help="With --record: header of the clock.")] = "time",
    velocity: Annotated[str | None, typer.Option(help="With --record: header of the slip velocity.")] = None,
    position: Annotated[str | None, typer.Option(help="With --record: header of the position, where no velocity was measured.")] = None,
    force: Annotated[str, typer.Option(help="With --record: header of the friction force.")] = "friction_force",
    force_sign: Annotated[float, typer.Option(help="With --record: -1 where the force counts against the motion.")] = 1.0,
    begin: Annotated[str | None, typer.Option(help="With --record: first time used, such as '20 ms'.")] = None,
    end: Annotated[str | None, typer.Option(help="With --record: last time used, such as '1 min'.")] = None,
    family: Annotated[str, typer.Option(help="Without --record: regularised or published sets.")] = "regularised",
    speed_unit: SpeedUnit = "m/min",
    to: Annotated[Path, typer.Option("--out", "-o", help="Folder for figures, tables and report.")] = Path("runs"),
    as_json: Json = False,
) -> None:
    """The main job: build the FMU and drive it through fmpy for the paper's four materials, or along a measured record.

    Example: evat run --record test.txt --time 'Time [s]' --position 'Position [mm]' --force 'Friction [uN]' --force-sign -1
    """
    usable(to)
    if record is None:
        _run_materials(family, speed_unit, to, as_json)
        return
    from evat.studies.record import Columns

    parameter_set = parameter_sets.load(parameters, speed_unit=speed_unit)
    values = kernel.check_values({**parameter_set.values, **typed_values(value)})
    first, last = typed_seconds(begin, "--begin"), typed_seconds(end, "--end")
    between = (float("-inf") if first is None else first, float("inf") if last is None else last)
    _run_record(record, Columns(time, force, velocity, position, force_sign), parameter_set, values, between, to, as_json)


def _host_fmu(version: Literal[2, 3], to: Path) -> Path:
    from evat import fmu
    from evat.native.compile import host_target

    with lines_done(3) as progress:
        return fmu.build_fmu(version, to / fmu.file_name(version), [host_target().fmi3_folder], progress)


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
    page = main_job_report.write_report(cases, figures, shares, family, speed_unit, to)
    if as_json:
        written = [str(path) for path in (*figures, to / "means.csv", page)]
        print_json({"means": main_job_report.means(cases), "caveats": list(condition_caveats(shares)), "written": written})
    for conditions, what in (
        (main_job.GUESSED, "the component's starts, not those of the paper's tests"),
        (main_job.INFERRED, "from the measured means themselves (evat study paper), not known"),
    ):
        table = Table("material", "force", "measured (paper)", *(model.title for model in main_job.MODELS.values()), title_justify="left")
        for line in main_job_report.means_table(cases, conditions):
            table.add_row(*line)
        table.title = f"{conditions} conditions: {what}; cycle means [N], maximum shear stress / minimum energy"
        out.print(table)
    for text in condition_caveats(shares):
        out.print(f"note: {text}", highlight=False)
    for path in (*figures, to / "means.csv", page):
        out.print(f"wrote {path}")


@app.callback(invoke_without_command=True)
def _everything(
    version: Annotated[bool, typer.Option("--version", help="Show the version and stop.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show warnings, errors and what --json asks for alone.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Tell each stage and how long it took, with the time, instead of a bar.")
    ] = False,
    log_file: Annotated[Path | None, typer.Option("--log-file", help="Add all that is said, and the stages, to this file.")] = None,
) -> None:
    if log_file is not None:
        usable(log_file.parent)
    try:
        ask(quiet, verbose, log_file)
    except OSError as error:
        raise OutputError(f"--log-file {log_file}: it cannot be written ({error.strerror}).") from error
    if log_file is not None:
        note(f"evat {' '.join(sys.argv[1:])}")
    if version:
        out.print(f"evat {importlib.metadata.version('evat')}, model {kernel.token()}")
        raise typer.Exit


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
    except EvatError as error:
        _refused(str(error))
    except OSError as error:  # of what is read, or of standard output; what is written says more (evat.files.writing)
        what = f"{error.filename}: " if error.filename is not None else ""
        _refused(f"{what}{error.strerror or error}. It is the system that refuses; see to that file, disk or pipe, and try again.")
    finally:
        ask()


def _refused(text: str) -> NoReturn:
    with suppress(OSError):
        err.print(marked("evat:", "bold red", text), soft_wrap=True)
    try:
        sys.stdout.flush()
    except OSError:  # it would be tried again, and complained of, at the very end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(REFUSED)
