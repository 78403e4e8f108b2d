"""Does a result hang on what memory held before? Steps of the kernel on a stack that was filled with one number, and with others."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from evat.native import kernel
from evat.native.compile import compile_library, host_target
from test_same_bits import CASES, LAWS, Values, course_of, put, started
from two_doors import differing, of_kernel

Fill = Callable[[float], None]
SOURCE = """#pragma GCC visibility push(default)
void fill(double number)
{
    volatile double room[20000]; /* deeper than a step goes */
    for (int i = 0; i < 20000; ++i)
        room[i] = number;
}
"""
NUMBERS = (0.0, 1e30, -1e30, 0.5)


@pytest.fixture(scope="module")
def fill(tmp_path_factory: pytest.TempPathFactory) -> Fill:
    """Leaves the number below the stack of whoever calls it."""
    folder, target = tmp_path_factory.mktemp("fill"), host_target()
    source = folder / "fill.c"
    source.write_text(SOURCE)
    function = ct.CDLL(str(compile_library([source], folder / f"fill{target.extension}", target))).fill
    function.argtypes, function.restype = [ct.c_double], None
    return function  # type: ignore[no-any-return]


def courses(fill: Fill, values: Values, effects: Sequence[str], seed: Sequence[int], count: int) -> list[np.ndarray]:
    """All variables after each step, once for each number."""
    made = []
    for number in NUMBERS:
        fill(number)
        contact, rows = started(values, effects), []
        for step, inputs in course_of(seed, count):
            put(contact, inputs)
            fill(number)
            contact.advance(step)
            fill(number)
            contact.evaluate()
            rows.append(of_kernel(contact))
        made.append(np.array(rows))
    return made


@pytest.mark.parametrize("kinematics", kernel.variable("kinematics").choices)
@pytest.mark.parametrize("effect", [effect.name for effect in kernel.effects()])
def test_of_no_effect(fill: Fill, effect: str, kinematics: str) -> None:
    """The courses of test_same_bits.py."""
    values: dict[str, float | str] = {"kinematics": kinematics, "sigma1": 5.0}
    one, *others = courses(fill, values, (effect,), [len(effect), len(kinematics)], 15)
    assert [differing(one, other) for other in others] == [[]] * len(others)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("case", CASES)
def test_of_no_law(fill: Fill, case: str, law: str) -> None:
    one, *others = courses(fill, {**CASES[case][0], "friction_law": law}, CASES[case][1], [LAWS.index(law), len(case)], 40)
    assert [differing(one, other) for other in others] == [[]] * len(others)


def test_of_no_step_of_roundings(fill: Fill) -> None:
    """Where the slip is solved for, the step across a jump that is recalled goes straight on, also out of contact, where nothing slides."""
    values: dict[str, float | str] = {"kinematics": "internal", "chip_flow_angle": "current_shear_angle"}
    one, *others = courses(fill, values, ("sensor_delay",), [1], 40)
    assert [differing(one, other) for other in others] == [[]] * len(others)
