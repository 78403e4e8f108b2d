"""How likely are the data, where the base law has its textbook form or another? Spike and slab: Mitchell and Beauchamp 1988.

A shape of a law is, a priori, the usual one exactly with a certain probability (the spike), else anywhere as its prior says (the slab).
A fit knows the slab alone. What a spike adds is the density of the posterior there over that of the prior (Savage and Dickey: Dickey 1971),
by the Gaussian that the fit has. So an effect that explains the data with the usual law is likelier than a law of another form that does
so without it, and the other way round; a slab alone may be as wide as one likes to make the effect unlikely.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.parameters import Parameter
from evat.model import FloatArray


def log_evidence_of_spikes(parameters: Sequence[Parameter], mean: FloatArray, covariance: FloatArray) -> float:
    """What they add to the log evidence of slabs alone; 0 where no parameter has a spike.

    mean, covariance : of the posterior, (p,) and (p, p), in prior standard deviations. Parameters of one spike are usual together.
    """
    places = dict[str, list[int]]()
    for place, parameter in enumerate(parameters):
        if parameter.spike:
            places.setdefault(parameter.spike, []).append(place)
    if not places:
        return 0.0
    usual, other = math.log(CONSTANTS.usual_form), math.log1p(-CONSTANTS.usual_form)
    logs = list[float]()
    for is_usual in itertools.product((False, True), repeat=len(places)):
        at = [place for own, chosen in zip(places.values(), is_usual, strict=True) if chosen for place in own]
        log = sum(usual if chosen else other for chosen in is_usual)
        logs.append(log + _log_density_ratio(mean[at], covariance[np.ix_(at, at)]) if at else log)
    return float(np.logaddexp.reduce(logs))


def _log_density_ratio(mean: FloatArray, covariance: FloatArray) -> float:
    """Of the posterior at 0 over the prior, which is standard normal: where the posterior is the prior it is 0."""
    return -0.5 * float(mean @ np.linalg.solve(covariance, mean)) - 0.5 * float(np.linalg.slogdet(covariance)[1])
