"""How do many value sets run at once? Blocks of lanes that run side by side in the kernel, threads over the blocks.

A set's answer does not depend on its neighbours, on the number of threads or on their order: to the last bit.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from evat.model import FloatArray, NamedArrays, ParameterError, Run, SimulationError, nearest
from evat.native import kernel
from evat.native.compile import MANY_LANES
from evat.required_inputs import AMPLITUDES, check_inputs_of_law, check_required_inputs
from evat.threads import kept_threads

Give = Literal["rows", "sums"]
LINE = 64  # bytes
FEWEST = 4  # sets that are worth a block; fewer run one by one
MOST_BYTES = 8e9  # of rows in one answer; sums fit any number of sets


class Cancelled(SimulationError):
    """The caller asked to stop; what was done is thrown away."""


@dataclass(frozen=True, eq=False, repr=False)
class Batch(NamedArrays):
    """What came out of K sets: a mapping from the name of each output to its `rows`, or its `sums` where these were asked for.

    A notebook shows it as a table; `plot()` draws it, `to_xarray()` and `to_pandas()` give what their libraries work with.

    Attributes
    ----------
    times : array of shape (n,)
        Times [s] of the rows.
    count : int
        How many sets there were, K.
    rows : mapping of str to array of shape (K, n)
        Each output, nan where a set has failed.
    sums, squares : mapping of str to array of shape (K,)
        Sums over the kept samples, and of the squared distance from the data.
    counts : mapping of str to int
        The number of data in each of `squares`.
    failed : mapping of int to str
        What ended set k.
    varied : mapping of str to array of shape (K,)
        What differed from set to set.
    units : mapping of str to str
        The SI unit of each output and of each of `varied`.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> run = evat.Run(np.linspace(0, 1, 11), {"slip_velocity": np.full(11, 0.1)}, ("friction_force",))
    >>> batch = evat.run_many(run, {"kinematics": "external", "friction_law": "coulomb", "F_C": np.array([5.0, 10.0])})
    >>> data = batch.to_xarray()
    >>> dict(data["friction_force"].sizes), data["F_C"].values
    ({'set': 2, 'time': 11}, array([ 5., 10.]))
    """

    times: FloatArray
    count: int
    rows: Mapping[str, FloatArray] = field(default_factory=dict)
    sums: Mapping[str, FloatArray] = field(default_factory=dict)
    squares: Mapping[str, FloatArray] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    failed: Mapping[int, str] = field(default_factory=dict)
    varied: Mapping[str, FloatArray] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    def _arrays(self) -> Mapping[str, FloatArray]:
        return self.rows or self.sums

    def to_xarray(self) -> Any:
        """As an xarray.Dataset over `set` and `time` [s], what differed from set to set as coordinates; `NAME_squares` beside NAME."""
        from evat.notebook.datasets import dataset

        columns = {**self._arrays(), **{f"{name}_squares": column for name, column in self.squares.items()}}
        failures = {"failed": ("set", np.array([self.failed.get(place, "") for place in range(self.count)]), "")} if self.failed else {}
        coordinates = {
            "set": ("set", np.arange(self.count), ""),
            **({"time": ("time", self.times, "s")} if self.rows else {}),
            **{name: ("set", column, self.units.get(name, "")) for name, column in self.varied.items()},
            **failures,
        }
        return dataset(columns, ("set", "time"), coordinates, self.units, {"gives": "rows" if self.rows else "sums over the samples"})

    def to_pandas(self) -> Any:
        """As a pandas.DataFrame, a line for each set and time; without rows for each set."""
        return self.to_xarray().to_dataframe()

    def plot(self, *names: str, over: str = "") -> Any:
        """A matplotlib Figure with a panel for each output: rows over time, sums over what differed, of several the one named by `over`."""
        from evat.notebook.panels import label, over_axis, over_time

        columns = {name: self[name] for name in names or self._arrays()}
        if self.rows:
            return over_time(self.times, columns, self.units, tuple(columns))
        over = over or next(iter(self.varied), "")
        if over and over not in self.varied:
            raise ParameterError(f"{over!r} did not differ from set to set; {nearest(over, self.varied)}")
        places = self.varied[over] if over else np.arange(self.count, dtype=np.float64)
        order = np.argsort(places)
        lines = {f"sum of {name}": {"": (places[order], column[order])} for name, column in columns.items()}
        axis = label(over, self.units.get(over, "")) if over else "set"
        return over_axis(lines, {f"sum of {name}": self.units.get(name, "") for name in columns}, axis)

    def _table(self) -> Any:
        from evat.notebook.tables import columns_table

        what = "rows over time" if self.rows else "sums over the samples"
        title = f"Batch: {self.count} sets, {what}"
        failed = f"{len(self.failed)} sets failed; the first: {next(iter(self.failed.values()))}" if self.failed else ""
        columns = {**self.varied, **{name: column.ravel() for name, column in self._arrays().items()}}
        return columns_table(title, columns, self.units, (failed,))


@dataclass(frozen=True)
class _Plan:
    """What all blocks have in common: the clock with the samples that are kept, columns, outputs, data, and values by index."""

    times: FloatArray
    keep: np.ndarray[Any, np.dtype[np.uint8]]
    inputs: tuple[int, ...]
    shared: FloatArray
    each: FloatArray | None
    outputs: tuple[int, ...]
    data: FloatArray | None
    constants: Mapping[int, float]
    columns: Mapping[int, FloatArray]
    give: Give
    most_steps: float
    one_by_one: bool


def value_sets(
    values: Mapping[str, float | str | FloatArray], on: Sequence[str], run: Run
) -> tuple[int, dict[int, float], dict[int, FloatArray]]:
    """How many sets K there are, what they share, and what each has of its own (K,), by index; checked.

    ParameterError for names and values that the tables do not allow, and for sets that are not equally many.
    """
    single = {name: value for name, value in values.items() if np.ndim(value) == 0}
    constants = {kernel.variable(name).index: number for name, number in kernel.check_values(single, on).items()}  # type: ignore[arg-type]
    columns, lengths = {}, {name: np.shape(column)[0] for name, column in run.inputs.items() if np.ndim(column) == 2}
    for name, value in values.items():
        if np.ndim(value) == 0:
            continue
        known, column = kernel.variable(name), np.asarray(value, dtype=np.float64)
        if column.ndim != 1:
            raise ParameterError(f"{name}: one number for each set is needed, this has the shape {column.shape}.")
        for bad in column[~known.allows(column)][:1]:
            known.check(float(bad))
        if known.type != "real":
            for some in np.unique(column):
                known.check(float(some))
        columns[known.index], lengths[name] = column, column.size
    if len(set(lengths.values())) > 1:
        raise ParameterError(f"values vary over different numbers of sets: {', '.join(f'{name} has {n}' for name, n in lengths.items())}.")
    return next(iter(lengths.values()), 1), constants, columns


def _clock(run: Run, at: FloatArray | None) -> tuple[FloatArray, np.ndarray[Any, np.dtype[np.uint8]]]:
    """The samples to pass through, and which of them are kept."""
    times = np.ascontiguousarray(run.times, dtype=np.float64)
    wanted = times if at is None else np.ascontiguousarray(at, dtype=np.float64)
    for clock, what in ((times, "sample times"), (wanted, "times at which outputs are wanted")):
        if clock.ndim != 1 or clock.size == 0 or not np.all(np.isfinite(clock)) or not np.all(np.diff(clock) > 0):
            raise ParameterError(f"{what} must be a row of finite, increasing numbers in s.")
    if wanted[0] < times[0] or wanted[-1] > times[-1]:
        raise ParameterError(
            f"outputs are wanted from {wanted[0]:g} to {wanted[-1]:g} s, the run goes from {times[0]:g} to {times[-1]:g} s; ask for times "
            "within the run."
        )
    if at is None:  # most runs, and the merge costs as much as a short one
        return times, np.ones(times.size, dtype=np.uint8)
    both = np.union1d(times, wanted)
    return both, np.isin(both, wanted).astype(np.uint8)


def _columns(run: Run, clock: FloatArray, count: int) -> tuple[tuple[int, ...], FloatArray, FloatArray | None]:
    """Inputs on the clock: (n, inputs) where all sets share them, (K, n, inputs) where some have their own."""
    indices, columns = [], []
    for name, column in run.inputs.items():
        known, given = kernel.variable(name), np.asarray(column, dtype=np.float64)
        if known.causality != "input":
            raise ParameterError(f"{name} is not an input; inputs are {', '.join(kernel.inputs())}.")
        if given.shape not in (run.times.shape, (count, run.times.size)):
            raise ParameterError(f"{name} has the shape {given.shape}; {run.times.shape} or {(count, run.times.size)} is needed.")
        for one in np.atleast_2d(given):
            kernel.check_column(known, one)
        on_clock = [np.interp(clock, run.times, one) for one in np.atleast_2d(given)]
        indices.append(known.index)
        columns.append(np.array(on_clock) if given.ndim == 2 else on_clock[0])
    if all(column.ndim == 1 for column in columns):
        return tuple(indices), np.ascontiguousarray(np.column_stack(columns)) if columns else np.empty((clock.size, 0)), None
    return (
        tuple(indices),
        np.empty((clock.size, 0)),
        np.stack([np.broadcast_to(column, (count, clock.size)) for column in columns], axis=-1),
    )


def _search_apart(constants: Mapping[int, float], on: Sequence[str]) -> bool:
    """Whether the sets search for periodic starts of a tool that their forces move, or whose motion comes through a gap: beside each other
    all go on for as long as the longest search, in twice the time that each takes alone, and begin anew where one is led astray."""
    start = kernel.variable("initial_state")
    searches = constants.get(start.index) == start.choices.index("periodic")
    return searches and any(effect.states and effect.stage in ("path", "engagement") for effect in kernel.effects() if effect.name in on)


def _blocks(count: int, columns: Mapping[int, FloatArray], lanes: int) -> Iterator[np.ndarray[Any, np.dtype[np.intp]]]:
    """Places of the sets that run side by side: those that agree in what is fixed, and in whether the tool vibrates, since only then are
    there cycles that may be skipped."""
    variables = kernel.variables()
    fixed = [column for index, column in columns.items() if variables[index].variability == "fixed"]
    fixed += [column != 0 for index, column in columns.items() if variables[index].name in AMPLITUDES]
    groups = np.unique(np.column_stack(fixed), axis=0, return_inverse=True)[1].ravel() if fixed else np.zeros(count, dtype=np.intp)
    for group in np.unique(groups):
        places = np.flatnonzero(groups == group)
        for first in range(0, places.size, lanes):
            yield places[first : first + lanes]


class _Room(threading.local):
    """One thread's contacts, used again from block to block and call to call: fresh memory costs as much as a hundred samples.

    They begin on a line of the cache: wide vectors that lie across two cost twice.
    """

    def __init__(self) -> None:
        self.blocks: dict[tuple[Any, int], Any] = {}
        self.bytes: list[Any] = []

    def block(self, ffi: Any, lanes: int) -> Any:
        if (ffi, lanes) not in self.blocks:
            self.bytes.append(ffi.new("char[]", ffi.sizeof("struct Contact") + LINE))
            begin = int(ffi.cast("uintptr_t", self.bytes[-1]))
            self.blocks[ffi, lanes] = ffi.cast("struct Contact *", begin + -begin % LINE)
        return self.blocks[ffi, lanes]


_room = _Room()


def _follow(plan: _Plan, places: np.ndarray[Any, np.dtype[np.intp]], lanes: int, stop: Any) -> tuple[int, dict[str, FloatArray]]:
    """One block through the kernel: its status, and what it gives for each set of the block."""
    ffi, loaded = kernel.library(lanes)
    block, record, answer = _room.block(ffi, lanes), ffi.new("struct Record *"), ffi.new("struct Yield *")
    filled = np.resize(places, lanes)  # idle lanes repeat a set
    loaded.kernel_reset(block)
    held = np.frombuffer(ffi.buffer(block.value), dtype=np.float64).reshape(-1, lanes)
    for index, value in plan.constants.items():
        held[index] = value
    for index, column in plan.columns.items():
        held[index] = column[filled]
    table = plan.shared if plan.each is None else np.ascontiguousarray(np.moveaxis(plan.each[filled], 0, -1))
    for place, index in enumerate(plan.inputs):
        held[index] = table[0, place]
    for index in {*plan.constants, *plan.columns, *plan.inputs} & set(range(loaded.INPUT_FIRST, loaded.INPUT_END)):
        for lane in range(lanes):  # one that misses its bounds by a hair is held on them
            loaded.kernel_set(block, index, lane, held[index, lane])
    status = loaded.kernel_start(block, plan.times[0])
    if status != loaded.STATUS_OK:
        return status, {}
    rows_count, width = int(plan.keep.sum()), len(plan.outputs)
    arrays = {"rows": np.empty((rows_count, width, lanes))} if plan.give == "rows" else {"sums": np.zeros((width, lanes))}
    record.count, record.times, record.keep = (
        plan.times.size,
        *map(ffi.from_buffer, ("double[]", "unsigned char[]"), (plan.times, plan.keep)),
    )
    inputs, outputs = ffi.new("int[]", list(plan.inputs)), ffi.new("int[]", list(plan.outputs))
    record.input_count, record.input_index, record.inputs = len(plan.inputs), inputs, ffi.from_buffer("double[]", table)
    record.per_lane, record.most_steps = plan.each is not None, plan.most_steps
    answer.output_count, answer.output_index = width, outputs
    for name, array in arrays.items():
        setattr(answer, name, ffi.from_buffer("double[]", array))
    if plan.data is not None:
        arrays["squares"] = np.zeros((width, lanes))
        answer.squares, answer.data = ffi.from_buffer("double[]", arrays["squares"]), ffi.from_buffer("double[]", plan.data)
    status = loaded.kernel_run_record(block, record, answer, stop)
    return status, {name: np.moveaxis(array, -1, 0)[: places.size] for name, array in arrays.items()}


def run_many(
    run: Run,
    values: Mapping[str, float | str | FloatArray],
    on: Sequence[str] = (),
    *,
    at: FloatArray | None = None,
    give: Give = "rows",
    data: Mapping[str, FloatArray] | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    most_steps: float = 0.0,
) -> Batch:
    """Run K value sets over one input, or one set over K inputs, or both.

    Parameters
    ----------
    run : Run
        Sample times [s] of shape (n,); inputs of shape (n,) for all sets or (K, n), linear between the samples; the outputs wanted.
    values : mapping of str to float, str or array of shape (K,)
        SI; a number, a text with a unit or a choice's name for all sets, an array for a value of each.
    on : sequence of str
        Effects that are on in all sets.
    at : array of shape (m,), optional
        Times [s] at which outputs are wanted, such as the clock of a slow sensor; without it the sample times.
    give : "rows" or "sums"
        "rows" for whole traces, "sums" for the sum of each output over the kept samples: then any number of sets fits into memory.
    data : mapping of str to array of shape (m,), optional
        Measured values of outputs at the kept times, nan where there is none: also gives squares of the distance.
    threads : int, optional
        How many; without it as many as there are processors. The answer does not depend on it.
    progress : callable, optional
        Told the share that is done.
    cancelled : callable, optional
        Asked about ten times a second whether to stop.
    most_steps : float
        Internal steps of a set over the whole run, beyond which it fails; 0 for as many as it takes.

    Returns
    -------
    Batch
        `rows[name]` of shape (K, m), or `sums[name]` of shape (K,). A set that fails is nan there, and `failed` says why; others are not
        touched by it.

    Raises
    ------
    ParameterError
        For names, shapes or values that are not allowed.
    SimulationError
        Where it was stopped on request.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> times = np.linspace(0, 1, 101)
    >>> run = evat.Run(times, {"slip_velocity": 0.02 * np.sin(2 * np.pi * 3 * times)}, ("friction_force",))
    >>> levels = np.array([5.0, 10.0])  # N
    >>> batch = evat.run_many(run, {"kinematics": "external", "friction_law": "coulomb", "F_C": levels})
    >>> print(batch.rows["friction_force"].shape, batch.rows["friction_force"].max(axis=1))
    (2, 101) [ 5. 10.]
    """
    names = tuple(run.outputs)
    if not names:
        raise ParameterError("no outputs were asked for; name at least one, for example friction_force.")
    values = kernel.in_si(values)
    single: dict[str, float | str] = {name: value for name, value in values.items() if isinstance(value, (int, float, str))}
    check_required_inputs(kernel.ContactTables(), on, single, {*run.inputs, *values})
    check_inputs_of_law(kernel.ContactTables(), kernel.laws(), single, {*run.inputs, *values})
    count, constants, columns = value_sets(values, on, run)
    clock, keep = _clock(run, at)
    inputs, shared, each = _columns(run, clock, count)
    kept = clock[keep != 0]
    if give == "rows" and 8 * count * kept.size * len(names) > MOST_BYTES:
        raise ParameterError(f"{count} sets of {kept.size} rows and {len(names)} outputs do not fit into memory; give sums, or run fewer.")
    table = None
    if data is not None:
        unknown = sorted(set(data) - set(names))
        shapes = {name: np.shape(column) for name, column in data.items()}
        if unknown or any(shape != kept.shape for shape in shapes.values()):
            raise ParameterError(f"data need {kept.size} values for outputs that are asked for; found {unknown or shapes}.")
        table = np.column_stack([np.asarray(data.get(name, np.full(kept.size, np.nan)), dtype=np.float64) for name in names])
    indices = tuple(kernel.variable(name).index for name in names)
    plan = _Plan(clock, keep, inputs, shared, each, indices, table, constants, columns, give, most_steps, _search_apart(constants, on))
    batch = _gathered(plan, names, count, threads, progress, cancelled)
    differed = {kernel.variables()[index].name: column for index, column in columns.items()}
    return replace(batch, varied=differed, units={name: kernel.variable(name).unit for name in (*names, *differed)})


def _gathered(
    plan: _Plan,
    names: tuple[str, ...],
    count: int,
    threads: int | None,
    progress: Callable[[float], None] | None,
    cancelled: Callable[[], bool] | None,
) -> Batch:
    ffi, loaded = kernel.library()
    kernel.library(MANY_LANES)  # before the threads, each of which would load its own
    shapes: dict[str, tuple[int, ...]] = (
        {"rows": (count, int(plan.keep.sum()), len(names))} if plan.give == "rows" else {"sums": (count, len(names))}
    )
    if plan.data is not None:
        shapes["squares"] = (count, len(names))
    whole = {name: np.empty(shape) for name, shape in shapes.items()}
    failed: dict[int, str] = {}
    stop = ffi.new("int *")

    def follow(places: np.ndarray[Any, np.dtype[np.intp]], lanes: int) -> int:
        status, arrays = _follow(plan, places, lanes, stop)
        for name, array in whole.items():
            array[places] = arrays[name] if status == loaded.STATUS_OK else np.nan
        return status

    def work(places: np.ndarray[Any, np.dtype[np.intp]]) -> int:
        if places.size >= FEWEST and not plan.one_by_one and follow(places, MANY_LANES) in (loaded.STATUS_OK, loaded.STATUS_STOPPED):
            return places.size
        for place in places:  # too few, or one of them spoils the block: each alone
            status = follow(np.array([place]), 1)
            if status not in (loaded.STATUS_OK, loaded.STATUS_STOPPED):
                failed[int(place)] = kernel.status_text(status)
        return places.size

    blocks = list(_blocks(count, plan.columns, MANY_LANES))
    if cancelled is None and (len(blocks) == 1 or threads == 1) and plan.times.size < kernel.LONG:  # nothing to share out
        done = 0
        for places in blocks:
            done += work(places)
            if progress:
                progress(done / count)
    else:
        _shared_out(work, blocks, count, stop, threads or os.cpu_count() or 1, progress, cancelled)
    by_name = {kind: {name: array[..., place] for place, name in enumerate(names)} for kind, array in whole.items()}
    counts = {} if plan.data is None else {name: int(np.isfinite(plan.data[:, place]).sum()) for place, name in enumerate(names)}
    return Batch(times=plan.times[plan.keep != 0], count=count, counts=counts, failed=dict(sorted(failed.items())), **by_name)  # type: ignore[arg-type]


def _shared_out(
    work: Callable[[np.ndarray[Any, np.dtype[np.intp]]], int],
    blocks: Sequence[np.ndarray[Any, np.dtype[np.intp]]],
    count: int,
    stop: Any,
    threads: int,
    progress: Callable[[float], None] | None,
    cancelled: Callable[[], bool] | None,
) -> None:
    """Work on blocks side by side."""
    done, waiting, pool = 0, set[Future[int]](), kept_threads("blocks", threads)
    try:
        for places in blocks:
            waiting.add(pool.submit(work, places))
            while len(waiting) >= 64:
                done += _reap(waiting, cancelled)
                if progress:
                    progress(done / count)
        while waiting:
            done += _reap(waiting, cancelled)
            if progress:
                progress(done / count)
    except BaseException:
        stop[0] = 1
        for future in waiting:
            future.cancel()
        wait(waiting)
        raise


def _reap(waiting: set[Future[int]], cancelled: Callable[[], bool] | None) -> int:
    """Takes what is done out of `waiting`; how many sets that is."""
    finished, _ = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
    waiting -= finished
    if cancelled and cancelled():
        raise Cancelled("the batch was stopped on request; nothing of it is kept.")
    return sum(future.result() for future in finished)
