"""Does an identification keep still where it cannot know? A true effect that is missing, gains that scatter, a bound in the way, a stop."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from evat.experiment import Experiment
from evat.identification import Execution, Identification, Settings, identify
from evat.identification.report.summary import headline
from known_rigs import MODEL, TO_AND_FRO, TRUTH, exact, experiment, force, trial
from scipy.signal import lfilter

NAMES = ("F_C", "sigma2")
SLIP = TO_AND_FRO[:500]
NEAR = {**TRUTH, "F_C": 8.0, "sigma2": 35.0}


def rig(on: Sequence[str] = (), repeats: int = 1) -> Experiment:
    """One motion, recorded so many times."""
    extra = {"direction_asymmetry.a": 0.1} if on else {}
    clean = force(SLIP, {**TRUTH, **extra}, on)
    return exact(experiment(*(trial(SLIP, noise=0.002, seed=seed, measured=clean) for seed in range(repeats)), nominal=NEAR))


def fitted(made: Experiment, **more: dict[str, tuple[float, float]]) -> Identification:
    return identify(made, MODEL, NAMES, Settings(search="none", profiles=False, **more))  # type: ignore[arg-type]


@pytest.mark.parametrize("repeats", [1, 2])
def test_a_model_that_lacks_the_true_effect_tells_no_value(repeats: int) -> None:
    """However narrow the interval, and with or without repeats that show the noise; with the effect on both values come back."""
    made = rig(("direction_asymmetry",), repeats=repeats)
    answer = fitted(made)
    assert [each.verdict for each in answer.estimates] == ["withheld", "withheld"]
    assert all("of the rms of friction force" in each.why for each in answer.estimates)
    said = headline(answer)
    assert (said.status, said.tone) == ("withheld", "bad")
    assert ("evat diagnose" if repeats == 2 else "second time") in said.next
    settings = Settings(on=("direction_asymmetry",), bounds={"direction_asymmetry.a": (0.01, 0.5)}, search="none", profiles=False)
    whole = identify(made, MODEL, [*NAMES, "direction_asymmetry.a"], settings)
    assert {each.verdict for each in whole.estimates} == {"identified"}
    assert headline(whole).status == "identified"


def test_recordings_that_scatter_widen_the_intervals() -> None:
    """Gains that differ by about half a per cent, each condition recorded once: no curve is left, and by noise alone F_C would be
    8.977 to 8.990 N and sigma2 38.75 to 39.13 N.s/m, beside the truths 9 and 40."""
    trials = []
    for place, size in enumerate((1.0, 0.6)):
        gain = 1 + 0.005 * np.random.default_rng(100 + place).standard_normal()
        clean = gain * force(size * TO_AND_FRO)
        trials.append(trial(size * TO_AND_FRO, f"c{place}", noise=0.002, seed=place + 1, measured=clean))
    made = exact(experiment(*trials, nominal={**TRUTH, "F_C": 8.0, "F_S": 10.0, "v_s": 1.3e-2, "sigma2": 30.0}))
    answer = identify(made, MODEL, ("F_C", "F_S", "v_s", "sigma2"), Settings(search="none", seed=1))
    assert answer.fits["friction_force"].follows_itself < 0.3
    for name in NAMES:
        assert answer[name].low < float(TRUTH[name]) < answer[name].high


def strokes(exponent: float, slow_noise: float = 0.0) -> Experiment:
    """Two repeats of slow and fast strokes of a contact whose Stribeck curve has that exponent; nominal values are a little off."""
    trials, size = [], 0.006 * np.sqrt(np.mean(force(TO_AND_FRO) ** 2))
    for place, share in enumerate((1.0, 0.2)):
        clean = force(share * TO_AND_FRO, {**TRUTH, "lugre.stribeck_exponent": exponent, "sigma1": 30.0})
        for repeat in range(2):
            draws = np.random.default_rng(10 * place + repeat).standard_normal(clean.size)
            noise = lfilter([np.sqrt(1 - slow_noise**2)], [1.0, -slow_noise], draws)
            trials.append(trial(share * TO_AND_FRO, f"c{place}", noise=0.0, seed=repeat, measured=clean + size * noise))
    return exact(experiment(*trials, nominal={**TRUTH, "sigma1": 30.0, "F_C": 8.7, "F_S": 11.5, "v_s": 1.1e-2}))


@pytest.mark.parametrize("exponent", [1.0, 3.5])
def test_a_misfit_that_many_samples_show_widens_however_small_it_is(exponent: float) -> None:
    """Stribeck's curve has another exponent than the textbook's: the residual is a fifth more than the noise of the repeats, F_S is
    more than ten standard errors off; nothing was said of it, and no interval held the truth."""
    answer = identify(strokes(exponent), MODEL, ("F_C", "F_S", "v_s", "sigma2"), Settings(search="none"))
    fit = answer.fits["friction_force"]
    assert 1.02 < fit.rms / fit.noise < 1.5
    assert fit.beyond_noise > 5
    assert "times the noise that the repeats show" in answer.doubts[0]
    assert "lugre.stribeck_exponent (a shape of the law, held as in textbooks) in " in answer.doubts[1]
    for estimate in answer.estimates:
        assert estimate.low < float(TRUTH[estimate.name]) < estimate.high
    plain = identify(strokes(2.0), MODEL, ("F_C", "F_S", "v_s", "sigma2"), Settings(search="none", profiles=False))
    assert abs(answer["F_S"].value - 11.0) > 10 * plain["F_S"].sd


@pytest.mark.parametrize("slow_noise", [0.0, 0.9])
def test_noise_is_no_misfit(slow_noise: float) -> None:
    """White noise and noise that goes on over ten samples: of the right law nothing is said."""
    answer = identify(strokes(2.0, slow_noise), MODEL, ("F_C", "F_S", "v_s", "sigma2"), Settings(search="none", profiles=False))
    assert abs(answer.fits["friction_force"].beyond_noise) < 3
    assert not any("misses" in doubt for doubt in answer.doubts)


def test_what_an_unknown_start_leaves_is_no_misfit() -> None:
    """Recordings that begin while the contact slides: the model begins with straight bristles, which no value is to blame for. The residual
    counted as four times the noise, and every value was withheld, within a per cent of the truth."""
    whole = strokes(2.0)
    parts = tuple(each.between(150 + begin, 550 + begin) for begin in (0, 400) for each in whole.trials)
    named = (replace(each, file=f"{place}-{each.file}", condition=f"{each.condition}{place // 4}") for place, each in enumerate(parts))
    answer = identify(replace(whole, trials=tuple(named)), MODEL, ("F_C", "F_S", "v_s", "sigma2"), Settings(search="none", profiles=False))
    fit = answer.fits["friction_force"]
    assert fit.rms == pytest.approx(fit.noise, rel=0.05)
    assert {each.verdict for each in answer.estimates} == {"identified"}
    assert not any("misses" in doubt for doubt in answer.doubts)
    assert any("began with bent bristles" in doubt for doubt in answer.doubts)


def test_a_bound_in_the_way_leaves_the_others_open() -> None:
    """sigma2 may be 30 at most and is 40: F_C then stands in for it, and is no statement."""
    narrow = fitted(rig(), bounds={"sigma2": (1.0, 30.0)})
    assert narrow["sigma2"].at_bound == "upper"
    assert narrow["F_C"].verdict == "withheld"
    assert abs(narrow["F_C"].value - 9.0) > 5 * fitted(rig())["F_C"].sd
    wide = fitted(rig(), bounds={"sigma2": (1.0, 300.0)})
    assert wide["F_C"].verdict == "identified"


def test_bounds_may_be_as_far_apart_as_one_likes() -> None:
    """Steps of the slopes, and the most that counted of them, went by how far: within 1e4 N to either side of an offset its standard error
    was 24 times as large as within 10 N, and sigma2 lay on a bound that is a hundred standard errors away."""
    made, offset = rig(), "sensor_offset.friction_force"
    names = [*NAMES, offset]

    def answer(offset_within: float, most: float) -> Identification:
        bounds = {offset: (-offset_within, offset_within), "sigma2": (0.0, most)}
        return identify(made, MODEL, names, Settings(on=("sensor_offset",), bounds=bounds, search="none", profiles=False))

    narrow, wide = answer(10.0, 1e3), answer(1e5, 1e6)
    for name in names:
        assert wide[name].value == pytest.approx(narrow[name].value, abs=0.01 * narrow[name].sd)
        assert wide[name].sd == pytest.approx(narrow[name].sd, rel=0.01)
        assert wide[name].at_bound == ""


def test_a_run_that_was_stopped_gives_no_verdict() -> None:
    """Stopped after the search, where the best point is there and nothing is known of its surroundings."""
    asked = itertools.count()
    answer = identify(rig(), MODEL, NAMES, Settings(search="none"), execution=Execution(cancelled=lambda: next(asked) > 1))
    assert answer.stopped
    assert {each.verdict for each in answer.estimates} == {"withheld"}
    assert headline(answer).status == "stopped"
