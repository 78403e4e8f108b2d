"""What becomes of the paper's table 2 where friction has to be borne: bounded by mu N and the chip's strength, or mu N from the outset?

The paper's friction force knows no normal force; under the inferred conditions it is more than N over much of the contact. Here the same
laws stand under the effect sticking_limit, and Amontons' law, mu N, beside them: under the inferred conditions, with the shear stress of
each material the one within its bounds that its principal force asks for, as in the study itself. A bounded friction falls with the shear
load, so that these stresses are others. What bounds it is unknown, too: places of mu and contact length stand for that.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from evat.model import FloatArray
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.paper.conditions import inference
from evat.studies.main_job import MODELS
from evat.studies.paper.domain import DomainShares, domain_shares
from evat.studies.paper.means import Calculation, cycle_means, inferred_point, mean_error, measured, solved_shear_stress
from evat.studies.paper.study import chosen, inferred_forces

LIMIT, AMONTONS = "sticking_limit", "amontons"
MU, CONTACT_LENGTH, OWN_MU = f"{LIMIT}.mu", f"{LIMIT}.contact_length", f"{AMONTONS}.mu"
COEFFICIENTS, LENGTHS = (0.3, 0.5, 0.7, 1.0, 1.5, 2.0), (1.0, 2.0, 4.0, 8.0)
TOLERANCE, HALVINGS = 1e-3, 12  # means are then right to 0.1 %, and principal forces met to that
PLACES = np.array(list(itertools.product(COEFFICIENTS, LENGTHS)))  # (K, 2): mu, contact length over thickness


@dataclass(frozen=True, slots=True, eq=False)
class BorneFriction:
    """Table 2 with friction that the contact bears. `forces` [N] (K, 4, 2) of each model at PLACES; `amontons` (C, 4, 2) at COEFFICIENTS;
    `at_start` (4, 2) of each model with the effect as it starts; `shares`: the same as it starts, with the stresses as inferred."""

    forces: Mapping[str, FloatArray]
    amontons: FloatArray
    at_start: Mapping[str, FloatArray]
    shares: tuple[DomainShares, ...]

    def errors(self, model: str) -> FloatArray:
        """(K,): mean error of a model at PLACES."""
        return mean_error(self.forces[model] / measured() - 1)

    def best(self, model: str) -> tuple[float, float, float]:
        """mu and contact length of the place at which the model comes nearest, and its mean error there."""
        errors = self.errors(model)
        place = int(np.argmin(errors))
        return float(PLACES[place, 0]), float(PLACES[place, 1]), float(errors[place])

    def best_amontons(self) -> tuple[float, float]:
        """The coefficient at which mu N comes nearest, and its mean error there."""
        errors = mean_error(self.amontons / measured() - 1)
        place = int(np.argmin(errors))
        return COEFFICIENTS[place], float(errors[place])


def borne_friction() -> BorneFriction:
    """All of it: seconds."""
    start = np.array([[kernel.variable(name).start for name in (MU, CONTACT_LENGTH)]])
    forces = {model: _forces(model, np.vstack([start, PLACES])) for model in MODELS}
    coefficients: Mapping[str, str | FloatArray] = {"friction_law": AMONTONS, OWN_MU: np.array(COEFFICIENTS)}
    return BorneFriction(
        {model: every[1:] for model, every in forces.items()},
        _solved("coulomb", len(COEFFICIENTS), (), coefficients),
        {model: every[0] for model, every in forces.items()},
        tuple(domain_shares(material, (LIMIT,)) for material in paper_tables.materials()),
    )


def _forces(model: str, places: FloatArray) -> FloatArray:
    return _solved(model, len(places), (LIMIT,), {MU: places[:, 0], CONTACT_LENGTH: places[:, 1]})


def _solved(model: str, count: int, beside: tuple[str, ...], others: Mapping[str, str | FloatArray]) -> FloatArray:
    how = Calculation(model, chosen().principle, chosen().speed_unit)
    points = np.repeat(inferred_point()[None], count, axis=0)
    stress = solved_shear_stress(points, how, beside=beside, others=others, tolerance=TOLERANCE, halvings=HALVINGS)
    return cycle_means(points, stress[..., None], how, TOLERANCE, beside=beside, others=others)[:, :, 0]


def _percent(forces: FloatArray) -> str:
    return f"{100 * float(mean_error(forces / measured() - 1)):.1f} %"


def friction_caveats(borne: BorneFriction) -> Iterator[str]:
    """What the bound changes, with its numbers."""
    titles = paper_tables.materials()
    mu, length = (kernel.variable(name).start for name in (MU, CONTACT_LENGTH))
    told = ", ".join(f"{titles[one.material]} {100 * one.beyond_normal_force:.0f} %" for one in borne.shares)
    none = ", ".join(f"{titles[one.material]} {100 * one.no_normal_force:.0f} %" for one in borne.shares)
    yield (
        f"With friction that the contact bears ({LIMIT}, mu = {mu:g}, contact length {length:g} thicknesses, guesses) the share of the "
        f"contact with |F| > N is {told}; with N = 0: {none}."
    )
    free = inferred_forces()
    errors = ", ".join(
        f"{MODELS[model].title} {_percent(means)} ({_percent(free[model])} unbounded)" for model, means in borne.at_start.items()
    )
    best = ", ".join(
        f"{MODELS[model].title} {100 * error:.1f} % (mu {mu:g}, length {length:g})"
        for model, (mu, length, error) in ((model, borne.best(model)) for model in MODELS)
    )
    yield f"Mean error then, shear stresses solved anew: {errors}. At the best of {len(PLACES)} places of mu and length: {best}."
    mu, error = borne.best_amontons()
    yield (
        f"Amontons' law, mu N in place of F_C, leaves {100 * error:.1f} % at the best of {len(COEFFICIENTS)} coefficients, mu = {mu:g}, "
        f"under the conditions inferred with {MODELS[inference().model].title}."
    )
