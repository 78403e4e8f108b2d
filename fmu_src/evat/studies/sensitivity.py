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
    """How outputs change with parameters at every time: d output / d parameter, SI, by central differences.

    Parameters
    ----------
    run : Run
        Sample times [s] of shape (n,), inputs of shape (n,), and the outputs to differentiate.
    values : mapping of str to float or str
        The point, SI; what is not named stands at its start. Its relative_tolerance counts where it is below 1e-9.
    parameters : sequence of str
        Those to differentiate with respect to; numbers, no choices.
    on : sequence of str
        Effects that are on.
    at : array of shape (m,), optional
        Times [s] at which the answer is wanted; without it the sample times.
    threads : int, optional
        How many; without it as many as there are processors.
    progress : callable, optional
        Told the share that is done.

    Returns
    -------
    dict of str to dict of str to array of shape (m,)
        `sensitivity[output][parameter]`.

    Raises
    ------
    ParameterError
        For a parameter that is no number.
    SimulationError
        Where a run fails.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> run = evat.Run(np.array([0.0, 0.5, 1.0]), {"slip_velocity": np.full(3, 0.1)}, ("friction_force",))
    >>> slopes = evat.sensitivities(run, {"kinematics": "external", "friction_law": "coulomb"}, ["F_C"])
    >>> print(np.round(slopes["friction_force"]["F_C"], 6))  # the force of Coulomb's law is F_C itself
    [1. 1. 1.]
    """
    values = kernel.in_si(values)
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
