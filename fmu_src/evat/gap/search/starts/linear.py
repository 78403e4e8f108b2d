"""How likely is a model that is linear in its parameters? In sums that are there already, bounds kept."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from evat.inference.band_whitening import BandWhitening, Sums
from evat.inference.discrepancy import likelihood
from evat.inference.fit import Fit, charged
from evat.inference.parameters import Parameter
from evat.model import FloatArray


def _bounds(parameters: Sequence[Parameter]) -> FloatArray:
    """Least and greatest places, (2, q)."""
    return np.array([[p.within(-math.inf), p.within(math.inf)] for p in parameters]).reshape(-1, 2).T


def expected_evidence(information: FloatArray, point: FloatArray, parameters: Sequence[Parameter]) -> float:
    """Evidence, but for a constant, of a model that is linear in its parameters, with a discrepancy that is given.

    information : (p + 1, p + 1), on [slopes, residual] at `point` (p,); the last of its parameters keep their bounds.
    """
    first, bounds = point.size - len(parameters), _bounds(parameters)
    step = np.linalg.solve(information[:-1, :-1] + np.eye(point.size), information[:-1, -1] - point)
    wanted = point[first:] + step[first:]
    step[first:] = np.clip(wanted, *bounds) - point[first:]
    free = np.append(np.ones(first), (wanted >= bounds[0]) & (wanted <= bounds[1]))
    change, there = np.append(-step, 1.0), point + step
    normal = information[:-1, :-1] * np.outer(free, free) + np.eye(point.size)
    return -0.5 * float(change @ information @ change + there @ there + np.linalg.slogdet(normal)[1])


def linear_fit(
    whitening: BandWhitening, sums: Sums, base: Fit, parameters: Sequence[Parameter], rounds: int = 3
) -> tuple[float, FloatArray]:
    """Evidence and best point (p,) of a model that is linear in its parameters: those of `base`, from where it is, then `parameters`, from
    0, whose bounds are kept: one that would leave them stays there. sums : of [slopes, residual] at that point.

    The evidence is charged as that of `base` is: a law whose usual form is far from what a fit needs costs the same beside an effect.
    """
    point = np.concatenate([base.point, np.zeros(len(parameters))])
    first, bounds = base.point.size, _bounds(parameters)
    free = np.ones(sums.grams.shape[-1])
    for _ in range(rounds + len(parameters)):
        discrepancy = likelihood(whitening, sums, point)
        step = np.where(free[: point.size] > 0, discrepancy.step, 0.0)
        wanted = point[first:] + step[first:]
        step[first:] = np.clip(wanted, *bounds) - point[first:]
        point = point + step
        sums = Sums(moved(sums.grams, step) * np.outer(free, free))
        within = (wanted >= bounds[0]) & (wanted <= bounds[1])
        free[first : point.size] *= within
        rounds -= bool(np.all(within))  # one that meets its bound leaves the others where they stand beside what it wanted
        if not rounds:
            break
    sums = Sums(sums.grams * np.outer(free, free))
    judged = charged(likelihood(whitening, sums, point), (*base.parameters, *parameters), point, base.fixed, base.on)
    return judged.evidence, point


def moved(grams: FloatArray, step: FloatArray) -> FloatArray:
    """Sums (..., w, w) where the residual is what is left after a step (p,) along the slopes: only its row and its column change."""
    moved, residual = grams.copy(), step.size
    moved[..., residual] -= moved[..., : step.size] @ step
    moved[..., residual, :] -= np.einsum("...kj,k->...j", moved[..., : step.size, :], step)
    return moved
