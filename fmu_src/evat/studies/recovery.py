"""Which parameters of a known contact come back from tests of it, and which motion makes them come back?

A forecast, linear: a parameter's standard deviation from the slopes of the simulated force at the truth, all others of the paper's table 1
free with it, for white noise. It knows no bounds and no curvature: where it is small fits do as it says, where it is large they may do
better. `fitted` does the whole thing on one motion's tests, to set beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from evat.experiment import Experiment
from evat.inference.prediction import Prediction
from evat.model import FloatArray, ParameterError, Run
from evat.models.contact import ContactModel
from evat.motions import KINDS
from evat.paper.tables import materials
from evat.parameter_sets import ParameterSet
from evat.studies.orthogonal import orthogonal, uncertain
from evat.studies.sensitivity import sensitivities

if TYPE_CHECKING:
    from evat.identification import Identification

Word = Literal["identified", "weak", "cannot come back"]
IDENTIFIED, WEAK = 0.05, 0.5  # sd over the truth, below which a parameter is called so
LOOSE = 100.0  # sd over the truth that a parameter gets on which nothing depends; slopes are too inexact to tell beyond it
ALIKE = 3.0  # times the least sd: motions that are told apart by no more are alike, and the simpler one is named
MOST = 10.0  # sd over the truth beyond which the number says no more
TOGETHER = "all together"
OUTPUT = "friction_force"
FIRST, THEN = "lugre-1995", "regularised"


@dataclass(frozen=True, slots=True, eq=False)
class Recovery:
    """One set: `sd[motion, parameter]` over the truth; the last row is that of all motions together."""

    name: str
    title: str
    truth: Mapping[str, float]
    motions: tuple[str, ...]
    sd: FloatArray

    def best(self, parameter: str) -> str:
        """The first motion that tells a parameter about as well as any; TOGETHER where none tells it by itself; "" where nothing does."""
        column = self.sd[:, list(self.truth).index(parameter)]
        alone = column[: len(self.motions)]
        if alone.min() >= WEAK:
            return TOGETHER if column[-1] < WEAK else ""
        return self.motions[int(np.argmax(alone <= ALIKE * alone.min()))]


def percent(sd: float) -> str:
    """Two digits in per cent; beyond MOST only that it is more."""
    share = 100 * sd
    return f">{100 * MOST:.0f}" if sd > MOST else f"{share:.0f}" if share >= 100 else f"{share:.2g}"


def word(sd: float) -> Word:
    """What a standard deviation over the truth is called."""
    return "identified" if sd < IDENTIFIED else "weak" if sd < WEAK else "cannot come back"


def study_sets() -> tuple[str, ...]:
    """What is studied where nothing is asked for: the plain law, and the four materials as far as they are dissipative."""
    return (FIRST, *(f"{THEN}/{name}" for name in materials()))


def truth_of_set(parameter_set: ParameterSet) -> dict[str, float]:
    """The coefficients of table 1 that a set has, that its effects use, and that are not 0, of which no share could be told."""
    truth = {}
    for name in uncertain():
        owner, dot, _ = name.partition(".")
        if parameter_set.values.get(name) and (not dot or owner in parameter_set.effects):
            truth[name] = float(parameter_set.values[name])
    if not truth:
        raise ParameterError(f"{parameter_set.name}: it names none of the coefficients that are looked for ({', '.join(uncertain())}).")
    return truth


def recovery(
    parameter_set: ParameterSet,
    motions: Sequence[str] = KINDS,
    *,
    noise: float = 0.01,
    repeats: int = 3,
    rate: float = 1000.0,
    progress: Callable[[str], None] | None = None,
) -> Recovery:
    """The forecast for one set; noise, repeats and rate as in evat.studies.orthogonal; progress : told the motion that comes next."""
    if not noise > 0:
        raise ParameterError(f"noise = {noise:g}: without noise every parameter is recovered exactly; more than 0 is needed.")
    truth = truth_of_set(parameter_set)
    tables = []
    for motion in motions:
        if progress is not None:
            progress(f"{parameter_set.name}: {motion}")
        clean = orthogonal(
            parameter_set.by_choice,
            parameter_set.effects,
            motion=motion,
            repeats=1,
            noise=0.0,
            rate=rate,
            nominal_off=0.0,
            outputs=(OUTPUT,),
        )
        tables.append(slopes(clean, tuple(truth), noise=noise, repeats=repeats))
    sd = np.array([spread(table) for table in (*tables, np.concatenate(tables))])
    return Recovery(parameter_set.name, parameter_set.title, truth, tuple(motions), sd)


def slopes(clean: Experiment, names: Sequence[str], *, noise: float, repeats: int) -> FloatArray:
    """(N, p): by how many sd of the noise each sample moves when a parameter grows by its own size; `clean` holds the truth."""
    values, effects = clean.nominal.values, clean.nominal.effects
    output = Prediction(ContactModel(), clean).variable_of(OUTPUT)
    measured = np.concatenate([trial.outputs[OUTPUT] for trial in clean.trials])
    sd = noise * float(np.sqrt(np.mean(measured**2))) / np.sqrt(repeats)
    rows = []
    for trial in clean.trials:
        derivatives = sensitivities(Run(trial.times, trial.inputs, (output,)), {**values, **trial.values}, names, effects)[output]
        rows.append(np.column_stack([derivatives[name] * float(values[name]) for name in names]) / sd)
    return np.concatenate(rows)


def spread(table: FloatArray, kept: npt.NDArray[np.bool_] | None = None) -> FloatArray:
    """Standard deviation of each parameter over its truth, all others being free; from some of the samples only where `kept` is given."""
    rows = table if kept is None else table[kept]
    _, size, turn = np.linalg.svd(np.concatenate([rows, np.eye(rows.shape[1]) / LOOSE]), full_matrices=False)
    sd: FloatArray = np.sqrt(np.sum((turn.T / size) ** 2, axis=1))
    return sd


def fitted(
    parameter_set: ParameterSet,
    motion: str,
    *,
    noise: float = 0.01,
    repeats: int = 3,
    rate: float = 1000.0,
    seed: int = 0,
    population: int = 64,
    generations: int = 100,
    progress: Callable[[str, float], None] | None = None,
) -> Identification:
    """Tests with noise, whose nominal model is off, identified: every parameter that the forecast speaks of is free."""
    from evat.identification import Execution, Settings, identify

    tests = orthogonal(
        parameter_set.by_choice,
        parameter_set.effects,
        motion=motion,
        repeats=repeats,
        noise=noise,
        seed=seed,
        rate=rate,
        outputs=(OUTPUT,),
    )
    settings = Settings(seed=seed, population=population, generations=generations)
    return identify(tests, ContactModel(), tuple(truth_of_set(parameter_set)), settings, execution=Execution(progress=progress))
