"""Where does one come in? `import evat`: the names that a user needs, each loaded when it is first asked for.

Chip-tool friction and elliptical vibration assisted turning as a component: simulate it, identify it, diagnose it, build its FMUs, run
it in a machine. `evat.__all__` lists the names; `help(evat.simulate)` shows one, with its units, its errors and an example.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the same as _PLACES, for type checkers and editors; a test holds the two together
    from evat import parameter_sets
    from evat.answers import diagnose, identify
    from evat.experiment import Experiment, ExperimentError
    from evat.experiment.compression import compress_experiment
    from evat.experiment.read import read_experiment
    from evat.experiment.write import write_experiment
    from evat.files.writing import OutputError
    from evat.fmu import build_fmu
    from evat.fmu.host import host_fmu
    from evat.gap.answer import Diagnosis
    from evat.identification import Execution, Identification, Settings
    from evat.model import BuildError, EvatError, FmuError, Model, ParameterError, Run, SimulationError, Trace
    from evat.models.contact import ContactModel
    from evat.models.fmu import FmuModel
    from evat.models.simulate import simulate
    from evat.native.batch import Batch, run_many
    from evat.native.compile import CompileError
    from evat.native.kernel import Contact, effects, laws, variables
    from evat.studies.orthogonal import orthogonal
    from evat.studies.sensitivity import sensitivities
    from evat.studies.sobol import SobolIndices, sobol
    from evat.systems.model import SspError
    from evat.systems.run import run_system
    from evat.systems.sweep import Sweep, sweep_system

__version__: str

__all__ = [
    "Batch",
    "BuildError",
    "CompileError",
    "Contact",
    "ContactModel",
    "Diagnosis",
    "EvatError",
    "Execution",
    "Experiment",
    "ExperimentError",
    "FmuError",
    "FmuModel",
    "Identification",
    "Model",
    "OutputError",
    "ParameterError",
    "Run",
    "Settings",
    "SimulationError",
    "SobolIndices",
    "SspError",
    "Sweep",
    "Trace",
    "build_fmu",
    "compress_experiment",
    "diagnose",
    "effects",
    "host_fmu",
    "identify",
    "laws",
    "orthogonal",
    "parameter_sets",
    "read_experiment",
    "run_many",
    "run_system",
    "sensitivities",
    "simulate",
    "sobol",
    "sweep_system",
    "variables",
    "write_experiment",
]

_PLACES = {
    "evat.answers": ("diagnose", "identify"),
    "evat.experiment": ("Experiment", "ExperimentError"),
    "evat.experiment.compression": ("compress_experiment",),
    "evat.experiment.read": ("read_experiment",),
    "evat.experiment.write": ("write_experiment",),
    "evat.files.writing": ("OutputError",),
    "evat.fmu": ("build_fmu",),
    "evat.gap.answer": ("Diagnosis",),
    "evat.identification": ("Execution", "Identification", "Settings"),
    "evat.fmu.host": ("host_fmu",),
    "evat.model": ("BuildError", "EvatError", "FmuError", "Model", "ParameterError", "Run", "SimulationError", "Trace"),
    "evat.models.contact": ("ContactModel",),
    "evat.models.fmu": ("FmuModel",),
    "evat.models.simulate": ("simulate",),
    "evat.native.batch": ("Batch", "run_many"),
    "evat.native.compile": ("CompileError",),
    "evat.native.kernel": ("Contact", "effects", "laws", "variables"),
    "evat.studies.orthogonal": ("orthogonal",),
    "evat.studies.sensitivity": ("sensitivities",),
    "evat.studies.sobol": ("SobolIndices", "sobol"),
    "evat.systems.model": ("SspError",),
    "evat.systems.run": ("run_system",),
    "evat.systems.sweep": ("Sweep", "sweep_system"),
}


def __getattr__(name: str) -> Any:
    """Load what is asked for, once (PEP 562): `import evat` alone loads no library."""
    attribute: Any
    if name == "__version__":
        from importlib.metadata import version  # takes as long to load as the list of commands

        attribute = version("evat")
    elif name == "parameter_sets":
        attribute = importlib.import_module("evat.parameter_sets")
    else:
        places = [module for module, names in _PLACES.items() if name in names]
        if not places:
            raise AttributeError(f"module 'evat' has no attribute {name!r}; it has {', '.join(__all__)}.")
        attribute = getattr(importlib.import_module(places[0]), name)
    globals()[name] = attribute
    return attribute


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
