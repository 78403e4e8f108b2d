"""Did a logger lose samples? What moved meanwhile is not known; between the rows that are there the motion is taken as straight."""

from __future__ import annotations

import numpy as np

from evat.experiment import Experiment
from evat.experiment.read import Scan

LONG_STEP = 10.0  # usual steps of a clock: a step that is longer lost samples,
MEAN_STEP = 2.0  # unless steps differ all over the recording, which is then thinned: their mean in usual steps


def skip(file: str, longest: float, usual: float, mean: float, sample: int, time: float) -> str:
    """What a clock skips after that sample, in a sentence, by its longest, usual and mean step [s]; "" where it runs through."""
    if not (longest > LONG_STEP * usual and mean <= MEAN_STEP * usual):
        return ""
    return (
        f"{file}: the clock skips {longest:.4g} s after sample {sample} (t = {time:.6g} s), where its usual step is {usual:.4g} s; "
        "the motion in between is taken as a straight line. If it was none, cut the file there into two trials."
    )


def skipped(scan: Scan) -> tuple[str, ...]:
    """The same as `skips` of an experiment that was scanned only."""
    return tuple(
        filter(
            None,
            (
                skip(each.file, each.longest, each.usual, (each.end - each.begin) / (each.rows - 1), each.longest_after, each.longest_from)
                for each in scan.trials
            ),
        )
    )


def skips(experiment: Experiment) -> tuple[str, ...]:
    """What the clocks of an experiment skip, a sentence for each recording that lost samples."""
    said = []
    for trial in experiment.trials:
        steps = np.diff(trial.times)
        if steps.size:
            place = int(np.argmax(steps))
            facts = float(steps[place]), float(np.median(steps)), float(steps.mean()), place + 1, float(trial.times[place])
            said.append(skip(trial.file, *facts))
    return tuple(filter(None, said))
