"""How do the outputs change with the parameters? Central differences of runs that differ in nothing else, side by side in one batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from evat.model import FloatArray, ParameterError, Run, SimulationError, Variable
from evat.native import kernel
from evat.native.batch import run_many

TOLERANCE = 1e-9  # of the runs: their noise; a step of its cube root balances noise against the curvature of the output
CENTRAL = (np.array([-1.0, 1.0, 0.0]), np.array([-0.5, 0.5, 0.0]))  # places in steps, and weights
UPWARD = (np.array([0.0, 1.0, 2.0]), np.array([-1.5, 2.0, -0.5]))  # of second order too, from within a bound
DOWNWARD = (np.array([-2.0, -1.0, 0.0]), np.array([0.5, -2.0, 1.5]))


def _stencil(known: Variable, value: float, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Values of the parameter to run at, and the weights of their outputs in the derivative."""
    step = max(abs(value), 0.1 * known.nominal) * tolerance ** (1 / 3)
    step = min(step, (known.max - known.min) / 4)
    places, weights = UPWARD if value - step < known.min else DOWNWARD if value + step > known.max else CENTRAL
    return value + places * step, weights / step


def sensitivities(
    run: Run,
    values: Mapping[str, float | str],
    parameters: Sequence[str],
    on: Sequence[str] = (),
    *,
    at: FloatArray | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, dict[str, FloatArray]]:
    """d output / d parameter at every kept time, SI: `found[output][parameter]` of shape (n,).

    Parameters
    ----------
    run, on, at, threads, progress : as run_many; inputs are shared by all sets.
    values : the point, SI; a parameter that is not named stands at its start. Its relative_tolerance counts where it is below 1e-9.
    parameters : those to differentiate with respect to; tunable or fixed numbers, no choices.

    Raises
    ------
    ParameterError for a parameter that is no number; SimulationError where a run fails.
    """
    point = kernel.check_values(values)
    tolerance = min(point.get("relative_tolerance", TOLERANCE), TOLERANCE)
    stencils = []
    for name in parameters:
        known = kernel.variable(name)
        if known.causality not in ("parameter", "input") or known.type != "real" or name in run.inputs:
            raise ParameterError(f"{name} is no number that is held during the run; differentiate with respect to parameters.")
        stencils.append(_stencil(known, point.get(name, known.start), tolerance))
    sets: dict[str, float | str | FloatArray] = {**values, "relative_tolerance": tolerance}
    for place, name in enumerate(parameters):
        column = np.full(3 * len(parameters), point.get(name, kernel.variable(name).start))
        column[3 * place : 3 * place + 3] = stencils[place][0]
        sets[name] = column
    batch = run_many(replace(run, outputs=tuple(run.outputs)), sets, on, at=at, threads=threads, progress=progress)
    if batch.failed:
        place, why = next(iter(batch.failed.items()))
        raise SimulationError(f"the run beside {parameters[place // 3]} failed: {why}.")
    return {
        output: {name: stencils[place][1] @ rows[3 * place : 3 * place + 3] for place, name in enumerate(parameters)}
        for output, rows in batch.rows.items()
    }
