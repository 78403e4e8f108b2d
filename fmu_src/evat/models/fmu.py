"""How is an FMU identified? As a Model: each set of values is a run of the FMU through fmpy, start to end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from os import PathLike
from pathlib import Path

import fmpy
import numpy as np

from evat.files.unpack import member, opened
from evat.model import FloatArray, ParameterError, Run, SimulationError, Trace, hash_of
from evat.models.contact import ContactModel
from evat.models.drive import drive
from evat.native import kernel
from evat.native.batch import value_sets
from evat.required_inputs import check_required_inputs


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

    @cached_property
    def digest(self) -> str:
        """Hash over the FMU's token, binaries and resources; not over its packing and dates, which differ from build to build.

        ArchiveError where the file cannot be read.
        """
        with opened(self.fmu) as archive:
            names = sorted(e.filename for e in archive.infolist() if e.filename.startswith(("binaries/", "resources/")) and not e.is_dir())
            parts = [part for name in names for part in (name, member(archive, name))]
        return hash_of(fmpy.read_model_description(str(self.fmu), validate=False).guid, *parts)

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        """Drive the FMU through `run`; see evat.model.Model. At least two samples."""
        numbers = kernel.check_values(values, on)
        check_required_inputs(self, on, values, run.inputs)
        off = dict.fromkeys((effect.name for effect in self.effects), 0.0)
        first = {name: float(column[0]) for name, column in run.inputs.items()}
        whole = replace(run, outputs=tuple(run.outputs) or kernel.outputs())
        trace = drive(self.fmu, whole, {**off, **kernel.by_choice(numbers), **first})
        return replace(trace, made_by={**trace.made_by, "model": self.digest})

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """K value sets, each a run of its own; see evat.model.Model."""
        if not run.outputs:
            raise ParameterError("no outputs were asked for; name at least one, for example friction_force.")
        count, _, _ = value_sets(values, on, run)
        rows = {name: np.full((count, run.times.size), np.nan) for name in run.outputs}
        for place in range(count):
            own = {name: value if np.ndim(value) == 0 else float(np.asarray(value)[place]) for name, value in values.items()}
            inputs = {name: column if np.ndim(column) == 1 else column[place] for name, column in run.inputs.items()}
            try:
                trace = self.simulate(replace(run, inputs=inputs), on, own)  # type: ignore[arg-type]
            except SimulationError:
                continue  # this set fails: nan, as the library does it
            for name in run.outputs:
                rows[name][place] = trace[name]
        return rows
