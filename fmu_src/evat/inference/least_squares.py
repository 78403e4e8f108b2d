"""Where is the least sum of squares within bounds? By scipy's trust regions, with residual and slopes from one call of the model.

Both come side by side, which costs hardly more than the residual alone. Identification and diagnosis look for their optima here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from scipy.optimize import OptimizeResult
from scipy.optimize import least_squares as trust_region

from evat.model import FloatArray


def least_squares(
    look: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    start: FloatArray,
    bounds: tuple[FloatArray | float, FloatArray | float],
    *,
    method: Literal["trf", "dogbox"] = "trf",
    scale: float | str = "jac",
    loss: str | Callable[[FloatArray], FloatArray] = "linear",
    most: int,
    gain: float,
    step: float,
    slope: float | None = None,
) -> OptimizeResult:
    """The nearest minimum to `start` (p,), as scipy.optimize.least_squares tells of it.

    look : residual (m,) and slopes (m, p) at a point; what is not finite is no place to go to; method : trf stays off the bounds until the
    end, dogbox goes along them; most : how often to look; gain, step, slope : relative gain, relative step and slope that are small enough
    to end.
    """
    at, slopes = np.empty(0), np.empty((0, 0))

    def residual(point: FloatArray) -> FloatArray:
        nonlocal at, slopes
        row, slopes = look(point)
        at = point.copy()
        return row

    def jacobian(point: FloatArray) -> FloatArray:
        if not np.array_equal(point, at):
            residual(point)
        return slopes

    return trust_region(
        residual, start, jacobian, bounds=bounds, method=method, x_scale=scale, loss=loss, max_nfev=most, ftol=gain, xtol=step, gtol=slope
    )
