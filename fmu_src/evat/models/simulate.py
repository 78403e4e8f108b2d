"""What forces does the contact give for these parameters and this motion? The API behind `evat simulate`, on the kernel itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from evat.model import FloatArray, ParameterError, Run, Trace
from evat.models.contact import ContactModel
from evat.native import kernel

SHOWN = (
    "principal_force",
    "feed_force",
    "friction_force",
    "normal_force",
    "slip_velocity_used",
    "uncut_thickness_used",
    "bristle_deflection",
    "shear_angle",
    "theta_used",
    "in_contact",
    "mean_principal_force",
    "mean_feed_force",
    "mean_friction_force",
    "mean_normal_force",
    "mean_contact_ratio",
)


MOST_SAMPLES = 1e8  # 0.8 GB for each column


def vibration_clock(cycles: float, frequency: float, samples_per_cycle: int = 200) -> FloatArray:
    """Sample times [s] over `cycles` vibration cycles of `frequency` [Hz], the last one included."""
    if not (cycles > 0 and samples_per_cycle >= 2 and cycles * samples_per_cycle <= MOST_SAMPLES):
        raise ParameterError(
            f"cycles = {cycles:g}, samples_per_cycle = {samples_per_cycle}: more than 0, at least 2, and at most {MOST_SAMPLES:g} samples "
            "in all are needed."
        )
    count = max(2, round(cycles * samples_per_cycle) + 1)
    return np.arange(count, dtype=np.float64) / (samples_per_cycle * frequency)


def simulate(
    values: Mapping[str, float | str] | None = None,
    effects: Sequence[str] = (),
    *,
    times: FloatArray | None = None,
    inputs: Mapping[str, FloatArray] | None = None,
    cycles: float = 5,
    samples_per_cycle: int = 200,
    outputs: Sequence[str] = SHOWN,
) -> Trace:
    """Run the contact.

    Parameters
    ----------
    values : parameters and constant inputs by the component's names, in SI, choices by name.
    effects : effects that are on.
    times, inputs : a measured or given motion: sample times [s], shape (n,), and inputs at them, linear in between.
        Without them the run is `cycles` vibration cycles long, with `samples_per_cycle` samples.
    outputs : the variables to record.

    Returns
    -------
    Trace with one column for each output, units and provenance.

    Raises
    ------
    ParameterError for an unknown name or a value out of bounds; SimulationError where the run breaks off.
    """
    values = dict(values or {})
    if times is None:
        if inputs:
            raise ParameterError("inputs were given without sample times.")
        frequency = kernel.check_values(values).get("vibration_frequency", kernel.variable("vibration_frequency").start)
        times = vibration_clock(cycles, frequency, samples_per_cycle)
    clock = np.asarray(times, dtype=np.float64)
    columns = {name: np.asarray(column, dtype=np.float64) for name, column in (inputs or {}).items()}
    if clock.ndim != 1 or clock.size == 0:
        raise ParameterError(f"times have the shape {clock.shape}: one row of at least one sample time in s is needed.")
    for name, column in columns.items():
        if column.shape != clock.shape:
            raise ParameterError(f"{name} has the shape {column.shape}: one value for each of the {clock.size} sample times is needed.")
    run = Run(clock, columns, tuple(outputs))
    return ContactModel().simulate(run, tuple(effects), values)
