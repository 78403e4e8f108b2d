"""By what are residuals divided before a fit sums them up, where neither repeats nor a stated sd tell the noise?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Trial
from evat.identification.objective import ASSUMED_SD, FAILED, HUBER, Kind, Objective
from evat.identification.polish import SMOOTH, _loss
from evat.identification.space import Free, Space
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Variable
from plain_model import PlainModel

LEVEL = Variable("q", "N", 5.0, 0.1, 50.0, "level", "toy")
ARM = Variable("arm", "m", 0.01, 0.001, 1.0, "arm of the force", "toy")
FORCE = Variable("F", "N", 0.0, -1e9, 1e9, "force", "toy", causality="output")
TORQUE = Variable("M", "N.m", 0.0, -1e9, 1e9, "torque", "toy", causality="output")
TIMES: FloatArray = np.linspace(0.0, 1.0, 50)


class Level(PlainModel):
    effects = ()
    variables = (LEVEL, ARM, FORCE, TORQUE)

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        wave = 1 + np.sin(20 * times)
        return {"F": values["q"] * wave, "M": -values["arm"] * values["q"] * wave}


def objective(kind: Kind) -> Objective:
    luck = np.random.default_rng(4)
    measured = {
        "F": 5 * (1 + np.sin(20 * TIMES)) + luck.normal(size=50),
        "M": -0.05 * (1 + np.sin(20 * TIMES)) + 0.01 * luck.normal(size=50),
    }
    rig = Experiment(Path(), "level", "", Nominal({"q": 5.0}, (), {}), {}, (Trial("a.csv", "a", {}, TIMES, {}, measured),), None, "no hash")
    return Objective(Prediction(Level(), rig), Space((Free(LEVEL, 5.0, 0.5, 50.0),)), (), kind, {})


def test_a_channel_weighs_by_its_rms_and_in_eq_9_by_its_sum() -> None:
    one = objective("relative")
    for channel in ("F", "M"):
        places = one.prediction.places(channel)
        measured = one.prediction.measured[places]
        assert measured.size == TIMES.size
        assert one.weights[places] == pytest.approx(np.full(50, 1 / (ASSUMED_SD * np.sqrt(np.mean(measured**2)))))
        assert one.shares[places] == pytest.approx(np.full(50, 0.5 / np.sum(np.abs(measured))))


def test_the_cost_is_that_of_its_kind() -> None:
    """By formulas over the whole record; beyond HUBER scales the cost grows as a line does, without a step or a bend."""
    left = np.where(np.arange(100) == 7, 3.0, 0.01) / objective("huber").weights
    weigh, shares = objective("huber").weights, objective("huber").shares
    assert objective("least_squares").cost(left) == pytest.approx(np.mean((left * weigh) ** 2))
    assert objective("relative").cost(left) == pytest.approx(np.sum(np.abs(left) * shares))
    assert objective("huber").cost(left) == pytest.approx((99 * 1e-4 + 2 * HUBER * 3.0 - HUBER**2) / 100)
    assert objective("huber").cost(left / 3) == pytest.approx(objective("least_squares").cost(left / 3))
    assert objective("huber").cost(np.full(100, np.nan)) == FAILED


def test_the_loss_of_a_descent_is_that_of_its_kind() -> None:
    """Squares have no bend; magnitudes are rounded off below a tenth of the spread."""
    kinds: tuple[Kind, ...] = ("least_squares", "huber", "relative")
    losses = [_loss(objective(kind), np.array([0.5]), False) for kind in kinds]
    assert [(loss.bend, loss.magnitudes) for loss in losses] == [(np.inf, False), (HUBER, False), (SMOOTH, True)]
    assert not any(loss.whitened for loss in losses)
    assert _loss(objective("least_squares"), np.array([0.5]), True).whitened
