"""Is each cause that once led a run beyond its tolerance still mended? One motion for each, small enough to look into."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from evat.model import FloatArray
from evat.native.kernel import Contact
from judged import Case, Motion, judge, reference, sensitivity

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


# ---- events ----

NARROW: dict[str, Any] = {
    "kinematics": "internal", "friction_law": "karnopp", "F_C": 0.7379, "F_S": 2.56, "karnopp.zero_velocity_band": 1.725249730623923e-4,
    "vibration_frequency": 3341.148583375648, "amplitude_x": 8.956607293869459e-6, "amplitude_y": 2.939542601804317e-6,
    "feed": 4.150291788312933e-5, "chip_flow_shear_angle": 0.4949623694445969, "shear_angle_principle": "minimum_energy",
    "amplitude_loss.kappa": 0.13092034666932229, "amplitude_loss.F_ref": 22.394371195711088,
    "amplitude_loss.response_time": 9.567795178976349e-4,
}  # fmt: skip


def test_a_band_that_is_left_as_soon_as_it_is_met_is_left() -> None:
    """The slip crosses a narrow band of sticking while the load shrinks its amplitude: the point behind an event lay outside the band by
    roundings, so the next event was taken for one that had happened, and the tool stuck for a whole step. Roundings decide where."""
    case = vibrates(NARROW, ("amplitude_loss",), 1e-5, cycles=5.9, points=56.521, speed=0.0552838099)
    right = reference(case)
    for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        judgement = judge(replace(case, relative_tolerance=tolerance), right=right)
        assert judgement.answer.status == "done"
        assert judgement.worst(("friction_force", "mean_friction_force")) < 10, tolerance


# ---- bonds ----

BONDS: dict[str, Any] = {"friction_law": "bristle", "sigma0": 1e6, "F_C": 9.0}


def after(on: str, own: Mapping[str, float], course: list[tuple[str, float, float]]) -> list[float]:
    """Friction force of bonds after inputs that are set to a value and held for a time: with a host that asks for events, and without."""
    forces = []
    for asks in (True, False):
        contact = Contact({**GIVEN, **BONDS, **own, "slip_velocity": 2e-2}, (on,))
        contact.start(0.0)
        for name, value, length in course:
            contact.set(name, value)
            for _ in range(4):
                contact.advance(length / 4)
                if asks:
                    contact.event()
        forces.append(contact.get("friction_force"))
    return forces


# ---- the measure ----


def test_a_draw_is_ill_conditioned_where_its_own_answer_moves() -> None:
    """A reset_integrator that stands at just 0 on its limit: a rounding decides whether it has turned. One that slides does not."""
    times = np.array([0, 0.1, 0.2, 0.3])
    values = {"friction_law": "reset_integrator", "F_C": 9.0, "F_S": 15.0}
    for slip, moves in ((np.array([0.1, 0.05, 0, 0]), True), (np.array([0.1, 0.05, 0.02, 0.02]), False)):
        case = slides(times, slip, values, (), 1e-4, stepped=False)
        assert (sensitivity(case, judge(case).reference, "friction_force") > 10) == moves
