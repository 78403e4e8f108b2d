"""Which mean forces does the kernel give under many process conditions, and how far do they lie from those that the paper measured?

Shear stress is not searched for. It has no part in friction where the rake angle is 0 and the chip flows at a constant angle, and the
principal force grows with it; so the forces at both ends of its bounds tell whether one within them meets the measured principal force.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from evat import parameter_sets
from evat.model import FloatArray, Run, SimulationError
from evat.native import kernel
from evat.native.batch import run_many
from evat.paper import tables as paper_tables
from evat.paper.conditions import SHEAR_STRESS, conditions, inference, shear_stresses
from evat.studies.main_job import FORCES, MODELS

MEANS = tuple(f"mean_{force}" for force in FORCES)
COARSE, FINE = 1e-2, 1e-6  # relative_tolerance: means are then right to 0.2 % (measured over the draws), and to 1e-5
HALVINGS = 20  # of the logarithm of the bounds of shear stress
# Powers of time in the units of parameters: with every one of them in proportion a vibration is another one, told slower.
POWERS_OF_TIME = {"Hz": 1, "m/s": 1, "N.s/m": -1, "s": -1}
FREQUENCY = "vibration_frequency"
NO_OTHERS: Mapping[str, str | FloatArray] = {}


@dataclass(frozen=True, slots=True)
class Calculation:
    """One way to calculate table 2: the paper's model, its shear-angle principle, the unit in which the speeds of its table 1 are read."""

    model: str
    principle: str
    speed_unit: str


@lru_cache(maxsize=1)
def measured() -> FloatArray:
    """(4, 2) N: measured means by material and force."""
    means = {(row.material, row.force): row.mean for row in paper_tables.table_2()}
    return np.array([[means[material, force] for force in FORCES] for material in paper_tables.materials()])


@lru_cache(maxsize=1)
def shear_stress_bounds() -> FloatArray:
    """(4, 2) Pa."""
    return np.array([[one.low, one.high] for one in shear_stresses().values()])


def inferred_point() -> FloatArray:
    """The inferred conditions, in the order of `conditions`."""
    return np.array([one.inferred for one in conditions()])


def separates(points: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether the tool leaves the chip in each cycle: speed ratio below 1. The paper, section 1: separation is what EVAT is."""
    frequency, amplitude, speed = (points[:, _place(name)] for name in (FREQUENCY, "amplitude_x", "cutting_speed"))
    return np.asarray(speed < 2 * np.pi * frequency * amplitude)


def _place(name: str) -> int:
    return [one.variable for one in conditions()].index(name)


@lru_cache(maxsize=2)
def _materials(speed_unit: str) -> tuple[Mapping[str, FloatArray], tuple[str, ...]]:
    """(4,) of each number of the materials' parameter sets, and the effects that these have."""
    sets = [parameter_sets.load(f"{inference().family}/{name}", speed_unit=speed_unit) for name in paper_tables.materials()]
    numbers = [name for name in sets[0].values if kernel.variable(name).type == "real"]
    return {name: np.array([one.values[name] for one in sets]) for name in numbers}, sets[0].effects


def cycle_means(
    points: FloatArray,
    shear_stress: FloatArray,
    how: Calculation,
    tolerance: float = COARSE,
    outputs: tuple[str, ...] = MEANS,
    chip_flow_angle: str = "constant",
    *,
    beside: tuple[str, ...] = (),
    others: Mapping[str, str | FloatArray] = NO_OTHERS,
) -> FloatArray:
    """Mean forces of a vibration cycle [N].

    points : (K, p), in the order of `conditions`; shear_stress : (K, 4, T) Pa, T for each material. Returns (K, 4, T, 2) in the order of
    FORCES, or other outputs; nan where a run fails. `beside`: effects on beside those of the model; `others`: choices, and (K,) of other
    parameters. The tool begins at the top of its path, out of contact, so that the first cycle is
    periodic already. All are run at one frequency, with speeds in proportion: a batch has one clock.
    """
    model, shape = MODELS[how.model], shear_stress.shape
    coefficients, effects = _materials(how.speed_unit)
    common = kernel.variable(FREQUENCY).start
    slower = common / points[:, _place(FREQUENCY), None, None]
    columns: dict[str, FloatArray] = {name: each[None, :, None] for name, each in coefficients.items()}
    columns |= {one.variable: points[:, place, None, None] for place, one in enumerate(conditions())}
    values: dict[str, float | str | FloatArray] = {
        name: np.broadcast_to(each * slower ** POWERS_OF_TIME.get(kernel.variable(name).unit, 0), shape).ravel()
        for name, each in columns.items()
    }
    values |= {
        SHEAR_STRESS: shear_stress.ravel(),
        FREQUENCY: common,
        "phase_x": np.pi / 2,
        "phase_y": 0.0,
        "friction_law": model.law,
        "shear_angle_principle": how.principle,
        "chip_flow_angle": chip_flow_angle,
        "relative_tolerance": tolerance,
    }
    values |= {
        name: each if isinstance(each, str) else np.broadcast_to(each[:, None, None], shape).ravel() for name, each in others.items()
    }
    on = (*(effects if model.with_effects else ()), *beside)
    batch = run_many(Run(np.array([0.0, 1 / common]), {}, outputs), values, on)
    return np.stack([batch.rows[name][:, -1].reshape(shape) for name in outputs], axis=-1)


def deviations(points: FloatArray, how: Calculation, tolerance: float = COARSE) -> FloatArray:
    """(K, 4, 2): (calculated - measured) / measured, each material at the shear stress within its bounds that its principal force asks for.

    inf where the tool does not separate or a run fails.
    """
    deviation = np.full((len(points), *measured().shape), np.inf)
    kept = separates(points)
    if kept.any():
        ends = cycle_means(points[kept], np.repeat(shear_stress_bounds()[None], kept.sum(), axis=0), how, tolerance)
        nearest = np.stack([np.clip(measured()[:, 0], ends[:, :, 0, 0], ends[:, :, 1, 0]), ends[:, :, 0, 1]], axis=-1)
        deviation[kept] = np.where(np.isfinite(nearest), nearest / measured() - 1, np.inf)
    return deviation


def mean_error(deviation: FloatArray) -> FloatArray:
    """The paper's measure over the eight means: mean of the absolute deviations, (..., 4, 2) -> (...)."""
    return np.asarray(np.abs(deviation).mean(axis=(-2, -1)))


def solved_shear_stress(
    points: FloatArray,
    how: Calculation,
    *,
    beside: tuple[str, ...] = (),
    others: Mapping[str, str | FloatArray] = NO_OTHERS,
    tolerance: float = FINE,
    halvings: int = HALVINGS,
) -> FloatArray:
    """(K, 4) Pa: where each material's principal force is the measured one, or the nearest end of the bounds."""
    low, high = (np.repeat(end[None], len(points), axis=0) for end in np.log(shear_stress_bounds().T))
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        means = cycle_means(points, np.exp(middle)[..., None], how, tolerance, beside=beside, others=others)
        above = means[:, :, 0, 0] > measured()[:, 0]
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(np.exp(0.5 * (low + high)))


def forces_at(point: FloatArray, shear_stress: FloatArray, how: Calculation, chip_flow_angle: str = "constant") -> FloatArray:
    """(4, 2) N: mean forces of one point. SimulationError where a run fails."""
    # Where the slip is solved for, a finer tolerance can make steps endless at entry (Inconel 718, 1e-6); means are right to 1e-6 at this.
    tolerance = FINE if chip_flow_angle == "constant" else kernel.variable("relative_tolerance").start
    means = cycle_means(point[None], shear_stress[None, :, None], how, tolerance, chip_flow_angle=chip_flow_angle)[0, :, 0]
    if not np.isfinite(means).all():
        raise SimulationError(f"{how.model}, {how.principle}: a vibration cycle cannot be run under these conditions: {point.tolist()}.")
    return means
