"""Is the long vector of predictions what single runs give, sample by sample, and are its derivatives those of the model?"""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, ExperimentError, Means, Nominal, Trial
from evat.inference.prediction import Prediction, at_tolerance_of_records, runs_at_a_time
from evat.model import Run
from evat.models.contact import ContactModel

TIMES = np.arange(400) * 1e-3
VALUES: dict[str, float | str] = {"kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma2": 4.0}
MODEL = ContactModel(threads=1)


def trial(place: int, **values: float) -> Trial:
    velocity = 0.01 * (1 + place) * np.sin(2 * np.pi * 5 * TIMES)
    outputs = {"friction_force": np.full(TIMES.size, float(place)), "feed_force": np.full(TIMES.size, 10.0 + place)}
    return Trial(f"{place}.csv", f"c{place}", values, TIMES, {"slip_velocity": velocity}, outputs)


def experiment(*trials: Trial, means: Means | None = None, values: dict[str, float | str] = VALUES) -> Experiment:
    return Experiment(Path(), "test", "", Nominal(values, (), {}), {}, trials, means, "")


def test_each_segment_is_the_run_of_its_trial() -> None:
    """With the trial's own values before all others; both channels of each trial side by side."""
    asked = experiment(trial(0), trial(1, F_C=5.0))
    prediction = Prediction(ContactModel(threads=2), asked)
    rows = prediction.many({"F_C": np.array([6.0, 7.0, 8.0])}, ["direction_asymmetry"])
    assert rows.shape == (3, prediction.measured.size)
    for segment in prediction.segments:
        own = asked.trials[segment.trial]
        assert np.all(prediction.measured[segment.at] == own.outputs[segment.channel])
        for row, level in zip(rows, (6.0, 7.0, 8.0), strict=True):
            values = {**VALUES, "F_C": level, **own.values, "relative_tolerance": CONSTANTS.solver_tolerance}
            name = f"measured_{segment.channel}"
            alone = MODEL.simulate(Run(own.times, own.inputs, (name,)), ["direction_asymmetry"], values)
            assert np.array_equal(row[segment.at], alone[name])


@pytest.mark.parametrize(("threads", "together"), [(2, True), (None, True), (1, False)])
def test_trials_run_side_by_side_where_the_model_allows_it(threads: int | None, together: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two runs wait for each other, or neither does; a model that says nothing runs one after the other."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    meeting = threading.Barrier(2)

    class Met(ContactModel):
        def simulate_many(self, *asked: Any) -> Any:
            if together:
                meeting.wait(timeout=10)
            else:
                assert threading.current_thread() is threading.main_thread()
            return super().simulate_many(*asked)

    asked = experiment(trial(0), trial(1), trial(2), trial(3))
    alone = Prediction(MODEL, asked).many({"F_C": np.array([6.0, 7.0])})
    model = Met(threads)
    assert np.array_equal(Prediction(model, asked).many({"F_C": np.array([6.0, 7.0])}), alone)
    assert runs_at_a_time(Plain()) == 1  # type: ignore[arg-type]


class Plain:
    """A model that does not say how many of its runs may go on at a time."""


def test_means_are_those_of_the_periodic_motion() -> None:
    """The last of many cycles, from rest, has the mean that the means have at once."""
    speeds = np.array([0.1, 0.3])
    means = Means("m.csv", ("a", "b"), {"cutting_speed": speeds}, {"mean_feed_force": speeds, "mean_principal_force": speeds}, {})
    nominal: dict[str, float | str] = {"kinematics": "internal", "friction_law": "lugre", "relative_tolerance": 1e-8}
    prediction = Prediction(MODEL, experiment(means=means, values=nominal))
    levels = np.array([5.0, 12.0])
    rows = prediction.many({"F_C": levels})
    cycles = np.linspace(0, 30 / 20e3, 301)
    for row, level in zip(rows, levels, strict=True):
        for segment in prediction.segments:
            speed = float(speeds["ab".index(segment.condition)])
            name = "mean_measured_" + segment.channel.removeprefix("mean_")
            run = MODEL.simulate(Run(cycles, {}, (name,)), (), {**nominal, "F_C": float(level), "cutting_speed": speed})
            assert row[segment.at] == pytest.approx(run[name][-1], rel=1e-5)


def test_rows_of_one_condition_are_simulated_once() -> None:
    """Replicates share a simulation, to the bit, wherever they stand in the table."""
    asked = list[int]()

    class Counted(ContactModel):
        def simulate_many(self, run: Run, on: Any, values: Any) -> Any:
            asked.append(np.size(values["cutting_speed"]))
            return super().simulate_many(run, on, values)

    def predicted(*speeds: float) -> Any:
        column = np.array(speeds)
        means = Means("m.csv", tuple(map(str, range(column.size))), {"cutting_speed": column}, {"mean_feed_force": column}, {})
        nominal: dict[str, float | str] = {"kinematics": "internal", "friction_law": "lugre"}
        return Prediction(Counted(1), experiment(means=means, values=nominal)).many({"F_C": np.array([5.0, 12.0])})

    alone = predicted(0.1, 0.3)
    assert np.array_equal(predicted(0.3, 0.1, 0.3, 0.1, 0.1), alone[:, [1, 0, 1, 0, 0]])
    assert asked == [4, 4]  # two speeds, two sets each


def test_the_jacobian_is_the_slope_of_the_prediction() -> None:
    """Against central differences ten times as wide, whose error falls with the square; at an upper bound it is taken from within."""
    prediction = Prediction(MODEL, experiment(trial(0), trial(1)))
    names, scales = ["F_C", "sigma0", "elasto_plastic.share"], {"F_C": 9.0, "sigma0": 1e5, "elasto_plastic.share": 1.0}
    point: dict[str, float | str] = {"F_C": 9.0, "sigma0": 1e5, "elasto_plastic.share": 1.0, "relative_tolerance": 1e-9}
    at, slopes = prediction.jacobian(point, names, scales, ["elasto_plastic"])
    assert np.array_equal(at, prediction.one(point, ["elasto_plastic"]))
    for place, name in enumerate(names[:2]):
        around = [prediction.one({**point, name: float(point[name]) * (1 + side)}, ["elasto_plastic"]) for side in (-1e-3, 1e-3)]
        wide = (around[1] - around[0]) / 2e-3
        assert np.linalg.norm(slopes[:, place] - wide) < 0.02 * np.linalg.norm(wide)
    inside = (at - prediction.one({**point, "elasto_plastic.share": 0.999}, ["elasto_plastic"])) / 1e-3
    assert np.linalg.norm(slopes[:, 2] - inside) < 1e-3 * np.linalg.norm(inside)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99999, 1.0])
def test_a_difference_stays_within_the_bounds(share: float) -> None:
    """Towards the end where there is more room, and no further than that."""
    prediction = Prediction(MODEL, experiment(trial(0)))
    effect = next(each for each in MODEL.effects if each.name == "direction_asymmetry").variables[0]
    at = effect.min + share * (effect.max - effect.min)
    width = 1e4 * (effect.max - effect.min)  # a step that would leave them on either side
    _, slopes = prediction.jacobian({effect.name: at}, [effect.name], {effect.name: width}, ["direction_asymmetry"])
    assert np.all(np.isfinite(slopes))
    assert np.any(slopes)


def test_slopes_of_a_cut_are_those_over_an_interval_though_forces_jump() -> None:
    """The tool enters the work at a sample or after it. A sample in the way of a jump changes by the whole force or by nothing, the mean
    over its interval by as much as the jump has moved: its slope hardly depends on where the samples lie."""
    times = np.arange(2 * 60 + 1) * 5e-5 / 60
    made = Trial("a.csv", "a", {}, times, {}, {"principal_force": np.full(times.size, 10.0)})
    plain = Prediction(MODEL, experiment(made, values={"kinematics": "internal", "friction_law": "lugre"}))
    smooth, sd, slopes = plain.with_slopes_over_intervals(), 5e-7, list[float]()
    for place in range(40):
        values = {"amplitude_x": 5e-6 * (1 + 0.002 * place)}
        predicted, column = smooth.jacobian(values, ["amplitude_x"], {"amplitude_x": sd})
        assert np.array_equal(predicted, plain.one(values))
        slopes.append(float(np.sqrt(np.mean(column**2))))
    assert max(slopes) < 1.5 * min(slopes)
    whole = plain.one({"amplitude_x": 6e-6}) - plain.one({"amplitude_x": 5e-6})
    assert np.mean(slopes) == pytest.approx(float(np.sqrt(np.mean(whole**2))) / 2, rel=0.5)


def test_slopes_over_intervals_stand_where_samples_are() -> None:
    """Of a force that does not jump they are those of the samples, to what it bends within an interval; also where samples are missing and
    channels were sampled late."""
    times = np.delete(np.arange(120) * 5e-5 / 60, [40, 41, 77])
    outputs = {"principal_force": np.full(times.size, 10.0), "feed_force": np.full(times.size, 10.0)}
    made = Trial("a.csv", "a", {}, times, {}, outputs)
    values: dict[str, float | str] = {"kinematics": "internal", "friction_law": "lugre", "amplitude_x": 1e-7, "relative_tolerance": 1e-8}
    plain = Prediction(MODEL, experiment(made, values=values)).sampled_at({"feed_force": 2e-7})
    asked: dict[str, float | str] = {**values, "shear_stress": 4e8}
    scales = {"shear_stress": 4e7}
    _, samples = plain.jacobian(asked, ["shear_stress"], scales)
    _, means = plain.with_slopes_over_intervals().jacobian(asked, ["shear_stress"], scales)
    inside = np.concatenate([np.arange(2, times.size - 2), times.size + np.arange(2, times.size - 2)])
    assert np.max(np.abs(samples)) > 1.0
    assert np.max(np.abs(means - samples)[inside]) < 0.02 * np.max(np.abs(samples))


def test_no_slope_is_beyond_all_that_was_measured() -> None:
    """Nor predicted: one that runs away within a standard deviation counts for a hundred times the largest, so that priors still count."""

    class Leaping(ContactModel):
        def simulate_many(self, run: Run, on: Any, values: Any) -> Any:
            rows = super().simulate_many(run, on, values)
            return {name: row * np.exp(60 * (np.atleast_1d(values["F_C"])[:, None] - 9.0) / 1e-3) for name, row in rows.items()}

    asked = experiment(trial(3))
    prediction = Prediction(Leaping(threads=1), asked)
    predicted, slopes = prediction.jacobian(VALUES, ["F_C", "sigma2"], {"F_C": 1.0, "sigma2": 1.0})
    for segment in prediction.segments:
        largest = max(np.max(np.abs(asked.trials[0].outputs[segment.channel])), np.max(np.abs(predicted[segment.at])))
        assert np.max(np.abs(slopes[segment.at, 0])) == pytest.approx(100 * largest)


def test_nothing_measured_is_an_error() -> None:
    with pytest.raises(ExperimentError, match="nothing was measured"):
        Prediction(MODEL, experiment())


def test_records_are_compared_at_the_tolerance_of_the_solver_itself_and_means_at_a_tighter_one() -> None:
    records, stated = experiment(trial(0)), experiment(trial(0), values={**VALUES, "relative_tolerance": 1e-7})
    assert at_tolerance_of_records(MODEL, records).nominal.values["relative_tolerance"] == CONSTANTS.solver_tolerance_of_records
    assert at_tolerance_of_records(MODEL, stated).nominal.values["relative_tolerance"] == 1e-7
    means = Means(Path("m.csv"), ("a",), {"cutting_speed": np.ones(1)}, {"mean_feed_force": np.ones(1)}, {})
    with_means = experiment(means=means)
    assert at_tolerance_of_records(MODEL, with_means) is with_means
    assert Prediction(MODEL, with_means).nominal["relative_tolerance"] == CONSTANTS.solver_tolerance
