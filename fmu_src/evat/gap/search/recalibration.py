"""Which values of the nominal model fit best, and what noise, whitening and beginnings of trials follow from that?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from evat.constants import CONSTANTS
from evat.inference.band_whitening import BandWhitening
from evat.inference.clocks import likeliest_clocks
from evat.inference.discrepancy import likelihood
from evat.inference.fit import Fit, fit
from evat.inference.law.initial_state import begun, with_initial_state
from evat.inference.law.law_form import with_law_forms
from evat.inference.noise.estimate import Noise, estimate_noise
from evat.inference.parameters import Parameter, form_parameters, nominal_parameters
from evat.inference.prediction import Linearised, Prediction
from evat.inference.setup.setup_errors import CLOCK, by_channel, name_of_clock
from evat.inference.zeros_between_trials import tried_zeros
from evat.model import FloatArray, SimulationError

NO_RUN = "the nominal model does not run on this experiment; simulate it on its own to see why."


def recalibrated_model(
    prediction: Prediction, whitening: BandWhitening, numerical: FloatArray, by_inputs: FloatArray | None
) -> tuple[Prediction, Noise, BandWhitening, Fit]:
    """The nominal model at its best, with the noise and the whitening that follow from it; then every model is forgiven what an effect of a
    slightly other form would leave. Shapes of the law enter the prediction linearly from there on."""
    model, experiment, zeros = prediction.model, prediction.experiment, prediction.input_zeros
    at = _likeliest_zeros(prediction, whitening)
    prediction = _linearised(prediction, {}, (), zeros, at)
    law = (*nominal_parameters(model, experiment), *prediction.setup.parameters)
    begin = [prediction.setup.start(p) if p.name in prediction.setup.names else 0.0 for p in law]
    first = _trusted(prediction, whitening, (*law, *zeros), np.concatenate([begin, at]))
    acts = np.any(first.slopes[:, : len(law)], axis=0) | np.array([p.name in experiment.nominal.values for p in law])
    own = tuple(parameter for parameter, does in zip(law, acts, strict=True) if does)  # of the law that is there
    prediction, predicted = _begun(prediction, first)
    noise = estimate_noise(prediction, predicted)
    whitening = BandWhitening(prediction, noise, predicted, numerical, by_inputs)
    recalibrated = _trusted(prediction, whitening, (*own, *zeros), np.concatenate([first.point[: len(law)][acts], first.point[len(law) :]]))
    forms = (*form_parameters(model, experiment), *zeros)
    if forms:
        at = np.concatenate([np.zeros(len(forms) - len(zeros)), recalibrated.point[len(own) :]])
        prediction, recalibrated = _shaped(prediction, whitening, recalibrated, own, forms, at)
        act = [each for each in prediction.linearised if np.any(each.column) or each.parameter.name in prediction.setup_names]
        prediction = prediction.linearise(act)  # what an effect may wake is not held
    formed = with_law_forms(prediction, recalibrated.slopes, recalibrated.values, recalibrated.on)
    if formed is not prediction:
        prediction, free = formed, [each.parameter for each in formed.linearised if each.parameter.name in formed.form_names]
        recalibrated = _trusted(
            prediction, whitening, (*recalibrated.parameters, *free), np.append(recalibrated.point, np.zeros(len(free)))
        )
    recalibrated = _with_moved_mass(prediction, whitening, recalibrated)
    prediction, recalibrated = _clocked(prediction, whitening, recalibrated)
    whitening.forgive(CONSTANTS.form_error * recalibrated.likelihood.size, recalibrated.likelihood.length)
    return prediction, noise, whitening, recalibrated.again(whitening)


def _with_moved_mass(prediction: Prediction, whitening: BandWhitening, fitted: Fit) -> Fit:
    """The fit with a mass that moves between contact and sensor and that nobody stated, where it is clear that there is one: beside a small
    one that may as well be none, what follows the acceleration by its nature would be half as clear."""
    mass = prediction.setup.unstated_mass
    if mass is None:
        return fitted
    tried = fit(prediction, whitening, (*fitted.parameters, mass), np.append(fitted.point, 0.0), fitted.on, fixed=fitted.fixed)
    clear = tried is not None and tried.likelihood.evidence - fitted.likelihood.evidence > CONSTANTS.evidence_of_mass
    return tried if clear and tried is not None else fitted


def _clocked(prediction: Prediction, whitening: BandWhitening, fitted: Fit) -> tuple[Prediction, Fit]:
    """The prediction with runs sampled where the fit tells that each channel was, and the fit to these.

    As they are where the fit leaves more than the form of a law does, or where runs that are sampled there are less likely than they were,
    or move a nominal value further still, beyond what is credible: a clock would stand in for a lag, or a phase, that is still to be found.
    """
    before, shift = (prediction, fitted), farthest_shift(prediction, fitted)
    if fitted.likelihood.size > CONSTANTS.accuracy_of_laws:
        return before
    for _ in range(CONSTANTS.searches_of_clocks):
        clocks = likeliest_clocks(prediction, whitening, fitted)
        if all(late == fitted.values.get(name_of_clock(channel)) for channel, late in clocks.items()):
            break
        prediction = prediction.sampled_at(clocks)
        held = {p.name: prediction.setup.start(p) for p in prediction.setup.parameters if by_channel(p.name)[1] == CLOCK}
        start = np.array([held.get(p.name, u) for p, u in zip(fitted.parameters, fitted.point, strict=True)])
        fitted = _trusted(prediction, whitening, fitted.parameters, start)
    likelier = fitted.likelihood.evidence >= before[1].again(whitening).likelihood.evidence  # what both are trusted in alike
    if likelier and farthest_shift(prediction, fitted) <= max(shift, CONSTANTS.credible_shift):
        return prediction, fitted
    return before[0], _trusted_again(whitening, before[1])


def farthest_shift(prediction: Prediction, fitted: Fit) -> float:
    """How far a fit has moved the nominal value that it has moved furthest, in prior standard deviations: of the values that the owner
    stated, not of shapes of the law or of what its effects have."""
    own = {parameter.name for parameter in nominal_parameters(prediction.model, prediction.experiment)}
    nominal = np.array([parameter.name in own for parameter in fitted.parameters], dtype=bool)
    return float(np.max(np.abs(fitted.point[nominal]), initial=0.0))


def nominal_place(prediction: Prediction, parameter: Parameter, u: float) -> float:
    """Where a parameter stood before recalibration, in its prior standard deviations: of set-up errors a clock alone stands in for
    effects of the motion, and goes back."""
    if parameter.name not in prediction.setup_names:
        return 0.0
    return prediction.setup.start(parameter) if by_channel(parameter.name)[1] == CLOCK else u


def _shaped(
    prediction: Prediction,
    whitening: BandWhitening,
    recalibrated: Fit,
    own: Sequence[Parameter],
    forms: Sequence[Parameter],
    at: FloatArray,
) -> tuple[Prediction, Fit]:
    """The prediction with shapes of the law about where they do best, and the fit with these. A shape is held elsewhere than where it began
    only where that earns something: a law with such a shape may take ten times as long to run."""
    best = prediction, recalibrated
    for tried in range(CONSTANTS.linearisations):
        prediction = _linearised(prediction, recalibrated.values, recalibrated.on, forms, at)
        shapes = [each for each in prediction.linearised if np.any(each.column)]
        start = np.concatenate([recalibrated.point[: len(own)], [each.at for each in shapes]])
        recalibrated = _trusted(prediction, whitening, (*own, *(each.parameter for each in shapes)), start)
        gain = recalibrated.likelihood.evidence - best[1].again(whitening).likelihood.evidence  # what both are trusted in alike
        if tried and gain < CONSTANTS.least_gain_of_linearising:
            return best[0], _trusted_again(whitening, best[1])
        best = prediction, recalibrated
        reached = dict(zip((each.parameter.name for each in shapes), recalibrated.point[len(own) :], strict=True))
        elsewhere = [float(u) if abs(u := reached.get(form.name, 0.0)) > CONSTANTS.linearisation_range else 0.0 for form in forms]
        before, at = at, np.array(elsewhere)
        if np.max(np.abs(at - before)) <= CONSTANTS.linearisation_range:
            break
    return best


def disbelieving(prediction: Prediction, whitening: BandWhitening, recalibrated: Fit) -> Fit | None:
    """The nominal model at its best if nobody were sure of its values; from those, since recalibration has other values stand in for one
    that may not move as far as it must. None where the model does not run."""
    nominal, least = prediction.experiment.nominal.values, CONSTANTS.disbelief
    own = [
        replace(p, sd=max(p.sd, least if p.logarithmic else least * abs(p.mean))) if p.name in nominal else p
        for p in recalibrated.parameters
    ]
    start = [0.0 if p.name in nominal else float(u) for p, u in zip(own, recalibrated.point, strict=True)]
    return fit(prediction, whitening, own, np.array(start), recalibrated.on, fixed=recalibrated.fixed)


def _begun(prediction: Prediction, first: Fit) -> tuple[Prediction, FloatArray]:
    """How trials begin by a fit that left it open, and what the fit then predicts, (N,)."""
    before = prediction.starts
    prediction = begun(with_initial_state(prediction, first.values, first.on), first.predicted)
    return prediction, first.predicted if prediction.starts == before else prediction.one(first.values, first.on)


def _likeliest_zeros(prediction: Prediction, whitening: BandWhitening) -> FloatArray:
    """Where each zero of an input is looked for, in its prior standard deviations: a contact at rest that creeps by it is far from
    linear in it."""
    best = []
    for zero in prediction.input_zeros:
        tried = tried_zeros(prediction, zero)
        logs = list[float]()
        for u in tried:
            row = prediction.one({zero.name: zero.value(float(u))})
            sums = whitening.sums(row, np.empty((row.size, 0))) if np.all(np.isfinite(row)) else None
            logs.append(likelihood(whitening, sums, np.empty(0)).log - 0.5 * u**2 if sums is not None else -np.inf)
        best.append(float(tried[int(np.argmax(logs))]))
    return np.array(best)


def _linearised(
    prediction: Prediction, values: Mapping[str, float | str], on: Sequence[str], forms: Sequence[Parameter], at: FloatArray
) -> Prediction:
    """Shapes of the base law and zeros of inputs about `at` (p,), in their prior standard deviations. values, on : of the model there."""
    plain, step = prediction.linearise(()), CONSTANTS.linearisation_step
    held = {name: value for name, value in values.items() if name not in prediction.setup.names}
    held |= {form.name: form.value(float(u)) for form, u in zip(forms, at, strict=True)}
    shapes = [place for place, form in enumerate(forms) if form.name not in prediction.setup_names]
    table = at[shapes] + np.vstack([np.zeros(len(shapes)), step * np.eye(len(shapes))])
    lanes = {forms[k].name: np.array([forms[k].value(float(u)) for u in column]) for k, column in zip(shapes, table.T, strict=True)}
    first, *others = plain.many({**held, **lanes}, on)
    rows = dict(zip(shapes, others, strict=True))
    for place, form in enumerate(forms):
        if place not in rows:  # an input is one for all lanes
            rows[place] = plain.one({**held, form.name: form.value(float(at[place]) + step)}, on)
    columns = [np.nan_to_num((rows[place] - first) / step) for place in range(len(forms))]
    return prediction.linearise([Linearised(form, float(u), column) for form, u, column in zip(forms, at, columns, strict=True)])


def _trusted(prediction: Prediction, whitening: BandWhitening, parameters: Sequence[Parameter], start: FloatArray) -> Fit:
    """A fit that the whitening then trusts as far as what it leaves allows."""
    trusted = must(fit(prediction, whitening, parameters, start, most_steps=0))
    for _ in range(2):
        whitening.doubt(trusted.likelihood.size, trusted.likelihood.length)
        trusted = must(fit(prediction, whitening, parameters, trusted.point))
    return _trusted_again(whitening, trusted)


def _trusted_again(whitening: BandWhitening, fitted: Fit) -> Fit:
    """A fit that the whitening trusts from now on as far as what it leaves allows: its evidence is then another."""
    whitening.doubt(fitted.likelihood.size, fitted.likelihood.length)
    return fitted.again(whitening)


def must(fitted: Fit | None) -> Fit:
    if fitted is None:
        raise SimulationError(NO_RUN)
    return fitted
