"""Where exactly is the optimum, and how well is it known? Whitened nonlinear least squares from the search's best points; its covariance.

least_squares is whitened: by the correlation of repeats, where there are any, else of the residual itself. huber and relative (as a smooth
sum of magnitudes) are M-estimates: not whitened; their covariance, and that of least squares that one asked not to whiten, takes the
residual's correlation in (a sandwich).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import least_squares

from evat.identification.covariance import Noise, Optimum, judged
from evat.identification.noise import Colour, colour, rows_of, whitened
from evat.identification.objective import HUBER, Objective, repeats
from evat.model import FloatArray

SMOOTH = 0.1  # of the residual's spread: below it the magnitude of eq. 9 is rounded off, lest its slope jump
ROUNDS = 3  # of estimating the noise from the residual, and the parameters with the noise


class _Runs:
    """Residual and slopes at points of the cube where the places `free` move and the others stand.

    Both come from one call of the model, side by side, which costs hardly more than the residual alone.
    """

    def __init__(self, objective: Objective, noise: Noise, point: FloatArray, free: FloatArray) -> None:
        self.objective, self.noise, self.point, self.free, self.calls = objective, noise, point, free, 0
        self._at, self._slopes = np.empty(0), np.empty((0, 0))

    def whole(self, moved: FloatArray) -> FloatArray:
        found = self.point.copy()
        found[self.free] = moved
        return found

    def residual(self, moved: FloatArray) -> FloatArray:
        self.calls += 1 + len(moved)
        prediction = self.objective.prediction
        row, table = self.objective.jacobian(self.whole(moved), only=np.flatnonzero(self.free).tolist())
        both = np.column_stack([row - prediction.measured, table]) * self.noise.weights[:, None]
        both = whitened(prediction, self.noise.colours, both)
        self._at, self._slopes = moved.copy(), both[:, 1:]
        return both[:, 0]

    def slopes(self, moved: FloatArray) -> FloatArray:
        if not np.array_equal(moved, self._at):
            self.residual(moved)
        return self._slopes


def descend(
    objective: Objective, noise: Noise, point: FloatArray, free: FloatArray, most: int = 60, exact: float = 1e-9
) -> tuple[FloatArray, float, int]:
    """The least loss over the places `free` of the cube from `point`: the point, the loss, and how many runs it took."""
    runs = _Runs(objective, noise, point, free)

    def scipy_loss(z: FloatArray) -> FloatArray:
        residual = np.sqrt(z)
        rho, psi, curve = noise.loss(residual)
        slope = np.where(residual > 0, psi / np.where(residual > 0, residual, 1.0), 1.0)
        bend = np.where(residual > 0, (curve - slope) / np.where(z > 0, 2 * z, 1.0), 0.0)
        return np.array([2 * rho, slope, bend])

    if not free.any():
        return point, float(losses(objective, noise, point[None, :])[0]), 1
    begin = np.clip(point[free], 1e-9, 1 - 1e-9)
    found = least_squares(
        runs.residual,
        begin,
        runs.slopes,
        bounds=(0.0, 1.0),
        x_scale="jac",
        loss="linear" if np.isinf(noise.bend) else scipy_loss,
        max_nfev=most,
        ftol=exact,
        xtol=exact,
        gtol=1e-12,
    )
    return runs.whole(found.x), float(found.cost), runs.calls


def losses(objective: Objective, noise: Noise, points: FloatArray) -> FloatArray:
    """The loss at points of the cube, (K, p) -> (K,); inf where the model fails."""
    found = []
    for first in range(0, len(points), objective.at_once):
        for row in objective.predicted(points[first : first + objective.at_once]):
            scaled = whitened(objective.prediction, noise.colours, (row - objective.prediction.measured) * noise.weights)
            found.append(float(noise.loss(scaled)[0].sum()) if np.all(np.isfinite(scaled)) else np.inf)
    return np.array(found)


def polish(objective: Objective, points: Sequence[FloatArray], whiten: bool, cancelled: Callable[[], bool] | None = None) -> Optimum:
    """The best of the optima near `points`, which a short descent from each tells; the noise is estimated along the way."""
    free, calls, point = np.ones(points[0].size, dtype=bool), 0, points[0]
    if len(points) > 1:
        plain, least = Noise(objective.weights, {}, np.inf, False), np.inf
        for start in points:
            if cancelled is not None and cancelled():
                break
            end, loss, used = descend(objective, plain, start, free, most=20, exact=1e-4)
            calls += used
            if loss < least:
                point, least = end, loss
    repeated = repeats(objective.prediction)
    from_repeats = {channel: colour(rows) for channel, rows in repeated.items()}
    noise = Noise(objective.weights, {}, np.inf, False)
    if objective.kind != "least_squares":
        noise = _noise(objective, _residual(objective, point), from_repeats, whiten)
    for _ in range(ROUNDS):
        if cancelled is not None and cancelled():
            break
        point, _, used = descend(objective, noise, point, free)
        calls += used
        noise = _noise(objective, _residual(objective, point), from_repeats, whiten)
    point, loss, used = descend(objective, noise, point, free)
    return judged(objective, noise, point, loss, calls + used)


def _residual(objective: Objective, point: FloatArray) -> FloatArray:
    found: FloatArray = objective.predicted(point[None, :])[0] - objective.prediction.measured
    return found


def _noise(objective: Objective, residual: FloatArray, from_repeats: Colour, whiten: bool) -> Noise:
    """Weights by channel: the repeats' noise, else the residual's spread; filters where least squares is to be whitened."""
    weights = objective.weights.copy()
    robust = objective.kind != "least_squares"
    for channel in objective.channels:
        places = objective.places(channel)
        if channel not in objective.noise and not objective.has_sd(channel):
            left = residual[places]
            spread = float(np.median(np.abs(left)) / 0.6745) if robust else float(np.sqrt(np.mean(left**2)))
            weights[places] = 1 / max(spread, 1e-9 / float(objective.weights[places][0]))
    if objective.kind == "huber":
        return Noise(weights, {}, HUBER, False)
    if objective.kind == "relative":
        return Noise(objective.shares / objective.shares.mean() * float(np.median(weights)), {}, SMOOTH, True)
    if not whiten:
        return Noise(weights, {}, np.inf, False)
    own = {channel: colour(rows) for channel, rows in rows_of(objective.prediction, residual).items()}
    return Noise(weights, {**own, **from_repeats}, np.inf, False)
