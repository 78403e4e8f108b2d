"""Which columns of a recording are not what was recorded, but derived from it? Velocities of positions, and forces without inertia."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import ExperimentError
from evat.experiment.column import Column
from evat.experiment.document import FRICTION, Document
from evat.experiment.remarks import unwrapped
from evat.experiment.smoothing import derivative, mean_step, position_noise
from evat.model import FloatArray
from evat.required_inputs import MOTION

UNEVEN = 0.05  # of a step: so far may a clock's steps differ where something is differentiated


def derived(file: str, columns: Sequence[Column], held: list[FloatArray], document: Document) -> list[FloatArray]:
    """Velocities from positions, and forces without the inertia and the load of what moves, beside the columns that stay."""
    names = [column.name for column in columns]
    positions = {place for place, name in enumerate(names) if document.signals[name].of}
    inertia = document.inertia
    if not positions and inertia is None:
        return held
    step = even_step(file, held[0])
    held = [unwrapped(values, column.turn) for values, column in zip(held, columns, strict=True)]
    columns_in_si = list(held)
    for place in positions:
        columns_in_si[place] = derivative(held[place], step)
        low, high = columns[place].variable_low, columns[place].variable_high
        if columns_in_si[place].min() < low or columns_in_si[place].max() > high:
            raise ExperimentError(
                f"{file}, column {columns[place].header!r}: {names[place]} comes out between {columns_in_si[place].min():g} and "
                f"{columns_in_si[place].max():g} m/s; allowed is {low:g} to {high:g} m/s. Its unit is given as "
                f"{columns[place].unit}: is that right?"
            )
    if inertia is not None:
        motion, force = names.index(MOTION), names.index(FRICTION)
        order = 2 if motion in positions else 1
        acceleration = derivative(held[motion], step, order)
        columns_in_si[force] = held[force] - inertia.mass * acceleration - inertia.load
    return columns_in_si


def noise_of_positions(columns: Sequence[Column], held: Sequence[FloatArray], document: Document) -> dict[str, float]:
    """By the input that is differentiated from it, the standard deviation by which a position is off [m]; without those that are exact."""
    sds = {
        column.name: position_noise(unwrapped(values, column.turn))
        for column, values in zip(columns, held, strict=True)
        if document.signals[column.name].of
    }
    return {name: sd for name, sd in sds.items() if sd > 0}


def even_step(file: str, times: FloatArray) -> float:
    """The sample time [s]; ExperimentError where it changes by more than a clock is rounded, so that nothing can be differentiated."""
    steps, step = np.diff(times), mean_step(times)
    if np.max(np.abs(steps - step)) > UNEVEN * step:
        raise ExperimentError(
            f"{file}: the clock is uneven, its steps are {steps.min():.4g} to {steps.max():.4g} s; what is differentiated "
            "needs an even one. Give the velocity as a column, or resample the recording."
        )
    return step


def derived_batches(
    file: str, columns: Sequence[Column], batches: Iterable[list[FloatArray]], document: Document
) -> Iterator[list[FloatArray]]:
    """The same batch by batch, each derived with so many rows around it as the widest window asks for."""
    if document.inertia is None and not any(document.signals[column.name].of for column in columns):
        yield from batches
        return
    around, kept, before = 2 * max(CONSTANTS.smoothing_windows), list[FloatArray](), 0
    for batch in batches:
        kept = [np.concatenate(pair) for pair in zip(kept, batch, strict=True)] if kept else batch
        last = kept[0].size - around
        if last <= before:
            continue
        yield [column[before:last] for column in derived(file, columns, kept, document)]
        first = max(last - around, 0)
        kept, before = [column[first:] for column in kept], last - first
    if kept and kept[0].size > before:
        yield [column[before:] for column in derived(file, columns, kept, document)]
