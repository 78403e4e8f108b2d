"""Are outputs that follow inputs at once handed on, through any number of components in any order, and in a loop?"""

from __future__ import annotations

import ctypes
import itertools
from typing import Any

import numpy as np
import pytest
from evat.native.coupling import CoupledFmu, Coupling, NotSettled, Output

Doubles = ctypes.POINTER(ctypes.c_double)
References = ctypes.POINTER(ctypes.c_uint)


class Affine:
    """y = offset + gain u, at once: an FMU of FMI 2, of which the loop asks four functions."""

    def __init__(self, gain: float, offset: float = 0.0) -> None:
        self.u, self.sets = 0.0, 0

        def set_real(_: Any, references: Any, count: int, values: Any) -> int:
            self.u, self.sets = values[0], self.sets + 1
            return 0

        def get_real(_: Any, references: Any, count: int, values: Any) -> int:
            values[0] = offset + gain * self.u
            return 0

        values = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, References, ctypes.c_size_t, Doubles)
        step = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int)
        self.functions = {"fmi2SetReal": values(set_real), "fmi2GetReal": values(get_real), "fmi2DoStep": step(lambda *_: 0)}
        self.fmu = CoupledFmu(2, 0, self._address, [0], [Output(1, "Float64", "fmi2GetReal")], interpolates=False)

    def _address(self, name: str) -> int:
        address = ctypes.cast(self.functions[name], ctypes.c_void_p).value
        assert address is not None
        return address


def follow(parts: list[Affine], sources: list[int], given: float, jacobi: bool = False, **wishes: float) -> tuple[np.ndarray, Coupling]:
    """Ten steps of 0.1 s, over which a record steps from 0 to `given` in the fifth."""
    loop = Coupling([part.fmu for part in parts], [[at] for at in sources], [[n] for n in range(len(parts))], 1, jacobi=jacobi)
    for part in range(len(parts)):
        loop.set(part)
        loop.show(part)
    loop.settle()
    table = np.empty((len(parts), 11))
    loop.run(table, 10, 1, lambda n, m: 0.1 * np.arange(n, m + 1), lambda ends: np.where(ends > 0.45, given, 0.0)[:, None], **wishes)
    return table, loop


@pytest.mark.parametrize("jacobi", [False, True])
@pytest.mark.parametrize("order", list(itertools.permutations(range(4))))
def test_a_chain_hands_on_at_once_whatever_the_order_of_its_components(order: tuple[int, ...], jacobi: bool) -> None:
    """Each link doubles: the last one shows 16 times the record. One pass over them showed 0, then 32, from last to first."""
    places = {link: place for place, link in enumerate(order)}
    sources = [4 if link == 0 else places[link - 1] for link in order]
    table, _ = follow([Affine(2.0) for _ in order], sources, 1.0, jacobi)
    assert table[places[3]].tolist() == [0.0] * 5 + [16.0] * 6


@pytest.mark.parametrize("gain", [0.5, -0.9])
def test_a_loop_that_contracts_settles(gain: float) -> None:
    table, _ = follow([Affine(gain, 1.0), Affine(gain, 1.0)], [1, 0], 0.0)
    assert table == pytest.approx(np.full((2, 11), 1 / (1 - gain)), rel=1e-8)


@pytest.mark.parametrize("gain", [0.5, -0.5])
def test_a_loop_settles_at_0_too(gain: float) -> None:
    """Each pass leaves a quarter of what there was, however little that is: it was said not to settle, at 1e-133."""
    parts = [Affine(gain), Affine(gain)]
    loop = Coupling([part.fmu for part in parts], [[1], [0]], [[0], [1]], 0)
    loop.signals[:] = 1.0
    loop.set(0)
    loop.set(1)
    loop.show(0)
    loop.settle()
    assert loop.signals == pytest.approx(np.zeros(2), abs=1e-9)


@pytest.mark.parametrize("gain", [2.0, -2.0, 1.0])
def test_a_loop_that_does_not_settle_is_said_to_be_one(gain: float) -> None:
    """1.8e11 came from one whose answer is a third, and the run went on."""
    with pytest.raises(NotSettled):
        follow([Affine(gain, 1.0), Affine(gain, 1.0)], [1, 0], 0.0)


def test_what_has_not_moved_is_not_set_again() -> None:
    part = Affine(1.0)
    follow([part], [1], 0.0)
    assert part.sets == 21  # at the start, over each of ten steps, and at its end


def test_means_are_over_all_steps_from_the_middle_on() -> None:
    """0, and 1 from the end of the fifth step on: over the steps that end behind 0.45 s, half of the first and all others."""
    _, loop = follow([Affine(1.0)], [1], 1.0, averaged_from=0.45)
    assert loop.means() == pytest.approx([5.5 / 6])
    assert np.isnan(follow([Affine(1.0)], [1], 1.0)[1].means()).all()


def test_a_step_that_ends_at_the_middle_but_for_roundings_is_not_averaged() -> None:
    """The third ends at 3 * 0.1 s, which is 4e-17 s more than 0.3 s: it was averaged, too."""
    _, loop = follow([Affine(1.0)], [1], 1.0, averaged_from=0.3)
    assert loop.means() == pytest.approx([5.5 / 7])
