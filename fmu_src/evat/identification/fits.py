"""How good is a fit, on what it has seen and on what it has not, and what should be doubted about it?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from evat.experiment import Experiment, Means
from evat.identification.objective import Objective, relative_error
from evat.identification.result import ChannelFit
from evat.inference.law.initial_state import in_motion, with_initial_state, without_starts
from evat.inference.noise.autoregression import lag_one_correlation
from evat.inference.noise.estimate import noise_level
from evat.inference.noise.lack_of_fit import lack_of_fit
from evat.inference.noise.means import replicate_sd
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Model

POOR = 0.5  # of eq. 9: a model that misses half of the force
ABOVE_NOISE = 1.5  # times the noise of repeated recordings: the residual is no longer only noise, however short they are
CERTAIN = 37.0  # sd: beyond it a chance is too small for a number
SURE = 3.0  # sd of chance: many numbers tell less, and it is no noise either
SLOW = 0.5  # correlation of neighbouring residuals from which something slow is missed
GROSS = 0.05  # of the rms: a model that misses more than this is not the one whose values were asked for
CURVE = 0.9  # from which the residual is a curve rather than noise, for all that one recording can tell
FEW = 30  # numbers of a channel, from whose residual the noise is told badly


def fits_of(prediction: Prediction, residual: FloatArray) -> dict[str, ChannelFit]:
    """By channel, of a residual (N,), calculated less measured; what the unknown start of a trial leaves, which no fit takes for its own,
    does not count."""
    residual = without_starts(prediction, residual)
    floor, error, rows = noise_level(prediction, residual), relative_error(prediction, residual), prediction.recordings(residual)
    fits, means, beyond = {}, prediction.experiment.means, lack_of_fit(prediction, residual)
    for channel in error:
        places = prediction.places(channel)
        rms, whole = (float(np.sqrt(np.mean(column[places] ** 2))) for column in (residual, prediction.measured))
        fits[channel] = ChannelFit(
            rms=rms,
            share=rms / whole if whole else math.inf,
            relative_error=error[channel],
            noise=floor.get(channel, math.nan),
            follows_itself=lag_one_correlation(rows.get(channel, [])),
            samples=places.size,
            of_replicates=_of_replicates(means, channel),
            beyond_noise=beyond.get(channel, math.nan),
        )
    return fits


def _of_replicates(means: Means | None, channel: str) -> float:
    """The noise of a mean of a channel, as replicates of a condition show it, or as it was stated of each mean, where that is more; nan
    where there are no replicates, or where all of them read alike."""
    if means is None or channel not in means.outputs:
        return math.nan
    shown, stated = replicate_sd(means.conditions, means.outputs[channel])[0] or math.nan, means.sd.get(channel, np.zeros(1))
    return max(shown, float(np.sqrt(np.mean(stated**2)))) if np.all(stated > 0) else shown


def held_out_fits(model: Model, kept: Experiment | None, values: Mapping[str, float | str], on: Sequence[str]) -> dict[str, ChannelFit]:
    if kept is None:
        return {}
    prediction = with_initial_state(in_motion(Prediction(model, kept), values, on), values, on)
    return fits_of(prediction, prediction.one(values, on) - prediction.measured)


def unexplained(fit: ChannelFit) -> float:
    """The rms of what the model misses of a channel, beside noise [unit of the channel]; 0 where nothing shows that it misses anything.
    Averages have few replicates, whose own rms is no measure: by the chance of that alone."""
    plenty = math.isfinite(fit.noise) and fit.rms > ABOVE_NOISE * fit.noise
    if fit.rms > fit.repeated and (plenty or fit.beyond_noise > SURE):
        return math.sqrt(fit.rms**2 - fit.repeated**2)
    return fit.rms if math.isnan(fit.repeated) and fit.follows_itself > CURVE else 0.0


def misfits(fits: Mapping[str, ChannelFit]) -> dict[str, str]:
    """Channels that the identified model misses by so much that no value is to be believed however well it fits: what shows it, of each.
    What it misses less of widens the intervals."""
    missed = {}
    for channel, fit in fits.items():
        words = channel.replace("_", " ")
        if fit.relative_error > POOR:
            missed[channel] = f"the model misses {100 * fit.relative_error:.0f} % of {words}"
        elif fit.rms and unexplained(fit) / fit.rms * fit.share > GROSS:
            missed[channel] = f"the model leaves {100 * fit.share:.2g} % of the rms of {words}, " + (
                f"{fit.rms / fit.repeated:.3g} times the noise of the repeats: it lacks something"
                if math.isfinite(fit.repeated)
                else f"as a curve and not as noise (neighbours correlate {fit.follows_itself:.2f}): it lacks something, or noise is slow"
            )
    return missed


def _untold(means: Means | None, channel: str) -> str:
    """Why nothing beside the fit tells the noise of a channel."""
    alike = means is not None and channel in means.outputs and len(set(means.conditions)) < len(means.conditions)
    return "whose replicates read alike, without a standard deviation" if alike else "neither repeated nor with a standard deviation"


def fit_doubts(aim: Objective, fits: Mapping[str, ChannelFit], whiten: bool) -> list[str]:
    """What should be read before a number is used: a sentence each."""
    doubts = []
    for channel, fit in fits.items():
        if fit.relative_error > POOR:
            doubts.append(
                f"{channel}: the identified model misses {100 * fit.relative_error:.0f} % of it (eq. 9). These parameters say nothing; "
                "check units, signs and the choice of the law before anything else."
            )
        if math.isfinite(fit.repeated) and (missed := unexplained(fit)):
            sds = f"{fit.beyond_noise:.0f}" if fit.beyond_noise < CERTAIN else f"more than {CERTAIN:g}"  # a smaller chance is no number
            sure = f", {sds} sd more than chance makes of it" if fit.beyond_noise > SURE else ""
            doubts.append(
                f"{channel}: the residual is {fit.rms / fit.repeated:.3g} times the noise that the repeats show{sure}: the model misses "
                f"something, {100 * missed / fit.rms * fit.share:.2g} % of the rms. The intervals are wider for it, as far as it is small."
            )
        if fit.samples < FEW and math.isnan(fit.noise) and math.isnan(fit.of_replicates) and not aim.has_sd(channel):
            doubts.append(
                f"{channel}: {fit.samples} numbers, {_untold(aim.prediction.experiment.means, channel)}: their noise was guessed from what "
                f"the fit leaves of them, and the intervals may be too narrow. State their sd (of averages as {channel}_sd)."
            )
        if fit.follows_itself > SLOW and math.isnan(fit.repeated):
            how = "whitened" if whiten and aim.kind == "least_squares" else "with wider intervals for it"
            doubts.append(
                f"{channel}: neighbouring residuals are correlated ({fit.follows_itself:.2f}); noise that is slow, or something that the "
                f"model lacks. It was fitted {how}; repeats of a condition would tell which."
            )
    return doubts
