"""Does another base law explain the gap?"""

from __future__ import annotations

import numpy as np
from scipy.stats import qmc

from evat.constants import CONSTANTS
from evat.gap.search.candidates import Candidates
from evat.inference.discrepancy import likelihood
from evat.inference.fit import fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.parameters import law_parameters


def try_rival_laws(candidates: Candidates) -> None:
    """Fit other base laws, where something is left for them to explain: from the best of a few starts in what they read."""
    prediction, whitening, recalibrated = candidates.prediction, candidates.whitening, candidates.recalibrated
    if recalibrated.likelihood.size < CONSTANTS.laws_from:
        return
    laws = prediction.model.rival_laws(prediction.nominal)
    for place, rival in enumerate(laws):
        candidates.tell(f"fitting {rival.name}", 0.75 + 0.05 * place / len(laws))
        parameters = law_parameters(rival.variables, recalibrated.parameters, prediction.experiment.nominal.values, candidates.scales)
        count = len(recalibrated.parameters)
        starts = np.zeros((CONSTANTS.law_starts, len(parameters)))
        starts[:, :count] = recalibrated.point
        if len(parameters) > count:
            places = qmc.Sobol(len(parameters) - count, scramble=False).random(CONSTANTS.law_starts)
            starts[:, count:] = places * (2 * CONSTANTS.law_start_range) - CONSTANTS.law_start_range
        else:
            starts = starts[:1]
        lanes = {p.name: np.array([p.value(float(u)) for u in starts[:, k]]) for k, p in enumerate(parameters)}
        rows = prediction.many({**rival.values, **lanes})
        none = np.empty((rows.shape[1], 0))
        logs = [likelihood(whitening, whitening.sums(row, none), np.empty(0)).log if np.all(np.isfinite(row)) else -np.inf for row in rows]
        if not np.isfinite(max(logs)):
            continue
        best = fit(prediction, whitening, parameters, starts[int(np.argmax(logs))], fixed=rival.values, most_steps=CONSTANTS.law_steps)
        if best is not None:
            candidates.models[Hypothesis(law=rival.name)] = best
