"""Does CasADi evaluate our FMUs? It leads the states one by one, by their value references, and asks for slopes."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evat.fmu.part_model import fmu_facts_of, model_of
from evat.native import kernel, machine

HOST = Path(__file__).with_name("host_casadi.py")
RATE_OF = {v.derivative_of: v.name for v in kernel.variables() if v.derivative_of}


@pytest.fixture(params=[2, 3], ids=["FMI2", "FMI3"])
def version(request: pytest.FixtureRequest) -> int:
    if importlib.util.find_spec("casadi") is None:
        pytest.skip("casadi is not installed: pip install 'evat[importers]'")
    return int(request.param)


def asked(fmu: Path, states: dict[str, float], inputs: dict[str, float]) -> Any:
    command = [sys.executable, str(HOST), str(fmu), json.dumps(states), json.dumps(inputs)]
    result = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=300, check=False)
    line = next((line for line in result.stdout.splitlines() if line.startswith("RESULT ")), None)
    assert line is not None, (result.stdout + result.stderr)[-2000:]
    return json.loads(line.removeprefix("RESULT "))


# Points of each FMU of the contact: the deflection, and its inputs.
POINTS: dict[str, tuple[tuple[float, dict[str, float]], ...]] = {
    "evat_guideway": ((3e-6, {"slip_velocity": 0.02}), (4e-6, {"slip_velocity": -0.05})),
    "evat_slip": ((3e-6, {"slip_velocity": 0.1, "uncut_thickness": 5e-5}),),
    "evat_cut": ((2e-6, {"cutting_speed": 0.2}),),
    "evat_contact": ((2e-6, {"cutting_speed": 0.25}),),
}


@pytest.mark.parametrize(
    ("part", "deflection", "inputs"), [(part, *point) for part, points in POINTS.items() for point in points], ids=lambda x: str(x)[:14]
)
def test_the_rates_of_contacts_are_those_of_the_library(
    version: int, fmus: dict[str, Path], part: str, deflection: float, inputs: dict[str, float]
) -> None:
    fmu = fmus[f"fmi{version}" if part == "evat_contact" else f"{part}-fmi{version}"]
    answered = asked(fmu, {"bristle_deflection": deflection}, inputs)
    assert set(answered["states"]) == set(model_of(part).states)
    own = kernel.Contact({**fmu_facts_of(part).start, "bristle_deflection": deflection, **inputs})
    own.start()
    expected = np.array([own.get(RATE_OF[name]) for name in answered["states"]])
    assert np.count_nonzero(expected) == len([name for name in answered["states"] if "." not in name]) >= 2  # those of effects are off
    np.testing.assert_allclose(answered["rates"], expected, rtol=1e-12, atol=0)
    # d(dz/dt)/du by CasADi against differences of the library's: for the guideway 1 - sigma0 z sgn(v)/g(v) and what g changes
    row, moved = answered["states"].index("bristle_deflection"), next(iter(inputs))
    column = answered["inputs"].index(moved)
    assert answered["slopes"][row][column] == pytest.approx(own.derivative("bristle_rate", moved), rel=1e-6)
    assert answered["slopes"][row][column] != 0


def test_rates_of_a_partner_are_those_of_the_library(version: int, fmus: dict[str, Path]) -> None:
    answered = asked(fmus[f"spindle-fmi{version}"], {"spindle_speed": 5.0}, {"principal_force": 120.0})
    own = machine.Machine("spindle", {"principal_force": 120.0})
    own.set("spindle_speed", 5.0)
    own.start()
    rate_of = {v.derivative_of: v.name for v in machine.variables("spindle") if v.derivative_of}
    np.testing.assert_allclose(answered["rates"], [own.get(rate_of[name]) for name in answered["states"]], rtol=1e-12, atol=0)
    assert np.count_nonzero(answered["slopes"]) == 1  # the force brakes the spindle, and nothing else
