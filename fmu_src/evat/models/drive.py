"""How is an FMU driven along a record? Through fmpy, as any importer would, with buffers that are kept from step to step."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from evat.files.unpack import ArchiveError, opened, unpack
from evat.files.writing import OutputError, temporary
from evat.model import FloatArray, FmuError, ParameterError, Run, SimulationError, Trace

Progress = Callable[[float], None]


def _log(lines: list[str]) -> Callable[..., None]:
    def keep(*arguments: Any) -> None:
        message = arguments[-1]
        lines.append(message.decode(errors="replace") if isinstance(message, bytes) else str(message))

    return keep


class Driver:
    """An instance of a co-simulation FMU between `with` and its end: set parameters, follow a record."""

    def __init__(
        self, fmu: Path, values: Mapping[str, float | str | bool], relative_tolerance: float | None = None, name: str = "evat"
    ) -> None:
        try:
            with opened(fmu):
                self.description = fmpy.read_model_description(str(fmu), validate=False)
        except ArchiveError as error:
            raise FmuError(f"no FMU that can be read: {error}") from error
        except Exception as error:  # fmpy raises what its parsers raise
            raise FmuError(f"{fmu}: this is no FMU that can be read ({error}).") from error
        if self.description.coSimulation is None or self.description.fmiVersion.startswith("1"):
            raise FmuError(f"{fmu}: an FMU for co-simulation by FMI 2 or 3 is needed; this one is of FMI {self.description.fmiVersion}.")
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self._path, self._values, self._tolerance, self._log = fmu, dict(values), relative_tolerance, list[str]()
        self._name = name
        self._kept = ExitStack()  # its folder
        self._fmu: Any = None

    @property
    def log(self) -> tuple[str, ...]:
        """What the FMU has logged, a line each."""
        return tuple(self._log)

    def __enter__(self) -> Driver:
        try:
            self._instantiate()
            for name, value in self._values.items():
                self._set(name, value)
        except BaseException:
            self.__exit__()
            raise
        return self

    def _instantiate(self) -> None:
        self._folder = self._kept.enter_context(temporary())
        try:
            unpack(self._path, self._folder)
            self._load()
        except OutputError:  # it is not the FMU that is at fault
            raise
        except Exception as error:  # fmpy raises plain Exceptions: no binary for this platform
            said = f"; it said: {self._log[-1]}" if self._log else ""
            raise FmuError(f"{self._path}: it cannot be instantiated here ({error}){said}.") from error

    def _load(self) -> None:
        kind = FMU3Slave if self.description.fmiVersion.startswith("3") else FMU2Slave
        self._fmu = kind(
            guid=self.description.guid,
            unzipDirectory=str(self._folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=self._name,
        )
        logger = _log(self._log)
        if kind is FMU3Slave:
            self._fmu.instantiate(loggingOn=True, logMessage=fmpy.fmi3.fmi3LogMessageCallback(logger))
        else:
            callbacks = fmpy.fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(logger)
            callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
            callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
            self._fmu.instantiate(loggingOn=True, callbacks=callbacks)

    def __exit__(self, *_: object) -> None:
        if getattr(self._fmu, "component", None):
            self._fmu.freeInstance()
        self._kept.close()

    def _call(self, doing: str, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except Exception as error:  # FMICallException and what ctypes raises
            said = self._log[-1] if self._log else str(error)
            raise SimulationError(f"{doing}: the FMU answered: {said}") from error

    def _set(self, name: str, value: float | str | bool) -> None:
        if name not in self.variables:
            raise ParameterError(f"the FMU has no variable {name!r}.")
        variable, three = self.variables[name], self.description.fmiVersion.startswith("3")
        references, doing = [variable.valueReference], f"setting {name} = {value}"
        if variable.type in ("Real", "Float64"):
            if isinstance(value, str):
                raise ParameterError(f"{name} = {value!r}: a number in {unit_of(variable)} is needed.")
            self._call(doing, self._fmu.setFloat64 if three else self._fmu.setReal, references, [float(value)])
        elif variable.type == "Boolean":
            if value not in (0, 1):
                raise ParameterError(f"{name} = {value!r}: allowed are True and False.")
            self._call(doing, self._fmu.setBoolean, references, [bool(value)])
        elif variable.type in ("Enumeration", "Integer", "Int32"):
            number = self._item(variable, value)
            setter = self._fmu.setInteger if not three else self._fmu.setInt64 if variable.type == "Enumeration" else self._fmu.setInt32
            self._call(doing, setter, references, [number])
        else:
            raise ParameterError(f"{name} is of type {variable.type}, which this driver does not set.")

    @staticmethod
    def _item(variable: Any, value: float | str | bool) -> int:
        items = variable.declaredType.items if variable.declaredType is not None and variable.declaredType.items else []
        if not isinstance(value, str) and value == value // 1:
            return int(value)
        for item in items:
            if item.name == value:
                return int(item.value)
        allowed = ", ".join(item.name for item in items) or "whole numbers"
        raise ParameterError(f"{variable.name} = {value!r}: allowed are {allowed}.")

    def follow(self, run: Run, progress: Progress | None = None) -> FloatArray:
        """Follow the record with one communication step from sample to sample; shape (samples, outputs).

        Within a step inputs go on linearly: FMI 2 by their derivatives, where the FMU takes them; else, and by FMI 3, which has
        none in co-simulation, by the mean of both ends.
        """
        times, names = run.times, list(run.inputs)
        _check_run(run)
        table = np.column_stack([run.inputs[name] for name in names]) if names else np.empty((times.size, 0))
        for name in (*names, *run.outputs):
            if name not in self.variables:
                raise ParameterError(f"the FMU has no variable {name!r}.")
        self.prepare(names, run.outputs, float(times[0]), float(times[-1]))
        rows = np.empty((times.size, len(run.outputs)))
        self.set("first inputs", table[0])
        self.begin()
        self.get("first outputs", rows[0])
        for n in range(1, times.size):
            at = f"step to t = {times[n]:.9g} s"
            self.step(at, times[n - 1], times[n] - times[n - 1], table[n - 1], table[n])
            self.get(at, rows[n])
            if progress is not None and n % 256 == 0:
                progress(n / times.size)
        self.end()
        return rows

    def prepare(self, inputs: Sequence[str], outputs: Sequence[str], start: float, stop: float) -> None:
        """Enter the initialisation; from here on `set`, `step` and `get` take the values of these inputs and outputs."""
        if self.description.fmiVersion.startswith("3"):
            self._call("initialisation", self._fmu.enterInitializationMode, startTime=start, stopTime=stop, tolerance=self._tolerance)
        else:
            self._call("initialisation", self._fmu.setupExperiment, startTime=start, stopTime=stop, tolerance=self._tolerance)
            self._call("initialisation", self._fmu.enterInitializationMode)
        three = self.description.fmiVersion.startswith("3")
        self._interpolates = not three and bool(self.description.coSimulation.canInterpolateInputs)
        self._loop = _Loop(self._fmu, three, [self.variables[n] for n in inputs], [self.variables[n] for n in outputs])

    def set(self, doing: str, row: FloatArray) -> None:
        """The inputs."""
        self._call(doing, self._loop.set, row)

    def begin(self) -> None:
        """End the initialisation."""
        self._call("initialisation", self._fmu.exitInitializationMode)

    def step(self, doing: str, time: float, step: float, now: FloatArray, then: FloatArray) -> None:
        """A step over which the inputs go from `now`, where they stand, to `then`: linearly, or where the FMU cannot, at their mean."""
        if now.size and self._interpolates:
            self._call(doing, self._loop.lean, (then - now) / step)
        elif now.size:
            self._call(doing, self._loop.set, 0.5 * (now + then))
        self._call(doing, self._fmu.doStep, time, step)
        if now.size:
            self._call(doing, self._loop.set, then)

    def get(self, doing: str, row: FloatArray) -> None:
        """The outputs."""
        self._call(doing, self._loop.get, row)

    def end(self) -> None:
        self._call("the end", self._fmu.terminate)


def _check_run(run: Run) -> None:
    times = run.times
    if times.ndim != 1 or times.size < 2 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0):
        raise ParameterError("sample times must be a row of at least 2 finite, increasing numbers in s.")
    for name, column in run.inputs.items():
        if np.shape(column) != times.shape:
            raise ParameterError(f"{name} has {np.size(column)} samples, the clock has {times.size}.")


class _Loop:
    """The value references and buffers of a record's inputs and outputs, kept from step to step."""

    def __init__(self, fmu: Any, three: bool, inputs: Sequence[Any], outputs: Sequence[Any]) -> None:
        self._fmu, self._three, self._inputs = fmu, three, len(inputs)
        self._in = (ctypes.c_uint32 * len(inputs))(*(v.valueReference for v in inputs))
        self._in_values = (ctypes.c_double * len(inputs))()
        self._first = (ctypes.c_int * len(inputs))(*([1] * len(inputs)))
        self._real = [place for place, v in enumerate(outputs) if v.type in ("Real", "Float64")]
        self._other = [(place, v) for place, v in enumerate(outputs) if v.type not in ("Real", "Float64")]
        self._out = (ctypes.c_uint32 * len(self._real))(*(outputs[place].valueReference for place in self._real))
        self._out_values = (ctypes.c_double * len(self._real))()
        self._out_view = np.ctypeslib.as_array(self._out_values)
        self._in_view = np.ctypeslib.as_array(self._in_values)

    def set(self, row: FloatArray) -> None:
        if not self._inputs:
            return
        self._in_view[:] = row
        if self._three:
            self._fmu.fmi3SetFloat64(self._fmu.component, self._in, self._inputs, self._in_values, self._inputs)
        else:
            self._fmu.fmi2SetReal(self._fmu.component, self._in, self._inputs, self._in_values)

    def lean(self, rates: FloatArray) -> None:
        """FMI 2: the inputs' rates over the coming step."""
        self._in_view[:] = rates
        self._fmu.fmi2SetRealInputDerivatives(self._fmu.component, self._in, self._inputs, self._first, self._in_values)

    def get(self, row: FloatArray) -> None:
        if self._real:
            if self._three:
                self._fmu.fmi3GetFloat64(self._fmu.component, self._out, len(self._real), self._out_values, len(self._real))
            else:
                self._fmu.fmi2GetReal(self._fmu.component, self._out, len(self._real), self._out_values)
            row[self._real] = self._out_view
        for place, variable in self._other:
            kind = {"Int32": "Int32", "Enumeration": "Int64" if self._three else "Integer"}.get(variable.type, variable.type)
            row[place] = float(getattr(self._fmu, f"get{kind}")([variable.valueReference])[0])


def unit_of(variable: Any) -> str:
    """Of a variable of a modelDescription.xml, its own or its type's; "1" where neither has one."""
    declared = variable.declaredType.unit if variable.declaredType is not None else None
    return str(variable.unit or declared or "1")


def drive(
    fmu: Path,
    run: Run,
    values: Mapping[str, float | str | bool],
    *,
    relative_tolerance: float | None = None,
    progress: Progress | None = None,
) -> Trace:
    """Drive a co-simulation FMU (2.0 or 3.0) through `run` with the start `values` by name; see evat.model.Run.

    Raises
    ------
    FmuError, where the file is no such FMU; ParameterError for an unknown name; SimulationError with the FMU's own log line where a
    call fails.
    """
    with Driver(fmu, values, relative_tolerance) as driver:
        rows = driver.follow(run, progress)
        return Trace(
            times=run.times,
            columns={name: rows[:, place].copy() for place, name in enumerate(run.outputs)},
            units={name: unit_of(driver.variables[name]) for name in run.outputs},
            made_by={
                "fmu": fmu.name,
                "token": driver.description.guid,
                "fmi": driver.description.fmiVersion,
                "values": {name: value if isinstance(value, str) else float(value) for name, value in values.items()},
                "log": "; ".join(driver.log),
            },
        )
