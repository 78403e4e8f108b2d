"""Which constants make the judgement's probabilities true? Those that are likeliest on cases whose truth is known.

A case whose truth is one effect also stands for a world that the library does not know: with that effect taken out of it (leave one out).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from scipy.optimize import minimize

from evat.constants import CONSTANTS, OWN_WORLD
from evat.gap.verdict.constants import Constants
from evat.gap.verdict.features import Features
from evat.gap.verdict.judgement import MISTUNED, NO_GAP, UNKNOWN, judge
from evat.inference.hypothesis import NOMINAL, Hypothesis
from evat.model import FloatArray

BY_HYPOTHESIS = tuple(each.name for each in fields(Features) if "Hypothesis" in str(each.type))  # features that each hypothesis has
POSITIVE = {field.name for field in fields(Constants)} - {"gap_offset", "structure_offset", "unknown_offset"}


@dataclass(frozen=True)
class CalibrationCase:
    """Features and the truth: no_gap, mistuned, unknown, or effects joined by +."""

    features: Features
    truth: str

    def line(self) -> str:
        """As a line of JSON."""
        held = {field.name: getattr(self.features, field.name) for field in fields(Features)}
        for name in BY_HYPOTHESIS:
            held[name] = [[hypothesis.document(), value] for hypothesis, value in getattr(self.features, name).items()]
        return json.dumps({"truth": self.truth, **held}, sort_keys=True)

    @staticmethod
    def read(line: str) -> CalibrationCase:
        held = json.loads(line)
        truth = held.pop("truth")
        for name in BY_HYPOTHESIS:
            held[name] = {Hypothesis.read(hypothesis): value for hypothesis, value in held.get(name, [])}
        held["doubts"] = {hypothesis: tuple(reasons) for hypothesis, reasons in held["doubts"].items()}
        return CalibrationCase(Features(**held), truth)


def with_unknown(cases: Iterable[CalibrationCase]) -> tuple[CalibrationCase, ...]:
    """The cases, and each of one effect once more without that in the library."""
    every = list[CalibrationCase]()
    for case in cases:
        every.append(case)
        if case.truth not in (NO_GAP, MISTUNED, UNKNOWN) and "+" not in case.truth:
            every.append(CalibrationCase(case.features.without(case.truth), UNKNOWN))
    return tuple(every)


def probability(case: CalibrationCase, constants: Constants) -> float:
    """What the judgement gives the truth."""
    judgement = judge(case.features, constants)
    none = judgement.probabilities[NOMINAL]
    if case.truth == NO_GAP:
        return none * judgement.no_gap
    if case.truth == MISTUNED:
        return none * (1 - judgement.no_gap)
    if case.truth == UNKNOWN:
        return judgement.unknown
    return judgement.probabilities.get(Hypothesis(tuple(case.truth.split("+"))), 0.0)


def fit_constants(cases: Sequence[CalibrationCase], start: Constants | None = None) -> tuple[Constants, float]:
    """The constants, and the mean log loss; cases of each kind weigh alike."""
    first = start or Constants()
    names = [field.name for field in fields(Constants)]
    kinds = [case.truth if case.truth in (NO_GAP, MISTUNED, UNKNOWN) else "pair" if "+" in case.truth else "single" for case in cases]
    weights = np.array([1 / kinds.count(kind) for kind in kinds])
    weights /= weights.sum()

    def constants(point: FloatArray) -> Constants:
        held = {}
        for name, u in zip(names, point, strict=True):
            value = getattr(first, name)
            held[name] = (
                value * math.exp(CONSTANTS.calibration_prior_sd * u) if name in POSITIVE else value + 2 * CONSTANTS.calibration_prior_sd * u
            )
        return Constants(**held)

    def loss(point: FloatArray) -> float:
        held = constants(point)
        with CONSTANTS.replaced(**OWN_WORLD):
            each = np.array([-math.log(max(probability(case, held), CONSTANTS.least_calibrated_probability)) for case in cases])
        return float(weights @ each) + 0.5 * float(point @ point) / len(cases)

    optimum = minimize(loss, np.zeros(len(names)), method="Powell", options={"maxiter": 20, "xtol": 0.02, "ftol": 1e-4})
    return constants(optimum.x), float(optimum.fun)
