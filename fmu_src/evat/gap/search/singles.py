"""What explains each effect alone? Tried by linear sums, then with the base's slopes held, and the most promising fitted with all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.budget import is_visible, squares
from evat.gap.search.candidates import Candidates
from evat.gap.search.nested import at_least
from evat.gap.search.recalibration import farthest_shift, nominal_place
from evat.gap.search.starts.screen import Start
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import likelihood
from evat.inference.fit import Fit, Look, charged, fit, likeliest
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction
from evat.model import Effect, FloatArray


def try_singles(candidates: Candidates, acting: Sequence[Effect]) -> None:
    """Fit the effects that promise most; those that do nothing here or lack inputs are told apart.

    acting : effects that may do something here.
    """
    screened = _screened(candidates, acting)
    _start(candidates, screened)
    _fit_promising(candidates)
    _fit_from_nominal_values(candidates, [effect for effect in acting if effect.name in candidates.fronts])


def _screened(candidates: Candidates, acting: Sequence[Effect]) -> dict[str, list[Start]]:
    """Where each effect starts."""
    prediction, recalibrated = candidates.prediction, candidates.recalibrated
    screened = dict[str, list[Start]]()
    for place, effect in enumerate(acting):
        candidates.tell(f"trying {effect.name}", 0.1 + 0.3 * place / len(acting))
        values = {**prediction.nominal, **recalibrated.values}
        if lacking := prediction.model.missing_inputs([effect.name], values, prediction.experiment.given):
            candidates.unfed[effect.name] = tuple(lacking)
        elif starts := candidates.screen.starts(recalibrated, effect):
            screened[effect.name] = starts
        else:
            candidates.silent.append(effect.name)
    return screened


def _start(candidates: Candidates, screened: dict[str, list[Start]]) -> None:
    """The evidence of each effect, roughly, and the point from which it is fitted: of those that promise anything with the base's slopes
    held."""
    recalibrated, base = candidates.recalibrated, candidates.without_effects
    most = max([starts[0].evidence - base for starts in screened.values()], default=0.0)
    enough = max(CONSTANTS.least_share_of_gain * most - CONSTANTS.hopeless_deficit, CONSTANTS.cost_of_no_effect)
    for place, (name, starts) in enumerate(screened.items()):
        candidates.tell(f"trying {name}", 0.4 + 0.2 * place / len(screened))
        key = Hypothesis((name,))
        candidates.rough[key] = starts[0].evidence
        candidates.fronts[name] = starts[0], np.concatenate([recalibrated.point, starts[0].point])
        if starts[0].evidence - base < enough:
            continue
        frozen = [
            (front, start)
            for start in _apart(starts)
            if (front := _frozen(candidates.prediction, candidates.whitening, recalibrated, start))
        ]
        if frozen:
            front, start = max(frozen, key=lambda pair: pair[0].likelihood.evidence)
            candidates.rough[key], candidates.fronts[name] = front.likelihood.evidence, (start, front.point)


def _fit_promising(candidates: Candidates) -> None:
    """The most promising effects, each with all parameters."""
    rough, recalibrated, base = candidates.rough, candidates.recalibrated, candidates.without_effects
    order = sorted(candidates.fronts, key=lambda name: -rough[Hypothesis((name,))])
    best = max([base, *rough.values()])
    hopeless = best - max(CONSTANTS.hopeless_deficit, CONSTANTS.error_of_linear_gain * (best - base))
    for place, name in enumerate(order[: CONSTANTS.full_fits]):
        candidates.tell(f"fitting {name}", 0.6 + 0.15 * place / CONSTANTS.full_fits)
        if rough[Hypothesis((name,))] < hopeless and place > 1:
            break
        start, point = candidates.fronts[name]
        whole = candidates.fit_beside(recalibrated, start, point, (name,))
        if whole is not None:
            candidates.models[Hypothesis((name,))] = at_least(candidates.prediction, candidates.whitening, whole, recalibrated)


def _fit_from_nominal_values(candidates: Candidates, effects: Sequence[Effect]) -> None:
    """Effects beside the nominal values, too, where recalibration went so far that these were not credible, or where no effect explains
    what can be seen: values and clocks that stand in for an effect may be where no step leads back to it."""
    prediction, whitening, recalibrated = candidates.prediction, candidates.whitening, candidates.recalibrated
    if farthest_shift(prediction, recalibrated) <= CONSTANTS.credible_shift and not _leaves_a_gap(candidates):
        return
    begin = [
        nominal_place(prediction, parameter, float(u)) for parameter, u in zip(recalibrated.parameters, recalibrated.point, strict=True)
    ]
    base = fit(prediction, whitening, recalibrated.parameters, np.array(begin), most_steps=0)
    if base is None:
        return
    begins = dict[str, Start]()
    for place, effect in enumerate(effects):
        candidates.tell(f"trying {effect.name} beside the nominal values", 0.7 + 0.05 * place / len(effects))
        if starts := candidates.screen.starts(base, effect):
            begins[effect.name] = starts[0]
    models, rough = candidates.models, candidates.rough
    for name in sorted(begins, key=lambda each: -begins[each].evidence)[: CONSTANTS.fits_from_nominal_values]:
        start, key = begins[name], Hypothesis((name,))
        whole = candidates.fit_beside(base, start, np.concatenate([base.point, start.point]), (name,))
        before = models[key].likelihood.evidence if key in models else rough[key]
        if whole is not None and whole.likelihood.evidence > before:
            models[key], rough[key] = whole, whole.likelihood.evidence
            candidates.fronts[name] = start, whole.point[: base.point.size + start.point.size]


def _leaves_a_gap(candidates: Candidates) -> bool:
    """Does the best of what was fitted leave a gap that can be seen?"""
    best = max((candidates.recalibrated, *candidates.models.values()), key=lambda each: each.likelihood.evidence)
    return is_visible(squares(candidates.whitening, best.predicted))


def _frozen(prediction: Prediction, whitening: BandWhitening, base: Fit, start: Start) -> Look | None:
    """The best point (base's parameters, then the effect's) with the slopes of the base's parameters held where they are."""
    names = [parameter.name for parameter in start.parameters]
    fitted = base.point.size

    def keep(point: FloatArray) -> FloatArray:
        own = [p.within(float(u)) for p, u in zip(start.parameters, point[fitted:], strict=True)]
        return np.concatenate([point[:fitted], own])

    def look(point: FloatArray) -> Look | None:
        own = point[fitted:]
        values = {**base.values, **start.fixed, **{p.name: p.value(float(u)) for p, u in zip(start.parameters, own, strict=True)}}
        scales = {p.name: p.slope(float(u)) for p, u in zip(start.parameters, own, strict=True)}
        predicted, slopes = prediction.jacobian(values, names, scales, (*base.on, start.effect.name))
        if not np.all(np.isfinite(predicted)):
            return None
        predicted = predicted + base.slopes @ (point[:fitted] - base.point)
        sums = whitening.sums(predicted, np.column_stack([base.slopes, np.nan_to_num(slopes)]))
        judged = charged(
            likelihood(whitening, sums, point), (*base.parameters, *start.parameters), point, start.fixed, (start.effect.name,)
        )
        return Look(point, sums, judged)

    return likeliest(look, keep, np.concatenate([base.point, start.point]), CONSTANTS.frozen_steps)


def _apart(starts: Sequence[Start]) -> list[Start]:
    """The best start, and the best of those that are elsewhere."""
    chosen = [starts[0]]
    for start in starts[1:]:
        elsewhere = all(np.max(np.abs(start.point - other.point)) > CONSTANTS.starts_apart for other in chosen)
        if len(chosen) < CONSTANTS.starts_of_an_effect and elsewhere:
            chosen.append(start)
    return chosen
