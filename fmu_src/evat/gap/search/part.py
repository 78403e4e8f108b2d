"""On which part of the data are effects looked for? One run of each condition, as far as a quick look needs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap.search.portion import portion
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.fit import Fit
from evat.inference.noise.estimate import Noise
from evat.inference.prediction import Prediction
from evat.model import FloatArray


@dataclass(frozen=True)
class SearchedPart:
    """`prediction` of some trials' heads; `rows` (n,) is where its numbers stand in the long vector of the whole."""

    prediction: Prediction
    rows: npt.NDArray[np.intp]

    def whitening(self, whole: BandWhitening, predicted: FloatArray, numerical: FloatArray, by_inputs: FloatArray | None) -> BandWhitening:
        """With the noise of the whole. predicted, numerical, by_inputs : of the whole, (N,)."""
        noise, sizes = whole.noise, np.empty(len(self.prediction.segments))
        starts = {segment.at.start: place for place, segment in enumerate(whole.prediction.segments)}
        for place, segment in enumerate(self.prediction.segments):
            sizes[place] = noise.sizes[starts[int(self.rows[segment.at.start])]]
        own = Noise(noise.filters, sizes, noise.spread, noise.degrees, noise.irregular)
        inputs = None if by_inputs is None else by_inputs[self.rows]
        return BandWhitening(self.prediction, own, predicted[self.rows], numerical[self.rows], inputs)

    def fit(self, whole: Fit, whitening: BandWhitening) -> Fit:
        """A fit to the whole as it stands here."""
        predicted, slopes = whole.predicted[self.rows], whole.slopes[self.rows]
        sums = whitening.sums(predicted, slopes)
        return replace(whole, predicted=predicted, slopes=slopes, sums=sums, likelihood=likelihood(whitening, sums, whole.point))


def part_of(prediction: Prediction) -> SearchedPart | None:
    """None where the whole is no more than a quick look, or where each trial has something of its own."""
    if prediction.apart:
        return None
    experiment, kept = prediction.experiment, list[int]()
    run_of = dict[str, bytes]()
    for place, trial in enumerate(experiment.trials):
        if run_of.setdefault(trial.condition, prediction.alike[place]) == prediction.alike[place]:
            kept.append(place)
    some = replace(experiment, trials=tuple(experiment.trials[place] for place in kept))
    part, _ = portion(some, prediction.model, CONSTANTS.searched_samples)
    if _simulated(part, prediction) > CONSTANTS.worthwhile_part * _simulated(experiment, prediction):
        return None
    smaller = prediction.of(part)
    starts = {(segment.trial, segment.channel): segment.at.start for segment in prediction.segments if segment.trial >= 0}
    recorded = [s for s in smaller.segments if s.trial >= 0]
    rows = [starts[kept[s.trial], s.channel] + np.arange(s.at.stop - s.at.start) for s in recorded]
    rows.append(np.array([at for s in prediction.segments if s.trial < 0 for at in range(s.at.start, s.at.stop)], dtype=np.intp))
    index = np.concatenate(rows).astype(np.intp)
    linearised = [replace(each, column=each.column[index]) for each in prediction.linearised]
    bent = smaller.starting(prediction.starts, prediction.bent[index], prediction.steady)
    return SearchedPart(bent.linearise(linearised), index)


def _simulated(experiment: Experiment, prediction: Prediction) -> int:
    """Samples that one value set takes."""
    keys = Prediction(prediction.model, experiment).alike
    return sum({keys[place]: trial.times.size for place, trial in enumerate(experiment.trials)}.values())
