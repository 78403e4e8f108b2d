"""How are FMUs stepped together without Python in between? The compiled loop of fmu_src/coupling, over the addresses of their functions."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import cffi
import numpy as np

from evat.model import FloatArray
from evat.native.compile import coupling_library_path, source_root
from evat.native.kernel import cffi_text, declarations, open_library

AT_ONCE = 0.05  # s between two looks at what else there is to do: progress, Ctrl-C
MOST_AT_ONCE = 65_536  # steps
FORMS = ("Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean")  # as FMI 3 names them


@functools.cache
def _loaded() -> tuple[Any, Any]:
    ffi = cffi.FFI()
    ffi.cdef(declarations([source_root() / "coupling" / "coupling.h"]))
    return ffi, open_library(ffi, coupling_library_path())


class CallFailed(Exception):
    """A function of an FMU has answered worse than with a warning: which member's, its name, and its status.

    asks_to_end: it went well, and asks that the simulation ends.
    """

    def __init__(self, member: int, function: str, status: int, asks_to_end: bool = False) -> None:
        super().__init__(f"{function}: {status}")
        self.member, self.function, self.status, self.asks_to_end = member, function, status, asks_to_end


class NotFinite(Exception):
    """An output is no finite number: which member's, which of its outputs, and what it is."""

    def __init__(self, member: int, output: int, value: float) -> None:
        super().__init__(f"{output}: {value}")
        self.member, self.output, self.value = member, output, value


class NotSettled(Exception):
    """Outputs that follow inputs at once form a loop in which they do not settle: by its place a signal of it, and what that is."""

    def __init__(self, signal: int, value: float) -> None:
        super().__init__(f"{signal}: {value}")
        self.signal, self.value = signal, value


@dataclass(frozen=True)
class Output:
    """An output by value reference, the form in which its FMU keeps it (one of FORMS) and the function that reads it."""

    reference: int
    form: str
    function: str


@dataclass(frozen=True)
class CoupledFmu:
    """An FMU instance: its version of FMI (2 or 3), the addresses of itself and, by name, of its functions; references of the inputs that
    it is given, and the outputs that it shows. interpolates: it takes rates of its inputs."""

    fmi: int
    instance: int
    address: Callable[[str], int]
    inputs: Sequence[int]
    outputs: Sequence[Output]
    interpolates: bool


@dataclass(frozen=True)
class Ends:
    """Of a bond: its force and its velocity by their places among the signals, and which members show them; whether the force acts against
    the motion."""

    force: int
    velocity: int
    force_side: int
    velocity_side: int
    against: bool = False


class Coupling:
    """Members and the signals between them: first all that they show, then what a record gives.

    Parameters
    ----------
    members : those that are stepped, in this order.
    sources : for each member the places of its inputs among the signals.
    places : for each member the places of its outputs.
    given : how many signals come from a record.
    jacobi : all members move from the same values; else one after the other.
    continued : inputs whose source has not moved yet go on along their last slope; else as constants.
    """

    def __init__(
        self,
        members: Sequence[CoupledFmu],
        sources: Sequence[Sequence[int]],
        places: Sequence[Sequence[int]],
        given: int,
        *,
        bonds: Sequence[Ends] = (),
        jacobi: bool = False,
        continued: bool = True,
    ) -> None:
        self._ffi, self._library = _loaded()
        self._places = [list(place) for place in places]
        self._kept: list[Any] = []  # cffi frees what nobody holds
        self._c = c = self._ffi.new("struct Coupling *")
        c.member_count, c.bond_count, c.jacobi, c.continued = len(members), len(bonds), jacobi, continued
        c.shown_count = sum(map(len, places))
        c.signal_count = c.shown_count + given
        c.signals, c.rates, c.guess, c.then, c.integrals = (self._new("double[]", max(1, c.signal_count)) for _ in range(5))
        c.buffer = self._new("uint64_t[]", max([1, *map(len, places)]))
        c.members = self._new("struct Member[]", len(members))
        for kept, member, source, place in zip(c.members[0 : len(members)], members, sources, places, strict=True):
            self._fill(kept, member, source, place)
        c.bonds = self._new("struct Bond[]", len(bonds))
        for kept, bond in zip(c.bonds[0 : len(bonds)], bonds, strict=True):
            kept.force, kept.velocity = bond.force, bond.velocity
            kept.force_side, kept.velocity_side, kept.against = bond.force_side, bond.velocity_side, bond.against
            kept.velocity_input, kept.force_input = (
                list(sources[side]).index(seen) if seen in sources[side] else -1
                for side, seen in ((bond.force_side, bond.velocity), (bond.velocity_side, bond.force))
            )
        self.signals: FloatArray = np.frombuffer(self._ffi.buffer(c.signals, 8 * c.signal_count), dtype=np.float64)

    def _new(self, kind: str, of: Any) -> Any:
        self._kept.append(self._ffi.new(kind, of))
        return self._kept[-1]

    def _function(self, at: Any, member: CoupledFmu, name: str) -> None:
        at.address = self._ffi.cast("void (*)(void)", member.address(name))
        at.name = self._new("char[]", name.encode())

    def _fill(self, kept: Any, member: CoupledFmu, sources: Sequence[int], places: Sequence[int]) -> None:
        count, fmi = len(member.inputs), member.fmi
        kept.fmi, kept.slopes, kept.input_count = fmi, member.interpolates, count
        kept.instance = self._ffi.cast("void *", member.instance)
        self._function(kept.do_step, member, f"fmi{fmi}DoStep")
        if count:
            self._function(kept.set_inputs, member, "fmi2SetReal" if fmi == 2 else "fmi3SetFloat64")
        if count and member.interpolates:
            self._function(kept.set_slopes, member, "fmi2SetRealInputDerivatives")
        kept.inputs, kept.sources = self._new("uint32_t[]", list(member.inputs)), self._new("int[]", list(sources))
        kept.orders = self._new("int[]", [1] * count)
        kept.held, kept.ahead, kept.told, kept.largest = (self._new("double[]", max(1, count)) for _ in range(4))
        calls: dict[tuple[str, str], list[tuple[int, int]]] = {}
        for output, place in zip(member.outputs, places, strict=True):
            calls.setdefault((output.function, output.form), []).append((output.reference, place))
        kept.call_count, kept.outputs = len(calls), self._new("struct Outputs[]", len(calls))
        for at, ((function, form), read) in zip(kept.outputs[0 : len(calls)], calls.items(), strict=True):
            self._function(at.get, member, function)
            at.form, at.count = FORMS.index(form), len(read)
            at.references = self._new("uint32_t[]", [reference for reference, _ in read])
            at.places = self._new("int[]", [place for _, place in read])

    def set(self, member: int) -> None:
        """Hand a member its inputs from the signals."""
        self._done(self._library.coupling_set(self._c, member))

    def show(self, member: int) -> None:
        """Read what a member shows into the signals."""
        self._done(self._library.coupling_show(self._c, member))

    def settle(self) -> None:
        """Hand on what members show until no input moves."""
        self._done(self._library.coupling_settle(self._c))

    @property
    def steps(self) -> int:
        """Steps that are done."""
        return int(self._c.done)

    @property
    def kept(self) -> int:
        """Columns of the table that are filled."""
        return int(self._c.kept)

    def run(
        self,
        table: FloatArray,
        count: int,
        every: int,
        times: Callable[[int, int], FloatArray],
        given: Callable[[FloatArray], FloatArray],
        progress: Callable[[float], None] | None = None,
        averaged_from: float = math.inf,
    ) -> None:
        """So many steps from the signals as they stand, which go to the table: at the start, at every so many steps, and at the end.

        Python has its turn every AT_ONCE seconds; what it raises then, such as KeyboardInterrupt, ends the run with `steps` done.

        Parameters
        ----------
        table : of shape (signals that members show, 1 + steps that are kept).
        times : what step the n-th to the m-th end at [s], both counted; the 0-th is the start.
        given : what a record gives at such times, of shape (times, signals of the record).
        averaged_from : `means` are over the steps that end behind this time [s].

        Raises
        ------
        CallFailed, NotFinite, NotSettled
            Where a member, or the system, cannot go on.
        """
        c, at_once = self._c, 1
        table[:, 0] = self.signals[: c.shown_count]
        c.count, c.every, c.rows, c.kept, c.averaged_from = count, every, table.shape[1], 1, averaged_from
        c.table = held = self._ffi.from_buffer("double[]", table, require_writable=True)
        self._kept.append(held)
        while self.steps < count:
            number = min(at_once, count - self.steps)
            ends = np.ascontiguousarray(times(self.steps, self.steps + number), dtype=np.float64)
            rows = np.ascontiguousarray(given(ends[1:]), dtype=np.float64)
            began = time.perf_counter()
            self._done(self._library.coupling_steps(c, number, self._view(ends), self._view(rows)))
            took = time.perf_counter() - began
            at_once = max(1, min(MOST_AT_ONCE, int(number * min(8.0, AT_ONCE / max(took, 1e-9)))))
            if progress is not None:
                progress(self.steps / count)

    def _view(self, array: FloatArray) -> Any:
        return self._ffi.from_buffer("double[]", array)

    def means(self) -> FloatArray:
        """Of what members show, over the steps that were to be averaged, kept or not; nan where there was none."""
        c = self._c
        integrals = np.frombuffer(self._ffi.buffer(c.integrals, 8 * c.shown_count), dtype=np.float64)
        return integrals / c.averaged if c.averaged > 0 else np.full(c.shown_count, np.nan)

    def powers(self) -> list[tuple[float, float, float]]:
        """For each bond: energy that passed [J], energy that the coupling made [J], and the sum of what each step made or lost [J]."""
        return [(bond.passed, bond.made, bond.moved) for bond in self._c.bonds[0 : self._c.bond_count]]

    def _done(self, went_well: int) -> None:
        if went_well:
            return
        c = self._c
        if c.status == self._library.NOT_SETTLED:
            raise NotSettled(c.place, float(self.signals[c.place]))
        if c.status == 0:
            raise NotFinite(c.failed, self._places[c.failed].index(c.place), c.shown)
        raise CallFailed(c.failed, cffi_text(self._ffi, c.function), c.status, c.status == self._library.ASKS_TO_END)
