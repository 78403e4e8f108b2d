"""`evat effects`: which effects can be switched on, and what does each do to a record?"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Group
from rich.padding import Padding
from rich.text import Text

from evat import parameter_sets
from evat.commands.shared import SpeedUnit, Values, only, print_json, typed_values
from evat.commands.tables import WholeTable
from evat.console import err, out
from evat.files.json_values import json_value
from evat.files.writing import usable
from evat.model import Effect, Variable
from evat.native import kernel
from evat.units import display

WIDTH = 100


def effects(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="An effect; without it all are listed.")] = None,
    to: Annotated[Path | None, typer.Option("--out", "-o", help="With NAME: the picture of its signature; otherwise NAME.png.")] = None,
    parameters: Annotated[str | None, typer.Option("--set", "-s", help="With NAME: a shipped set or an .ssv file to show it on.")] = None,
    value: Values = None,
    speed_unit: SpeedUnit = "m/min",
    as_json: Annotated[bool, typer.Option("--json", help="The list, or NAME's entry, as JSON on standard output; no picture.")] = False,
) -> None:
    """List the effects, or show one and plot its signature: forces with and without it, over a cycle and over the conditions.

    The picture goes to NAME.png in the present folder, or to --out.

    Example: evat effects run_out -v run_out.amplitude=20um -o run-out.png
    """
    from evat.signature import effect_named

    only(context, name is not None, "with NAME", "to", "parameters", "value")
    only(context, name is not None and parameters is not None, "with --set", "speed_unit")
    chosen = kernel.effects() if name is None else (effect_named(name),)
    if as_json:
        print_json([_facts(effect) for effect in chosen])
        return
    for stage, group in itertools.groupby(chosen, key=lambda effect: effect.stage):
        out.print(Text(f"stage: {stage}", "bold"))
        for effect in group:
            out.print(_described(effect, in_full=name is not None), width=min(out.width, WIDTH))
    if name is None:
        out.print("In full, with a picture: evat effects NAME", highlight=False)
    else:
        _plot(name, to or Path(f"{name}.png"), parameters, value, speed_unit)


def _plot(name: str, to: Path, parameters: str | None, value: list[str] | None, speed_unit: str) -> None:
    from evat.plots.cycles import check_picture
    from evat.plots.signature import plot_signature
    from evat.signature import signature

    check_picture(to)  # before the work
    usable(to.parent)
    parameter_set = parameter_sets.load(parameters, speed_unit=speed_unit) if parameters is not None else None
    values: dict[str, float | str] = {**(parameter_set.values if parameter_set else {}), **typed_values(value)}
    result = signature(name, values, parameter_set.effects if parameter_set else ())
    for line in result.left_out:
        err.print(f"left out: {line}", highlight=False)
    out.print(f"wrote {plot_signature(result, to)}")


def _grid(rows: Iterable[tuple[str, ...]], headers: tuple[str, ...] = ()) -> WholeTable:
    table = WholeTable(*headers, box=None, show_header=bool(headers), header_style="dim", pad_edge=False, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*row)
    return table


def _parameter(variable: Variable, in_full: bool) -> tuple[str, ...]:
    neutral = "" if math.isnan(variable.neutral) else display(variable.neutral, variable)
    bounds = f"{display(variable.min, variable, digits=4)} .. {display(variable.max, variable, digits=4)}"
    short = variable.name.partition(".")[2]
    return (
        short,
        display(variable.start, variable, digits=4),
        bounds,
        neutral,
        *([f"{variable.meaning}. [{variable.source}]"] if in_full else []),
    )


def _described(effect: Effect, in_full: bool) -> Padding:
    facts = [("what it is", effect.physics), ("equation", effect.equation), ("signature", effect.signature)]
    facts += [("source", effect.source), ("family", effect.family)]
    facts += [("rivals", ", ".join(effect.rivals))] if effect.rivals else []
    facts += [("special cases", ", ".join(effect.special_cases))] if effect.special_cases else []
    facts += [("needs", ", ".join(effect.needs))] if effect.needs else []
    facts += [("applies to", ", ".join(effect.applies_to))] if effect.applies_to else []
    headers = ("parameter", "start", "bounds", "neutral", *(["meaning [source]"] if in_full else []))
    parameters = _grid((_parameter(variable, in_full) for variable in effect.variables), headers)
    return Padding(Group(Text(effect.name, "bold"), Padding(Group(_grid(facts), parameters), (0, 0, 1, 2))), (0, 0, 0, 2))


def _facts(effect: Effect) -> dict[str, Any]:
    """The effect as JSON takes it: SI, a neutral value of null where a parameter has none."""
    facts: dict[str, Any] = json_value(dataclasses.asdict(effect))
    for variable in (*facts["variables"], *facts["states"]):
        del variable["index"]
    return facts
