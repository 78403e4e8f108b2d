"""What of a comparison is judged? Structural squares, log evidence and shares left of every hypothesis, and why a fit is not credible."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from evat.constants import CONSTANTS
from evat.gap.budget import squares, structural_share
from evat.gap.search.candidates import of_one_family
from evat.gap.search.compare import Comparison
from evat.gap.verdict.credibility import largest_shift
from evat.inference.hypothesis import Hypothesis
from evat.inference.noise.estimate import estimate_noise
from evat.inference.noise.irregularity import Irregularity


@dataclass(frozen=True)
class Features:
    """What is judged. By channel, in its mean square: structural squares of the nominal and of the recalibrated model, the noise floor,
    and `unsure`, the standard deviation of a structural square by noise alone; `irregular`, what repeats do not share beside noise (in the
    same mean square), and `irregular_share` of all that they do not share; `exact`, log evidence of the nominal over the recalibrated
    model, both with set-up errors; `gain[hypothesis]`, the same of a hypothesis; `left[hypothesis]`, its share of the recalibrated model's
    structural squares; `held_out[hypothesis]`, the share that it leaves on conditions left out of its fit, as far as that is sure;
    `doubts[hypothesis]`, reasons why its fit is not credible; `shift` and `shifts[hypothesis]`, how far the recalibrated model and each
    hypothesis move a nominal value at most, or a parameter whose size in ordinary rigs is known, in its standard deviations; `numbers`,
    how many were measured; `one_family[hypothesis]`, whether an effect of the measurement stands in it beside another of its family;
    `general[hypothesis]`, how many of its effects have a special case that was compared, too."""

    nominal: Mapping[str, float]
    recalibrated: Mapping[str, float]
    floor: Mapping[str, float]
    unsure: Mapping[str, float]
    irregular: Mapping[str, float]
    irregular_share: Mapping[str, float]
    exact: float
    gain: Mapping[Hypothesis, float]
    left: Mapping[Hypothesis, float]
    held_out: Mapping[Hypothesis, float] = field(default_factory=dict)
    doubts: Mapping[Hypothesis, tuple[str, ...]] = field(default_factory=dict)
    shift: float = 0.0
    shifts: Mapping[Hypothesis, float] = field(default_factory=dict)
    numbers: float = math.inf
    one_family: Mapping[Hypothesis, bool] = field(default_factory=dict)
    general: Mapping[Hypothesis, int] = field(default_factory=dict)

    @property
    def overstated(self) -> float:
        """How far evidence overstates, from 0 (not at all) to 1. What is wrong with the form of an effect adds up in it over the samples
        of a recording, as if each told something new; a table of some means has little to add up."""
        return 1 / (1 + CONSTANTS.few_numbers / self.numbers)

    def left_at_least(self, on: Hypothesis) -> float:
        """The share that it leaves on the data it was fitted to, or, where that is more, on those that it was not."""
        return max(self.left[on], self.held_out.get(on, 0.0))

    def without(self, effect: str) -> Features:
        """As if the model did not have that effect: its sets are gone."""
        kept = [on for on in self.gain if effect not in on]
        return replace(self, gain={on: self.gain[on] for on in kept}, left={on: self.left[on] for on in kept})


def features(comparison: Comparison) -> Features:
    whitening, reference = comparison.whitening, comparison.recalibrated.predicted
    base, levels = comparison.recalibrated.likelihood.evidence, whitening.levels
    before, after = squares(whitening, comparison.set_up.predicted), squares(whitening, reference)
    irregular = _irregular(comparison)
    return Features(
        nominal={c: before[c].structural / levels[c] ** 2 for c in levels},
        recalibrated={c: after[c].structural / levels[c] ** 2 for c in levels},
        floor={c: after[c].floor / levels[c] ** 2 for c in levels},
        unsure={c: after[c].unsure / levels[c] ** 2 for c in levels},
        irregular={c: comes.square * comes.share / levels[c] ** 2 for c, comes in irregular.items()},
        irregular_share={c: comes.share for c, comes in irregular.items()},
        exact=comparison.set_up.likelihood.evidence - base,
        gain={on: fit.likelihood.evidence - base for on, fit in comparison.models.items()},
        left={on: structural_share(whitening, fit.predicted, reference) for on, fit in comparison.models.items()},
        shift=largest_shift(comparison, comparison.recalibrated),
        shifts={on: largest_shift(comparison, fit) for on, fit in comparison.models.items()},
        numbers=comparison.prediction.measured.size,
        one_family={on: of_one_family(comparison.prediction.model, on) for on in comparison.models},
        general=_general(comparison),
    )


def _general(comparison: Comparison) -> dict[Hypothesis, int]:
    cases = {effect.name: effect.special_cases for effect in comparison.prediction.model.effects}
    compared = {name for on in comparison.models for name in on.effects}
    return {on: sum(not compared.isdisjoint(set(cases[name]) - set(on.effects)) for name in on.effects) for on in comparison.models}


def _irregular(comparison: Comparison) -> dict[str, Irregularity]:
    """What repeats do not share and is no noise, channel by channel, as far as the likeliest model does not have it: a dynamometer that is
    struck at slightly different moments rings in lines."""
    best = max(comparison.models.values(), key=lambda fit: fit.likelihood.evidence, default=comparison.recalibrated)
    by_best = estimate_noise(comparison.prediction, best.predicted).irregular
    return {
        channel: min(comes, by_best[channel], key=lambda each: each.square * each.share)
        for channel, comes in comparison.noise.irregular.items()
    }
