"""What do the paper's four materials give under Coulomb, LuGre and modified LuGre? FMU through fmpy, figures.

Under two sets of process conditions, of which the paper prints none: the component's starts, which are guesses, and those that the paper's
table 2 lets infer (parameters/paper/conditions.toml).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from evat import parameter_sets
from evat.model import Run, Trace
from evat.models.drive import drive
from evat.models.simulate import vibration_clock
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.paper.conditions import inferred
from evat.plots.cycles import cycles, save_figure

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


GUESSED, INFERRED = "guessed", "inferred"  # conditions
# By the names that the paper's table 2 gives them in parameters/paper/table-2.toml.
MODELS = {
    "coulomb": FrictionModel("Coulomb", "coulomb", False),
    "lugre": FrictionModel("LuGre", "lugre", False),
    "lugre_thermal": FrictionModel("modified LuGre", "lugre", True),
}


@dataclass(frozen=True, slots=True)
class MainJobCase:
    """One run under GUESSED or INFERRED conditions: the last vibration cycle of it, and its cycle means [N]."""

    material: str
    model: str
    principle: str
    conditions: str
    cycle: Trace
    means: Mapping[str, float]
    clamped_steps: int


def case_count() -> int:
    return 2 * len(paper_tables.materials()) * len(MODELS) * len(kernel.variable("shear_angle_principle").choices)


def run_cases(fmu: Path, family: str, speed_unit: str, done: Callable[[int], None] = lambda _: None) -> list[MainJobCase]:
    """Every material of the paper under both conditions and every model and principle, through the FMU.

    family : "regularised" or "published", the parameter sets' first name. done(n) is called after the n-th case.
    """
    cases = list[MainJobCase]()
    last = slice(-SAMPLES_PER_CYCLE - 1, None)
    for material in paper_tables.materials():
        parameter_set = parameter_sets.load(f"{family}/{material}", speed_unit=speed_unit)
        for conditions, given in ((GUESSED, {}), (INFERRED, inferred(material))):
            frequency = given.get("vibration_frequency", kernel.variable("vibration_frequency").start)
            times = vibration_clock(CYCLES, float(frequency), SAMPLES_PER_CYCLE)
            for name, model in MODELS.items():
                for principle in kernel.variable("shear_angle_principle").choices:
                    values = {
                        **parameter_set.by_choice,
                        **given,
                        "friction_law": model.law,
                        "shear_angle_principle": principle,
                    }
                    switches = dict.fromkeys(parameter_set.effects, model.with_effects)
                    trace = drive(fmu, Run(times, {}, OUTPUTS), {**values, **switches})
                    cycle = Trace(
                        trace.times[last], {key: column[last] for key, column in trace.columns.items()}, trace.units, trace.made_by
                    )
                    means = {force: float(trace[f"mean_{force}"][-1]) for force in FORCES}
                    cases.append(MainJobCase(material, name, principle, conditions, cycle, means, int(trace["clamped_count"][-1])))
                    done(len(cases))
    return cases


def plot_cases(cases: list[MainJobCase], out: Path) -> list[Path]:
    """The paper's figures 3 and 4, for each material: principal and feed force over one vibration cycle; by conditions."""
    return [save_figure(figure, out / f"{stem}.png") for stem, figure in drawn(cases).items()]


def drawn(cases: list[MainJobCase], *, narrow: bool = False) -> dict[str, Figure]:
    """The pictures of `plot_cases` by the stems of their files; narrow, for a phone: panels one below the other."""
    titles = paper_tables.materials()
    figures = {}
    for conditions, ending in ((INFERRED, f"-{INFERRED}"), (GUESSED, "")):
        for number, force in zip((3, 4), FORCES, strict=True):
            panels: dict[str, dict[str, Trace]] = {}
            for case in cases:
                if case.conditions == conditions:
                    label = f"{MODELS[case.model].title}, {case.principle.replace('_', ' ')}"
                    panels.setdefault(titles[case.material], {})[label] = case.cycle
            name = force.replace("_", " ")
            title = (
                f"{name} over one vibration cycle (compare the paper's figure {number}; conditions are {conditions}, the paper prints none)"
            )
            figures[f"figure-{number}-{force.replace('_', '-')}{ending}"] = cycles(panels, force, title, narrow=narrow)
    return figures
