"""Which part of long records does a search look at? Excerpts from their start to their end; the polish sees all.

A search only has to find the valley in which the optimum lies. That some thousand samples tell, as long as they come from everywhere,
and each excerpt follows a lead-in, from which it begins with bristles and filters as they stood there. Where something goes by the time or
the way itself, an excerpt would begin without what was before it, and a vibration that the model makes is short: these are looked at whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from evat.experiment import Experiment, Trial
from evat.inference.prediction import Prediction
from evat.model import Model

LOOKED_AT = 20_000  # samples that one value set takes, in all trials that differ
FEWEST = 500  # of a trial, whatever their number
EXCERPTS = 8  # of a long trial
LEAD_IN = 100  # samples
WORTHWHILE = 0.5  # of the whole: more is looked at whole


def excerpts(experiment: Experiment, model: Model, on: Sequence[str]) -> Experiment | None:
    """The experiment with its trials cut to excerpts, None where the whole is to be looked at. on : effects beside the nominal ones."""
    acting = {*experiment.nominal.effects, *on}
    unsteady = any(effect.unsteady for effect in model.effects if effect.name in acting)
    values = experiment.nominal.values
    if unsteady or any(np.isfinite(model.cycle_time({**values, **trial.values})) for trial in experiment.trials):
        return None
    alike = Prediction(model, experiment).alike
    sizes = {key: experiment.trials[place].times.size for place, key in alike.items()}
    quota = max(_quota(list(sizes.values())), FEWEST)
    if sum(min(size, quota) for size in sizes.values()) > WORTHWHILE * sum(sizes.values()):
        return None
    return replace(experiment, trials=tuple(part for trial in experiment.trials for part in _parts(trial, quota)))


def _quota(sizes: Sequence[int]) -> int:
    """Samples of a trial such that all together are as many as are looked at; short ones leave more to the long ones."""
    left = LOOKED_AT
    for place, size in enumerate(ordered := sorted(sizes)):
        share = left // (len(ordered) - place)
        if size > share:
            return share
        left -= size
    return left


def _parts(trial: Trial, quota: int) -> list[Trial]:
    """Excerpts of one length, the first of which begins and the last of which ends with the trial."""
    count = trial.times.size
    if count <= quota:
        return [trial]
    number = min(EXCERPTS, max(quota // FEWEST, 1))
    length = quota // number
    begins = np.linspace(0, count - length, number).astype(int) if number > 1 else np.array([0])
    return [_part(trial, int(begin), int(begin) + length) for begin in begins]


def _part(trial: Trial, begin: int, end: int) -> Trial:
    if begin == 0:
        return trial.head(end)
    lead = trial.between(max(begin - LEAD_IN, 0), begin)
    return replace(trial.between(begin, end), file=f"{trial.file} from sample {begin}", lead_in=replace(lead, lead_in=None))
