"""Do recordings go on as they began? What was concluded from their first samples, over all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap.search.compare import Comparison
from evat.inference.fit import Fit
from evat.inference.prediction import OWN
from evat.model import FloatArray


def later_part(comparison: Comparison, chosen: Fit, whole: Experiment) -> str:
    """A sentence where samples that were not looked at leave more than those that were, or the model does not run there; "" else.

    whole : the experiment before it was cut.
    """
    looked_at = comparison.prediction
    # What was fitted holds at the references and the tolerance at which it was, and not at those that nobody stated.
    prediction = looked_at.of(replace(whole, nominal=looked_at.experiment.nominal)).running_the_law()
    beside = looked_at.form_names - looked_at.setup_names
    predicted = prediction.one({name: value for name, value in chosen.values.items() if name not in beside and OWN not in name}, chosen.on)
    if not np.all(np.isfinite(predicted)):
        return "only the first samples of each trial were looked at, and beyond them the model does not run with these values"
    seen = {trial.file: trial.times.size for trial in looked_at.experiment.trials}
    first, later = dict[str, list[FloatArray]](), dict[str, list[FloatArray]]()
    for segment in prediction.segments:
        if segment.trial < 0:
            continue
        left = prediction.measured[segment.at] - predicted[segment.at]
        count = seen[whole.trials[segment.trial].file]
        if count == left.size:
            continue
        first.setdefault(segment.channel, []).append(left[:count])
        later.setdefault(segment.channel, []).append(left[count:])
    units = {variable.name: variable.unit for variable in looked_at.model.variables}
    grown = []
    for channel in first:
        before, after = (float(np.sqrt(np.mean(np.concatenate(rows[channel]) ** 2))) for rows in (first, later))
        if after > CONSTANTS.later_gap * before:
            grown.append(f"{channel.replace('_', ' ')} {after:.3g} {units[channel]} rms where it was {before:.3g} {units[channel]}")
    if not grown:
        return ""
    return f"only the first {max(seen.values())} samples of each trial were looked at, and those that follow leave more: {'; '.join(grown)}"
