"""How many internal steps may one value set take, before it is given up?"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.model import Run
from evat.models import contact
from evat.models.contact import ContactModel

RUN = Run(np.linspace(0, 480, 961), {}, ("principal_force",))
STILL = {"kinematics": "internal", "amplitude_x": 0.0, "amplitude_y": 0.0}


def most(monkeypatch: pytest.MonkeyPatch, on: tuple[str, ...] = (), **values: Any) -> float:
    """That a value set may take over 8 minutes at 2 Hz."""
    given: dict[str, Any] = {}
    monkeypatch.setattr(contact, "run_many", lambda *_, **options: given.update(options) or SimpleNamespace(rows={}))
    ContactModel().simulate_many(RUN, on, {**STILL, **values})
    return float(given["most_steps"])


def test_a_tool_that_stands_still_has_no_cycles_to_step_through(monkeypatch: pytest.MonkeyPatch) -> None:
    """It had those of 20 kHz, 9.6 million: a holder that chatters took 340 of the 410 s of a diagnosis of turning."""
    assert most(monkeypatch) < 1e4
    assert most(monkeypatch, amplitude_y=np.array([0.0, 1e-5])) > 1e8


def test_a_spindle_that_runs_out_may_be_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert most(monkeypatch, ("run_out",), **{"run_out.spindle_frequency": 25.0}) > 1e6
    assert most(monkeypatch, **{"run_out.spindle_frequency": 25.0}) < 1e4
