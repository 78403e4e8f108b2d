"""`evat experiment recovery`: which parameters of a known contact come back from which tests?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.text import Text

from evat import parameter_sets
from evat.commands.shared import Json, SpeedUnit, lines_done, print_json
from evat.commands.tables import WholeTable
from evat.console import out
from evat.files.writing import usable
from evat.model import FloatArray, ParameterError
from evat.motions import KINDS
from evat.native import kernel
from evat.units import display, to_si

if TYPE_CHECKING:
    from evat.identification import Identification
    from evat.studies.recovery import Recovery

COLOURS = {"identified": "green", "weak": "yellow", "cannot come back": "red"}


def recovery(
    sets: Annotated[
        list[str] | None, typer.Argument(help="Shipped sets or .ssv files; without them LuGre 1995 and four materials.")
    ] = None,
    motion: Annotated[list[str] | None, typer.Option(help=f"One of {', '.join(KINDS)}; repeat it. Without it all.")] = None,
    noise: Annotated[str, typer.Option(help="Standard deviation over the force's root mean square.")] = "1 %",
    repeats: Annotated[int, typer.Option(help="Trials of each condition.", min=1)] = 3,
    rate: Annotated[str, typer.Option(help="Sampling rate.")] = "1 kHz",
    fit: Annotated[
        bool, typer.Option("--fit", help="Make the tests and identify from them too (minutes for each set and motion).")
    ] = False,
    seed: Annotated[int, typer.Option(help="--fit: of noise, nominal values and search.", min=0)] = 0,
    generations: Annotated[int, typer.Option(help="--fit: of the search, at most.", min=1)] = 100,
    csv: Annotated[Path | None, typer.Option(help="Write every number to this file, .csv or .parquet.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the forecast as a map to this file.")] = None,
    speed_unit: SpeedUnit = "m/min",
    as_json: Json = False,
) -> None:
    """Forecast which of the coefficients of the paper's table 1 come back from simulated tests, and which motion makes them come back.

    Linear: the standard deviation of each over its truth, all others free. --fit sets real identifications beside it.

    Example: evat experiment recovery regularised/copper --motion ramp --motion heated_presliding --fit
    """
    from evat.plots.cycles import check_picture
    from evat.studies import recovery as study

    chosen = [parameter_sets.load(name, speed_unit=speed_unit) for name in sets or study.study_sets()]
    if repeated := [name for name in dict.fromkeys(motion or ()) if (motion or []).count(name) > 1]:
        raise ParameterError(f"motion {repeated[0]!r} is named twice; name it once.")
    motions = tuple(motion or KINDS)
    tests: dict[str, Any] = {"noise": to_si(noise, "1", name="noise"), "repeats": repeats, "rate": to_si(rate, "Hz", name="rate")}
    if csv is not None:
        usable(csv.parent)
    if plot is not None:
        check_picture(plot)
        usable(plot.parent)
    with lines_done(len(chosen) * len(motions)) as progress:
        forecasts = [study.recovery(one, motions, progress=progress, **tests) for one in chosen]
    if not as_json:
        for forecast in forecasts:
            _show(forecast)
    fits: dict[tuple[str, str], Identification] = {}
    if fit:
        with lines_done(len(chosen) * len(motions)) as progress:
            for one in chosen:
                for name in motions:
                    progress(f"{one.name}: {name}, identification")
                    fits[one.name, name] = study.fitted(one, name, seed=seed, generations=generations, **tests)
        for forecast in forecasts if not as_json else ():
            for name in motions:
                out.print(_beside(forecast, name, fits[forecast.name, name]))
    rows = [row for forecast in forecasts for row in _rows(forecast, fits)]
    if as_json:
        print_json(rows)
    if csv is not None:
        from evat.files.table import write_columns

        out.print(f"wrote {write_columns(_columns(rows), csv)}")
    if plot is not None:
        from evat.studies.recovery_plot import plot_recovery

        out.print(f"wrote {plot_recovery(forecasts, plot)}")


def _short(name: str) -> str:
    return name.rpartition(".")[2]


def _show(forecast: Recovery) -> None:
    from evat.studies.recovery import TOGETHER, percent, word

    title = f"{forecast.name}: sd over the truth [%]"
    table = WholeTable("motion", *map(_short, forecast.truth), title=title, title_justify="left")
    for motion, row in zip((*forecast.motions, TOGETHER), forecast.sd, strict=True):
        table.add_row(motion, *(Text(percent(sd), COLOURS[word(sd)]) for sd in row))
    out.print(table)
    for what in COLOURS:
        named = [name for name, sd in zip(forecast.truth, forecast.sd.min(axis=0), strict=True) if word(float(sd)) == what]
        if named:
            told = [f"{name} ({forecast.best(name)})" if forecast.best(name) else name for name in named]
            out.print(f"{what}: {', '.join(told)}", highlight=False)
    out.print()


def _beside(forecast: Recovery, motion: str, fit: Identification) -> WholeTable:
    from evat.studies.recovery import percent

    title = f"{forecast.name}, {motion}: identified; errors over the truth [%]"
    table = WholeTable("", "truth", "sd forecast", "estimate", "error", "90 % interval", "verdict", title=title, title_justify="left")
    for place, (name, truth) in enumerate(forecast.truth.items()):
        known, estimate = kernel.variable(name), fit[name]
        ends = (
            "bound" if is_open else f"{100 * (end / truth - 1):+.2g}"
            for end, is_open in ((estimate.low, estimate.open_below), (estimate.high, estimate.open_above))
        )
        table.add_row(
            _short(name),
            display(truth, known, digits=4),
            percent(float(forecast.sd[forecast.motions.index(motion), place])),
            display(estimate.value, known, digits=4),
            f"{100 * (estimate.value / truth - 1):+.2g}",
            " .. ".join(ends),
            estimate.verdict,
        )
    return table


def _columns(rows: Sequence[Mapping[str, str | float]]) -> dict[str, FloatArray | list[str]]:
    def column(name: str) -> FloatArray | list[str]:
        return [str(row[name]) for row in rows] if isinstance(rows[0][name], str) else np.array([float(row[name]) for row in rows])

    return {name: column(name) for name in rows[0]}


def _rows(forecast: Recovery, fits: dict[tuple[str, str], Identification]) -> Iterator[dict[str, str | float]]:
    """A row for each motion and parameter; with fits, what they found (nan where there is none)."""
    from evat.studies.recovery import TOGETHER, word

    for motion, row in zip((*forecast.motions, TOGETHER), forecast.sd, strict=True):
        for (name, truth), sd in zip(forecast.truth.items(), row, strict=True):
            line: dict[str, str | float] = {
                "set": forecast.name, "motion": motion, "parameter": name, "unit": kernel.variable(name).unit, "truth": truth,
                "sd_over_truth": float(sd), "forecast": word(float(sd)), "best_motion": forecast.best(name),
            }  # fmt: skip
            if fits:
                fit = fits.get((forecast.name, motion))
                numbers: Sequence[float] = (float("nan"),) * 4
                if fit is not None:
                    numbers = (fit[name].value, fit[name].sd, fit[name].low, fit[name].high)
                line |= dict(zip(("estimate", "sd", "low", "high"), numbers, strict=True))
                line["verdict"] = "" if fit is None else fit[name].verdict
            yield line
