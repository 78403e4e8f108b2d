"""What comes out of the study of the paper's table 2? The best conditions of each calculation, profiles, spreads, predictions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from evat.model import FloatArray
from evat.paper.conditions import ProcessCondition
from evat.studies.main_job import MODELS
from evat.studies.paper.means import Calculation, mean_error, measured

DETERMINED = 2.0  # high over low of an interval, up to which a condition is called so
ACCEPTED = 0.2  # mean error of the best model, up to which a draw counts: 20.0 % is what the paper's own LuGre column leaves


@dataclass(frozen=True, slots=True, eq=False)
class Best:
    """The conditions under which a calculation comes nearest to the eight measured means, SI, and what it gives there [N], (4, 2)."""

    how: Calculation
    point: FloatArray
    shear_stress: FloatArray
    forces: FloatArray

    @property
    def deviations(self) -> FloatArray:
        return np.asarray(self.forces / measured() - 1)

    @property
    def error(self) -> float:
        return float(mean_error(self.deviations))


@dataclass(frozen=True, slots=True, eq=False)
class ConditionProfile:
    """Least mean error of the modified law with one condition held at each of its values [SI]; where it stays below `threshold`."""

    condition: ProcessCondition
    values: FloatArray
    errors: FloatArray
    threshold: float

    @property
    def interval(self) -> tuple[float, float]:
        """Where the least error stays below the threshold, by lines between the places; a bound where it does so up to there."""
        good, along = self.errors <= self.threshold, np.log(self.values)
        first, last = int(np.argmax(good)), int(good.size - 1 - np.argmax(good[::-1]))
        return float(np.exp(self._crossing(along, first, first - 1))), float(np.exp(self._crossing(along, last, last + 1)))

    def _crossing(self, along: FloatArray, inside: int, outside: int) -> float:
        if not 0 <= outside < along.size:
            return float(along[inside])
        if not np.isfinite(self.errors[outside]):
            return float(along[inside])
        share = (self.threshold - self.errors[inside]) / (self.errors[outside] - self.errors[inside])
        return float(along[inside] + share * (along[outside] - along[inside]))

    @property
    def verdict(self) -> str:
        """What the eight means say of it."""
        low, high = self.interval
        below, above = bool(low > self.values[0]), bool(high < self.values[-1])
        if below and above:
            return "determined" if high <= DETERMINED * low else "bounded, not determined"
        return "bounded below" if below else "bounded above" if above else "not determined"


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """A quantity made of conditions, over the draws that the modified law meets to ACCEPTED: from its 5th to its 95th percentile."""

    name: str
    unit: str
    low: float
    high: float

    @property
    def factor(self) -> float:
        return self.high / self.low


@dataclass(frozen=True, slots=True, eq=False)
class LeftOut:
    """Feed force of a material [N], predicted by a model from the other three: over all draws that are accepted by those alone."""

    material: str
    model: str
    measured: float
    predicted: FloatArray

    @property
    def median(self) -> float:
        return float(np.median(self.predicted)) if self.predicted.size else float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class PaperStudy:
    """What came out. `points` (K, p) SI are the draws, `draws[how]` (K, 4, 2) their deviations, inf where they have none.

    `inferred` and `current_angle`: forces under the inferred conditions by model, the latter with the chip flowing by the shear angle of
    the moment, the other way to close the equations. Friction then depends on shear stress, and no search is made.
    """

    best: Mapping[Calculation, Best]
    points: FloatArray
    draws: Mapping[Calculation, FloatArray]
    profiles: tuple[ConditionProfile, ...]
    spreads: tuple[Spread, ...]
    left_out: tuple[LeftOut, ...]
    inferred: Mapping[str, FloatArray]
    current_angle: Mapping[str, FloatArray]
    made_by: Mapping[str, str | int]

    def ranking(self, principle: str, speed_unit: str) -> dict[str, float]:
        """Mean error of each model at its own best."""
        return {model: self.best[Calculation(model, principle, speed_unit)].error for model in MODELS}

    def draw_errors(self, principle: str, speed_unit: str) -> FloatArray:
        """(3, K): mean error of each draw by model."""
        return np.array([mean_error(self.draws[Calculation(model, principle, speed_unit)]) for model in MODELS])

    def accepted(self, principle: str, speed_unit: str) -> tuple[int, int, int]:
        """Draws in which the tool separates, those of them that the best model meets to ACCEPTED, those of these that keep the ranking."""
        errors = self.draw_errors(principle, speed_unit)
        met = errors.min(axis=0) <= ACCEPTED
        return int(np.isfinite(errors).all(axis=0).sum()), int(met.sum()), int((met & ranked(errors)).sum())


def ranked(errors: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether the errors, in the order of MODELS, rank as the paper's: the modified law before LuGre before Coulomb."""
    return np.asarray((errors[1:] < errors[:-1]).all(axis=0))
