"""What does an identification leave behind? identified.ssv, identification.json and report.html, each of them whole or not there."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from evat import parameter_sets
from evat.files.json_values import json_value
from evat.files.writing import as_output_error, scratch
from evat.html import render
from evat.identification.report.figures import figures
from evat.identification.report.summary import headline
from evat.identification.result import Estimate, Identification, error_text
from evat.plots.experiment_page import REPORTS, pages_on

SSV, JSON, REPORT = "identified.ssv", "identification.json", "report.html"
FILES = {
    SSV: "the identified parameters, which FMUs, systems and evat sets read",
    JSON: "all numbers of this page, for programs",
    REPORT: "this page",
}


def parameter_set(identification: Identification, name: str) -> parameter_sets.ParameterSet:
    """The identified model as a set, with what is known of each estimate and where it comes from."""
    values, others = parameter_sets.of_component(identification.values)
    sources = {estimate.name: _source(estimate) for estimate in identification.estimates}
    nominal = identification.experiment.nominal.parameters
    return parameter_sets.ParameterSet(
        name=name,
        title=f"Identified from: {identification.experiment.title}",
        values=values,
        effects=identification.effects,
        sources={
            key: sources.get(key, f"held, from the nominal model{f' ({nominal})' if nominal else ''}")
            for key in (*values, *identification.effects)
        },
        notes=(
            *_provenance(identification),
            *(f"{key} = {value}" for key, value in others.items()),
            *(f"doubt: {doubt}" for doubt in identification.doubts),
        ),
    )


def _source(estimate: Estimate) -> str:
    unit = "" if estimate.variable.unit == "1" else f" {estimate.variable.unit}"
    said = f"{estimate.verdict}; standard error {estimate.sd:.3g}{unit}"
    if estimate.verdict == "withheld":
        said = f"verdict withheld: {estimate.why}; by noise alone, standard error {estimate.sd:.3g}{unit}"
    if math.isfinite(estimate.low):
        said += f", 90 % interval {estimate.low:.6g} to {estimate.high:.6g}{unit}"
    said += f"; bounds {estimate.bounds[0]:.6g} to {estimate.bounds[1]:.6g}{unit}"
    return said + (f"; on its {estimate.at_bound} bound" if estimate.at_bound else "")


def _provenance(identification: Identification) -> tuple[str, ...]:
    made = ", ".join(f"{key} {value}" for key, value in identification.made_by.items())
    errors = ", ".join(f"{channel} {100 * fit.relative_error:.2f} %" for channel, fit in identification.fits.items())
    held = ", ".join(f"{channel} {100 * fit.relative_error:.2f} %" for channel, fit in identification.held_out.items())
    notes = [f"made by: {made}", f"error (eq. 9 of the paper): {errors}"]
    if held:
        notes.append(f"error on conditions that were held out ({', '.join(identification.held_out_conditions)}): {held}")
    if identification.stopped:
        notes.append("the search was stopped by its user: the best so far, not an optimum")
    return tuple(notes)


def as_json(identification: Identification) -> dict[str, Any]:
    """SI throughout; what is not a number is null."""
    free = {}
    for estimate in identification.estimates:
        free[estimate.name] = {
            "unit": estimate.variable.unit,
            "value": estimate.value,
            "nominal": estimate.nominal,
            "standard_error": estimate.sd,
            "interval_90": [estimate.low, estimate.high],
            "open": {"below": estimate.open_below, "above": estimate.open_above},
            "bounds": list(estimate.bounds),
            "at_bound": estimate.at_bound or None,
            "verdict": estimate.verdict,
            "why": estimate.why,
            "advice": estimate.advice,
            "profile": None
            if estimate.profile is None
            else {
                "values": estimate.profile.values.tolist(),
                "rise": estimate.profile.rise.tolist(),
                "threshold": estimate.profile.threshold,
            },
        }
    fit_keys = ("rms", "share", "relative_error", "noise", "follows_itself", "samples")
    names = [estimate.name for estimate in identification.estimates]
    document: dict[str, Any] = json_value(
        {
            "format": 1,
            "title": identification.experiment.title,
            "parameters": free,
            "correlation": {"names": names, "matrix": identification.correlation.tolist()},
            "values": dict(identification.values),
            "effects": list(identification.effects),
            "objective": {"name": identification.objective, "value": identification.cost},
            "fit": {channel: {key: getattr(fit, key) for key in fit_keys} for channel, fit in identification.fits.items()},
            "held_out": {
                "conditions": list(identification.held_out_conditions),
                "fit": {channel: {key: getattr(fit, key) for key in fit_keys} for channel, fit in identification.held_out.items()},
            },
            "doubts": list(identification.doubts),
            "stopped": identification.stopped,
            "search": {
                "name": identification.search,
                "data_points": identification.searched_points,
                "evaluations": identification.evaluations,
                "seconds": identification.seconds,
                "best": [generation.best for generation in identification.history],
            },
            "made_by": dict(identification.made_by),
        }
    )
    return document


def write(identification: Identification, folder: Path) -> tuple[Path, Path, Path]:
    """All three into `folder`. They are made elsewhere first, so that a failure leaves what was there as it was."""
    with as_output_error(folder, "results"), scratch(folder) as made:
        parameter_sets.save_ssv(parameter_set(identification, folder.name or "identified"), made / SSV)
        text = json.dumps(as_json(identification), indent=2, ensure_ascii=False, allow_nan=False)
        (made / JSON).write_text(text + "\n", encoding="utf-8")
        others = pages_on(identification.experiment, folder / REPORT, REPORTS[JSON])
        page = render(
            "identify.html.j2",
            identification=identification,
            headline=headline(identification),
            figures=figures(identification),
            spread=error_text,
            provenance=_provenance(identification),
            files={**FILES, **others},
        )
        (made / REPORT).write_text(page, encoding="utf-8")
        for name in (SSV, JSON, REPORT):
            os.replace(made / name, folder / name)
    return folder / SSV, folder / JSON, folder / REPORT
