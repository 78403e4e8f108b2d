"""What does an identification find and how does it look for it? Settings decide its answer, Execution only how it is carried out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from evat.identification.objective import Kind, Objective
from evat.identification.searching.search import Search
from evat.model import FloatArray

Spread = Callable[[Objective, FloatArray], FloatArray]


@dataclass(frozen=True)
class Settings:
    """All that the answer depends on beside experiment, model and free parameters.

    Attributes
    ----------
    on : effects that are on, beside the nominal ones.
    values : parameters held at other than their nominal values, SI, choices by name.
    bounds : lower and upper bound of a free parameter, SI, by name; without them a twentieth and twenty times the nominal value.
    objective : least_squares, huber, or relative (the paper's eq. 9); see evat.identification.objective.
    search : ga (genetic algorithm), de (differential evolution), none (the polish starts from the nominal values).
    population : members of a generation, 5 or more.
    generations : at most; the search ends earlier where nothing more is gained.
    seed : of the search, 0 or more; the same seed gives the same answer, whatever the number of threads.
    whiten : least_squares takes the noise's correlation from sample to sample into account.
    profiles : make profile intervals; without them the standard errors decide.
    hold_out : conditions that the fit does not see, on which it is judged.

    Examples
    --------
    >>> import evat
    >>> settings = evat.Settings(bounds={"F_C": (1.0, 30.0)}, search="none", profiles=False)
    >>> settings.objective
    'least_squares'
    """

    on: tuple[str, ...] = ()
    values: Mapping[str, float | str] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    objective: Kind = "least_squares"
    search: Search = "de"
    population: int = 64
    generations: int = 100
    seed: int = 0
    whiten: bool = True
    profiles: bool = True
    hold_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Execution:
    """How an identification is carried out; its answer does not depend on it, unless it is stopped.

    Attributes
    ----------
    journal : file that holds the generations, so that a search that was cut off can go on.
    resume : go on with the search in the journal; JournalError where that is another one.
    spread : costs (K,) of the points (K, p) of a generation, evaluated elsewhere; see evat.identification.searching.cluster.
    progress : told what is done and its share, 0 to 1.
    cancelled : asked between generations and runs whether to stop with the best so far.

    Examples
    --------
    >>> import evat
    >>> execution = evat.Execution(progress=lambda doing, share: print(f"{doing}: {share:.0%}"))
    >>> execution.report("search", 0.5)
    search: 50%
    """

    journal: Path | None = None
    resume: bool = False
    spread: Spread | None = None
    progress: Callable[[str, float], None] | None = None
    cancelled: Callable[[], bool] | None = None

    def report(self, doing: str, share: float) -> None:
        if self.progress is not None:
            self.progress(doing, share)

    def stopped(self) -> bool:
        return self.cancelled is not None and self.cancelled()
