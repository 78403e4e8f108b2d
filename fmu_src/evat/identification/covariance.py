"""How well is an optimum known? The loss and its noise, and the covariance that they give.

Noise that goes on from sample to sample widens what was not whitened: a sandwich of the slopes around the residual's correlation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evat.identification.noise import Colour, colour, coloured, rows_of, whitened
from evat.identification.objective import Objective
from evat.model import FloatArray

LOOSE = 1e3  # sd, in widths of the bounds, that a parameter without any influence gets


@dataclass(frozen=True, eq=False)
class Noise:
    """Weights (N,), the whitening filters, and the loss: scale of its bend (inf: none) and where it is flat in slope."""

    weights: FloatArray
    colours: Colour
    bend: float
    magnitudes: bool

    def loss(self, residual: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """rho, psi = rho', psi' of weighted residuals; rho is r^2/2 near zero."""
        if self.magnitudes:
            root = np.sqrt(1 + (residual / self.bend) ** 2)
            return self.bend**2 * (root - 1), residual / root, 1 / root**3
        inside = np.abs(residual) <= self.bend
        rho = np.where(inside, residual**2 / 2, 0.0 if np.isinf(self.bend) else self.bend * (np.abs(residual) - self.bend / 2))
        return rho, np.clip(residual, -self.bend, self.bend), inside.astype(np.float64)


@dataclass(frozen=True, eq=False)
class Optimum:
    """The optimum in the cube with what is needed to judge its surroundings.

    residual : (N,), calculated less measured, SI; loss : sum of rho there; unit : the loss's rise that is one sd, squared, over 2
    (`2 * (loss - least) / unit` is chi-squared with 1 degree of freedom); stretch : (p,) the factor of a parameter's variance by which
    correlated noise exceeds white one; covariance : of the point of the cube.
    """

    point: FloatArray
    residual: FloatArray
    noise: Noise
    loss: float
    unit: float
    stretch: FloatArray
    covariance: FloatArray
    calls: int


def judged(objective: Objective, noise: Noise, point: FloatArray, loss: float, calls: int) -> Optimum:
    """The optimum with its covariance."""
    predicted, table = objective.jacobian(point)
    residual = predicted - objective.prediction.measured
    scaled = whitened(objective.prediction, noise.colours, residual * noise.weights)
    slopes = whitened(objective.prediction, noise.colours, table * noise.weights[:, None])
    _, psi, curve = noise.loss(scaled)
    count = max(scaled.size - point.size, 1)
    unit = float(np.sum(psi**2) / count / max(float(np.mean(curve)), 1e-12))
    if objective.kind == "least_squares" and all(objective.has_sd(channel) for channel in objective.channels):
        unit = max(unit, 1.0)  # few averages may lie closer to the model than their sd, by chance: that makes nothing better known
    information = slopes.T @ slopes * float(np.mean(curve)) / unit
    covariance = np.linalg.inv(information + np.eye(point.size) / LOOSE**2)
    stretch: FloatArray = np.ones(point.size)
    if not noise.colours:
        colours = {channel: colour(rows) for channel, rows in rows_of(objective.prediction, psi).items()}
        power = _powers(objective, colours, psi)
        meat = coloured(objective.prediction, colours, slopes * power[:, None])
        sandwich = covariance @ (meat.T @ meat) @ covariance / unit**2
        # correlated noise that happens to suit a parameter is no reason to believe in less than white noise
        stretch = np.maximum(np.diag(sandwich) / np.diag(covariance), 1.0)
        grown = np.sqrt(stretch)
        covariance = covariance * grown[:, None] * grown[None, :]
    return Optimum(point, residual, noise, loss, unit, stretch, np.asarray(covariance, dtype=np.float64), calls + 1 + point.size)


def _powers(objective: Objective, colours: Colour, psi: FloatArray) -> FloatArray:
    """sd of the innovations of each number."""
    inner = whitened(objective.prediction, colours, psi)
    found = np.ones(psi.size)
    for channel in objective.channels:
        places = objective.places(channel)
        found[places] = np.sqrt(np.mean(inner[places] ** 2))
    return found
