"""What forces does the contact give for these parameters and this motion? The API behind `evat simulate`, on the kernel itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from evat.model import FloatArray, ParameterError, Run, Trace
from evat.models.contact import ContactModel
from evat.native import kernel
from evat.required_inputs import KINEMATICS, MOTION

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


NO_WINDOW = 1e-9  # s, that of fmu_src/kernel/stages.h: an averaging window that is shorter is none


def averaging_window(values: Mapping[str, float | str]) -> float:
    """Length of the window over which the component takes its means [s]; 0 where they need none: they are then of the moment, or of whole
    cycles."""

    def number(name: str) -> float:
        known = kernel.variable(name)
        return float(known.check(values.get(name, known.start)))

    chosen = {name: kernel.variable(name).choices[int(number(name))] for name in ("averaging", KINEMATICS)}
    if chosen["averaging"] == "cycle":
        return 0.0
    if number("averaging_window") >= NO_WINDOW:
        return number("averaging_window")
    return 0.0 if chosen[KINEMATICS] in kernel.variable(MOTION).required_with else 1 / number("vibration_frequency")


def simulate(
    values: Mapping[str, float | str] | None = None,
    effects: Sequence[str] = (),
    *,
    times: FloatArray | None = None,
    inputs: Mapping[str, FloatArray] | None = None,
    cycles: float = 5,
    samples_per_cycle: int = 200,
    outputs: Sequence[str] = SHOWN,
    **named: float | str,
) -> Trace:
    """Run the contact: over some vibration cycles, or along a motion of your own.

    Parameters
    ----------
    values : mapping of str to float or str
        Parameters and constant inputs by the component's names (`evat info` lists them), choices by name: numbers are SI,
        texts may have a unit. What is not named stands at its start value.
    effects : sequence of str
        Names of the effects that are on.
    times : array of shape (n,), optional
        Sample times [s] of a given motion. Without them the run is `cycles` vibration cycles long.
    inputs : mapping of str to array of shape (n,), optional
        Inputs at the sample times, SI, linear in between.
    cycles : float
        Without `times`: how many vibration cycles.
    samples_per_cycle : int
        Without `times`: samples in each.
    outputs : sequence of str
        The variables to record.
    named : float or str
        More values, by their names, such as `cutting_speed="20 m/min"`; they come over `values`.

    Returns
    -------
    Trace
        A column of shape (n,) for each output, its unit, and how it was made.

    Raises
    ------
    ParameterError
        For an unknown name or a value out of bounds.
    SimulationError
        Where the run breaks off.

    Notes
    -----
    Canudas de Wit et al. 1995 (LuGre), and the paper's modification of it; each variable, law and effect names its own source.

    Examples
    --------
    >>> import evat
    >>> aluminium = evat.parameter_sets.load("regularised/al-7075-t6")
    >>> trace = evat.simulate(aluminium.values, aluminium.effects, cycles=5, cutting_speed="20 m/min")
    >>> print(f"{trace['mean_feed_force'][-1]:.2f} {trace.units['mean_feed_force']}")
    1.94 N
    """
    values = kernel.in_si({**(values or {}), **named})
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
