"""How does a system answer to its parameters? A grid of runs on all cores or a dask cluster, a row of means for each."""

from __future__ import annotations

import itertools
import math
import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evat.files.writing import put, temporary
from evat.model import EvatError, FloatArray, ParameterError
from evat.systems.couple import Values, run_file
from evat.systems.model import System, SystemStopped, port
from evat.systems.values import Value, merged, of_work, unit, value, variable

MOST_RUNS = 100_000


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
    """One run: its place on every axis, what came out (the mean of each column over the last half), or why nothing did."""

    place: tuple[int, ...]
    means: Mapping[str, float]
    failure: str


def axis(system: System, text: str) -> SweepAxis:
    """An axis from NAME[,NAME...]=FIRST:LAST:COUNT, NAME=VALUE,VALUE,... or COMPONENT=SET,SET,... (parameter sets of the contact)."""
    names, equals, places = text.partition("=")
    example = "for example 'spindle.speed_set=2:30:8', 'contact.amplitude_x=3 um,5 um' or 'contact=regularised/copper,regularised/al-6061'"
    if not equals or not places.strip():
        raise ParameterError(f"--over {text!r}: write NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE; {example}.")
    if "." not in names:
        sets = tuple(name.strip() for name in places.split(","))
        if names.strip() not in system.components:
            raise ParameterError(f"--over {text!r}: there is no component {names.strip()!r}; {example}.")
        return SweepAxis(names.strip(), "1", sets, tuple(of_work(system, names.strip(), name) for name in sets))
    ports = [port(name.strip(), f"--over {text!r}") for name in names.split(",")]
    kinds = {variable(system, at).type for at in ports}
    wanted = [part.strip() for part in places.split(",")]
    if ":" in places:
        wanted = _range(text, places, example)
    rows = [[value(system, at, given) for at in ports] for given in wanted]
    sets_of = tuple(merged(*({at[0]: {at[1]: one}} for at, one in zip(ports, row, strict=True))) for row in rows)
    texts = tuple(repr(float(row[0])) if kinds <= {"Real", "Float64"} else str(row[0]) for row in rows)
    return SweepAxis(names.partition(",")[0].strip(), unit(system, ports[0]), texts, sets_of)


def _range(text: str, places: str, example: str) -> list[str]:
    parts = [part.strip() for part in places.split(":")]
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[2])
    except (ValueError, IndexError):
        raise ParameterError(f"--over {text!r}: FIRST:LAST:COUNT in SI units is needed; {example}.") from None
    if len(parts) != 3 or not 1 <= count <= MOST_RUNS or not (math.isfinite(first) and math.isfinite(last)):
        raise ParameterError(f"--over {text!r}: FIRST:LAST:COUNT with a count from 1 to {MOST_RUNS} is needed; {example}.")
    return [repr(float(number)) for number in np.linspace(first, last, count)]


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
    late = trace.times >= 0.5 * (trace.times[0] + trace.times[-1])
    return {name: float(np.mean(column[late])) for name, column in trace.columns.items()}, ""


def sweep(
    path: Path,
    axes: Sequence[SweepAxis],
    values: Values,
    wishes: Mapping[str, Any],
    done: Callable[[float], None] = lambda _: None,
    cluster: Any = None,
    beside: Values | None = None,
) -> list[Row]:
    """Run the system at every point of the grid; rows in the order of the grid, whatever the order in which they finish.

    beside : values that stand whatever the point says.
    cluster : evat.identification.searching.cluster.Cluster whose workers run them; None: the cores of this machine.
    """
    places = list(itertools.product(*(range(len(each.texts)) for each in axes)))
    if len(places) > MOST_RUNS:
        raise ParameterError(f"the grid has {len(places)} points; at most {MOST_RUNS} are run.")
    archive = path.read_bytes()
    points = [merged(values, *(each.values[place] for each, place in zip(axes, at, strict=True)), beside or {}) for at in places]
    rows: dict[int, Row] = {}
    for number, (means, failure) in (_here if cluster is None else cluster.each)(
        _point, archive, [(point, dict(wishes)) for point in points]
    ):
        rows[number] = Row(places[number], means, failure)
        done(len(rows) / len(places))
    return [rows[number] for number in range(len(places))]


def _here(function: Callable[..., Any], archive: bytes, points: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
    """Each point on a core of its own: processes, since a run in Python keeps its interpreter busy."""
    workers = max(1, min(os.cpu_count() or 1, len(points)))
    if workers == 1:
        yield from ((number, function(archive, *point)) for number, point in enumerate(points))
        return
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
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
