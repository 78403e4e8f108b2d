"""Does the paper's table 2 come out, under process conditions that the paper does not print? Draws, polish, profiles, predictions.

For each of the paper's three models and two principles: Sobol draws over the bounds of the conditions, differential evolution from the best
of them, a simplex at the end. What the eight measured means determine is read from profiles: the least error with one condition held.
Stage after stage is kept in a journal, so that a study goes on where it was stopped, to the same end.
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.optimize import differential_evolution, minimize
from scipy.stats import qmc

from evat.identification.searching.journal import Journal
from evat.model import FloatArray, ParameterError
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.paper.conditions import conditions, inference, shear_stresses
from evat.studies.main_job import FORCES, MODELS
from evat.studies.paper.means import (
    FREQUENCY,
    Calculation,
    cycle_means,
    deviations,
    forces_at,
    inferred_point,
    mean_error,
    measured,
    solved_shear_stress,
)
from evat.studies.paper.result import ACCEPTED, Best, ConditionProfile, LeftOut, PaperStudy, Spread
from evat.units import SPEED_UNITS

DRAWS = 2048
MEMBERS, GENERATIONS = 40, 80  # of differential evolution; measured: with the simplex, others end within 0.1 % of error in m/min
SIMPLEX = 0.05  # of the unit interval
POLISHED = 300  # evaluations of the simplex
PROFILE_PLACES = 9
PROFILE_POLISHED = 70  # evaluations of the simplex from each of two starts at each place of a profile
PROFILE_DRAWS = 24  # good ones near a place, the best of which is one of the starts
FEED = FORCES.index("feed_force")


def calculations() -> tuple[Calculation, ...]:
    """All that are studied. Coulomb's law holds no speed, so the unit of speeds is nothing to it; it is listed with both."""
    principles = kernel.variable("shear_angle_principle").choices
    return tuple(Calculation(model, principle, unit) for unit in SPEED_UNITS for principle in principles for model in MODELS)


def paper_threshold() -> float:
    """Mean error of the paper's own calculation with the modified law: what a profile has to do as well as."""
    return paper_tables.mean_relative_error(inference().model)


def chosen() -> Calculation:
    """The calculation that the inferred conditions were made with."""
    return Calculation(inference().model, inference().principle, inference().speed_unit)


def scaled(unit_points: FloatArray) -> FloatArray:
    """Points of the unit cube as conditions, SI; the logarithm of each is drawn evenly."""
    low, high = np.log([[one.low, one.high] for one in conditions()]).T
    return np.asarray(np.exp(low + unit_points * (high - low)))


def study_paper(
    *,
    draws: int = DRAWS,
    seed: int = 0,
    journal: Path | None = None,
    resume: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> PaperStudy:
    """The whole study.

    Parameters
    ----------
    draws : int
        Sobol points over the conditions, a power of 2.
    seed : int
        Of the draws and of differential evolution; the same seed gives the same study.
    journal : path, optional
        File that keeps what is done, stage by stage.
    resume : bool
        Go on with the study that the journal holds.
    progress : callable
        Told what comes next, `stage_count()` times.

    Returns
    -------
    PaperStudy
        The best of each calculation, the draws, profiles and predictions.

    Raises
    ------
    ParameterError
        For a number of draws that is no power of 2 from 64 up.
    EvatError
        Where the journal is that of another study.
    """
    if draws < 64 or draws & (draws - 1):
        raise ParameterError(f"draws = {draws}: a power of 2 from 64 up is needed, such as {DRAWS}; Sobol points are even only then.")
    made_by: dict[str, str | int] = {
        "evat": importlib.metadata.version("evat"),
        "model": kernel.token(),
        "draws": draws,
        "seed": seed,
    }
    stages = _Stages(None if journal is None else Journal(journal, {**made_by, "bounds": _bounds_text()}, resume), progress)
    unit_points: FloatArray = qmc.Sobol(len(conditions()), rng=np.random.default_rng(seed)).random(draws)
    points = scaled(unit_points)
    drawn: dict[Calculation, FloatArray] = {}
    best: dict[Calculation, Best] = {}
    cube: dict[Calculation, FloatArray] = {}
    for how in calculations():
        same = Calculation(how.model, how.principle, SPEED_UNITS[0])
        if MODELS[how.model].law == "coulomb" and same in drawn:
            drawn[how], cube[how], best[how] = drawn[same], cube[same], Best(how, *_of(best[same]))
            continue
        label = f"{MODELS[how.model].title}, {how.principle.replace('_', ' ')}, {how.speed_unit}"
        drawn[how] = stages.of(f"draws: {label}", unit_points, partial(_drawn, how=how))
        others = [point for one, point in cube.items() if one.speed_unit == how.speed_unit]
        good = unit_points[np.argsort(mean_error(drawn[how]), kind="stable")[:MEMBERS]]
        cube[how] = stages.of(f"best: {label}", np.array([*good, *others]), partial(_lowest, how=how, seed=seed))
        point = scaled(cube[how])
        stress = solved_shear_stress(point[None], how)[0]
        best[how] = Best(how, point, stress, forces_at(point, stress, how))
    order = np.argsort(mean_error(drawn[chosen()]), kind="stable")
    profiles = tuple(_profiles(stages, cube[chosen()], unit_points[order]))
    spreads = tuple(_spreads(points[mean_error(drawn[chosen()]) <= ACCEPTED]))
    left_out = tuple(_left_out({model: drawn[Calculation(model, inference().principle, inference().speed_unit)] for model in MODELS}))
    return PaperStudy(best, points, drawn, profiles, spreads, left_out, inferred_forces(), inferred_forces("current_shear_angle"), made_by)


def _of(best: Best) -> tuple[FloatArray, FloatArray, FloatArray]:
    return best.point, best.shear_stress, best.forces


def stage_count() -> int:
    """How often `progress` is told of a study."""
    same = len(kernel.variable("shear_angle_principle").choices) * (len(SPEED_UNITS) - 1)
    return 2 * (len(calculations()) - same) + len(conditions())


def inferred_forces(chip_flow_angle: str = "constant") -> dict[str, FloatArray]:
    """(4, 2) N by model: mean forces under the inferred conditions, shear stresses included."""
    stress = np.array([one.inferred for one in shear_stresses().values()])
    how = {model: Calculation(model, chosen().principle, chosen().speed_unit) for model in MODELS}
    return {model: forces_at(inferred_point(), stress, each, chip_flow_angle) for model, each in how.items()}


def _bounds_text() -> list[str]:
    return [f"{one.variable} {one.low!r} {one.high!r}" for one in (*conditions(), *shear_stresses().values())]


class _Stages:
    """Runs stage after stage, or reads it from the journal: what a stage gives depends on where it starts alone."""

    def __init__(self, journal: Journal | None, progress: Callable[[str], None]) -> None:
        self._journal, self._progress = journal, progress

    def of(self, label: str, start: FloatArray, work: Callable[[FloatArray], FloatArray]) -> FloatArray:
        self._progress(label)
        held = self._journal.recall(start) if self._journal is not None else None
        if held is not None:
            return held
        outcome = work(start)
        if self._journal is not None:
            self._journal.keep(start, outcome)
        return outcome


def _errors(unit_points: FloatArray, how: Calculation) -> FloatArray:
    return mean_error(_drawn(unit_points, how))


def _drawn(unit_points: FloatArray, how: Calculation) -> FloatArray:
    return deviations(scaled(unit_points), how)


def _lowest(start: FloatArray, how: Calculation, seed: int) -> FloatArray:
    """The best point of the unit cube, from MEMBERS good ones; after them may come those where other calculations are best.

    These do not take part in the evolution, which would run to them at once.
    """
    optimum = differential_evolution(
        lambda members: _errors(np.ascontiguousarray(members.T), how),
        [(0.0, 1.0)] * start.shape[1],
        init=start[:MEMBERS],
        maxiter=GENERATIONS,
        rng=np.random.default_rng(seed),
        polish=False,
        strategy="currenttobest1bin",
        updating="deferred",
        vectorized=True,
        tol=1e-4,
    )
    ends = np.vstack([optimum.x, start[MEMBERS:]])
    return _polished(ends[np.argmin(_errors(ends, how))], how, np.arange(start.shape[1]), POLISHED)


def _polished(point: FloatArray, how: Calculation, free: npt.NDArray[np.intp], evaluations: int) -> FloatArray:
    """A simplex in the free coordinates from `point` on: the sum of absolute deviations has kinks, which slopes do not follow."""

    def whole(some: FloatArray) -> FloatArray:
        at = point.copy()
        at[free] = some
        return at

    first = point[free]
    corners = first + np.vstack([np.zeros(free.size), np.diag(np.where(first < 0.5, SIMPLEX, -SIMPLEX))])
    optimum = minimize(
        lambda some: float(_errors(whole(some)[None], how)[0]),
        first,
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * free.size,
        options={"maxfev": evaluations, "initial_simplex": corners, "xatol": 1e-5, "fatol": 1e-6},
    )
    return whole(optimum.x)


def _profiles(stages: _Stages, best: FloatArray, good: FloatArray) -> Iterator[ConditionProfile]:
    """The profile of each condition. A place begins twice: at the end of its neighbour, and at the best of the good draws near it.

    good : draws, the best first.
    """
    how = chosen()
    grid = np.linspace(0.0, 1.0, PROFILE_PLACES)
    for place, condition in enumerate(conditions()):

        def outward(start: FloatArray, place: int = place) -> FloatArray:
            free, errors = np.delete(np.arange(start.size), place), np.full(grid.size, np.inf)
            for side in (np.flatnonzero(grid >= start[place]), np.flatnonzero(grid < start[place])[::-1]):
                point = start
                for number in side:
                    near = good[np.abs(good[:, place] - grid[number]) <= grid[1] - grid[0]][:PROFILE_DRAWS]
                    drawn = _held(near, place, grid[number])
                    starts = _held(point, place, grid[number]), drawn[np.argmin(_errors(drawn, how))]
                    ends = np.array([_polished(one, how, free, PROFILE_POLISHED) for one in starts])
                    reached = _errors(ends, how)
                    point, errors[number] = ends[np.argmin(reached)], reached.min()
            return errors

        errors = stages.of(f"profile: {condition.variable}", best, outward)
        values = np.exp(np.log(condition.low) + grid * (np.log(condition.high) - np.log(condition.low)))
        yield ConditionProfile(condition, values, errors, paper_threshold())


def _held(points: FloatArray, place: int, value: float) -> FloatArray:
    held = points.copy()
    held[..., place] = value
    return held


def _spreads(points: FloatArray) -> Iterator[Spread]:
    """Of quantities that forces depend on by the equations: speeds, and the shear load tau_s w h of each material, mean of the cycle."""
    at = {one.variable: points[:, place] for place, one in enumerate(conditions())}
    omega, stress = 2 * np.pi * at[FREQUENCY], solved_shear_stress(points, chosen())
    chip = at["cutting_speed"] * np.tan(at["chip_flow_shear_angle"])
    made = {
        ("speed ratio HSR", "1"): at["cutting_speed"] / (omega * at["amplitude_x"]),
        ("thrust speed of the vibration over the mean chip speed", "1"): omega * at["amplitude_y"] / chip,
        ("mean chip speed", "m/s"): chip,
    }
    duty = cycle_means(points, stress[..., None], chosen(), outputs=("mean_contact_ratio",))[:, :, 0, 0]
    for place, title in enumerate(paper_tables.materials().values()):
        made[f"shear load of {title}, mean of the cycle", "N"] = duty[:, place] * stress[:, place] * at["width"] * at["feed"]
    for (name, unit), column in made.items():
        low, high = np.percentile(column, [5, 95])
        yield Spread(name, unit, float(low), float(high))


def _left_out(draws: Mapping[str, FloatArray]) -> Iterator[LeftOut]:
    """The principal force of a material follows its own shear stress, of which no other material tells; so its feed force is predicted."""
    for place, material in enumerate(paper_tables.materials()):
        for model, deviation in draws.items():
            met = mean_error(np.delete(deviation, place, axis=1)) <= ACCEPTED
            predicted = measured()[place, FEED] * (1 + deviation[met, place, FEED])
            yield LeftOut(material, model, float(measured()[place, FEED]), predicted)
