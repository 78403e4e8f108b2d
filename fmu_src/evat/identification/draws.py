"""What would an ensemble of fits look like? Draws from the normal approximation about the optimum, within the bounds; for ArviZ.

The profile intervals say more where the two disagree: an estimate on its bound, a curved valley.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evat.identification.space import Free
from evat.model import EvatError, FloatArray, Variable

ROUNDS = 200
APPROXIMATION = "normal about the optimum, within the bounds; where the data say nothing, even between the bounds"


def draws(
    variables: Sequence[tuple[Variable, float, tuple[float, float], float, float]], correlation: FloatArray, count: int, seed: int
) -> dict[str, FloatArray]:
    """`count` draws of each variable. variables : with their nominal value, bounds, estimate and standard error (inf: not known at all)."""
    free = [Free(variable, nominal, *bounds) for variable, nominal, bounds, _, _ in variables]
    best = np.array([one.place(value) for one, (*_, value, _) in zip(free, variables, strict=True)])
    sd = np.array([error / one.slope(float(u)) for one, u, (*_, error) in zip(free, best, variables, strict=True)])
    known = np.isfinite(sd)
    rng = np.random.default_rng(seed)
    points = rng.uniform(size=(count, len(free)))
    if np.any(known):
        related = correlation[np.ix_(known, known)]
        points[:, known] = _within(rng, best[known], related * sd[known][:, None] * sd[known][None, :], count)
    return {one.name: one.values(points[:, place]) for place, one in enumerate(free)}


def _within(rng: np.random.Generator, centre: FloatArray, covariance: FloatArray, count: int) -> FloatArray:
    """Normal draws in the unit cube; those outside are drawn again."""
    kept = np.empty((0, centre.size))
    for _ in range(ROUNDS):
        points = rng.multivariate_normal(centre, covariance, size=2 * count, method="eigh")
        kept = np.concatenate([kept, points[np.all((points >= 0) & (points <= 1), axis=1)]])
        if len(kept) >= count:
            return kept[:count]
    raise EvatError("too few draws of the estimates lie within the bounds; widen the bounds, or use the profile intervals.")


def prior(variables: Sequence[tuple[Variable, float, tuple[float, float], float, float]], count: int, seed: int) -> dict[str, FloatArray]:
    """Draws that know the bounds alone, as the search does: even in the value, or in its logarithm where the bounds are far apart."""
    rng = np.random.default_rng(seed)
    return {
        variable.name: Free(variable, nominal, *bounds).values(rng.uniform(size=count)) for variable, nominal, bounds, _, _ in variables
    }


def as_arviz(groups: Mapping[str, Mapping[str, FloatArray]], units: Mapping[str, str], about: Mapping[str, Any]) -> Any:
    """Groups of arrays as ArviZ's tree of Datasets (what ArviZ before 1.0 called InferenceData)."""
    try:
        import arviz_base
    except ImportError as error:
        raise EvatError("to_arviz needs the package arviz-base, which is not installed here: pip install 'evat[notebook]'.") from error
    tree = arviz_base.from_dict({name: dict(columns) for name, columns in groups.items()}, attrs={"/": dict(about)})
    for group in groups:
        for name in tree[group].data_vars:
            tree[group][name].attrs["units"] = units.get(str(name), "")
    return tree
