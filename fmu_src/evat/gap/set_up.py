"""What does the set-up take up of a gap? Its gain, zero and clock as a fit has them, and where they are most of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.compare import Comparison
from evat.inference.fit import Fit
from evat.inference.setup.setup_errors import by_channel
from evat.model import FloatArray


@dataclass(frozen=True, slots=True)
class SetUpError:
    """`kind` (gain, zero, clock, clock_drift, mass) of a `channel`, shared by all trials. `tolerance`:
    standard deviation that it was thought to have, `bound`: whether the value lies at the end of what it may be; `changes[channel]`: rms of
    what it does there."""

    channel: str
    kind: str
    value: float
    sd: float
    unit: str
    tolerance: float
    bound: bool
    changes: Mapping[str, float]

    @property
    def credible(self) -> bool:
        """Whether it is no further off than its owner can have meant."""
        return abs(self.value) <= CONSTANTS.credible_shift * self.tolerance


def set_up_errors(comparison: Comparison, fit: Fit) -> tuple[SetUpError, ...]:
    """In the order of the fit's parameters."""
    prediction, sd, errors = comparison.prediction, fit.sd, list[SetUpError]()
    for parameter, does in _changes(comparison, fit).items():
        own = next(each for each in fit.parameters if each.name == parameter)
        channel, kind = by_channel(parameter)
        value = float(fit.values[parameter])
        changes = {each: float(np.sqrt(np.mean(does[prediction.places(each)] ** 2))) for each in prediction.channels}
        bound = math.isclose(abs(value), own.high, rel_tol=1e-6)
        errors.append(SetUpError(channel, kind, value, sd[parameter], own.unit, own.sd, bound, changes))
    return tuple(errors)


def notable(comparison: Comparison, fit: Fit, floors: Mapping[str, float]) -> tuple[SetUpError, ...]:
    """Those that take up most of what the nominal model leaves above the noise in a channel, the largest first; none where the set-up as a
    whole does not. floors : noise floor of each channel, as an rms."""
    changes, taken = _changes(comparison, fit), dict[str, float]()
    for channel in comparison.prediction.channels:
        at = comparison.prediction.places(channel)
        left = comparison.prediction.measured[at] - comparison.nominal.predicted[at]
        floor = floors.get(channel, 0.0) ** 2
        gap = float(np.mean(left**2)) - floor
        whole = _taken(left, [does[at] for does in changes.values()])
        if not gap > CONSTANTS.noise_floor_error * floor or not whole > CONSTANTS.advised_share * gap:
            continue
        alone = {name: _taken(left, [does[at]]) for name, does in changes.items()}
        most = max(alone.values())
        taken.update({name: share / gap for name, share in alone.items() if share > CONSTANTS.advised_share * most})
    by_name = dict(zip(changes, set_up_errors(comparison, fit), strict=True))
    return tuple(by_name[name] for name in sorted(taken, key=lambda name: -taken[name]))


def _changes(comparison: Comparison, fit: Fit) -> dict[str, FloatArray]:
    """What each set-up error of a fit changes in the prediction, (N,), to first order."""
    names = comparison.prediction.setup_names
    return {
        parameter.name: (float(fit.point[place]) - parameter.place(0.0)) * fit.slopes[:, place]
        for place, parameter in enumerate(fit.parameters)
        if parameter.name in names
    }


def _taken(left: FloatArray, changes: Sequence[FloatArray]) -> float:
    """Mean square that changes take off what is left (n,)."""
    return float(np.mean(left**2) - np.mean((left - sum(changes, np.zeros_like(left))) ** 2))
