"""How does a system answer to its parameters? A grid of runs on all cores or a dask cluster, a row of means for each."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from evat.files.writing import put, temporary
from evat.model import EvatError, FloatArray, NamedArrays, ParameterError
from evat.processes import process_pool
from evat.systems.couple import Inputs, Order, Values, means_of_last_half, plan, run_file
from evat.systems.model import System, SystemStopped, port
from evat.systems.values import Value, in_units, merged, of_work, seconds, unit, value, variable
from evat.units import to_si

MOST_RUNS = 100_000
STEPS_TO_OPEN = 20_000  # steps that take as long as it takes to load a system: 0.2 s, at some 10 us a step of evat_turning
FEW_STEPS = 120_000  # for more, two processes are worth their start, 0.7 s of processor time each
EXAMPLE = "for example 'spindle.speed_set=2:30:8', 'contact.amplitude_x=3 um:9 um:4' or 'contact=regularised/copper,regularised/al-6061'"
NOT_RUN = "not run: the sweep was stopped"
MAPPED = ("mean_principal_force", "mean_feed_force", "mean_contact_ratio")  # of a cut
RATIO = "speed_ratio"
RATIO_LABEL = "speed ratio HSR = cutting speed over the highest speed of the vibration"
SPEEDS = ("m/s", "rad/s")  # of which the speed ratio may be a measure
FOLLOWS = 0.01  # of the relative change of an axis


@dataclass(frozen=True, slots=True)
class SweepAxis:
    """What one axis of the grid changes: a label, its unit, and for each place a text and the values that it sets."""

    label: str
    unit: str
    texts: tuple[str, ...]
    values: tuple[Mapping[str, Mapping[str, Value]], ...]

    @property
    def numbers(self) -> FloatArray | None:
        """The places as numbers, None where they are names."""
        try:
            return np.array([float(text) for text in self.texts])
        except ValueError:
            return None


@dataclass(frozen=True, slots=True)
class Row:
    """One run: its place on every axis, what came out (the mean of each output over the steps of the last half), or why nothing did."""

    place: tuple[int, ...]
    means: Mapping[str, float]
    failure: str


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sweep(NamedArrays):
    """What came out of a sweep: a mapping from the name of each output to its means on the grid, an axis of the array for each axis swept.

    A notebook shows it as a table; `plot()` draws it, `to_xarray()` and `to_pandas()` give what their libraries work with.

    Attributes
    ----------
    axes : tuple of SweepAxis
        What was swept: `label`, `unit`, and the places as `texts` and, where they are numbers, as `numbers`.
    rows : tuple of Row
        Each run in the order of the grid: its `place`, its `means` over the last half, or its `failure`.
    units : mapping of str to str
        The SI unit of each output.
    beside : tuple of Row
        The same grid with other values beside it.
    system : str
        The name of what was run.

    Examples
    --------
    >>> import evat
    >>> swept = evat.sweep_system("stick_slip", {"drive.pid_gain": [2.0, 4.0]}, stop="10 ms")
    >>> swept["guideway.friction_force"].shape
    (2,)
    """

    axes: tuple[SweepAxis, ...]
    rows: tuple[Row, ...]
    units: Mapping[str, str]
    beside: tuple[Row, ...] = ()
    system: str = ""

    @property
    def failed(self) -> Mapping[tuple[int, ...], str]:
        """Why a run gave nothing, by its place on the grid."""
        return {row.place: row.failure for row in (*self.rows, *self.beside) if row.failure}

    def _grid(self, name: str, rows: Sequence[Row]) -> FloatArray:
        grid = np.full([len(each.texts) for each in self.axes], np.nan)
        for row in rows:
            grid[row.place] = row.means.get(name, np.nan)
        return grid

    def _arrays(self) -> Mapping[str, FloatArray]:
        return {name: self._grid(name, self.rows) for name in _shown(self.rows)}

    def to_xarray(self) -> Any:
        """As an xarray.Dataset over the axes; what was run beside the grid as `NAME beside`."""
        from evat.notebook.datasets import dataset

        labels = [each.label for each in self.axes]
        texts = {each.label: (each.label, np.array(each.texts) if each.numbers is None else each.numbers, each.unit) for each in self.axes}
        columns = dict(self._arrays())
        columns |= {f"{name} beside": self._grid(name, self.beside) for name in _shown(self.beside)}
        units = {**self.units, **{f"{name} beside": self.units.get(name, "") for name in _shown(self.beside)}}
        return dataset(columns, labels, texts, units, {"system": self.system, "gives": "means over the last half of each run"})

    def to_pandas(self) -> Any:
        """As a pandas.DataFrame, a line for each run."""
        return self.to_xarray().to_dataframe()

    def plot(self, *names: str) -> Any:
        """A matplotlib Figure: means over the first axis, a line for each place on the others. What stood beside the grid is dashed.

        Where the first axis is a speed that a shown speed ratio follows, over that. Without names it chooses, and says what is left out.
        """
        from evat.notebook.choice import chosen, left_out
        from evat.notebook.panels import label, over_axis, prefixed

        columns = {name: self[name] for name in names or self}
        told = [name for name in columns if name.rpartition(".")[2] in MAPPED]
        shown = list(names) or told or chosen({name: column.ravel() for name, column in columns.items()})
        first, numbers = self.axes[0], self.axes[0].numbers
        ratio = next((name for name in self if name.rpartition(".")[2] == RATIO), None)
        scale, shown_unit = (1.0, first.unit) if numbers is None else prefixed(numbers, first.unit)
        abscissa = np.arange(len(first.texts), dtype=np.float64) if numbers is None else scale * numbers
        rests = list(itertools.product(*(range(len(each.texts)) for each in self.axes[1:])))
        if ratio is not None and (first.unit not in SPEEDS or not all(_follows(_line(self[ratio], rest), numbers) for rest in rests)):
            ratio = None

        def lines(name: str, rows: Sequence[Row]) -> dict[str, tuple[FloatArray, FloatArray]]:
            made = {}
            for rest in rests:
                over = abscissa if ratio is None else _line(self[ratio], rest)
                if ratio is not None and rows is self.beside:
                    own = _line(self._grid(ratio, rows), rest)
                    over = np.where(np.isfinite(own) & (own != 0), own, over)  # without vibration there is none to speak of
                words = ", ".join(each.texts[place] for each, place in zip(self.axes[1:], rest, strict=True))
                order = np.argsort(over)
                made[words] = over[order], _line(self._grid(name, rows), rest)[order]
            return made

        words = label(first.label, shown_unit).replace("\n", " ") if ratio is None else RATIO_LABEL
        ticks = first.texts if numbers is None and ratio is None else None
        dashed = {name: lines(name, self.beside) for name in shown} if self.beside else {}
        note = "" if names else left_out(columns, shown)
        return over_axis({name: lines(name, self.rows) for name in shown}, self.units, words, ticks, dashed, note)

    def _table(self) -> Any:
        from evat.notebook.tables import columns_table

        title = f"Sweep of {self.system} over {', '.join(f'{each.label} ({len(each.texts)})' for each in self.axes)}"
        runs = len(self.rows) + len(self.beside)
        failed = [f"{len(self.failed)} of {runs} runs failed; the first: {why}" for why in list(self.failed.values())[:1]]
        return columns_table(title, {name: self[name].ravel() for name in self}, self.units, failed)


def _line(grid: FloatArray, rest: tuple[int, ...]) -> FloatArray:
    """The numbers along the first axis at one place on the others."""
    line: FloatArray = np.moveaxis(grid, 0, -1)[rest]
    return line


def _follows(line: FloatArray, numbers: FloatArray | None) -> bool:
    """Whether a line rises or falls at every step along an axis, by no small share of what the axis does: a Stribeck velocity moves a
    cutting speed, too, by the force that brakes the spindle."""
    ran = np.isfinite(line)
    if numbers is None or not ran.any():
        return False
    order = np.argsort(numbers[ran])
    shares = [np.diff(each[ran][order]) / max(np.abs(each[ran]).max(), np.finfo(float).tiny) for each in (line, numbers)]
    return bool(np.all(shares[0] > FOLLOWS * shares[1]) or np.all(-shares[0] > FOLLOWS * shares[1]))


def axis(system: System, text: str) -> SweepAxis:
    """An axis from NAME[,NAME...]=FIRST:LAST:COUNT, NAME=VALUE,VALUE,... or COMPONENT=SET,SET,... (parameter sets of the contact)."""
    names, equals, places = text.partition("=")
    if not equals or not places.strip():
        raise ParameterError(f"--over {text!r}: write NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE; {EXAMPLE}.")
    wanted = [part.strip() for part in places.split(",")]
    if "." in names and ":" in places:
        ports = [port(name.strip(), f"--over {text!r}") for name in names.split(",")]
        units = {unit(system, at): ".".join(at) for at in ports}
        if len(units) > 1:
            told = ", ".join(f"{name} is in {each}" for each, name in units.items())
            raise ParameterError(f"--over {text!r}: {told}; a range is of one unit. Give an axis to each.")
        wanted = _range(text, places, next(iter(units)))
    return axis_of(system, names, wanted, f"--over {text!r}")


def axis_of(system: System, names: str, wanted: Sequence[float | str], where: str) -> SweepAxis:
    """An axis of these places: of the variables `names`, joined by commas, or sets of a component; a text may have a unit."""
    if not wanted:
        raise ParameterError(f"{where}: it has no places; {EXAMPLE}.")
    if "." not in names:
        sets = tuple(str(name) for name in wanted)
        if names.strip() not in system.components:
            raise ParameterError(f"{where}: there is no component {names.strip()!r}; {EXAMPLE}.")
        return SweepAxis(names.strip(), "1", sets, tuple(of_work(system, names.strip(), name) for name in sets))
    ports = [port(name.strip(), where) for name in names.split(",")]
    kinds = {variable(system, at).type for at in ports}
    rows = [[value(system, at, given if isinstance(given, str) else repr(float(given))) for at in ports] for given in wanted]
    sets_of = tuple(merged(*({at[0]: {at[1]: one}} for at, one in zip(ports, row, strict=True))) for row in rows)
    texts = tuple(repr(float(row[0])) if kinds <= {"Real", "Float64"} else str(row[0]) for row in rows)
    return SweepAxis(names.partition(",")[0].strip(), unit(system, ports[0]), texts, sets_of)


def check_axes(axes: Sequence[SweepAxis]) -> None:
    """ParameterError where one axis hides another, or a variable that it names: later values stand over earlier ones. A parameter set may
    be varied by an axis after it, as long as that leaves some of it."""
    names = [{(component, name) for place in each.values for component, values in place.items() for name in values} for each in axes]
    for (earlier, hidden), (later, over) in itertools.combinations(zip(axes, names, strict=True), 2):
        if hidden <= over:
            raise ParameterError(f"the axis {later.label} sets all that {earlier.label} does, and would hide it: sweep over each once.")
        if "." in earlier.label and (both := sorted(map(".".join, hidden & over))):
            raise ParameterError(
                f"the axis {later.label} sets {', '.join(both)}, too, and would hide what {earlier.label} sets there: sweep over each once."
            )


def check_beside_axes(axes: Sequence[SweepAxis], values: Values) -> None:
    """ParameterError where an axis hides one of the values that stand at all points."""
    for at in ((component, name) for component, of_component in values.items() for name in of_component):
        for each in axes:
            if all(at[1] in place.get(at[0], {}) for place in each.values):
                raise ParameterError(
                    f"{'.'.join(at)} is swept over, as {each.label}; a value for it would change nothing. Leave it out, or give it with "
                    "--beside, which runs the grid once more with it."
                )


def _range(text: str, places: str, unit: str) -> list[str]:
    """The places of FIRST:LAST:COUNT in the SI unit; a unit behind LAST alone counts for both."""
    parts = [part.strip() for part in places.split(":")]
    wrong = f"--over {text!r}: FIRST:LAST:COUNT with a count from 1 to {MOST_RUNS} is needed; {EXAMPLE}."
    if len(parts) != 3 or not parts[2].isdecimal() or not 1 <= int(parts[2]) <= MOST_RUNS:
        raise ParameterError(wrong)
    with suppress(ValueError):
        float(parts[0])
        parts[0] = f"{parts[0]} {parts[1].lstrip('+-.0123456789eE').strip()}".strip()
    try:
        first, last = (to_si(part, unit, name="--over " + text.partition("=")[0]) for part in parts[:2])
    except ParameterError as error:
        raise ParameterError(f"{wrong} {error}") from None
    return [repr(float(number)) for number in np.linspace(first, last, int(parts[2]))]


def _point(archive: bytes, values: Values, wishes: Mapping[str, Any]) -> tuple[dict[str, float], str]:
    """One run, in whatever process: means of the last half."""
    with temporary() as folder:
        path = put(folder / "system.ssp", archive)
        try:
            trace, _ = run_file(path, folder / "system", values, **wishes)
        except SystemStopped as stopped:
            return {}, str(stopped)
        except EvatError as error:
            return {}, str(error)
    return dict(means_of_last_half(trace)), ""


def sweep(
    path: Path,
    axes: Sequence[SweepAxis],
    values: Values,
    wishes: Mapping[str, Any],
    done: Callable[[float], None] = lambda _: None,
    cluster: Any = None,
    beside: Values | None = None,
    stopped: Callable[[], None] | None = None,
    workers: int | None = None,
) -> list[Row]:
    """Run the system at every point of the grid; rows in the order of the grid, whatever the order in which they finish.

    beside : values that stand whatever the point says.
    workers : processes at most; without it as many as there are processors.
    stopped : told of Ctrl-C, after which the rows that are done come back; without it KeyboardInterrupt goes on its way.
    cluster : evat.identification.searching.cluster.Cluster whose workers run them; None: the cores of this machine.
    """
    check_axes(axes)
    places = list(itertools.product(*(range(len(each.texts)) for each in axes)))
    if len(places) > MOST_RUNS:
        raise ParameterError(f"the grid has {len(places)} points; at most {MOST_RUNS} are run.")
    archive = path.read_bytes()
    points = [merged(values, *(each.values[place] for each, place in zip(axes, at, strict=True)), beside or {}) for at in places]
    rows: dict[int, Row] = {}
    try:
        each = partial(_here, workers or os.cpu_count() or 1) if cluster is None else cluster.each
        for number, (means, failure) in each(_point, archive, [(point, dict(wishes)) for point in points]):
            rows[number] = Row(places[number], means, failure)
            done(len(rows) / len(places))
    except KeyboardInterrupt:
        if stopped is None:
            raise
        stopped()
    return [rows.get(number, Row(places[number], {}, NOT_RUN)) for number in range(len(places))]


def sweep_system(
    ssp: str | PathLike[str],
    over: Mapping[str, Sequence[float | str]],
    values: Mapping[str, Mapping[str, Value]] | None = None,
    *,
    sets: Mapping[str, str] | None = None,
    beside: Mapping[str, Mapping[str, Value]] | None = None,
    step: float | str | None = None,
    stop: float | str | None = None,
    order: Order = "gauss-seidel",
    inputs: Inputs = "linear",
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Run a system of FMUs over a grid of its parameters, on all cores.

    Parameters
    ----------
    ssp : path
        The .ssp file, or one of our systems by its name, such as "stick_slip".
    over : mapping of str to sequence
        An axis of the grid each: "component.variable" with its values, in the unit of the FMU (ours: SI) or as texts with units, or
        "component" with names of parameter sets. Several names joined by commas get the same values.
    values : mapping of str to mapping of str to float, str or bool, optional
        For each component the values of its variables at all points; texts may have units.
    sets : mapping of str to str, optional
        For each component a parameter set of the contact by name, or an .ssv file; `values` come over it.
    beside : mapping of str to mapping of str to float, str or bool, optional
        The grid once more with these values, whatever the axes say: dashed in the picture.
    step : float or str, optional
        Communication step, in s or with a unit; without it the system's own.
    stop : float or str, optional
        Stop time, in s or with a unit; without it the system's own.
    order : "gauss-seidel" or "jacobi"
        One component after the other, or all from the same values.
    inputs : "linear" or "constant"
        How inputs go on within a step whose end is not known yet.
    progress : callable, optional
        Told the share that is done.

    Returns
    -------
    Sweep
        The mean of each output over the last half of each run, on the grid; nan where a run has failed, and `failed` says why.

    Raises
    ------
    SspError
        Where the system cannot be read, or has no such component or variable.
    ParameterError
        For a value, step or grid that is not allowed.

    Examples
    --------
    >>> import evat
    >>> swept = evat.sweep_system("stick_slip", {"path.speed": ["0.05 m/s", "0.1 m/s"]}, stop="20 ms")
    >>> swept.to_xarray()["guideway.friction_force"].sizes
    Frozen({'path.speed': 2})
    """
    from evat.systems.ours import archive_of
    from evat.systems.ssp.read import read

    with archive_of(ssp) as path, temporary() as folder:
        system = read(path, folder)
        axes = tuple(axis_of(system, names, wanted, f"over {names!r}") for names, wanted in over.items())
        if not axes:
            raise ParameterError(f"over is empty: name at least one axis; {EXAMPLE}.")
        of_sets = [of_work(system, name, which) for name, which in (sets or {}).items()]
        own = in_units(system, values or {})
        check_beside_axes(axes, own)
        held = merged(*of_sets, own)
        wishes = {"step": seconds(step, "step"), "stop": seconds(stop, "stop"), "order": order, "inputs": inputs}
        steps = plan(system, **wishes).count  # type: ignore[arg-type]
        workers = worth(math.prod(len(each.texts) for each in axes), steps)
        grids: list[Values | None] = [None] if beside is None else [None, in_units(system, beside)]
        told = progress or (lambda _: None)
        rows, *again = [
            sweep(path, axes, held, wishes, lambda done, n=n: told((n + done) / len(grids)), beside=grid, workers=workers)  # type: ignore[misc]
            for n, grid in enumerate(grids)
        ]
    return Sweep(axes, tuple(rows), units_of(system), tuple(again[0]) if again else (), system.name)


def units_of(system: System) -> dict[str, str]:
    """The unit of everything that the components show, by "component.variable"."""
    return {f"{name}.{c.name}": c.unit for name, component in system.components.items() for c in component.connectors.values()}


def worth(points: int, steps: int) -> int | None:
    """Processes that so many runs of so many communication steps are worth, None as many as there are: each takes long to start."""
    return 1 if points * (STEPS_TO_OPEN + steps) <= FEW_STEPS else None


def _here(most: int, function: Callable[..., Any], archive: bytes, points: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
    """Each point on a core of its own: processes, since a run in Python keeps its interpreter busy. None is left behind."""
    workers = max(1, min(most, len(points)))
    if workers == 1:
        yield from ((number, function(archive, *point)) for number, point in enumerate(points))
        return
    with process_pool(workers, "spawn") as pool:
        waiting = {pool.submit(function, archive, *point): number for number, point in enumerate(points)}
        for future in as_completed(waiting):
            yield waiting[future], future.result()


def columns(axes: Sequence[SweepAxis], rows: Sequence[Row], units: Mapping[str, str], beside: Sequence[Row] = ()) -> dict[str, Any]:
    """The rows as columns of a table, headers with units; what stood beside them, at the same places, in columns of its own."""
    table: dict[str, Any] = {}
    for number, each in enumerate(axes):
        numbers, texts = each.numbers, each.texts
        header = each.label if numbers is None else f"{each.label} [{each.unit}]"
        table[header] = [texts[row.place[number]] for row in rows] if numbers is None else numbers[[row.place[number] for row in rows]]
    for name in _shown(rows):
        table[f"{name} [{units[name]}]"] = np.array([row.means.get(name, np.nan) for row in rows])
    for name in _shown(beside):
        table[f"{name} beside [{units[name]}]"] = np.array([row.means.get(name, np.nan) for row in beside])
    table["failure"] = [row.failure for row in rows]
    if beside:
        table["failure beside"] = [row.failure for row in beside]
    return table


def _shown(rows: Iterable[Row]) -> list[str]:
    return next((list(row.means) for row in rows if row.means), [])
