"""Does `simulate` give what the laws say for parameters and a motion, with units and provenance, and refuse what is no run?"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from evat.model import EvatError, ParameterError
from evat.models.simulate import SHOWN, simulate, vibration_clock
from evat.native import kernel

SLIDING: Mapping[str, float | str] = {"kinematics": "external", "friction_law": "coulomb", "F_C": 3.0}


def test_a_clock_of_whole_cycles_ends_on_the_cycle() -> None:
    clock = vibration_clock(3, 20e3, 8)
    assert clock.shape == (25,)
    assert (clock[0], clock[-1]) == (0, 3 / 20e3)
    assert clock[8::8] == pytest.approx([1 / 20e3, 2 / 20e3, 3 / 20e3], rel=1e-15)
    assert vibration_clock(0.5, 100.0, 4) == pytest.approx([0, 2.5e-3, 5e-3])


def test_default_is_five_cycles_of_all_that_is_shown_with_units_and_provenance() -> None:
    trace = simulate()
    assert trace.times[-1] == pytest.approx(5 / kernel.variable("vibration_frequency").start)
    assert tuple(trace.columns) == SHOWN
    assert dict(trace.units) == {name: kernel.variable(name).unit for name in SHOWN}
    assert {column.shape for column in trace.columns.values()} == {trace.times.shape} == {(1001,)}
    assert trace.made_by["model"] == kernel.token()
    assert trace.made_by["values"] == {}
    with pytest.raises(ParameterError, match="no column 'friction' in this trace; did you mean friction_force"):
        trace["friction"]


def test_the_clock_follows_the_frequency_that_is_asked_for() -> None:
    trace = simulate({"vibration_frequency": 1e4}, cycles=2, samples_per_cycle=10, outputs=["in_contact"])
    assert trace.times == pytest.approx(np.arange(21) / 1e5)
    assert trace["in_contact"][1:11].tolist() == trace["in_contact"][11:21].tolist()
    assert 0 < trace["in_contact"].mean() < 1


def test_a_given_motion_is_followed_linearly_between_its_samples() -> None:
    """Coulomb friction over a ramp from 2 to -1 m/s through zero at 2/3 of the way: the impulse is F_C (2 - 1) T/3."""
    times, slip = np.array([5.0, 5.3]), np.array([2.0, -1.0])
    outputs = ("friction_impulse", "slip_velocity_used", "friction_force")
    trace = simulate(SLIDING, times=times, inputs={"slip_velocity": slip}, outputs=outputs)
    assert trace["slip_velocity_used"].tolist() == [2.0, -1.0]
    assert trace["friction_force"].tolist() == [3.0, -3.0]
    assert trace["friction_impulse"] == pytest.approx(
        [0, 3.0 * 0.1], abs=2e-7
    )  # reversal to 1e-3 of the tolerance of 1e-4: 2 F_C 0.3 s 1e-7


def test_the_same_run_is_the_same_bytes_and_touches_nothing_that_was_given() -> None:
    values, times, slip = dict(SLIDING), np.linspace(0, 1e-3, 50), np.sin(np.arange(50.0))
    kept = dict(values), times.copy(), slip.copy()
    one, other = (simulate(values, times=times, inputs={"slip_velocity": slip}) for _ in range(2))
    assert all(one[name].tobytes() == other[name].tobytes() for name in SHOWN)
    assert values == kept[0]
    assert times.tobytes() + slip.tobytes() == kept[1].tobytes() + kept[2].tobytes()


def test_an_effect_is_off_unless_it_is_named() -> None:
    """Softened bristles bend on: at theta_ref the stiffness P - k_Q in place of P carries the same deflection."""
    values: dict[str, float | str] = {
        "kinematics": "external",
        "slip_velocity": 0.5,
        "proxy_source": "proxy_speed",
        "proxy_speed": kernel.variable("theta_ref").start,
        "sigma0": 1e6,
        "sigma1": 0.0,
        "sigma2": 0.0,
        "thermal_softening.k_Q": 1e5,
    }
    cold, hot = (simulate(values, on, outputs=["friction_force"])["friction_force"][-1] for on in ((), ("thermal_softening",)))
    assert hot / cold == pytest.approx(0.9, rel=1e-9)


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        ({"cycles": 0}, "cycles = 0"),
        ({"cycles": math.nan}, "cycles = nan"),
        ({"cycles": math.inf}, "cycles = inf"),
        ({"cycles": 1e12}, "at most"),
        ({"samples_per_cycle": 1}, "at least 2"),
        ({"inputs": {"slip_velocity": [1.0]}}, "without sample times"),
        ({"times": []}, "at least one sample"),
        ({"times": 1.0}, "shape"),
        ({"times": [[0.0, 1.0]]}, "shape"),
        ({"times": [0.0, 1.0, 1.0]}, "increasing"),
        ({"times": [0.0, math.nan]}, "finite"),
        ({"times": [math.nan, 1.0]}, "finite"),
        ({"times": [0.0, 1.0], "inputs": {"slip_velocity": [1.0]}}, "slip_velocity has the shape"),
        ({"times": [0.0, 1.0], "inputs": {"slip_velocity": 1.0}}, "slip_velocity has the shape"),
        ({"times": [0.0, 1.0], "inputs": {"slip_velocity": [1.0, math.nan]}}, "slip_velocity, sample 1"),
        ({"times": [0.0, 1.0], "inputs": {"slip_velocity": [math.inf, 1.0]}}, "slip_velocity, sample 0"),
        ({"times": [0.0, 1.0], "inputs": {"F_C": [1.0, 2.0]}}, "F_C is not an input"),
        ({"times": [0.0, 1.0], "inputs": {"../slip": [1.0, 2.0]}}, "no variable '../slip'"),
        ({"outputs": ["friction"]}, "did you mean friction"),
        ({"values": {"F_C": -1.0}}, "allowed is"),
        ({"values": {"friction_law": "stribeck"}}, "coulomb, lugre"),
        ({"effects": ["magic"]}, "no effect 'magic'"),
    ],
)
def test_what_is_no_run_is_refused(asked: dict[str, Any], what: str) -> None:
    run: Callable[..., object] = simulate
    with pytest.raises(EvatError, match=what):
        run(**{"values": SLIDING if "times" in asked else {}, **asked})
