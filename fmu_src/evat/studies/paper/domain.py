"""Where do the inferred conditions take the paper's model beyond what it means, and what has to be known beside its table 2?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from evat import parameter_sets
from evat.model import Trace
from evat.models.simulate import simulate
from evat.paper import tables as paper_tables
from evat.paper.conditions import conditions, inference, inferred
from evat.parameter_sets import softening_limit
from evat.studies.main_job import MODELS
from evat.studies.paper.means import mean_error, measured
from evat.studies.paper.result import ACCEPTED, PaperStudy, ranked
from evat.studies.paper.study import FEED, chosen, inferred_forces
from evat.units import SPEED_UNITS

SAMPLES = 2000  # of the cycle: shares are then right to 0.001
SHOWN = ("friction_force", "normal_force", "slip_velocity_used", "theta_used", "in_contact")


@dataclass(frozen=True, slots=True, eq=False)
class DomainShares:
    """One material under the inferred conditions and the modified law: a vibration cycle, and shares of the time in contact.

    no_normal_force: N = 0, a chip that would pull at the tool; beyond_normal_force: |F| > N, friction of a coefficient above 1;
    stiffness_at_floor: the paper's eq. 7 fails, s0 is clamped.
    """

    material: str
    cycle: Trace
    no_normal_force: float
    beyond_normal_force: float
    stiffness_at_floor: float


def domain_shares(material: str, beside: tuple[str, ...] = ()) -> DomainShares:
    """The shares of one of the paper's materials, with effects on beside the paper's."""
    loaded = parameter_sets.load(f"{inference().family}/{material}", speed_unit=inference().speed_unit)
    model = MODELS[inference().model]
    values = {**loaded.by_choice, **inferred(material), "friction_law": model.law, "phase_x": np.pi / 2, "phase_y": 0.0}
    on = (*(loaded.effects if model.with_effects else ()), *beside)
    cycle = simulate(values, on, cycles=1, samples_per_cycle=SAMPLES, outputs=SHOWN)
    touching = cycle["in_contact"] > 0
    friction, normal, theta = (cycle[name][touching] for name in ("friction_force", "normal_force", "theta_used"))
    return DomainShares(
        material,
        cycle,
        float(np.mean(normal <= 0)),
        float(np.mean(np.abs(friction) > normal)),
        float(np.mean(theta >= softening_limit(loaded.values))),
    )


def condition_caveats(shares: tuple[DomainShares, ...]) -> Iterator[str]:
    """What has to be said beside figures under the inferred conditions."""
    titles = paper_tables.materials()
    yield (
        f"The conditions are inferred, not known: the paper prints none of them. {measured().size} means cannot determine "
        f"{len(conditions())} conditions and {len(titles)} shear stresses: others within their bounds do as well (evat study paper)."
    )
    forces = inferred_forces()
    plain, modified = (np.abs(forces[model] / measured() - 1).sum(axis=1) for model in ("lugre", inference().model))
    gain = 100 * (plain - modified) / measured().size
    most = int(np.argmax(gain))
    yield (
        f"The gain of the modified law over LuGre comes from {list(titles.values())[most]}: under the inferred conditions it takes "
        f"{gain[most]:.1f} points off the mean error, the other materials together {gain.sum() - gain[most]:.1f}."
    )
    for what, key in (
        ("N = 0, a chip that would pull at the tool", "no_normal_force"),
        ("|F| > N", "beyond_normal_force"),
        ("stiffness at its floor (the paper's eq. 7 fails)", "stiffness_at_floor"),
    ):
        told = ", ".join(f"{titles[one.material]} {100 * getattr(one, key):.0f} %" for one in shares)
        yield f"The fit leaves the model's domain. Share of the contact with {what}: {told}."


def study_caveats(study: PaperStudy) -> Iterator[str]:
    """What has to be said beside the ranking, with the numbers of this study."""
    titles, principle, unit = paper_tables.materials(), chosen().principle, chosen().speed_unit
    separating, met, kept = study.accepted(principle, unit)
    errors = study.draw_errors(principle, unit)
    nearest = float(errors[:, ~ranked(errors)].min())
    yield (
        f"The ranking is that of each law at its own best, and of {kept} of the {met} draws (of {separating} in which the tool separates) "
        f"that the best of the three laws meets to {100 * ACCEPTED:.0f} %; the nearest of the others leaves {100 * nearest:.1f} %."
    )
    hardest, best = _hardest(study)
    sharing = [titles[name] for name in titles if name != hardest and _sigma2(name) == _sigma2(hardest)]
    why = f" Table 1 gives it the sigma2 of {', '.join(sharing)}, {_sigma2(hardest):g}." if sharing else ""
    yield (
        f"The feed force of {titles[hardest]} fits under no shared conditions: of the draws that the modified law meets to "
        f"{100 * ACCEPTED:.0f} % the nearest is {100 * best:.0f} % off.{why}"
    )
    for other_unit in (one for one in SPEED_UNITS if one != unit):
        told = ", ".join(f"{MODELS[model].title} {100 * error:.2f} %" for model, error in study.ranking(principle, other_unit).items())
        yield f"With the speeds of table 1 in {other_unit} no law comes nearer than this, each at its own best: {told}."


def _sigma2(material: str) -> float:
    return next(cell.printed for cell in paper_tables.table_1(material) if cell.row == "sigma2")


def _hardest(study: PaperStudy) -> tuple[str, float]:
    """The material whose feed force the accepted draws miss most, and by how much the nearest of them does."""
    deviations = study.draws[chosen()]
    nearest = np.abs(deviations[mean_error(deviations) <= ACCEPTED, :, FEED]).min(axis=0)
    place = int(np.argmax(nearest))
    return list(paper_tables.materials())[place], float(nearest[place])
