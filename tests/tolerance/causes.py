"""By which motions is a cause looked into, and how far is the kernel off there?"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from evat.model import FloatArray
from judged import Case, Motion, judge

GIVEN = {"kinematics": "external"}


def worst(case: Case, *names: str) -> float:
    """Largest error of these outputs, in tolerances."""
    judgement = judge(case)
    assert (judgement.answer.status, judgement.reference.verdict) == ("done", "done")
    return judgement.worst(names)


def slides(times: FloatArray, slip: FloatArray, values: Mapping[str, Any], on: tuple[str, ...], tolerance: float, *, stepped: bool) -> Case:
    """A slip that is given."""
    return Case("test", {**GIVEN, **values}, on, Motion.record(times, {"slip_velocity": slip}, stepped=stepped), tolerance)


def vibrates(values: Mapping[str, Any], on: tuple[str, ...], tolerance: float, *, cycles: float, points: float, speed: float) -> Case:
    """An ellipse, looked at in so many points a cycle."""
    times = np.arange(0, cycles, 1 / points) / values["vibration_frequency"]
    return Case("test", values, on, Motion.record(times, {"cutting_speed": np.full(times.shape, speed)}, stepped=True), tolerance)
