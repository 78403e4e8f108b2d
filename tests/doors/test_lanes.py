"""Do contacts that run side by side in one block (-DLANES=8) answer as each would alone?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from evat.native import kernel
from evat.native.compile import MANY_LANES
from evat.native.kernel import Contact

Values = Mapping[str, float | str]

LAWS = kernel.variable("friction_law").choices
VARIABLES = kernel.variables()


@pytest.fixture(scope="module")
def library() -> Any:
    """The compiled kernel with many lanes that Python loads on this machine, as it is: ffi, functions."""
    return kernel.library(MANY_LANES)


class Block:
    """Contacts in one block, and each of them alone."""

    def __init__(self, library: Any, sets: Sequence[Values]) -> None:
        self.ffi, self.c = library
        assert self.c.kernel_lanes() == len(sets) == MANY_LANES
        self.block: Any = self.ffi.new("struct Contact *")
        self.alone = [Contact(values) for values in sets]
        self.c.kernel_reset(self.block)
        for lane, values in enumerate(sets):
            self.put(lane, values)
        assert self.c.kernel_start(self.block, 0.0) == 0
        for contact in self.alone:
            contact.start()

    def put(self, lane: int, values: Values) -> None:
        for name, number in kernel.check_values(values).items():
            assert self.c.kernel_set(self.block, kernel.variable(name).index, lane, number) == 0

    def advance(self, step: float) -> None:
        assert self.c.kernel_advance(self.block, step, 0, self.ffi.new("double *")) == 0
        assert self.c.kernel_evaluate(self.block) == 0
        for contact in self.alone:
            contact.advance(step)

    def values(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Variables and indicators, in the block and alone; shape (n, lanes)."""
        indicator = self.ffi.new(f"double[][{MANY_LANES}]", len(kernel.indicators()))
        self.c.kernel_indicators(self.block, indicator)
        both = (np.frombuffer(self.ffi.buffer(kind)).reshape(-1, MANY_LANES) for kind in (self.block.value, indicator))
        yield next(both)[: len(VARIABLES)], np.column_stack([contact.values() for contact in self.alone])
        yield next(both), np.column_stack([contact.indicators() for contact in self.alone])

    def differing(self) -> list[int]:
        """Places of the numbers that are not the same to the last bit."""
        return [int(n) for ours, theirs in self.values() for n in np.flatnonzero((ours != theirs).any(axis=1))]


CASES: dict[str, dict[str, float | str]] = {  # what lanes of a block have in common: laws, effects, sources of motion and heat
    "internal": {"thermal_softening": 1, "relative_tolerance": 1e-6},
    "external": {"kinematics": "external", "thermal_damping": 1, "proxy_source": "contact_temperature", "relative_tolerance": 1e-6},
    "combined": {"kinematics": "combined", "relative_tolerance": 1e-4, "release_time": 1e-5},
    "own angle": {"chip_flow_angle": "current_shear_angle", "relative_tolerance": 1e-3},
    "compliant holder": {"holder_compliance": 1, "relative_tolerance": 1e-5},
    "held stiffly": {"holder_compliance": 1, "sigma1": 3e4, "relative_tolerance": 1e-4},
}
every_law = pytest.mark.parametrize("law", LAWS)
every_case = pytest.mark.parametrize("case", CASES)


def drawn(luck: np.random.Generator, law: str, case: str) -> list[dict[str, float | str]]:
    """Contacts that differ in all that lanes may differ in: the fixed choices are those of the block."""
    common = {
        "shear_angle_principle": str(luck.choice(["maximum_shear_stress", "minimum_energy"])),
        "damping_mode": str(luck.choice(["dissipative", "as_published"])),
    }
    ranges = {"F_C": (3, 12), "F_S": (3, 12), "sigma0": (3e5, 1e7), "cutting_speed": (0.1, 0.5), "contact_temperature": (300, 800)}
    return [
        {
            **CASES[case],
            **{name: float(luck.uniform(*bounds)) for name, bounds in ranges.items()},
            "friction_law": law,
            **common,
            "rake_angle": float(luck.uniform(-0.2, 0.2)),
            "slip_velocity": float(luck.normal(0, 0.3)) if case == "external" else 0.0,
        }
        for lane in range(MANY_LANES)
    ]


@every_law
@every_case
def test_lanes_answer_like_contacts(library: Any, case: str, law: str) -> None:
    """Motion, laws, effects, forces, indicators and events at random times and states: to the last bit."""
    luck = np.random.default_rng([LAWS.index(law), len(case)])
    lanes = Block(library, drawn(luck, law, case))
    assert lanes.differing() == []
    for n in range(20):
        for lane, contact in enumerate(lanes.alone):
            lanes.block.value[0][lane] = contact.time = n * 1.3e-5
            for name in kernel.states():
                value = float(luck.normal(0, kernel.variable(name).nominal))
                lanes.put(lane, {name: value})
                contact.set(name, value)
        for action in ("evaluate", "event"):
            assert getattr(lanes.c, f"kernel_{action}")(lanes.block) == 0
            for contact in lanes.alone:
                getattr(contact, action)()
            assert lanes.differing() == []


@every_law
@every_case
def test_equal_lanes_step_like_one(library: Any, case: str, law: str) -> None:
    """Through entries, exits, reversals, windows and the law's events: to the last bit."""
    lanes = Block(library, [drawn(np.random.default_rng(1), law, case)[1]] * MANY_LANES)
    for step in (1e-7, 1.3e-5, 4e-5, 1.1e-4):
        lanes.advance(step)
        assert lanes.differing() == []


@every_law
@every_case
def test_lanes_step_like_contacts(library: Any, case: str, law: str) -> None:
    """Whatever the neighbours do: other steps, other events, more passes of an iteration. To the last bit."""
    lanes = Block(library, drawn(np.random.default_rng([LAWS.index(law), len(case)]), law, case))
    for step in (1e-7, 1.3e-5, 4e-5, 1.1e-4):
        lanes.advance(step)
        assert lanes.differing() == []


@every_law
@pytest.mark.parametrize("case", [case for case in CASES if case != "external"])
def test_lanes_jump_over_cycles_like_contacts(library: Any, case: str, law: str) -> None:
    """In long steps lanes wait for those that have not settled, whose input rises or whose averaging window ends. To the last bit."""
    sets = drawn(np.random.default_rng([LAWS.index(law), len(case), 1]), law, case)
    sets[3]["averaging_window"] = 7e-4
    lanes = Block(library, sets)
    for count in (31, 24.3):
        for contact, lane in ((lanes.block, 5), (lanes.alone[5]._contact, 0)):
            contact.slope[kernel.variable("cutting_speed").index - lanes.c.INPUT_FIRST][lane] = 0.1
        lanes.advance(count / 20e3)
        assert lanes.differing() == []
