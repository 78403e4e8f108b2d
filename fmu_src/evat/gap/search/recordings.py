"""Is a recording what its owner takes it for? Clipped, turned round or out of step with its repeats it would be taken for physics."""

from __future__ import annotations

import numpy as np
from scipy import signal

from evat.constants import CONSTANTS
from evat.inference.prediction import Prediction, Segment
from evat.model import FloatArray


def misrecorded(prediction: Prediction, predicted: FloatArray) -> tuple[list[str], list[str]]:
    """Why recordings cannot be judged, and what is to be known of those that can. predicted : (N,), by the nominal model."""
    refused, notes = list[str](), list[str]()
    for channel in prediction.channels:
        own = [segment for segment in prediction.segments if segment.channel == channel and segment.trial >= 0]
        if not own:
            continue
        measured = np.concatenate([prediction.measured[segment.at] for segment in own])
        if (share := clipped_share(measured)) > CONSTANTS.clipped_share:
            (refused if share > CONSTANTS.mostly_clipped else notes).append(
                f"{channel}: {100 * share:.2g} % of the samples stand at its largest or smallest value, as of a sensor, an amplifier or a "
                "converter at the end of its range; what lies beyond is cut off"
            )
        refused += _turned(prediction, predicted, own)
        refused += _out_of_step(prediction, predicted, own)
    return refused, notes


def clipped_share(measured: FloatArray) -> float:
    """Of the samples, those at an end of a range: many at one value where the next, which is near, has few. Noise thins out towards its
    end, and what is rounded has neighbours that have as many."""
    share = 0.0
    for values in (measured, -measured):
        levels, counts = np.unique(values, return_counts=True)
        if levels.size < 2 or levels[-1] - levels[-2] > CONSTANTS.next_level * (levels[-1] - levels[0]):
            continue
        if counts[-1] >= CONSTANTS.fewest_clipped and counts[-1] > CONSTANTS.piled_up * counts[-2]:
            share += float(counts[-1]) / measured.size
    return share


def _turned(prediction: Prediction, predicted: FloatArray, own: list[Segment]) -> list[str]:
    """Recordings that run against the model where the others run with it, and are on the other side of zero: of a force that stays on one
    side the little that it varies may go by what the model lacks."""
    runs = {segment.trial: _alike(prediction.measured[segment.at], predicted[segment.at]) for segment in own}
    usual = float(np.median(list(runs.values())))
    beyond = [segment.trial for segment in own if float(prediction.measured[segment.at] @ predicted[segment.at]) < 0]
    against = [trial for trial in beyond if runs[trial] < -CONSTANTS.clearly_alike < CONSTANTS.clearly_alike < usual]
    files = [prediction.experiment.trials[trial].file for trial in against]
    if not files:
        return []
    return [f"{', '.join(files)}: {own[0].channel} runs against the model where it runs with it in the other recordings; check its sign"]


def _out_of_step(prediction: Prediction, predicted: FloatArray, own: list[Segment]) -> list[str]:
    """Repeats of one motion that are alike only once one of them is moved a little way, and that are then nearer to the model, too, which
    a level that jumps is not; what vibrates by itself waits for no trigger."""
    if prediction.jumps:
        return []
    first, said = dict[bytes, Segment](), list[str]()
    for segment in own:
        other = first.setdefault(prediction.alike[segment.trial], segment)
        one, two = prediction.measured[other.at], prediction.measured[segment.at]
        if other is segment or one.size != two.size or not _alike(one, two) > 0:
            continue
        together = signal.correlate(two - two.mean(), one - one.mean())
        lag = int(signal.correlation_lags(two.size, one.size)[int(np.argmax(together))])
        if not CONSTANTS.late_samples < abs(lag) < CONSTANTS.farthest_moved * one.size:
            continue
        lag = max(range(lag - CONSTANTS.late_samples, lag + CONSTANTS.late_samples + 1), key=lambda late: _moved(one, two, late))
        moved = _moved(one, two, lag)
        model = predicted[segment.at]
        nearer = [(_moved(with_, two, lag), _alike(with_, two)) for with_ in (one, model)]
        if moved > CONSTANTS.alike_once_moved and all(1 - after < CONSTANTS.nearer_once_moved * (1 - before) for after, before in nearer):
            files = [prediction.experiment.trials[each.trial].file for each in (segment, other)]
            how = f"{abs(lag)} samples {'later' if lag > 0 else 'earlier'}"
            said.append(f"{files[0]}: {segment.channel} comes {how} than in {files[1]}, of which it is a repeat; check its trigger")
    return said


def _moved(one: FloatArray, two: FloatArray, late: int) -> float:
    """How alike they are, the second by so many samples earlier, where both are."""
    return _alike(one[max(-late, 0) : one.size - max(late, 0)], two[max(late, 0) : two.size + min(late, 0)])


def _alike(one: FloatArray, two: FloatArray) -> float:
    """Their correlation; 0 where one of them stands still."""
    one, two = one - one.mean(), two - two.mean()
    size = float(np.sqrt((one @ one) * (two @ two)))
    return float(one @ two) / size if size > 0 else 0.0
