"""Is a fit to be believed, however well it fits? Reasons to doubt it, from its parameters and from conditions that it was not fitted to."""

from __future__ import annotations

import math

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import as_typed
from evat.gap.budget import squares
from evat.gap.closure import HeldOut
from evat.gap.search.compare import Comparison
from evat.gap.search.starts.periodogram import WAY, travel
from evat.gap.search.starts.quadrature import sine_of
from evat.gap.values_alone import values_alone
from evat.inference.fit import Fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.parameters import nominal_parameters
from evat.inference.setup.setup_errors import MASS, by_channel
from evat.units import display

SPEED = "m/s"


def doubts(comparison: Comparison, on: Hypothesis, held: HeldOut) -> tuple[str, ...]:
    """Why the fit of a hypothesis is not credible; empty where nothing speaks against it."""
    fit = comparison.models[on]
    reasons = [reason for name in on.effects for reason in _of_effect(comparison, on, name)]
    for condition, (before, after) in held.worse(fit).items():
        reasons.append(f"it makes {condition} worse, left out of its fit: {before:.1%} of the rms were left, {after:.1%} with it")
    foreseen = held.foreseen(fit)
    share, (low, high) = held.closed(fit, foreseen, away=True) if foreseen else held.where_fitted(fit, away=True)
    seen = "left out of its fit" if foreseen else "that it was fitted to"
    if share <= 0:
        reasons.append(f"it leaves more of the gap than without it on the conditions {seen}: {share:.3g} of it closes")
    elif low < 0:
        reasons.append(
            f"it is not sure that it closes any of the gap on the conditions {seen}: {share:.3g} of it, 90 % interval {low:.2g} to "
            f"{high:.2g}"
        )
    if foreseen and low > CONSTANTS.advised_share:  # with a form of the law, as it may be, that holds where no fit has looked
        return tuple(reasons)
    where = foreseen or comparison.prediction.experiment.conditions
    floors = {channel: math.sqrt(own.floor) for channel, own in squares(comparison.whitening, fit.predicted, set(where)).items()}
    by_values = values_alone(comparison, fit, where, floors, set_up=True).closed_share
    if by_values < -CONSTANTS.taken_back:
        reasons.append(f"its values close {by_values:.3g} of the gap, and the form of the law beside them takes that back")
    return tuple(reasons)


def _of_effect(comparison: Comparison, on: Hypothesis, name: str) -> list[str]:
    prediction, fit = comparison.prediction, comparison.models[on]
    without = comparison.models.get(Hypothesis(tuple(other for other in on.effects if other != name), on.law), comparison.recalibrated)
    is_clear = fit.likelihood.evidence - without.likelihood.evidence > CONSTANTS.clear_evidence
    own = {v.name: v for effect in prediction.model.effects if effect.name == name for v in effect.variables}
    fitted = [(place, p) for place, p in enumerate(fit.parameters) if p.name in own]
    sd, reasons = fit.sd, list[str]()
    strengths = [p for _, p in fitted if math.isfinite(own[p.name].neutral)]
    beyond = [abs(float(fit.values[p.name]) - own[p.name].neutral) / sd[p.name] for p in strengths if sd[p.name] > 0]
    if beyond and max(beyond) < CONSTANTS.significant_amplitude and not is_clear:
        reasons.append(f"{name} is no better known than its size: {max(beyond):.2g} standard deviations from nothing")
    for place, p in fitted:
        u, low, high = float(fit.point[place]), p.within(-math.inf), p.within(math.inf)
        if p.low <= own[p.name].min and p.high >= own[p.name].max:  # by definition, as of a share
            continue
        near = CONSTANTS.distance_to_bound
        too_slow = p.unit == SPEED and p.low > own[p.name].min  # below all that was recorded, as any slower one is
        at_bound = (math.isfinite(low) and u < low + near and not too_slow) or (math.isfinite(high) and u > high - near)
        if at_bound and not _is_best_there(fit, place):
            value = f"{float(fit.values[p.name]):.3g} {p.unit}".removesuffix(" 1")
            reasons.append(f"{p.name} = {value} lies at the bound of what it may be")
    unknown = [p for _, p in fitted if not math.isfinite(own[p.name].neutral)]
    if (sine := sine_of(unknown)) and unknown[sine[0]].unit == WAY:
        period, way = float(fit.values[unknown[sine[0]].name]), travel(prediction.experiment)
        if period > way > 0:
            reasons.append(
                f"{unknown[sine[0]].name} = {period:.3g} m is longer than the way that was recorded, {way:.3g} m, on which anything that "
                "changes slowly with the position looks like it"
            )
    others = [effect for effect in fit.on if effect != name]
    alone = prediction.one({key: value for key, value in fit.values.items() if key not in own}, others)
    for channel, level in comparison.whitening.levels.items():
        at = prediction.places(channel)
        does = float(np.sqrt(np.mean((fit.predicted[at] - alone[at]) ** 2)))
        if does > CONSTANTS.absurd_effect * level:
            reasons.append(f"{name} would make {does / level:.3g} times the measured rms of {channel}, which something else takes back")
    return reasons


def _is_best_there(fit: Fit, place: int) -> bool:
    """Whether the data tell a parameter at its bound so well that it would be next to there without one."""
    further, sd = abs(float(fit.likelihood.step[place])), math.sqrt(float(fit.likelihood.covariance[place, place]))
    return max(further, sd) < CONSTANTS.near_bound


def shift(comparison: Comparison, fit: Fit) -> dict[str, float]:
    """How far it moves each nominal value, in the standard deviations in which its owner knows it."""
    experiment = comparison.prediction.experiment
    known = {p.name: p for p in nominal_parameters(comparison.prediction.model, experiment)}
    return {name: known[name].place(float(value)) for name, value in fit.values.items() if name in known}


def largest_shift(comparison: Comparison, fit: Fit) -> float:
    """How far it moves at most a nominal value, or a parameter of its effects of which one knows how large it is in ordinary rigs, in
    standard deviations."""
    own = [v for effect in comparison.prediction.model.effects if effect.name in fit.on for v in effect.variables if v.prior_sd > 0]
    sizes = [(float(fit.values[v.name]) - v.neutral) / v.prior_sd for v in own if v.name in fit.values]
    return max(map(abs, [*shift(comparison, fit).values(), *sizes]), default=0.0)


def shifted(comparison: Comparison, fit: Fit) -> tuple[str, ...]:
    """Nominal values that a fit, with the effects that are named or without any, has to move further than their owner can have meant."""
    nominal = comparison.prediction.experiment.nominal.values
    signals, known = (
        comparison.prediction.experiment.signals,
        {variable.name: variable for variable in comparison.prediction.model.variables},
    )

    def said(name: str, value: float) -> str:
        return display(value, as_typed(known[name], signals), digits=4)

    incredible = tuple(
        f"the nominal {name} is not credible: {said(name, float(nominal[name]))} has to become {said(name, float(fit.values[name]))}, "
        f"{abs(away):.2g} of its standard deviations away"
        for name, away in shift(comparison, fit).items()
        if abs(away) > CONSTANTS.credible_shift
    )
    return (*incredible, *_moved_mass(comparison, fit))


def _moved_mass(comparison: Comparison, fit: Fit) -> tuple[str, ...]:
    """The same of the mass whose inertia was taken off the friction force."""
    stated = comparison.prediction.experiment.mass
    return tuple(
        f"the stated mass is not credible: {stated:.4g} kg has to become {stated + float(fit.values[p.name]):.4g} kg, "
        f"{abs(away):.2g} of its standard deviations away"
        for p, away in zip(fit.parameters, fit.point, strict=True)
        if stated > 0
        and p.name in comparison.prediction.setup.names
        and by_channel(p.name)[1] == MASS
        and abs(away) > CONSTANTS.credible_shift
    )
