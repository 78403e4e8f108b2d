"""Is the part that effects are looked for in a true part of the whole, and does the whole decide?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Trial
from evat.gap import diagnose_with
from evat.gap.search.compare import compare
from evat.gap.search.part import part_of
from evat.gap.search.portion import portion, shown_late, with_its_motion
from evat.inference.hypothesis import Hypothesis
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from toy import Toy, measured


def apart(made: Experiment) -> Experiment:
    """Repeats that each follow a motion of their own, so that each is a run."""
    trials = tuple(
        replace(trial, inputs={"x": (1 + 1e-2 * place) * trial.inputs["x"]}, outputs={"F": (1 + 1e-2 * place) * trial.outputs["F"]})
        for place, trial in enumerate(made.trials)
    )
    return replace(made, trials=trials)


def test_a_small_experiment_is_searched_as_a_whole() -> None:
    assert part_of(Prediction(Toy(), measured())) is None


def test_its_numbers_are_those_of_the_whole() -> None:
    prediction = Prediction(Toy(), apart(measured(conditions=9, repeats=2)))
    part = part_of(prediction)
    assert part is not None
    assert part.prediction.experiment.conditions == prediction.experiment.conditions
    assert part.rows.size <= CONSTANTS.searched_samples
    assert np.array_equal(part.prediction.measured, prediction.measured[part.rows])
    assert np.array_equal(part.prediction.one({"k": 11.0}), prediction.one({"k": 11.0})[part.rows])


def test_the_whole_decides() -> None:
    """The effect is named, and its fit is that to all data."""
    made = apart(measured(["bend"], {"bend.c": 0.2}, conditions=9, repeats=2))
    answer, comparison = diagnose_with(made, Toy())
    assert [effect.name for effect in answer.effects] == ["bend"]
    assert comparison.models[Hypothesis(("bend",))].predicted.size == comparison.prediction.measured.size
    assert comparison.rough[Hypothesis(("bend",))] > comparison.recalibrated.likelihood.evidence


def test_noise_is_that_of_the_whole() -> None:
    prediction = Prediction(Toy(), apart(measured(conditions=9, repeats=2)))
    part, comparison = part_of(prediction), compare(prediction)
    assert part is not None
    some = part.whitening(comparison.whitening, comparison.recalibrated.predicted, np.zeros(prediction.measured.size), None)
    for place, segment in enumerate(part.prediction.segments):
        whole = next(n for n, s in enumerate(prediction.segments) if s.condition == segment.condition)
        assert some.noise.sizes[place] == comparison.noise.sizes[whole]


class Late(Toy):
    """A spring whose sensor begins to drift after 3 s."""

    effects = tuple(replace(effect, unsteady=effect.name == "drift") for effect in Toy.effects)

    def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
        force = super().formula(times, values, [name for name in on if name != "drift"])["F"]
        return {"F": force + values["drift.rate"] * np.maximum(times - 3, 0) if "drift" in on else force}


@pytest.mark.parametrize(("bend", "named"), [(0.2, ("bend", "drift")), (0.0, ("drift",))])
def test_what_grows_is_looked_for_in_the_whole(bend: float, named: tuple[str, ...]) -> None:
    """In the first 1.4 s of each trial, which is searched, there is none of it: an offset was named for a drift."""
    drift = 1.5 * np.maximum(np.arange(400) * 0.01 - 3, 0)
    prediction = Prediction(Late(), apart(measured(["bend"], {"bend.c": bend}, conditions=9, repeats=2, extra=drift)))
    part = part_of(prediction)
    assert part is not None
    assert max(trial.times[-1] for trial in part.prediction.experiment.trials) < 3
    models = compare(prediction).models
    assert max(models, key=lambda on: models[on].likelihood.evidence).effects == named


def stroke(count: int, back: float) -> Trial:
    """Forth, and back from `back` of the samples on."""
    speed = np.where(np.arange(count) < back * count, 0.1, -0.1)
    return Trial("stroke.csv", "stroke", {}, np.linspace(0, 1, count), {"slip_velocity": speed}, {"friction_force": np.sign(speed)})


def test_a_part_of_a_stroke_shows_the_way_back() -> None:
    """An axis goes forth and back once: of its first half an offset is friction."""
    whole = stroke(1200, back=0.5)
    head = with_its_motion(whole, whole.head(500))
    assert 780 < head.times.size < 820
    assert with_its_motion(whole, whole.head(900)).times.size == 900
    only_forth = stroke(1200, back=1)
    assert with_its_motion(only_forth, only_forth.head(500)).times.size == 500
    undriven = replace(whole, inputs={})
    assert with_its_motion(undriven, undriven.head(500)).times.size == 500


def test_a_part_of_a_staircase_goes_as_fast_as_the_whole() -> None:
    """Plateaus, each faster than the one before: the first half is slow."""
    whole = stroke(1200, back=1)
    whole = replace(whole, inputs={"slip_velocity": 0.1 * 2.0 ** np.floor(np.arange(1200) / 200)})
    assert with_its_motion(whole, whole.head(500)).times.size == 1001


def test_a_part_shows_what_else_is_led() -> None:
    """A load that is put on late, and only there: not where another trial's head has it from the start."""
    whole = stroke(1200, back=1)
    loaded = replace(whole, inputs={**whole.inputs, "normal_load": np.where(np.arange(1200) < 800, 1.0, 5.0)})
    evenly = replace(whole, inputs={**whole.inputs, "normal_load": np.linspace(1, 5, 1200)})
    heads = [loaded.head(500), evenly.head(500)]
    assert shown_late([loaded, evenly], heads) == {"normal_load"}
    assert shown_late([loaded, evenly], [loaded.head(500), evenly]) == set()
    assert with_its_motion(loaded, loaded.head(500), {"normal_load"}).times.size == 801
    assert with_its_motion(loaded, loaded.head(500)).times.size == 500


def test_where_not_all_can_be_longer_some_go_back() -> None:
    """Strokes that go back late, of three conditions with two runs each: all of them go back in more samples than are looked at, and none
    did."""
    trials = [
        replace(
            whole, file=f"{place}.csv", condition=str(place // 2), inputs={"slip_velocity": (1 + place) * whole.inputs["slip_velocity"]}
        )
        for place, whole in enumerate([stroke(1200, back=0.5)] * 6)
    ]
    cut, note = portion(replace(measured(), trials=tuple(trials)), Toy(), 900)
    sizes = [trial.times.size for trial in cut.trials]
    going_back = [trial for trial in cut.trials if np.min(trial.inputs["slip_velocity"]) < 0]
    assert len({trial.condition for trial in going_back}) == len(going_back) == 2
    assert sorted(sizes)[:4] == [150] * 4
    assert sum(sizes) <= CONSTANTS.longer_heads * 900
    assert note == f"only the first 150 to {max(sizes)} samples of each trial were looked at; --whole takes all"
