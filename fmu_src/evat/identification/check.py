"""Can this experiment be fitted at all? What would make a fit silent nonsense is refused here, before anything is searched."""

from __future__ import annotations

import numpy as np

from evat.experiment import Experiment, ExperimentError
from evat.identification.objective import Objective
from evat.model import FloatArray, ParameterError

JUMP = 100.0  # median sample steps: a record that goes on after such a gap is two records
AGAINST = -0.5  # correlation of measured and calculated below which one of them has its sign turned
FACTOR = 100.0  # between the rms of measured and calculated, beyond which a unit is suspect
PROBES = 4


def check_clocks(experiment: Experiment) -> None:
    """ExperimentError where a clock jumps: between the samples the inputs would be made up."""
    for trial in experiment.trials:
        steps = np.diff(trial.times)
        if steps.size < 2:
            raise ExperimentError(f"{trial.file}: {trial.times.size} samples; a recording has at least three.")
        usual, place = float(np.median(steps)), int(np.argmax(steps))
        if steps[place] > JUMP * usual:
            raise ExperimentError(
                f"{trial.file}: the clock jumps by {steps[place]:.4g} s after sample {place + 1} (t = {trial.times[place]:.6g} s), "
                f"its usual step is {usual:.4g} s. What moved in between is not known: cut the file there into two trials."
            )


def check_influence(objective: Objective, seed: int) -> None:
    """ParameterError where nothing predicted depends on a free parameter, to the last bit, wherever the others stand."""
    names, count = objective.space.names, len(objective.space.free)
    base = np.random.default_rng(seed).random((PROBES, count))
    base[0] = objective.space.start
    points = np.repeat(base, count + 1, axis=0)
    for probe in range(PROBES):
        for place in range(count):
            points[probe * (count + 1) + place + 1, place] = (base[probe, place] + 0.37) % 1.0
    seen = np.zeros(count, dtype=bool)
    for probe in range(PROBES):
        rows = objective.predicted(points[probe * (count + 1) : (probe + 1) * (count + 1)])
        seen |= np.array([not np.array_equal(row, rows[0], equal_nan=True) for row in rows[1:]])
    idle = [name for name, some in zip(names, seen, strict=True) if not some]
    if idle:
        law = objective.prediction.nominal.get("friction_law", "of the model")
        raise ParameterError(
            f"free parameter {', '.join(idle)}: nothing that was measured depends on it, whatever its value. The friction law {law} with "
            f"the effects {', '.join((*objective.prediction.experiment.nominal.effects, *objective.on)) or 'none'} does not use "
            "it; choose another law, switch an effect on, or do not free it."
        )


def check_signs(objective: Objective) -> None:
    """ExperimentError where the measured force runs against the calculated one."""
    prediction = objective.prediction
    nominal = prediction.one(objective.values, objective.on)
    for channel in objective.channels:
        places = objective.places(channel)
        measured, calculated = prediction.measured[places], nominal[places]
        if not np.all(np.isfinite(calculated)):
            raise ExperimentError(f"{channel}: the nominal model fails on this record; check its values against the units of the inputs.")
        both = float(np.sqrt(np.sum(measured**2) * np.sum(calculated**2)))
        cosine = float(np.sum(measured * calculated)) / both if both > 0 else 0.0
        if cosine < AGAINST:
            raise ExperimentError(
                f"{channel}: measured runs against calculated (correlation {cosine:.2f}). Positive slip gives positive friction here; "
                "turn the sign of the force's column, or of the motion's."
            )


def suspicious_scales(objective: Objective) -> list[str]:
    """Channels whose size is far from what the nominal model says: a sentence for each."""
    prediction, found = objective.prediction, []
    nominal = prediction.one(objective.values, objective.on)
    for channel in objective.channels:
        places = objective.places(channel)
        measured, calculated = _rms(prediction.measured[places]), _rms(nominal[places])
        ratio = measured / calculated if calculated > 0 else np.inf
        if not 1 / FACTOR < ratio < FACTOR:
            found.append(
                f"{channel}: measured is {ratio:.3g} times what the nominal model gives (rms {measured:.4g} against {calculated:.4g}). "
                "Is the column in the unit that the experiment says?"
            )
    return found


def _rms(column: FloatArray) -> float:
    return float(np.sqrt(np.mean(column**2)))
