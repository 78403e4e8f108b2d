"""Is every model as likely as it can be, and as those that it contains? A local optimum is none of what its effects explain."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.recalibration import farthest_shift, nominal_place
from evat.inference.band_whitening import BandWhitening
from evat.inference.fit import Fit, fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction
from evat.model import FloatArray


def polish(prediction: Prediction, whitening: BandWhitening, recalibrated: Fit, models: dict[Hypothesis, Fit]) -> None:
    """Where values stand in for effects, the best models begin without that once more. A model that came less far than one that it contains
    starts from there: nothing is less likely for what it may do besides. And where a pair went further than its first effect alone, that
    goes on from there: a second effect is not paid for a longer way."""
    _begin_at_nominal_values(prediction, whitening, recalibrated, models)
    for key in [key for key in models if len(key) == 1 and key.effects]:
        models[key] = at_least(prediction, whitening, models[key], recalibrated)
    _go_on_from_pairs(prediction, whitening, models)
    for key in [key for key in models if len(key) > 1]:
        parts = [models[part] for part in key.parts() if part in models]
        if parts:
            models[key] = at_least(prediction, whitening, models[key], max(parts, key=lambda part: part.likelihood.log))


def _begin_at_nominal_values(prediction: Prediction, whitening: BandWhitening, recalibrated: Fit, models: dict[Hypothesis, Fit]) -> None:
    """Where recalibration moved values further than anybody can have meant, these stand in for an effect, and no step may lead back from
    them: the best models begin at the nominal values once more, where their effects first do what they can alone."""
    if farthest_shift(prediction, recalibrated) <= CONSTANTS.credible_shift:
        return
    nominal = {parameter.name for parameter in recalibrated.parameters}
    for key in sorted(models, key=lambda on: -models[on].likelihood.evidence)[: CONSTANTS.fits_from_nominal_values]:
        model = models[key]
        known = zip(model.parameters, map(float, model.point), strict=True)
        begin = {p.name: nominal_place(prediction, p, u) for p, u in known if p.name in nominal}
        alone = _with_held(prediction, whitening, model, begin)
        start = np.array([begin.get(p.name, float(u)) for p, u in zip(model.parameters, alone, strict=True)])
        models[key] = max(model, _from(prediction, whitening, model, start), key=lambda each: each.likelihood.evidence)


def _with_held(prediction: Prediction, whitening: BandWhitening, whole: Fit, held: Mapping[str, float]) -> FloatArray:
    """The best point (p,) of a model some of whose parameters are held, at so many prior standard deviations; its own where none is."""
    free = [place for place, parameter in enumerate(whole.parameters) if parameter.name not in held]
    values = {p.name: p.value(held[p.name]) for p in whole.parameters if p.name in held}
    parameters = [whole.parameters[place] for place in free]
    alone = fit(prediction, whitening, parameters, whole.point[free], whole.on, fixed={**whole.fixed, **values})
    point = whole.point.copy()
    if alone is not None:
        point[free] = alone.point
    return point


def at_least(prediction: Prediction, whitening: BandWhitening, whole: Fit, part: Fit) -> Fit:
    """A fit that is about as likely as one that it contains: else from where that is, with its other parameters as they are, or where
    they do nothing."""
    if not {p.name for p in part.parameters} <= {p.name for p in whole.parameters}:
        return whole
    known = {parameter.name: float(u) for parameter, u in zip(part.parameters, part.point, strict=True)}
    neutral = {v.name for effect in prediction.model.effects for v in effect.variables if math.isfinite(v.neutral)}
    as_it_is = np.array([known.get(p.name, float(u)) for p, u in zip(whole.parameters, whole.point, strict=True)])
    idle = np.array([known.get(p.name, 0.0 if p.name in neutral else float(u)) for p, u in zip(whole.parameters, whole.point, strict=True)])
    best = whole
    for start in (as_it_is, idle):
        if best.likelihood.log >= part.likelihood.log - CONSTANTS.lost_likelihood:
            break
        best = max(best, _from(prediction, whitening, whole, start), key=lambda each: each.likelihood.log)
    return best


def _from(prediction: Prediction, whitening: BandWhitening, whole: Fit, start: FloatArray) -> Fit:
    return fit(prediction, whitening, whole.parameters, start, whole.on, fixed=whole.fixed) or whole


def _go_on_from_pairs(prediction: Prediction, whitening: BandWhitening, models: dict[Hypothesis, Fit]) -> None:
    pairs = {key: model for key, model in models.items() if len(key) > 1}
    best = max((model.likelihood.evidence for key, model in models.items() if len(key) == 1), default=0.0)
    for key, base in list(models.items()):
        further = [pair for pair in pairs.values() if {p.name for p in base.parameters} <= {p.name for p in pair.parameters}]
        if len(key) > 1 or not further:
            continue
        whole = max(further, key=lambda pair: pair.likelihood.evidence)
        if max(base.likelihood.evidence, whole.likelihood.evidence) < best - CONSTANTS.hopeless_deficit:
            continue
        values = whole.values
        start = np.array([p.place(float(values[p.name])) for p in base.parameters])
        again = fit(prediction, whitening, base.parameters, start, base.on, fixed=base.fixed)
        if again is not None and again.likelihood.log > base.likelihood.log:
            models[key] = again
