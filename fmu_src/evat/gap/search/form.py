"""Which effects are no more than another form of the base law? Those in which friction laws differ anyway, as long as they do little, and
the law does without them at values that its owner can have meant."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.recalibration import farthest_shift
from evat.inference.band_whitening import BandWhitening
from evat.inference.fit import Fit, fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction


def with_form_of_law(
    prediction: Prediction, whitening: BandWhitening, recalibrated: Fit, models: Mapping[Hypothesis, Fit]
) -> tuple[Fit, dict[Hypothesis, Fit], dict[str, float]]:
    """The recalibrated model and all others, each with what of its best fit is the form of the base law; sets with an effect that is only
    that are gone, and stand for what is left of them. And how far the forms that were tried alone are from the base law as it was fitted
    [of the rms of a channel]."""
    forms = {effect.name for effect in prediction.model.effects if effect.form_of_law}
    base, kept, alone, shares = recalibrated, dict(models), dict[Hypothesis, Fit | None](), dict[str, float]()
    for on, whole in models.items():
        own = forms.intersection(on.effects)
        if not own:
            continue
        rest = Hypothesis(tuple(name for name in on.effects if name not in own), on.law)
        if rest not in alone:
            alone[rest] = (models.get(rest) or without(prediction, whitening, whole, own)) if rest else recalibrated
        beside = alone[rest]
        share = np.inf if beside is None else _share(prediction, whitening, whole, beside)
        if beside is None or share > CONSTANTS.accuracy_of_laws or _makes_credible(prediction, whole, beside):
            continue
        del kept[on]
        if not rest:
            shares.update(dict.fromkeys(own, share))
            base = max(base, _formed(whole), key=lambda each: each.likelihood.evidence)
        else:
            kept[rest] = max(kept.get(rest, beside), _formed(whole), key=lambda each: each.likelihood.evidence)
    return base, kept, shares


def _makes_credible(prediction: Prediction, whole: Fit, beside: Fit) -> bool:
    """Does the law without the effects do as much only at values that its owner cannot have meant, where it needs none with them?"""
    return farthest_shift(prediction, whole) <= CONSTANTS.credible_shift < farthest_shift(prediction, beside)


def _formed(whole: Fit) -> Fit:
    """As unlikely a priori as another form of the base law is."""
    return replace(whole, likelihood=replace(whole.likelihood, evidence=whole.likelihood.evidence - CONSTANTS.evidence_of_form))


def without(prediction: Prediction, whitening: BandWhitening, whole: Fit, effects: Collection[str]) -> Fit | None:
    """A fit without some of its effects, fitted anew."""
    own = {v.name for effect in prediction.model.effects if effect.name in effects for v in effect.variables}
    kept = [place for place, parameter in enumerate(whole.parameters) if parameter.name not in own]
    on = [effect for effect in whole.on if effect not in effects]
    return fit(prediction, whitening, [whole.parameters[place] for place in kept], whole.point[kept], on, fixed=whole.fixed)


def _share(prediction: Prediction, whitening: BandWhitening, whole: Fit, beside: Fit) -> float:
    """The largest difference of both in a channel, in the root mean square of what was measured there."""
    apart = whole.predicted - beside.predicted
    return max(
        float(np.sqrt(np.mean(apart[prediction.places(channel)] ** 2))) / whitening.levels[channel] for channel in prediction.channels
    )
