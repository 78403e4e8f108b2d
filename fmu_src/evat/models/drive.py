"""How is an FMU driven along a record? Loaded by fmpy, as by any importer, and stepped by the compiled loop that steps coupled ones."""

from __future__ import annotations

import ctypes
import numbers
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from evat.files.shared_library import cut_at
from evat.files.unpack import ArchiveError, opened, unpack
from evat.files.writing import OutputError, temporary
from evat.model import FloatArray, FmuError, ParameterError, Run, SimulationError, Trace
from evat.native.coupling import FORMS, CallFailed, CoupledFmu, Coupling, NotFinite, Output

Progress = Callable[[float], None]
_NOT_RUN = ("documentation/", "sources/")  # most of an FMU's files, and none that it may ask for while it runs


def _log(lines: list[str]) -> Callable[..., None]:
    def keep(*arguments: Any) -> None:
        message = arguments[-1]
        lines.append(message.decode(errors="replace") if isinstance(message, bytes) else str(message))

    return keep


@lru_cache(maxsize=8)
def _description(fmu: Path, *_: int) -> Any:
    """Read once for the many runs of one FMU; by the path, and what tells the file from another that is put there."""
    return fmpy.read_model_description(str(fmu), validate=False)


def only_once(fmu: Path) -> str | None:
    """The token of an FMU that says it can be instantiated only once in a process; None of any other, and of what cannot be read."""
    try:
        with opened(fmu):
            state = fmu.stat()
            about = _description(fmu, state.st_mtime_ns, state.st_size)
    except Exception:  # whoever opens it tells why
        return None
    return str(about.guid) if about.coSimulation is not None and about.coSimulation.canBeInstantiatedOnlyOncePerProcess else None


_LOADING = threading.Lock()


@contextmanager
def _directory_kept() -> Iterator[None]:
    """Loading a library fmpy goes into its folder: not back where that fails, and to where another thread is that loads one, too."""
    with _LOADING:
        before = os.getcwd()
        try:
            yield
        finally:
            os.chdir(before)


class Driver:
    """An instance of a co-simulation FMU between `with` and its end: set parameters, follow a record."""

    def __init__(
        self, fmu: Path, values: Mapping[str, float | str | bool], relative_tolerance: float | None = None, name: str = "evat"
    ) -> None:
        try:
            with opened(fmu):
                state = fmu.stat()
                self.description = _description(fmu, state.st_mtime_ns, state.st_size)
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
            unpack(self._path, self._folder, but=_NOT_RUN)
            self._check_libraries()
            self._load()
        except (FmuError, OutputError):  # which say all; of the latter not the FMU is at fault
            raise
        except Exception as error:  # fmpy raises plain Exceptions: no binary for this platform
            said = f"; it said: {self._log[-1]}" if self._log else ""
            raise FmuError(f"{self._path}: it cannot be instantiated here ({error}){said}.") from error

    def _check_libraries(self) -> None:
        """FmuError where one that this machine loads is cut short: the system would not say so, but end the process."""
        three = self.description.fmiVersion.startswith("3")
        for library in sorted((self._folder / "binaries" / (fmpy.platform_tuple if three else fmpy.platform)).glob("*")):
            if library.is_file() and (wanted := cut_at(library)) is not None:
                name = library.relative_to(self._folder).as_posix()
                raise FmuError(
                    f"{self._path.name}: {name} is truncated: it has {library.stat().st_size} bytes, by its headers at least {wanted}. "
                    "It is not loaded; build or download the FMU again."
                )

    def _load(self) -> None:
        kind = FMU3Slave if self.description.fmiVersion.startswith("3") else FMU2Slave
        with _directory_kept():
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
            if isinstance(value, str) or not _is_number(value):
                raise ParameterError(f"{name} = {value!r}: a number in {unit_of(variable)} is needed.")
            self._call(doing, self._fmu.setFloat64 if three else self._fmu.setReal, references, [float(value)])
        elif variable.type == "Boolean":
            if isinstance(value, str) or value not in (0, 1):
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
        if not isinstance(value, str) and _is_number(value, or_bool=True) and value == value // 1:
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
        check_run(run)
        table = np.column_stack([run.inputs[name] for name in names]) if names else np.empty((times.size, 0))
        for name in (*names, *run.outputs):
            if name not in self.variables:
                raise ParameterError(f"the FMU has no variable {name!r}.")
        self.prepare(names, run.outputs, float(times[0]), float(times[-1]))
        shown = len(run.outputs)
        loop = Coupling([self.member], [range(shown, shown + len(names))], [range(shown)], len(names))
        loop.signals[shown:] = table[0]
        rows, at = np.empty((shown, times.size)), "first inputs"
        try:
            loop.set(0)
            self.begin()
            at = "first outputs"
            loop.show(0)
            at = ""
            loop.run(rows, times.size - 1, 1, lambda n, m: times[n : m + 1], lambda ends: table[loop.steps + 1 :][: ends.size], progress)
        except (CallFailed, NotFinite) as failed:
            raise self.failure(at or f"step to t = {times[loop.steps + 1]:.9g} s", failed) from failed
        self.end()
        return rows.T

    def prepare(self, inputs: Sequence[str], outputs: Sequence[str], start: float, stop: float) -> None:
        """Enter the initialisation; from here on `member` has these inputs and outputs."""
        three, self._outputs = self.description.fmiVersion.startswith("3"), list(outputs)
        if three:
            self._call("initialisation", self._fmu.enterInitializationMode, startTime=start, stopTime=stop, tolerance=self._tolerance)
        else:
            self._call("initialisation", self._fmu.setupExperiment, startTime=start, stopTime=stop, tolerance=self._tolerance)
            self._call("initialisation", self._fmu.enterInitializationMode)
        self.member = CoupledFmu(
            3 if three else 2,
            self._fmu.component,
            self._address,
            [self.variables[name].valueReference for name in inputs],
            [self._output(self.variables[name], three) for name in outputs],
            not three and bool(self.description.coSimulation.canInterpolateInputs),
        )

    def start_of(self, name: str) -> float:
        """What a real input is until something sets it."""
        start = self.variables[name].start
        return 0.0 if start is None else float(start)

    def _address(self, function: str) -> int:
        address = ctypes.cast(getattr(self._fmu.dll, function), ctypes.c_void_p).value
        return address or 0

    @staticmethod
    def _output(variable: Any, three: bool) -> Output:
        kinds = {"Enumeration": "Int64"} if three else {"Real": "Float64", "Integer": "Int32", "Enumeration": "Int32", "Boolean": "Int32"}
        form = kinds.get(variable.type, variable.type if three else "")
        if form not in FORMS:
            raise ParameterError(f"{variable.name} is of type {variable.type}, which is no number; only numbers are read.")
        read = form if three else "Integer" if variable.type == "Enumeration" else variable.type
        return Output(variable.valueReference, form, f"fmi{3 if three else 2}Get{read}")

    def failure(self, doing: str, failed: CallFailed | NotFinite) -> SimulationError:
        """What is told of a call that failed, or of an output."""
        if isinstance(failed, NotFinite):
            return SimulationError(f"{self._outputs[failed.output]} is {failed.value}, which is no finite number")
        if failed.asks_to_end:
            return SimulationError(f"{doing}: the FMU asks that the simulation ends")
        said = self._log[-1] if self._log else FMICallException(failed.function, failed.status)
        return SimulationError(f"{doing}: the FMU answered: {said}")

    def begin(self) -> None:
        """End the initialisation."""
        self._call("initialisation", self._fmu.exitInitializationMode)

    def end(self) -> None:
        self._call("the end", self._fmu.terminate)


def _is_number(value: object, or_bool: bool = False) -> bool:
    """Numbers of numpy are some, too; True is one only where a choice is meant."""
    return isinstance(value, numbers.Real) and (or_bool or not isinstance(value, bool))


def check_run(run: Run) -> None:
    """ParameterError where sample times do not increase, or an input has other samples than the clock."""
    times = run.times
    if times.ndim != 1 or times.size < 2 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0):
        raise ParameterError("sample times must be a row of at least 2 finite, increasing numbers in s.")
    for name, column in run.inputs.items():
        if np.shape(column) != times.shape:
            raise ParameterError(f"{name} has {np.size(column)} samples, the clock has {times.size}.")


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
