"""How much of a long record is looked at? The head of every trial, as long as a diagnosis is to take seconds and no longer than shows its
motion, and the answer says so."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import chain, zip_longest

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Trial
from evat.inference.prediction import Prediction
from evat.model import Model
from evat.required_inputs import MOTION


def portion(experiment: Experiment, model: Model, samples: float) -> tuple[Experiment, str]:
    """The experiment with its trials cut to what can be looked at, and a note of that; "" where nothing was cut.

    samples : that are simulated, up to CONSTANTS.longer_heads times as many where trials show their motion late.
    """
    alike = Prediction(model, experiment).alike
    sizes = {key: experiment.trials[place].times.size for place, key in alike.items()}
    total = sum(sizes.values())
    if total <= samples:
        return experiment, ""
    samples = int(samples)
    most = samples // len(sizes)
    while True:  # short trials leave more for the long ones
        left = samples - sum(size for size in sizes.values() if size <= most)
        longer = sum(size > most for size in sizes.values())
        if not longer or left // longer <= most:
            break
        most = left // longer
    heads = [trial.head(max(most, 2)) for trial in experiment.trials]
    late = shown_late(experiment.trials, heads)
    moving = [with_its_motion(whole, head, late) for whole, head in zip(experiment.trials, heads, strict=True)]
    longer_ones = _longer(heads, moving, alike, CONSTANTS.longer_heads * samples)
    heads = [moving[place] if alike[place] in longer_ones else head for place, head in enumerate(heads)]
    return replace(experiment, trials=tuple(heads)), _note(experiment.trials, heads)


def _longer(heads: Sequence[Trial], moving: Sequence[Trial], alike: Mapping[int, bytes], samples: float) -> set[bytes]:
    """Of which runs the longer heads are taken, where those of all are more than so many samples: the shortest of each condition come
    first, since one that goes back tells what all others show at one way.

    alike : what trials share that are one run, by their places.
    """
    run_at = {key: place for place, key in alike.items()}
    size, grown = ({key: some[place].times.size for key, place in run_at.items()} for some in (heads, moving))
    of_condition = dict[str, list[bytes]]()
    for key, place in sorted(run_at.items(), key=lambda each: grown[each[0]] - size[each[0]]):
        of_condition.setdefault(heads[place].condition, []).append(key)
    taken, total = set[bytes](), sum(size.values())
    for key in filter(None, chain.from_iterable(zip_longest(*of_condition.values()))):
        if total + grown[key] - size[key] <= samples:
            taken.add(key)
            total += grown[key] - size[key]
    return taken


def as_long_as(experiment: Experiment, cut: Experiment) -> Experiment:
    """The experiment with its trials as long as those of `cut`."""
    heads = (trial.head(head.times.size) for trial, head in zip(experiment.trials, cut.trials, strict=True))
    return replace(experiment, trials=tuple(heads))


def _note(trials: Sequence[Trial], heads: Sequence[Trial]) -> str:
    sizes = {head.times.size for whole, head in zip(trials, heads, strict=True) if head.times.size < whole.times.size}
    if not sizes:
        return ""
    span = f"{min(sizes)}" if len(sizes) == 1 else f"{min(sizes)} to {max(sizes)}"
    return f"only the first {span} samples of each trial were looked at; --whole takes all"


def shown_late(trials: Sequence[Trial], heads: Sequence[Trial]) -> set[str]:
    """Inputs beside the motion, as a load or a temperature, that all heads together show too little of."""

    def spans(some: Sequence[Trial], name: str) -> float:
        columns = [trial.inputs[name] for trial in some if name in trial.inputs]
        return float(max(map(np.max, columns)) - min(map(np.min, columns)))

    names = {name for trial in trials for name in trial.inputs} - {MOTION}
    return {name for name in names if spans(heads, name) < CONSTANTS.shown_range * spans(trials, name)}


def with_its_motion(whole: Trial, head: Trial, late: Collection[str] = ()) -> Trial:
    """The head, or a longer one that goes back, too, and as fast, where the whole does: as long as what is done at one way is seen at one
    only, an offset is friction, and so is an asymmetry; nor do slow plateaus tell what friction does at the fast ones that follow.

    late : other inputs that have to be shown as far.
    """
    if head.times.size == whole.times.size:
        return head
    enough = np.ones(whole.times.size, dtype=np.bool_)
    if MOTION in whole.inputs:
        slip = whole.inputs[MOTION]
        forward, backward = (np.cumsum(np.maximum(sign * slip, 0.0)) for sign in (1, -1))
        lesser, both, fastest = np.minimum(forward, backward), forward + backward, np.maximum.accumulate(np.abs(slip))
        enough &= lesser >= CONSTANTS.way_back * both * (lesser[-1] / max(both[-1], np.finfo(float).tiny))
        enough &= fastest >= CONSTANTS.shown_range * fastest[-1]
    for name in set(late) & set(whole.inputs):
        column = whole.inputs[name]
        shown = np.maximum.accumulate(column) - np.minimum.accumulate(column)
        enough &= shown >= CONSTANTS.shown_range * shown[-1]
    first = np.flatnonzero(enough[head.times.size - 1 :])
    return whole.head(head.times.size + int(first[0])) if first.size else whole
