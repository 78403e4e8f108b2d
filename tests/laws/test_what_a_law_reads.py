"""Does a friction law read of the base table what it says, and nothing else? And which laws may stand in for another one?"""

from __future__ import annotations

import numpy as np
import pytest
from driving import started
from evat.model import FloatArray, Variable
from evat.models.contact import ContactModel
from evat.native import kernel

LAWS = kernel.laws()
BASE = kernel.variables()[: kernel.library()[1].BASE_COUNT]
READABLE = (
    *(v for v in BASE if v.causality == "parameter" and v.variability == "tunable"),
    kernel.variable("applied_force"),
    kernel.variable("normal_load"),
)
# Strokes of several break-away deflections, at speeds around v_s; as published, since the limit of the damping reads damping_margin.
SETTING: dict[str, float | str] = {
    "kinematics": "external", "damping_mode": "as_published", "relative_tolerance": 1e-8, "karnopp.zero_velocity_band": 5e-3,
    "sigma0": 1e5, "sigma1": 100.0, "sigma2": 50.0, "F_C": 9.0, "F_S": 12.0, "v_s": 1e-2,
}  # fmt: skip
TIMES = np.linspace(0, 0.5, 301)
SLIP = 2e-2 * np.sin(2 * np.pi * 8 * TIMES + 0.1)
APPLIED = 60 * TIMES  # within F_S, then beyond
LOAD = 20 + 10 * np.cos(30 * TIMES)


def force(law: str, changed: Variable | None = None) -> FloatArray:
    """Friction force along the strokes, (301,), with a tenth more of one variable."""
    values, inputs = {**SETTING, "friction_law": law}, {"slip_velocity": SLIP, "applied_force": APPLIED, "normal_load": LOAD}
    if changed is not None and changed.causality == "input":
        inputs[changed.name] = 1.1 * inputs[changed.name]
    elif changed is not None:
        values[changed.name] = 1.1 * float(values.get(changed.name, changed.start)) + (0.0 if changed.start else 0.1 * changed.nominal)
    contact = started({**values, "slip_velocity": float(SLIP[0]), "normal_load": float(inputs["normal_load"][0])})
    return contact.run(TIMES, inputs, ("friction_force",))[:, 0]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_the_force_follows_what_the_law_reads_and_nothing_else(law: kernel.Law) -> None:
    """A tenth moves the force by a thousandth or more; what is not read moves internal steps at most, at a tolerance of 1e-8."""
    first = force(law.name)
    moved = {known.name: float(np.max(np.abs(force(law.name, known) - first)) / np.max(np.abs(first))) for known in READABLE}
    assert {name for name, share in moved.items() if share > 1e-5} == {known.name for known in law.reads}
    assert min(moved[known.name] for known in law.reads) > 1e-3


OF_STATIC_FRICTION: dict[str, tuple[dict[str, float | str], tuple[str, ...]]] = {
    "given": (
        {"kinematics": "external", "uncut_thickness": 1e-6, "normal_load": 1.0, "applied_force": 1e3},
        ("direction_asymmetry", "stribeck"),
    ),
    "cut": ({"chip_flow_angle": "current_shear_angle"}, ("sensor_delay",)),
    "periodic": ({"initial_state": "periodic", "release_time": 1e-5}, ("thermal_softening",)),
    "averaged": ({"averaging": "cycle", "release_time": 1e-4}, ()),
}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("case", OF_STATIC_FRICTION)
def test_a_static_friction_that_is_not_read_changes_no_bit(law: kernel.Law, case: str) -> None:
    """Nor the steps, which had been measured by it: of a small F_C beside it all was within the tolerance."""
    own, on = OF_STATIC_FRICTION[case]
    shown = []
    for static in (0.1, 10.0, 1e4):
        contact = kernel.Contact({"friction_law": law.name, **own, "F_C": 0.1, "F_S": static, "sigma0": 1e4, "slip_velocity": -0.01}, on)
        contact.start()
        contact.run(np.arange(6) * 2.3e-5, {"slip_velocity": np.linspace(-0.01, 0.02, 6)} if case == "given" else {}, ("friction_force",))
        shown.append([contact.get(v.name) for v in BASE if v.name != "F_S"])
    reads = "F_S" in {known.name for known in law.reads}
    assert reads == any(values != shown[0] for values in shown)


@pytest.mark.parametrize(("kinematics", "loaded"), [("internal", set()), ("external", {"amontons"})])
def test_laws_that_jump_or_ask_for_more_than_a_slip_velocity_are_no_rivals(kinematics: str, loaded: set[str]) -> None:
    """A normal load is there where the kinematics knows the cut."""
    names = {law.name for law in LAWS}
    for law in LAWS:
        rivals = ContactModel().rival_laws({"friction_law": law.name, "kinematics": kinematics})
        by_name = {next(iter(rival.values.values())): rival for rival in rivals}
        assert set(by_name) == names - {law.name, "karnopp", "bristle", "reset_integrator"} - loaded
        for other in LAWS:
            if other.name in by_name:
                assert by_name[other.name].variables == (*(v for v in other.reads if v.causality == "parameter"), *other.variables)
