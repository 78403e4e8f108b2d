"""Is the motion behind noisy recordings of it found, and are repeats compared only where they share it?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Trial
from evat.experiment.smoothing import derivative, noise_sd, smoothed
from evat.gap import diagnose_with
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import Prediction
from evat.inference.recorded_inputs import comparable, in_step, same_motion, smoothed_inputs
from evat.model import FloatArray, IntArray
from toy import Toy, measured

TIMES = np.arange(3000) * 1e-3
MOTIONS: dict[str, FloatArray] = {
    "sine": 0.2 * np.sin(4 * np.pi * TIMES),
    "trapezoid": np.clip(0.45 * np.sin(2 * np.pi * TIMES), -0.2, 0.2),
    "levels": np.convolve(np.repeat(np.resize([0, 0.2, 0.1, 0.2, 0, -0.2, -0.1, -0.2], 30), 100), np.hanning(10) / 4.5, mode="same"),
    "stops": np.interp(TIMES, [0, 0.5, 0.8, 1.2, 1.5, 2, 2.2, 3], [0, 0, 0.2, 0.2, -0.2, -0.2, 0, 0]),
}


def noisy(made: Experiment, sd: float, seed: int = 5) -> Experiment:
    draw = np.random.default_rng(seed)
    trials = (replace(t, inputs={n: c + sd * draw.normal(size=c.size) for n, c in t.inputs.items()}) for t in made.trials)
    return replace(made, trials=tuple(trials))


@pytest.mark.parametrize("name", MOTIONS)
def test_noise_is_told_from_motion(name: str) -> None:
    assert noise_sd(MOTIONS[name]) < 1e-6
    for sd in (5e-4, 5e-3, 2e-2):
        drawn = sd * np.random.default_rng(1).normal(size=TIMES.size)
        assert pytest.approx(sd, rel=0.1) == noise_sd(MOTIONS[name] + drawn)
        rest = smoothed(MOTIONS[name] + drawn, sd) - MOTIONS[name]
        # ramps of eight samples, one in a hundred, are corners: a mean of three missed them by 1.7 times the noise
        assert np.sqrt(np.mean(rest**2)) < (0.9 if name == "levels" else 0.5) * sd


def test_an_input_without_noise_is_left_as_it_is() -> None:
    made = measured()
    assert smoothed_inputs(made).experiment is made
    assert smoothed_inputs(made).perturbed is None


def test_repeats_of_one_motion_get_one_input() -> None:
    recorded = smoothed_inputs(noisy(measured(repeats=3), 0.01))
    assert len(set(Prediction(Toy(), recorded.experiment).alike.values())) == 4
    assert recorded.perturbed is not None
    assert pytest.approx(0.01, rel=0.15) == recorded.noise["x"]


def led_in(trial: Trial, way: float, count: int, clock: float = 0.0) -> Trial:
    """The trial after a stroke that way, of which so many samples of 1 ms were recorded; its own clock starts at `clock`."""
    times = trial.times[0] - 1e-3 * np.arange(count, 0, -1)
    x = way * np.sin(1e-2 * np.arange(-count, 0))
    lead = Trial(trial.file, trial.condition, trial.values, times + clock, {"x": x}, {"F": np.zeros(count)})
    return replace(trial, times=trial.times + clock, lead_in=lead)


def test_each_repeat_keeps_what_came_before_it() -> None:
    """One approached forward, the other backward: with a noisy input both ran after the forward stroke, 17 N off. One motion before both,
    of which more or less was recorded, is one."""
    made = measured(repeats=4, conditions=1)
    ways = ((1.0, 400, 0.0), (-1.0, 400, 5.0), (1.0, 300, 9.0), (-1.0, 200, 0.0))
    trials = tuple(led_in(trial, *way) for trial, way in zip(made.trials, ways, strict=True))
    assert smoothed_inputs(replace(made, trials=trials)).experiment.trials == trials
    with_noise = noisy(replace(made, trials=trials), 0.01)
    draw = np.random.default_rng(3)
    leads = [
        replace(t.lead_in, inputs={"x": t.lead_in.inputs["x"] + 0.01 * draw.normal(size=t.lead_in.times.size)})
        for t in with_noise.trials
        if t.lead_in
    ]
    given = replace(made, trials=tuple(replace(t, lead_in=lead) for t, lead in zip(with_noise.trials, leads, strict=True)))
    smooth = smoothed_inputs(given).experiment.trials
    for trial, (way, _, _) in zip(smooth, ways, strict=True):
        assert trial.lead_in is not None
        assert np.sign(np.mean(trial.lead_in.inputs["x"][-100:])) == -way
        assert trial.lead_in.times[-1] == pytest.approx(trial.times[0] - 1e-3)
    assert len(set(Prediction(Toy(), replace(given, trials=smooth)).alike.values())) == 2


def test_an_input_without_noise_is_left_as_it_is_beside_a_noisy_one() -> None:
    """Repeats with noise in one condition, none in another, where one repeat was recorded by another clock."""
    made = measured(repeats=2, conditions=2)
    kept = [replace(t, times=t.times + 7.0 * (n % 2)) for n, t in enumerate(made.trials) if t.condition == "c1"]
    with_noise = noisy(replace(made, trials=tuple(t for t in made.trials if t.condition == "c0")), 0.01).trials
    smooth = smoothed_inputs(replace(made, trials=(*with_noise, *kept))).experiment.trials
    assert smooth[2:] == tuple(kept)


def test_inertia_that_was_taken_off_is_as_unsure_as_the_acceleration() -> None:
    """Of 20 kg the acceleration of a noisy velocity is a force: 0.05 m/s2 are 1 N where the axis speeds up, and nothing said so."""
    motion, force = MOTIONS["trapezoid"], np.sign(MOTIONS["trapezoid"])
    trials = tuple(Trial(f"{n}.csv", "c", {}, TIMES, {"slip_velocity": motion}, {"friction_force": force}) for n in range(2))
    made = noisy(Experiment(Path(), "axis", "", Nominal({}, (), {}), {}, trials, None, ""), 1e-3)
    for mass in (0.0, 20.0):
        recorded = smoothed_inputs(replace(made, mass=mass))
        assert recorded.perturbed is not None
        (first, second), kept = ([t.outputs["friction_force"] for t in e.trials] for e in (recorded.perturbed, recorded.experiment))
        taken = first - kept[0]
        assert np.array_equal(taken, second - kept[1])
        again = derivative(noisy(made, 1e-3, seed=8).trials[0].inputs["slip_velocity"], 1e-3) - np.gradient(motion, TIMES)
        assert np.sqrt(np.mean(taken**2)) == pytest.approx(mass * np.sqrt(np.mean(again**2)), rel=0.5)
        assert np.all(np.isfinite(taken))


def test_a_noisy_input_names_no_effect() -> None:
    """At 3 % of the stroke the noise of the way makes a force of 3 times that of the sensor."""
    made = noisy(measured(noise=0.03, conditions=5), 0.01)
    answer, comparison = diagnose_with(made, Toy())
    assert answer.verdict == "no_gap"
    assert any(line.startswith("x is noisy, 0.01") for line in answer.cannot_tell)
    assert max(comparison.noise.sizes) < 0.04  # what the sensor has, not what the input makes


def late(trial: Trial, samples: int) -> Trial:
    """The same motion, recorded from another moment on."""

    def turned(column: FloatArray) -> FloatArray:
        return column[samples : samples + 300]

    inputs, outputs = ({n: turned(c) for n, c in some.items()} for some in (trial.inputs, trial.outputs))
    return replace(trial, times=trial.times[:300], inputs=inputs, outputs=outputs)


def test_repeats_out_of_step_are_compared_in_step() -> None:
    """Model error is no noise: the nominal stiffness is 20 % off."""
    made = measured(values={"k": 12.0}, noise=0.02, repeats=3)
    trials = tuple(late(trial, 7 * (place % 3)) for place, trial in enumerate(made.trials))
    prediction = Prediction(Toy(), replace(made, trials=trials))
    assert len(same_motion(trials)) == len(trials)
    places = in_step(trials[:3])
    assert [at[0] - places[0][1][0] for _, at in places] == [0, -7, -14]
    noise = estimate_noise(prediction, prediction.one())
    assert noise.degrees["F"] == 8
    assert pytest.approx(0.02, rel=0.2) == np.median(noise.sizes)
    assert noise.spread["F"][0] < 0.01


def by_itself(first: int, count: int = 280) -> Trial:
    """A vibration that goes by the clock, recorded from its sample `first` on."""
    times = (first + np.arange(count)) * 4.8e-7
    return Trial(f"{first}.csv", "c", {"cutting_speed": 0.2}, times, {}, {"F": np.sin(1.3e5 * times)})


def test_what_moves_by_itself_is_compared_by_its_clock() -> None:
    """Without a recorded motion two starts in another phase are two motions, however alike the clocks run."""
    trials = [by_itself(97), by_itself(93), by_itself(97), by_itself(102, 255)]
    assert same_motion(trials) == [[0, 2], [1], [3]]
    together = dict(in_step(trials))
    assert len(together) == 4
    rows = [trials[place].outputs["F"][at] for place, at in together.items()]
    assert all(row == pytest.approx(rows[0], abs=1e-9) for row in rows)
    lost = np.delete(np.arange(280), [140, 141])
    gap = replace(trials[2], times=trials[2].times[lost], outputs={"F": trials[2].outputs["F"][lost]})
    (_, whole), (_, part) = in_step([trials[0], gap])
    assert trials[0].outputs["F"][whole] == pytest.approx(gap.outputs["F"][part], abs=1e-9)
    assert whole.size == 278
    between = replace(trials[1], times=trials[1].times + 2.4e-7)  # half a sample
    assert dict(in_step([trials[0], between, trials[2]])).keys() == {0, 2}


def stroking(kept: IntArray) -> Trial:
    """A motion that repeats itself every 20 samples."""
    times = kept * 2e-3
    speed = np.sin(2 * np.pi * 25 * times)
    return Trial(f"{kept.size}.csv", "c", {}, times, {"x": speed}, {"F": speed})


def test_repeats_of_other_lengths_are_compared_from_their_start() -> None:
    """A motion that repeats itself agrees with itself a stroke later as well."""
    trials = [stroking(np.arange(count)) for count in (500, 487, 474)]
    assert [(place, at[0], at.size) for place, at in in_step(trials)] == [(0, 0, 474), (1, 0, 474), (2, 0, 474)]


def test_repeats_that_lack_samples_are_compared_by_their_clocks() -> None:
    """Behind a gap they come earlier than before it."""
    every = np.arange(500)
    trials = [stroking(every), stroking(np.delete(every, [90, 300])), stroking(np.delete(every, [40]))]
    kept = in_step(trials)
    assert [at.size for _, at in kept] == [497, 497, 497]
    times = [trials[place].times[at] for place, at in kept]
    assert np.array_equal(times[0], times[1])
    assert np.array_equal(times[0], times[2])


@pytest.mark.parametrize("other", [lambda x: 0.5 * x, lambda x: x[::-1] ** 2])
def test_repeats_of_other_motions_are_not_compared(other: Callable[[FloatArray], FloatArray]) -> None:
    trials = measured(conditions=1, repeats=2).trials
    changed = replace(trials[1], inputs={"x": other(trials[1].inputs["x"])})
    assert same_motion((trials[0], changed)) == [[0], [1]]
    assert len(in_step((trials[0], changed))) < 2


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("late", [0, 7])
def test_a_recording_that_was_broken_off_does_not_cut_the_others(place: int, late: int) -> None:
    """Beside two whole repeats one of 18 samples left 18 of 3000 to compare: noise with a memory was told as white, and a gap was seen."""
    made = measured(repeats=2, conditions=1)
    first, second = made.trials
    if late:
        second = replace(
            second,
            times=second.times[late:] - second.times[late],
            inputs={"x": second.inputs["x"][late:]},
            outputs={"F": second.outputs["F"][late:]},
        )
    trials = [first, second]
    trials.insert(place, first.head(30))
    kept = [at for group in comparable(trials) for _, at in group]
    assert [at.size for at in kept] == 2 * [first.times.size - late]


def test_short_repeats_count() -> None:
    made = measured(repeats=6, noise=0.05)
    prediction = Prediction(Toy(), replace(made, trials=tuple(trial.head(15) for trial in made.trials)))
    noise = estimate_noise(prediction, prediction.one())
    assert noise.degrees["F"] == 20
    assert pytest.approx(0.05, rel=0.25) == np.median(noise.sizes)
