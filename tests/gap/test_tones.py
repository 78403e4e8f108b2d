"""Is a tone told that comes and goes with the speed, and no noise taken for one?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Trial
from evat.gap.tones import stretches, tones
from evat.inference.prediction import Prediction
from evat.model import FloatArray
from scipy.signal import lfilter
from toy import Toy, measured

TIMES = np.arange(2000) * 1e-3


def chirp(amplitude: float, seed: int) -> tuple[FloatArray, FloatArray]:
    """Speeds [m/s], and a tone whose frequency follows them, where they are above 20 mm/s, at a phase of its own."""
    speed = 0.15 * np.abs(np.sin(2 * np.pi * 1.5 * TIMES))
    phase = 2 * np.pi * np.cumsum(100 + 600 * speed) * 1e-3 + np.random.default_rng(seed).uniform(0, 2 * np.pi)
    return speed, amplitude * (speed > 0.02) * np.sin(phase)


def test_a_tone_is_told_where_it_is() -> None:
    speed, tone = chirp(0.3, 1)
    told = stretches(tone + 0.1 * np.random.default_rng(2).normal(size=TIMES.size), 1e-3)
    assert len(told) > 20
    assert all(100 < frequency < 210 for _, frequency, _ in told)
    assert np.median([amplitude for *_, amplitude in told]) == pytest.approx(0.3, rel=0.3)
    assert min(float(np.mean(speed[at])) for at, *_ in told) > 0.015


@pytest.mark.parametrize("memory", [0.0, 0.6, 0.95, -0.5])
def test_noise_does_not_sing(memory: float) -> None:
    draw = np.random.default_rng(3)
    rows = [stretches(lfilter([1.0], [1.0, -memory], draw.normal(size=2000)), 1e-3) for _ in range(60)]
    assert sum(map(bool, rows)) <= 2


@pytest.mark.parametrize("hertz", [62.5, 71.3, 203.4])
def test_a_tone_is_told_by_its_own_frequency_and_amplitude(hertz: float) -> None:
    draw = np.random.default_rng(5)
    told = stretches(np.sin(2 * np.pi * hertz * TIMES + 1.3) + 0.05 * draw.normal(size=TIMES.size), 1e-3)
    assert len(told) > 5
    assert [frequency for _, frequency, _ in told] == pytest.approx([hertz] * len(told), abs=1.0)
    assert [amplitude for *_, amplitude in told] == pytest.approx([1.0] * len(told), rel=0.1)


@pytest.mark.parametrize("hertz", [27.0, 40.0, 50.0])
def test_the_flank_of_a_slower_one_is_no_tone(hertz: float) -> None:
    """Too slow for a short stretch. Of a mains hum of 50 Hz the slowest frequency that is looked at was told: 62.5 Hz, and half of its
    amplitude."""
    draw = np.random.default_rng(5)
    told = stretches(np.sin(2 * np.pi * hertz * TIMES + 1.3) + 0.05 * draw.normal(size=TIMES.size), 1e-3)
    assert len(told) <= 2


def singing(trial: Trial, place: int, amplitude: float) -> Trial:
    tone = amplitude * np.sin(2 * np.pi * 27.0 * trial.times + place) * (np.abs(trial.inputs["x"]) > 0.2)
    return replace(trial, outputs={"F": trial.outputs["F"] + tone})


@pytest.mark.parametrize(("amplitude", "sings"), [(0.3, True), (0.0, False)])
def test_what_sings_is_told_in_a_sentence(amplitude: float, sings: bool) -> None:
    made = measured()
    sung = replace(made, trials=tuple(singing(trial, place, amplitude) for place, trial in enumerate(made.trials)))
    said = tones(Prediction(Toy(), sung))
    assert said == tones(Prediction(Toy(), sung).each_apart())
    assert bool(said) == sings
    if sings:
        assert said[0].startswith("F: unknown is a tone of 2")
        assert " N, in " in said[0]
