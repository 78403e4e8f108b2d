"""Where exactly is the optimum, and how well is it known? Whitened nonlinear least squares from the search's best points; its covariance.

least_squares is generalised: whitened by what repeats say of the noise within trials and of what differs between them, where there are any,
else by the correlation of the residual itself. huber and relative (as a smooth sum of magnitudes) are M-estimates: not whitened; their
covariance, and that of least squares that one asked not to whiten, takes the residual's correlation in (a sandwich).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from evat.identification.covariance import Loss, Optimum, Weights, optimum_at
from evat.identification.objective import HUBER, LANES, Objective
from evat.inference.least_squares import least_squares
from evat.inference.noise.autoregression import impulse_response
from evat.inference.noise.estimate import Noise, estimate_noise
from evat.inference.sample_whitening import SampleWhitening
from evat.model import FloatArray

SMOOTH = 0.1  # of the residual's spread: below it the magnitude of eq. 9 is rounded off, lest its slope jump
ROUNDS = 3  # of estimating the noise from the residual, and the parameters with the noise


class _Runs:
    """Residual and slopes at points of the cube where the places `free` move and the others stand."""

    def __init__(self, objective: Objective, loss: Loss, point: FloatArray, free: FloatArray) -> None:
        self.objective, self.loss, self.point, self.free, self.calls = objective, loss, point, free, 0

    def whole(self, moved: FloatArray) -> FloatArray:
        point = self.point.copy()
        point[self.free] = moved
        return point

    def __call__(self, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
        self.calls += 1 + len(moved)
        prediction = self.objective.prediction
        row, table = self.objective.jacobian(self.whole(moved), only=np.flatnonzero(self.free).tolist())
        both = self.loss.weigh(np.column_stack([row - prediction.measured, table]))
        return both[:, 0], both[:, 1:]


def descend(
    objective: Objective, loss: Loss, point: FloatArray, free: FloatArray, most: int = 60, exact: float = 1e-9
) -> tuple[FloatArray, float, int]:
    """The least loss over the places `free` of the cube from `point`: the point, the loss, and how many runs it took."""
    runs = _Runs(objective, loss, point, free)

    def scipy_loss(z: FloatArray) -> FloatArray:
        residual = np.sqrt(z)
        rho, psi, curve = loss(residual)
        slope = np.where(residual > 0, psi / np.where(residual > 0, residual, 1.0), 1.0)
        bend = np.where(residual > 0, (curve - slope) / np.where(z > 0, 2 * z, 1.0), 0.0)
        return np.array([2 * rho, slope, bend])

    if not free.any():
        return point, float(losses(objective, loss, point[None, :])[0]), 1
    begin = np.clip(point[free], 1e-9, 1 - 1e-9)
    solution = least_squares(
        runs,
        begin,
        (0.0, 1.0),
        loss="linear" if np.isinf(loss.bend) else scipy_loss,
        most=most,
        gain=exact,
        step=exact,
        slope=1e-12,
    )
    return runs.whole(solution.x), float(solution.cost), runs.calls


def losses(objective: Objective, loss: Loss, points: FloatArray) -> FloatArray:
    """The loss at points of the cube, (K, p) -> (K,); inf where the model fails."""
    sums = list[float]()
    most = max(LANES, objective.at_once // objective.side_by_side // LANES * LANES)
    for first in range(0, len(points), most):
        for row in objective.predicted(points[first : first + most]):
            if not np.all(np.isfinite(row)):
                sums.append(np.inf)
                continue
            scaled = loss.weigh(row - objective.prediction.measured)
            sums.append(float(loss(scaled)[0].sum()))
    return np.array(sums)


def polish(
    objective: Objective,
    points: Sequence[FloatArray],
    whiten: bool,
    cancelled: Callable[[], bool] | None = None,
    searched: Objective | None = None,
) -> Optimum:
    """The best of the optima near `points`, which a short descent from each tells; the noise is estimated along the way.

    searched : what the search has looked at, where that is less than the whole; the short descents see no more.
    """
    free, calls, point = np.ones(points[0].size, dtype=bool), 0, points[0]
    plain = _plain(objective)
    if len(points) > 1:
        ends, rough = list[tuple[float, FloatArray]](), searched or objective
        for start in points:
            if cancelled is not None and cancelled():
                break
            end, cost, used = descend(rough, _plain(rough), start, free, most=20, exact=1e-4)
            calls += used
            ends.append((cost, end))
        if searched is not None and ends:
            costs = losses(objective, plain, np.array([end for _, end in ends]))
            ends = [(float(cost), end) for cost, (_, end) in zip(costs, ends, strict=True)]
            calls += len(ends)
        point = min(ends, key=lambda each: each[0], default=(np.inf, point))[1]
    loss = plain if objective.kind == "least_squares" else _loss(objective, point, whiten)
    for _ in range(ROUNDS):
        if cancelled is not None and cancelled():
            break
        point, _, used = descend(objective, loss, point, free)
        calls += used
        loss = _loss(objective, point, whiten)
    if cancelled is not None and cancelled():  # the best so far, as it is
        return optimum_at(objective, loss, point, float(losses(objective, loss, point[None, :])[0]), calls + 1)
    point, least, used = descend(objective, loss, point, free)
    return optimum_at(objective, loss, point, least, calls + used)


def _plain(objective: Objective) -> Loss:
    """Least squares by the scales that a search goes by."""
    usual = {channel: 1 / float(np.median(objective.weights[objective.prediction.places(channel)])) for channel in objective.channels}
    return Loss(Weights(objective.weights), usual)


def _loss(objective: Objective, point: FloatArray, whiten: bool) -> Loss:
    """The loss with the noise that repeats tell, or the residual at a point of the cube."""
    predicted = objective.predicted(point[None, :])[0]
    noise = estimate_noise(objective.prediction, predicted, prior=False, from_residual=True)
    sd = _usual_sd(objective, noise)
    if objective.kind == "least_squares" and whiten:
        return Loss(SampleWhitening(objective.at(point), noise, predicted), sd)
    weights = _weights(objective, predicted - objective.prediction.measured)
    if objective.kind == "huber":
        return Loss(Weights(weights), sd, HUBER)
    if objective.kind == "relative":
        return Loss(Weights(objective.shares / objective.shares.mean() * float(np.median(weights))), sd, SMOOTH, True)
    return Loss(Weights(weights), sd)


def _usual_sd(objective: Objective, noise: Noise) -> dict[str, float]:
    """Of a number of each channel, correlated or not [unit of the channel]."""
    usual = dict[str, float]()
    for channel in objective.channels:
        places = [place for place, segment in enumerate(objective.prediction.segments) if segment.channel == channel]
        growth = float(np.sqrt(np.sum(impulse_response(noise.filters[channel]) ** 2))) if channel in noise.filters else 1.0
        usual[channel] = float(np.median(noise.sizes[places])) * growth
    return usual


def _weights(objective: Objective, residual: FloatArray) -> FloatArray:
    """Of each number (N,): by the repeatability of its channel or its stated sd, else by the residual's spread."""
    weights = objective.weights.copy()
    robust = objective.kind != "least_squares"
    for channel in objective.channels:
        places = objective.prediction.places(channel)
        if channel not in objective.noise and not objective.has_sd(channel):
            left = residual[places]
            spread = float(np.median(np.abs(left)) / 0.6745) if robust else float(np.sqrt(np.mean(left**2)))
            weights[places] = 1 / max(spread, 1e-9 / float(objective.weights[places][0]))
    return weights
