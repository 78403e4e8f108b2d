"""Does the diagnosis get by with what evat.model says of a model, and does it name what a toy has been given?"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import evat.gap
import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Means
from evat.gap import diagnose
from evat.gap.closure import HeldOut, _recordings
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from evat.native import kernel
from toy import FORCE, Toy, measured

FOLDER = Path(evat.gap.__file__).parent


@pytest.mark.parametrize(("on", "parameter", "value"), [("bend", "c", 0.2), ("drift", "rate", 0.3), ("lean", "a", -0.8)])
def test_the_effect_that_is_there_is_named(on: str, parameter: str, value: float) -> None:
    answer = diagnose(measured([on], {f"{on}.{parameter}": value}), Toy())
    assert answer.verdict == "effect"
    (named,) = answer.effects
    assert named.name == on
    assert named.probability > 0.9
    estimate, sd, _ = named.parameters[parameter]
    assert abs(estimate - value) < 4 * sd
    assert sd < 0.2 * abs(value)
    assert answer.closure.closed_share == pytest.approx(1.0, abs=0.05)
    assert sorted((*answer.closure.held_out_conditions, *answer.closure.unforeseen)) == ["c0", "c1", "c2", "c3"]
    assert len(answer.closure.held_out_conditions) >= 3
    assert np.isnan(answer.closure.closed_share_where_fitted[0])


@pytest.mark.parametrize(("conditions", "repeats", "has_interval"), [(2, 2, True), (1, 2, False)])
def test_too_few_conditions_tell_a_share_of_what_was_fitted(conditions: int, repeats: int, has_interval: bool) -> None:
    """Over recordings, and kept apart from the share that no fit has seen, which is not known. The interval holds the truth, all of it."""
    made = measured(["bend"], {"bend.c": 0.2}, conditions=conditions, repeats=repeats)
    answer = diagnose(made, Toy())
    closure = answer.closure
    assert (closure.held_out_conditions, np.isfinite(closure.closed_share)) == ((), False)
    share, (low, high) = closure.closed_share_where_fitted
    assert share == pytest.approx(1.0, abs=0.1)
    assert (np.isfinite(low) and low < high) == np.isfinite(low) == has_interval
    if has_interval:
        assert 0.8 < low < 1 < high < 1.2
        assert f"closes {100 * share:.0f} % of the gap of conditions that it was fitted to" in repr(answer)


def test_no_gap_is_no_gap() -> None:
    answer = diagnose(measured(), Toy())
    assert answer.verdict == "no_gap"
    assert answer.novelty[1] == 0.0
    assert answer.effects == ()


def test_a_wrong_stiffness_is_no_effect() -> None:
    answer = diagnose(measured(values={"k": 11.0}), Toy())
    assert answer.verdict == "mistuned"
    nominal, value, sd = answer.recalibration.parameters["k"]
    assert (nominal, value) == (10.0, pytest.approx(11.0, abs=4 * sd))
    assert answer.recalibration.explains_share > 0.99
    assert answer.novelty.unexplained_share < 0.02  # what another stiffness explains is not unexplained


def test_one_recording_has_no_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawn again and again it is as wide as nothing."""
    monkeypatch.setattr(HeldOut, "foreseen", lambda *_: ("c1",))
    answer = diagnose(measured(values={"k": 11.0}, repeats=1), Toy())
    assert answer.closure.held_out_conditions == ("c1",)
    share, (low, high) = answer.closure.by_recalibration
    assert share == pytest.approx(1.0, abs=0.1)
    assert np.isnan(low)
    assert np.isnan(high)


class Twice(Toy):
    """The force is recorded by a second sensor, too."""

    variables = (*Toy.variables, replace(FORCE, name="G"))

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        force = super().formula(times, values, on)["F"]
        return {"F": force, "G": force}


@pytest.mark.parametrize("conditions", [4, 2])
def test_a_second_channel_is_no_second_recording(conditions: int) -> None:
    """Of the same column twice the interval was as if each had been recorded by itself: half as wide, and one of two recordings."""
    made = measured(["bend"], {"bend.c": 0.4}, noise=0.3, conditions=conditions, repeats=1)
    twice = replace(made, trials=tuple(replace(trial, outputs={**trial.outputs, "G": trial.outputs["F"]}) for trial in made.trials))
    one, two = (diagnose(each, model).closure for each, model in ((made, Toy()), (twice, Twice())))
    assert np.isfinite(one.interval[0]) == (conditions == 4)
    assert two.interval == pytest.approx(one.interval, abs=1e-3, nan_ok=True)
    assert two.closed_share_where_fitted[1] == pytest.approx(one.closed_share_where_fitted[1], nan_ok=True)
    assert np.isfinite(two.closed_share_where_fitted[0]) == (conditions == 2)


def test_of_a_table_each_row_is_a_recording() -> None:
    forces = np.arange(1.0, 5.0)
    means = Means("m.csv", ("a", "a", "b", "c"), {"x": forces}, {"F": forces, "G": forces}, {})
    prediction = Prediction(Twice(), replace(measured(conditions=1, repeats=2), means=means))
    groups = [SimpleNamespace(condition=segment.condition, members=(place,)) for place, segment in enumerate(prediction.segments)]
    comparison: Any = SimpleNamespace(prediction=prediction, whitening=SimpleNamespace(groups=groups))
    assert _recordings(comparison, ("c0", "a", "b")) == [0, 1, 2, 3, 4, 2, 3, 4]


def test_two_effects_are_two() -> None:
    answer = diagnose(measured(["bend", "drift"], {"bend.c": 0.3, "drift.rate": 0.4}), Toy())
    assert [effect.name for effect in answer.effects] == ["bend", "drift"]


def test_what_no_effect_explains_is_unknown() -> None:
    """A hum at a frequency of its own."""
    hum = 1.5 * np.sin(2 * np.pi * 3.7 * np.arange(400) * 0.01)
    assert diagnose(measured(extra=hum), Toy()).verdict == "unknown"


def test_the_order_of_effects_does_not_matter() -> None:
    class Turned(Toy):
        effects = Toy.effects[::-1]

    experiment = measured(["bend"], {"bend.c": 0.2})
    assert diagnose(experiment, Toy()).json() == diagnose(experiment, Turned()).json()


def test_the_same_input_gives_the_same_bytes() -> None:
    experiment = measured(["lean"], {"lean.a": 0.7})
    assert diagnose(experiment, Toy()).json() == diagnose(experiment, Toy()).json()


def test_repeats_that_change_places_change_nothing() -> None:
    experiment = measured(["bend"], {"bend.c": 0.2})
    trials = experiment.trials
    turned = replace(experiment, trials=tuple(trials[place - place % 3 + (2 - place % 3)] for place in range(len(trials))))
    first, second = diagnose(experiment, Toy()), diagnose(turned, Toy())
    assert first.verdict == second.verdict
    assert first.effects[0].parameters["c"] == pytest.approx(second.effects[0].parameters["c"])


def test_the_diagnosis_names_no_effect_and_imports_no_kernel() -> None:
    """Each word of its source but for examples in docstrings, and all that it imports, one after the other."""
    effects = {effect.name for effect in kernel.effects()}
    seen, waiting = set[str](), [path for path in FOLDER.glob("*.py")]
    for path in waiting:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        examples = [ast.get_docstring(node, clean=False) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        text = path.read_text(encoding="utf-8")
        for example in filter(None, examples):
            text = text.replace(example, "")
        assert not [name for name in effects if name in text], path.name
    while waiting:
        path = waiting.pop()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                if name.startswith("evat") and name not in seen:
                    seen.add(name)
                    base = FOLDER.parent.joinpath(*name.split(".")[1:])
                    waiting.append(base / "__init__.py" if base.is_dir() else base.with_suffix(".py"))
    assert {"evat.inference.prediction", "evat.experiment", "evat.model"} <= seen
    assert not seen & {
        "evat.native.kernel",
        "evat.native.batch",
        "evat.models.contact",
        "evat.fmu",
        "evat.files.ssv",
        "evat.native.compile",
        "cffi",
    }


def test_a_long_record_is_cut_and_said_to_be() -> None:
    """Ten thousand samples each of four conditions: the same answer from the heads, and a note."""
    short = measured(["bend"], {"bend.c": 0.2})
    times = np.arange(10_000) * 0.01
    trials = tuple(
        replace(
            trial,
            times=times,
            inputs={"x": np.resize(trial.inputs["x"], times.size)},
            outputs={"F": np.resize(trial.outputs["F"], times.size)},
        )
        for trial in short.trials
    )
    answer = diagnose(replace(short, trials=trials), Toy())
    assert [effect.name for effect in answer.effects] == ["bend"]
    assert any(f"only the first {CONSTANTS.diagnosed_samples // 4} samples" in note for note in answer.cannot_tell)
    assert not any("only the first" in note for note in diagnose(short, Toy()).cannot_tell)


def test_what_would_begin_anew_in_each_recording_is_told_where_it_cannot() -> None:
    """Wear does not: what drifts back between recordings is a state."""

    class Worn(Toy):
        effects = tuple(replace(effect, irreversible=effect.name == "drift") for effect in Toy.effects)

    made = measured(["drift"], {"drift.rate": 0.3})
    (told,) = (sentence for sentence in diagnose(made, Worn()).cannot_tell if "begin anew" in sentence)
    assert told.startswith(f"whether it is drift: that would begin anew in each of {len(made.trials)} recordings")
    assert not any("begin anew" in sentence for sentence in diagnose(made, Toy()).cannot_tell)
    assert not any("begin anew" in sentence for sentence in diagnose(measured(["bend"], {"bend.c": 0.2}), Worn()).cannot_tell)
