"""What speaks against a fitted effect: its size, a bound, or that something else takes it back? On fits that are written down."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap.verdict.credibility import _of_effect
from evat.inference.hypothesis import Hypothesis
from evat.inference.parameters import Parameter
from evat.model import Variable

SHARE = Variable("m.share", "1", 0.0, 0.0, 1.0, "share", "toy", neutral=0.0)
BOTH = Hypothesis(("a", "m", "z"))


def doubted(
    *,
    value: float,
    sd: float = 0.01,
    low: float = -1.0,
    high: float = 0.9,
    gain: float = 0.0,
    does: float = 0.1,
    further: float = 1.0,
    unit: str = "1",
) -> list[str]:
    """Of `m`, fitted together with `a` and `z`: its share and the sd of that, the parameter's bounds, the evidence gained over the model
    without it, what it does to the channel F by its measured rms, how much further it would go without bounds, and its unit."""
    share = Parameter(SHARE.name, unit, 0.0, 1.0, low, high)
    fit = SimpleNamespace(
        likelihood=SimpleNamespace(evidence=10.0 + gain, step=np.array([further]), covariance=np.array([[sd**2]])),
        parameters=(share,),
        point=np.array([value]),
        sd={SHARE.name: sd},
        values={SHARE.name: value, "k": 3.0},
        on=("a", "m", "z"),
        predicted=2.0 * does * np.ones(4),
    )

    def one(values: dict[str, float], on: list[str]) -> np.ndarray:
        assert values == {"k": 3.0}
        assert on == ["a", "z"]
        return np.zeros(4)

    worse, other = (SimpleNamespace(likelihood=SimpleNamespace(evidence=evidence)) for evidence in (-90.0, 10.0))
    comparison: Any = SimpleNamespace(
        prediction=SimpleNamespace(
            model=SimpleNamespace(effects=(SimpleNamespace(name="m", variables=(SHARE,)), SimpleNamespace(name="a", variables=()))),
            one=one,
            places=lambda channel: slice(None),
        ),
        models={BOTH: fit, Hypothesis(("a", "z")): other},
        recalibrated=worse,
        whitening=SimpleNamespace(levels={"F": 2.0}),
    )
    return _of_effect(comparison, BOTH, "m")


def test_a_size_that_is_not_known_is_doubted_unless_the_evidence_is_clear() -> None:
    """Clear against the same set without this effect, not against no effect at all."""
    sd = 0.5 / (0.9 * CONSTANTS.significant_amplitude)
    (reason,) = doubted(value=0.5, sd=sd)
    assert reason == f"m is no better known than its size: {0.5 / sd:.2g} standard deviations from nothing"
    assert doubted(value=0.5, sd=sd, gain=1.1 * CONSTANTS.clear_evidence) == []
    assert doubted(value=0.5, sd=sd, gain=0.9 * CONSTANTS.clear_evidence) == [reason]
    assert doubted(value=0.5, sd=0.5 / (1.1 * CONSTANTS.significant_amplitude)) == []


def test_a_value_at_a_bound_is_doubted_unless_the_bounds_are_those_of_its_definition() -> None:
    near, far = 0.5 * CONSTANTS.distance_to_bound, 2 * CONSTANTS.distance_to_bound
    assert "lies at the bound" in doubted(value=0.9 - near)[0]
    assert "lies at the bound" in doubted(value=0.2 + near, low=0.2, high=math.inf)[0]
    assert doubted(value=0.9 - far) == doubted(value=0.2 + far, low=0.2) == []
    assert doubted(value=1.0, low=0.0, high=1.0) == []
    assert "lies at the bound" in doubted(value=1.0, low=0.1, high=1.0)[0]
    assert "lies at the bound" in doubted(value=0.9, low=0.0, high=0.9)[0]


def test_a_speed_slower_than_all_that_was_recorded_is_as_good_as_any_slower_one() -> None:
    """Logarithms of a rate-and-state law grow from v_0 on, in the literature 1 um/s and less: a true one was doubted."""
    near = 0.5 * CONSTANTS.distance_to_bound
    assert doubted(value=0.2 + near, low=0.2, unit="m/s") == []
    assert "lies at the bound" in doubted(value=0.9 - near, low=0.2, unit="m/s")[0]
    assert "lies at the bound" in doubted(value=near, low=0.0, high=0.9, unit="m/s")[1]


def test_a_value_at_a_bound_is_not_doubted_where_it_would_be_without_one() -> None:
    """A damping of a quarter, which a platform has at most and this one had, was told from 0.26, and doubted."""
    near = CONSTANTS.near_bound
    assert doubted(value=0.9, sd=0.5 * near, further=0.9 * near) == []
    assert doubted(value=0.9, sd=0.5 * near, further=1.1 * near) == ["m.share = 0.9 lies at the bound of what it may be"]
    assert "lies at the bound" in doubted(value=0.9, sd=1.1 * near, further=0.0)[0]


@pytest.mark.parametrize("times", [0.9, 1.1])
def test_what_something_else_takes_back_is_doubted(times: float) -> None:
    does = times * CONSTANTS.absurd_effect
    expected = [f"m would make {does:.3g} times the measured rms of F, which something else takes back"]
    assert doubted(value=0.5, does=does) == (expected if times > 1 else [])
