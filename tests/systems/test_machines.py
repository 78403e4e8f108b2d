"""Do the partners of the contact obey mechanics, and is their step as exact as they say?"""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from evat import fmu
from evat.model import ParameterError
from evat.native import machine
from evat.native.compile import host_target
from evat.native.machine import Machine
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

PARTS = machine.names()
VARYING = ("tool_heat",)  # whose response to their states changes with the inputs: linear in the states alone
RIGID_PID = {"rigid": 1.0, "pid": 1.0, "motor_inertia": 0.0, "table_mass": 1.0, "feed_forward": 0.0}


def drawn(part: str, seed: int) -> Machine:
    """Parameters, inputs and states at random, within their bounds."""
    luck, one = np.random.default_rng(seed), Machine(part)
    for v in machine.variables(part):
        if v.causality == "independent" or (v.causality in ("output", "local") and v.name not in machine.states(part)):
            continue
        if v.type != "real":
            one.set(v.name, float(luck.integers(int(v.max) + 1)))
        else:
            size = v.start if v.causality == "parameter" and v.start else v.nominal
            one.set(v.name, float(np.clip(size * luck.uniform(0.3, 2), v.min, v.max)))
    return one


def driven(part: str) -> list[str]:
    return [*(v.name for v in machine.variables(part) if v.causality == "input"), *machine.states(part)]


def rates(one: Machine, at: dict[str, float]) -> np.ndarray:
    for name, value in at.items():
        one.set(name, value)
    one.evaluate()
    return np.array([one.get(next(v.name for v in machine.variables(one.part) if v.derivative_of == s)) for s in machine.states(one.part)])


@pytest.mark.parametrize("part", PARTS)
def test_the_table_is_what_the_shared_code_takes_it_for(part: str) -> None:
    variables = machine.variables(part)
    inputs = [v.index for v in variables if v.causality == "input"]
    assert inputs == list(range(1, len(inputs) + 1))  # model.h: model_input
    assert len({v.name for v in variables}) == len(variables)
    for v in variables:
        assert v.name
        assert v.unit
        assert v.meaning
        assert v.source
        assert v.min <= v.start <= v.max
        assert bool(v.derivative_of) <= (v.causality == "local")
    library = Machine(part)._library
    assert [library.model_state(place) for place in (-1, len(machine.states(part)))] == [-1, -1]  # there is none


@pytest.mark.parametrize("part", PARTS)
def test_rates_are_linear_in_states_and_inputs(part: str) -> None:
    """What the exact step rests on: f(a) + f(b) = f(a + b) + f(0). Of varying parts with the inputs as they stand."""
    luck, one = np.random.default_rng(5), drawn(part, 7)
    size = {v.name: v.nominal for v in machine.variables(part)}
    names = machine.states(part) if part in VARYING else driven(part)
    a, b = ({name: size[name] * luck.uniform(0.1, 1) for name in names} for _ in range(2))
    both, none = {name: a[name] + b[name] for name in a}, dict.fromkeys(a, 0.0)
    left, right = rates(one, a) + rates(one, b), rates(one, both) + rates(one, none)
    assert np.allclose(left, right, rtol=1e-12, atol=1e-12 * np.max(np.abs(left), initial=0))


@pytest.mark.parametrize("part", [part for part in PARTS if machine.states(part)])
def test_one_long_step_is_the_solution(part: str) -> None:
    """Against Radau at 1e-11, with inputs that are linear within the step; and against a thousand short steps of its own. A varying
    part's inputs change by 1.5 %, and its step errs with their square."""
    step, names, inputs = 5e-3, machine.states(part), [v.name for v in machine.variables(part) if v.causality == "input"]
    one = drawn(part, 3)
    slopes = {name: 3.0 * one.get(name) for name in inputs}
    first = {name: one.get(name) for name in (*inputs, *names)}
    start = one.state()
    for name, slope in slopes.items():
        one.slope(name, slope)
    one.start()
    here = one.state()
    one.advance(step)
    long = np.array([one.get(name) for name in names])
    one.restore(here)
    for _ in range(1000):
        one.advance(step / 1000)
    short = np.array([one.get(name) for name in names])
    one.restore(start)

    def right(t: float, x: np.ndarray) -> np.ndarray:
        now = {name: first[name] + slopes[name] * t for name in inputs} | dict(zip(names, map(float, x), strict=True))
        return rates(one, now)

    from_start = np.array([first[name] for name in names])
    exact = solve_ivp(right, (0, step), from_start, method="LSODA", rtol=1e-11, atol=1e-15).y[:, -1]
    scale = np.maximum(np.abs(exact), np.abs(from_start))
    assert np.all(np.abs(long - exact) <= (3e-4 if part in VARYING else 1e-7) * scale)  # LSODA's own error over a stiff screw
    assert np.all(np.abs(long - short) <= (3e-4 if part in VARYING else 1e-10) * scale)


def test_a_structure_without_dampers_keeps_its_energy() -> None:
    one = Machine("tool_structure", {"holder_damping_ratio": 0.0, "slide_damping_ratio": 0.0, "velocity_x": 0.1, "displacement_y": 1e-5})
    one.start()
    first = one.get("stored_energy")
    for step in (1e-3, 1e-6, 3.7e-5):
        for _ in range(5000):
            one.advance(step)
        assert one.get("stored_energy") == pytest.approx(first, rel=1e-10)  # rounding, 15 000 steps


def test_energy_goes_where_the_structure_says() -> None:
    """Stored energy rises by the work of the forces less what the dampers take."""
    one, step = Machine("tool_structure", {"force_x": 80.0, "force_y": -30.0}), 1e-5
    one.start()
    powers, energies = [], []
    for _ in range(2001):
        powers.append(one.get("power_in") - one.get("power_lost"))
        energies.append(one.get("stored_energy"))
        one.advance(step)
    work = step * (np.sum(powers) - 0.5 * (powers[0] + powers[-1]))
    assert energies[-1] - energies[0] == pytest.approx(work, rel=1e-3)  # trapezia of 1.2 kHz in steps of 10 us
    assert energies[-1] > 0


def test_a_static_force_bends_holder_and_slide_in_series() -> None:
    one = Machine("tool_structure", {"force_y": 100.0})
    one.start()
    one.advance(10.0)
    given = {v.name: v.start for v in machine.variables("tool_structure")}
    expected = 100 / given["holder_stiffness_y"] + 100 / given["slide_stiffness_y"]
    assert one.get("displacement_y") == pytest.approx(expected, rel=1e-9)
    assert one.get("displacement_x") == 0


def test_the_spindle_holds_its_speed_under_load() -> None:
    one = Machine("spindle", {"principal_force": 200.0})
    one.start()
    one.advance(0.02)
    assert one.get("cutting_speed") < 0.999 * one.get("speed_set") * one.get("workpiece_radius")
    one.advance(20.0)
    assert one.get("spindle_speed") == pytest.approx(one.get("speed_set"), rel=1e-9)
    assert one.get("motor_torque") == pytest.approx(200 * 0.02 + 0.01 * 25 / 3, rel=1e-9)


def test_heat_settles_at_power_times_resistances() -> None:
    """Of friction alone: the chip takes its part over its resistance, the tool over two in series."""
    one = Machine("tool_heat", {"dissipated_power": 4.0, "cutting_speed": 0.5})
    one.start()
    one.advance(1e4)
    chip, tool = one.get("chip_resistance"), one.get("spot_resistance") + one.get("insert_resistance")
    assert one.get("contact_temperature") - one.get("ambient_temperature") == pytest.approx(4 / (1 / chip + 1 / tool), rel=1e-9)
    assert one.get("bulk_temperature") == one.get("ambient_temperature")


def test_a_pid_with_nothing_but_a_spring_swings_at_its_frequency() -> None:
    one = Machine("feed_drive", {**RIGID_PID, "pid_gain": 2.0, "pid_integral_gain": 0.0, "pid_velocity_gain": 0.0, "table_position": 0.1})
    one.start()
    one.advance(np.pi / np.sqrt(2))
    assert one.get("table_position") == pytest.approx(-0.1, rel=1e-9)
    assert one.get("motor_position") == pytest.approx(-0.2, rel=1e-9)  # it began at 0


def test_both_directions_of_a_structure_are_alike() -> None:
    """What is given along x and read along x is what is given along y and read along y."""
    given = {
        "holder_stiffness": 3e7,
        "slide_mass": 30.0,
        "slide_stiffness": 5e7,
        "force": 80.0,
        "displacement": 1e-6,
        "slide_velocity": 1e-3,
    }
    states = ("displacement", "velocity", "slide_displacement", "slide_velocity")
    rows = []
    for along, across in ("xy", "yx"):
        one = Machine("tool_structure", {f"{name}_{along}": value for name, value in given.items()})
        one.start()
        one.advance(3e-4)
        rows.append(
            [one.get(f"{name}_{along}") for name in states] + [one.get("stored_energy"), one.get("power_in"), one.get("power_lost")]
        )
        assert all(one.get(f"{name}_{across}") == 0 for name in states)
    assert rows[0] == rows[1]
    assert all(rows[0])


@pytest.mark.parametrize("inertia", [2e-3, 1e-6])
def test_a_drive_with_integral_action_gives_way_by_its_screw_alone(inertia: float) -> None:
    """A constant load: the speed control brings the motor back to its reference, with the load's force, and the screw is F/k shorter."""
    one = Machine("feed_drive", {"position_reference": 1e-3, "load_force": 200.0, "motor_inertia": inertia})
    one.start()
    one.advance(1e-3)
    assert one.get("motor_position") < 0.9e-3
    for _ in range(400):
        one.advance(1e-2)
    assert one.get("motor_position") == pytest.approx(1e-3, rel=1e-9)
    assert one.get("motor_force") == pytest.approx(200.0, rel=1e-9)
    assert one.get("motor_torque") == pytest.approx(200.0 * 1e-2 / (2 * np.pi), rel=1e-9)
    assert one.get("table_position") == pytest.approx(1e-3 - 200.0 / 1e8, rel=1e-9)
    assert one.get("stored_energy") == pytest.approx(0.5 * 200.0**2 / 1e8, rel=1e-6)


def test_a_pid_leaves_no_error_under_load() -> None:
    """The integral of the position's error carries the load: k_i times it is the load, whatever the other gains."""
    gains = {"pid_gain": 3.0, "pid_integral_gain": 4.0, "pid_velocity_gain": 6.0}
    one = Machine("feed_drive", {**RIGID_PID, **gains, "position_reference": 1.0, "load_force": 2.0})
    one.start()
    one.advance(300.0)
    assert one.get("table_position") == pytest.approx(1.0, rel=1e-9)
    assert one.get("position_error_integral") == pytest.approx(2.0 / 4.0, rel=1e-9)


def test_a_spot_warms_at_first_as_the_half_ball_under_it() -> None:
    one = Machine("tool_heat", {"dissipated_power": 2.0, "width": 1e-3, "contact_length": 2e-4})
    one.start()
    one.advance(1e-9)
    half_ball = 2 / 3 * np.pi * (2e-7 / np.pi) ** 1.5 * 3e6  # under the circle with the area of the contact
    assert one.get("contact_temperature") - one.get("ambient_temperature") == pytest.approx(2.0 * 1e-9 / half_ball, rel=1e-4)
    both = 1 / (1 / one.get("spot_resistance") + 1 / one.get("chip_resistance"))
    assert one.get("spot_time") == pytest.approx(half_ball * both, rel=1e-12)


def test_a_screw_needs_a_motor_with_inertia() -> None:
    one = Machine("feed_drive", {"rigid": 0.0, "motor_inertia": 0.0})
    with pytest.raises(Exception, match="no longer a finite number"):
        one.start()


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("seed", range(3))
def test_what_a_partner_has_come_to_has_no_flaw_and_what_is_forged_has_one(part: str, seed: int) -> None:
    """A serialised state may bring any bytes: the response over a step, which they carry, must be that of the parameters."""
    one = drawn(part, seed)
    ffi, library = one._ffi, one._library
    machine_of = one._machine
    assert library.model_flaw(machine_of) == ffi.NULL
    one.start()
    one.advance(1e-3)
    assert library.model_flaw(machine_of) == ffi.NULL
    states = 0 if part in VARYING else len(machine.states(part))  # those find their response anew at each step
    forged = [
        ("step", None, -1.0),
        ("step", None, np.inf),
        ("started", None, 2),
        ("warnings", None, 2),
        ("value", 0, np.nan),
        ("slope", 2, np.inf),
    ]
    forged += [("once", 0, 0.3), ("twice", states * states - 1, np.nan)] if states else []
    for field, place, value in forged:
        twin = ffi.new("struct Model *", machine_of[0])
        if place is None:
            setattr(twin, field, value)
        else:
            getattr(twin, field)[place] = value
        assert library.model_flaw(twin) != ffi.NULL, (field, place, value)


def test_the_circle_is_one_and_is_entered_smoothly() -> None:
    one = Machine("path_reference", {"circle": 1.0})
    one.start()
    assert one.get("velocity_x") == one.get("velocity_y") == 0
    for _ in range(50):
        one.advance(0.13)
        x, y, r = one.get("position_x"), one.get("position_y"), one.get("radius")
        assert np.hypot(x, y - r) == pytest.approx(r, rel=1e-12)
        h = 1e-5
        before = one.get("position_x"), one.get("position_y")
        one.advance(h)
        moved = (one.get("position_x") - before[0]) / h, (one.get("position_y") - before[1]) / h
        assert moved == pytest.approx((one.get("velocity_x"), one.get("velocity_y")), abs=1e-6)


def test_a_value_out_of_bounds_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"holder_mass = -1 kg: allowed is 0.001"):
        Machine("tool_structure", {"holder_mass": -1.0})
    with pytest.raises(ParameterError, match="no variable 'mass'"):
        Machine("spindle", {"mass": 1.0})


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("part", PARTS)
def test_the_fmu_is_valid_and_says_what_the_library_says(part: str, version: fmu.Version, tmp_path: Path) -> None:
    path = fmu.build_fmu(version, tmp_path / fmu.file_name(version, part), [host_target().fmi3_folder], part=part)
    assert validate_fmu(str(path)) == []
    about = fmu.fmu_facts_of(part)
    columns, step = list(about.reference_results["columns"]), about.default_experiment["stepSize"]
    one = Machine(part)
    one.start()
    times = np.arange(51) * step
    expected = one.run(times, {}, columns)
    for kind, tolerance in (("CoSimulation", 1e-12), ("ModelExchange", 1e-4)):
        trace = fmpy.simulate_fmu(
            str(path), fmi_type=kind, output=columns, stop_time=times[-1], output_interval=step, relative_tolerance=1e-8
        )
        for place, name in enumerate(columns):
            scale = max(np.max(np.abs(expected[:, place])), 1e-9)
            assert np.allclose(trace[name], expected[:, place], rtol=0, atol=tolerance * scale)


@pytest.mark.parametrize("part", [part for part in PARTS if machine.states(part)])
def test_a_parameter_that_changes_between_steps_acts_at_once(part: str) -> None:
    """The integrals of the step before must not serve for it. One step after the change is two of half the length."""
    tuned = next(v for v in machine.variables(part) if v.causality == "parameter" and v.variability == "tunable" and v.start > 0)
    whole, halves = drawn(part, 5), drawn(part, 5)
    for one in (whole, halves):
        one.start()
        one.advance(1e-3)
        one.set(tuned.name, 0.5 * one.get(tuned.name))
    whole.advance(1e-3)
    halves.advance(5e-4)
    halves.advance(5e-4)
    for state in machine.states(part):
        assert whole.get(state) == pytest.approx(halves.get(state), rel=1e-9, abs=1e-12 * (1 + abs(halves.get(state))))
