"""Measurement and simulation disagree: where does the gap lie, which effect causes it, how far does it shrink once that is added?

Knows a model by the words of evat.model alone: no effect by name, no kernel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means
from evat.gap.advise import next_experiment
from evat.gap.answer import Diagnosis, Named, Novelty, Recalibrated
from evat.gap.budget import is_visible, squares, structural, structural_share
from evat.gap.closure import Closure, HeldOut, close
from evat.gap.later_part import later_part
from evat.gap.location import Location, locate
from evat.gap.search.compare import Comparison, compare
from evat.gap.search.portion import as_long_as, portion
from evat.gap.set_up import notable, set_up_errors
from evat.gap.tones import tones
from evat.gap.verdict.constants import Constants, stored
from evat.gap.verdict.credibility import doubts, shifted
from evat.gap.verdict.features import features
from evat.gap.verdict.gates import gates
from evat.gap.verdict.judgement import CANNOT_TELL, MISTUNED, NO_GAP, UNKNOWN, Judgement, fitted, foreign_channels, judge
from evat.gap.verdict.raised import raised
from evat.gap.verdict.small import small_effect
from evat.inference.checks import check_clocks
from evat.inference.fit import Fit
from evat.inference.law.initial_state import beginnings
from evat.inference.parameters import references
from evat.inference.prediction import Prediction
from evat.inference.recorded_inputs import smoothed_inputs
from evat.inference.zeros_between_trials import with_slow_motions_as_likeliest
from evat.model import Model
from evat.required_inputs import unread_inputs

Report = Callable[[str, float], None]

__all__ = ["Comparison", "Diagnosis", "diagnose", "diagnose_with"]


def diagnose(experiment: Experiment, model: Model, *, version: str = "", report: Report | None = None, whole: bool = False) -> Diagnosis:
    """What `evat.diagnose` says, of any model; see evat.answers."""
    return diagnose_with(experiment, model, version=version, report=report, whole=whole)[0]


def diagnose_with(
    experiment: Experiment,
    model: Model,
    *,
    version: str = "",
    report: Report | None = None,
    constants: Constants | None = None,
    whole: bool = False,
) -> tuple[Diagnosis, Comparison]:
    """The same, with everything that was fitted on the way: what the report draws."""
    check_clocks(experiment)
    recorded = smoothed_inputs(experiment)
    units = {variable.name: variable.unit for variable in model.variables}
    slow = with_slow_motions_as_likeliest(model, recorded, units)
    most = math.inf if whole else CONSTANTS.diagnosed_samples
    looked_at, cut = portion(slow.experiment, model, most)
    other = None if slow.perturbed is None else Prediction(model, as_long_as(slow.perturbed, looked_at))
    said = [cut, *(f"{name} is noisy, {sd:.3g} {units[name]}: it was smoothed" for name, sd in recorded.noise.items()), slow.said]
    with threadpool_limits(1):  # sums over short rows gain nothing from threads, and their last bits would depend on them
        known, origin = (constants, "given") if constants else stored()
        version = f"{version}; constants {origin}".removeprefix("; ")
        comparison = compare(Prediction(model, looked_at), report, other)
        if report:
            report("on held-out conditions", 0.95)
        answer = conclude(comparison, known, tuple(filter(None, said)), version)
        if cut and answer.verdict != CANNOT_TELL:
            later = later_part(comparison, fitted(comparison, answer.judgement.chosen), slow.experiment)
            if later:
                answer = replace(answer, later=later, cannot_tell=(*answer.cannot_tell, later))
        return answer, comparison


def conclude(comparison: Comparison, known: Constants, said: tuple[str, ...] = (), version: str = "") -> Diagnosis:
    """What follows from all that was fitted. known : the judgement's constants; said : of the data, before anything was compared."""
    prediction, held = comparison.prediction, HeldOut(comparison)
    judgement = _judged(comparison, held, known)
    verdict = CANNOT_TELL if comparison.audit.refused else judgement.verdict
    closure = close(comparison, fitted(comparison, judgement.chosen), held)
    far = shifted(comparison, fitted(comparison, judgement.chosen))
    missing = (
        *judgement.features.doubts.get(judgement.chosen, ()),
        *_unforeseen(closure),
        *far,
        *_own_values(comparison, judgement),
        *_begun_anew(comparison, judgement),
        *said,
        *_missing(comparison),
    )
    return Diagnosis(
        verdict=verdict,
        effects=_named(comparison, judgement) if verdict != CANNOT_TELL else (),
        judgement=judgement,
        gates=gates(judgement, comparison.audit.refused),
        novelty=Novelty(1 - judgement.unknown, _unexplained(comparison, fitted(comparison, judgement.chosen))),
        recalibration=_recalibrated(comparison, fitted(comparison, judgement.chosen), closure),
        where=_location(comparison, judgement),
        closure=closure,
        cannot_tell=missing,
        advice=next_experiment(comparison, judgement),
        made_by={
            "version": version,
            "model": prediction.model.digest,
            "data": prediction.experiment.data_hash,
        },
        families=_families(prediction.model, judgement),
        members=_members(prediction.model),
        small_effect=None if comparison.audit.refused else small_effect(comparison, judgement),
        foreign={channel: comparison.noise.irregular[channel] for channel in foreign_channels(judgement.features, known)},
        shifted=far,
    )


def _unforeseen(closure: Closure) -> tuple[str, ...]:
    """Which conditions are no test, though they were left out of a fit."""
    if not closure.unforeseen:
        return ()
    which = " and ".join(closure.unforeseen)
    return (f"whether the model holds on {which}: what it does there hangs on values that the other conditions do not tell",)


def _unexplained(comparison: Comparison, chosen: Fit) -> float:
    """Share of what the nominal model leaves above the noise that is left by what the answer names, values and effects; 0 where it leaves
    nothing that can be seen."""
    if not is_visible(squares(comparison.whitening, comparison.nominal.predicted)):
        return 0.0
    return min(structural_share(comparison.whitening, chosen.predicted, comparison.nominal.predicted), 1.0)


def _judged(comparison: Comparison, held: HeldOut, known: Constants) -> Judgement:
    """The likeliest models are also tried on conditions left out of their fits, until those that lead have been."""
    seen = features(comparison)
    judgement = judge(seen, known)
    for _ in range(CONSTANTS.held_out_rounds):
        leaders = sorted((on for on in judgement.probabilities if on), key=lambda on: -judgement.probabilities[on])[
            : CONSTANTS.held_out_models
        ]
        new = [on for on in dict.fromkeys((*leaders, judgement.chosen)) if on and on not in seen.doubts]
        if not new or comparison.audit.refused:
            break
        left = {on: held.left(comparison.models[on]) for on in new}
        seen = replace(
            seen,
            held_out={**seen.held_out, **{on: share for on, share in left.items() if math.isfinite(share)}},
            doubts={**seen.doubts, **{on: doubts(comparison, on, held) for on in new}},
        )
        judgement = judge(seen, known)
    return judgement


def _members(model: Model) -> dict[str, tuple[str, ...]]:
    members: dict[str, tuple[str, ...]] = {}
    for effect in model.effects:
        family = effect.family or effect.name
        members[family] = (*members.get(family, ()), effect.name)
    return members


def _families(model: Model, judgement: Judgement) -> dict[str, float]:
    """Probability that any effect of a family acts, the likeliest first; effects without a family are one of their own."""
    family_of = {name: family for family, names in _members(model).items() for name in names}
    total: dict[str, float] = {}
    for on, probability in judgement.probabilities.items():
        for family in {family_of[name] for name in on.effects}:
            total[family] = total.get(family, 0.0) + probability
    return dict(sorted(total.items(), key=lambda item: (-item[1], item[0])))


def _named(comparison: Comparison, judgement: Judgement) -> tuple[Named, ...]:
    """The effects of the chosen set; where several sets are likely, what else each could be. Of their parameters those that change nothing
    that was measured are left out, such as the gain of a channel that was not recorded."""
    if not judgement.chosen or judgement.verdict in (NO_GAP, MISTUNED, UNKNOWN):
        return ()
    best, sd = comparison.models[judgement.chosen], comparison.models[judgement.chosen].sd
    idle = {p.name for p, slope in zip(best.parameters, best.slopes.T, strict=True) if not np.any(slope)}
    values = {name: value for name, value in best.values.items() if name not in idle}
    own = {effect.name: {variable.name for variable in effect.variables} for effect in comparison.prediction.model.effects}
    references_of = {effect.name: references(effect) for effect in comparison.prediction.model.effects}
    units = {variable.name: variable.unit for variable in comparison.prediction.model.variables}
    fitted_by_law = {p.name for p in best.parameters} - {p.name for p in comparison.recalibrated.parameters} - set().union(*own.values())
    named = []
    for name in judgement.chosen:
        probability = sum(p for on, p in judgement.probabilities.items() if name in on)
        others = [on for on in judgement.likely if on and name not in on]
        twins = sorted({other for on in others for other in on if other not in judgement.chosen})
        parameters = {
            variable: (float(values[variable]), sd.get(variable, math.nan), units[variable])
            for variable in values
            if variable in own.get(name, fitted_by_law)
        }
        for variable in references_of.get(name, ()):
            told_at = float(comparison.prediction.nominal.get(variable.name, variable.start))
            parameters.setdefault(variable.name, (told_at, 0.0, variable.unit))
        own_names = {key.removeprefix(f"{name}."): value for key, value in parameters.items()}
        named.append(Named(name, probability, own_names, tuple(twins), name == judgement.chosen.law))
    return tuple(named)


def _recalibrated(comparison: Comparison, chosen: Fit, closure: Closure) -> Recalibrated:
    """Set-up errors are those beside what is named: without it they stand in for it."""
    recalibrated, sd = comparison.recalibrated, comparison.recalibrated.sd
    before, after = (structural(comparison.whitening, fit.predicted) for fit in (comparison.nominal, recalibrated))
    share = min(max(1 - after / before, 0.0), 1.0) if before > 0 else 0.0
    by_channel = dict[str, dict[str, tuple[float, float, str]]]()
    for error in set_up_errors(comparison, chosen):
        by_channel.setdefault(error.channel, {})[error.kind] = error.value, error.sd, error.unit
    parameters = {
        p.name: (p.mean, float(recalibrated.values[p.name]), sd[p.name])
        for p in recalibrated.parameters
        if p.name not in comparison.prediction.setup_names | comparison.prediction.form_names
    }
    floors = {channel: row["noise_floor"] for channel, row in closure.rms.items()}
    beside = chosen is not recalibrated
    with_effects = {name: (float(chosen.values[name]), chosen.sd[name]) for name in parameters if beside and name in chosen.sd}
    return Recalibrated(parameters, share, by_channel, notable(comparison, chosen, floors), with_effects)


def _location(comparison: Comparison, judgement: Judgement) -> Location:
    """From what the effects contribute; of something unknown from all that the recalibrated model leaves, which need not come back in every
    repeat; else from what the nominal model leaves of the means of repeats."""
    base = comparison.recalibrated.predicted
    if judgement.chosen:
        return locate(comparison.prediction, comparison.models[judgement.chosen].predicted - base)
    if judgement.verdict == UNKNOWN:
        return locate(comparison.prediction, comparison.prediction.measured - base)
    return locate(comparison.prediction, comparison.whitening.residuals(comparison.nominal.predicted))


def _own_values(comparison: Comparison, judgement: Judgement) -> list[str]:
    """What conditions or recordings have by themselves in the chosen model, which one set of parameters cannot hold."""
    units = {variable.name: variable.unit for variable in comparison.prediction.model.variables}
    return [
        f"{name} is each recording's own, as nobody knows where a motion begins and when a record does: "
        f"{', '.join(f'{value:+.2f} {units[name]} in {where}' for where, value in own.items())} beside the value of the set"
        for name, own in fitted(comparison, judgement.chosen).own_values.items()
    ]


def _begun_anew(comparison: Comparison, judgement: Judgement) -> list[str]:
    """Named effects that undo themselves between recordings, which what they are cannot."""
    recordings = len(comparison.prediction.experiment.trials)
    named = [effect.name for effect in comparison.prediction.model.effects if effect.irreversible and effect.name in judgement.chosen]
    return [
        f"whether it is {name}: that would begin anew in each of {recordings} recordings, and what it changes stays so on a specimen; what "
        "recovers between recordings is a state of the contact"
        for name in named
        if recordings > 1
    ]


def _replicated(means: Means | None) -> bool:
    """Whether a table has more than one row of a condition."""
    return means is not None and len(set(means.conditions)) < len(means.conditions)


def _missing(comparison: Comparison) -> tuple[str, ...]:
    """What these data cannot say anything about."""
    notes = [*comparison.audit.refused, *comparison.audit.notes, *beginnings(comparison.prediction)]
    notes += raised(comparison) if not comparison.audit.refused else ()
    experiment = comparison.prediction.experiment
    notes += unread_inputs(comparison.prediction.model, comparison.prediction.nominal, experiment.recorded, experiment.stated)
    notes += [f"{name}: not identifiable, {', '.join(still)} does not vary" for name, still in comparison.audit.idle.items()]
    notes += [f"{name}: it changes nothing that was measured here" for name in comparison.silent if name not in comparison.unfed]
    notes += [f"{name}: {', '.join(inputs)} was not recorded" for name, inputs in comparison.unfed.items()]
    for name, share in comparison.forms.items():
        notes.append(f"{name}: no more than another form of the base law here, {share:.1%} of the force away from it")
    notes += tones(comparison.prediction)
    for channel, comes in comparison.noise.irregular.items():
        if comes.share > CONSTANTS.notable_irregularity:
            notes.append(f"{channel}: {comes.share:.0%} of what repeats do not share is no noise but comes and goes by itself: {comes}")
    if not comparison.noise.repeated and (experiment.trials or not _replicated(experiment.means)):
        notes.append("repeatability: no condition was recorded twice, so trial-to-trial changes are taken from priors")
    return tuple(notes)
