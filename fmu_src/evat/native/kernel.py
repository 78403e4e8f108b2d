"""What does the compiled kernel know, and how is it run from Python? The only file that knows C."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cffi
import numpy as np

from evat.model import (
    Causality,
    Effect,
    EvatError,
    FloatArray,
    Law,
    ParameterError,
    SimulationError,
    Type,
    Variability,
    Variable,
    near_names,
    nearest,
)
from evat.native.compile import kernel_library_path, source_root
from evat.native.processor import instructions
from evat.units import to_si

LONG = 50_000  # samples of a run, from which it takes longer than a thread to start
TYPES: tuple[Type, ...] = ("real", "integer", "boolean", "choice")
CAUSALITIES: tuple[Causality, ...] = ("independent", "parameter", "calculated", "input", "output", "local")
VARIABILITIES: tuple[Variability, ...] = ("fixed", "tunable", "discrete", "continuous")


def library(lanes: int = 1) -> tuple[Any, Any]:
    """The compiled kernel with that many contacts in a block (1 or MANY_LANES): cffi's view of kernel.h, and the library itself."""
    return _loaded(lanes)


@functools.cache
def _loaded(lanes: int) -> tuple[Any, Any]:
    ffi = cffi.FFI()
    ffi.cdef(declarations(source_root() / "kernel" / name for name in ("tables.h", "kernel.h")).replace("[LANES]", f"[{lanes}]"))
    loaded = open_library(ffi, kernel_library_path(lanes, instructions()))
    if loaded.kernel_size() != ffi.sizeof("struct Contact"):
        raise EvatError(
            f"the compiled kernel does not fit its header: a contact has {loaded.kernel_size()} bytes there, "
            f"{ffi.sizeof('struct Contact')} here. Install evat again, which compiles the kernel."
        )
    return ffi, loaded


def open_library(ffi: Any, path: Path) -> Any:
    """A compiled library; EvatError where the system does not load it."""
    try:
        return ffi.dlopen(str(path))
    except OSError as error:
        raise EvatError(
            f"{path}: the compiled library cannot be loaded here ({error}). Install evat again, on a disk from which programs may run."
        ) from error


def declarations(headers: Iterable[Path]) -> str:
    """C headers as cffi reads them: without comments and preprocessor lines."""
    text = "".join(path.read_text(encoding="utf-8") for path in headers)
    return re.sub(r"^\s*#.*$", "", re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL), flags=re.MULTILINE)


def _text(pointer: Any) -> str:
    return cffi_text(library()[0], pointer)


def cffi_text(ffi: Any, pointer: Any) -> str:
    return ffi.string(pointer).decode() if pointer != ffi.NULL else ""


def _names(text: str) -> tuple[str, ...]:
    return tuple(filter(None, re.split(r",\s*", text)))


@functools.lru_cache(maxsize=1)
def variables() -> tuple[Variable, ...]:
    """Every quantity of the component, in the order of its value references.

    Returns
    -------
    tuple of Variable
        Each with name, unit, start, min, max, meaning, source, type and role.

    Raises
    ------
    EvatError
        Where the compiled kernel cannot be loaded.

    Examples
    --------
    >>> import evat
    >>> F_C = next(variable for variable in evat.variables() if variable.name == "F_C")
    >>> F_C.unit, F_C.min, F_C.max, F_C.meaning
    ('N', 1e-06, 1000000.0, 'Coulomb friction force')
    """
    ffi, loaded = library()
    rows = [loaded.kernel_variable(index) for index in range(loaded.kernel_variable_count())]
    return read_table(ffi, rows, loaded.kernel_derivative_of, loaded.kernel_bound_slack)


def read_table(
    ffi: Any, rows: Sequence[Any], derivative_of: Callable[[int], int], bound_slack: Callable[[int], float]
) -> tuple[Variable, ...]:
    """Every quantity of a compiled model, from the rows of its table, in the order of its value references."""
    table = []
    for index, row in enumerate(rows):
        choices: list[str] = []
        while row.choices != ffi.NULL and row.choices[len(choices)] != ffi.NULL:
            choices.append(cffi_text(ffi, row.choices[len(choices)]))
        table.append(
            Variable(
                name=cffi_text(ffi, row.name),
                unit=cffi_text(ffi, row.unit),
                display_unit=cffi_text(ffi, row.display_unit) or None,
                start=row.start,
                min=row.min,
                max=row.max,
                nominal=row.nominal or 1.0,
                meaning=cffi_text(ffi, row.meaning),
                source=cffi_text(ffi, row.source),
                type=TYPES[row.type],
                causality=CAUSALITIES[row.causality],
                variability=VARIABILITIES[row.variability],
                choices=tuple(choices),
                derivative_of=cffi_text(ffi, rows[of].name) if (of := derivative_of(index)) else None,
                neutral=row.neutral,
                required_with=_names(cffi_text(ffi, row.required_with)),
                slack=bound_slack(index),
                difference=bool(row.difference),
                reference=bool(row.reference),
                prior_sd=row.prior_sd,
                index=index,
            )
        )
    return tuple(table)


@functools.lru_cache(maxsize=1)
def by_name() -> Mapping[str, Variable]:
    return {variable.name: variable for variable in variables()}


def variable(name: str) -> Variable:
    """The variable of that name; ParameterError with the nearest names where there is none."""
    try:
        return by_name()[name]
    except KeyError:
        near = near_names(name, by_name())
        hint = f"did you mean {', '.join(near)}?" if near else "`evat info` lists all variables."
        raise ParameterError(f"there is no variable {name!r}; {hint}") from None


@functools.lru_cache(maxsize=1)
def laws() -> tuple[Law, ...]:
    """The friction laws, in the order of the choice friction_law.

    Returns
    -------
    tuple of Law
        Each with name, meaning, equation, source, and the variables that it alone has.

    Raises
    ------
    EvatError
        Where the compiled kernel cannot be loaded.

    Examples
    --------
    >>> import evat
    >>> [law.name for law in evat.laws()]
    ['coulomb', 'lugre', 'dahl', 'karnopp', 'bristle', 'reset_integrator', 'amontons']
    """
    ffi, loaded = library()
    table, at = [], loaded.BASE_COUNT
    for place, name in enumerate(variable("friction_law").choices):
        row = loaded.kernel_law(place)
        table.append(
            Law(
                name=name,
                meaning=_text(row.meaning),
                equation=_text(row.equation),
                source=_text(row.source),
                variables=variables()[at : at + row.count],
                reads=tuple(variable(each) for each in _names(_text(row.reads))),
                has_event=row.indicator != ffi.NULL,
            )
        )
        at += row.count
    return tuple(table)


@functools.lru_cache(maxsize=1)
def effects() -> tuple[Effect, ...]:
    """The switchable effects; each one's name is also its Boolean variable.

    Returns
    -------
    tuple of Effect
        Each with name, meaning, equation, source, signature, stage, parameters, rivals, special cases, the inputs without which it says
        nothing, and the kinematics it applies to.

    Raises
    ------
    EvatError
        Where the compiled kernel cannot be loaded.

    Examples
    --------
    >>> import evat
    >>> softening = next(effect for effect in evat.effects() if effect.name == "thermal_softening")
    >>> [variable.name for variable in softening.variables]
    ['thermal_softening.k_Q', 'thermal_softening.Q']
    """
    _, loaded = library()
    table = []
    for place in range(loaded.kernel_effect_count()):
        row, at = loaded.kernel_effect(place), loaded.kernel_effect_switch(place)
        own = variables()[at : at + row.count]
        table.append(
            Effect(
                name=own[0].name,
                meaning=own[0].meaning,
                equation=_text(row.equation),
                source=own[0].source,
                variables=own[1 : row.count - 2 * row.states],
                rivals=_names(_text(row.rivals)),
                special_cases=_names(_text(row.special_cases)),
                signature=_text(row.signature),
                family=_text(row.family),
                stage=_text(loaded.kernel_stage_name(row.stage)),
                needs=_names(_text(row.needs)),
                applies_to=_names(_text(row.applies_to)),
                states=own[row.count - 2 * row.states : row.count - row.states],
                unsteady=bool(row.unsteady),
                irreversible=bool(row.irreversible),
                keeps_mean=bool(row.keeps_mean),
                form_of_law=bool(row.form_of_law),
            )
        )
    return tuple(table)


@functools.lru_cache(maxsize=1)
def states() -> tuple[str, ...]:
    """Names of the continuous states."""
    _, loaded = library()
    return tuple(variables()[loaded.kernel_state(place)].name for place in range(loaded.kernel_state_count()))


@functools.lru_cache(maxsize=1)
def indicators() -> tuple[str, ...]:
    """Names of the event indicators."""
    _, loaded = library()
    return tuple(variables()[loaded.kernel_indicator(place)].name for place in range(loaded.INDICATORS))


def inputs() -> tuple[str, ...]:
    return tuple(v.name for v in variables() if v.causality == "input")


def outputs() -> tuple[str, ...]:
    return tuple(v.name for v in variables() if v.causality == "output")


def token() -> str:
    """Hash over all tables: the GUID / instantiation token of the FMUs."""
    ffi, loaded = library()
    text = ffi.new("char[39]")
    loaded.kernel_token(text)
    return _text(text)


def status_text(status: int) -> str:
    return _text(library()[1].kernel_status_text(status))


def check_values(values: Mapping[str, float | int | bool | str], on: Sequence[str] = ()) -> dict[str, float]:
    """Names and values as numbers that the component holds (SI), the switches of the effects `on` among them; texts may have units."""
    switches = {effect.name for effect in effects()}
    for name in on:
        if name not in switches:
            raise ParameterError(f"there is no effect {name!r}; {nearest(name, sorted(switches), len(switches))}")
    return {name: variable(name).check(value) for name, value in {**in_si(values), **dict.fromkeys(on, 1.0)}.items()}


def in_si(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values with each text that stands for a number, such as "20 m/min", as that number in SI; choices stay names."""
    return {name: _in_si(variable(name), value) if isinstance(value, str) else value for name, value in values.items()}


def _in_si(known: Variable, text: str) -> float | str:
    if known.type == "choice":
        return text
    if known.type == "boolean" and text.lower() in ("true", "false"):
        return float(text.lower() == "true")
    return to_si(text, known.unit, name=known.name)


def by_choice(values: Mapping[str, float]) -> dict[str, float | str | bool]:
    """Values with choices by their names and switches as yes or no: what FMUs and people take."""
    chosen: dict[str, float | str | bool] = {}
    for name, number in values.items():
        known = variable(name)
        chosen[name] = known.choices[int(number)] if known.type == "choice" else bool(number) if known.type == "boolean" else number
    return chosen


class Contact:
    """One contact, step by step: set values, start, advance, read. SI, choices by name or place.

    Parameters
    ----------
    values : mapping of str to float, int, bool or str
        Parameters and inputs by name; what is not named has its start value.
    on : sequence of str
        Names of the effects that are on.

    Raises
    ------
    ParameterError
        For a name or value that is not allowed.

    Examples
    --------
    >>> import evat
    >>> contact = evat.Contact({"kinematics": "external", "friction_law": "coulomb", "F_C": 3.0})
    >>> contact.start(0.0)
    >>> contact.set("slip_velocity", 0.1)  # m/s
    >>> contact.advance(1e-4)  # s, in as many internal steps as the tolerance asks for; how far it went
    0.0001
    >>> contact.get("friction_force")  # N
    3.0
    """

    def __init__(self, values: Mapping[str, float | int | bool | str] | None = None, on: Sequence[str] = ()) -> None:
        ffi, self._library = library()
        self._ffi = ffi
        self._contact = ffi.new("struct Contact *")
        self._taken = ffi.new("double *")
        self._library.kernel_reset(self._contact)
        for name, number in check_values(values or {}, on).items():
            self._done(self._library.kernel_set(self._contact, variable(name).index, 0, number), f"setting {name}")

    def _done(self, status: int, doing: str) -> None:
        if status != self._library.STATUS_OK:
            text = self._ffi.new("char[512]")
            self._library.kernel_explain(self._contact, status, text, 512)
            raise SimulationError(f"{doing} at t = {self.time:.9g} s: {_text(text)}.")

    @property
    def time(self) -> float:
        return float(self._contact.value[0][0])

    @time.setter
    def time(self, value: float) -> None:
        self._contact.value[0][0] = value

    @property
    def nbytes(self) -> int:
        """Memory of the contact [bytes]."""
        return int(self._ffi.sizeof("struct Contact"))

    def set(self, name: str, value: float | int | bool | str) -> None:
        """Set one parameter, input or state, in SI or as a text with a unit; ParameterError outside its bounds.

        An input that misses them by a hair is held on them.
        """
        known = variable(name)
        number = known.check(in_si({name: value})[name] if isinstance(value, str) else value)
        self._done(self._library.kernel_set(self._contact, known.index, 0, number), f"setting {name}")

    def get(self, name: str) -> float:
        return float(self._contact.value[variable(name).index][0])

    def values(self) -> FloatArray:
        """All values in the order of `variables()`, a copy."""
        count = len(variables())
        return np.frombuffer(self._ffi.buffer(self._contact.value), dtype=np.float64)[:count].copy()

    def start(self, time: float = 0.0) -> None:
        """Initialise at `time` [s]."""
        self._done(self._library.kernel_start(self._contact, time), "initialisation")

    def evaluate(self) -> None:
        """Outputs and derivatives from the time, states and inputs as they stand."""
        self._done(self._library.kernel_evaluate(self._contact), "evaluation")

    def advance(self, step: float, *, stop_at_events: bool = False) -> float:
        """Advance by `step` [s] with inputs held, outputs then fresh; returns how far it went (less only with stop_at_events)."""
        self._done(self._library.kernel_advance(self._contact, step, stop_at_events, self._taken), f"step of {step:g} s")
        self.evaluate()
        return float(self._taken[0])

    def event(self) -> None:
        """Act on an event at the present time (model exchange, or after a stop at an event)."""
        self._done(self._library.kernel_event(self._contact), "event")

    def indicators(self) -> FloatArray:
        """Event indicators at the present time, in the order of kernel.indicators()."""
        indicator = self._ffi.new("double[][1]", len(indicators()))
        self._library.kernel_indicators(self._contact, indicator)
        return np.array([row[0] for row in indicator])

    def next_event(self) -> float:
        """Time of the next averaging-window end [s], inf where there is none."""
        return float(self._library.kernel_next_event(self._contact))

    def derivative(self, unknown: str, known: str) -> float:
        """d unknown / d known (an input or a state) at the present point, SI."""
        quotient, asked = self._ffi.new("double *"), self._ffi.new("int *", variable(unknown).index)
        status = self._library.kernel_derivatives(self._contact, variable(known).index, 1, asked, quotient)
        self._done(status, f"derivative of {unknown}")
        return float(quotient[0])

    def copy(self) -> Contact:
        """An independent copy, in mid-cycle too."""
        twin = Contact()
        twin.restore(self.state())
        return twin

    def state(self) -> bytes:
        """Everything there is to this contact, as bytes."""
        return bytes(self._ffi.buffer(self._contact))

    def restore(self, state: bytes) -> None:
        if len(state) != self.nbytes:
            raise ParameterError(f"a contact's state has {self.nbytes} bytes, this has {len(state)}.")
        self._ffi.buffer(self._contact)[:] = state

    def warnings(self) -> tuple[str, ...]:
        """What was legal but noteworthy since the start, a line each."""
        lines = []
        text = self._ffi.new("char[512]")
        for bit in range(self._library.WARNING_COUNT):
            if self._contact.warnings >> bit & 1:
                self._library.kernel_explain_warning(self._contact, bit, text, 512)
                lines.append(_text(text))
        return tuple(lines)

    def run(self, times: FloatArray, columns: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
        """Follow a record: inputs linear between the samples.

        Parameters
        ----------
        times : sample times [s], shape (n,), increasing; the contact must have been started at times[0].
        columns : input name -> values at the times, shape (n,).
        names : the variables to record.

        Returns
        -------
        shape (n, len(names)).

        Raises
        ------
        ParameterError, where a sample is not finite or out of bounds or a column is no input; SimulationError, where the run breaks off.
        """
        ffi = self._ffi
        times = np.ascontiguousarray(times, dtype=np.float64)
        if times.ndim != 1 or times.size == 0 or not np.all(np.diff(times) > 0) or not np.all(np.isfinite(times)):
            raise ParameterError("sample times must be a row of finite, increasing numbers in s.")
        for name, column in columns.items():
            if variable(name).causality != "input":
                raise ParameterError(f"{name} is not an input; inputs are {', '.join(inputs())}.")
            if np.shape(column) != times.shape:
                raise ParameterError(f"{name} has {np.size(column)} samples, the clock has {times.size}.")
            check_column(variable(name), np.asarray(column, dtype=np.float64))
        table = np.ascontiguousarray(np.column_stack(list(columns.values())) if columns else np.empty((times.size, 0)), dtype=np.float64)
        recorded = np.empty((times.size, len(names)))
        places, wanted = (ffi.new("int[]", [variable(name).index for name in some]) for some in (columns, names))
        record, answer = ffi.new("struct Record *"), ffi.new("struct Yield *")
        record.count, record.times = times.size, ffi.from_buffer("double[]", times)
        record.input_count, record.input_index, record.inputs = len(columns), places, ffi.from_buffer("double[]", table)
        answer.output_count, answer.output_index, answer.rows = len(names), wanted, ffi.from_buffer("double[]", recorded)
        status = _interruptible(ffi, times.size, lambda stop: self._library.kernel_run_record(self._contact, record, answer, stop))
        self._done(status, f"sample {answer.samples_done} of {times.size}")
        return recorded


def _interruptible(ffi: Any, samples: int, follow: Callable[[Any], int]) -> int:
    """What `follow` gives, which a number that is not 0 tells to stop. A long one runs beside the first thread, which Ctrl-C reaches."""
    if samples < LONG:
        return follow(ffi.NULL)
    stop = ffi.new("int *")
    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(follow, stop)
        try:
            return waiting.result()
        except BaseException:
            stop[0] = 1
            raise


def check_column(known: Variable, column: FloatArray) -> None:
    bad = ~known.allows(column)
    if np.any(bad):
        row = int(np.argmax(bad))
        raise ParameterError(
            f"{known.name}, sample {row}: {column[row]:g} {known.unit}; allowed are finite values from {known.min:g} to {known.max:g}. "
            "Correct or cut the record; nothing is filled in."
        )


class ContactTables:
    """The component's tables: what it consists of."""

    variables: tuple[Variable, ...]
    effects: tuple[Effect, ...]

    def __init__(self) -> None:
        self.variables = variables()
        self.effects = effects()
