"""What is a gap made of? Mean squares of each channel: noise, repeatability, numerical error, mis-tuning, set-up, effects, unexplained."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from evat.gap.budget import squares
from evat.gap.search.compare import Comparison
from evat.inference.fit import Fit

TITLES = {
    "noise": "noise",
    "repeatability": "repeatability",
    "numerical": "numerical error",
    "mistuning": "mis-tuning",
    "set_up": "set-up",
    "form": "form of the law",
    "effect": "named effects",
    "unexplained": "unexplained",
}


@dataclass(frozen=True, slots=True)
class Parts:
    """Mean squares [unit squared] whose sum is that of measured less nominal, in a single recording."""

    noise: float
    repeatability: float
    numerical: float
    mistuning: float
    set_up: float
    form: float
    effect: float
    unexplained: float

    @property
    def total(self) -> float:
        return float(sum(getattr(self, name) for name in TITLES))

    def rms(self, name: str) -> float:
        """A part alone; parts add up in squares."""
        return math.sqrt(getattr(self, name))

    def share(self, name: str) -> float:
        return float(getattr(self, name) / self.total) if self.total > 0 else 0.0


def parts(comparison: Comparison, chosen: Fit) -> dict[str, Parts]:
    """Of each channel, over all conditions; a part that a fit has made larger in one channel, for the sake of another, counts as 0.

    Mis-tuning, set-up, form of the law and effects are parts of what the chosen model changes, each as far as it goes the way of the whole
    change: what recalibration alone would take up in place of an effect that is named is no mis-tuning.
    """
    whitening = comparison.whitening
    nominal, corrected = (squares(whitening, fit.predicted) for fit in (comparison.nominal, chosen))
    wrong, changes = numerical_error(comparison, chosen), _shares_of_change(comparison, chosen)
    by_channel = {}
    for channel, start in nominal.items():
        left = corrected[channel].structural
        numerical = min(left, wrong.get(channel, 0.0))
        explained = max(start.structural - left, 0.0)
        structure = {
            "numerical": numerical,
            **{name: share * explained for name, share in changes[channel].items()},
            "unexplained": left - numerical,
        }
        # Structure is measured away from jumps; here it is brought to all samples.
        size, rest = sum(structure.values()), max(start.left - start.floor, 0.0)
        scale = rest / size if size > 0 else 0.0
        by_channel[channel] = Parts(start.noise, start.repeatability, **{name: scale * part for name, part in structure.items()})
    return by_channel


def _shares_of_change(comparison: Comparison, chosen: Fit) -> dict[str, dict[str, float]]:
    """Of what the chosen model changes in each channel, the shares that its effects, or its other base law, do, then the set-up, then forms
    that no law has, and nominal values the rest: 0 to 1, in all 1."""
    prediction = comparison.prediction
    own = {variable.name for effect in prediction.model.effects if effect.name in chosen.on for variable in effect.variables}
    bare = {name: value for name, value in chosen.values.items() if name not in own and name not in chosen.fixed}
    without = {name: value for name, value in bare.items() if name not in prediction.setup_names}
    told = {name: value for name, value in without.items() if name not in prediction.form_names}
    added, plain = bool(chosen.on or chosen.fixed), prediction.sampled_at({})
    rows = [
        chosen.predicted,
        prediction.one(bare) if added else chosen.predicted,
        plain.one(without),
        plain.one(told),
        comparison.nominal.predicted,
    ]
    names = ("effect", "set_up", "form", "mistuning")  # what is missing from row to row
    shares = {}
    for channel in prediction.channels:
        at = prediction.places(channel)
        whole = rows[0][at] - rows[-1][at]
        parts = {name: float((above[at] - below[at]) @ whole) for name, above, below in zip(names, rows[:-1], rows[1:], strict=True)}
        size = float(whole @ whole)
        effects = parts.pop("effect") / size if size > 0 else 0.0
        effects = min(max(effects, 0.0), 1.0) if math.isfinite(effects) else 1.0
        along = {name: part if part > 0 and math.isfinite(part) else 0.0 for name, part in parts.items()}
        total = sum(along.values())
        rest = {name: part / total for name, part in along.items()} if total > 0 else {"mistuning": 1.0, "set_up": 0.0, "form": 0.0}
        shares[channel] = {"effect": effects, **{name: (1 - effects) * share for name, share in rest.items()}}
    return shares


def numerical_error(comparison: Comparison, chosen: Fit) -> dict[str, float]:
    """Mean square that a finer solver changes [unit squared]; nothing where the model has no tolerance to set."""
    prediction = comparison.prediction
    change = np.nan_to_num(prediction.numerical_error(chosen.values, chosen.on))
    sums, counts = dict[str, float](), dict[str, int]()
    for segment in prediction.segments:
        sums[segment.channel] = sums.get(segment.channel, 0.0) + float(np.sum(change[segment.at] ** 2))
        counts[segment.channel] = counts.get(segment.channel, 0) + segment.at.stop - segment.at.start
    return {channel: total / counts[channel] for channel, total in sums.items()}
