"""Is what comes and goes by itself told from noise of every kind, and from single outliers?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from evat.gap import diagnose_with
from evat.gap.report.words import sentence
from evat.gap.search.compare import compare
from evat.gap.verdict.features import features
from evat.inference.hypothesis import Hypothesis
from evat.inference.noise.estimate import without_jumps
from evat.inference.noise.irregularity import Irregularity, bursts, irregular, lines, smoother_than_calm
from evat.inference.prediction import Prediction
from scipy.signal import lfilter
from toy import Toy, measured

COUNT = 3000
FORCE = 10.0 * np.sin(2 * np.pi * 6.0 * np.arange(COUNT) / COUNT)


def noise(seed: int, memory: float = 0.5, tails: float = 0.0, count: int = COUNT) -> np.ndarray:
    luck = np.random.default_rng(seed)
    drawn = luck.standard_t(tails, count) if tails else luck.normal(size=count)
    return np.asarray(lfilter([1.0], [1.0, -memory], drawn))


def of(row: np.ndarray) -> Irregularity:
    return irregular([row], [1e-3], [np.resize(FORCE, row.size)])


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.95])
@pytest.mark.parametrize("tails", [0.0, 3.0])
def test_noise_is_regular(memory: float, tails: float) -> None:
    """Heavy tails make some; a long memory, in which an outlier lasts, no more."""
    shares = [of(noise(seed, memory, tails)).share for seed in range(20)]
    assert max(shares) < 0.2
    assert np.median(shares) < 0.1


def test_a_shock_to_noise_that_goes_on_is_no_burst() -> None:
    """In short recordings one of some dozens is large: as its tail, it was three fifths of all that repeats do not share."""
    assert max(of(noise(seed, 0.8, 3.0, 1000)).bursts for seed in range(40)) < 0.1


def test_outliers_are_no_bursts() -> None:
    row = noise(1)
    row[::50] += 30.0
    assert np.mean(bursts(row)) < 0.002


@pytest.mark.parametrize("width", [5, 12, 40])
def test_sawteeth_are_bursts(width: int) -> None:
    row = noise(2)
    places = np.random.default_rng(3).choice(np.arange(0, COUNT - 50, 60), 12, replace=False)
    for place in places:
        row[place : place + width] += np.linspace(8, 24, width)
    irregularity = of(row)
    tooth = 12 * float(np.sum(np.linspace(8, 24, width) ** 2)) / float(row @ row)
    assert irregularity.bursts == pytest.approx(tooth, abs=0.15)
    assert irregularity.lines < 0.05


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_sawteeth_that_fill_recordings_are_no_noise(memory: float) -> None:
    """What is smoother than the noise between two teeth: four fifths of all, where bursts, lines and wander had none of it."""
    rows = [noise(seed, memory) + sawtooth(seed) for seed in range(3)]
    irregularity = irregular(rows, [1e-3] * 3, [FORCE] * 3)
    assert irregularity.smooth > 0.4
    assert irregularity.share > 0.6
    assert "smoother than the noise" in str(irregularity)


@pytest.mark.parametrize("memory", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("tails", [0.0, 3.0])
def test_noise_is_no_smoother_than_where_it_is_calm(memory: float, tails: float) -> None:
    shares = [
        irregular([noise(3 * seed + k, memory, tails, 800) for k in range(3)], [1e-3] * 3, [FORCE[:800]] * 3).smooth for seed in range(30)
    ]
    assert max(shares) < 0.2
    assert np.median(shares) < 0.02


@pytest.mark.parametrize("slow", [0.2, 0.4, 0.6])
def test_a_slow_noise_beside_a_white_one_is_noise(slow: float) -> None:
    """As amplifiers have: in windows as short as tell the white part nothing is seen of it, and it was as much of "what comes and goes by
    itself" as it is of the noise."""

    def drawn(seed: int) -> np.ndarray:
        wander = noise(2 * seed, 0.97) * np.sqrt(1 - 0.97**2)
        return np.asarray(np.sqrt(1 - slow) * noise(2 * seed + 1, 0.0) + np.sqrt(slow) * wander)

    shares = [irregular([drawn(6 * seed + k) for k in range(6)], [1e-3] * 6, [FORCE] * 6).smooth for seed in range(15)]
    assert max(shares) < 0.1


def test_repeats_out_of_step_differ_where_the_force_jumps() -> None:
    """By half a sample at ten reversals: their few changes are large beside those of a slow noise, which then was none, and a rig where
    nothing acts but half a sample of delay had "something unknown" with a probability of 0.95."""
    reversing = 10.0 * np.tanh(3.0 * np.sin(2 * np.pi * 10.0 * np.arange(COUNT) / COUNT) / 0.2)
    jumps = np.convolve(np.gradient(reversing), np.full(4, 0.25), mode="same")

    def drawn(seed: int) -> np.ndarray:
        slow = noise(2 * seed, 0.97) * np.sqrt(1 - 0.97**2)
        return np.asarray(0.7 * noise(2 * seed + 1, 0.0) + 0.7 * slow + 1.2 * (-1) ** seed * jumps)

    shares = [irregular([drawn(4 * seed + k) for k in range(4)], [1e-3] * 4, [reversing] * 4).smooth for seed in range(15)]
    assert max(shares) < 0.1


def test_a_recording_with_next_to_no_samples_tells_nothing_of_what_is_smooth() -> None:
    """Of one that a burst fills nothing is left: its noise was no number."""
    force = [FORCE, np.zeros(0), FORCE[:2]]
    assert smoother_than_calm([noise(1), np.zeros(0), noise(2, count=2)], force) == smoother_than_calm([noise(1)], [FORCE])


def test_a_hum_is_a_line_at_its_frequency() -> None:
    row = noise(4) + 1.5 * np.sin(2 * np.pi * 50.0 * np.arange(COUNT) * 1e-3 + 1.0)
    irregularity = of(row)
    assert irregularity.frequency == pytest.approx(50.0, abs=0.5)
    assert 0.2 < irregularity.lines < 0.9
    assert irregularity.bursts < 0.05


def test_a_resonance_of_the_noise_is_no_line() -> None:
    pole = 0.9 * np.exp(2j * np.pi * 0.1)
    row = lfilter([1.0], np.real(np.poly([pole, pole.conjugate()])), np.random.default_rng(5).normal(size=COUNT))
    assert lines(np.asarray(row))[0] < 0.05


def test_a_clock_that_differs_is_no_line() -> None:
    """A force that jumps in every cycle, recorded a tenth of a sample later: what differs comes back with the cycle and is no hum."""
    force = 100.0 * (np.arange(COUNT) % 60 < 25)
    row = noise(6) + 0.2 * np.gradient(force)
    assert of(row).share > 0.3
    assert of(without_jumps(row, force)).share < 0.05
    hum = 1.5 * np.sin(2 * np.pi * 50.0 * np.arange(COUNT) * 1e-3)
    assert of(without_jumps(row + hum, force)).frequency == pytest.approx(50.0, abs=0.5)


def _steps(row: np.ndarray, size: float) -> np.ndarray:
    return row + size * (np.arange(row.size) > 0.6 * row.size)


def _teeth(row: np.ndarray, size: float) -> np.ndarray:
    return row + size * np.sign(FORCE) * (np.arange(row.size) / row.size * 5.3 % 1.0 - 0.5)


def _starved(row: np.ndarray, size: float) -> np.ndarray:
    knots = np.cumsum(np.random.default_rng(9).normal(size=16))
    return row + size * np.sign(FORCE) * np.interp(np.arange(row.size), np.linspace(0, row.size, 16), knots - knots.mean())


@pytest.mark.parametrize("strays", [_steps, _teeth, _starved], ids=["a level that jumps", "layers that tear off", "starved"])
def test_a_level_that_strays_is_wander(strays: Callable[[np.ndarray, float], np.ndarray]) -> None:
    """As the force itself or against the motion; what it holds of the square, and nothing where it is too small to matter."""
    row = strays(noise(7), 4.0)
    more = 1 - float(noise(7) @ noise(7)) / float((row - row.mean()) @ (row - row.mean()))
    assert 0.5 * more < of(row - row.mean()).wander < more + 0.1
    assert of(strays(noise(7), 0.02)).wander == 0.0


@pytest.mark.parametrize(("memory", "count"), [(0.0, 400), (0.8, 400), (0.95, 400), (0.95, 1000), (0.99, 1000), (0.99, 3000)])
def test_noise_that_remembers_is_no_wander(memory: float, count: int) -> None:
    """Also where the three recordings last for ten times its memory only: slow periods hold most of it."""
    force, drawn = 10 * np.sin(2 * np.pi * 6 * np.arange(count) / count), (noise(seed, memory, count=count) for seed in range(60))
    shares = [irregular(rows, [1e-3] * 3, [force] * 3).wander for rows in zip(drawn, drawn, drawn, strict=True)]
    assert np.mean(np.array(shares) > 0) <= 0.1


def test_a_drift_is_no_wander() -> None:
    """Of the zero, or of the gain; as large as the jump above."""
    assert of(noise(8) + np.linspace(-4, 4, COUNT)).wander == 0.0
    assert of(noise(8) + np.linspace(-0.4, 0.4, COUNT) * FORCE).wander == 0.0


def test_identical_repeats_have_nothing_irregular() -> None:
    assert of(np.zeros(COUNT)).share == 0.0
    assert irregular([], [], []).share == 0.0


def test_lines_that_the_likeliest_model_has_are_none() -> None:
    """A sensor that is struck at slightly different moments rings: repeats do not share it, and what has it explains it."""
    made = measured(repeats=3, noise=0.02)
    ringing = [np.sin(2 * np.pi * 11.0 * trial.times + 2.0 * place) for place, trial in enumerate(made.trials)]
    trials = [replace(t, outputs={"F": t.outputs["F"] + 0.3 * ring}) for t, ring in zip(made.trials, ringing, strict=True)]
    comparison = compare(Prediction(Toy(), replace(made, trials=tuple(trials))))
    assert features(comparison).irregular_share["F"] > 0.9
    has_it = replace(comparison.recalibrated, predicted=comparison.recalibrated.predicted + 0.3 * np.concatenate(ringing))
    with_it = replace(comparison, models={Hypothesis(("lean",)): has_it})
    assert features(with_it).irregular_share["F"] < 0.1


@pytest.mark.parametrize(("hum", "together"), [(0.0, 3), (0.3, 1)])
def test_repeats_are_one_motion_unless_lines_go_through_them(hum: float, together: int) -> None:
    """What no model has in step would be taken from their mean as if it were noise."""
    made, draw = measured(repeats=3, noise=0.02), np.random.default_rng(4)
    trials = [replace(t, outputs={"F": t.outputs["F"] + hum * np.sin(2 * np.pi * (11.0 * t.times + draw.uniform()))}) for t in made.trials]
    groups = compare(Prediction(Toy(), replace(made, trials=tuple(trials)))).whitening.groups
    assert {len(group.members) for group in groups} == {together}


def test_a_level_that_jumps_from_repeat_to_repeat_is_told() -> None:
    """Also a jump that is larger than the force itself, of which fits of gain and clock leave something."""
    made = measured(repeats=3, noise=0.02)
    jumps = [6.0 * (-1) ** place * (trial.times > (0.2 + 0.05 * place) * trial.times[-1]) for place, trial in enumerate(made.trials)]
    trials = [replace(t, outputs={"F": t.outputs["F"] + jump}) for t, jump in zip(made.trials, jumps, strict=True)]
    answer, _ = diagnose_with(replace(made, trials=tuple(trials)), Toy())
    assert answer.verdict == "unknown"
    assert sentence(answer).startswith(
        "Something comes and goes by itself that none of the known effects does: in the F a level that jumps"
    )
    calm, _ = diagnose_with(measured(repeats=3, noise=0.02), Toy())
    assert not calm.foreign


def sawtooth(seed: int, count: int = COUNT) -> np.ndarray:
    """An edge that builds up and breaks off, again and again, after as long as luck has it: it fills the recording."""
    luck, row = np.random.default_rng(seed), np.empty(0)
    while row.size < count:
        row = np.concatenate([row, np.linspace(0.0, 8.0, int(luck.uniform(30, 90)))])
    return row[:count] - 4.0


def in_conditions(rows: list[np.ndarray]) -> Irregularity:
    return irregular(rows, [1e-3] * len(rows), [FORCE] * len(rows), ["slow", "slow", "fast", "fast"])


@pytest.mark.parametrize("seed", range(4))
def test_what_fills_the_recordings_of_some_conditions_is_told_by_the_others(seed: int) -> None:
    quiet = [noise(10 * seed + n, 0.1) for n in range(4)]
    told = in_conditions([quiet[0] + sawtooth(seed), quiet[1] + sawtooth(90 + seed), *quiet[2:]])
    assert told.of_some_conditions == pytest.approx(0.75, abs=0.1)
    assert "what some conditions alone have" in str(told)
    assert irregular([quiet[0] + sawtooth(seed)], [1e-3], [FORCE], ["slow"]).of_some_conditions == 0.0  # no other tells


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_noise_that_is_larger_in_some_conditions_is_noise(seed: int, memory: float) -> None:
    """As where it grows with the force: of another size, and of the same spectrum. Or a little smoother, and hardly larger."""
    rows = [noise(10 * seed + n, memory) for n in range(4)]
    assert in_conditions([5.0 * rows[0], 4.0 * rows[1], *rows[2:]]).of_some_conditions == 0.0
    smoother = [noise(10 * seed + n, 0.5) for n in range(4)]
    assert in_conditions([*smoother[:2], *(noise(70 + n, 0.0) for n in range(2))]).of_some_conditions == 0.0
