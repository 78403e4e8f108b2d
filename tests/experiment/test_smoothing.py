"""Does the velocity of a recorded position lead back to it, whatever counted it and wherever its scale begins?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.experiment.smoothing import derivative, noise_sd, position_noise, quantum
from evat.model import FloatArray

COUNT = 1e-6


def way(velocity: FloatArray, step: float) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum((velocity[1:] + velocity[:-1]) / 2 * step)])


@pytest.mark.parametrize("samples", [1, 5, 20, 100, 500, 5000])
def test_the_velocity_of_a_counted_ramp_leads_along_it(samples: int) -> None:
    """Of 200 samples a count half of the way was lost, of 500 six parts in seven, since a position between two counts seemed to rest."""
    ramp = np.arange(40 * samples) * COUNT / samples
    velocity = derivative(np.round(ramp / COUNT) * COUNT, 1e-3)
    assert way(velocity, 1e-3)[-1] == pytest.approx(ramp[-1], abs=COUNT)


@pytest.mark.parametrize(("rate", "frequency"), [(1e3, 1.0), (1e4, 1.0), (1e4, 0.1)])
def test_the_velocity_of_a_counted_stroke_leads_to_and_fro(rate: float, frequency: float) -> None:
    """A stroke of 10 um to either side, slow beside the counter's sampling, came out as one of 1.3 um, and a bristle six times as stiff."""
    times = np.arange(int(2 / frequency * rate)) / rate
    stroke = 10e-6 * np.sin(2 * np.pi * frequency * times)
    led = way(derivative(np.round(stroke / COUNT) * COUNT, 1 / rate), 1 / rate)
    assert np.max(np.abs(led - stroke)) < 1.5 * COUNT


def test_what_was_counted_rests_where_it_does() -> None:
    """A move of 2 mm at 20 samples a count, and at one sample a count; before and after it the velocity is 0."""
    for samples in (1, 20):
        move = np.clip(np.arange(-2000, 2000 * samples + 2000) / samples, 0, 2000) * COUNT
        velocity = derivative(np.round(move / COUNT) * COUNT, 1e-3)
        assert np.max(np.abs(velocity[:1700])) < 1e-12
        assert np.max(np.abs(velocity[-1700:])) < 1e-12
        assert velocity[2300:-2300] == pytest.approx(COUNT / samples / 1e-3, rel=0.02)


@pytest.mark.parametrize("offset", [0.1, 1.5, 40.0])
def test_noise_is_the_same_wherever_the_scale_begins(offset: float) -> None:
    """Of 0.2 um none was seen 1.5 m from the zero of a scale, and a velocity was 17 times as far off."""
    times = np.arange(4000) * 1e-3
    position = 2e-3 * np.sin(2 * np.pi * times) + 2e-7 * np.random.default_rng(1).normal(size=times.size)
    assert noise_sd(position) == pytest.approx(2e-7, rel=0.1)
    assert noise_sd(position + offset) == pytest.approx(noise_sd(position), rel=1e-3)
    assert derivative(position + offset, 1e-3) == pytest.approx(derivative(position, 1e-3), abs=1e-8)
    counted = np.round(position / COUNT) * COUNT
    assert quantum(counted + offset) == pytest.approx(quantum(counted), rel=1e-6)


def test_a_column_at_a_distance_has_no_noise_but_its_own() -> None:
    """Neither has one that stands still, nor one of which floating point alone moves the last digits."""
    assert noise_sd(np.full(100, 1.5)) == 0
    assert noise_sd(1e3 + np.sin(np.arange(400) / 50)) == 0
    assert quantum(np.full(100, 1.5)) == 0
    assert quantum(np.zeros(0)) == 0


@pytest.mark.parametrize("counts", [1, 4, 15])
def test_few_counts_are_counts(counts: int) -> None:
    """Fewer than 16 were taken for exact, and each for a motion of one sample: 80 times as fast as it was."""
    ramp = np.round(np.linspace(0, counts, 3000)) * COUNT
    assert position_noise(ramp) == pytest.approx(COUNT / np.sqrt(12))
    assert np.max(np.abs(derivative(ramp, 1e-3))) < 4 * max(counts * COUNT / 3, COUNT / 0.25)
    assert quantum(np.concatenate([[0.0, 0.3, 1.1], np.full(30, 1.5)])) == 0  # a start, and rest
