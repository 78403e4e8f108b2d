"""What do the tests of systems share? One call that runs an .ssp."""

from __future__ import annotations

import tempfile
from pathlib import Path

import lugre_1995 as published
import numpy as np
from evat.model import Trace
from evat.systems.couple import NO_INPUTS, Given, Values, run_file
from evat.systems.power import Power


def run(path: Path, values: Values | None = None, given: Given = NO_INPUTS, **wishes: object) -> tuple[Trace, Power]:
    with tempfile.TemporaryDirectory() as folder:
        return run_file(path, Path(folder), values, given, **wishes)


def motion(trace: Trace) -> published.Motion:
    """The block's motion, for the readers of the 1995 figures."""
    return published.Motion(trace.times, trace["drive.table_position"], trace["drive.table_velocity"], trace["guideway.friction_force"])


def order(errors: list[float]) -> np.ndarray:
    """Slope of the error over steps that halve."""
    return np.log2(np.divide(errors[:-1], errors[1:]))
