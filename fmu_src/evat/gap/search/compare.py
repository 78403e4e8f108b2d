"""Which of the models explains the data, and how sure is that? Every effect alone, the promising pairs, none at all: by evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.search.audit import Audit, audit
from evat.gap.search.candidates import Candidates, Progress, allowed, best_pairs, of_one_family
from evat.gap.search.form import with_form_of_law
from evat.gap.search.growing import growing, try_growing
from evat.gap.search.nested import polish
from evat.gap.search.pairs import try_pairs
from evat.gap.search.part import part_of
from evat.gap.search.recalibration import NO_RUN, disbelieving, must, recalibrated_model
from evat.gap.search.rival_laws import try_rival_laws
from evat.gap.search.singles import try_singles
from evat.inference.band_whitening import BandWhitening
from evat.inference.clocks import with_clocks
from evat.inference.fit import Fit, fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.law.initial_state import begun, in_motion, with_initial_state
from evat.inference.noise.estimate import Noise, estimate_noise
from evat.inference.parameters import at_usual_references
from evat.inference.prediction import Prediction, at_tolerance_of_records
from evat.model import Effect, FloatArray, SimulationError
from evat.required_inputs import KINEMATICS


@dataclass(frozen=True)
class Comparison:
    """All that was compared: `nominal` as it is and as the `set_up` shows it, `recalibrated`, and `models` by their hypotheses, each at its
    best; set-up errors are fitted in all but the first.

    `rough` is the evidence of all hypotheses that were looked at, as far as it was; `silent` effects do nothing here, `unfed` ones lack
    inputs; `forms` are effects that came out as another form of the base law, and how far from it [of the rms of a channel].
    """

    prediction: Prediction
    noise: Noise
    whitening: BandWhitening
    nominal: Fit
    set_up: Fit
    recalibrated: Fit
    models: dict[Hypothesis, Fit]
    rough: dict[Hypothesis, float]
    silent: tuple[str, ...]
    unfed: Mapping[str, Sequence[str]]
    audit: Audit
    forms: Mapping[str, float] = field(default_factory=dict)


def compare(prediction: Prediction, report: Progress | None = None, perturbed: Prediction | None = None) -> Comparison:
    """Fit everything that may explain the gap. perturbed : the same experiment by inputs as they may as well have been."""
    tell = report or (lambda _, __: None)
    tell("recalibrating the nominal model", 0.0)
    compared = at_tolerance_of_records(prediction.model, at_usual_references(prediction.model, prediction.experiment))
    prediction = with_clocks(in_motion(prediction.of(compared)))
    if perturbed is not None:
        perturbed = prediction.of(replace(perturbed.experiment, nominal=prediction.experiment.nominal))
    predicted = prediction.one()
    if not np.all(np.isfinite(predicted)):
        raise SimulationError(NO_RUN)
    by_inputs = None if perturbed is None else (perturbed.one() - predicted) - (perturbed.measured - prediction.measured)
    prediction = begun(with_initial_state(prediction), predicted)
    if prediction.starts:
        predicted = prediction.one()
    numerical = prediction.numerical_error()
    noise = estimate_noise(prediction, predicted)
    if any(comes.lines > CONSTANTS.notable_irregularity for comes in noise.irregular.values()):
        prediction = prediction.each_apart()  # lines whose phase differs from repeat to repeat
    floors = {
        channel: float(
            np.median([size for size, segment in zip(noise.sizes, prediction.segments, strict=True) if segment.channel == channel])
        )
        for channel in prediction.channels
    }
    audited = audit(prediction, predicted, floors, numerical)
    whitening = BandWhitening(prediction, noise, predicted, numerical, by_inputs)
    if audited.refused:
        nominal = must(fit(prediction.sampled_at({}), whitening, (), np.empty(0)))
        return Comparison(prediction, noise, whitening, nominal, nominal, nominal, {}, {}, (), {}, audited)
    prediction, noise, whitening, recalibrated = recalibrated_model(prediction, whitening, numerical, by_inputs)
    nominal = must(fit(prediction.sampled_at({}), whitening, (), np.empty(0)))
    errors = [(parameter, prediction.setup.start(parameter)) for parameter in prediction.setup.parameters]
    does = prediction.setup_names.intersection(p.name for p in recalibrated.parameters)  # a zero that changes nothing is nowhere
    errors += [(p, 0.0) for p in recalibrated.parameters if p == prediction.setup.unstated_mass]
    errors += [(each.parameter, each.at) for each in prediction.linearised if each.parameter.name in does]
    set_up = must(fit(prediction, whitening, [parameter for parameter, _ in errors], np.array([at for _, at in errors])))

    searched = _searched(prediction, whitening, recalibrated, audited, numerical, by_inputs, tell)
    models = searched.models
    polish(prediction, whitening, recalibrated, models)
    prediction, recalibrated, models = _with_slopes_over_intervals(prediction, whitening, recalibrated, models)
    recalibrated, models, forms = with_form_of_law(prediction, whitening, recalibrated, models)
    recalibrated = _believed(prediction, whitening, recalibrated, models)
    return Comparison(
        prediction,
        noise,
        whitening,
        nominal,
        set_up,
        recalibrated,
        models,
        searched.rough,
        tuple(searched.silent),
        searched.unfed,
        audited,
        forms,
    )


@dataclass(frozen=True)
class _Searched:
    """As in Comparison."""

    models: dict[Hypothesis, Fit]
    rough: dict[Hypothesis, float]
    silent: Sequence[str]
    unfed: Mapping[str, Sequence[str]]


def _searched(
    prediction: Prediction,
    whitening: BandWhitening,
    recalibrated: Fit,
    audited: Audit,
    numerical: FloatArray,
    by_inputs: FloatArray | None,
    tell: Progress,
) -> _Searched:
    """What may explain something, looked for in a part where the whole is long, and fitted to all."""
    offered = _offered(prediction)
    acting = [effect for effect in offered if effect.name not in audited.idle]
    part = part_of(prediction)
    if part is None:
        candidates = _search(Candidates(prediction, whitening, recalibrated, offered, tell), acting)
        return _Searched(candidates.models, candidates.rough, candidates.silent, candidates.unfed)
    some = part.whitening(whitening, recalibrated.predicted, numerical, by_inputs)
    some.doubt(recalibrated.likelihood.size, recalibrated.likelihood.length)
    base = part.fit(recalibrated, some)
    some.forgive(CONSTANTS.form_error * base.likelihood.size, base.likelihood.length)
    base = base.again(some)
    candidates = _search(Candidates(part.prediction, some, base, offered, tell), acting)
    models = _fitted_to_all(prediction, whitening, candidates.models, tell)
    rough = {on: evidence - base.likelihood.evidence + recalibrated.likelihood.evidence for on, evidence in candidates.rough.items()}
    unfed = candidates.unfed
    whole = Candidates(prediction, whitening, recalibrated, growing([e for e in acting if e.name not in unfed]), tell, models, rough)
    try_growing(whole)
    return _Searched(whole.models, whole.rough, candidates.silent, unfed)


def _offered(prediction: Prediction) -> list[Effect]:
    """Effects that the nominal model does not have and that can happen beside those it has, in such a record."""
    model, on = prediction.model, prediction.experiment.nominal.effects
    given, kinematics = prediction.experiment.given, str(prediction.nominal.get(KINEMATICS, ""))
    return [
        effect
        for effect in model.effects
        if effect.name not in on and allowed(model, (*on, effect.name)) and effect.applies(kinematics, given)
        if prediction.experiment.trials or not (effect.unsteady or effect.keeps_mean)
    ]


def _with_slopes_over_intervals(
    prediction: Prediction, whitening: BandWhitening, recalibrated: Fit, models: Mapping[Hypothesis, Fit]
) -> tuple[Prediction, Fit, dict[Hypothesis, Fit]]:
    """What was fitted, with the slopes by which it is judged: where forces jump, those of a search are rough. The recalibrated model and
    the best of the others go on by these slopes; the rest stay where they are."""
    if not prediction.jumps:
        return prediction, recalibrated, dict(models)
    prediction = prediction.with_slopes_over_intervals()

    def again(own: Fit, most_steps: int | None) -> Fit:
        return fit(prediction, whitening, own.parameters, own.point, own.on, fixed=own.fixed, most_steps=most_steps) or own

    best = sorted(models, key=lambda on: -models[on].likelihood.evidence)[: CONSTANTS.smoothly_fitted]
    return prediction, again(recalibrated, None), {on: again(own, None if on in best else 0) for on, own in models.items()}


def _believed(prediction: Prediction, whitening: BandWhitening, recalibrated: Fit, models: Mapping[Hypothesis, Fit]) -> Fit:
    """The recalibrated model, or that with other nominal values than their owner believes, where it beats every other clearly."""
    free = disbelieving(prediction, whitening, recalibrated)
    best = max(each.likelihood.evidence for each in (recalibrated, *models.values()))
    return free if free is not None and free.likelihood.evidence > best + CONSTANTS.evidence_of_disbelief else recalibrated


def _search(candidates: Candidates, acting: Sequence[Effect]) -> Candidates:
    """Everything that may explain something. acting : effects that may do anything here."""
    try_singles(candidates, acting)
    try_rival_laws(candidates)
    try_pairs(candidates)
    return candidates


def _fitted_to_all(
    prediction: Prediction, whitening: BandWhitening, tried: Mapping[Hypothesis, Fit], tell: Progress
) -> dict[Hypothesis, Fit]:
    """The best of what was fitted to a part: the likeliest of each size, since evidence of a part favours few effects; and the
    effects of a pair alone, against which it is judged."""
    ranked = sorted(tried, key=lambda on: -tried[on].likelihood.evidence)
    singles = [on for on in ranked if len(on) == 1][: CONSTANTS.singles_fitted_to_all]
    pairs = best_pairs(prediction.model, [on for on in ranked if len(on) == 2], CONSTANTS.pairs_fitted_to_all)
    named = [tried[on].likelihood.evidence for on in pairs if not of_one_family(prediction.model, on)]
    near = max(named, default=0.0) - CONSTANTS.hopeless_deficit
    pairs = [on for place, on in enumerate(pairs) if place < CONSTANTS.pair_fits or tried[on].likelihood.evidence > near]
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
