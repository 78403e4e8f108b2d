"""What grows along a recording, as a drift or a wear, shows less in a part than in the whole: there it is looked for again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.candidates import Candidates, allowed
from evat.gap.search.nested import at_least
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.inference.parameters import shapes
from evat.model import Effect


def growing(effects: Sequence[Effect]) -> list[Effect]:
    """Those that go by the time or the way itself and do not come back, as a line at a frequency does."""
    return [effect for effect in effects if effect.unsteady and all(variable.unit != "Hz" for variable in shapes(effect))]


def try_growing(candidates: Candidates) -> None:
    """Fit them beside the recalibrated model and beside the best single effect, where that may be better than all that was fitted."""
    models, model = candidates.models, candidates.prediction.model
    singles = [on for on in models if len(on) == 1]
    leader = max(singles, key=lambda on: models[on].likelihood.evidence, default=NOMINAL)
    for on in dict.fromkeys((NOMINAL, leader)):
        base = models.get(on, candidates.recalibrated)
        for effect in candidates.offered:
            key = Hypothesis((effect.name,)) if on == NOMINAL else on.beside(effect.name)
            if effect.name in on or key in models or not allowed(model, key.effects):
                continue
            candidates.tell(f"trying {effect.name} beside {on} in all", 0.95)
            best = max([base.likelihood.evidence, *(each.likelihood.evidence for held, each in models.items() if len(held) <= len(key))])
            for start in candidates.screen.starts(base, effect)[:1]:
                candidates.rough[key] = start.evidence
                if start.evidence < best + CONSTANTS.gain_of_a_pair:
                    continue
                whole = candidates.fit_beside(base, start, np.concatenate([base.point, start.point]), key.effects)
                if whole is not None:
                    models[key] = at_least(candidates.prediction, candidates.whitening, whole, base)
