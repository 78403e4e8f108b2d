"""How far does the gap shrink by values alone, as corrected.ssv holds them? Run as they are, and with the set-up put right.

Fits know more than a parameter set can hold: gain, zero and clock of the set-up, a form that no law has, how each recording began, and
phases of its own. Who runs the model with corrected.ssv has none of these; who puts right what the set-up is off by has all but the form.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.compare import Comparison
from evat.inference.fit import Fit
from evat.inference.prediction import OWN
from evat.model import FloatArray


@dataclass(frozen=True)
class ValuesAlone:
    """`rms[channel]` of measured less what the nominal, the recalibrated and the corrected values give [unit of the channel];
    `closed_share` of what the recalibrated values leave above the noise, closed by the corrected ones, or these of the nominal ones' where
    nothing was added. Either as the set-up is, or with it put right."""

    rms: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    closed_share: float = math.nan


def replayed(comparison: Comparison, fit: Fit, set_up: bool = False) -> FloatArray:
    """(N,) what the model gives with the values of a fit, and nothing else of it; or with the set-up and how recordings began, too."""
    prediction = comparison.prediction
    if set_up:
        values = {name: value for name, value in fit.values.items() if name not in prediction.form_names - prediction.setup_names}
        # As it was fitted: at rest, next to nothing of the zero of a speed that is as likely of either sign turns the friction round.
        return prediction.running_the_law().one(values, fit.on)
    beside = prediction.setup_names | prediction.form_names
    values = {name: value for name, value in fit.values.items() if name not in beside and OWN not in name}
    return prediction.linearise(()).sampled_at({}).starting({}, None).one(values, fit.on)


def root_mean_squares(comparison: Comparison, predicted: FloatArray, conditions: Collection[str]) -> dict[str, float]:
    """Of measured less predicted, by channel, over the samples of some conditions: means over the repeats of each, as the noise floor is.
    One that was recorded oftener would else be in what is left by more than its noise is in the floor."""
    prediction, left = comparison.prediction, dict[str, list[FloatArray]]()
    for group in comparison.whitening.groups:
        if group.condition in conditions:
            repeats = [prediction.segments[member].at for member in group.members]
            squares = [(prediction.measured[at] - predicted[at]) ** 2 for at in repeats]
            left.setdefault(group.channel, []).append(np.mean(squares, axis=0))
    return {channel: float(np.sqrt(np.mean(np.concatenate(rows)))) for channel, rows in left.items()}


def values_alone(
    comparison: Comparison, chosen: Fit, conditions: Collection[str], floors: Mapping[str, float], set_up: bool = False
) -> ValuesAlone:
    """Over some conditions. floors : noise floor of each channel there, as an rms; set_up : with that put right."""
    nominal = comparison.set_up if set_up else comparison.nominal
    fits = {"nominal": nominal, "recalibrated": comparison.recalibrated, "corrected": chosen}
    rows = {name: root_mean_squares(comparison, replayed(comparison, fit, set_up), conditions) for name, fit in fits.items()}
    rms = {channel: {name: row[channel] for name, row in rows.items()} for channel in rows["nominal"]}
    before = "nominal" if chosen is comparison.recalibrated else "recalibrated"
    levels = comparison.whitening.levels
    squares = np.array([[rms[c][before], rms[c]["corrected"], floors[c]] for c in rms]) ** 2
    first, last, floor = (float(column @ [levels[c] ** -2 for c in rms]) for column in squares.T)
    seen = first > (1 + CONSTANTS.noise_floor_error) * floor
    return ValuesAlone(rms, (first - last) / (first - floor) if seen else math.nan)
