"""Does the compiled loop give what a plain loop over fmpy gives, to the bit?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.systems.couple import NO_INPUTS, Coupled, Given, Inputs, Order, plan
from evat.systems.model import System
from evat.systems.ssp.read import read
from python_master import PythonMaster

STEPS, EVERY = 300, 7
TIMES = np.linspace(0, 0.1, 5)
REFERENCE = Given((("drive", "position_reference"),), TIMES, 1e-3 * np.sin(20 * TIMES)[:, None])


@pytest.fixture(scope="module")
def coupled(systems: dict[str, Path], fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, System]:
    """Systems of FMI 2; "of FMI 3" the same parts by FMI 3, which has no derivatives of inputs."""
    systems_read = {name: read(path, tmp_path_factory.mktemp(name)) for name, path in systems.items()}
    plain, folder = systems_read["stick_slip"], fmus["fmi3"].parent
    parts = {name: replace(part, source=folder / f"{part.source.stem}-fmi3.fmu") for name, part in plain.components.items()}
    return systems_read | {"of FMI 3": replace(plain, components=parts)}


@pytest.mark.parametrize(
    ("name", "given", "order", "inputs"),
    [
        ("stick_slip", NO_INPUTS, "gauss-seidel", "linear"),
        ("stick_slip", NO_INPUTS, "jacobi", "constant"),
        ("of FMI 3", NO_INPUTS, "gauss-seidel", "constant"),
        ("hunting", NO_INPUTS, "jacobi", "linear"),
        ("feed_drive", NO_INPUTS, "gauss-seidel", "linear"),
        ("circular_path", NO_INPUTS, "gauss-seidel", "constant"),
        ("emps", REFERENCE, "gauss-seidel", "linear"),
        ("evat_turning", NO_INPUTS, "jacobi", "linear"),
    ],
)
def test_to_the_bit(coupled: dict[str, System], tmp_path: Path, name: str, given: Given, order: Order, inputs: Inputs) -> None:
    """Times, what all components show, and the power at the bonds; the last step is a shorter one."""
    system = coupled[name]
    assert system.step is not None
    planned = plan(system, stop=(STEPS - 0.6) * system.step, every=EVERY, order=order, inputs=inputs)
    master = PythonMaster(system, given, tmp_path, planned)
    times, columns, energies = master.run()
    master.close()
    with Coupled(system, given=given) as compiled:
        trace, power = compiled.run(planned)
    assert times.size == 2 + STEPS // EVERY
    assert trace.times.tobytes() == times.tobytes()
    assert list(trace.columns) == list(columns)
    assert [at for at, column in columns.items() if trace[at].tobytes() != column.tobytes()] == []
    assert power.shares() == energies
    assert all(passed > 0 for passed, _, _ in energies.values())
