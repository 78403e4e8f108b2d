"""How is an FMU identified? As a Model: each set of values is a run of the FMU through fmpy, start to end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from evat.model import FloatArray, Run, SimulationError, Trace
from evat.models.contact import ContactModel
from evat.models.drive import drive


class FmuModel(ContactModel):
    """The contact as a `Model`, run by its FMU (co-simulation, FMI 2 or 3) instead of by the library.

    Slower: sets run one after the other, and every sample is a communication step.

    Parameters
    ----------
    fmu : path
        A .fmu of the contact, as `evat build` or `build_fmu` writes it.

    Examples
    --------
    After `evat build --host-only --out fmus`:

    >>> import evat
    >>> import numpy as np
    >>> model = evat.FmuModel("fmus/EvatContact-fmi3.fmu")
    >>> values = {"friction_law": "coulomb", "kinematics": "external", "F_C": 3.0, "slip_velocity": 0.1}
    >>> trace = model.simulate(evat.Run(np.array([0.0, 0.1]), outputs=("friction_force",)), (), values)
    >>> print(trace["friction_force"], trace.made_by["fmi"])
    [3. 3.] 3.0
    """

    def __init__(self, fmu: str | PathLike[str]) -> None:
        super().__init__()
        self.fmu = Path(fmu)

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        switches = {effect.name: float(effect.name in on) for effect in self.effects}
        inside = {name: float(column[0]) for name, column in run.inputs.items()}
        return drive(self.fmu, run, {**values, **switches, **inside})

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        count = max([np.size(value) for value in values.values() if np.ndim(value) == 1], default=1)
        found = {name: np.full((count, run.times.size), np.nan) for name in run.outputs}
        for place in range(count):
            own: dict[str, float | str] = {}
            for name, value in values.items():
                own[name] = (
                    value if isinstance(value, str) else float(value[place] if isinstance(value, np.ndarray) and value.ndim else value)
                )
            try:
                trace = self.simulate(run, on, own)
            except SimulationError:
                continue  # this set fails: nan, as the library does it
            for name in run.outputs:
                found[name][place] = trace[name]
        return found
