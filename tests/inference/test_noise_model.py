"""Is there one answer about the noise of a record, and is it right? Repeats whose noise and scatter between trials are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.experiment import Experiment, ExperimentError, Nominal, Signal, Trial
from evat.gap.search.compare import compare
from evat.identification import Settings, identify
from evat.identification.objective import Kind
from evat.inference.checks import opposed, unit_ratio
from evat.inference.noise.autoregression import WHITE, autoregression, impulse_response, innovation_sd, innovations
from evat.inference.noise.estimate import differing, estimate_noise, random_effects, repeatability, without_jumps
from evat.inference.prediction import Prediction
from evat.inference.sample_whitening import SampleWhitening
from evat.model import FloatArray, Run
from known_rigs import FREE, MODEL, SLIDING, TIMES, TO_AND_FRO, TRUTH, exact, experiment, force, trial
from scipy.signal import lfilter
from toy import Toy
from toy import measured as toy_measured

NOISE, REPEATS = 0.01, 6
QUICK = Settings(search="none", profiles=False)
GAINS = 1 + 0.03 * np.array([1.2, -0.9, 0.4, -1.4, 0.9, -0.2])
FORCE = force(TO_AND_FRO)
LEVEL = float(np.sqrt(np.mean(FORCE**2)))
FORCE_REPEATED = np.tile(FORCE, REPEATS)


def repeats(gains: Sequence[float] = GAINS) -> Experiment:  # type: ignore[assignment]
    trials = [trial(TO_AND_FRO, seed=place, measured=FORCE * gain, noise=NOISE) for place, gain in enumerate(gains)]
    return experiment(*trials, nominal=TRUTH)


@pytest.fixture(scope="module")
def rig() -> Prediction:
    return Prediction(MODEL, repeats())


def test_an_autoregression_is_told_by_its_recordings() -> None:
    """e_t = 1.1 e_(t-1) - 0.3 e_(t-2) + white; one burst, and the steps between recordings, change nothing."""
    rng = np.random.default_rng(3)
    rows = [lfilter([1.0], [1.0, -1.1, 0.3], rng.standard_normal(4000)) + 0.0 for _ in range(3)]
    rows[1][2000:2004] += 300.0
    filter_ = autoregression(rows)
    assert filter_[:3] == pytest.approx([1.0, -1.1, 0.3], abs=0.05)
    assert impulse_response(filter_, 3) == pytest.approx([1.0, 1.1, 0.91], abs=0.08)
    assert np.array_equal(autoregression([rng.standard_normal(4000)]), WHITE)
    assert np.array_equal(autoregression([np.arange(10.0)]), WHITE)


def test_a_slow_noise_beside_a_white_one_is_white_behind_its_filter() -> None:
    """As an amplifier's 1/f noise: six lags left twice the variance of white noise in the slowest periods, where effects are told."""
    rng = np.random.default_rng(5)
    slow = [lfilter([np.sqrt(1 - 0.99**2)], [1.0, -0.99], rng.standard_normal(2000)) for _ in range(6)]
    rows = [np.sqrt(0.4) * row + np.sqrt(0.6) * rng.standard_normal(2000) for row in slow]
    filter_ = autoregression(rows)
    spectra = [np.abs(np.fft.rfft(innovations(filter_, row))[1:9]) ** 2 / row.size for row in rows]
    assert np.mean(spectra) == pytest.approx(innovation_sd(filter_, rows) ** 2, rel=0.4)  # of 48 numbers: 0.14


def test_a_short_recording_loses_few_samples_to_its_filter() -> None:
    rng = np.random.default_rng(6)
    rows = [lfilter([1.0], [1.0, -0.97], rng.standard_normal(200))[-60:] + 2 * rng.standard_normal(60) for _ in range(60)]
    assert autoregression(rows).size <= 1 + CONSTANTS.usual_lags


def test_a_gain_that_scatters_is_no_noise_within_a_trial(rig: Prediction) -> None:
    """Noise of 1 % of the rms, white; gains with a standard deviation of 3.2 %. Taken together they would be 3.4 % and correlated."""
    noise = estimate_noise(rig, FORCE_REPEATED, prior=False, from_residual=True)
    assert np.array_equal(noise.filters["friction_force"], WHITE)
    assert noise.sizes == pytest.approx(NOISE * LEVEL, rel=0.05)
    gain, zero, clock = noise.spread["friction_force"]
    assert gain == pytest.approx(float(GAINS.std(ddof=1)), rel=0.05)
    assert zero < 0.01 * LEVEL
    assert clock < 1e-4
    assert noise.degrees["friction_force"] == REPEATS - 1
    assert repeatability(rig)["friction_force"] > 3 * NOISE * LEVEL


def test_noise_that_is_stated_counts_before_that_of_repeats() -> None:
    """The last trial is stated to be ten times as noisy as the others, which are repeats of each other. Noise goes on by 0.6
    from sample to sample, and sizes are those of what is new in it."""
    rows = lfilter([1.0], [1.0, -0.6], np.random.default_rng(1).standard_normal((REPEATS, FORCE.size)))
    trials = [trial(TO_AND_FRO, seed=0, measured=FORCE + row, noise=0.0) for row in rows]
    trials[-1] = replace(trials[-1], condition="another", noise_sd={"friction_force": 12.5})
    sizes = estimate_noise(Prediction(MODEL, experiment(*trials, nominal=TRUTH)), FORCE_REPEATED).sizes
    assert sizes[:-1] == pytest.approx(1.0, rel=0.1)
    assert sizes[-1] == pytest.approx(12.5 * np.sqrt(1 - 0.6**2), rel=0.05)


def other_noise(sizes: Sequence[float], alike: int = 1, seed: int = 0) -> Experiment:
    """A recording for each size of noise [N], of motions of their own but for the first, which is recorded `alike` times."""
    motions = [(0, sizes[0])] * alike + list(enumerate(sizes))[1:]
    trials = []
    for place, (which, size) in enumerate(motions):
        slip = (1 + 0.2 * which) * TO_AND_FRO
        white = np.random.default_rng([seed, place]).standard_normal(slip.size)
        made = trial(slip, f"c{which}", seed=place, noise=0.0, measured=force(slip) + size * white)
        trials.append(made)
    return exact(experiment(*trials, nominal=TRUTH))


def test_each_recording_that_nobody_repeated_has_its_own_noise() -> None:
    """One of 0.5 N beside four of 0.02 N: all had 0.22 N, and the estimates the noise of the one."""
    sizes = [0.02] * 4 + [0.5]
    prediction = Prediction(MODEL, other_noise(sizes))
    noise = estimate_noise(prediction, prediction.one(), prior=False, from_residual=True)
    assert noise.sizes == pytest.approx(sizes, rel=0.1)
    both, calm = (identify(other_noise(some), MODEL, ["F_C"], QUICK)["F_C"] for some in (sizes, sizes[:4]))
    assert both.sd == pytest.approx(calm.sd, rel=0.1)
    assert abs(both.value - calm.value) < calm.sd


def test_a_short_recording_has_the_noise_of_all() -> None:
    """Of a few samples a fit may leave next to nothing by chance, and these would then count before all others."""
    made = other_noise([0.1, 0.1])
    few = made.trials[1].head(CONSTANTS.samples_of_own_noise - 1)
    prediction = Prediction(MODEL, replace(made, trials=(made.trials[0], few)))
    noise = estimate_noise(prediction, prediction.one(), prior=False, from_residual=True)
    whole = prediction.measured - prediction.one()
    assert noise.sizes[1] == pytest.approx(np.sqrt(np.mean(whole**2)), rel=1e-6)


@pytest.mark.parametrize(("single", "expected"), [(0.5, 0.5), (0.002, 0.02)])
def test_a_recording_beside_repeats_may_have_more_noise(single: float, expected: float) -> None:
    """It had that of the repeats, so that a true model missed something; less than theirs it does not get."""
    made = other_noise([0.02, single], alike=3)
    prediction = Prediction(MODEL, made)
    noise = estimate_noise(prediction, prediction.one(), prior=False, from_residual=True)
    assert noise.sizes == pytest.approx([0.02, 0.02, 0.02, expected], rel=0.15)
    answer = identify(made, MODEL, ["F_C"], QUICK)
    assert not any("misses something" in doubt for doubt in answer.doubts)
    assert answer.fits["friction_force"].noise == pytest.approx(np.sqrt((3 * 0.02**2 + expected**2) / 4), rel=0.1)


def test_what_a_model_misses_beside_repeats_is_missed() -> None:
    """A force that is 5 % larger in the one recording that was not repeated."""
    made = other_noise([0.02, 0.02], alike=3)
    off = made.trials[-1]
    grown = replace(off, outputs={name: column * 1.05 for name, column in off.outputs.items()})
    answer = identify(replace(made, trials=(*made.trials[:-1], grown)), MODEL, ["F_C"], QUICK)
    assert any("misses something" in doubt for doubt in answer.doubts)


def test_identification_and_diagnosis_say_the_same_of_it(rig: Prediction) -> None:
    of_gap = compare(rig).noise
    of_fit = estimate_noise(rig, FORCE_REPEATED, prior=False, from_residual=True)
    assert np.array_equal(of_gap.filters["friction_force"], of_fit.filters["friction_force"])
    assert of_gap.sizes == pytest.approx(of_fit.sizes, rel=0.02)
    assert of_gap.spread["friction_force"][0] == pytest.approx(of_fit.spread["friction_force"][0], rel=0.3)  # its prior weighs two repeats


def test_standard_errors_know_of_the_scatter_and_no_doubt_is_cast_on_the_model() -> None:
    """Six gains tell their mean to 1.3 %, and with all parameters free a gain cannot be told from them; noise alone would tell F_C far
    better."""
    scattered = identify(exact(repeats()), MODEL, FREE, QUICK)
    alone = identify(exact(repeats([1.0] * REPEATS)), MODEL, FREE, QUICK)
    expected = float(GAINS.std(ddof=1)) / np.sqrt(REPEATS)
    assert scattered["F_C"].sd / float(TRUTH["F_C"]) == pytest.approx(expected, rel=0.1)
    assert alone["F_C"].sd / float(TRUTH["F_C"]) < 0.2 * expected
    assert not [doubt for doubt in scattered.doubts if "the model misses something" in doubt]


def test_whitening_makes_the_covariance_one() -> None:
    """W S W' = I with S = size^2 (A' A)^-1 + B D B' of a recording, but for the first samples, whose past is unknown."""
    short = trial(TO_AND_FRO[:120])
    alike = [
        replace(short, file=f"{k}.csv", outputs={"friction_force": short.outputs["friction_force"] * gain})
        for k, gain in enumerate((1.0, 1.04))
    ]
    prediction = Prediction(MODEL, experiment(*alike, nominal=TRUTH))
    predicted = prediction.one()
    filter_ = np.array([1.0, -0.6])
    noise = estimate_noise(prediction, predicted, prior=False)
    noise = replace(
        noise, filters={"friction_force": filter_}, sizes=np.array([0.2, 0.3]), spread={"friction_force": np.array([0.05, 0.4, 1e-3])}
    )
    whiten = SampleWhitening(prediction, noise, predicted)
    matrix = whiten(np.eye(240))
    A = np.eye(120) - 0.6 * np.eye(120, k=-1)
    for place, size in enumerate((0.2, 0.3)):
        at = slice(120 * place, 120 * place + 120)
        times, clean = alike[0].times, predicted[at]
        B = np.column_stack([clean, np.ones(120), -np.gradient(clean, times)]) * [0.05, 0.4, 1e-3 * np.median(np.diff(times))]
        S = size**2 * np.linalg.inv(A) @ np.linalg.inv(A).T + B @ B.T
        W = matrix[at, at][1:]
        # rows beyond the first are those of the stationary noise that the filter assumes
        assert pytest.approx(np.eye(119), abs=1e-8) == W @ S @ W.T
    assert not np.any(matrix[:120, 120:])


def test_a_short_recording_is_whitened_whole() -> None:
    """W S W' = I for all of its samples, with S the stationary covariance."""
    short = trial(TO_AND_FRO[:25])
    prediction = Prediction(MODEL, experiment(short, nominal=TRUTH))
    filter_, size = np.array([1.0, -0.6]), 0.3
    noise = estimate_noise(prediction, prediction.one(), prior=False)
    noise = replace(noise, filters={"friction_force": filter_}, sizes=np.array([size]))
    W = SampleWhitening(prediction, noise, prediction.one())(np.eye(25))
    S = size**2 / (1 - 0.6**2) * 0.6 ** np.abs(np.subtract.outer(np.arange(25), np.arange(25)))
    assert pytest.approx(np.eye(25), abs=1e-9) == W @ S @ W.T


def test_checks_have_one_threshold() -> None:
    rng = np.random.default_rng(0)
    simulated = np.sin(TIMES)
    assert opposed(-simulated, simulated) == pytest.approx(-1.0)
    assert opposed(simulated + rng.standard_normal(TIMES.size), simulated) is None
    assert CONSTANTS.opposed_correlation < 0
    assert unit_ratio(1e3 * simulated, simulated) == pytest.approx(1e3)
    assert unit_ratio(CONSTANTS.wrong_unit_ratio / 2 * simulated, simulated) is None
    turned = experiment(trial(TO_AND_FRO, measured=-FORCE), nominal=TRUTH)
    with pytest.raises(ExperimentError, match="reverse the sign"):
        identify(turned, MODEL, ["F_C"], QUICK)
    assert any("check its sign" in said for said in compare(Prediction(MODEL, turned)).audit.refused)


@pytest.mark.parametrize("objective", get_args(Kind))
def test_a_recording_shorter_than_the_filter_counts_as_it_is(objective: Kind) -> None:
    """Three samples beside a thousand whose noise, a moving average, takes an autoregression of the highest order."""
    coloured = 0.1 * lfilter([1.0, 1.0, 1.0, 1.0], [1.0], np.random.default_rng(0).standard_normal(FORCE.size))
    assert autoregression([coloured]).size > 4
    rig = experiment(
        trial(TO_AND_FRO, measured=FORCE + coloured, noise=0.0), trial(TO_AND_FRO[:3], "c1", measured=FORCE[:3], noise=0.0), nominal=TRUTH
    )
    settings = Settings(objective=objective, search="none", profiles=False)
    estimate = identify(rig, MODEL, ["F_C", "sigma2"], settings)["F_C"]
    assert 0 < estimate.sd < 0.05 * estimate.value
    assert estimate.value == pytest.approx(float(TRUTH["F_C"]), abs=4 * estimate.sd)


def test_a_clock_between_samples_makes_no_gain_beside_jumps() -> None:
    """A cut that comes and goes within a sample: a third of a sample later, samples beside its edges differ by as much as a third of it."""
    draw, places = np.random.default_rng(4), np.arange(600)
    edges = np.where(places % 100 < 40, 3.0 - 0.02 * (places % 100), 0.0)
    edges[places % 100 == 70] = -1.5
    basis = differing(edges, places * 1.0)
    for gain, zero in ((0.02, -0.01), (-0.015, 0.03)):
        late = (np.interp(places - 0.33, places, edges) - edges) * 0.8
        row = gain * edges + zero + late + 0.005 * draw.normal(size=places.size)
        coefficients, calm = random_effects(basis, row, edges)
        assert coefficients[:2] == pytest.approx([gain, zero], abs=1.5e-3)
        assert 0.9 < np.mean(calm) < 0.98
        rest = without_jumps(row - basis @ coefficients, edges)
        assert np.std(rest) == pytest.approx(0.005, rel=0.15)


def test_repeats_that_begin_a_sample_apart_are_no_burst() -> None:
    """A cut into a blank: of two repeats one enters two samples later, and their difference jumps where only the other is predicted to."""
    draw, places = np.random.default_rng(6), np.arange(600)
    forces = [np.where(places < entry, 0.0, 80.0) for entry in (57, 59)]
    measured = [np.where(places < entry, 0.0, 80.0) + draw.normal(size=600) for entry in (58, 58)]
    trials = [
        Trial(f"{n}.csv", "c", {}, 0.004 * places, {"slip_velocity": np.full(600, 0.5)}, {"friction_force": each})
        for n, each in enumerate(measured)
    ]
    noise = estimate_noise(Prediction(MODEL, experiment(*trials, nominal=TRUTH)), np.concatenate(forces))
    assert noise.irregular["friction_force"].share < 0.05
    assert noise.sizes == pytest.approx(1.0, rel=0.15)


def standing(interval: float, rng: np.random.Generator, condition: str) -> tuple[list[Trial], FloatArray]:
    """Three repeats of a force that comes on at once and then stands still, and the force without its noise."""
    clean = np.where(np.arange(400) < 60, 0.0, 73.0)
    times = interval * np.arange(clean.size)
    own = {"slip_velocity": np.where(clean > 0, 0.5, 0.0)}
    trials = [
        Trial(f"{condition}-{n}.csv", condition, {}, times, own, {"friction_force": clean + 4.0 * rng.standard_normal(clean.size)})
        for n in range(3)
    ]
    return trials, np.tile(clean, 3)


@pytest.mark.parametrize("seed", range(4))
def test_a_force_that_stands_still_tells_no_clock(seed: int) -> None:
    """What noise makes of the few samples that tell is no spread of a clock, which a jump of the force would make of all noise there is.
    Nor does a trigger miss more samples of a fast recording than of a slow one."""
    rng = np.random.default_rng(seed)
    made = [standing(interval, rng, f"c{place}") for place, interval in enumerate([0.01, 0.002, 0.002, 0.0005])]
    prediction = Prediction(MODEL, experiment(*(each for trials, _ in made for each in trials), nominal=TRUTH))
    noise = estimate_noise(prediction, np.concatenate([clean for _, clean in made]))
    assert noise.sizes == pytest.approx(4.0, rel=0.1)
    assert noise.spread["friction_force"][2] == pytest.approx(CONSTANTS.prior_trial_clock, rel=0.01)


def test_a_clock_that_differs_by_samples_is_told_where_the_force_moves() -> None:
    late = 1.7 * np.array([1.0, -1.3, 0.4, -0.9, 1.2, -0.4])
    places = np.arange(TIMES.size)
    trials = [trial(TO_AND_FRO, seed=n, measured=np.interp(places - by, places, FORCE), noise=0.001) for n, by in enumerate(late)]
    noise = estimate_noise(Prediction(MODEL, experiment(*trials, nominal=TRUTH)), FORCE_REPEATED, prior=False)
    assert noise.spread["friction_force"][2] == pytest.approx(float(late.std(ddof=1)), rel=0.15)


def test_a_force_that_stands_still_tells_no_gain_from_a_zero() -> None:
    """The gain of one that changes by a billionth was 160 000 from repeat to repeat, its zero 20 MN."""
    luck, steady = np.random.default_rng(4), 100.0 * (1 + 1e-9 * np.sin(np.arange(1000.0)))
    trials = [trial(SLIDING, seed=place, measured=steady + luck.normal(size=1000) + 3.0 * luck.normal(), noise=0.0) for place in range(4)]
    noise = estimate_noise(Prediction(MODEL, experiment(*trials, nominal=TRUTH)), np.tile(steady, 4))
    gain, zero, _ = noise.spread["friction_force"]
    assert np.hypot(100.0 * gain, zero) < 6.0
    assert noise.sizes == pytest.approx(1.0, rel=0.1)


TURNING: dict[str, float | str] = {
    "kinematics": "internal", "F_C": 90.0, "F_S": 108.0, "v_s": 0.27, "sigma0": 9.3e6, "sigma1": 0.94, "sigma2": 2.0,
    "shear_stress": 4.46e8, "amplitude_x": 0.0, "amplitude_y": 0.0, "feed": 1e-4, "width": 2e-3,
}  # fmt: skip


def turned(seed: int) -> Experiment:
    """Three cuts without vibration, twice each: a force that stands still but for its first samples, with a white and a slow noise."""
    luck, times, trials = np.random.default_rng(seed), np.arange(1600) / 8000, list[Trial]()
    for speed in (0.25, 0.375, 0.5):
        values = {"cutting_speed": speed}
        still = MODEL.simulate(Run(times, {}, ("principal_force",)), (), {**TURNING, **values})["principal_force"]
        for k in range(2):
            slow = np.convolve(luck.normal(size=times.size + 399), np.full(400, 0.04), mode="valid")
            measured = still + 4 * luck.normal(size=times.size) + slow
            trials.append(Trial(f"{speed}-{k}.csv", f"{speed} m/s", values, times, {}, {"principal_force": measured}))
    signals = {"principal_force": Signal("principal_force", "F", "N", "output")}
    return Experiment(Path(), "turning", "", Nominal(TURNING, (), {}), signals, tuple(trials), None, "")


@pytest.mark.parametrize("seed", range(4))
def test_what_first_samples_alone_tell_apart_is_no_difference_of_gain_and_zero(seed: int) -> None:
    """Of 278 N a zero of up to 560 N between repeats was told, with a gain that took it back: the noise was then larger than the force,
    and no gap could be seen."""
    prediction = Prediction(MODEL, turned(seed))
    gain, zero, clock = estimate_noise(prediction, prediction.one()).spread["principal_force"]
    assert gain <= CONSTANTS.prior_trial_gain
    assert zero < 5.0
    assert clock <= CONSTANTS.prior_trial_clock


def test_ten_repeats_have_nine_differences() -> None:
    """They counted as five beside what is usual, which weighs as much as a few."""
    made = toy_measured(repeats=10, conditions=1, noise=1e-4)
    gains = np.random.default_rng(2).normal(size=10) * 3 * CONSTANTS.prior_trial_gain
    trials = tuple(replace(trial, outputs={"F": trial.outputs["F"] * (1 + gain)}) for trial, gain in zip(made.trials, gains, strict=True))
    prediction = Prediction(Toy(), replace(made, trials=trials))
    told = estimate_noise(prediction, prediction.one()).spread["F"][0]
    expected = (9 * gains.var(ddof=1) + CONSTANTS.prior_trials * CONSTANTS.prior_trial_gain**2) / (9 + CONSTANTS.prior_trials)
    assert told**2 == pytest.approx(expected, rel=0.02)
