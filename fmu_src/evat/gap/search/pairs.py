"""Do two effects explain it better than one? Second effects beside the best, and others in the place of either of the best pair."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.budget import is_visible, squares
from evat.gap.search.candidates import Candidates, allowed, best_pairs, of_one_family
from evat.gap.search.form import without
from evat.gap.search.nested import at_least
from evat.gap.search.starts.linear import linear_fit
from evat.gap.search.starts.screen import Start
from evat.inference.fit import Fit
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.model import Effect, FloatArray


def try_pairs(candidates: Candidates) -> None:
    """Fit the pairs that promise most."""
    _fit_promising(candidates, _screened_beside_the_best(candidates, _beside_the_best(candidates)))
    _swap(candidates)


Merit = dict[Hypothesis, tuple[float, Fit, Start, FloatArray]]  # of a pair: evidence, what it goes on from, its second effect, its point


def _beside_the_best(candidates: Candidates) -> Merit:
    """Second effects beside the best models, by linear sums."""
    models, fronts, merit = candidates.models, candidates.fronts, Merit()
    leaders = sorted(models, key=lambda held: -models[held].likelihood.evidence)[: CONSTANTS.paired_singles]
    for leader in leaders:
        base = models[leader]
        for effect in candidates.offered:
            key = leader.beside(effect.name)
            if effect.name in leader or effect.name not in fronts or not allowed(candidates.prediction.model, key.effects):
                continue
            start, _ = fronts[effect.name]
            # Slopes of the second effect as they are without the first.
            sums = candidates.whitening.sums(base.predicted, np.column_stack([base.slopes, start.slopes]))
            width = start.slopes.shape[1]
            evidence, point = linear_fit(candidates.whitening, sums, base, start.straight)
            point = np.concatenate([point, start.point[width:]])
            if key not in merit or evidence > merit[key][0]:
                merit[key] = (evidence, base, start, point)
                candidates.rough[key] = evidence
    return merit


def _screened_beside_the_best(candidates: Candidates, merit: Merit) -> Merit:
    """The same, with what is screened anew beside the best single effect, where that leaves a gap that can be seen: once it is there,
    others look as they did not before."""
    singles = {key: model for key, model in candidates.models.items() if len(key) == 1}
    leader = max(singles, key=lambda key: singles[key].likelihood.evidence, default=NOMINAL)
    if not leader.effects or not is_visible(squares(candidates.whitening, singles[leader].predicted)):
        return merit
    base, promising = singles[leader], dict(merit)
    for effect in _screened(candidates):
        key = leader.beside(effect.name)
        if effect.name in leader or not allowed(candidates.prediction.model, key.effects):
            continue
        candidates.tell(f"trying {effect.name} beside {leader}", 0.75)
        for start in candidates.screen.starts(base, effect)[:1]:
            if key not in promising or start.evidence > promising[key][0]:
                promising[key] = (start.evidence, base, start, np.concatenate([base.point, start.point]))
                candidates.rough[key] = start.evidence
    return promising


def _screened(candidates: Candidates) -> list[Effect]:
    """Effects that have what they need and do something here."""
    return [effect for effect in candidates.offered if Hypothesis((effect.name,)) in candidates.rough]


def _fit_promising(candidates: Candidates, merit: Merit) -> None:
    """The pairs of most merit, and as many more as may be as good as the best of them."""
    models, model = candidates.models, candidates.prediction.model
    singles = max((single.likelihood.evidence for single in models.values()), default=-np.inf)
    ranked, best = sorted(merit, key=lambda key: -merit[key][0]), -np.inf
    for place, key in enumerate(best_pairs(model, ranked, CONSTANTS.most_pair_fits)):
        candidates.tell(f"fitting {' and '.join(key)}", 0.75 + 0.2 * place / CONSTANTS.most_pair_fits)
        value, base, start, point = merit[key]
        if value < singles + CONSTANTS.gain_of_a_pair or (place >= CONSTANTS.pair_fits and value < best - CONSTANTS.hopeless_deficit):
            break
        _fit_beside(candidates, key, base, start, point)
        if key in models and not of_one_family(model, key):
            best = max(best, models[key].likelihood.evidence)


def _fit_beside(candidates: Candidates, key: Hypothesis, base: Fit, start: Start, point: FloatArray) -> None:
    whole = candidates.fit_beside(base, start, point, key.effects)
    if whole is not None:
        candidates.models[key] = at_least(candidates.prediction, candidates.whitening, whole, base)


def _swap(candidates: Candidates) -> None:
    """What else could stand in for either effect of a pair that leads? Screened anew beside the other, since alone it looks different."""
    prediction, models, rough = candidates.prediction, candidates.models, candidates.rough
    evidence = {key: each.likelihood.evidence for key, each in models.items() if not of_one_family(prediction.model, key)}
    best = max(evidence.values(), default=-np.inf)
    near = [key for key in sorted(evidence, key=lambda key: -evidence[key]) if evidence[key] > best - CONSTANTS.hopeless_deficit]
    if not near or len(near[0]) < 2:
        return
    like = sorted(_screened(candidates), key=lambda effect: -rough[Hypothesis((effect.name,))])[: CONSTANTS.swaps]
    swaps = dict[Hypothesis, tuple[float, Fit, Start]]()
    for pair in [key for key in near if len(key) > 1][: CONSTANTS.swapped_pairs]:
        for kept in pair.parts():
            (other,) = (part for part in pair.parts() if part != kept)
            swaps.update(_in_place_of(candidates, pair, kept, other, [effect for effect in like if kept.beside(effect.name) not in swaps]))
    deficit = max(CONSTANTS.hopeless_deficit, CONSTANTS.error_of_linear_gain * (best - candidates.without_effects))
    for key in sorted(swaps, key=lambda key: -swaps[key][0])[: CONSTANTS.swap_fits]:
        value, base, start = swaps[key]
        if value < best - deficit:
            break
        _fit_beside(candidates, key, base, start, np.concatenate([base.point, start.point]))


def _in_place_of(
    candidates: Candidates, pair: Hypothesis, kept: Hypothesis, other: Hypothesis, effects: Sequence[Effect]
) -> dict[Hypothesis, tuple[float, Fit, Start]]:
    """Pairs with one of `effects` in the place of the other of a pair: the evidence of each, and from where it is fitted."""
    prediction, models = candidates.prediction, candidates.models
    base = models.get(kept) or (without(prediction, candidates.whitening, models[pair], other.effects) if other.effects else None)
    swaps = dict[Hypothesis, tuple[float, Fit, Start]]()
    for effect in effects:
        key = kept.beside(effect.name)
        if base is None or effect.name in kept or key in models or not allowed(prediction.model, key.effects):
            continue
        if of_one_family(prediction.model, key):
            continue
        candidates.tell(f"trying {effect.name} beside {kept}", 0.93)
        for start in candidates.screen.starts(base, effect)[:1]:
            swaps[key] = (start.evidence, base, start)
    return swaps
