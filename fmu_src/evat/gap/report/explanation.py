"""Why was an effect chosen, or not, and why this verdict? What was tried, what it gained, how large it would have to be to show here."""

from __future__ import annotations

import math

import numpy as np

from evat.constants import CONSTANTS
from evat.gap.answer import Diagnosis
from evat.gap.budget import structural_share
from evat.gap.report.words import number, percent, sentence, with_unit
from evat.gap.search.compare import Comparison
from evat.gap.verdict.judgement import fitted
from evat.inference.discrepancy import known
from evat.inference.fit import Fit
from evat.inference.hypothesis import NOMINAL
from evat.inference.parameters import Scales, amplitudes, shape_parameters
from evat.model import Effect, ParameterError
from evat.required_inputs import KINEMATICS


def explain(comparison: Comparison, answer: Diagnosis, effect: str) -> str:
    """What the diagnosis has found out about one effect, as lines of text; ParameterError where there is none of that name."""
    prediction = comparison.prediction
    known = {each.name: each for each in prediction.model.effects}
    laws = [*(rival.name for rival in prediction.model.rival_laws(prediction.nominal)), *(on.law for on in comparison.models if on.law)]
    if effect not in known and effect not in laws:
        raise ParameterError(f"there is no effect {effect!r} to explain; there are {', '.join(dict.fromkeys([*known, *laws]))}.")
    if effect in laws:
        return "\n".join([_standing(answer, effect), *_law(comparison, answer, effect)])
    asked, on = known[effect], prediction.experiment.nominal.effects
    lines = [f"{effect}: {asked.physics}", _standing(answer, effect)]
    if effect in on:
        return "\n".join([*lines, "It is on in the nominal model already, so it was no candidate."])
    if rivals := [name for name in on if name in asked.rivals or effect in known[name].rivals]:
        return "\n".join([*lines, f"It was not tried: it goes not together with {', '.join(rivals)}, which the nominal model has on."])
    kinematics = str(prediction.nominal.get(KINEMATICS, ""))
    if not asked.applies(kinematics, prediction.experiment.given):
        return "\n".join(
            [*lines, f"It was not tried: it happens with {' or '.join(asked.applies_to)}, and kinematics = {kinematics} here."]
        )
    if asked.unsteady and not prediction.experiment.trials:
        return "\n".join([*lines, "It was not tried: it goes by the time or the way itself, of which means tell nothing. Record a trial."])
    if asked.keeps_mean and not prediction.experiment.trials:
        return "\n".join([*lines, "It was not tried: it is a filter or a delay, and passes means as they are. Record a trial."])
    if effect in comparison.audit.idle:
        inputs = ", ".join(comparison.audit.idle[effect])
        return "\n".join([*lines, f"It was not tried: {inputs} does not vary, so that it is one with other parameter values. Vary that."])
    if effect in comparison.unfed:
        inputs = ", ".join(comparison.unfed[effect])
        return "\n".join([*lines, f"It was not tried: it says nothing without {inputs}, which was not recorded. Record it."])
    if effect in comparison.silent:
        return "\n".join([*lines, "It was tried, and whatever its size it changes nothing in the channels and conditions of these data."])
    if effect in comparison.forms:
        away = (
            f"{comparison.forms[effect]:.1%} of the force away from it as it was fitted; effects begin at {CONSTANTS.accuracy_of_laws:.0%}"
        )
        return "\n".join([*lines, f"It was tried, and is no more than another form of the base law here, {away}."])
    lines += _rank(comparison, effect)
    lines += _fits(comparison, answer, effect)
    return "\n".join([*lines, *_detectable(comparison, answer, asked)])


def explain_verdict(answer: Diagnosis, verdict: str) -> str:
    """Whether this was the verdict, and the gates that led to the one that was, in their order and with their numbers."""
    was = (
        f"{verdict}: this is the verdict."
        if answer.verdict == verdict
        else f"{verdict}: this is not the verdict, which is {answer.verdict}."
    )
    lines = [was, f"It says: {sentence(answer)}"]
    for place, gate in enumerate(answer.gates, 1):
        lines.append(
            f"{place:2}. {gate.name}: {'passed' if gate.passed else 'not passed'}; {gate.quantity}: {number(gate.value)}, wanted is "
            f"{gate.wanted} {number(gate.threshold)}. {gate.consequence[:1].upper()}{gate.consequence[1:]}."
            f"{' This moved the verdict.' if gate.moved else ''}"
        )
    return "\n".join(lines)


def _standing(answer: Diagnosis, effect: str) -> str:
    inside = sum(p for on, p in answer.judgement.probabilities.items() if effect in on)
    chosen = effect in {each.name for each in answer.effects}
    return f"{'Chosen' if chosen else 'Not chosen'}: probability {percent(inside)} that it acts. The verdict was: {sentence(answer)}"


def _law(comparison: Comparison, answer: Diagnosis, law: str) -> list[str]:
    """How another base law did, or why it was not tried."""
    if any(law == on.law for on in comparison.models):
        return [*_rank(comparison, law), *_fits(comparison, answer, law)]
    if comparison.audit.refused:
        return [f"It was not tried: of these data nothing was judged, {'; '.join(comparison.audit.refused)}."]
    left = comparison.recalibrated.likelihood.size
    if left < CONSTANTS.laws_from:
        return [
            f"It was not tried: the recalibrated model leaves {left:.1%} of the rms unexplained, and other base laws are tried from "
            f"{CONSTANTS.laws_from:.1%} on."
        ]
    return ["No fit with it was kept: none came to an end, or it fell too far behind."]


def _rank(comparison: Comparison, effect: str) -> list[str]:
    """Among effects alone, by the evidence as far as each was fitted."""
    base = comparison.recalibrated.likelihood.evidence
    alone = {str(on): evidence for on, evidence in comparison.rough.items() if len(on) == 1}
    alone.update({str(on): fit.likelihood.evidence for on, fit in comparison.models.items() if len(on) == 1})
    if effect not in alone:
        return ["It was tried, and no fit with it came to an end."]
    ranked = sorted(alone, key=lambda name: (-alone[name], name))
    place, best = ranked.index(effect) + 1, ranked[0]
    said_best = "" if best == effect else f"; the best, {best}, gains {number(alone[best] - base)}"
    how = (
        "fitted with all parameters"
        if any(str(on) == effect for on in comparison.models)
        else "roughly fitted only, it fell too far behind"
    )
    return [f"Alone it is number {place} of {len(ranked)}: log evidence gained over the recalibrated model {number(alone[effect] - base)}"
            f"{said_best} ({how})."]  # fmt: skip


def _fits(comparison: Comparison, answer: Diagnosis, effect: str) -> list[str]:
    """Its fits, alone and in pairs, the best first."""
    reference, base = comparison.recalibrated.predicted, comparison.recalibrated.likelihood.evidence
    effects = {each.name: {variable.name for variable in each.variables} for each in comparison.prediction.model.effects}
    units = {variable.name: variable.unit for variable in comparison.prediction.model.variables}
    lines = []
    for on, fit in sorted(comparison.models.items(), key=lambda item: -item[1].likelihood.evidence):
        if effect not in on:
            continue
        left, sd = structural_share(comparison.whitening, fit.predicted, reference), fit.sd
        sizes = ", ".join(
            f"{name.removeprefix(f'{effect}.')} = {number(float(fit.values[name]))} +- {with_unit(sd[name], units[name], 2)}"
            for name in sd
            if name in units and name in effects.get(effect, sd)  # beside a law errors of the set-up are fitted, too
        )
        lines.append(
            f"{on}: leaves {percent(left)} of the structural gap, gains {number(fit.likelihood.evidence - base)}, "
            f"probability {percent(answer.judgement.probabilities.get(on, 0.0))}; {sizes}"
        )
    chosen = answer.judgement.chosen
    if chosen and effect not in chosen:
        left = structural_share(comparison.whitening, comparison.models[chosen].predicted, reference)
        gain = comparison.models[chosen].likelihood.evidence - base
        lines.append(f"to compare, {chosen}: leaves {percent(left)}, gains {number(gain)}")
    return lines


def _detectable(comparison: Comparison, answer: Diagnosis, effect: Effect) -> list[str]:
    """The smallest amplitudes that would show: from the information beside all that the model without the effect can take up."""
    rivals = {each.name: each.rivals for each in comparison.prediction.model.effects}
    chosen = answer.judgement.chosen
    apart = {effect.name, *effect.rivals}
    beside = NOMINAL if any(name in apart or effect.name in rivals.get(name, ()) for name in chosen) else chosen
    base = fitted(comparison, beside)
    smallest = smallest_amplitudes(comparison, base, effect)
    assumed = ", ".join(
        f"{name.removeprefix(f'{effect.name}.')} = {number(value, 3)}" for name, value in _shape_values(comparison, effect).items()
    )
    lines = []
    for variable in amplitudes(effect):
        size, name = smallest[variable.name], variable.name.removeprefix(f"{effect.name}.")
        away = "" if variable.neutral == 0 else f" away from {number(variable.neutral)}"
        lines.append(
            f"Smallest {name} that would show here ({CONSTANTS.detected_amplitude:g} sd{f', beside {beside}' if beside else ''}): "
            f"{with_unit(size, variable.unit, 2)}{away}{f', at {assumed}' if assumed else ''}."
            if math.isfinite(size)
            else f"Smallest {name} that would show: none can be given, alone it changes nothing to first order."
        )
    return lines


def _shape_values(comparison: Comparison, effect: Effect) -> dict[str, float]:
    """As the best fit with the effect has them; else the middle of what the record can show."""
    fits = [fit for on, fit in comparison.models.items() if effect.name in on]
    best = max(fits, key=lambda fit: fit.likelihood.evidence) if fits else None
    scales = Scales(comparison.prediction.model, comparison.prediction.experiment)
    return {p.name: float(best.values[p.name]) if best else p.mean for p in shape_parameters(effect, scales)}


def smallest_amplitudes(comparison: Comparison, base: Fit, effect: Effect) -> dict[str, float]:
    """Of each amplitude what would show at its neutral value, beside the parameters of `base`; inf where it says nothing."""
    prediction, whitening = comparison.prediction, comparison.whitening
    scales = Scales(prediction.model, prediction.experiment)
    strengths = amplitudes(effect)
    values = {**base.values, **_shape_values(comparison, effect), **{v.name: v.neutral for v in strengths}}
    units = {v.name: abs(scales.amplitude(v)) for v in strengths}
    predicted, slopes = prediction.jacobian(values, [v.name for v in strengths], units, (*base.on, effect.name))
    if not np.all(np.isfinite(predicted)):
        return dict.fromkeys(units, math.inf)
    width = base.point.size
    grams = whitening.sums(base.predicted, np.column_stack([base.slopes, np.nan_to_num(slopes)])).grams
    information = known(grams * whitening.trust[..., None, None], base.likelihood.weights)[:-1, :-1]
    nominal = information[:width, :width] + np.eye(width)
    smallest = {}
    for place, variable in enumerate(strengths, width):
        across = information[:width, place]
        own = float(information[place, place] - across @ np.linalg.solve(nominal, across)) if width else float(information[place, place])
        smallest[variable.name] = (
            CONSTANTS.detected_amplitude * units[variable.name] / math.sqrt(own)
            if own > 1e-9 * float(information[place, place])
            else math.inf
        )
    return smallest
