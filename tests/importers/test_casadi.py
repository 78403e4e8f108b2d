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
from evat.fmu.part_model import model_of
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


@pytest.mark.parametrize(("deflection", "slip"), [(3e-6, 0.02), (-2e-6, 0.3), (4e-6, -0.05)])
def test_the_rates_of_the_guideway_are_those_of_the_library(version: int, fmus: dict[str, Path], deflection: float, slip: float) -> None:
    answered = asked(fmus[f"evat_guideway-fmi{version}"], {"bristle_deflection": deflection}, {"slip_velocity": slip})
    assert set(answered["states"]) == set(model_of("evat_guideway").states)
    own = kernel.Contact({"kinematics": "external", "bristle_deflection": deflection, "slip_velocity": slip})
    own.start()
    expected = np.array([own.get(RATE_OF[name]) for name in answered["states"]])
    assert np.count_nonzero(expected) == len(expected) == 3
    np.testing.assert_allclose(answered["rates"], expected, rtol=1e-12, atol=0)
    # d(dz/dt)/dv by CasADi against the law: 1 - sigma0 z sgn(v)/g(v) and what g changes, by differences of the library's
    row, column = answered["states"].index("bristle_deflection"), answered["inputs"].index("slip_velocity")
    assert answered["slopes"][row][column] == pytest.approx(own.derivative("bristle_rate", "slip_velocity"), rel=1e-6)


def test_rates_of_a_partner_are_those_of_the_library(version: int, fmus: dict[str, Path]) -> None:
    answered = asked(fmus[f"spindle-fmi{version}"], {"spindle_speed": 5.0}, {"principal_force": 120.0})
    own = machine.Machine("spindle", {"principal_force": 120.0})
    own.set("spindle_speed", 5.0)
    own.start()
    rate_of = {v.derivative_of: v.name for v in machine.variables("spindle") if v.derivative_of}
    np.testing.assert_allclose(answered["rates"], [own.get(rate_of[name]) for name in answered["states"]], rtol=1e-12, atol=0)
    assert np.count_nonzero(answered["slopes"]) == 1  # the force brakes the spindle, and nothing else
