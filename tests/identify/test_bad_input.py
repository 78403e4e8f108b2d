"""What would give a silent nonsense fit: is it refused with a clear error, or called what it is?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat.commands.experiment import check
from evat.experiment import ExperimentError, Trial
from evat.experiment.write import write_experiment
from evat.gap import diagnose
from evat.identification import Settings, identify
from evat.model import ParameterError
from known_rigs import FREE, GUESS, MODEL, TIMES, TO_AND_FRO, TRUTH, experiment, force, trial

GOOD = trial(TO_AND_FRO)


def test_a_force_of_zero() -> None:
    nothing = replace(GOOD, outputs={"friction_force": np.zeros(TIMES.size)})
    with pytest.raises(ExperimentError, match="friction_force is zero in every sample"):
        identify(experiment(nothing), MODEL, FREE)


def test_a_sign_that_is_turned() -> None:
    turned = replace(GOOD, outputs={"friction_force": -GOOD.outputs["friction_force"]})
    with pytest.raises(ExperimentError, match=r"measured runs against calculated .*reverse the sign"):
        identify(experiment(turned), MODEL, FREE)


CROWDED = np.concatenate(([0, 5e-324, 1e-323, 2e-323], TIMES[4:]))


@pytest.mark.parametrize("ask", ["identify", "diagnose", "check"])
@pytest.mark.parametrize(
    ("times", "match"),
    [
        (TIMES + np.where(np.arange(TIMES.size) > 600, 3.0, 0.0), r"the clock jumps by 3.002 s after sample 601 .*cut the file there"),
        (CROWDED, r"samples 1 and 2 are 4.941e-324 s apart, the usual step of the clock is 0.002 s: no clock tells them apart"),
        (TIMES[:2], r"it has 2 rows; a recording has at least 3\."),
    ],
    ids=["jumps", "crowded", "two rows"],
)
def test_a_clock_that_tells_no_times(ask: str, times: np.ndarray, match: str, tmp_path: Path) -> None:
    """One answer, whoever is asked."""
    columns = {name: {key: column[: times.size] for key, column in getattr(GOOD, name).items()} for name in ("inputs", "outputs")}
    told = experiment(replace(GOOD, times=times, **columns))
    asks: dict[str, Callable[[], object]] = {
        "identify": lambda: identify(told, MODEL, FREE),
        "diagnose": lambda: diagnose(told, MODEL),
        "check": lambda: check(write_experiment(told, tmp_path / "rig")),
    }
    with pytest.raises(ExperimentError, match=rf"c0-1.csv: {match}"):
        asks[ask]()


def test_a_parameter_that_the_law_has_not() -> None:
    with pytest.raises(ParameterError, match=r"free parameter sigma0: nothing that was measured depends on it.*friction law coulomb"):
        identify(experiment(GOOD, nominal={**GUESS, "friction_law": "coulomb"}), MODEL, ["F_C", "sigma0"])


@pytest.mark.parametrize(
    ("free", "named", "message"),
    [
        (["F_Q"], {}, "no such variable"),
        ([], {}, "no free parameter was named"),
        (["friction_law"], {}, "is a choice parameter"),
        (["friction_force"], {}, "is a real output"),
        (["direction_asymmetry.a"], {}, "belongs to the effect direction_asymmetry, which is off"),
        (["F_C"], {"on": ("friction_of_the_third_kind",)}, "there is no effect 'friction_of_the_third_kind'"),
        (["F_C"], {"bounds": {"F_C": (3.0, 2.0)}}, "the first must be below the second"),
        (["F_C"], {"bounds": {"F_C": (-3.0, 2.0)}}, "the model allows"),
        (["F_C"], {"bounds": {"F_S": (1.0, 2.0)}}, "F_S, not free here"),
        (["F_C"], {"values": {"F_C": 2.0}}, "held at a value and free at once"),
        (["F_C"], {"objective": "most_squares"}, "allowed are least_squares, huber, relative"),
        (["F_C"], {"search": "luck"}, "allowed are ga, de, none"),
        (["F_C"], {"population": 2}, "a population of 5 to 100000"),
        (["F_C"], {"population": 10**12}, "a population of 5 to 100000"),
        (["F_C"], {"seed": -1}, "seed -1: allowed are .* a seed of 0 or more"),
        (["F_C"], {"hold_out": ("c0",)}, "all conditions are held out"),
        (["F_C"], {"hold_out": ("c7",)}, "asked for conditions 'c7'"),
        (
            ["direction_asymmetry.a"],
            {"on": ("direction_asymmetry",)},
            r"direction_asymmetry\.a: it is 0\.1 where nobody says, and for a value that is of either sign .* allows -0\.9 to 0\.9\. ",
        ),
    ],
)
def test_a_question_that_makes_no_sense(free: list[str], named: dict[str, object], message: str) -> None:
    with pytest.raises((ParameterError, ExperimentError), match=message):
        identify(experiment(GOOD), MODEL, free, Settings(**named))  # type: ignore[arg-type]


def test_a_parameter_that_the_experiment_states() -> None:
    with pytest.raises(ParameterError, match="the experiment states this for its trials"):
        identify(experiment(replace(GOOD, values={"F_C": 9.0})), MODEL, ["F_C"])


def test_one_speed_only() -> None:
    """One number was measured, many times: no two parameters can be told from it, and none is called identified but by the start."""
    slip = np.full(TIMES.size, 0.1)
    slip[0] = 0.0
    still = trial(slip, values={**TRUTH, "sigma0": 1e7, "sigma1": 20.0})
    identification = identify(
        experiment(still, nominal={**TRUTH, "sigma0": 1e7, "sigma1": 20.0}), MODEL, ["F_C", "sigma2"], Settings(seed=1)
    )
    assert {estimate.verdict for estimate in identification.estimates} <= {"weak", "not identifiable"}
    assert abs(identification.correlation[0, 1]) > 0.99
    assert "there is one speed only" in identification["sigma2"].why


@pytest.mark.parametrize("column", ["force", "motion"])
def test_a_column_in_the_wrong_unit(column: str) -> None:
    """N taken for mN, or m/s for mm/s: a doubt that says so, or estimates on their bounds; never six identified parameters."""
    if column == "force":
        wrong = replace(GOOD, outputs={"friction_force": 1e3 * GOOD.outputs["friction_force"]})
    else:
        wrong = replace(GOOD, inputs={"slip_velocity": 1e3 * GOOD.inputs["slip_velocity"]})
    identification = identify(experiment(wrong), MODEL, FREE, Settings(seed=1, generations=40))
    assert identification.doubts
    assert any(estimate.verdict != "identified" for estimate in identification.estimates)
    if column == "force":
        assert "Is the column in the unit that the experiment says?" in identification.doubts[0]
        assert any("bound" in estimate.why for estimate in identification.estimates)


def test_a_force_that_has_nothing_to_do_with_the_motion() -> None:
    noise = replace(GOOD, outputs={"friction_force": np.random.default_rng(3).standard_normal(TIMES.size)})
    identification = identify(experiment(noise), MODEL, FREE, Settings(seed=1, generations=30))
    assert any("These parameters say nothing" in doubt for doubt in identification.doubts)


def test_a_recording_of_two_samples() -> None:
    short = Trial("s.csv", "c0", {}, TIMES[:2], {"slip_velocity": TO_AND_FRO[:2]}, {"friction_force": force(TO_AND_FRO[:2])})
    with pytest.raises(ExperimentError, match=r"s.csv: it has 2 rows; a recording has at least 3"):
        identify(experiment(short), MODEL, ["F_C"])
