"""How much of a long record is looked at? The head of every trial, as long as a diagnosis is to take seconds, and the answer says so."""

from __future__ import annotations

from dataclasses import replace

from evat.experiment import Experiment
from evat.inference.prediction import Prediction
from evat.model import Model


def portion(experiment: Experiment, model: Model, samples: float) -> tuple[Experiment, str]:
    """The experiment with its trials cut to what can be looked at, and a note of that; "" where nothing was cut.

    samples : that are simulated at most.
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
    note = f"only the first {most} samples of each trial were looked at; --whole takes all"
    return replace(experiment, trials=tuple(trial.head(max(most, 2)) for trial in experiment.trials)), note
