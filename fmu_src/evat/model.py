"""Which words do all parts of the project share? Variable, Effect, Trace, Model.

Imports nothing of ours, but what shows a result in a notebook, where that is asked for.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, Protocol, overload

import numpy as np
import numpy.typing as npt

FIRST_ITEM = 1  # FMI counts the items of an enumeration from here; the kernel counts the places of a choice from 0
Type = Literal["real", "integer", "boolean", "choice"]
Causality = Literal["independent", "parameter", "calculated", "input", "output", "local"]
Variability = Literal["fixed", "tunable", "discrete", "continuous"]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]


class EvatError(Exception):
    """Base of every error that this package raises on purpose; its text says what was asked, found, allowed, and what to do.

    Examples
    --------
    >>> import evat
    >>> try:
    ...     evat.parameter_sets.load("regularised/wood")
    ... except evat.EvatError as error:
    ...     print(type(error).__name__)
    ParameterError
    """


class ParameterError(EvatError):
    """A value, name or unit that a variable does not allow.

    Examples
    --------
    >>> import evat
    >>> try:
    ...     evat.simulate({"F_C": -1.0})
    ... except evat.ParameterError as error:
    ...     print(error)
    F_C = -1 N: allowed is 1e-06 to 1e+06 N.
    """


class SimulationError(EvatError):
    """A run that could not be carried to its end; the text says when it broke off, and why.

    Examples
    --------
    >>> import evat
    >>> contact = evat.Contact({"kinematics": "external"})
    >>> contact.start()
    >>> try:
    ...     contact.advance(-1e-3)
    ... except evat.SimulationError as error:
    ...     print(error)
    step of -0.001 s at t = 0 s: the step is not a number above 0 and up to 1e9 s.
    """


class BuildError(EvatError):
    """An FMU that could not be built.

    Examples
    --------
    >>> import evat
    >>> try:
    ...     evat.build_fmu(1, "EvatContact.fmu")
    ... except evat.BuildError as error:
    ...     print(error)
    FMI version 1: FMUs are built for version 2 or 3.
    """


class FmuError(EvatError):
    """An FMU that cannot be loaded, or is not what it was taken for.

    Examples
    --------
    >>> import evat
    >>> issubclass(evat.FmuError, evat.EvatError)  # what catches every error that this package raises on purpose
    True
    """


@dataclass(frozen=True, slots=True)
class Variable:
    """One quantity of a model: the seven facts (name, unit, start, min, max, meaning, source) and its role.

    `start`, `min` and `max` are in `unit`. A choice holds the place of its name in `choices`. `neutral` is for parameters of effects: with
    all of an effect's at their neutral values it changes nothing; nan where the value has no say in that. Above 0 it is also for shapes of
    a base law that nobody knows exactly: with that value it is the law as published. `required_with` are the kinematics with which an
    input must be given to whatever reads it (with others it is computed, or its start will do); empty: all. An input may be given outside
    its bounds by no more than `slack`: solvers and extrapolation miss a bound by as much. It then lies on the bound. A `difference` is one
    of two temperatures, to which no offset of a display unit is added. The value of a `reference` is a convention, at which other
    parameters are said: nothing can be measured of it. `prior_sd` is the standard deviation of an effect's parameter about `neutral` in
    ordinary rigs, 0 where nobody says.
    """

    name: str
    unit: str
    start: float
    min: float
    max: float
    meaning: str
    source: str
    type: Type = "real"
    causality: Causality = "parameter"
    variability: Variability = "tunable"
    nominal: float = 1.0
    display_unit: str | None = None
    choices: tuple[str, ...] = ()
    derivative_of: str | None = None
    neutral: float = math.nan
    required_with: tuple[str, ...] = ()
    slack: float = 0.0
    difference: bool = False
    reference: bool = False
    prior_sd: float = 0.0
    index: int = -1

    @overload
    def allows(self, number: float) -> bool: ...
    @overload
    def allows(self, number: FloatArray) -> BoolArray: ...
    def allows(self, number: float | FloatArray) -> bool | BoolArray:
        """Whether a number lies within the bounds, for an input but for the slack; not a number does not."""
        return (self.min - self.slack <= number) & (number <= self.max + self.slack)

    @property
    def items(self) -> dict[str, int]:
        """The choices, each with its number in an FMU."""
        return {choice: place for place, choice in enumerate(self.choices, FIRST_ITEM)}

    def check(self, value: float | int | bool | str) -> float:
        """The value as the number that the model is given; ParameterError where it is not one that this variable allows."""
        if isinstance(value, str):
            if value in self.choices:
                return float(self.choices.index(value))
            allowed = f"one of {', '.join(self.choices)}" if self.choices else f"a number in {self.unit}"
            near = near_names(value, self.choices)
            raise ParameterError(f"{self.name} = {value!r}: allowed is {allowed}{f'; did you mean {near[0]}?' if near else '.'}")
        try:
            number = float(value)
        except OverflowError:  # a whole number of hundreds of digits
            number = math.inf if value > 0 else -math.inf
        if not math.isfinite(number):
            raise ParameterError(f"{self.name} = {number}: a finite number in {self.unit} is needed.")
        if not self.allows(number):
            unit = "" if self.unit == "1" else f" {self.unit}"
            raise ParameterError(f"{self.name} = {number:g}{unit}: allowed is {self.min:g} to {self.max:g}{unit}.")
        if self.type != "real" and number != int(number):
            raise ParameterError(f"{self.name} = {number:g}: a whole number is needed.")
        return number


@dataclass(frozen=True, slots=True)
class Law:
    """A friction law, one of the choices of `friction_law`: `variables` are its own parameters; of the base table it `reads` parameters and
    inputs beside the slip velocity. One that has an event of its own jumps there, at times that hang on its parameters."""

    name: str
    meaning: str
    equation: str
    source: str
    variables: tuple[Variable, ...] = ()
    reads: tuple[Variable, ...] = ()
    has_event: bool = False


@dataclass(frozen=True, slots=True)
class Effect:
    """A switchable effect: `variables` are its own parameters, `states` its own states; without the inputs it `needs` it says nothing.
    Effects of one `family` (lag, load, thermal, ...) leave much the same in a record. Its `special_cases` are effects that it comes to
    where what it has besides is out of sight.

    It `applies_to` the kinematics named there, and to every kinematics in which an input named there is given; empty: to all. One that does
    not apply can be switched on all the same, and is no explanation of such a record: the work of a robot's joint has no run-out. One
    that is `unsteady` goes by the time or the way itself, so that means of steady states tell nothing of it; nor do they of one that
    `keeps_mean`, a filter or a delay. What one that is `irreversible` has changed stays so from recording to recording. One that is a
    `form_of_law` is what friction laws differ in among themselves, so that a little of it is no effect.
    """

    name: str
    meaning: str
    equation: str
    source: str
    variables: tuple[Variable, ...] = ()
    rivals: tuple[str, ...] = ()
    special_cases: tuple[str, ...] = ()
    signature: str = ""
    stage: str = ""
    needs: tuple[str, ...] = ()
    states: tuple[Variable, ...] = ()
    applies_to: tuple[str, ...] = ()
    family: str = ""
    unsteady: bool = False
    irreversible: bool = False
    keeps_mean: bool = False
    form_of_law: bool = False

    @property
    def physics(self) -> str:
        """What it is in the world, in plain words: its meaning without the word that says it is a switch."""
        return self.meaning.removeprefix("switch: ")

    def applies(self, kinematics: str, given: Collection[str] = ()) -> bool:
        """Whether it may happen in this kinematics to a contact of which these inputs are `given`."""
        return not self.applies_to or kinematics in self.applies_to or any(name in self.applies_to for name in given)


@dataclass(frozen=True, slots=True)
class Run:
    """What to drive a model with: sample times, the values of its inputs at them (linear in between), and what to bring back.

    Parameters
    ----------
    times : array of shape (n,)
        Sample times [s], increasing.
    inputs : mapping of str to array of shape (n,)
        Values of the inputs at the sample times, SI, by the model's names. `run_many` also takes shape (K, n).
    outputs : sequence of str
        The variables to record; without any a model gives all that it has, and `run_many` refuses.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> times = np.linspace(0, 1, 101)
    >>> run = evat.Run(times, {"slip_velocity": 0.02 * np.sin(2 * np.pi * times)}, ("friction_force",))
    >>> run.outputs
    ('friction_force',)
    """

    times: FloatArray
    inputs: Mapping[str, FloatArray] = field(default_factory=dict)
    outputs: Sequence[str] = ()

    def __post_init__(self) -> None:
        """Lists become arrays, one name becomes a sequence of one."""
        columns = {name: np.asarray(column, dtype=np.float64) for name, column in self.inputs.items()}
        object.__setattr__(self, "times", np.asarray(self.times, dtype=np.float64))
        object.__setattr__(self, "inputs", columns)
        if isinstance(self.outputs, str):
            object.__setattr__(self, "outputs", (self.outputs,))


class ShownAsTable:
    """What a prompt and a notebook show as a table."""

    __slots__ = ()

    def _table(self) -> Any:
        """An `evat.notebook.tables.ResultTable`."""
        raise NotImplementedError

    def __repr__(self) -> str:
        text: str = self._table().text()
        return text

    def _repr_html_(self) -> str:
        html: str = self._table().html()
        return html


class NamedArrays(ShownAsTable, Mapping[str, FloatArray]):
    """A result that is a mapping from names to arrays; where there is none of a name, near ones are told. KIND says what it is."""

    __slots__ = ()
    KIND: ClassVar[str] = "result"

    def _arrays(self) -> Mapping[str, FloatArray]:
        raise NotImplementedError

    def __getitem__(self, name: str) -> FloatArray:
        held = self._arrays()
        if name not in held:
            raise ParameterError(f"no column {name!r} in this {self.KIND}; {nearest(name, held)}")
        return held[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays())

    def __len__(self) -> int:
        return len(self._arrays())

    def __contains__(self, name: object) -> bool:
        return name in self._arrays()

    def get(self, name: str, default: Any = None) -> Any:
        return self._arrays().get(name, default)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trace(NamedArrays):
    """What came out of a run: a mapping from the name of each column to its values over time.

    A notebook shows it as a table; `plot()` draws it, `to_xarray()` and `to_pandas()` give what their libraries work with.

    Attributes
    ----------
    times : array of shape (n,)
        Sample times [s].
    columns : mapping of str to array of shape (n,)
        Each recorded variable, in the unit that `units` says.
    units : mapping of str to str
        The SI unit of each column.
    made_by : mapping of str
        How it was made: version, model, values, effects, warnings.

    Examples
    --------
    >>> import evat
    >>> trace = evat.simulate({"friction_law": "coulomb"}, cycles=1, samples_per_cycle=50)
    >>> trace["friction_force"].shape, trace.units["friction_force"]
    ((51,), 'N')
    >>> data = trace.to_xarray()
    >>> dict(data["friction_force"].sizes), data["friction_force"].attrs["units"]
    ({'time': 51}, 'N')
    >>> figure = trace.plot("friction_force", "slip_velocity_used")  # a matplotlib Figure
    """

    KIND: ClassVar[str] = "trace"
    times: FloatArray
    columns: Mapping[str, FloatArray]
    units: Mapping[str, str]
    made_by: Mapping[str, str | float | int | Mapping[str, float | str]]

    def _arrays(self) -> Mapping[str, FloatArray]:
        return self.columns

    def to_xarray(self) -> Any:
        """As an xarray.Dataset over `time` [s]; units in `attrs["units"]`, how it was made in the Dataset's attributes."""
        from evat.notebook.datasets import dataset

        return dataset(self.columns, ("time",), {"time": ("time", self.times, "s")}, self.units, self.made_by)

    def to_pandas(self) -> Any:
        """As a pandas.DataFrame over `time` [s]; units in `attrs["units"]`."""
        from evat.notebook.datasets import frame

        return frame(self.times, self.columns, self.units, self.made_by)

    def plot(self, *names: str, title: str = "") -> Any:
        """A matplotlib Figure with a panel for each of `names`; without any, of those that change, and it says what it leaves out."""
        from evat.notebook.panels import over_time

        return over_time(self.times, {name: self[name] for name in names or self.columns}, self.units, names, title)

    def _table(self) -> Any:
        from evat.notebook.tables import columns_table

        span = f", {self.times[0]:g} to {self.times[-1]:g} s" if self.times.size else ""
        title = f"Trace: {len(self.columns)} columns, {self.times.size} samples{span}"
        return columns_table(title, self.columns, self.units, (str(self.made_by.get("warnings", "")),))


@dataclass(frozen=True, slots=True)
class Rival:
    """Another base law that a model offers: `values` choose it, `variables` are those that it may read."""

    name: str
    values: Mapping[str, str]
    variables: tuple[Variable, ...]
    meaning: str = ""


class Tables(Protocol):
    """What a model consists of, without the means to run it."""

    variables: tuple[Variable, ...]
    effects: tuple[Effect, ...]


class Model(Tables, Protocol):
    """Anything that can be simulated, compared with a measurement and diagnosed.

    `identify` and `diagnose` know a model by these words alone, so that a model of your own can stand in: a class with these attributes
    and methods will do, nothing need be inherited. `ContactModel` and `FmuModel` are two.

    Values are SI, choices by name. Names, values and shapes that the tables do not allow raise ParameterError, as does an effect that lacks
    an input it needs; an input that does not change may stand in `values`. The same call gives the same bits.

    Attributes
    ----------
    variables : tuple of Variable
        Its quantities: name, unit, start, min, max, meaning, source, role.
    effects : tuple of Effect
        What can be switched on, each with its own variables.
    threads : int or None, optional
        How many of its runs may go on at a time, None for one per processor. Of a model that does not say so one goes on after the other.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> model: evat.Model = evat.ContactModel()
    >>> values = {"friction_law": "coulomb", "kinematics": "external", "F_C": 3.0, "slip_velocity": 0.1}
    >>> trace = model.simulate(evat.Run(np.array([0.0, 0.1]), outputs=("friction_force",)), (), values)
    >>> print(trace["friction_force"])
    [3. 3.]
    """

    @property
    def digest(self) -> str:
        """A hash by which a result says which model it was made with; of the contact, as of its FMUs, over its tables."""
        ...

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        """Drive the model through `run` with the effects `on` and the parameter `values` (SI); all outputs where `run` names none.

        The trace's `made_by["model"]` is the digest. SimulationError where the run breaks off.
        """
        ...

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """The same for K value sets, from values that are arrays of shape (K,): each output of shape (K, n), nan where a set fails.

        K = 1 where no value and no input is of several sets; `run` names at least one output.
        """
        ...

    def settled(self, names: Sequence[str], on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """Outputs `names` of K sets once conditions that do not change have settled (means over a cycle): (K,), nan as above."""
        ...

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        """Duration [s] of the model's own cycle of motion, nan where it has none."""
        ...

    def rival_laws(self, values: Mapping[str, float | str]) -> Sequence[Rival]:
        """Base laws that could stand in for the one that `values` choose."""
        ...

    def missing_inputs(self, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str]) -> Mapping[str, Sequence[str]]:
        """Inputs without which effects that are on say nothing, in neither `values` nor the columns `given`: input -> effects."""
        ...


def near_names(name: str, known: Iterable[str]) -> list[str]:
    """The known names that are nearest to one that is not: by its letters, whatever their case, or by its last part."""
    import difflib

    names = list(known)
    folded = {each.lower(): each for each in names}
    last = {each.rpartition(".")[2].lower(): each for each in names}
    typed = name.lower()
    near = [folded[typed]] if typed in folded else [folded[each] for each in difflib.get_close_matches(typed, folded, n=3)]
    return near or [last[each] for each in difflib.get_close_matches(typed.rpartition(".")[2], last, n=3)]


def nearest(name: str, known: Iterable[str], most: int = 40) -> str:
    """What an error says of a name that is not known: the nearest ones, or what there is where none is near."""
    names = list(known)
    if near := near_names(name, names):
        return f"did you mean {', '.join(near)}?"
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"there are {', '.join(names[:most])}{more}." if names else "there are none."


def hash_of(*parts: str | bytes) -> str:
    """32 hexadecimal digits; parts are told apart, so that ("ab", "c") and ("a", "bc") differ."""
    whole = hashlib.sha256()
    for part in parts:
        held = part.encode() if isinstance(part, str) else part
        whole.update(f"{len(held)}:".encode() + held)
    return whole.hexdigest()[:32]


def table_hash(tables: Tables) -> str:
    """Hash over the facts of all variables and effects, whatever their order."""
    return hash_of(*sorted(map(repr, tables.variables)), *sorted(map(repr, tables.effects)))
