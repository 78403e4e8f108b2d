"""How does a C host see an FMU? The library through ctypes: nothing between a test and the functions of the standard."""

from __future__ import annotations

import ctypes as ct
import math
import re
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from evat.native.compile import fmi_headers, host_target
from fmpy import read_model_description

OK, WARNING, DISCARD, ERROR = 0, 1, 2, 3
REAL, INTEGER, BOOLEAN, CHOICE = "real", "integer", "boolean", "choice"

_LOGGER2 = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_char_p, ct.c_int, ct.c_char_p, ct.c_char_p)  # the rest of its arguments is not used
_LOGGER3 = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_int, ct.c_char_p, ct.c_char_p)
_ALLOCATE = ct.CFUNCTYPE(ct.c_void_p, ct.c_size_t, ct.c_size_t)
_RELEASE = ct.CFUNCTYPE(None, ct.c_void_p)
_UPDATE = ct.CFUNCTYPE(
    None, ct.c_void_p, ct.c_double, ct.c_bool, ct.c_bool, ct.c_bool, ct.c_bool, ct.POINTER(ct.c_bool), ct.POINTER(ct.c_double)
)


class _Callbacks2(ct.Structure):
    _fields_ = (
        ("logger", _LOGGER2),
        ("allocate", _ALLOCATE),
        ("release", _RELEASE),
        ("finished", ct.c_void_p),
        ("environment", ct.c_void_p),
    )


class EventInfo2(ct.Structure):
    """fmi2EventInfo."""

    _fields_ = (
        ("needed", ct.c_int),
        ("terminate", ct.c_int),
        ("nominals_changed", ct.c_int),
        ("states_changed", ct.c_int),
        ("next_defined", ct.c_int),
        ("next_time", ct.c_double),
    )


class Door:
    """One FMU: its library, and the names, types and token that its description states."""

    def __init__(self, fmu: Path, folder: Path) -> None:
        description = read_model_description(str(fmu), validate=False)
        self.version = int(description.fmiVersion[0])
        self.token = description.guid if self.version == 2 else description.instantiationToken
        self.variables = {v.name: v for v in description.modelVariables}
        self.reference = {name: int(v.valueReference) for name, v in self.variables.items()}
        target = host_target()
        binary = f"binaries/{target.fmi2_folder if self.version == 2 else target.fmi3_folder}/{description.modelName}{target.extension}"
        with zipfile.ZipFile(fmu) as archive:
            self.path = archive.extract(binary, folder)
        self.library = ct.CDLL(self.path)
        self.functions = self._declared()

    def _declared(self) -> list[str]:
        """The functions that the standard's header declares."""
        text = (fmi_headers() / f"fmi{self.version}Functions.h").read_text(encoding="latin-1")
        return re.findall(rf"^\s*FMI{self.version}_Export\s+\w+\s+(\w+);", text, re.MULTILINE)

    def kind(self, name: str) -> str:
        """Type of a variable in the kernel's words."""
        return {"Real": REAL, "Float64": REAL, "Boolean": BOOLEAN, "Enumeration": CHOICE}.get(self.variables[name].type, INTEGER)

    def function(self, name: str) -> Callable[..., int]:
        """fmi2<name> or fmi3<name>."""
        function: Callable[..., int] = getattr(self.library, f"fmi{self.version}{name}")
        return function

    def text(self, name: str) -> str:
        """What a function without arguments says."""
        function = getattr(self.library, f"fmi{self.version}{name}")
        function.restype = ct.c_char_p
        return str(function().decode())


class Instance:
    """One component; every call gives the status back and its log lines gather in `lines`."""

    def __init__(
        self,
        door: Door,
        *,
        model_exchange: bool = False,
        kind: int | None = None,
        name: bytes | None = b"one",
        token: bytes | None = b"",
        logging: bool = True,
        event_mode: bool = False,
        early_return: bool = False,
        update: Callable[[Instance, float], float | None] | None = None,
        allocator: tuple[Callable[[int, int], int], Callable[[int], None]] | None = None,
    ) -> None:
        self.door, self.lines = door, list[tuple[int, str, str]]()
        guid = door.token.encode() if token == b"" else token
        if door.version == 2:
            self._logger: object = _LOGGER2(lambda _e, _n, status, category, text: self._note(status, category, text))
            allocate, release = allocator or (None, None)
            self._callbacks = _Callbacks2(
                self._logger,
                _ALLOCATE(allocate) if allocate else _ALLOCATE(0),
                _RELEASE(release) if release else _RELEASE(0),
                None,
                None,
            )
            make = door.library.fmi2Instantiate
            make.restype = ct.c_void_p
            fmu_type = kind if kind is not None else int(not model_exchange)
            self.pointer = make(name, fmu_type, guid, None, ct.byref(self._callbacks), 0, int(logging))
        else:
            self._logger = _LOGGER3(lambda _e, status, category, text: self._note(status, category, text))
            self._update = _UPDATE(lambda *arguments: self._show(update, *arguments))
            tail: list[Any] = [ct.c_bool(logging), None, self._logger]
            if model_exchange:
                make = door.library.fmi3InstantiateModelExchange
            else:
                make = door.library.fmi3InstantiateCoSimulation
                wanted = (ct.c_uint * 1)(0)
                tail[1:1] = [ct.c_bool(event_mode), ct.c_bool(early_return), wanted, ct.c_size_t(1 if update else 0)]
                tail.append(self._update if update else None)
            make.restype = ct.c_void_p
            self.pointer = make(name, guid, None, ct.c_bool(False), *tail)

    def _note(self, status: int, category: bytes, text: bytes) -> None:
        self.lines.append((status, category.decode(), text.decode()))

    def _show(self, update: Callable[[Instance, float], float | None] | None, _environment: object, time: float, *rest: object) -> None:
        until = update(self, time) if update else None
        if until is not None:
            wants, at = rest[-2:]
            wants[0], at[0] = True, until  # type: ignore[index]

    def call(self, name: str, *arguments: object) -> int:
        """Any function; floats are doubles."""
        made = [ct.c_double(a) if isinstance(a, float) else a for a in arguments]
        return self.door.function(name)(ct.c_void_p(self.pointer), *made)

    def said(self) -> str:
        """The one line that was logged since the last time; it is an error that there is not exactly one."""
        assert len(self.lines) == 1, self.lines
        return self.lines.pop()[2]

    def free(self) -> None:
        self.call("FreeInstance")
        self.pointer = None

    # ---- values ----

    def _access(self, verb: str, kind: str, references: list[int], values: object) -> int:
        two = self.door.version == 2
        word = {REAL: "Real" if two else "Float64", INTEGER: "Integer" if two else "Int32", BOOLEAN: "Boolean"}.get(kind)
        word = word or ("Integer" if two else "Int64")
        count = ct.c_size_t(len(references))
        return self.call(verb + word, (ct.c_uint * len(references))(*references), count, values, *([] if two else [count]))

    def _array(self, kind: str, values: list[float]) -> object:
        two = self.door.version == 2
        if kind == REAL:
            return (ct.c_double * len(values))(*values)
        item: Any = {BOOLEAN: ct.c_int if two else ct.c_bool, CHOICE: ct.c_int if two else ct.c_int64}.get(kind, ct.c_int)
        return (item * len(values))(*map(int, values))

    def set_as(self, kind: str, references: list[int], values: list[float]) -> int:
        """Set by value reference through the functions of one type."""
        return self._access("Set", kind, references, self._array(kind, values))

    def get_as(self, kind: str, references: list[int]) -> tuple[int, list[float]]:
        """Get by value reference through the functions of one type."""
        values = self._array(kind, [0.0] * len(references))
        status = self._access("Get", kind, references, values)
        return status, list(values)  # type: ignore[call-overload]

    def set(self, values: Mapping[str, float]) -> int:
        """Set variables by name, one call for each type; the worst status."""
        worst = OK
        for kind in (REAL, INTEGER, BOOLEAN, CHOICE):
            chosen = {name: value for name, value in values.items() if self.door.kind(name) == kind}
            if chosen:
                references = [self.door.reference[name] for name in chosen]
                worst = max(worst, self.set_as(kind, references, list(chosen.values())))
        return worst

    def get(self, *names: str) -> list[float]:
        """Values by name."""
        values = []
        for name in names:
            status, value = self.get_as(self.door.kind(name), [self.door.reference[name]])
            assert status == OK, (name, status, self.lines)
            values += value
        return values

    # ---- life ----

    def set_up(self, start: float = 0.0, stop: float | None = None, tolerance: float | None = None) -> int:
        """Up to and into initialization mode."""
        two = self.door.version == 2
        flag = ct.c_int if two else ct.c_bool
        facts = [flag(tolerance is not None), tolerance or 0.0, start, flag(stop is not None), stop or 0.0]
        if not two:
            return self.call("EnterInitializationMode", *facts)
        return max(self.call("SetupExperiment", *facts), self.call("EnterInitializationMode"))

    def start(self, values: Mapping[str, float] | None = None, **facts: float) -> Instance:
        """Set start values and initialise."""
        status = max(self.set(values or {}), self.set_up(**facts), self.call("ExitInitializationMode"))
        assert status <= WARNING, self.lines
        return self

    def step(self, time: float, size: float) -> int:
        """doStep, without what FMI 3 tells beside the status."""
        if self.door.version == 2:
            return self.call("DoStep", time, size, 1)
        return self.step3(time, size)[0]

    def step3(self, time: float, size: float) -> tuple[int, bool, bool, float]:
        """FMI 3: status, event, early return, last successful time."""
        event, stop, early, last = ct.c_bool(), ct.c_bool(), ct.c_bool(), ct.c_double(math.nan)
        results = [ct.byref(result) for result in (event, stop, early, last)]
        status = self.call("DoStep", time, size, ct.c_bool(True), *results)
        return status, event.value, early.value, last.value

    def update(self) -> tuple[int, bool, float | None]:
        """The event is converged: status, states changed, next time event."""
        if self.door.version == 2:
            info = EventInfo2()
            status = self.call("NewDiscreteStates", ct.byref(info))
            return status, bool(info.states_changed), info.next_time if info.next_defined else None
        flags, moment = [ct.c_bool(True) for _ in range(5)], ct.c_double()
        status = self.call("UpdateDiscreteStates", *map(ct.byref, flags), ct.byref(moment))
        assert not any(flag.value for flag in flags[:3]) or status != OK
        return status, flags[3].value, moment.value if flags[4].value else None

    # ---- FMU state ----

    def state_function(self, name: str) -> str:
        """The name of a function of the FMU state, which the two versions spell differently."""
        return name if self.door.version == 3 else name.replace("State", "state").replace("Deserialize", "DeSerialize")

    def save(self, state: ct.c_void_p | None = None) -> ct.c_void_p:
        """Get the FMU state, into `state` if one is given."""
        state = state or ct.c_void_p()
        assert self.call(self.state_function("GetFMUState"), ct.byref(state)) == OK
        return state

    def restore(self, state: ct.c_void_p) -> int:
        return self.call(self.state_function("SetFMUState"), state)

    def drop(self, state: ct.c_void_p) -> int:
        return self.call(self.state_function("FreeFMUState"), ct.byref(state))

    def serialize(self) -> bytes:
        """The present FMU state as bytes."""
        state, size = self.save(), ct.c_size_t()
        assert self.call(self.state_function("SerializedFMUStateSize"), state, ct.byref(size)) == OK
        data = (ct.c_ubyte * size.value)()
        assert self.call(self.state_function("SerializeFMUState"), state, data, size) == OK
        assert self.drop(state) == OK
        return bytes(data)

    def deserialize(self, data: bytes) -> int:
        """Bring bytes back as the present FMU state."""
        state, size = ct.c_void_p(), ct.c_size_t(len(data))
        status = self.call(self.state_function("DeserializeFMUState"), data, size, ct.byref(state))
        return status if status != OK else max(self.restore(state), self.drop(state))
