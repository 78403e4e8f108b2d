"""`evat study`: what do the studies of the package find? `evat study paper`: does the paper's table 2 come out?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from evat.commands.shared import Json, lines_done, print_json
from evat.commands.tables import WholeTable
from evat.console import out
from evat.files.writing import usable
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.units import display

if TYPE_CHECKING:
    from evat.studies.paper.result import PaperStudy

study = typer.Typer(name="study", no_args_is_help=True, help="Studies of the paper that take a minute: each writes figures and JSON.")
JOURNAL = "study.journal"


@study.callback()
def _studies() -> None:
    """Studies of the paper that take a minute: each writes figures and JSON."""


@study.command()
def paper(
    draws: Annotated[int, typer.Option(help="Sobol draws over the conditions, a power of 2.")] = 2048,
    seed: Annotated[int, typer.Option(help="Of draws and search; the same seed gives the same study.", min=0)] = 0,
    resume: Annotated[bool, typer.Option(help="Go on with the study that OUT holds, to the result it would have had.")] = False,
    to: Annotated[Path, typer.Option("--out", "-o", help="Folder for figures, JSON and the state of the study.")] = Path("paper-study"),
    as_json: Json = False,
) -> None:
    """Look for process conditions under which the paper's table 2 comes out, and say what its eight measured means determine.

    About a minute. Example: evat study paper --out paper-study
    """
    from evat.studies.paper import output, plots
    from evat.studies.paper.domain import condition_caveats, domain_shares, study_caveats
    from evat.studies.paper.friction import borne_friction, friction_caveats
    from evat.studies.paper.study import stage_count, study_paper

    usable(to)
    with lines_done(stage_count()) as progress:
        study = study_paper(draws=draws, seed=seed, journal=to / JOURNAL, resume=resume, progress=progress)
    shares = tuple(domain_shares(material) for material in paper_tables.materials())
    borne = borne_friction()
    told = (*condition_caveats(shares), *study_caveats(study), *friction_caveats(borne))
    if as_json:
        print_json(output.as_json(study, shares, borne, told))
    for table in (_means(study), _errors(study), _conditions(study), _predictions(study)):
        out.print(table)
    for text in told:
        out.print(f"note: {text}", highlight=False)
    for path in (*plots.plot_all(study, shares, to), output.write(study, shares, borne, told, to)):
        out.print(f"wrote {path}")


def _means(study: PaperStudy) -> WholeTable:
    from evat.studies.main_job import FORCES, MODELS
    from evat.studies.paper.means import Calculation, measured
    from evat.studies.paper.study import chosen

    title = f"cycle means [N], each law at its own best / under the inferred conditions; {chosen().principle.replace('_', ' ')}"
    table = WholeTable("material", "force", "measured", *(model.title for model in MODELS.values()), title=title, title_justify="left")
    for row, material in enumerate(paper_tables.materials().values()):
        for column, force in enumerate(FORCES):
            ours = [
                f"{study.best[Calculation(model, chosen().principle, chosen().speed_unit)].forces[row, column]:.1f} / "
                f"{study.inferred[model][row, column]:.1f}"
                for model in MODELS
            ]
            table.add_row(material, force.replace("_", " "), f"{measured()[row, column]:g}", *ours)
    return table


def _errors(study: PaperStudy) -> WholeTable:
    from evat.studies.main_job import MODELS
    from evat.studies.paper.means import mean_error, measured
    from evat.units import SPEED_UNITS

    table = WholeTable("mean error [%]", *(model.title for model in MODELS.values()), "ranking kept in", title_justify="left")
    table.add_row("the paper, as printed", *(f"{100 * paper_tables.mean_relative_error(model):.1f}" for model in MODELS), "")
    for what, forces in (("", study.inferred), ("; chip flow by the current shear angle", study.current_angle)):
        errors = (mean_error(forces[model] / measured() - 1) for model in MODELS)
        table.add_row(f"inferred, round values{what}", *(f"{100 * error:.1f}" for error in errors), "")
    for unit in SPEED_UNITS:
        for principle in kernel.variable("shear_angle_principle").choices:
            _, met, kept = study.accepted(principle, unit)
            texts = (f"{100 * error:.1f}" for error in study.ranking(principle, unit).values())
            table.add_row(f"own best, {principle.replace('_', ' ')}, {unit}", *texts, f"{kept} of {met} draws" if met else "no draw met")
    return table


def _conditions(study: PaperStudy) -> WholeTable:
    title = "what the eight means determine: where the modified law does as well as the paper's calculation"
    table = WholeTable("condition", "bounds", "inferred", "interval", "verdict", title=title, title_justify="left")
    for one in study.profiles:
        known = kernel.variable(one.condition.variable)
        ends = [
            " .. ".join(display(value, known, digits=3) for value in pair)
            for pair in ((one.condition.low, one.condition.high), one.interval)
        ]
        table.add_row(known.name, ends[0], display(one.condition.inferred, known, digits=3), ends[1], one.verdict)
    for spread in study.spreads:
        unit = "" if spread.unit == "1" else f" {spread.unit}"
        table.add_row(
            spread.name, "", "", f"{spread.low:.2g} .. {spread.high:.2g}{unit}", f"a factor of {spread.factor:.1f} over the draws met"
        )
    return table


def _predictions(study: PaperStudy) -> WholeTable:
    from evat.studies.main_job import MODELS

    title = "feed force [N] predicted from the other three materials: median, 5 to 95 % of the draws that meet these"
    table = WholeTable("left out", "measured", *(model.title for model in MODELS.values()), title=title, title_justify="left")
    for material, name in paper_tables.materials().items():
        some = [one for one in study.left_out if one.material == material]
        texts = []
        for one in some:
            low, high = np.percentile(one.predicted, [5, 95]) if one.predicted.size else (0.0, 0.0)
            texts.append(f"{one.median:.1f}, {low:.1f} .. {high:.1f}" if one.predicted.size else "meets no three")
        table.add_row(name, f"{some[0].measured:g}", *texts)
    return table
