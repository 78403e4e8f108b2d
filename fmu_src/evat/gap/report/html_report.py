"""What does the report say? All that report.html shows, gathered for its template; its numbers are those of diagnosis.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from evat import html as pages
from evat.constants import CONSTANTS
from evat.gap.answer import Diagnosis
from evat.gap.budget import structural_share
from evat.gap.report.parts import TITLES, parts
from evat.gap.report.pictures import interactive, printed
from evat.gap.report.pictures.chart import BLUE, GREEN, GREY, ORANGE, RED, SKY, YELLOW, Chart
from evat.gap.report.pictures.selection import charts
from evat.gap.report.pictures.series import Series, unlike
from evat.gap.report.summary import headline
from evat.gap.report.words import beyond_all, number, percent, shown_unit, typed
from evat.gap.search.compare import Comparison
from evat.gap.set_up import set_up_errors
from evat.gap.verdict.credibility import shift
from evat.gap.verdict.judgement import CANNOT_TELL, UNKNOWN, fitted
from evat.inference.fit import Fit
from evat.inference.noise.autoregression import impulse_response
from evat.plots.cycles import clock_unit
from evat.units import display

if TYPE_CHECKING:
    from evat.gap.report.fmu_run import FmuRun

RELATIVES = 5  # sets that are listed at least, likely or not
FILES = {
    "diagnosis.json": "all numbers of this page, for programs",
    "corrected.ssv": "the corrected parameters, which FMUs, systems and evat sets read",
    "report.html": "this page",
}
COLOURS = dict(zip(TITLES, ("#c8c8c8", "#8c8c8c", YELLOW, ORANGE, GREEN, SKY, BLUE, RED), strict=True))


def page(
    answer: Diagnosis, comparison: Comparison, run: FmuRun | None, without: str, beside: Mapping[str, str] = MappingProxyType({})
) -> str:
    """report.html. run : what the FMU gave, None where it was not run, and then `without` says why; beside : links to other pages on these
    data, and what each is."""
    document, chosen = answer.document(), fitted(comparison, answer.judgement.chosen)
    prediction = comparison.prediction
    some = bool(answer.judgement.chosen)
    corrected = (chosen.predicted if run is None else run.predicted) if some else None
    series = Series(comparison, corrected)
    reference = comparison.recalibrated.predicted if answer.verdict == UNKNOWN else comparison.nominal.predicted
    placed = unlike(comparison, chosen.predicted if some else None, reference)
    drawn = charts(series, answer.where.regions, placed)
    variables = [variable.name for variable in prediction.model.variables]
    units = {name: shown_unit(prediction, name) for name in ("time", "phase", *variables)}
    return pages.render(
        "diagnosis.html.j2",
        answer=answer,
        document=document,
        experiment=prediction.experiment,
        headline=headline(answer, comparison),
        judged=answer.verdict != CANNOT_TELL,
        left_of_effect=_called(answer),
        files={**FILES, **beside},
        parts=parts(comparison, chosen),
        titles=TITLES,
        colours=COLOURS,
        line_colours={"measured": GREY, "nominal": RED, "recalibrated": ORANGE, "corrected": BLUE},
        pictures={where: [_picture(chart) for chart in some] for where, some in drawn.items()},
        candidates=_candidates(answer, comparison),
        recalibrated=_recalibrated(answer, comparison),
        set_up=set_up_errors(comparison, chosen) if answer.recalibration.setup else (),
        formed=bool(prediction.form_names),
        cannot_tell=_by_reason(document["cannot_tell"]),
        place=lambda name, x: _place(comparison, name, x),
        noise=_noise(comparison),
        discrepancies={"recalibrated": _discrepancy(comparison.recalibrated), **({"corrected": _discrepancy(chosen)} if some else {})},
        tried={"models": len(comparison.models), "rough": len(comparison.rough), "silent": comparison.silent, "unfed": comparison.unfed},
        run=run,
        without=without,
        units={name: unit for name, (unit, _, _) in units.items()},
        level=lambda name, x: None if x is None else units[name][1] * x + units[name][2],
        size=lambda name, x: None if x is None else units[name][1] * x,
        number=number,
        percent=percent,
        beyond_all=beyond_all,
        script=interactive.script(),
    )


def _called(answer: Diagnosis) -> str:
    """What the part of the gap that the chosen effects take is called."""
    chosen = answer.judgement.chosen
    if not chosen:
        return TITLES["effect"]
    return str(chosen) if answer.verdict == "effect" else f"{chosen}, or what cannot be told from it"


def _picture(chart: Chart) -> dict[str, Any]:
    choice = f" Drawn: {chart.choices[0]}." if len(chart.choices) > 1 else ""
    return {"screen": interactive.drawn(chart), "paper": Markup(printed.drawn(chart)), "caption": chart.caption, "choice": choice}


def _candidates(answer: Diagnosis, comparison: Comparison) -> list[dict[str, Any]]:
    """The sets of diagnosis.json with what speaks for them; where they are few, the nearest of the others."""
    candidates, base = [], comparison.recalibrated
    entries: list[dict[str, Any]] = [{"hypothesis": on, "probability": probability, "said": True} for on, probability in answer.candidates]
    named = [on for on, _ in answer.candidates]
    others = sorted((on for on in comparison.models if on not in named), key=lambda on: -answer.judgement.probabilities.get(on, 0.0))
    entries += [
        {"hypothesis": on, "probability": answer.judgement.probabilities.get(on, 0.0), "said": False}
        for on in others[: RELATIVES - len(named)]
    ]
    for entry in entries:
        fit = fitted(comparison, entry["hypothesis"])
        candidates.append(
            {
                **entry,
                "gain": fit.likelihood.evidence - base.likelihood.evidence,
                "left": structural_share(comparison.whitening, fit.predicted, base.predicted),
                "parameters": len(fit.parameters),
            }
        )
    return candidates


def _by_reason(lines: Sequence[str]) -> dict[str, list[str]]:
    """Reason -> what could not be told for it."""
    names: dict[str, list[str]] = {}
    for line in lines:
        name, colon, reason = line.partition(": ")
        names.setdefault(reason if colon else line, []).append(name if colon else "")
    return names


def _place(comparison: Comparison, name: str, x: float) -> str:
    """A bound of a region as a person reads it."""
    if name == "time":
        factor, unit = clock_unit(max(float(np.ptp(trial.times)) for trial in comparison.prediction.experiment.trials))
        return f"{number(factor * x)} {unit}"
    return number(x) if name == "phase" else display(x, typed(comparison.prediction, name), digits=4)


def _recalibrated(answer: Diagnosis, comparison: Comparison) -> list[dict[str, Any]]:
    fit = comparison.recalibrated
    away = {p.name: float(u) for p, u in zip(fit.parameters, fit.point, strict=True)} | shift(comparison, fit)
    document = answer.document()["recalibration"]
    rows: Mapping[str, Any] = document["parameters"]
    return [
        {
            "name": name,
            **row,
            "with_effects": document["with_effects"].get(name),
            "shift": away[name],
            "relative": row["value"] / row["nominal"] - 1 if row["nominal"] else None,
        }
        for name, row in rows.items()
    ]


def _noise(comparison: Comparison) -> list[dict[str, Any]]:
    """Of each channel: the autoregression, the noise it makes, and how trials differ."""
    noise, rows = comparison.noise, []
    for channel in comparison.prediction.channels:
        own = [place for place, segment in enumerate(comparison.prediction.segments) if segment.channel == channel]
        filter_ = noise.filters.get(channel, np.array([1.0]))
        gain = float(np.sqrt(np.sum(impulse_response(filter_) ** 2)))
        sizes = gain * noise.sizes[own]
        rows.append(
            {
                "channel": channel,
                "order": filter_.size - 1,
                "coefficients": [float(-weight) for weight in filter_[1:]],
                "low": float(sizes.min()),
                "high": float(sizes.max()),
                "spread": [float(x) for x in noise.spread[channel]] if channel in noise.spread else None,
            }
        )
    return rows


def _discrepancy(fit: Fit) -> dict[str, float]:
    return {"size": fit.likelihood.size, "samples": CONSTANTS.correlation_samples[fit.likelihood.length]}
