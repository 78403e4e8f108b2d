"""Can this experiment be fitted at all? What would make a fit silent nonsense is refused here, before anything is searched."""

from __future__ import annotations

import numpy as np

from evat.experiment import ExperimentError
from evat.identification.objective import Objective
from evat.inference.checks import opposed, rms, unit_ratio
from evat.inference.cycles import other_frequency
from evat.model import ParameterError
from evat.required_inputs import LAW

PROBES = 4


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
        law = {**objective.prediction.nominal, **objective.values}.get(LAW, "of the model")
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
        places = prediction.places(channel)
        if not np.all(np.isfinite(nominal[places])):
            raise ExperimentError(f"{channel}: the nominal model fails on this record; check its values against the units of the inputs.")
        if (correlation := opposed(prediction.measured[places], nominal[places])) is not None:
            raise ExperimentError(
                f"{channel}: measured runs against calculated (correlation {correlation:.2f}). Positive slip gives positive friction here; "
                "reverse the sign of the force's column, or of the motion's (sign = -1)."
            )


def check_frequency(objective: Objective) -> None:
    """ExperimentError where a tool is said to vibrate at another frequency than that at which the force comes back, unless that is free."""
    prediction, space = objective.prediction, objective.space
    ends = [{**prediction.nominal, **objective.values, **space.at(np.full(len(space.free), end))} for end in (0.0, 1.0)]
    if len({prediction.model.cycle_time(values) for values in ends}) == 1 and (frequency := other_frequency(prediction)) is not None:
        raise ExperimentError(f"{frequency}.")


def suspicious_scales(objective: Objective) -> list[str]:
    """Channels whose size is far from what the nominal model says: a sentence for each."""
    prediction, sentences = objective.prediction, []
    nominal = prediction.one(objective.values, objective.on)
    for channel in objective.channels:
        places = prediction.places(channel)
        measured, calculated = prediction.measured[places], nominal[places]
        if (ratio := unit_ratio(measured, calculated)) is not None:
            sentences.append(
                f"{channel}: measured is {ratio:.3g} times what the nominal model gives (rms {rms(measured):.4g} against "
                f"{rms(calculated):.4g}). Is the column in the unit that the experiment says?"
            )
    return sentences
