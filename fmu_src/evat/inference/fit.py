"""Which parameters of a model with these effects fit best, and how likely are the data then?

The size of the discrepancy is estimated anew at each point. Still minus twice the log likelihood is a sum of squares, that of the whitened
residual as far as parameters can change it and a rest: where the discrepancy is the likeliest, the likelihood has no slope by its size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.band_whitening import BandWhitening, Sums
from evat.inference.discrepancy import Likelihood, likelihood
from evat.inference.least_squares import least_squares
from evat.inference.parameters import Parameter
from evat.inference.prediction import OWN, Prediction
from evat.inference.spike_and_slab import log_evidence_of_spikes
from evat.model import BoolArray, FloatArray

Looked = TypeVar("Looked", bound="Look")


@dataclass(frozen=True)
class Look:
    """A point (p,), the `sums` of residual and slopes there, and what follows from them."""

    point: FloatArray
    sums: Sums
    likelihood: Likelihood


@dataclass(frozen=True)
class Fit(Look):
    """A model at its best. `point` (p,) in prior standard deviations; `predicted` (N,); `slopes` (N, p) by prior standard deviations;
    `sums` of both; `fixed` are values that were given, not fitted."""

    on: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    predicted: FloatArray
    slopes: FloatArray
    fixed: Mapping[str, float | str]

    @property
    def values(self) -> dict[str, float | str]:
        """What to simulate with."""
        return {**self.fixed, **{p.name: p.value(float(u)) for p, u in zip(self.parameters, self.point, strict=True)}}

    @property
    def sd(self) -> dict[str, float]:
        """Standard deviation of each fitted value."""
        spread = np.sqrt(np.diag(self.likelihood.covariance))
        return {p.name: p.slope(float(u)) * float(s) for p, u, s in zip(self.parameters, self.point, spread, strict=True)}

    @property
    def own_values(self) -> dict[str, dict[str, float]]:
        """By variable: by how much its value is more in which conditions or trials; fixed before the fit."""
        own: dict[str, dict[str, float]] = {}
        for name, value in self.fixed.items():
            variable, _, where = name.partition(OWN)
            if where and variable.partition(".")[0] in self.on:
                own.setdefault(variable, {})[where] = float(value)
        return own

    def again(self, whitening: BandWhitening) -> Fit:
        """The same point, judged by what is forgiven now."""
        judged = likelihood(whitening, self.sums, self.point)
        return replace(self, likelihood=charged(judged, self.parameters, self.point, self.fixed, self.on))


def fit(
    prediction: Prediction,
    whitening: BandWhitening,
    parameters: Sequence[Parameter],
    start: FloatArray,
    on: Sequence[str] = (),
    *,
    fixed: Mapping[str, float | str] | None = None,
    held_out: BoolArray | None = None,
    most_steps: int | None = None,
) -> Fit | None:
    """The best point near `start` (p,), bounds kept; None where the model does not run there.

    most_steps : else as many as the table of constants has.
    """
    names = [parameter.name for parameter in parameters]
    fixed = dict(fixed or {})

    def look(point: FloatArray) -> Fit | None:
        values = {**fixed, **{p.name: p.value(float(u)) for p, u in zip(parameters, point, strict=True)}}
        scales = {p.name: p.slope(float(u)) for p, u in zip(parameters, point, strict=True)}
        predicted, slopes = prediction.jacobian(values, names, scales, on)
        if not np.all(np.isfinite(predicted)):
            return None
        slopes = np.nan_to_num(slopes)
        sums = whitening.sums(predicted, slopes)
        here = charged(likelihood(whitening, sums, point, held_out=held_out), parameters, point, fixed, on)
        return Fit(point, sums, here, tuple(on), tuple(parameters), predicted, slopes, fixed)

    def keep(point: FloatArray) -> FloatArray:
        return np.array([p.within(float(u)) for p, u in zip(parameters, point, strict=True)])

    return likeliest(look, keep, start, CONSTANTS.most_steps if most_steps is None else most_steps)


def charged(
    likelihood: Likelihood, parameters: Sequence[Parameter], point: FloatArray, fixed: Mapping[str, float | str], on: Sequence[str]
) -> Likelihood:
    """With what the spikes of the parameters add to the evidence, and what the values cost that conditions or trials have by themselves:
    each was fitted, too, before."""
    own = {value for name, value in fixed.items() if OWN in name and name.partition(".")[0] in on}
    spikes = log_evidence_of_spikes(parameters, point + likelihood.step, likelihood.covariance)
    return replace(likelihood, evidence=likelihood.evidence + spikes - CONSTANTS.cost_of_own_value * len(own))


def likeliest(
    look: Callable[[FloatArray], Looked | None], keep: Callable[[FloatArray], FloatArray], start: FloatArray, most_steps: int
) -> Looked | None:
    """From `start` to where the log likelihood no longer rises; None where `look` finds nothing there.

    look : what is to be seen at a point (p,), None where the model does not run; keep : the nearest point within bounds.
    """
    first = look(keep(start))
    if first is None or not most_steps or np.max(np.abs(first.likelihood.step), initial=0.0) < CONSTANTS.least_step:
        return first
    # The first trust region is as large as the start, which is therefore put at so much in every coordinate.
    reach, best, last = CONSTANTS.first_reach, first, first
    origin = best.point - reach
    low, high = keep(np.full(start.size, -np.inf)) - origin, keep(np.full(start.size, np.inf)) - origin

    def squares(moved: FloatArray) -> tuple[FloatArray, FloatArray]:
        nonlocal best, last
        point = keep(moved + origin)
        here = last if np.allclose(point, last.point, rtol=0, atol=1e-12) else look(point)
        if here is None:
            return np.full(start.size + 1, np.inf), np.zeros((start.size + 1, start.size))
        last = here
        if here.likelihood.log > best.likelihood.log:
            best = here
        return here.likelihood.squares

    least_squares(
        squares,
        np.clip(np.full(start.size, reach), low, high),
        (low, high),
        method="dogbox",
        scale=1.0,
        most=most_steps + 1,
        gain=CONSTANTS.enough_gain / max(-best.likelihood.log, CONSTANTS.enough_gain),
        step=CONSTANTS.least_step / reach,
    )
    return best
