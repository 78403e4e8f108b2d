"""Does an identification keep still where it cannot know? A true effect that is missing, gains that scatter, a bound in the way, a stop."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import pytest
from evat.experiment import Experiment
from evat.identification import Execution, Identification, Settings, identify
from evat.identification.report.summary import headline
from known_rigs import MODEL, TO_AND_FRO, TRUTH, experiment, force, trial

NAMES = ("F_C", "sigma2")
SLIP = TO_AND_FRO[:500]
NEAR = {**TRUTH, "F_C": 8.0, "sigma2": 35.0}


def rig(on: Sequence[str] = (), gains: Sequence[float] = (1.0,), repeats: int = 1, noise: float = 0.002) -> Experiment:
    """A recording for each gain, each of another motion, so many times."""
    extra = {"direction_asymmetry.a": 0.1} if on else {}
    trials = []
    for place, gain in enumerate(gains):
        slip = (1 - 0.4 * place / len(gains)) * SLIP
        clean = gain * force(slip, {**TRUTH, **extra}, on)
        trials += [trial(slip, f"c{place}", noise=noise, seed=10 * place + k, measured=clean) for k in range(repeats)]
    return experiment(*trials, nominal=NEAR)


def fitted(made: Experiment, profiles: bool = False, **more: dict[str, tuple[float, float]]) -> Identification:
    return identify(made, MODEL, NAMES, Settings(search="none", profiles=profiles, **more))  # type: ignore[arg-type]


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
    """Gains that differ by half a per cent, each condition recorded once: the truth is inside, and far outside of what noise would give."""
    alike, apart = fitted(rig(gains=(1.0, 1.0)), profiles=True), fitted(rig(gains=(1.005, 0.995)), profiles=True)
    for name in NAMES:
        assert apart[name].low < float(TRUTH[name]) < apart[name].high
        assert abs(apart[name].value - float(TRUTH[name])) > 2 * alike[name].sd
        assert apart[name].high - apart[name].low > 5 * (alike[name].high - alike[name].low)


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
