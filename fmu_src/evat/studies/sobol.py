"""Which parameters decide an output, over all that they may be? Sobol's indices by Saltelli's design, through SALib, in one batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from scipy.integrate import trapezoid

from evat.model import EvatError, FloatArray, NamedArrays, ParameterError, Run, SimulationError
from evat.native import kernel
from evat.native.batch import run_many
from evat.units import to_si

Reduction = Literal["mean", "rms", "last", "max", "min"]
REDUCTIONS: dict[str, Callable[[FloatArray, FloatArray], FloatArray]] = {  # of rows and their times
    "mean": lambda rows, times: _over_time(rows, times),
    "rms": lambda rows, times: np.sqrt(_over_time(rows**2, times)),
    "last": lambda rows, _: rows[:, -1],
    "max": lambda rows, _: np.max(rows, axis=-1),
    "min": lambda rows, _: np.min(rows, axis=-1),
}
CONFIDENCE = 0.95
KINDS = ("S1", "S1_conf", "ST", "ST_conf")  # by the names of SALib
MOST_SETS = 2_000_000
NUMBERS_AT_ONCE = 10_000_000  # of rows that are held


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SobolIndices(NamedArrays):
    """How much of an output's variance each parameter explains: a mapping from outputs to their total indices, (P,).

    `plot()` draws them, `to_xarray()` and `to_pandas()` give what their libraries work with; a notebook shows a table.

    Attributes
    ----------
    parameters : tuple of str
        What was varied, P of them.
    bounds : mapping of str to (float, float)
        Between which values, evenly, SI.
    first, first_error : mapping of str to array of shape (P,)
        By output the share of variance that a parameter explains alone, and half its 95 % interval.
    total, total_error : mapping of str to array of shape (P,)
        With all that it does together with others.
    of : str
        What of an output over time was looked at.
    runs : int
        How many runs that took.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> run = evat.Run(np.array([0.0, 0.1]), {"slip_velocity": np.full(2, 0.1)}, ("friction_force",))
    >>> held = {"kinematics": "external", "friction_law": "coulomb"}
    >>> indices = evat.sobol(run, held, {"F_C": ("1 N", "10 N"), "sigma0": (1e5, 1e6)}, samples=64)
    >>> np.abs(np.round(indices["friction_force"], 1))  # Coulomb's force is F_C itself
    array([1., 0.])
    """

    parameters: tuple[str, ...]
    bounds: Mapping[str, tuple[float, float]]
    first: Mapping[str, FloatArray]
    first_error: Mapping[str, FloatArray]
    total: Mapping[str, FloatArray]
    total_error: Mapping[str, FloatArray]
    of: str
    runs: int

    def _arrays(self) -> Mapping[str, FloatArray]:
        return self.total

    def to_xarray(self) -> Any:
        """As an xarray.Dataset over `output` and `parameter`."""
        from evat.notebook.datasets import dataset

        tables = {
            name: np.array([rows[output] for output in self.total])
            for name, rows in (
                ("first", self.first),
                ("first_error", self.first_error),
                ("total", self.total),
                ("total_error", self.total_error),
            )
        }
        coordinates = {"output": ("output", list(self.total), ""), "parameter": ("parameter", list(self.parameters), "")}
        about = {"of": self.of, "runs": self.runs, "bounds": dict(self.bounds), "confidence": CONFIDENCE}
        return dataset(tables, ("output", "parameter"), coordinates, dict.fromkeys(tables, "1"), about)

    def to_pandas(self) -> Any:
        """As a pandas.DataFrame, a line for each output and parameter."""
        return self.to_xarray().to_dataframe()

    def plot(self, *names: str) -> Any:
        """A matplotlib Figure: bars of the first and total indices of each output, with their 95 % intervals."""
        from evat.notebook.panels import bars

        panels = {
            f"{self.of} of {name}": {
                "alone": (self.first[name], self.first_error[name]),
                "in all": (self.total[name], self.total_error[name]),
            }
            for name in names or self.total
        }
        return bars(panels, self.parameters, "share of the variance [-]")

    def _table(self) -> Any:
        from evat.notebook.tables import ResultTable, number

        rows = [
            (
                output,
                name,
                *(number(float(column[output][place])) for column in (self.first, self.first_error, self.total, self.total_error)),
            )
            for output in self.total
            for place, name in enumerate(self.parameters)
        ]
        title = f"Sobol indices of the {self.of}, {self.runs} runs"
        return ResultTable(title, ("output", "parameter", "alone", "+/-", "in all", "+/-"), rows)


def sobol(
    run: Run,
    values: Mapping[str, float | str],
    parameters: Mapping[str, tuple[float | str, float | str]],
    on: Sequence[str] = (),
    *,
    of: Reduction = "mean",
    samples: int = 256,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> SobolIndices:
    """Which parameters decide the outputs, alone and together with others? Sobol's first and total indices; needs SALib.

    Parameters
    ----------
    run : Run
        Sample times [s], inputs, and the outputs to look at.
    values : mapping of str to float or str
        What is held, SI or texts with units, choices by name; what is not named stands at its start.
    parameters : mapping of str to (float or str, float or str)
        What varies evenly between two bounds, SI or texts with units.
    on : sequence of str
        Effects that are on.
    of : "mean", "rms", "last", "max" or "min"
        What of an output is looked at; means are over the time, also where samples are not even.
    samples : int
        Base points of the design, a power of 2; it takes samples * (parameters + 2) runs.
    seed : int
        Of the design and of the intervals; the same seed gives the same answer.
    threads : int, optional
        How many; without it as many as there are processors.
    progress : callable, optional
        Told the share that is done.

    Returns
    -------
    SobolIndices
        `indices[output]` are the total indices in the order of the parameters.

    Raises
    ------
    ParameterError
        For a name, bound or number that is not allowed.
    SimulationError
        Where a run fails: indices need all of them.
    EvatError
        Where SALib is not installed.

    Notes
    -----
    Saltelli et al. 2010, with Sobol's sequence and Owen's scrambling; an output that does not change at all has indices of 0.

    Examples
    --------
    >>> import evat
    >>> import numpy as np
    >>> run = evat.Run(np.linspace(0, 0.1, 11), {"slip_velocity": np.linspace(0, 0.1, 11)}, ("friction_force",))
    >>> indices = evat.sobol(run, {"kinematics": "external"}, {"F_C": (5.0, 10.0), "sigma2": (0.0, 1.0)}, samples=64)
    >>> indices.parameters, indices.runs
    (('F_C', 'sigma2'), 256)
    """
    if of not in REDUCTIONS:
        raise ParameterError(f"of = {of!r}: allowed are {', '.join(REDUCTIONS)}.")
    if samples < 2 or samples & (samples - 1) or samples * (len(parameters) + 2) > MOST_SETS:
        raise ParameterError(f"samples = {samples}: a power of 2 is needed, from 2 on, and at most {MOST_SETS} runs in all.")
    if not parameters:
        raise ParameterError("parameters are empty: name at least one with its bounds, for example {'F_C': (5.0, 10.0)}.")
    bounds = {name: _bounds(name, pair, run) for name, pair in parameters.items()}
    sampler, analyzer = _salib()
    problem = {"num_vars": len(bounds), "names": list(bounds), "bounds": [list(pair) for pair in bounds.values()]}
    design = np.asarray(sampler.sample(problem, samples, calc_second_order=False, seed=seed))
    wanted = replace(run, outputs=tuple(run.outputs))
    parts = list[dict[str, FloatArray]]()
    at_once = max(1, NUMBERS_AT_ONCE // max(1, run.times.size * len(wanted.outputs)))
    for begin in range(0, len(design), at_once):
        part = design[begin : begin + at_once]
        sets: dict[str, float | str | FloatArray] = {**values, **{name: part[:, place].copy() for place, name in enumerate(bounds)}}
        kept = run.times[-1:] if of == "last" else None
        batch = run_many(wanted, sets, on, at=kept, threads=threads, progress=_part(progress, begin, len(part), len(design)))
        if batch.failed:
            place, why = next(iter(batch.failed.items()))
            there = ", ".join(f"{name} = {part[place, at]:.6g}" for at, name in enumerate(bounds))
            raise SimulationError(f"{len(batch.failed)} of {batch.count} runs failed, the first at {there}: {why}. Narrow the bounds.")
        parts.append({name: REDUCTIONS[of](rows, run.times) for name, rows in batch.rows.items()})
    answers = {name: np.concatenate([part[name] for part in parts]) for name in wanted.outputs}
    indices = {name: _indices(analyzer, problem, answer, seed) for name, answer in answers.items()}
    first, first_error, total, total_error = ({name: index[kind] for name, index in indices.items()} for kind in KINDS)
    return SobolIndices(tuple(bounds), bounds, first, first_error, total, total_error, of, len(design))


def _over_time(rows: FloatArray, times: FloatArray) -> FloatArray:
    """Means of rows that go straight from sample to sample; of one sample, what it is."""
    if times.size == 1:
        return rows[:, 0]
    return np.asarray(trapezoid(rows, times, axis=-1) / (times[-1] - times[0]))


def _part(progress: Callable[[float], None] | None, begin: int, size: int, of_all: int) -> Callable[[float], None] | None:
    """Told the share that is done of a part, it tells that of all."""
    return None if progress is None else lambda share: progress((begin + share * size) / of_all)


def _bounds(name: str, pair: tuple[float | str, float | str], run: Run) -> tuple[float, float]:
    known = kernel.variable(name)
    if known.causality not in ("parameter", "input") or known.type != "real" or name in run.inputs:
        raise ParameterError(f"{name} is no number that is held during the run; parameters are varied.")
    low, high = (known.check(to_si(end, known.unit, name=name)) for end in pair)
    if not low < high:
        raise ParameterError(f"bounds of {name}: {low:g} to {high:g} {known.unit}; the first must be below the second.")
    return low, high


def _indices(analyzer: Any, problem: Mapping[str, Any], answer: FloatArray, seed: int) -> Mapping[str, FloatArray]:
    if float(np.ptp(answer)) <= 1e-12 * float(np.abs(answer).max()):
        return dict.fromkeys(KINDS, np.zeros(problem["num_vars"]))
    told = analyzer.analyze(problem, answer, calc_second_order=False, conf_level=CONFIDENCE, seed=seed)
    return {kind: np.asarray(told[kind], dtype=np.float64) for kind in KINDS}


def _salib() -> tuple[Any, Any]:
    try:
        from SALib.analyze import sobol as analyzer
        from SALib.sample import sobol as sampler
    except ImportError as error:
        raise EvatError("Sobol indices need the package SALib, which is not installed here: pip install 'evat[notebook]'.") from error
    return sampler, analyzer
