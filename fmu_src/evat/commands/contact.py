"""`evat info`, `evat sets`, `evat simulate`: what the contact is made of, which values are shipped, and what it does with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Group
from rich.padding import Padding
from rich.table import Column
from rich.text import Text

from evat import parameter_sets
from evat.commands.shared import Json, SpeedUnit, Values, keep_record, one_of, only, picture_beside, print_json, typed_values
from evat.commands.tables import WholeTable
from evat.console import err, out, printable
from evat.model import Effect, Law, ParameterError, Variable, near_names
from evat.native import kernel
from evat.required_inputs import KINEMATICS, MOTION
from evat.units import display

Effects = Annotated[
    list[str] | None,
    typer.Option(
        "--effect", "-e", help="Switch on an effect (`evat effects` lists them); repeat it for more. A set's own effects stay on."
    ),
]


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
    return "; ".join(filter(None, (start, ", ".join(f"{name} ({number})" for name, number in variable.items.items()) or bounds.strip())))


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
        near = near_names(name or "", names)
        hint = f"did you mean {', '.join(near)}?" if near else f"`evat info` lists the {len(names)} that there are."
        raise ParameterError(f"there is no variable, friction law or effect {name!r}; {hint}")
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


def sets(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="A shipped set or an .ssv file; without it the shipped sets are listed.")] = None,
    speed_unit: SpeedUnit = "m/min",
    strict: Annotated[bool, typer.Option(help="Refuse a set that violates the paper's eq. 7 within its speed range.")] = False,
    save: Annotated[Path | None, typer.Option(help="Write the set as an SSP parameter file (.ssv).")] = None,
    as_json: Json = False,
) -> None:
    """List the shipped parameter sets, or show one: every value with unit and source.

    Example: evat sets published/inconel-718
    """
    only(context, name is not None, "with NAME", "strict", "save")
    if name is None:
        titles = {each: parameter_sets.load(each, speed_unit=speed_unit).title for each in parameter_sets.names()}
        if as_json:
            print_json(titles)
        table = WholeTable(Column("set", no_wrap=True), "what it is")
        for each, title in titles.items():
            table.add_row(each, title)
        out.print(table)
        return
    parameter_set = parameter_sets.load(name, speed_unit=speed_unit, strict=strict)
    if as_json:
        values = {key: {"value": value, "unit": kernel.variable(key).unit} for key, value in parameter_set.by_choice.items()}
        print_json(
            {
                "name": parameter_set.name,
                "title": parameter_set.title,
                "values": {key: {**each, "source": parameter_set.sources.get(key, "")} for key, each in values.items()},
                "effects": parameter_set.effects,
                "notes": parameter_set.notes,
            }
        )
    table = WholeTable(
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


def simulate(
    context: typer.Context,
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
    from evat.files.table import once, read_table, write_trace
    from evat.files.text import RecordError
    from evat.models.simulate import SHOWN, averaging_window
    from evat.models.simulate import simulate as run_contact
    from evat.plots.cycles import plot_trace

    only(context, parameters is not None, "with --set", "speed_unit")
    only(context, motion is None, "without --input", "cycles", "samples")
    values: dict[str, float | str] = {}
    effects: list[str] = []
    for name in effect or ():
        one_of(name, (each.name for each in kernel.effects()), "effect")
    if law is not None:
        one_of(law, (each.name for each in kernel.laws()), "friction law")
    if principle is not None:
        one_of(principle, kernel.variable("shear_angle_principle").choices, "shear-angle principle")
    beside = picture_beside(to)
    keep_record(motion, to)
    if parameters is not None:
        parameter_set = parameter_sets.load(parameters, speed_unit=speed_unit)
        values, effects = dict(parameter_set.values), list(parameter_set.effects)
    options = {"friction_law": f"--law {law}"} if law is not None else {}
    options |= {"shear_angle_principle": f"--principle {principle}"} if principle is not None else {}
    typed = typed_values(value, options | {name: f"--effect {name}" for name in effect or ()})
    values |= typed
    effects += [name for name in effect or [] if name not in effects]
    values |= {name: choice for name, choice in (("friction_law", law), ("shear_angle_principle", principle)) if choice is not None}
    times, inputs = None, {}
    if motion is not None:
        table = read_table(motion)
        headers = once(table.columns, motion.name)
        unknown = set(headers) - set(kernel.inputs()) - {"time"}
        if "time" not in headers or unknown:
            raise RecordError(
                f"{motion.name}: columns {', '.join(map(repr, table.columns))}; needed are 'time' and inputs of the component "
                f"({', '.join(kernel.inputs())}), with a unit in brackets where it is not SI."
            )
        times = table.clock(headers.pop("time"))
        if both := [name for name in headers if name in typed]:
            raise ParameterError(f"{both[0]} is fed by the record {motion.name}; a value for it would change nothing. Leave it out.")
        inputs = {name: table.column(header, kernel.variable(name).unit) for name, header in headers.items()}
        if MOTION in inputs:
            values.setdefault(KINEMATICS, kernel.variable(MOTION).required_with[0])
    trace = run_contact(values, effects, times=times, inputs=inputs, cycles=cycles, samples_per_cycle=samples)
    out.print(f"wrote {write_trace(trace, to)}")
    picture = plot_trace(trace, beside, ("principal_force", "feed_force", "friction_force", "slip_velocity_used"), to.stem)
    out.print(f"wrote {picture}")
    window, length = averaging_window(values), float(trace.times[-1] - trace.times[0])
    ended = length >= window * (1 - 1e-9)  # before that the component shows 0, which is no mean
    means = {name: float(trace[name][-1]) if ended else math.nan for name in SHOWN if name.startswith("mean_")}
    summary = WholeTable("mean over the last window", "value")
    for name, mean in means.items():
        summary.add_row(name, display(mean, kernel.variable(name)))
    if ended:
        out.print(summary)
    else:
        todo = f"run on for at least {window:g} s, or give a shorter averaging_window"
        out.print(f"no averaging window has ended within {length:g} s, so that there are no means: {todo}.", soft_wrap=True)
    if as_json:
        told = {name: {"value": mean, "unit": trace.units[name]} for name, mean in means.items()}
        print_json({"table": str(to), "picture": str(picture), "mean": told, "made_by": trace.made_by})
    if trace.made_by["warnings"]:
        err.print(f"warning: {trace.made_by['warnings']}")
