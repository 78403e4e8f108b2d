"""Do entry and exit reach a host that people use? FMI 3 Co-Simulation with event mode and early return, through fmpy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from evat.native.kernel import Contact
from fmpy.simulation import instantiate_fmu
from scipy.optimize import brentq

FREQUENCY = 20e3
PERIOD = 1 / FREQUENCY
HSR = (10 / 60) / (2 * math.pi * FREQUENCY * 5e-6)
THETA_S = float(brentq(lambda theta: HSR * (math.pi - theta) - math.sin(theta), 1e-3, 2.0, xtol=1e-15))
EXIT, ENTRY = PERIOD * math.acos(-HSR) / (2 * math.pi), PERIOD * (1 - THETA_S / (2 * math.pi))
CLOSE = 1e-7 * PERIOD / 20  # a thousandth of relative_tolerance, of the longest internal step


@pytest.fixture(scope="module")
def opened(fmi3_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Any]:
    return fmpy.extract(str(fmi3_fmu), str(tmp_path_factory.mktemp("fmi3"))), fmpy.read_model_description(str(fmi3_fmu))


def crossings(until: float) -> list[tuple[float, float]]:
    """(time, in_contact behind it) of the kernel, in steps that stop at events; nothing of the FMU."""
    contact, sides = Contact(), []
    contact.start()
    while contact.time < until * (1 - 1e-12):
        left = until - contact.time
        if contact.advance(left, stop_at_events=True) < left:
            before = contact.get("in_contact")
            contact.event()
            if contact.get("in_contact") != before:
                sides.append((contact.time, contact.get("in_contact")))
    return sides


def test_steps_return_at_entry_and_exit(opened: tuple[str, Any]) -> None:
    """Two steps of 1.5 cycles, as a host makes them: return, event mode, step mode, go on."""
    folder, description = opened
    one = instantiate_fmu(folder, description, "CoSimulation", early_return_allowed=True, event_mode_used=True)
    references = {v.name: v.valueReference for v in description.modelVariables}
    one.enterInitializationMode(startTime=0.0)
    one.exitInitializationMode()
    one.updateDiscreteStates()
    one.enterStepMode()
    time, sides, contact = 0.0, [], one.getBoolean([references["in_contact"]])[0]
    for end in (1.5 * PERIOD, 3 * PERIOD):
        while time < end - CLOSE:
            event, terminate, early, time = one.doStep(currentCommunicationPoint=time, communicationStepSize=end - time)
            assert not terminate
            assert bool(event) == bool(early)
            if event:
                one.enterEventMode()
                one.updateDiscreteStates()
                now = one.getBoolean([references["in_contact"]])[0]
                sides += [(time, float(now))] if now != contact else []
                contact = now
                one.enterStepMode()
    one.terminate()
    one.freeInstance()
    expected = [(EXIT, 0.0), (ENTRY, 1.0), (EXIT + PERIOD, 0.0), (ENTRY + PERIOD, 1.0), (EXIT + 2 * PERIOD, 0.0), (ENTRY + 2 * PERIOD, 1.0)]
    assert [side for _, side in sides] == [side for _, side in expected]
    assert np.abs(np.array(sides) - expected)[:, 0].max() <= CLOSE
    assert np.abs(np.array(sides) - crossings(3 * PERIOD))[:, 0].max() <= CLOSE


def test_fmpys_own_loop_records_the_events(fmi3_fmu: Path) -> None:
    """simulate_fmu with steps of a whole cycle: rows stand at the events, and the force is gone right behind the exit."""
    result = fmpy.simulate_fmu(
        str(fmi3_fmu),
        stop_time=2 * PERIOD,
        output_interval=PERIOD,
        fmi_type="CoSimulation",
        use_event_mode=True,
        early_return_allowed=True,
        record_events=True,
        output=["principal_force", "in_contact"],
    )
    for due, side in ((EXIT, 0), (ENTRY, 1), (EXIT + PERIOD, 0), (ENTRY + PERIOD, 1)):
        rows = result[np.abs(result["time"] - due) <= CLOSE]
        assert rows.size >= 2  # before and behind
        assert rows["in_contact"][-1] == side
        assert (rows["principal_force"][-1] == 0) == (side == 0)


def test_an_averaged_step_has_no_events(opened: tuple[str, Any]) -> None:
    folder, description = opened
    one = instantiate_fmu(folder, description, "CoSimulation", early_return_allowed=True, event_mode_used=True)
    references = {v.name: v.valueReference for v in description.modelVariables}
    one.setInt64([references["averaging"]], [2])
    one.enterInitializationMode(startTime=0.0)
    one.exitInitializationMode()
    one.updateDiscreteStates()
    one.enterStepMode()
    event, _, early, time = one.doStep(currentCommunicationPoint=0.0, communicationStepSize=1e-3)
    assert (bool(event), bool(early), time) == (False, False, 1e-3)
    one.terminate()
    one.freeInstance()
