"""Which effects are no more than another form of the base law? Those in which friction laws differ anyway, as long as they do little."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.fit import Fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction
from evat.inference.whitening import Whitening


def with_form_of_law(
    prediction: Prediction, whitening: Whitening, recalibrated: Fit, models: Mapping[Hypothesis, Fit]
) -> tuple[Fit, dict[Hypothesis, Fit]]:
    """The recalibrated model and all others, each with what of its best fit is the form of the base law; sets with an effect that is only
    that are gone."""
    forms = {effect.name for effect in prediction.model.effects if effect.form_of_law}
    base, kept = recalibrated, dict(models)
    for on, fit in models.items():
        own = forms.intersection(on.effects)
        rest = Hypothesis(tuple(name for name in on.effects if name not in own), on.law)
        beside = models.get(rest) if rest else recalibrated
        if not own or beside is None or _share(prediction, whitening, fit, beside) > CONSTANTS.form_of_law:
            continue
        del kept[on]
        if fit.likelihood.evidence <= beside.likelihood.evidence:
            continue
        if not rest:
            base = max(base, fit, key=lambda each: each.likelihood.evidence)
        else:
            kept[rest] = max(kept[rest], fit, key=lambda each: each.likelihood.evidence)
    return base, kept


def _share(prediction: Prediction, whitening: Whitening, fit: Fit, beside: Fit) -> float:
    """The largest difference of both in a channel, in the root mean square of what was measured there."""
    apart = fit.predicted - beside.predicted
    return max(
        float(np.sqrt(np.mean(apart[prediction.places(channel)] ** 2))) / whitening.levels[channel] for channel in prediction.channels
    )
