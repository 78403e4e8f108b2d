"""What came out of an identification? Estimates, what the data say about each, and how good the fit is on what it has and has not seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from evat.experiment import Experiment
from evat.identification.searching.search import Generation
from evat.model import FloatArray, Variable

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
    bound, up to which the data do not object. `sd` is the standard error at the optimum (inf where the data say nothing). Both count noise
    and what differs between recordings; where something speaks against the whole fit the verdict is withheld, and they are no statement."""

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
    """How far the identified model is from one channel. `noise` is nan where nothing was repeated; `follows_itself` is the correlation of
    neighbouring residuals."""

    rms: float
    share: float
    relative_error: float
    noise: float
    follows_itself: float
    samples: int


@dataclass(frozen=True, slots=True, eq=False)
class Identification:
    """The answer. `values` are complete, with the estimates in them; `predicted` belongs to the trials and means of `experiment`,
    `units` to its channels.

    fits, held_out : by channel, on what was fitted and on the conditions that were kept back; doubts : sentences to read before a number is
    used; stopped : the search was ended by its user, so this is the best so far.
    """

    experiment: Experiment
    estimates: tuple[Estimate, ...]
    correlation: FloatArray
    values: Mapping[str, float | str]
    effects: tuple[str, ...]
    objective: str
    search: str
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
        raise KeyError(name)
