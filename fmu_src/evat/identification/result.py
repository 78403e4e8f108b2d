"""What came out of an identification? Estimates, what the data say about each, and how good the fit is on what it has and has not seen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from evat.experiment import Experiment
from evat.identification.draws import APPROXIMATION, as_arviz, prior
from evat.identification.draws import draws as drawn
from evat.identification.searching.search import Generation
from evat.model import FloatArray, ParameterError, Variable, nearest
from evat.notebook.summaries import FitRow
from evat.notebook.summaries import summary as fit_summary
from evat.units import affine, display

Word = Literal["identified", "weak", "not identifiable", "withheld"]


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A profile: values of the parameter (SI), and how much worse the best fit there is, in units of one sd squared."""

    values: FloatArray
    rise: FloatArray
    threshold: float


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """One free parameter. `low` and `high` are the ends of the 90 % interval from the profile, nan where none was made; an open end is a
    bound, up to which the data do not object. `sd` is the standard error at the optimum (inf where the data say nothing). Both count
    noise, what differs between recordings, and what held values and the set-up may be off; where something speaks against the whole fit the
    verdict is withheld, and they are no statement."""

    variable: Variable
    nominal: float
    bounds: tuple[float, float]
    value: float
    sd: float
    low: float
    high: float
    open_below: bool
    open_above: bool
    at_bound: Literal["", "lower", "upper"]
    verdict: Word
    why: str
    advice: str
    profile: Curve | None

    @property
    def name(self) -> str:
        return self.variable.name


@dataclass(frozen=True, slots=True)
class ChannelFit:
    """How far the identified model is from one channel. `noise` is nan where no recording was repeated, `of_replicates` where no mean was,
    or where all replicates read alike, and is what was stated of the means where that is more; `follows_itself` is the correlation of
    neighbouring residuals, `beyond_noise` by how many sd the repeats tell that the residual is more than their noise, nan without
    repeats."""

    rms: float
    share: float
    relative_error: float
    noise: float
    follows_itself: float
    samples: int
    of_replicates: float = math.nan
    beyond_noise: float = math.nan

    @property
    def repeated(self) -> float:
        """What repeats show of the noise, be they recordings or means; nan where nothing was repeated."""
        return self.of_replicates if math.isnan(self.noise) else self.noise


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Identification:
    """The answer: `identification[name]` is the estimate of a free parameter, and it goes through their names as a dict does.

    `values` are complete, with the estimates in them; `predicted` belongs to the trials and means of `experiment`, `units` to its channels.

    fits, held_out : by channel, on what was fitted and on the conditions that were kept back; doubts : sentences to read before a number is
    used; stopped : the search was ended by its user, so this is the best so far; searched_points : measured numbers that the search looked
    at, fewer than `predicted` where it looked at excerpts of long records.

    `print` shows a summary as of lmfit, a notebook a table; `plot()` draws the profiles, `to_pandas()` has a line for each estimate,
    `to_arviz()` draws for what ArviZ shows.

    Attributes
    ----------
    estimates : tuple of Estimate
        Of each free parameter `value`, `sd`, the 90 % interval from `low` to `high`, `verdict` and `why`, SI.
    correlation : array of shape (P, P)
        Of the estimates.
    values : mapping of str to float or str
        The whole model, as `evat.simulate` takes it.
    doubts : tuple of str
        Sentences to read before a number is used.

    Examples
    --------
    >>> import evat
    >>> truth = {"friction_law": "coulomb", "F_C": 8.0}
    >>> made = evat.orthogonal(truth, motion="reversal", repeats=2, speeds=[0.1, 0.5], rate=100.0, seed=1)
    >>> result = evat.identify(made, free=["F_C"], settings=evat.Settings(search="none"))
    >>> list(result), result["F_C"].verdict
    (['F_C'], 'identified')
    >>> result.to_pandas().loc["F_C", "unit"]
    'N'
    """

    experiment: Experiment
    estimates: tuple[Estimate, ...]
    correlation: FloatArray
    values: Mapping[str, float | str]
    effects: tuple[str, ...]
    objective: str
    search: str
    searched_points: int
    cost: float
    fits: Mapping[str, ChannelFit]
    held_out: Mapping[str, ChannelFit]
    held_out_conditions: tuple[str, ...]
    predicted: FloatArray
    units: Mapping[str, str]
    history: tuple[Generation, ...]
    evaluations: int
    seconds: float
    stopped: bool
    doubts: tuple[str, ...]
    made_by: Mapping[str, str | int | float | bool]

    def __getitem__(self, name: str) -> Estimate:
        for estimate in self.estimates:
            if estimate.name == name:
                return estimate
        raise KeyError(f"{name!r} was not free here; {nearest(name, self)}")

    def __iter__(self) -> Iterator[str]:
        return (estimate.name for estimate in self.estimates)

    def __len__(self) -> int:
        return len(self.estimates)

    def __contains__(self, name: object) -> bool:
        return name in self.keys()

    def keys(self) -> tuple[str, ...]:
        """Names of the free parameters."""
        return tuple(self)

    def __repr__(self) -> str:
        told = ", ".join(f"{row.name} = {row.value} +/- {row.error} ({row.verdict})" for row in self._rows())
        return f"<Identification of {self.experiment.title!r}: {told}>"

    def __str__(self) -> str:
        return self.summary()

    def _rows(self) -> list[FitRow]:
        return [
            FitRow(
                each.name,
                display(each.value, each.variable, digits=5),
                error_text(each),
                f"{_end(each.low, each.open_below, each.variable)} to {_end(each.high, each.open_above, each.variable)}",
                display(each.nominal, each.variable),
                each.verdict,
            )
            for each in self.estimates
        ]

    def _searched(self) -> str:
        some = self.searched_points < self.predicted.size
        return f"{self.search} over excerpts of {self.searched_points} data points" if some else self.search

    def summary(self) -> str:
        """A text as of lmfit's fit_report: the fit, each variable with its interval, correlations, doubts."""
        errors = {
            f"error of {channel}": f"{100 * fit.relative_error:.3g} % (eq. 9), residual {fit.rms:.3g} {self.units[channel]} rms"
            for channel, fit in self.fits.items()
        }
        held = {f"{channel}, held out": f"{100 * fit.relative_error:.3g} % (eq. 9)" for channel, fit in self.held_out.items()}
        facts = {
            "experiment": self.experiment.title,
            "method": f"{self.objective}, search {self._searched()}{'; stopped, the best so far' if self.stopped else ''}",
            "data points": str(self.predicted.size),
            "variables": str(len(self.estimates)),
            "evaluations": str(self.evaluations),
            **errors,
            **held,
        }
        names = list(self)
        pairs = {(names[i], names[j]): float(self.correlation[i, j]) for i in range(len(names)) for j in range(i)}
        why = [f"{each.name}: {each.why}" for each in self.estimates if each.why]
        return fit_summary(facts, self._rows(), pairs, (*why, *self.doubts))

    def to_pandas(self) -> Any:
        """As a pandas.DataFrame, a line for each estimate, SI."""
        import pandas

        columns = ("unit", "value", "sd", "low", "high", "nominal", "verdict")
        lines = [(e.variable.unit, e.value, e.sd, e.low, e.high, e.nominal, e.verdict) for e in self.estimates]
        return pandas.DataFrame(lines, index=pandas.Index(list(self), name="parameter"), columns=columns)

    def plot(self) -> Any:
        """A matplotlib Figure: the profile of each parameter, how much worse the best fit with that value is."""
        from evat.notebook.panels import curves

        profiles = {
            e.name: (e.profile.values, e.profile.rise, e.profile.threshold, e.value) for e in self.estimates if e.profile is not None
        }
        if not profiles:
            raise ParameterError("this identification has no profiles to draw: it was made without them, or was stopped before.")
        units = {e.name: e.variable.unit for e in self.estimates}
        return curves(profiles, units, "rise of the loss\n[sd squared]", "90 % interval")

    def to_arviz(self, draws: int = 1000, chains: int = 4, seed: int = 0) -> Any:
        """For ArviZ: its tree of Datasets (before ArviZ 1.0: InferenceData) with posterior, prior and observed_data; needs arviz-base.

        The posterior is a normal approximation about the optimum within the bounds, no sampler's chain; its attributes say so.
        """
        facts = [(e.variable, e.nominal, e.bounds, e.value, e.sd if e.sd < 1e300 else math.inf) for e in self.estimates]
        shape = (chains, draws)
        groups: dict[str, dict[str, FloatArray]] = {
            "posterior": {n: c.reshape(shape) for n, c in drawn(facts, self.correlation, chains * draws, seed).items()},
            "prior": {n: c.reshape(shape) for n, c in prior(facts, chains * draws, seed).items()},
        }
        if self.experiment.trials:
            groups["observed_data"] = {
                name: np.concatenate([trial.outputs[name] for trial in self.experiment.trials if name in trial.outputs])
                for name in self.fits
            }
        units = {**{e.name: e.variable.unit for e in self.estimates}, **self.units}
        made_by = {name: value if isinstance(value, (int, float)) else str(value) for name, value in self.made_by.items()}
        return as_arviz(
            groups, units, {"inference_library": "evat", "approximation": APPROXIMATION, "doubts": " ".join(self.doubts), **made_by}
        )

    def _repr_html_(self) -> str:
        from evat.notebook.tables import ResultTable

        rows = [(r.name, r.value, r.error, r.interval, r.start, r.verdict) for r in self._rows()]
        header = ("parameter", "estimate", "standard error", "90 % interval", "nominal", "verdict")
        return ResultTable(f"Identification: {self.experiment.title}", header, rows, self.doubts).html()


def error_text(estimate: Estimate) -> str:
    """The standard error in the unit in which the estimate is shown."""
    if not estimate.sd < 1e300:
        return "unbounded"
    unit = estimate.variable.display_unit or estimate.variable.unit
    error = f"{affine(estimate.variable.unit, unit)[0] * estimate.sd:.2g}"  # a difference: the zero of the unit has no say
    return error if unit == "1" else f"{error} {unit}"


def _end(value: float, is_open: bool, variable: Variable) -> str:
    return "?" if math.isnan(value) else "bound" if is_open else display(value, variable)
