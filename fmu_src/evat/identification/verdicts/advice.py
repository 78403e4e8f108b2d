"""Which further motion would identify what these data cannot? Candidates are simulated, their information on the parameters compared.

They are simulated at the estimates, but what the data do not tell at all, or only up to a bound, stands as in the nominal model: its
estimate may be anything, and often lies where nothing depends on it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from evat import motions
from evat.experiment import Experiment, Trial
from evat.identification.covariance import Optimum
from evat.identification.objective import Objective, slopes
from evat.inference.noise.autoregression import WHITE, autocovariance, autoregression, innovations
from evat.inference.prediction import Prediction
from evat.inference.sample_whitening import SampleWhitening
from evat.model import EvatError, FloatArray
from evat.motions import Motion

RATE = 1000.0  # 1/s
FASTEST = 20e3  # Hz: an ultrasonic rig
LEAST_IMPROVEMENT = 3.0  # times smaller must the sd become for a motion to be advised
ALIKE = 2.0  # times the least sd: motions that differ by no more are alike
KNOWN = 0.2  # sd, relative or as a share of the bounds, beyond which a parameter is not worth calling known
PROXIES = {"contact_temperature": (1.0, 1.5, 2.0), "proxy_speed": (0.1, 1.0, 3.0)}  # levels, as shares of the highest one recorded


def candidates(experiment: Experiment, values: Mapping[str, float | str], units: Mapping[str, str]) -> dict[str, list[Motion]]:
    """Motions that this experiment has not got, by what one would call them; none where slip is not an input."""
    slips = [trial.inputs["slip_velocity"] for trial in experiment.trials if "slip_velocity" in trial.inputs]
    fastest = max((float(np.max(np.abs(slip))) for slip in slips), default=0.0)
    F_C, F_S, sigma0, sigma1, v_s = (_number(values, name) for name in ("F_C", "F_S", "sigma0", "sigma1", "v_s"))
    if fastest <= 0 or sigma0 <= 0 or F_C <= 0:
        return {}
    z, slow = max(F_C, F_S) / sigma0, 5 * v_s if v_s > 0 else fastest / 20
    by_parameter = {
        f"reversals, to and fro at up to {_short(fastest)}m/s": motions.reversal([fastest], RATE),
        f"presliding strokes of {', '.join(f'{_short(share * z)}m' for share in motions.AMPLITUDES)}": motions.presliding(z, RATE),
        f"slow ramps, from rest to {_short(slow)}m/s": motions.ramp([slow], RATE),
        f"ramps to other speeds, {_short(0.2 * fastest)}m/s to {_short(5 * fastest)}m/s": motions.ramp(
            [0.2 * fastest, fastest, 5 * fastest], RATE
        ),
    }
    if sigma1 > 0:  # where the bristles' damping bears as much as their stiffness
        frequency = min(sigma0 / sigma1 / (2 * math.pi), FASTEST)
        name = f"presliding vibration of {_short(motions.AMPLITUDES[0] * z)}m at {_short(frequency)}Hz"
        by_parameter[name] = motions.presliding(z, motions.STROKE * frequency)[:1]
    inputs = experiment.trials[0].inputs
    for name, shares in PROXIES.items():
        highest = float(np.max(np.abs(inputs[name]))) if name in inputs else 0.0
        if highest > 0:
            levels = [share * highest for share in shares]
            told = f"temperature steps, {name} of {', '.join(f'{level:.3g}' for level in levels)} {units[name]}, with strokes and reversals"
            by_parameter[told] = motions.heated(levels, levels[0], name, [share * z for share in motions.AMPLITUDES], [fastest], RATE)
    return by_parameter


def advise(objective: Objective, optimum: Optimum, wanted: Sequence[str], untold: Sequence[str] = ()) -> dict[str, str]:
    """For each wanted parameter the motion that would tell it best, with what would then be known; "" where none of them would.

    untold : those whose estimates say nothing.
    """
    experiment, space = objective.prediction.experiment, objective.space
    point = np.where(np.isin(space.names, list(untold)), space.start, optimum.point)
    values = {**objective.prediction.nominal, **objective.values, **space.at(point)}
    units = {variable.name: variable.unit for variable in objective.prediction.model.variables}
    held = np.linalg.inv(optimum.covariance) + 12 * np.eye(point.size)  # bounds: as much as a uniform density within them
    before, after = np.sqrt(np.diag(np.linalg.inv(held))), dict[str, FloatArray]()
    for what, several in (candidates(experiment, values, units) if wanted else {}).items():
        extra = _information(objective, optimum, point, several)
        if extra is not None:
            after[what] = np.sqrt(np.diag(np.linalg.inv(held + extra)))
    advice = {}
    for name in wanted:
        place = space.names.index(name)
        least = min((float(sd[place]) for sd in after.values()), default=math.inf)
        if least * LEAST_IMPROVEMENT > before[place]:
            advice[name] = ""
            continue
        best = next(what for what, sd in after.items() if sd[place] <= ALIKE * least)  # the simpler ones come first
        one = space.free[place]
        sd = float(after[best][place]) * one.slope(float(point[place]))
        value = one.value(float(point[place]))
        share = f"{100 * sd / abs(value):.2g} %" if value else f"{sd:.2g} {one.variable.unit}"
        advice[name] = f"{best}: with it the standard error would be about {share}" + (
            "" if sd < KNOWN * abs(value) else ", still not much"
        )
    return advice


def _information(objective: Objective, optimum: Optimum, point: FloatArray, several: Sequence[Motion]) -> FloatArray | None:
    """Fisher information of motions at a point, with the noise of the present data, which goes on for as long as it does there; None where
    the model cannot run them."""
    experiment, weigh = objective.prediction.experiment, optimum.loss.weigh
    if isinstance(weigh, SampleWhitening):
        filters = weigh.noise.filters
    else:
        filters = {channel: autoregression(rows) for channel, rows in objective.prediction.recordings(optimum.residual).items()}
    like = experiment.trials[0]
    trials = []
    for motion in several:
        others = {name: np.full(motion.times.size, float(np.median(column))) for name, column in like.inputs.items()}
        outputs = {name: np.zeros(motion.times.size) for name in like.outputs}
        own = {name: value for name, value in motion.values.items() if name in like.values}
        trials.append(Trial(motion.condition, motion.condition, {**like.values, **own}, motion.times, {**others, **motion.inputs}, outputs))
    prediction = Prediction(objective.prediction.model, replace(experiment, trials=tuple(trials), means=None))
    try:
        _, table = slopes(prediction, objective.space, objective.values, objective.on, point)
    except EvatError:
        return None
    scaled = np.zeros_like(table)
    for segment in prediction.segments:
        intervals = trials[segment.trial].sampling_interval / like.sampling_interval
        filter_ = _sampled_as_often(filters.get(segment.channel, WHITE), intervals)
        white = innovations(filter_, table[segment.at]) / optimum.loss.sd[segment.channel]
        scaled[segment.at.stop - len(white) : segment.at.stop] = white
    information: FloatArray = scaled.T @ scaled / optimum.unit
    return information if np.all(np.isfinite(information)) else None


def _sampled_as_often(filter_: FloatArray, intervals: float) -> FloatArray:
    """The whitening filter of a noise of variance 1 when it is sampled after so many intervals instead of one: that of the first-order
    autoregression which neighbouring samples then go together as."""
    lags = autocovariance(filter_, math.ceil(intervals) + 2)
    if intervals < 1:
        correlation = max(float(lags[1] / lags[0]), 0.0) ** intervals
    else:
        correlation = float(np.interp(intervals, np.arange(lags.size), lags / lags[0]))
    whitening: FloatArray = np.array([1.0, -correlation]) / math.sqrt(1 - correlation**2) if correlation else WHITE
    return whitening


def _number(values: Mapping[str, float | str], name: str) -> float:
    value = values.get(name, 0.0)
    return float(value) if isinstance(value, (int, float)) else 0.0


def _short(value: float) -> str:
    """With three digits and a prefix: 12.5 u."""
    power = min(max(3 * math.floor(math.log10(value) / 3), -9), 3)
    return f"{value / 10**power:.3g} {({3: 'k', 0: '', -3: 'm', -6: 'u', -9: 'n'})[power]}"
