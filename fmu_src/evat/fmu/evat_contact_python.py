"""How does the contact run as an FMU with no compiled kernel? A slave of the package pythonfmu around reference.py.

Inside the FMU this file lies in resources/ beside reference.py (the laws, to be changed by whoever wants to) and the variable tables
as JSON. pythonfmu's wrapper answers every Python exception with fmi2Fatal and may crash the host when it resets such an instance, and
its setters and getters have no other error status. So nothing is raised here: what cannot be done is logged in one line with status
Error, a refused value is not taken, and until it is put right (or the instance reset) every step is refused with fmi2Discard.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import math
import sys
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Integer, Real
from pythonfmu.enums import Fmi2Status, Fmi2Variability

TABLES = "evat_contact_python.json"
REFERENCE = "reference.py"
_KINDS = {"real": Real, "integer": Integer, "boolean": Boolean, "choice": Integer}
_CAUSALITIES = {"parameter": Fmi2Causality.parameter, "input": Fmi2Causality.input, "output": Fmi2Causality.output}


class Refused(Exception):
    """A call that is not allowed; the text says what was found and what is allowed. (Nothing of evat can be imported inside an FMU.)"""


def load_reference(folder: Path) -> ModuleType:
    """reference.py of this FMU, not of another one in the same process: the module goes by the hash of its text."""
    text = (folder / REFERENCE).read_bytes()
    name = f"evat_contact_python_{hashlib.sha256(text).hexdigest()[:16]}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, folder / REFERENCE)
        if spec is None or spec.loader is None:
            raise ImportError(f"{folder / REFERENCE} cannot be loaded as a Python module.")
        sys.modules[name] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(sys.modules[name])
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]


class EvatContactPython(Fmi2Slave):  # type: ignore[misc]
    """The contact between chip and tool, in plain Python."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        folder = Path(self.resources)
        tables = json.loads((folder / TABLES).read_text(encoding="utf-8"))
        self.rows: list[dict[str, Any]] = tables["variables"]
        self.states: list[str] = tables["states"]
        self.first_item: int = tables["first_item"]
        self.first_reference: int = tables["first_reference"]
        self.values = {row["name"]: row["start"] for row in self.rows if self._is_settable(row)}
        self.refused: dict[str, str] = {}  # what was asked for and could not be done, and is not yet put right
        self.mode, self.stale, self.warned, self.warned_of_bound = "instantiated", True, False, False
        self.contact: Any = None  # of the class ReferenceContact in reference.py
        self.start_time, self.stop_time = 0.0, math.inf
        self.reference: ModuleType | None = None
        self._try("reference.py", lambda: setattr(self, "reference", load_reference(folder)))
        for place, row in enumerate(self.rows):
            self.register_variable(self._registered(place, row))

    def _registered(self, place: int, row: dict[str, Any]) -> Any:
        kind = _KINDS[row["type"]]
        variability = None if row["causality"] == "independent" else Fmi2Variability[row["variability"]]
        causality = _CAUSALITIES.get(row["causality"], Fmi2Causality.local)
        return kind(row["name"], causality=causality, variability=variability, description=row["meaning"], getter=lambda: self._get(place))

    # -- refusing

    def _refuse(self, what: str, why: str) -> None:
        self.refused[what] = " ".join(why.split())
        self.log(f"{what}: {self.refused[what]}", Fmi2Status.error)

    def _try(self, what: str, action: Callable[[], Any]) -> bool:
        """Whether it could be done; if not it is logged. Any exception: the text of a law may be anybody's."""
        try:
            action()
        except Refused as error:
            self._refuse(what, str(error))
        except Exception as error:
            self._refuse(what, str(error) if type(error).__name__ == "ContactError" else f"{type(error).__name__}: {error}")
        else:
            self.refused.pop(what, None)
            return True
        return False

    # -- values

    def _is_settable(self, row: dict[str, Any]) -> bool:
        return row["causality"] in ("parameter", "input") or row["name"] in self.states

    def _settable_now(self, row: dict[str, Any]) -> bool:
        running = row["causality"] == "input" or (row["causality"] == "parameter" and row["variability"] == "tunable")
        return self._is_settable(row) if self.mode != "running" else running

    def _kept(self, row: dict[str, Any], value: Any) -> Any:
        """What FMI gives as what the tables hold (a choice by its place); ValueError where the tables do not allow it."""
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        if not math.isfinite(value):
            raise Refused(f"{value} is no finite number{unit and ' in' + unit}.")
        number = value
        if row["type"] == "choice":
            words = dict(enumerate(row["choices"], self.first_item))
            if value not in words:
                raise Refused(f"{value} is none of {', '.join(f'{number} {word}' for number, word in words.items())}.")
            number = value - self.first_item
        low, high = (-math.inf if row["min"] is None else row["min"]), (math.inf if row["max"] is None else row["max"])
        slack = row["slack"]  # an input that misses its bounds by a hair is held on them
        if not low - slack <= number <= high + slack:
            raise Refused(f"{value:g}{unit} lies outside {low:g} to {high:g}{unit}.")
        if not self._settable_now(row):
            raise Refused("it cannot be set now." if self._is_settable(row) else "it is calculated, not set.")
        held = min(max(number, low), high)
        if held != number and not self.warned_of_bound:
            self.warned_of_bound = True
            self.log(
                f"{row['name']} = {value:g}{unit} lies outside {low:g} to {high:g}{unit} by a hair and is held there.", Fmi2Status.warning
            )
        return held

    def _worded(self, row: dict[str, Any]) -> Any:
        """A value as reference.py takes it."""
        value = self.values[row["name"]]
        if row["type"] == "choice":
            return row["choices"][int(value)]
        return bool(value) if row["type"] == "boolean" else value

    def _put(self, kind: Any, vr: int, value: Any) -> None:
        row = self._row(kind, vr)
        self.values[row["name"]] = self._kept(row, value)
        self.stale = True
        if self.mode == "running":
            self.contact.set(row["name"], self._worded(row))

    def _row(self, kind: Any, vr: int) -> dict[str, Any]:
        place = vr - self.first_reference
        if not (0 <= place < len(self.rows) and _KINDS[self.rows[place]["type"]] is kind):
            raise Refused(f"there is no {kind.__name__} variable with this value reference.")
        return self.rows[place]

    def _set_all(self, kind: Any, vrs: Iterable[int], values: Iterable[Any]) -> None:
        for vr, value in zip(vrs, values, strict=True):
            place = vr - self.first_reference
            name = self.rows[place]["name"] if 0 <= place < len(self.rows) else f"value reference {vr}"
            self._try(name, partial(self._put, kind, vr, value))

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self._set_all(Real, vrs, values)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set_all(Integer, vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self._set_all(Boolean, vrs, values)

    def _get(self, place: int) -> Any:
        row = self.rows[place]
        if row["causality"] in ("parameter", "input"):
            return self.values[row["name"]] + (self.first_item if row["type"] == "choice" else 0)
        if self.stale and self.mode != "instantiated":
            self.stale = False
            self._try("outputs", self.contact.evaluate if self.mode == "running" else self._begin)
        if self.refused and row["type"] == "real":
            return math.nan  # what goes on otherwise than was asked shows nothing, for no status says so here
        if self.contact is not None and row["name"] in self.contact.out:
            return self.contact.get(row["name"])
        return self.values.get(row["name"], row["start"])

    def _get_all(self, kind: Any, vrs: Iterable[int], convert: Callable[[Any], Any], nothing: Any) -> list[Any]:
        numbers = []
        for vr in vrs:
            known = self._try(f"value reference {vr}", partial(self._row, kind, vr))
            numbers.append(convert(self._get(vr - self.first_reference)) if known else nothing)
        return numbers

    def get_real(self, vrs: list[int]) -> list[float]:
        return self._get_all(Real, vrs, float, math.nan)

    def get_integer(self, vrs: list[int]) -> list[int]:
        return self._get_all(Integer, vrs, int, 0)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return self._get_all(Boolean, vrs, bool, False)

    # -- life

    def setup_experiment(self, start_time: float, stop_time: float | None = None, tolerance: float | None = None) -> None:
        self.start_time, self.stop_time = start_time, math.inf if stop_time is None else stop_time
        row = next(row for row in self.rows if row["name"] == "relative_tolerance")
        if tolerance is not None and self.values[row["name"]] == row["start"]:  # one that was set is the more particular wish
            self._try("tolerance", lambda: self.values.update({row["name"]: self._kept(row, tolerance)}))

    def enter_initialization_mode(self) -> None:
        self.mode, self.stale = "initializing", True

    def _begin(self) -> None:
        """The contact as it starts with the values that are set now."""
        if self.reference is None:
            raise Refused("reference.py could not be loaded.")
        contact = self.reference.ReferenceContact({row["name"]: self._worded(row) for row in self.rows if row["name"] in self.values})
        contact.start(self.start_time)
        self.contact = contact

    def exit_initialization_mode(self) -> None:
        if self.mode == "initializing" and self._try("start", self._begin):
            self.mode, self.stale = "running", False
            self.refused.pop("outputs", None)

    def do_step(self, current_time: float, step_size: float) -> bool:
        if self.mode != "running":
            if not self.refused:
                self._refuse("step", f"the instance is {self.mode}; steps come after the initialization mode.")
            return False
        self.refused.pop("step", None)
        return not self.refused and self._try("step", lambda: self._step(current_time, step_size))

    def _step(self, time: float, step: float) -> None:
        now = self.contact.time
        if not (step > 0 and math.isfinite(step)):
            raise Refused(f"its length is {step:g} s; a positive finite number is needed.")
        if not abs(time - now) <= 1e-9 * step + 1e-12 * abs(now):
            raise Refused(f"it begins at {time!r} s, the instance stands at {now!r} s.")
        if time + step > self.stop_time + 1e-9 * step + 1e-12 * abs(time):
            raise Refused(f"it would end at {time + step!r} s, after the stop time {self.stop_time!r} s.")
        before = self.contact.state()
        try:
            self.contact.advance(step)
            if not all(map(math.isfinite, self.contact.out.values())):
                raise Refused("an output is no finite number; the values before the step stand.")
        except BaseException:
            self.contact.restore(before)
            raise
        self.contact.time, self.stale = time + step, False  # the host's sum, so that rounding does not build up
        self.contact.out["time"] = self.contact.time
        if self.contact.clamped and not self.warned:
            self.warned = True
            self.log(
                "a value was kept from leaving its range (stiffness floor, force domain, temperature); see clamped_count.",
                Fmi2Status.warning,
            )

    # -- state

    _STATE = ("values", "refused", "mode", "stale", "warned", "warned_of_bound", "start_time", "stop_time")

    def _get_fmu_state(self) -> dict[str, Any]:
        kept = {name: getattr(self, name) for name in self._STATE}
        contact = None if self.contact is None else self.contact.state()
        return {**{name: dict(value) if isinstance(value, dict) else value for name, value in kept.items()}, "contact": contact}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self._try("FMU state", lambda: self._take(state))

    def _take(self, state: dict[str, Any]) -> None:
        if "unreadable" in state:
            raise Refused(state["unreadable"])
        if state.keys() != {*self._STATE, "contact"} or state["values"].keys() != self.values.keys() or self.reference is None:
            raise Refused("it comes from another model; give back a state that this FMU has made.")
        contact = None
        if state["contact"] is not None:
            contact = self.reference.ReferenceContact(state["contact"]["p"])
            contact.restore(state["contact"])
        for name in self._STATE:
            setattr(self, name, dict(state[name]) if isinstance(state[name], dict) else state[name])
        self.contact = contact

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        """JSON in front of which its hash stands; numbers in the shortest form that reads back as the same number."""
        text = json.dumps(state, sort_keys=True).encode()
        return hashlib.sha256(text).hexdigest().encode() + text

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        if hashlib.sha256(state[64:]).hexdigest().encode() != state[:64]:
            return {"unreadable": f"these {len(state)} bytes are no state of this FMU, or not the whole of one."}
        saved: dict[str, Any] = json.loads(state[64:])
        return saved
