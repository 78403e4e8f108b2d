"""Does the FMU itself do what the diagnosis promises? Held-out recordings through fmpy, with corrected.ssv, alone and set up."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from evat import parameter_sets
from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap.budget import squares
from evat.gap.search.compare import Comparison
from evat.gap.values_alone import replayed, root_mean_squares
from evat.inference.fit import Fit
from evat.inference.prediction import OWN, Prediction
from evat.model import FloatArray
from evat.models.fmu import FmuModel


@dataclass(frozen=True)
class FmuRun:
    """What the corrected FMU gave. `predicted` (N,) is the chosen model's prediction with the FMU's numbers where it was run.

    `rms[channel]` over `conditions`, of measured less each: nominal, alone (the FMU with corrected.ssv and nothing else), corrected (the
    FMU as the set-up shows it), library (the same by the diagnosis), and the noise_floor [unit of the channel]. `difference` is the largest
    between FMU and library, in rms of its channel; `runs` of `samples` in all, each once either way, `left_out` conditions were not run.
    """

    fmu: str
    predicted: FloatArray
    rms: dict[str, dict[str, float]]
    difference: float
    runs: int
    samples: int
    conditions: tuple[str, ...]
    left_out: tuple[str, ...]


def run_fmu(path: Path, ssv: Path, comparison: Comparison, chosen: Fit, conditions: tuple[str, ...]) -> FmuRun:
    """Run what was measured at `conditions` (all where there are none), as far as fmu_samples reach.

    Raises what drive does where the FMU does not run.
    """
    whole = comparison.prediction
    part, left_out, runs, samples = _some(whole, conditions or whole.experiment.conditions)
    stored = parameter_sets.load(ssv)
    bare = Prediction(FmuModel(path), part)
    through = bare.set_up_as(whole)
    parts = [
        slice(segment.at.start, segment.at.start + own.at.stop - own.at.start)
        for segment, own in zip((s for s in whole.segments if s.condition in set(part.conditions)), through.segments, strict=True)
    ]
    bent = np.concatenate([whole.bent[here] for here in parts])
    through = through.starting(whole.starts, bent, whole.steady)
    set_up = {name: value for name, value in chosen.values.items() if name in whole.setup_names or OWN in name}
    rows, alone = through.one({**stored.by_choice, **set_up}, stored.effects), bare.one(stored.by_choice, stored.effects)
    # Shapes of the law are simulated, as the FMU has them; forms that no law has are left out.
    values = {name: value for name, value in chosen.values.items() if name not in whole.form_names}
    exact = Prediction(whole.model, part).set_up_as(whole).starting(whole.starts, bent, whole.steady).one(values, chosen.on)
    predicted, by_library, wanted, worst = chosen.predicted.copy(), chosen.predicted.copy(), set(part.conditions), 0.0
    by_values = replayed(comparison, chosen)
    for here, own in zip(parts, through.segments, strict=True):
        pairs = ((rows[own.at], exact[own.at]), (alone[own.at], by_values[here]))
        away = max(float(np.max(np.abs(by_fmu - other))) for by_fmu, other in pairs)
        worst = max(worst, away / comparison.whitening.levels[own.channel])
        predicted[here], by_library[here], by_values[here] = rows[own.at], exact[own.at], alone[own.at]
    left_alone = root_mean_squares(comparison, by_values, wanted)
    tables = {
        name: squares(comparison.whitening, row, wanted)
        for name, row in (("nominal", comparison.nominal.predicted), ("corrected", predicted), ("library", by_library))
    }
    rms = {
        channel: {
            **{name: table[channel].left ** 0.5 for name, table in tables.items()},
            "alone": left_alone[channel],
            "noise_floor": tables["library"][channel].floor ** 0.5,
        }
        for channel in tables["nominal"]
    }
    return FmuRun(path.name, predicted, rms, worst, runs, samples, part.conditions, left_out)


def _some(whole: Prediction, conditions: tuple[str, ...]) -> tuple[Experiment, tuple[str, ...], int, int]:
    """Conditions in their order while their runs are not too long in all, the first in any case; repeats of one run cost nothing. Of a
    recording that is too long, the head."""
    experiment = whole.experiment
    kept, seen, samples = list[str](), set[bytes](), 0
    for condition in conditions:
        own = {
            whole.alike[n]: min(trial.times.size, CONSTANTS.fmu_samples)
            for n, trial in enumerate(experiment.trials)
            if trial.condition == condition
        }
        more = sum(size for key, size in own.items() if key not in seen)
        if kept and samples + more > CONSTANTS.fmu_samples:
            continue
        kept.append(condition)
        seen.update(own)
        samples += more
    part = experiment.only(kept)
    means = len(part.means.conditions) if part.means is not None else 0
    left_out = tuple(condition for condition in conditions if condition not in kept)
    return replace(part, trials=tuple(trial.head(CONSTANTS.fmu_samples) for trial in part.trials)), left_out, len(seen) + means, samples
