"""Is a second set of values that fits as well found, is what fits worse left out, and does a better one become the optimum?

A model whose misfit is a formula: F = q + h(p) cos t with h = (p - 1)((p - 3)^2 + e). Data of h = 0: the misfit is 0 at p = 1, and
near p = 3 it has a second valley, as deep as |h| = 2 e there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Trial
from evat.identification import Identification, Settings, identify
from evat.model import FloatArray, Variable
from known_rigs import exact
from plain_model import PlainModel
from scipy.optimize import brentq

P = Variable("p", "1", 1.0, 0.1, 10.0, "place", "toy")
LEVEL = Variable("q", "N", 5.0, 0.1, 50.0, "level", "toy")
DEPTH = Variable("e", "1", 0.0, -10.0, 10.0, "misfit of the second valley", "toy")
FORCE = Variable("F", "N", 0.0, -1e9, 1e9, "force", "toy", causality="output")
TIMES: FloatArray = 2 * np.pi * np.arange(200) / 200
NOISE = 0.1
UNIT = NOISE / math.sqrt(TIMES.size / 2)  # sd of h: cos t has half a square
ROOT = 1.6449  # sd that a 90 % interval reaches to each side


def h(p: FloatArray | float, e: FloatArray | float) -> FloatArray:
    return np.asarray((np.asarray(p) - 1) * ((np.asarray(p) - 3) ** 2 + e), dtype=np.float64)


class TwoValleys(PlainModel):
    effects = ()
    variables = (P, LEVEL, DEPTH, FORCE)

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        return {"F": values["q"] + h(values["p"], values["e"]) * np.cos(times)}


def identified(depth: float, begin: float = 1.0) -> Identification:
    """depth : of the second valley, in sd; begin : nominal p, from which alone the polish starts. The noise has no share of cos t and none
    of a constant, so that the misfit is the formula's."""
    noise = np.random.default_rng(0).standard_normal(TIMES.size)
    for shape in (np.ones_like(TIMES), np.cos(TIMES)):
        noise -= shape * (noise @ shape) / (shape @ shape)
    measured = 5 + NOISE * noise / np.sqrt(np.sum(noise**2) / (TIMES.size - 2))
    trial = Trial("a.csv", "a", {}, TIMES, {}, {"F": measured})
    nominal = Nominal({"p": begin, "q": 5.0, "e": depth * UNIT / 2}, (), {})
    tests = exact(Experiment(Path(), "two valleys", "", nominal, {}, (trial,), None, "hash of no file"))
    return identify(tests, TwoValleys(), ["p", "q"], Settings(search="none", whiten=False, bounds={"p": (0.2, 8.0), "q": (1.0, 20.0)}))


def end(depth: float, low: float, high: float) -> float:
    """Where |h| is as large as the data allow, between two places."""
    return float(brentq(lambda p: abs(float(h(p, depth * UNIT / 2))) - ROOT * UNIT, low, high))


@pytest.mark.parametrize("depth", [0.0, 1.0])
def test_an_interval_holds_the_second_valley(depth: float) -> None:
    """Both valleys lie within the 90 %: the interval goes from the far side of the one to the far side of the other, which the formula
    gives; the ends are found to a twentieth of the misfit's root."""
    one = identified(depth)["p"]
    assert one.value == pytest.approx(1.0, abs=0.01)
    assert one.verdict == "weak"
    assert "second set of values" in one.why
    assert one.low == pytest.approx(end(depth, 0.5, 1.0), abs=0.1 * ROOT * UNIT / 4)  # |dh/dp| = 4 at p = 1
    assert one.high == pytest.approx(end(depth, 3.001, 4.0), abs=0.01)  # there |h| rises by 2 (p - 3)^2


@pytest.mark.parametrize("depth", [2.5, 8.0])
def test_a_valley_that_the_data_reject_is_left_out(depth: float) -> None:
    """2.5 sd are more than the 1.645 of a 90 % interval: only the valley of the optimum counts."""
    one = identified(depth)["p"]
    assert one.verdict == "identified"
    assert one.high == pytest.approx(end(depth, 1.0, 1.5), abs=0.1 * ROOT * UNIT / 4)
    assert one.high < 1.1


def test_from_the_worse_valley_the_better_one_is_found() -> None:
    """The polish starts beside p = 3 and ends there, 8 sd above the least; the profile comes across p = 1, and all is judged from there."""
    one = identified(8.0, begin=3.1)["p"]
    assert one.value == pytest.approx(1.0, abs=0.01)
    assert one.verdict == "identified"


def test_the_other_parameter_has_one_valley() -> None:
    one = identified(0.0)["q"]
    assert one.verdict == "identified"
    assert "second set" not in one.why
    assert one.high - one.low == pytest.approx(2 * ROOT * NOISE / math.sqrt(TIMES.size), rel=0.1)
