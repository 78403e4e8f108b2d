"""Do all doors give one answer? The kernel through Python, FMI 2 and FMI 3: the same to the last bit, on one platform."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate
from pathlib import Path

import numpy as np
import pytest
from evat.native import kernel
from raw_fmi import OK, WARNING, Door, Instance
from two_doors import Values, differing, in_fmi, of_fmu, of_kernel

Course = Sequence[tuple[float, Mapping[str, float]]]  # communication steps [s], and the inputs set before each
Make = Callable[..., Instance]

PERIOD = 5e-5  # [s], of the vibration at its start value
LAWS = kernel.variable("friction_law").choices
BOTH = ("thermal_softening", "thermal_damping")

# Beside the law: kinematics, principle, what there is to switch; no two alike.
CASES: dict[str, tuple[dict[str, float | str], tuple[str, ...]]] = {
    "internal": ({}, ()),
    "internal, hot": ({"shear_angle_principle": "minimum_energy", "rake_angle": 0.1, "release_time": 1e-5}, BOTH),
    "internal, own angle": ({"chip_flow_angle": "current_shear_angle", "relative_tolerance": 1e-3, "cutting_speed": 0.4}, ()),
    "internal, periodic": ({"initial_state": "periodic", "release_time": 3e-5, "amplitude_y": 3e-6, "phase_y": 2.0}, BOTH[:1]),
    "external": ({"kinematics": "external", "averaging_window": 4e-5, "proxy_source": "contact_temperature"}, BOTH),
    "external, stiff": ({"kinematics": "external", "sigma0": 1e9, "damping_mode": "as_published", "rate_stiffness": "thermal"}, BOTH[1:]),
    "external, steady": (
        {"kinematics": "external", "initial_state": "steady", "slip_velocity": 0.2, "proxy_source": "proxy_speed", "proxy_speed": 0.5},
        ("thermal_softening", "proxy_lag", "rate_and_state", "backlash", "sensor_lowpass", "dynamometer_resonance"),
    ),
    "combined": ({"kinematics": "combined", "proxy_source": "proxy_speed", "relative_tolerance": 1e-6}, BOTH),
    "combined, slow": ({"kinematics": "combined", "vibration_frequency": 900.0, "proxy_source": "cutting_speed"}, BOTH[1:]),
}
every_law = pytest.mark.parametrize("law", LAWS)
every_case = pytest.mark.parametrize("case", CASES)


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI2", "FMI3"])
def door(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Door:
    fmu: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return Door(fmu, tmp_path_factory.mktemp("door"))


def motion(luck: np.random.Generator) -> dict[str, float]:
    """New inputs: slip of both signs, a chip that comes and goes, a machine that shakes."""
    return {
        "slip_velocity": float(luck.normal(0, 0.3)),
        "proxy_speed": float(luck.uniform(0, 2)),
        "contact_temperature": float(luck.uniform(280, 900)),
        "uncut_thickness": float(luck.uniform(-2e-5, 1e-4)),
        "normal_load": float(luck.uniform(0, 30)),
        "cutting_speed": float(luck.uniform(0, 0.5)),
        "applied_force": float(luck.normal(0, 10)),
        "tool_displacement_x": float(luck.normal(0, 1e-6)),
        "tool_displacement_y": float(luck.normal(0, 1e-6)),
        "tool_velocity_x": float(luck.normal(0, 0.05)),
        "tool_velocity_y": float(luck.normal(0, 0.05)),
    }


def unexplained(tolerance: float) -> float:
    """The change that one step may leave unexplained: the kernel's own rule. Where the motion is smooth its error is far smaller."""
    return float((10 * tolerance) ** 0.6)


def tuning(luck: np.random.Generator) -> dict[str, float]:
    """Parameters that may change during a run: friction that rises and falls, another feed and width, another path and other angles,
    from which the FMUs find once what the kernel finds before each step."""
    return {
        "amplitude_x": float(luck.uniform(3e-6, 8e-6)),
        "rake_angle": float(luck.uniform(-0.1, 0.2)),
        "chip_flow_shear_angle": float(luck.uniform(0.3, 0.7)),
        "F_C": float(luck.uniform(3, 12)),
        "F_S": float(luck.uniform(3, 12)),
        "feed": float(luck.uniform(5e-6, 1e-4)),
        "width": float(luck.uniform(5e-4, 2e-3)),
    }


def course_of(seed: Sequence[int], count: int) -> Course:
    """Communication steps from 0.1 us to more than a vibration cycle; inputs change before each, parameters before every fourth."""
    luck = np.random.default_rng(seed)
    return [(float(10 ** luck.uniform(-7, -4.2)), motion(luck) | (tuning(luck) if n % 4 == 3 else {})) for n in range(count)]


def put(contact: kernel.Contact, values: Mapping[str, float]) -> None:
    for name, value in values.items():
        contact.set(name, value)


def through_kernel(contact: kernel.Contact, course: Course) -> np.ndarray:
    """All variables after each step."""
    rows = []
    for step, inputs in course:
        put(contact, inputs)
        contact.advance(step)
        rows.append(of_kernel(contact))
    return np.array(rows)


def through_fmu(one: Instance, course: Course) -> np.ndarray:
    """All variables after each step."""
    rows, (time,) = [], one.get("time")
    for step, inputs in course:
        assert one.set(inputs) == OK
        assert one.step(time, step) <= WARNING, one.lines
        rows.append(of_fmu(one))
        time += step
    return np.array(rows)


def started(values: Values, effects: Sequence[str]) -> kernel.Contact:
    contact = kernel.Contact(values, effects)
    contact.start()
    return contact


@every_law
@every_case
def test_kernel_and_fmu_step_alike(make: Make, case: str, law: str) -> None:
    """Every variable at the start and after every step."""
    values, effects = {**CASES[case][0], "friction_law": law}, CASES[case][1]
    course = course_of([LAWS.index(law), len(case)], 40)
    contact, one = started(values, effects), make().start(in_fmi(values, effects))
    assert not differing(of_kernel(contact), of_fmu(one))
    ours, theirs = through_kernel(contact, course), through_fmu(one, course)
    assert not differing(ours, theirs)
    assert np.ptp(ours, axis=0).astype(bool).sum() > 20  # it was no course of standstill


@pytest.mark.parametrize("kinematics", kernel.variable("kinematics").choices)
@pytest.mark.parametrize("effect", [effect.name for effect in kernel.effects()])
def test_every_effect_is_the_same_through_every_door(make: Make, effect: str, kinematics: str) -> None:
    """With its switch set in the FMU, its parameters where they start; its states among what is compared."""
    values: dict[str, float | str] = {"kinematics": kinematics, "sigma1": 5.0}
    course = course_of([len(effect), len(kinematics)], 15)
    contact, one = started(values, (effect,)), make().start(in_fmi(values, (effect,)))
    assert not differing(of_kernel(contact), of_fmu(one))
    assert not differing(through_kernel(contact, course), through_fmu(one, course))


@every_law
@every_case
def test_a_step_goes_on_from_where_the_last_one_has_ended(make: Make, case: str, law: str) -> None:
    """Inputs stand still for a few steps: an FMU then begins at the point that it has reached, the kernel finds it anew. A flip: the place
    in the cycle at the end of a step is that which its own clock shows, not that of the next one."""
    values, effects = {**CASES[case][0], "friction_law": law}, CASES[case][1]
    course = [(step, inputs if n % 5 == 0 else {}) for n, (step, inputs) in enumerate(course_of([LAWS.index(law), len(case), 5], 40))]
    assert not differing(through_kernel(started(values, effects), course), through_fmu(make().start(in_fmi(values, effects)), course))


@every_law
@every_case
def test_to_look_is_not_to_touch(make: Make, case: str, law: str) -> None:
    """Outputs read before and after every step, or once at the end: one run, also where inputs and parameters jump."""
    values, effects = {**CASES[case][0], "friction_law": law}, CASES[case][1]
    looking, blind = (make().start(in_fmi(values, effects)) for _ in range(2))
    time = 0.0
    for step, inputs in course_of([LAWS.index(law), len(case), 1], 40):
        for one in (looking, blind):
            assert one.set(inputs) == OK
            if one is looking:
                of_fmu(one)
            assert one.step(time, step) <= WARNING, one.lines
            if one is looking:
                of_fmu(one)
        time += step
    assert not differing(of_fmu(looking), of_fmu(blind))


@every_law
@every_case
def test_kernel_and_fmu_answer_a_solver_alike(make: Make, case: str, law: str) -> None:
    """Model exchange: rates, outputs and indicators at any time, state and input, before and after an event there."""
    values, effects = {**CASES[case][0], "friction_law": law}, CASES[case][1]
    contact, one = started(values, effects), make(model_exchange=True).start(in_fmi(values, effects))
    contact.event()
    assert one.update()[0] <= WARNING
    luck = np.random.default_rng([LAWS.index(law), len(case), 2])
    scale = [kernel.variable(name).nominal for name in kernel.states()]
    for _ in range(25):
        time, inputs = contact.time + float(luck.exponential(PERIOD / 5)), motion(luck)
        states = [float(x) for x in luck.normal(0, scale)]
        assert one.call("EnterContinuousTimeMode") == OK
        assert one.call("SetTime", time) == OK
        assert one.call("SetContinuousStates", (ct.c_double * len(states))(*states), ct.c_size_t(len(states))) == OK
        assert one.set(inputs) == OK
        contact.time = time
        put(contact, {**inputs, **dict(zip(kernel.states(), states, strict=True))})
        contact.evaluate()
        assert not differing(of_kernel(contact), of_fmu(one))
        indicators = (ct.c_double * len(kernel.indicators()))()
        assert one.call("GetEventIndicators", indicators, ct.c_size_t(len(indicators))) == OK
        assert list(indicators) == list(contact.indicators())
        assert one.call("EnterEventMode") == OK
        contact.event()
        assert one.update()[0] <= WARNING
        assert not differing(of_kernel(contact), of_fmu(one))


@every_law
@pytest.mark.parametrize("case", ["internal", "internal, hot", "internal, own angle", "internal, periodic", "combined"])
def test_kernel_and_event_mode_stop_alike(fmi3_fmu: Path, tmp_path: Path, case: str, law: str) -> None:
    """FMI 3 with early return hands over the same events, at the same moments, as the kernel that stops at them."""
    values, effects = {**CASES[case][0], "friction_law": law}, CASES[case][1]
    contact, one = started(values, effects), Instance(Door(fmi3_fmu, tmp_path), event_mode=True, early_return=True)
    one.start(in_fmi(values, effects))
    contact.event()
    one.update()
    assert one.call("EnterStepMode") == OK
    events = 0
    for step in (0.7 * PERIOD, 1.9 * PERIOD):
        end = contact.time + step
        while (left := end - contact.time) > 1e-12 * step:
            began = contact.time
            went = contact.advance(left, stop_at_events=True)
            status, event, early, last = one.step3(began, left)
            assert (status, event, early, last) == (OK, went < left, went < left, contact.time), one.lines
            assert not differing(of_kernel(contact), of_fmu(one))
            if event:
                contact.event()
                assert one.call("EnterEventMode") == OK
                assert one.update()[0] <= WARNING
                assert one.call("EnterStepMode") == OK
                assert not differing(of_kernel(contact), of_fmu(one))
                events += 1
    one.free()
    assert 4 <= events < 300  # two and a half cycles have at least so many entries and exits


@every_law
@pytest.mark.parametrize("case", ["internal, hot", "internal, own angle", "external", "combined"])
def test_a_run_taken_up_in_mid_cycle_goes_on_to_the_last_bit(make: Make, case: str, law: str) -> None:
    """Saved and restored, written and read, carried into another instance: what follows is the kernel's uninterrupted run."""
    values, effects = {**CASES[case][0], "friction_law": law}, CASES[case][1]
    course = course_of([LAWS.index(law), len(case), 3], 30)
    whole = through_kernel(started(values, effects), course)
    one, other = make().start(in_fmi(values, effects)), make()
    for cut in (7, 19):
        first = through_fmu(one, course[:cut]) if cut == 7 else through_fmu(one, course[7:cut])
        assert not differing(first, whole[:cut] if cut == 7 else whole[7:cut])
        state, data = one.save(), one.serialize()
        assert not differing(through_fmu(one, course[cut:]), whole[cut:])
        assert one.restore(state) == OK
        assert not differing(through_fmu(one, course[cut:]), whole[cut:])
        assert other.deserialize(data) == OK, other.lines
        assert not differing(through_fmu(other, course[cut:]), whole[cut:])
        assert one.restore(state) == OK
        assert one.drop(state) == OK


SPLITS: dict[str, list[float]] = {
    "20 cycles at once": [1e-3],
    "uneven": [float(step) for step in np.random.default_rng(57).dirichlet(np.full(57, 0.5)) * 1e-3],
    "0.1 us each": [1e-7] * 10_000,
}


@pytest.mark.parametrize("split", SPLITS)
@pytest.mark.parametrize(("law", "tolerance"), [("lugre", 1e-4), ("lugre", 1e-7), ("dahl", 1e-5), ("reset_integrator", 1e-5)])
def test_how_a_communication_step_is_split_does_not_matter(make: Make, split: str, law: str, tolerance: float) -> None:
    """1 ms of vibration in 1, 57 or 10 000 communication steps, each held against the kernel at its tightest tolerance."""
    values: dict[str, float | str] = {"friction_law": law, "cutting_speed": 0.2, "release_time": 1e-5, "relative_tolerance": tolerance}
    exact = started({**values, "relative_tolerance": 1e-12}, ())
    exact.advance(1e-3)
    one = make().start(in_fmi(values))
    steps = SPLITS[split]
    for time, step in zip(accumulate(steps, initial=0.0), steps, strict=False):
        assert one.step(time, step) <= WARNING, one.lines
    assert one.get("time")[0] == pytest.approx(1e-3, rel=1e-12)
    means = ("mean_friction_force", "mean_principal_force", "mean_feed_force", "mean_normal_force", "mean_contact_ratio")
    names = (*means, "contact_time", "dissipated_energy", "friction_impulse", "bristle_deflection")
    assert one.get(*names) == pytest.approx([exact.get(name) for name in names], rel=0.3 * unexplained(tolerance))
