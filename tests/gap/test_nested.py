"""Is a model at least as likely as one that it contains, whatever local optimum its first fit came to?"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evat.gap.search import nested, recalibration
from evat.inference.hypothesis import Hypothesis
from evat.model import FloatArray

AMPLITUDE, SHAPE = (
    SimpleNamespace(name="a.size", neutral=0.0),
    SimpleNamespace(name="a.length", neutral=float("nan")),
)
PREDICTION: Any = SimpleNamespace(
    model=SimpleNamespace(effects=[SimpleNamespace(name="a", variables=[AMPLITUDE, SHAPE])]), setup_names=frozenset[str](), experiment=None
)
LEVEL = SimpleNamespace(name="F_C")


@pytest.fixture(autouse=True)
def stated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recalibration, "nominal_parameters", lambda *_: (LEVEL,))


def model(log: float, point: Sequence[float], names: Sequence[str], on: tuple[str, ...] = ()) -> Any:
    parameters = tuple(SimpleNamespace(name=name, value=lambda u: 10 * u) for name in names)
    return SimpleNamespace(
        likelihood=SimpleNamespace(log=log, evidence=log), point=np.array(point), parameters=parameters, on=on, fixed={}, values={}
    )


PART = model(-500.0, [1.5], ["F_C"])


@pytest.fixture
def starts(monkeypatch: pytest.MonkeyPatch) -> list[list[float]]:
    """Where fits start. They end there: at -300 where the effect does nothing at the level of the part, else at -700."""
    tried = list[list[float]]()

    def fit(prediction: Any, whitening: Any, parameters: Any, start: FloatArray, on: Any, *, fixed: Any) -> Any:
        tried.append(start.tolist())
        return model(-300.0 if start[:2].tolist() == [1.5, 0.0] else -700.0, start, [p.name for p in parameters], on)

    monkeypatch.setattr(nested, "fit", fit)
    return tried


def whole(log: float) -> Any:
    return model(log, [-2.0, 3.0, 0.7], ["F_C", "a.size", "a.length"], ("a",))


def test_a_fit_that_came_less_far_starts_from_what_it_contains(starts: list[list[float]]) -> None:
    """First with the effect as it is, then where it does nothing; what has no nothing, such as a length, stays."""
    assert nested.at_least(PREDICTION, None, whole(-600.0), PART).likelihood.log == -300.0  # type: ignore[arg-type]
    assert starts == [[1.5, 3.0, 0.7], [1.5, 0.0, 0.7]]


def test_a_fit_that_came_as_far_is_kept(starts: list[list[float]]) -> None:
    fitted = whole(-501.0)
    assert nested.at_least(PREDICTION, None, fitted, PART) is fitted  # type: ignore[arg-type]
    assert nested.at_least(PREDICTION, None, fitted, model(-100.0, [0.0], ["sigma0"])) is fitted  # type: ignore[arg-type]
    assert not starts


def test_a_pair_starts_from_the_better_of_its_effects(starts: list[list[float]], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nested, "_go_on_from_pairs", lambda *_: None)
    alone = model(-400.0, [1.5, 0.0, 0.2], ["F_C", "b.size", "a.length"], ("b",))
    pair = model(-600.0, [0.0, 9.0, 0.2, 8.0], ["F_C", "b.size", "a.length", "a.size"], ("a", "b"))
    models = {Hypothesis(("a",)): whole(-450.0), Hypothesis(("b",)): alone, Hypothesis(("a", "b")): pair}
    nested.polish(PREDICTION, None, model(-1000.0, [0.0], ["F_C"]), models)  # type: ignore[arg-type]
    assert models[Hypothesis(("a", "b"))].likelihood.log == -300.0
    assert starts[-1] == [1.5, 0.0, 0.2, 8.0]


@pytest.mark.parametrize("moved", [3.0, 4.0])
def test_where_recalibration_is_not_credible_the_best_begins_at_the_nominal_values(moved: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A contact with several elements stood at a tenth of its share, beside a damping 8 standard deviations off, and never came back: it
    gained 70 of log evidence, and 110 from where the effect alone had first done what it could."""
    tried = list[tuple[list[str], list[float], dict[str, float]]]()

    def fit(prediction: Any, whitening: Any, parameters: Any, start: FloatArray, on: Any, *, fixed: Any) -> Any:
        names = [p.name for p in parameters]
        tried.append((names, start.tolist(), fixed))
        return model(-200.0, start if "F_C" in names else [5.0, 0.9], names, on)

    monkeypatch.setattr(nested, "fit", fit)
    models = {Hypothesis(("a",)): whole(-450.0)}
    nested.polish(PREDICTION, None, model(-500.0, [moved], ["F_C"]), models)  # type: ignore[arg-type]
    if moved < 3.5:
        assert not tried
        return
    assert tried == [(["a.size", "a.length"], [3.0, 0.7], {"F_C": 0.0}), (["F_C", "a.size", "a.length"], [0.0, 5.0, 0.9], {})]
    assert models[Hypothesis(("a",))].likelihood.log == -200.0
