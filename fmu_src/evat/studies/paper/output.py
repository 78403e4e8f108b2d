"""What does the study of the paper's table 2 leave behind? study.json: every figure, SI, with bounds, sources and how it was made."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from evat.files.json_values import json_value
from evat.files.writing import put
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.paper.conditions import SHEAR_STRESS, ProcessCondition, conditions, inference, shear_stresses
from evat.studies.main_job import FORCES, MODELS
from evat.studies.paper.domain import DomainShares
from evat.studies.paper.friction import COEFFICIENTS, PLACES, BorneFriction
from evat.studies.paper.means import mean_error, measured
from evat.studies.paper.result import ACCEPTED, DETERMINED, Best, ConditionProfile, LeftOut, PaperStudy
from evat.studies.paper.study import paper_threshold
from evat.units import SPEED_UNITS

JSON = "study.json"


def as_json(study: PaperStudy, shares: tuple[DomainShares, ...], borne: BorneFriction, told: tuple[str, ...]) -> dict[str, Any]:
    """SI throughout; what is not a number is null."""
    whole: dict[str, Any] = json_value(
        {
            "format": 1,
            "measured": _forces(measured()),
            "paper": {model: paper_tables.mean_relative_error(model) for model in MODELS},
            "bounds": [_bounds(one) for one in conditions()]
            + [{"material": name, **_bounds(one)} for name, one in shear_stresses().items()],
            "inferred": {
                "how": inference().how,
                "conditions": {one.variable: one.inferred for one in conditions()},
                SHEAR_STRESS: {name: one.inferred for name, one in shear_stresses().items()},
                "models": {model: _means(means) for model, means in study.inferred.items()},
                "mean_error_by_current_shear_angle": {model: _mean_error(means) for model, means in study.current_angle.items()},
            },
            "best": [_best(one) for one in study.best.values()],
            "draws": _draws(study),
            "profiles": {
                "threshold": paper_threshold(),
                "determined_up_to_factor": DETERMINED,
                "conditions": {one.condition.variable: _profile(one) for one in study.profiles},
            },
            "spreads": [{"quantity": one.name, "unit": one.unit, "low": one.low, "high": one.high} for one in study.spreads],
            "left_out": [_left_out(one) for one in study.left_out],
            "domain": _domain(shares),
            "borne_friction": _borne(borne),
            "caveats": told,
            "made_by": study.made_by,
        }
    )
    return whole


def _draws(study: PaperStudy) -> dict[str, Any]:
    counts = [
        {
            "principle": principle,
            "speed_unit": unit,
            **dict(zip(("separating", "accepted", "ranking_kept"), study.accepted(principle, unit), strict=True)),
        }
        for unit in SPEED_UNITS
        for principle in kernel.variable("shear_angle_principle").choices
    ]
    return {"accepted_up_to": ACCEPTED, "counts": counts}


def _profile(one: ConditionProfile) -> dict[str, Any]:
    return {"values": one.values.tolist(), "mean_errors": one.errors.tolist(), "interval": one.interval, "verdict": one.verdict}


def _left_out(one: LeftOut) -> dict[str, Any]:
    return {
        "material": one.material,
        "model": one.model,
        "feed_force": one.measured,
        "predicted_median": one.median,
        "predicted_5_to_95_percent": np.percentile(one.predicted, [5, 95]).tolist() if one.predicted.size else None,
        "draws": int(one.predicted.size),
    }


def _borne(borne: BorneFriction) -> dict[str, Any]:
    return {
        "domain": _domain(borne.shares),
        "models": {model: _means(means) for model, means in borne.at_start.items()},
        "places": [
            {
                "mu": float(mu),
                "contact_length": float(length),
                "mean_error": {model: float(borne.errors(model)[n]) for model in MODELS},
            }
            for n, (mu, length) in enumerate(PLACES)
        ],
        "amontons": [{"mu": mu, **_means(means)} for mu, means in zip(COEFFICIENTS, borne.amontons, strict=True)],
    }


def _means(means: Any) -> dict[str, Any]:
    return {"mean_error": _mean_error(means), "means": _forces(means)}


def _mean_error(means: Any) -> float:
    return float(mean_error(means / measured() - 1))


def _domain(shares: tuple[DomainShares, ...]) -> dict[str, dict[str, float]]:
    return {
        one.material: {
            "no_normal_force": one.no_normal_force,
            "friction_beyond_normal_force": one.beyond_normal_force,
            "stiffness_at_floor": one.stiffness_at_floor,
        }
        for one in shares
    }


def _forces(means: Any) -> dict[str, dict[str, float]]:
    return {name: dict(zip(FORCES, map(float, row), strict=True)) for name, row in zip(paper_tables.materials(), means, strict=True)}


def _bounds(one: ProcessCondition) -> dict[str, Any]:
    unit = kernel.variable(one.variable).unit
    return {"variable": one.variable, "unit": unit, "low": one.low, "high": one.high, "source": one.source}


def _best(one: Best) -> dict[str, Any]:
    return {
        "model": one.how.model,
        "principle": one.how.principle,
        "speed_unit": one.how.speed_unit,
        "mean_error": one.error,
        "conditions": {each.variable: float(value) for each, value in zip(conditions(), one.point, strict=True)},
        SHEAR_STRESS: dict(zip(paper_tables.materials(), map(float, one.shear_stress), strict=True)),
        "means": _forces(one.forces),
    }


def write(study: PaperStudy, shares: tuple[DomainShares, ...], borne: BorneFriction, told: tuple[str, ...], folder: Path) -> Path:
    return put(folder / JSON, json.dumps(as_json(study, shares, borne, told), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
