"""How does a system run in one call? Unpacked, given its values, coupled from start to end, and cleared away again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from os import PathLike

import numpy as np

from evat.files.writing import temporary
from evat.model import Run, Trace, nearest
from evat.models.drive import check_run
from evat.systems.couple import NO_INPUTS, Coupled, Given, Inputs, Order, plan
from evat.systems.model import SspError, System, port
from evat.systems.ours import archive_of
from evat.systems.ssp.read import read
from evat.systems.values import in_units, merged, of_work, seconds, variable


def run_system(
    ssp: str | PathLike[str],
    values: Mapping[str, Mapping[str, float | str | bool]] | None = None,
    *,
    sets: Mapping[str, str] | None = None,
    record: Run | None = None,
    step: float | str | None = None,
    stop: float | str | None = None,
    every: int | None = None,
    order: Order = "gauss-seidel",
    inputs: Inputs = "linear",
    progress: Callable[[float], None] | None = None,
) -> Trace:
    """Run a system of FMUs (.ssp): the contact in a machine, or any flat system of FMI 2 or 3 co-simulation FMUs.

    Parameters
    ----------
    ssp : path
        The .ssp file, or one of our systems by its name, such as "stick_slip".
    values : mapping of str to mapping of str to float, str or bool, optional
        For each component the values of its variables, in the units of its FMU (ours: SI), or texts with a unit such as "20 m/min".
    sets : mapping of str to str, optional
        For each component a parameter set of the contact by name, or an .ssv file; `values` come over it.
    record : Run, optional
        Sample times [s] of shape (n,) and inputs at them as "component.variable", of inputs that nothing in the system feeds; its outputs
        are the columns to keep, all where it names none.
    step : float or str, optional
        Communication step, in s or with a unit such as "20 us"; without it the system's own.
    stop : float or str, optional
        Stop time, in s or with a unit; without it the system's own.
    every : int, optional
        Keep every n-th step; without it as the system says.
    order : "gauss-seidel" or "jacobi"
        One component after the other, or all from the same values.
    inputs : "linear" or "constant"
        How inputs go on within a step whose end is not known yet.
    progress : callable, optional
        Told the share that is done.

    Returns
    -------
    Trace
        A column "component.variable" for each output. `made_by["energy_passed"]` and `made_by["energy_made"]` say for each bond how much
        energy [J] went through it, and how much the coupling made (below 0: lost); `made_by["energy_made_or_lost"]` adds up what each step
        made or lost. `made_by["mean_of_last_half"]` has the mean of each output over all steps of the last half, kept or not.

    Raises
    ------
    SspError
        Where the system cannot be read or coupled, or has no such component.
    FmuError
        Where a component is no FMU that runs here.
    ParameterError
        For a variable, value or step that is not allowed.
    SimulationError
        Where a component stops; its `trace` holds the results until then.

    Notes
    -----
    Sadjina et al. 2017 for the energy that a coupling makes.

    Examples
    --------
    The stick-slip case of LuGre 1995:

    >>> import evat
    >>> trace = evat.run_system("stick_slip", stop=0.1)
    >>> trace.units["guideway.friction_force"]
    'N'
    """
    with archive_of(ssp) as path, temporary() as folder:
        system = read(path, folder)
        wanted = plan(system, seconds(step, "step"), seconds(stop, "stop"), every, order, inputs)
        for name in sets or {}:
            if name not in system.components:
                raise SspError(f"there is no component {name!r}; {nearest(name, system.components)}")
        of_sets = [of_work(system, name, which) for name, which in (sets or {}).items()]
        with Coupled(system, merged(*of_sets, in_units(system, values or {})), _given(system, record)) as coupled:
            trace, power = coupled.run(wanted, progress)
        shares = power.shares()
        about: dict[str, str | float | int | Mapping[str, float | str]] = {
            **trace.made_by,
            "energy_passed": {name: passed for name, (passed, _, _) in shares.items()},
            "energy_made": {name: made for name, (_, made, _) in shares.items()},
            "energy_made_or_lost": {name: moved for name, (_, _, moved) in shares.items()},
        }
        return _only(replace(trace, made_by=about), record, system)


def _given(system: System, record: Run | None) -> Given:
    if record is None or not record.inputs:
        return NO_INPUTS
    ports = tuple(port(name, "record") for name in record.inputs)
    for at in ports:
        if variable(system, at).causality != "input":
            raise SspError(f"record: {'.'.join(at)} is no input.")
    check_run(record)
    return Given(ports, np.asarray(record.times, dtype=np.float64), np.column_stack(list(record.inputs.values())))


def _only(trace: Trace, record: Run | None, system: System) -> Trace:
    """The columns that were asked for."""
    names = record.outputs if record is not None and record.outputs else tuple(trace.columns)
    if unknown := [name for name in names if name not in trace.columns]:
        raise SspError(f"the system {system.name} has no output {unknown[0]!r}; {nearest(unknown[0], trace.columns)}")
    return replace(trace, columns={name: trace.columns[name] for name in names}, units={name: trace.units[name] for name in names})
