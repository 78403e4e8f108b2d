"""Which parameters of a model with these effects fit best, and how likely are the data then? Levenberg and Marquardt, all slopes in one
call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.discrepancy import Likelihood, likelihood
from evat.inference.parameters import Parameter
from evat.inference.prediction import Prediction
from evat.inference.whitening import Sums, Whitening
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

    def again(self, whitening: Whitening) -> Fit:
        """The same point, judged by what is forgiven now."""
        return replace(self, likelihood=likelihood(whitening, self.sums, self.point))


def fit(
    prediction: Prediction,
    whitening: Whitening,
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
        here = likelihood(whitening, sums, point, held_out=held_out)
        return Fit(point, sums, here, tuple(on), tuple(parameters), predicted, slopes, fixed)

    def keep(point: FloatArray) -> FloatArray:
        return np.array([p.within(float(u)) for p, u in zip(parameters, point, strict=True)])

    return levenberg_marquardt(look, keep, start, whitening, CONSTANTS.most_steps if most_steps is None else most_steps, held_out)


def levenberg_marquardt(
    look: Callable[[FloatArray], Looked | None],
    keep: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    whitening: Whitening,
    most_steps: int,
    held_out: BoolArray | None = None,
) -> Looked | None:
    """Levenberg's and Marquardt's steps from `start` to where the log likelihood no longer rises; None where `look` finds nothing there.

    look : what is to be seen at a point (p,), None where the model does not run; keep : the nearest point within bounds.
    """
    best = look(keep(start))
    if best is None:
        return None
    damping = 0.0
    for _ in range(most_steps):
        step = likelihood(whitening, best.sums, best.point, damping=damping, held_out=held_out).step if damping else best.likelihood.step
        step = step / max(1.0, float(np.max(np.abs(step), initial=0.0)) / 3)  # three prior standard deviations at a time
        point = keep(best.point + step)
        if np.max(np.abs(point - best.point), initial=0.0) < 1e-4:
            break
        tried = look(point)
        if tried is None or tried.likelihood.log < best.likelihood.log - 1e-9:
            damping = max(4 * damping, 0.3)
            if damping > 1e3:
                break
            continue
        gained = tried.likelihood.log - best.likelihood.log
        best, damping = tried, damping / 4 if damping > 0.1 else 0.0
        if gained < CONSTANTS.enough_gain:
            break
    return best
