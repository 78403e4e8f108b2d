"""Which rows of a recording count? Those in which a trigger is on; what was recorded just before leads a model there.

Each stretch of such rows is a recording of its own. Half of the trigger's largest value divides on from off, so that 0 and 1 do as well as
a logic level in volts. Where the contact wears, a stretch begins as far slid as the record had come.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePosixPath

import numpy as np
from scipy.integrate import cumulative_trapezoid

from evat.experiment import DISTANCE, FEWEST_ROWS, ExperimentError, Trial
from evat.experiment.document import TRIGGER
from evat.model import FloatArray
from evat.required_inputs import MOTION

WAY_DIGITS = 3  # of the way slid before: repeats that were started by hand have slid as far, and stay repeats of each other
LEAD_IN = 2_000  # rows at most: bristles, filters and a warm contact follow the motion; what was earlier is forgotten


def triggered(whole: Trial, header: str, wears: bool = False) -> list[Trial]:
    """The stretches of a recording in which its column `header`, kept among the outputs as the trigger, is on.

    wears : the nominal model goes by how far the contact has slid: each stretch then states it, where the motion was recorded.
    """
    column = whole.outputs[TRIGGER]
    high = float(column.max())
    if high <= 0:
        raise ExperimentError(f"{whole.file}, column {header!r}: the trigger is never on, it is at most {high:g}. Is it the right column?")
    on = np.concatenate([[False], column > 0.5 * high, [False]])
    begins, ends = np.flatnonzero(on[1:] & ~on[:-1]), np.flatnonzero(on[:-1] & ~on[1:])
    outputs = {name: each for name, each in whole.outputs.items() if name != TRIGGER}
    trials, before, slid = list[Trial](), 0, _slid(whole) if wears else None
    for count, (begin, end) in enumerate(zip(begins, ends, strict=True), 1):
        if end - begin < FEWEST_ROWS:
            raise ExperimentError(
                f"{whole.file}, column {header!r}, data row {begin + 1}: the trigger is on for {end - begin} rows only; a recording has at "
                f"least {FEWEST_ROWS}. Does it bounce? Correct the column."
            )
        path = PurePosixPath(whole.file)
        name = whole.file if begins.size == 1 else str(path.with_name(f"{path.stem}-part{count}{path.suffix}"))
        first = max(before, int(begin) - LEAD_IN)
        lead_in = _cut(whole, outputs, name, slice(first, begin)) if begin > first else None
        trial = _cut(whole, outputs, name, slice(begin, end))
        values = dict(whole.values) if slid is None else {**whole.values, DISTANCE: float(f"{slid[first]:.{WAY_DIGITS}g}")}
        lead_in = None if lead_in is None else replace(lead_in, values=values)
        trials.append(replace(trial, values=values, lead_in=lead_in, noise_sd=whole.noise_sd))
        before = int(end)
    return trials


def _cut(whole: Trial, outputs: Mapping[str, FloatArray], name: str, at: slice) -> Trial:
    inputs, kept = ({key: column[at] for key, column in some.items()} for some in (whole.inputs, outputs))
    return replace(whole, file=name, times=whole.times[at], inputs=inputs, outputs=kept)


def _slid(whole: Trial) -> FloatArray | None:
    """How far (n,) the contact has slid in a recording at each of its rows, and before it where that is stated [m]; None where its motion
    was not recorded."""
    if MOTION not in whole.inputs:
        return None
    way: FloatArray = whole.values.get(DISTANCE, 0.0) + cumulative_trapezoid(np.abs(whole.inputs[MOTION]), whole.times, initial=0.0)
    return way
