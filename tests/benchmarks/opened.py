"""How is an FMU opened for a benchmark? Unpacked and read once, so that neither is timed; instances are fmpy's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
from evat.fmu.description.model_description import FIRST_REFERENCE
from evat.model import FIRST_ITEM
from evat.native import kernel


@dataclass(frozen=True)
class OpenFmu:
    """An FMU in a folder."""

    folder: str
    description: Any

    @property
    def version(self) -> int:
        return int(self.description.fmiVersion[0])

    def instance(self, kind: str = "CoSimulation") -> Any:
        return fmpy.simulation.instantiate_fmu(self.folder, self.description, kind)

    def reference(self, name: str) -> int:
        return kernel.variable(name).index + FIRST_REFERENCE

    def started(self, values: Mapping[str, float | str], time: float = 0.0) -> Any:
        """A co-simulation instance with these values that stands at `time`."""
        instance, two = self.instance(), self.version == 2
        if two:
            instance.setupExperiment(startTime=time)
        for name, number in kernel.check_values(values).items():
            if kernel.variable(name).type == "choice":
                (instance.setInteger if two else instance.setInt64)([self.reference(name)], [int(number) + FIRST_ITEM])
            else:
                (instance.setReal if two else instance.setFloat64)([self.reference(name)], [number])
        instance.enterInitializationMode(**({} if two else {"startTime": time}))
        instance.exitInitializationMode()
        return instance

    def steps(self, instance: Any) -> int:
        """Internal steps since the start."""
        get = instance.getInteger if self.version == 2 else instance.getInt32
        return int(get([self.reference("step_count")])[0])


def opened(fmu: Path, folder: Path) -> OpenFmu:
    return OpenFmu(fmpy.extract(str(fmu), unzipdir=str(folder)), fmpy.read_model_description(str(fmu), validate=False))
