"""Do the partners of the contact tell how outputs change with time, inputs and states, and has each of their warnings a text?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.native import machine
from evat.native.machine import Machine
from test_machines import PARTS, VARYING, drawn, driven


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize(("seed", "pace"), [(1, 0.5), (2, 0.5), (3, 3e3)])
def test_outputs_change_with_time_as_they_do_over_a_step(part: str, seed: int, pace: float) -> None:
    """Inputs move by `pace` times their value a second. Against a one-sided difference of fourth order over the exact steps; of
    varying parts, too, whose steps are exact to second order. The model itself stays where it is."""
    one, outputs = drawn(part, seed), [v for v in machine.variables(part) if v.causality in ("output", "local")]
    for v in machine.variables(part):
        if v.causality == "input":
            one.slope(v.name, (-1) ** v.index * pace * one.get(v.name))
        elif v.name in machine.states(part):
            one.set(v.name, (-1) ** v.index * one.get(v.name))
    one.start(0.3)
    here, room = one.state(), one._ffi.new("struct Model *")
    told = one._ffi.new("double[]", len(outputs))
    assert one._library.model_time_derivatives(one._machine, room, len(outputs), [v.index for v in outputs], told) == 0
    assert one.state() == here
    h, rows = 1e-6, []
    for steps in range(5):
        one.restore(here)
        if steps:
            one.advance(steps * h)
        rows.append([one.get(v.name) for v in outputs])
    weights = np.array([-25, 48, -36, 16, -3]) / 12
    expected, size = weights @ np.array(rows) / h, np.abs(rows[0])
    for place, v in enumerate(outputs):
        rounding = 1e-14 * max(size[place], v.nominal or 1.0) / h
        assert told[place] == pytest.approx(expected[place], rel=1e-3, abs=rounding + 1e-5 * max(size[place], v.nominal or 1.0)), v.name


@pytest.mark.parametrize("part", PARTS)
def test_outputs_change_with_inputs_and_states_as_they_do_between_two_values(part: str) -> None:
    """Varying parts are not of second order in all; their difference errs with the square of its step, 1e-3 of the value."""
    one = drawn(part, 4)
    one.start(0.2)
    outputs = [v for v in machine.variables(part) if v.causality in ("output", "local") and v.name not in machine.states(part)]
    indices, told = [v.index for v in outputs], one._ffi.new("double[]", len(outputs))
    for known in (v for v in machine.variables(part) if v.name in driven(part)):
        here = one.state()
        assert one._library.model_derivatives(one._machine, known.index, len(outputs), indices, told) == 0
        assert one.state() == here
        rows, h = [], 1e-4 * max(abs(one.get(known.name)), known.nominal or 1.0)
        for value in (one.get(known.name) - h, one.get(known.name) + h):
            one._library.model_lead(one._machine, known.index, value)
            one.evaluate()
            rows.append(np.array([one.get(v.name) for v in outputs]))
        one.restore(here)
        expected, size = (rows[1] - rows[0]) / (2 * h), np.maximum(np.abs(rows[0]), 1e-12)
        for place, v in enumerate(outputs):
            assert told[place] == pytest.approx(expected[place], rel=1e-4 if part in VARYING else 1e-6, abs=1e-10 * size[place] / h), v.name


@pytest.mark.parametrize("speed", [0.005, 0.02, 0.2, 2.0])
def test_heat_goes_by_a_power_of_a_speed_far_below_its_nominal(speed: float) -> None:
    """The difference was one over a hundredth of a metre per second, whatever the speed: 3.3 times the slope at 5 mm/s."""
    one = Machine("tool_heat", {"cutting_speed": speed, "shear_power": 10.0, "dissipated_power": 3.0})
    one.start(0.0)
    outputs = [v for v in machine.variables("tool_heat") if v.name in ("bulk_temperature", "work_share", "flash_temperature")]
    known = next(v.index for v in machine.variables("tool_heat") if v.name == "cutting_speed")
    told = one._ffi.new("double[]", len(outputs))
    assert one._library.model_derivatives(one._machine, known, len(outputs), [v.index for v in outputs], told) == 0
    rows, h = [], 1e-4 * speed
    for value in (speed - h, speed + h):
        one._library.model_lead(one._machine, known, value)
        one.evaluate()
        rows.append(np.array([one.get(v.name) for v in outputs]))
    assert list(told) == pytest.approx((rows[1] - rows[0]) / (2 * h), rel=1e-6)


@pytest.mark.parametrize("part", PARTS)
def test_every_warning_that_there_is_has_a_text(part: str) -> None:
    one = Machine(part)
    text = one._ffi.new("char[512]")
    said = []
    for bit in range(one._library.model_warning_count() + 1):
        one._library.model_explain_warning(one._machine, bit, text, 512)
        said.append(one._ffi.string(text).decode())
    assert said[-1] == "unknown warning"
    assert "unknown warning" not in said[:-1]
    assert said[:-1]


def test_a_fast_path_is_differenced_over_a_part_of_its_turn() -> None:
    """1600 turns a second: velocities change by speed^2/radius, in the direction that the angle tells."""
    one = Machine("path_reference", {"circle": 1.0, "speed": 10.0, "radius": 1e-3, "run_up_time": 0.01})
    one.start(0.7)
    names = ("position_x", "position_y", "velocity_x", "velocity_y")
    indices = [next(v.index for v in machine.variables("path_reference") if v.name == name) for name in names]
    told, room = one._ffi.new("double[]", 4), one._ffi.new("struct Model *")
    assert one._library.model_time_derivatives(one._machine, room, 4, indices, told) == 0
    x, y, v_x, v_y = (one.get(name) for name in names)
    turns = 1e4  # speed/radius; the run-up is over
    assert list(told) == pytest.approx([v_x, v_y, -(turns**2) * x, -(turns**2) * (y - 1e-3)], rel=1e-5, abs=1e-5 * 10 * turns)
    assert list(told)[:2] == pytest.approx([v_x, v_y], abs=1e-6)
