"""What is there for certain and yet too small to matter? An effect that is named with its size, beside the verdict or in it.

The verdict asks how large a gap is; evidence asks how sure. A small effect with much evidence is told beside a verdict of no gap or of
mis-tuning, which stays: the probabilities were calibrated without it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.compare import Comparison
from evat.gap.verdict.judgement import EFFECT, MISTUNED, NO_GAP, Judgement
from evat.inference.hypothesis import Hypothesis


@dataclass(frozen=True)
class SmallEffect:
    """What changes no channel by more than `share_of_rms`; `either` is what it is, or may be; `log_evidence` that over none."""

    either: tuple[Hypothesis, ...]
    channel: str
    share_of_rms: float
    log_evidence: float


def small_effect(comparison: Comparison, judgement: Judgement) -> SmallEffect | None:
    """The effect that was named, if it is small; where none was, one that is certain all the same and that nothing speaks against."""
    features = judgement.features
    either: tuple[Hypothesis, ...]
    if judgement.verdict == EFFECT:
        either = (judgement.chosen,)
    elif judgement.verdict in (NO_GAP, MISTUNED):
        singles = {on: gain for on, gain in features.gain.items() if len(on) == 1 and on.effects}
        best = max(singles.values(), default=0.0)
        either = tuple(sorted((on for on, gain in singles.items() if gain > best - CONSTANTS.rival_deficit), key=lambda on: -singles[on]))
        # Doubts are known of what was tried on held-out conditions.
        if best < CONSTANTS.certain_evidence or any(features.doubts.get(on, ("not tried",)) for on in either):
            return None
    else:
        return None
    base, predicted = comparison.recalibrated.predicted, comparison.models[either[0]].predicted
    shares = {}
    for channel, level in comparison.whitening.levels.items():
        at = comparison.prediction.places(channel)
        shares[channel] = float(np.sqrt(np.mean((predicted[at] - base[at]) ** 2))) / level
    channel = max(shares, key=lambda each: shares[each])
    if shares[channel] > CONSTANTS.small_share:
        return None
    return SmallEffect(either, channel, shares[channel], features.gain[either[0]])
