"""Which of the models explains the data, and how sure is that? Every effect alone, the promising pairs, none at all: by evidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from evat.constants import CONSTANTS
from evat.gap.search.audit import Audit, audit
from evat.gap.search.form import with_form_of_law, without
from evat.gap.search.part import part_of
from evat.gap.search.screen import Screen, Start, linear
from evat.inference.discrepancy import likelihood
from evat.inference.fit import Fit, Look, fit, likeliest
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.inference.initial_state import begun, in_motion, with_initial_state
from evat.inference.noise.estimate import Noise, estimate_noise
from evat.inference.parameters import Parameter, Scales, form_parameters, law_parameters, nominal_parameters
from evat.inference.prediction import Linearised, Prediction
from evat.inference.whitening import Whitening
from evat.model import Effect, FloatArray, Model, SimulationError
from evat.required_inputs import KINEMATICS

NO_RUN = "the nominal model does not run on this experiment; simulate it on its own to see why."


@dataclass(frozen=True)
class Comparison:
    """All that was compared: `nominal` as it is and as the `set_up` shows it, `recalibrated`, and `models` by their hypotheses, each at its
    best; set-up errors are fitted in all but the first.

    `rough` is the evidence of all hypotheses that were looked at, as far as it was; `silent` effects do nothing here, `unfed` ones lack
    inputs.
    """

    prediction: Prediction
    noise: Noise
    whitening: Whitening
    nominal: Fit
    set_up: Fit
    recalibrated: Fit
    models: dict[Hypothesis, Fit]
    rough: dict[Hypothesis, float]
    silent: tuple[str, ...]
    unfed: Mapping[str, Sequence[str]]
    audit: Audit


def _frozen(prediction: Prediction, whitening: Whitening, base: Fit, start: Start) -> Look | None:
    """The best point (base's parameters, then the effect's) with the slopes of the base's parameters held where they are."""
    names = [parameter.name for parameter in start.parameters]
    fitted = base.point.size

    def keep(point: FloatArray) -> FloatArray:
        own = [p.within(float(u)) for p, u in zip(start.parameters, point[fitted:], strict=True)]
        return np.concatenate([point[:fitted], own])

    def look(point: FloatArray) -> Look | None:
        own = point[fitted:]
        values = {**base.values, **{p.name: p.value(float(u)) for p, u in zip(start.parameters, own, strict=True)}}
        scales = {p.name: p.slope(float(u)) for p, u in zip(start.parameters, own, strict=True)}
        predicted, slopes = prediction.jacobian(values, names, scales, (*base.on, start.effect.name))
        if not np.all(np.isfinite(predicted)):
            return None
        predicted = predicted + base.slopes @ (point[:fitted] - base.point)
        sums = whitening.sums(predicted, np.column_stack([base.slopes, np.nan_to_num(slopes)]))
        return Look(point, sums, likelihood(whitening, sums, point))

    return likeliest(look, keep, np.concatenate([base.point, start.point]), CONSTANTS.frozen_steps)


def _allowed(model: Model, effects: Sequence[str]) -> bool:
    rivals = {effect.name: effect.rivals for effect in model.effects}
    return not any(other in rivals.get(name, ()) for name in effects for other in effects)


Fronts = dict[str, tuple[Start, FloatArray]]  # of an effect: how it starts beside the recalibrated parameters, and from which point


def compare(prediction: Prediction, report: Callable[[str, float], None] | None = None, perturbed: Prediction | None = None) -> Comparison:
    """Fit everything that may explain the gap. perturbed : the same experiment by inputs as they may as well have been."""
    tell = report or (lambda _, __: None)
    tell("recalibrating the nominal model", 0.0)
    prediction = in_motion(prediction)
    if perturbed is not None:
        perturbed = Prediction(prediction.model, replace(perturbed.experiment, nominal=prediction.experiment.nominal))
    predicted = prediction.one()
    if not np.all(np.isfinite(predicted)):
        raise SimulationError(NO_RUN)
    by_inputs = None if perturbed is None else perturbed.one() - predicted
    prediction = begun(with_initial_state(prediction), predicted)
    if prediction.starts:
        predicted = prediction.one()
    numerical = prediction.numerical_error()
    noise = estimate_noise(prediction, predicted)
    floors = {s.channel: float(noise.sizes[place]) for place, s in enumerate(prediction.segments)}
    audited = audit(prediction, predicted, floors, numerical)
    whitening = Whitening(prediction, noise, predicted, numerical, by_inputs)
    if audited.refused:
        nominal = _must(fit(prediction, whitening, (), np.empty(0)))
        return Comparison(prediction, noise, whitening, nominal, nominal, nominal, {}, {}, (), {}, audited)
    prediction, noise, whitening, recalibrated = _recalibrate(prediction, whitening, numerical, by_inputs)
    nominal = _must(fit(prediction, whitening, (), np.empty(0)))
    errors = [(parameter, 0.0) for parameter in prediction.setup.parameters]
    errors += [(each.parameter, each.at) for each in prediction.linearised if each.parameter.name in prediction.setup_names]
    set_up = _must(fit(prediction, whitening, [parameter for parameter, _ in errors], np.array([at for _, at in errors])))

    model, on = prediction.model, prediction.experiment.nominal.effects
    given, kinematics = prediction.experiment.given, str(prediction.nominal.get(KINEMATICS, ""))
    offered = [
        effect
        for effect in model.effects
        if effect.name not in on and _allowed(model, (*on, effect.name)) and effect.applies(kinematics, given)
        if prediction.experiment.trials or not effect.unsteady
    ]
    acting = [effect for effect in offered if effect.name not in audited.idle]
    part = part_of(prediction)
    if part is None:
        models, rough, silent, unfed = _search(prediction, whitening, recalibrated, offered, acting, tell)
    else:
        some = part.whitening(whitening, recalibrated.predicted, numerical, by_inputs)
        some.doubt(recalibrated.likelihood.size, recalibrated.likelihood.length)
        base = part.fit(recalibrated, some)
        some.forgive(CONSTANTS.form_error * base.likelihood.size, base.likelihood.length)
        base = base.again(some)
        tried, rough, silent, unfed = _search(part.prediction, some, base, offered, acting, tell)
        models = _fitted_to_all(prediction, whitening, tried, tell)
        rough = {on: evidence - base.likelihood.evidence + recalibrated.likelihood.evidence for on, evidence in rough.items()}
    _polish(prediction, whitening, models)
    recalibrated, models = with_form_of_law(prediction, whitening, recalibrated, models)
    return Comparison(prediction, noise, whitening, nominal, set_up, recalibrated, models, rough, silent, unfed, audited)


def _search(
    prediction: Prediction,
    whitening: Whitening,
    recalibrated: Fit,
    offered: Sequence[Effect],
    acting: Sequence[Effect],
    tell: Callable[[str, float], None],
) -> tuple[dict[Hypothesis, Fit], dict[Hypothesis, float], tuple[str, ...], dict[str, Sequence[str]]]:
    """Models that explain something, the evidence of all that were looked at, effects that do nothing here, and those that lack inputs."""
    scales = Scales(prediction.model, prediction.experiment)
    screen = Screen(prediction, whitening, scales)
    screened, silent, unfed = _screened(screen, recalibrated, acting, tell)
    rough, fronts = _fronts(prediction, whitening, recalibrated, screened, tell)
    models = _singles(prediction, whitening, recalibrated, rough, fronts, tell)
    tried = [effect for effect in acting if effect.name in fronts]
    _from_nominal_values(prediction, whitening, recalibrated, screen, tried, models, rough, fronts, tell)
    _rivals(prediction, whitening, models, recalibrated, scales, tell)
    _pairs(prediction, whitening, models, fronts, rough, offered, tell)
    _swaps(prediction, whitening, models, screen, rough, offered, recalibrated.likelihood.evidence, tell)
    return models, rough, silent, unfed


def _fitted_to_all(
    prediction: Prediction, whitening: Whitening, tried: Mapping[Hypothesis, Fit], tell: Callable[[str, float], None]
) -> dict[Hypothesis, Fit]:
    """The best of what was fitted to a part: the likeliest of each size, since evidence of a part favours few effects; and the
    effects of a pair alone, against which it is judged."""
    ranked = sorted(tried, key=lambda on: -tried[on].likelihood.evidence)
    singles = [on for on in ranked if len(on) == 1][: CONSTANTS.singles_fitted_to_all]
    pairs = [on for on in ranked if len(on) == 2][: CONSTANTS.pairs_fitted_to_all]
    chosen = dict.fromkeys([*singles, *[part for on in pairs for part in on.parts() if part in tried], *pairs])
    models = dict[Hypothesis, Fit]()
    for place, on in enumerate(chosen):
        tell(f"fitting {' and '.join(on)} to all", 0.94 + 0.01 * place / len(chosen))
        before = tried[on]
        whole = fit(
            prediction, whitening, before.parameters, before.point, before.on, fixed=before.fixed, most_steps=CONSTANTS.finishing_steps
        )
        if whole is not None:
            models[on] = whole
    return models


def _recalibrate(
    prediction: Prediction, whitening: Whitening, numerical: FloatArray, by_inputs: FloatArray | None
) -> tuple[Prediction, Noise, Whitening, Fit]:
    """The nominal model at its best, with the noise and the whitening that follow from it; then every model is forgiven what an effect of a
    slightly other form would leave. Shapes of the law enter the prediction linearly from there on."""
    model, experiment, zeros = prediction.model, prediction.experiment, prediction.input_zeros
    at = _likeliest_zeros(prediction, whitening)
    prediction = _linearised(prediction, {}, (), zeros, at)
    law = (*nominal_parameters(model, experiment), *prediction.setup.parameters)
    first = _trusted(prediction, whitening, (*law, *zeros), np.concatenate([np.zeros(len(law)), at]))
    acts = np.any(first.slopes[:, : len(law)], axis=0) | np.array([p.name in experiment.nominal.values for p in law])
    own = tuple(parameter for parameter, does in zip(law, acts, strict=True) if does)  # of the law that is there
    prediction, predicted = _begun(prediction, first)
    noise = estimate_noise(prediction, predicted)
    whitening = Whitening(prediction, noise, predicted, numerical, by_inputs)
    recalibrated = _trusted(prediction, whitening, (*own, *zeros), np.concatenate([first.point[: len(law)][acts], first.point[len(law) :]]))
    forms = (*form_parameters(model, experiment), *zeros)
    at = np.concatenate([np.zeros(len(forms) - len(zeros)), recalibrated.point[len(own) :]])
    for _ in range(CONSTANTS.linearisations if forms else 0):
        prediction = _linearised(prediction, recalibrated.values, recalibrated.on, forms, at)
        shapes = [each for each in prediction.linearised if np.any(each.column)]
        start = np.concatenate([recalibrated.point[: len(own)], [each.at for each in shapes]])
        recalibrated = _trusted(prediction, whitening, (*own, *(each.parameter for each in shapes)), start)
        reached = dict(zip((each.parameter.name for each in shapes), recalibrated.point[len(own) :], strict=True))
        before, at = (
            at,
            np.array([float(u) if abs(u := reached.get(form.name, 0.0)) > CONSTANTS.linearisation_range else 0.0 for form in forms]),
        )
        if np.max(np.abs(at - before)) <= CONSTANTS.linearisation_range:
            break
    whitening.forgive(CONSTANTS.form_error * recalibrated.likelihood.size, recalibrated.likelihood.length)
    return prediction, noise, whitening, recalibrated.again(whitening)


def _begun(prediction: Prediction, first: Fit) -> tuple[Prediction, FloatArray]:
    """How trials begin by a fit that left it open, and what the fit then predicts, (N,)."""
    before = prediction.starts
    prediction = begun(with_initial_state(prediction, first.values, first.on), first.predicted)
    return prediction, first.predicted if prediction.starts == before else prediction.one(first.values, first.on)


def _likeliest_zeros(prediction: Prediction, whitening: Whitening) -> FloatArray:
    """Where each zero of an input is looked for, in its prior standard deviations: a contact at rest that creeps by it is far from
    linear in it."""
    best = []
    for zero in prediction.input_zeros:
        tried = np.linspace(zero.within(-np.inf), zero.within(np.inf), CONSTANTS.zeros_tried)
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


def _screened(
    screen: Screen, recalibrated: Fit, effects: Sequence[Effect], tell: Callable[[str, float], None]
) -> tuple[dict[str, list[Start]], tuple[str, ...], dict[str, Sequence[str]]]:
    """Where each effect starts; which of them do nothing here, and which lack inputs."""
    prediction = screen.prediction
    screened, silent, unfed = dict[str, list[Start]](), list[str](), dict[str, Sequence[str]]()
    for place, effect in enumerate(effects):
        tell(f"trying {effect.name}", 0.1 + 0.3 * place / len(effects))
        values = {**prediction.nominal, **recalibrated.values}
        if lacking := prediction.model.missing_inputs([effect.name], values, prediction.experiment.given):
            unfed[effect.name] = tuple(lacking)
        elif starts := screen.starts(recalibrated, effect):
            screened[effect.name] = starts
        else:
            silent.append(effect.name)
    return screened, tuple(silent), unfed


def _fronts(
    prediction: Prediction,
    whitening: Whitening,
    recalibrated: Fit,
    screened: Mapping[str, list[Start]],
    tell: Callable[[str, float], None],
) -> tuple[dict[Hypothesis, float], Fronts]:
    """The evidence of each effect, roughly, and the point from which it is fitted: of those that promise anything with the base's slopes
    held."""
    rough, fronts = dict[Hypothesis, float](), Fronts()
    base = recalibrated.likelihood.evidence
    most = max([starts[0].evidence - base for starts in screened.values()], default=0.0)
    for place, (name, starts) in enumerate(screened.items()):
        tell(f"trying {name}", 0.4 + 0.2 * place / len(screened))
        rough[Hypothesis((name,))] = starts[0].evidence
        fronts[name] = starts[0], np.concatenate([recalibrated.point, starts[0].point])
        if starts[0].evidence - base < max(CONSTANTS.least_share_of_gain * most - CONSTANTS.hopeless_deficit, CONSTANTS.cost_of_no_effect):
            continue
        frozen = [(front, start) for start in _apart(starts) if (front := _frozen(prediction, whitening, recalibrated, start))]
        if frozen:
            front, start = max(frozen, key=lambda pair: pair[0].likelihood.evidence)
            rough[Hypothesis((name,))], fronts[name] = front.likelihood.evidence, (start, front.point)
    return rough, fronts


def _singles(
    prediction: Prediction,
    whitening: Whitening,
    recalibrated: Fit,
    rough: Mapping[Hypothesis, float],
    fronts: Fronts,
    tell: Callable[[str, float], None],
) -> dict[Hypothesis, Fit]:
    """The most promising effects, each fitted with all parameters."""
    models = dict[Hypothesis, Fit]()
    order = sorted(fronts, key=lambda name: -rough[Hypothesis((name,))])
    base = recalibrated.likelihood.evidence
    best = max([base, *rough.values()])
    for place, name in enumerate(order[: CONSTANTS.full_fits]):
        tell(f"fitting {name}", 0.6 + 0.15 * place / CONSTANTS.full_fits)
        if (
            rough[Hypothesis((name,))] < best - max(CONSTANTS.hopeless_deficit, CONSTANTS.error_of_linear_gain * (best - base))
            and place > 1
        ):
            break
        start, point = fronts[name]
        whole = fit(prediction, whitening, (*recalibrated.parameters, *start.parameters), point, (name,))
        if whole is not None:
            models[Hypothesis((name,))] = whole
    return models


def _from_nominal_values(
    prediction: Prediction,
    whitening: Whitening,
    recalibrated: Fit,
    screen: Screen,
    effects: Sequence[Effect],
    models: dict[Hypothesis, Fit],
    rough: dict[Hypothesis, float],
    fronts: Fronts,
    tell: Callable[[str, float], None],
) -> None:
    """Effects beside the nominal values, too, where recalibration went so far that these were not credible: values that stand in for an
    effect may be where no step leads back to it."""
    nominal = np.array([parameter.name not in prediction.setup_names for parameter in recalibrated.parameters])
    if np.max(np.abs(recalibrated.point[nominal]), initial=0.0) <= CONSTANTS.credible_shift:
        return
    base = fit(prediction, whitening, recalibrated.parameters, np.where(nominal, 0.0, recalibrated.point), most_steps=0)
    if base is None:
        return
    begins = dict[str, Start]()
    for place, effect in enumerate(effects):
        tell(f"trying {effect.name} beside the nominal values", 0.7 + 0.05 * place / len(effects))
        if starts := screen.starts(base, effect):
            begins[effect.name] = starts[0]
    for name in sorted(begins, key=lambda each: -begins[each].evidence)[: CONSTANTS.fits_from_nominal_values]:
        start, key = begins[name], Hypothesis((name,))
        point = np.concatenate([base.point, start.point])
        whole = fit(prediction, whitening, (*recalibrated.parameters, *start.parameters), point, (name,))
        before = models[key].likelihood.evidence if key in models else rough[key]
        if whole is not None and whole.likelihood.evidence > before:
            models[key], rough[key], fronts[name] = whole, whole.likelihood.evidence, (start, whole.point)


def _trusted(prediction: Prediction, whitening: Whitening, parameters: Sequence[Parameter], start: FloatArray) -> Fit:
    """A fit that the whitening then trusts as far as what it leaves allows."""
    trusted = _must(fit(prediction, whitening, parameters, start, most_steps=0))
    for _ in range(2):
        whitening.doubt(trusted.likelihood.size, trusted.likelihood.length)
        trusted = _must(fit(prediction, whitening, parameters, trusted.point))
    whitening.doubt(trusted.likelihood.size, trusted.likelihood.length)
    return trusted.again(whitening)


def _rivals(
    prediction: Prediction,
    whitening: Whitening,
    models: dict[Hypothesis, Fit],
    recalibrated: Fit,
    scales: Scales,
    tell: Callable[[str, float], None],
) -> None:
    """Other base laws, where something is left for them to explain: from the best of a few starts in what they read."""
    if recalibrated.likelihood.size < CONSTANTS.laws_from:
        return
    laws = prediction.model.rival_laws(prediction.nominal)
    for place, rival in enumerate(laws):
        tell(f"fitting {rival.name}", 0.75 + 0.05 * place / len(laws))
        parameters = law_parameters(rival.variables, recalibrated.parameters, prediction.experiment.nominal.values, scales)
        count = len(recalibrated.parameters)
        starts = np.zeros((CONSTANTS.law_starts, len(parameters)))
        starts[:, :count] = recalibrated.point
        if len(parameters) > count:
            starts[:, count:] = qmc.Sobol(len(parameters) - count, scramble=False).random(CONSTANTS.law_starts) * 3.0 - 1.5
        else:
            starts = starts[:1]
        lanes = {p.name: np.array([p.value(float(u)) for u in starts[:, k]]) for k, p in enumerate(parameters)}
        rows = prediction.many({**rival.values, **lanes})
        none = np.empty((rows.shape[1], 0))
        logs = [likelihood(whitening, whitening.sums(row, none), np.empty(0)).log if np.all(np.isfinite(row)) else -np.inf for row in rows]
        if not np.isfinite(max(logs)):
            continue
        best = fit(prediction, whitening, parameters, starts[int(np.argmax(logs))], fixed=rival.values, most_steps=CONSTANTS.law_steps)
        if best is not None:
            models[Hypothesis(law=rival.name)] = best


def _apart(starts: Sequence[Start], most: int = 2) -> list[Start]:
    """The best start, and the best of those that are elsewhere."""
    chosen = [starts[0]]
    for start in starts[1:]:
        if len(chosen) < most and all(np.max(np.abs(start.point - other.point)) > 0.8 for other in chosen):
            chosen.append(start)
    return chosen


def _pairs(
    prediction: Prediction,
    whitening: Whitening,
    models: dict[Hypothesis, Fit],
    fronts: Fronts,
    rough: dict[Hypothesis, float],
    offered: Sequence[Effect],
    tell: Callable[[str, float], None],
) -> None:
    """Second effects beside the best singles: rough ones by linear sums, the best of them fitted."""
    model = prediction.model
    leaders = sorted(models, key=lambda held: -models[held].likelihood.evidence)[: CONSTANTS.paired_singles]
    merit = dict[Hypothesis, tuple[float, Fit, Start, FloatArray]]()
    for leader in leaders:
        base = models[leader]
        for effect in offered:
            key = leader.beside(effect.name)
            if effect.name in leader or effect.name not in fronts or not _allowed(model, key.effects):
                continue
            start, _ = fronts[effect.name]
            # Slopes of the second effect as they are without the first.
            sums = whitening.sums(base.predicted, np.column_stack([base.slopes, start.slopes]))
            width = start.slopes.shape[1]
            evidence, point = linear(whitening, sums, np.concatenate([base.point, np.zeros(width)]), start.parameters[:width])
            point = np.concatenate([point, start.point[width:]])
            if key not in merit or evidence > merit[key][0]:
                merit[key] = (evidence, base, start, point)
                rough[key] = evidence
    singles = max((single.likelihood.evidence for single in models.values()), default=-np.inf)
    for place, key in enumerate(sorted(merit, key=lambda k: -merit[k][0])[: CONSTANTS.pair_fits]):
        tell(f"fitting {' and '.join(key)}", 0.75 + 0.2 * place / CONSTANTS.pair_fits)
        if merit[key][0] < singles + CONSTANTS.gain_of_a_pair:
            break
        _, base, start, point = merit[key]
        whole = fit(prediction, whitening, (*base.parameters, *start.parameters), point, key.effects, fixed=base.fixed)
        if whole is not None:
            models[key] = whole


def _swaps(
    prediction: Prediction,
    whitening: Whitening,
    models: dict[Hypothesis, Fit],
    screen: Screen,
    rough: Mapping[Hypothesis, float],
    offered: Sequence[Effect],
    none: float,
    tell: Callable[[str, float], None],
) -> None:
    """What else could stand in for either effect of the best pair? Screened anew beside the other, since alone it looks different.

    none : log evidence without effects.
    """
    evidence = {key: model.likelihood.evidence for key, model in models.items()}
    best = max(evidence, key=lambda key: evidence[key], default=NOMINAL)
    if len(best) < 2:
        return
    like = sorted(
        (effect for effect in offered if Hypothesis((effect.name,)) in rough), key=lambda effect: -rough[Hypothesis((effect.name,))]
    )[: CONSTANTS.swaps]
    swaps = list[tuple[float, Hypothesis, Fit, Start]]()
    for kept in best.parts():
        (other,) = (part for part in best.parts() if part != kept)
        base = models.get(kept) or (without(prediction, whitening, models[best], other.effects) if other.effects else None)
        for effect in like:
            key = kept.beside(effect.name)
            if base is None or effect.name in kept or key in models or not _allowed(prediction.model, key.effects):
                continue
            tell(f"trying {effect.name} beside {kept}", 0.93)
            swaps += [(start.evidence, key, base, start) for start in screen.starts(base, effect)[:1]]
    for value, key, base, start in sorted(swaps, key=lambda each: -each[0])[: CONSTANTS.swap_fits]:
        if value < evidence[best] - max(CONSTANTS.hopeless_deficit, CONSTANTS.error_of_linear_gain * (evidence[best] - none)):
            break
        point = np.concatenate([base.point, start.point])
        whole = fit(prediction, whitening, (*base.parameters, *start.parameters), point, key.effects, fixed=base.fixed)
        if whole is not None:
            models[key] = whole


def _polish(prediction: Prediction, whitening: Whitening, models: dict[Hypothesis, Fit]) -> None:
    """Where a pair went further than its first effect alone, that goes on from there: a second effect is not paid for a longer way."""
    pairs = {key: model for key, model in models.items() if len(key) > 1}
    best = max((model.likelihood.evidence for key, model in models.items() if len(key) == 1), default=0.0)
    for key, base in list(models.items()):
        further = [pair for pair in pairs.values() if {p.name for p in base.parameters} <= {p.name for p in pair.parameters}]
        if len(key) > 1 or not further or base.likelihood.evidence < best - CONSTANTS.hopeless_deficit:
            continue
        values = max(further, key=lambda pair: pair.likelihood.evidence).values
        start = np.array([p.place(float(values[p.name])) for p in base.parameters])
        again = fit(prediction, whitening, base.parameters, start, base.on, fixed=base.fixed)
        if again is not None and again.likelihood.log > base.likelihood.log:
            models[key] = again


def _must(fitted: Fit | None) -> Fit:
    if fitted is None:
        raise SimulationError(NO_RUN)
    return fitted
