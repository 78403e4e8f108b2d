"""What do the compiled partners of the contact know, and how is one run from Python? Tool structure, spindle, heat, feed drive, path."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import cffi
import numpy as np

from evat.model import FloatArray, ParameterError, SimulationError, Variable
from evat.native.compile import machine_library_path, machine_names, source_root
from evat.native.kernel import cffi_text, check_column, declarations, open_library, read_table


@functools.cache
def names() -> tuple[str, ...]:
    """The partners that there are."""
    return machine_names(source_root())


@functools.cache
def _loaded(part: str) -> tuple[Any, Any]:
    ffi = cffi.FFI()
    headers = (source_root() / name for name in ("kernel/tables.h", "fmi/model.h", "machines/machine.h"))
    ffi.cdef(declarations(headers).replace("extern const struct Part part;", ""))
    return ffi, open_library(ffi, machine_library_path(part))


@functools.cache
def variables(part: str) -> tuple[Variable, ...]:
    """Every quantity of a partner, in the order of its value references."""
    ffi, library = _loaded(part)
    rows = [library.model_variable(index) for index in range(library.model_variable_count())]
    return read_table(ffi, rows, library.model_derivative_of, library.model_bound_slack)


@functools.cache
def states(part: str) -> tuple[str, ...]:
    """Names of its continuous states."""
    _, library = _loaded(part)
    return tuple(variables(part)[library.model_state(place)].name for place in range(library.model_state_count()))


def token(part: str) -> str:
    """Hash over its table: GUID / instantiation token of its FMUs."""
    ffi, library = _loaded(part)
    text = ffi.new("char[39]")
    library.model_token(text)
    return cffi_text(ffi, text)


def equations(part: str) -> str:
    """What it computes, for people."""
    ffi, library = _loaded(part)
    return cffi_text(ffi, library.machine_equations())


class Machine:
    """One partner: set values, start, advance, read. Values in SI, choices by name or place."""

    def __init__(self, part: str, values: Mapping[str, float | str] | None = None) -> None:
        self.part = part
        self._ffi, self._library = _loaded(part)
        self._machine = self._ffi.new("struct Model *")
        self._taken = self._ffi.new("double *")
        self._variables = {variable.name: variable for variable in variables(part)}
        self._library.model_reset(self._machine)
        for name, value in (values or {}).items():
            self.set(name, value)

    def _variable(self, name: str) -> Variable:
        if name not in self._variables:
            raise ParameterError(f"{self.part} has no variable {name!r}; it has {', '.join(self._variables)}.")
        return self._variables[name]

    def _input(self, name: str) -> Variable:
        variable = self._variable(name)
        if variable.causality != "input":
            inputs = ", ".join(v.name for v in self._variables.values() if v.causality == "input")
            raise ParameterError(f"{self.part}: {name} is no input, and has no rate; inputs are {inputs or 'none'}.")
        return variable

    def _done(self, status: int, doing: str) -> None:
        if status != self._library.STATUS_OK:
            text = self._ffi.new("char[512]")
            self._library.model_explain(self._machine, status, text, 512)
            raise SimulationError(f"{self.part}, {doing} at t = {self.time:.9g} s: {cffi_text(self._ffi, text)}.")

    @property
    def time(self) -> float:
        return float(self._library.model_get(self._machine, self._library.MODEL_TIME))

    @time.setter
    def time(self, value: float) -> None:
        self._library.model_lead(self._machine, self._library.MODEL_TIME, value)

    def set(self, name: str, value: float | str) -> None:
        """Set one parameter, input or state; ParameterError outside its bounds."""
        variable = self._variable(name)
        self._done(self._library.model_set(self._machine, variable.index, variable.check(value)), f"setting {name}")

    def slope(self, name: str, rate: float) -> None:
        """The rate of an input [its unit per second] until it is given anew."""
        self._library.model_set_slope(self._machine, self._input(name).index, rate)

    def get(self, name: str) -> float:
        return float(self._library.model_get(self._machine, self._variable(name).index))

    def values(self) -> FloatArray:
        """All values, in the order of the table."""
        count = len(self._variables)
        return np.frombuffer(self._ffi.buffer(self._machine.value), dtype=np.float64)[:count].copy()

    def start(self, time: float = 0.0) -> None:
        self._done(self._library.model_start(self._machine, time), "start")

    def evaluate(self) -> None:
        self._done(self._library.model_evaluate(self._machine), "evaluation")

    def advance(self, step: float) -> None:
        self._done(self._library.model_step(self._machine, step, 0, self._taken), f"step of {step:g} s")

    def state(self) -> bytes:
        """Everything there is to it, as bytes."""
        return bytes(self._ffi.buffer(self._machine))

    def restore(self, state: bytes) -> None:
        self._ffi.buffer(self._machine)[:] = state

    def run(self, times: FloatArray, columns: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
        """Follow a record from times[0], where it must have been started: inputs linear between the samples; shape (n, len(names))."""
        for name, column in columns.items():
            check_column(self._variable(name), column)
        places = [self._variable(name).index for name in names]
        recorded = np.empty((times.size, len(names)))
        for n, time in enumerate(times):
            for name, column in columns.items():
                self.set(name, float(column[n]))
                last = n + 1 == times.size
                self.slope(name, 0.0 if last else float((column[n + 1] - column[n]) / (times[n + 1] - time)))
            self.evaluate()
            recorded[n] = self.values()[places]
            if n + 1 < times.size:
                self.advance(float(times[n + 1] - self.time))
        return recorded
