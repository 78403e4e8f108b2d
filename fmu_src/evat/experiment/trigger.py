"""Which rows of a recording count? Those in which a trigger is on; what was recorded just before leads a model there.

Each stretch of such rows is a recording of its own. Half of the trigger's largest value divides on from off, so that 0 and 1 do as well as
a logic level in volts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePosixPath

import numpy as np

from evat.experiment import FEWEST_ROWS, ExperimentError, Trial
from evat.experiment.document import TRIGGER
from evat.model import FloatArray

LEAD_IN = 2_000  # rows at most: bristles, filters and a warm contact follow the motion; what was earlier is forgotten


def triggered(whole: Trial, header: str) -> list[Trial]:
    """The stretches of a recording in which its column `header`, kept among the outputs as the trigger, is on."""
    column = whole.outputs[TRIGGER]
    high = float(column.max())
    if high <= 0:
        raise ExperimentError(f"{whole.file}, column {header!r}: the trigger is never on, it is at most {high:g}. Is it the right column?")
    on = np.concatenate([[False], column > 0.5 * high, [False]])
    begins, ends = np.flatnonzero(on[1:] & ~on[:-1]), np.flatnonzero(on[:-1] & ~on[1:])
    outputs = {name: each for name, each in whole.outputs.items() if name != TRIGGER}
    trials, before = list[Trial](), 0
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
        trials.append(replace(trial, lead_in=lead_in, noise_sd=whole.noise_sd))
        before = int(end)
    return trials


def _cut(whole: Trial, outputs: Mapping[str, FloatArray], name: str, at: slice) -> Trial:
    inputs, kept = ({key: column[at] for key, column in some.items()} for some in (whole.inputs, outputs))
    return replace(whole, file=name, times=whole.times[at], inputs=inputs, outputs=kept)
