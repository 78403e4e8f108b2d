"""What do the runs of `evat run` say? Cycle means beside the measured ones as table, CSV and page; which conditions are guessed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from fmpy import read_model_description

from evat.files.writing import put
from evat.fmu.documentation import beside
from evat.html import render
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.paper.conditions import SHEAR_STRESS, conditions, inference, inferred
from evat.plots.cycles import inline
from evat.studies.main_job import FORCES, GUESSED, INFERRED, MODELS, FrictionModel, MainJobCase, drawn
from evat.studies.paper.domain import DomainShares, condition_caveats

REPORT = "report.html"
BOTH = (INFERRED, GUESSED)


def means_columns() -> tuple[str, ...]:
    """What heads the columns of `means_table`, in lines that are as narrow as their numbers."""
    ours = (f"{model.title} {principle}".replace("_", "\n").replace(" ", "\n") for model, principle in _columns())
    return ("material", "force", "measured", *ours)


def means_table(cases: list[MainJobCase], conditions: str) -> list[tuple[str, ...]]:
    """Material, force, measured mean, and ours for each model under each principle, as text; at the end the mean errors."""
    lines = []
    for row in paper_tables.table_2():
        ours = {(case.model, case.principle): case.means[row.force] for case in cases if _is(case, row.material, conditions)}
        numbers = (f"{ours[name, principle]:.1f}" for name in MODELS for principle in _principles())
        lines.append((paper_tables.materials()[row.material], row.force.removesuffix("_force"), f"{row.mean:g}", *numbers))
    errors = (f"{100 * main_job_error(cases, conditions, name, principle):.1f}" for name in MODELS for principle in _principles())
    return [*lines, ("mean error", "%", "", *errors)]


def _is(case: MainJobCase, material: str, conditions: str) -> bool:
    return (case.material, case.conditions) == (material, conditions)


def _principles() -> tuple[str, ...]:
    return tuple(kernel.variable("shear_angle_principle").choices)


def _columns() -> list[tuple[FrictionModel, str]]:
    return [(model, principle) for model in MODELS.values() for principle in _principles()]


def main_job_error(cases: list[MainJobCase], conditions: str, model: str, principle: str) -> float:
    """Mean of |ours - measured| / measured over the eight means."""
    measured = {(row.material, row.force): row.mean for row in paper_tables.table_2()}
    errors = [
        abs(case.means[force] - measured[case.material, force]) / measured[case.material, force]
        for case in cases
        if (case.conditions, case.model, case.principle) == (conditions, model, principle)
        for force in FORCES
    ]
    return float(np.mean(errors))


def means(cases: list[MainJobCase]) -> list[dict[str, object]]:
    """The cycle means [N] for programs, beside the measured ones."""
    measured = {(row.material, row.force): row.mean for row in paper_tables.table_2()}
    return [
        {
            "material": case.material,
            "model": case.model,
            "principle": case.principle,
            "conditions": case.conditions,
            **{f"mean_{force}": {"value": case.means[force], "measured": measured[case.material, force], "unit": "N"} for force in FORCES},
        }
        for case in cases
    ]


def write_means(cases: list[MainJobCase], path: Path) -> Path:
    """The cycle means as CSV, one line for each case, beside the measured means."""
    measured = {(row.material, row.force): row.mean for row in paper_tables.table_2()}
    lines = ["material,model,principle,conditions," + ",".join(f"mean_{force} [N],measured_mean_{force} [N]" for force in FORCES)]
    for case in cases:
        numbers = ",".join(f"{case.means[force]:.9g},{measured[case.material, force]:g}" for force in FORCES)
        lines.append(f"{case.material},{case.model},{case.principle},{case.conditions},{numbers}")
    return put(path, "\n".join(lines) + "\n")


def write_report(
    cases: list[MainJobCase], figures: list[Path], shares: tuple[DomainShares, ...], family: str, speed_unit: str, out: Path, fmu: Path
) -> Path:
    """`report.html`, one self-contained file: figures, the means beside the measured ones, what can and cannot be compared. The
    documentation of the `fmu` that was run lies beside it."""
    rows = []
    for row in paper_tables.table_2():
        ours = {(case.conditions, case.model, case.principle): case.means[row.force] for case in cases if case.material == row.material}
        rows.append({"row": row, "ours": ours, "material": paper_tables.materials()[row.material]})
    narrow = drawn(cases, narrow=True) if figures else {}
    text = render(
        "main_job.html.j2",
        rows=rows,
        models=MODELS,
        principles=kernel.variable("shear_angle_principle").choices,
        both=BOTH,
        inference=inference(),
        source=paper_tables.table_1_source().replace("table 1", "table 2"),
        printed=paper_tables.table_3(),
        error=lambda model, **part: 100 * paper_tables.mean_relative_error(model, **part),
        our_error=lambda conditions, model, principle: 100 * main_job_error(cases, conditions, model, principle),
        forces=FORCES,
        figures=[(path.stem, inline(path.read_bytes()), inline(narrow[path.stem])) for path in figures],
        clamped=[case for case in cases if case.clamped_steps],
        contact_ratios=[(one, next(case for case in cases if case.conditions == one).cycle["mean_contact_ratio"][-1]) for one in BOTH],
        conditions=[(kernel.variable(one.variable), one) for one in conditions()],
        rake_angle=kernel.variable("rake_angle"),
        shear_stress=kernel.variable(SHEAR_STRESS),
        shear_stresses=[(title, inferred(name)[SHEAR_STRESS]) for name, title in paper_tables.materials().items()],
        caveats=list(condition_caveats(shares)),
        family=family,
        speed_unit=speed_unit,
        materials=paper_tables.materials(),
        token=kernel.token(),
        fmu=fmu.name,
        day=(read_model_description(str(fmu), validate=False).generationDateAndTime or "")[:10],
        files={path.name: "a picture of this page" for path in figures}
        | {"means.csv": "all cycle means, a line for each run"}
        | beside(fmu, out)
        | {REPORT: "this page"},
    )
    return put(out / REPORT, text)
