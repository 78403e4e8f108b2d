"""Does an identification keep still where it cannot know? A true effect that is missing, gains that scatter, a bound in the way, a stop."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pytest
from evat.experiment import Experiment
from evat.identification import Execution, Identification, Settings, identify
from evat.identification.report.summary import headline
from known_rigs import MODEL, TO_AND_FRO, TRUTH, exact, experiment, force, trial

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


def test_a_bound_in_the_way_leaves_the_others_open() -> None:
    """sigma2 may be 30 at most and is 40: F_C then stands in for it, and is no statement."""
    narrow = fitted(rig(), bounds={"sigma2": (1.0, 30.0)})
    assert narrow["sigma2"].at_bound == "upper"
    assert narrow["F_C"].verdict == "withheld"
    assert abs(narrow["F_C"].value - 9.0) > 5 * fitted(rig())["F_C"].sd
    wide = fitted(rig(), bounds={"sigma2": (1.0, 300.0)})
    assert wide["F_C"].verdict == "identified"


def test_a_run_that_was_stopped_gives_no_verdict() -> None:
    """Stopped after the search, where the best point is there and nothing is known of its surroundings."""
    asked = itertools.count()
    answer = identify(rig(), MODEL, NAMES, Settings(search="none"), execution=Execution(cancelled=lambda: next(asked) > 1))
    assert answer.stopped
    assert {each.verdict for each in answer.estimates} == {"withheld"}
    assert headline(answer).status == "stopped"
