"""What do the paper's four materials give under Coulomb, LuGre and modified LuGre? The main job: FMU through fmpy, figures, a table."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from evat import paper_tables, parameter_sets
from evat.files.writing import put
from evat.html import render
from evat.model import Run, Trace
from evat.models.drive import drive
from evat.models.simulate import vibration_clock
from evat.native import kernel
from evat.plots.cycles import plot_cycles

SAMPLES_PER_CYCLE = 400
CYCLES = 6  # bristles are let go at separation, so the second cycle is periodic already; the rest shows that it is
FORCES = ("principal_force", "feed_force")
OUTPUTS = (*FORCES, "mean_principal_force", "mean_feed_force", "mean_contact_ratio", "clamped_count", "in_contact")


@dataclass(frozen=True, slots=True)
class FrictionModel:
    """One of the paper's three models: a friction law of the component, with the set's effects on or off."""

    title: str
    law: str
    with_effects: bool


# By the names that the paper's table 2 gives them in parameters/paper/table-2.toml.
MODELS = {
    "coulomb": FrictionModel("Coulomb", "coulomb", False),
    "lugre": FrictionModel("LuGre", "lugre", False),
    "lugre_thermal": FrictionModel("modified LuGre", "lugre", True),
}


@dataclass(frozen=True, slots=True)
class MainJobCase:
    """One run: the last vibration cycle of it, and its cycle means [N]."""

    material: str
    model: str
    principle: str
    cycle: Trace
    means: Mapping[str, float]
    clamped_steps: int


def case_count() -> int:
    return len(paper_tables.materials()) * len(MODELS) * len(kernel.variable("shear_angle_principle").choices)


def run_cases(fmu: Path, family: str, speed_unit: str, done: Callable[[int], None] = lambda _: None) -> list[MainJobCase]:
    """Every material of the paper under every model and principle, through the FMU.

    family : "regularised" or "published", the parameter sets' first name. done(n) is called after the n-th case.
    """
    cases = []
    times = vibration_clock(CYCLES, kernel.variable("vibration_frequency").start, SAMPLES_PER_CYCLE)
    last = slice(-SAMPLES_PER_CYCLE - 1, None)
    for material in paper_tables.materials():
        parameter_set = parameter_sets.load(f"{family}/{material}", speed_unit=speed_unit)
        for name, model in MODELS.items():
            for principle in kernel.variable("shear_angle_principle").choices:
                values = {**kernel.by_choice(parameter_set.values), "friction_law": model.law, "shear_angle_principle": principle}
                switches = dict.fromkeys(parameter_set.effects, model.with_effects)
                trace = drive(fmu, Run(times, {}, OUTPUTS), {**values, **switches})
                cycle = Trace(trace.times[last], {key: column[last] for key, column in trace.columns.items()}, trace.units, trace.made_by)
                means = {force: float(trace[f"mean_{force}"][-1]) for force in FORCES}
                cases.append(MainJobCase(material, name, principle, cycle, means, int(trace["clamped_count"][-1])))
                done(len(cases))
    return cases


def plot_cases(cases: list[MainJobCase], out: Path) -> list[Path]:
    """The paper's figures 3 and 4, for each material: principal and feed force over one vibration cycle."""
    titles = paper_tables.materials()
    written = []
    for number, force in zip((3, 4), FORCES, strict=True):
        panels: dict[str, dict[str, Trace]] = {}
        for case in cases:
            label = f"{MODELS[case.model].title}, {case.principle.replace('_', ' ')}"
            panels.setdefault(titles[case.material], {})[label] = case.cycle
        name = force.replace("_", " ")
        title = f"{name} over one vibration cycle (compare the paper's figure {number}; process conditions are our own)"
        written.append(plot_cycles(panels, force, out / f"figure-{number}-{force.replace('_', '-')}.png", title))
    return written


def means_table(cases: list[MainJobCase]) -> list[tuple[str, ...]]:
    """Material, force, measured mean, and ours under both principles for each model, as text."""
    lines = []
    for row in paper_tables.table_2():
        ours = [
            " / ".join(f"{case.means[row.force]:.1f}" for case in cases if case.material == row.material and case.model == model)
            for model in MODELS
        ]
        lines.append((paper_tables.materials()[row.material], row.force.replace("_", " "), f"{row.mean:g}", *ours))
    return lines


def write_means(cases: list[MainJobCase], path: Path) -> Path:
    """The cycle means as CSV, one line for each case, beside the measured means."""
    measured = {(row.material, row.force): row.mean for row in paper_tables.table_2()}
    lines = ["material,model,principle," + ",".join(f"mean_{force} [N],measured_mean_{force} [N]" for force in FORCES)]
    for case in cases:
        numbers = ",".join(f"{case.means[force]:.9g},{measured[case.material, force]:g}" for force in FORCES)
        lines.append(f"{case.material},{case.model},{case.principle},{numbers}")
    return put(path, "\n".join(lines) + "\n")


def write_report(cases: list[MainJobCase], figures: list[Path], family: str, speed_unit: str, out: Path) -> Path:
    """`report.html`, one self-contained file: figures, the means beside the measured ones, what can and cannot be compared."""
    rows = []
    for row in paper_tables.table_2():
        ours = {(case.model, case.principle): case.means[row.force] for case in cases if case.material == row.material}
        rows.append({"row": row, "ours": ours, "material": paper_tables.materials()[row.material]})
    text = render(
        "main_job.html.j2",
        rows=rows,
        models=MODELS,
        principles=kernel.variable("shear_angle_principle").choices,
        source=paper_tables.table_1_source().replace("table 1", "table 2"),
        printed=paper_tables.table_3(),
        error=lambda model, **part: 100 * paper_tables.mean_relative_error(model, **part),
        forces=FORCES,
        figures=[(path.stem, base64.b64encode(path.read_bytes()).decode()) for path in figures],
        clamped=[case for case in cases if case.clamped_steps],
        contact_ratio=cases[0].cycle["mean_contact_ratio"][-1],
        conditions=[v for v in kernel.variables() if v.name in CONDITIONS],
        family=family,
        speed_unit=speed_unit,
        cases=cases,
        materials=paper_tables.materials(),
        token=kernel.token(),
    )
    return put(out / "report.html", text)


CONDITIONS = (
    "vibration_frequency",
    "amplitude_x",
    "amplitude_y",
    "cutting_speed",
    "feed",
    "width",
    "rake_angle",
    "shear_stress",
    "chip_flow_shear_angle",
)
