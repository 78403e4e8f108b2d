"""Which parameter set corrects the model? Recalibrated nominal values, switches and parameters of the effects: corrected.ssv."""

from __future__ import annotations

import math
from pathlib import Path

from evat.files import ssv
from evat.gap.answer import Diagnosis
from evat.gap.report.reached import reached
from evat.gap.report.words import sentence, with_unit
from evat.gap.search.compare import Comparison
from evat.gap.verdict.judgement import fitted
from evat.inference.law.initial_state import PERIODIC, SETTLED, START
from evat.inference.parameters import references

SSV = "corrected.ssv"

BEGINNINGS: dict[object, str] = {
    PERIODIC: "the records begin in the midst of a vibration",
    SETTLED: "what follows with a lag has been where it is before the records begin",
}


def content(answer: Diagnosis, comparison: Comparison) -> ssv.Content:
    """The corrected model; where no effect was chosen, the recalibrated one."""
    prediction, chosen = comparison.prediction, fitted(comparison, answer.judgement.chosen)
    experiment, known = prediction.experiment, {variable.name: variable for variable in prediction.model.variables}
    switches = dict.fromkeys((*experiment.nominal.effects, *chosen.on), 1.0)
    own = {v.name for effect in prediction.model.effects if effect.name in chosen.on for v in effect.variables}
    off = {v.name for effect in prediction.model.effects if effect.name not in switches for v in references(effect)}
    every: dict[str, float | str] = {**prediction.nominal, **chosen.values, **switches}
    every = {name: value for name, value in every.items() if name not in off}
    sources, sd = dict[str, str](), chosen.sd
    nominal = experiment.nominal
    for name, value in every.items():
        if name not in known:
            continue
        unit = known[name].unit
        if name in chosen.on or name in chosen.fixed:
            sources[name] = "found by the diagnosis"
        elif name in own and known[name].reference:
            sources[name] = "at which the effect's amplitude is told: the usual magnitude of the records"
        elif name in own:
            sources[name] = f"of the effect, found by the diagnosis{_spread(sd.get(name), unit)}"
        elif name in sd:
            before = f", nominal {with_unit(float(nominal.values[name]), unit, 6)}" if name in nominal.values else ""
            sources[name] = f"recalibrated{before}{_spread(sd.get(name), unit)}"
        elif name == START and value in BEGINNINGS:
            sources[name] = BEGINNINGS[value]
        elif name in nominal.values or name in nominal.effects:
            sources[name] = f"nominal model{f' ({nominal.parameters})' if nominal.parameters else ''}, held"
        else:
            sources[name] = f"what the diagnosis simulated with, {value}"
    return ssv.Content(
        name="corrected",
        title=f"Corrected by the diagnosis of: {experiment.title}",
        values={name: known[name].check(value) for name, value in every.items() if name in known},
        sources=sources,
        notes=(
            f"verdict: {sentence(answer)}",
            f"what the diagnosis added: {answer.judgement.chosen}",
            *reached(answer, comparison),
            f"made by: {', '.join(f'{key} {value}' for key, value in answer.made_by.items())}",
            *(f"{name} = {value}" for name, value in every.items() if name not in known and name not in prediction.form_names),
        ),
    )


def _spread(sd: float | None, unit: str) -> str:
    return "" if sd is None or not math.isfinite(sd) else f"; standard deviation {with_unit(sd, unit, 3)}"


def write(answer: Diagnosis, comparison: Comparison, folder: Path) -> Path:
    """corrected.ssv in `folder`."""
    variables = {variable.name: variable for variable in comparison.prediction.model.variables}
    return ssv.write(folder / SSV, content(answer, comparison), variables)
