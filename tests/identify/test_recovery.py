"""Does the truth come back, by every search, within the interval that is given, and is what cannot come back called so?"""

from __future__ import annotations

import numpy as np
import pytest
from evat.identification import Identification, Settings, identify
from evat.model import ParameterError
from known_rigs import FREE, GUESS, MODEL, SLIDING, STEP, TIMES, TO_AND_FRO, TRUTH, exact, experiment, force, trial


@pytest.fixture(scope="module")
def by_search() -> dict[str, Identification]:
    rig = exact(experiment(trial(TO_AND_FRO)))
    return {kind: identify(rig, MODEL, FREE, Settings(search=kind, seed=5, profiles=kind == "ga")) for kind in ("ga", "de")}  # type: ignore[arg-type]


def test_ga_and_de_end_on_one_optimum(by_search: dict[str, Identification]) -> None:
    """To a hundredth of the standard error, from another valley's side: the nominal values alone lead elsewhere."""
    ga, de = by_search["ga"], by_search["de"]
    for name in FREE:
        assert abs(ga[name].value - de[name].value) < 0.01 * ga[name].sd
    assert ga.cost == pytest.approx(de.cost, rel=1e-8)
    alone = identify(experiment(trial(TO_AND_FRO)), MODEL, FREE, Settings(search="none", profiles=False))
    assert alone.cost > 1.5 * ga.cost


def test_the_truth_lies_within_some_standard_errors(by_search: dict[str, Identification]) -> None:
    """Six estimates: one beyond 4 sd happens once in 2500 such tests. The residual is the noise, and white."""
    for estimate in by_search["ga"].estimates:
        assert abs(estimate.value - float(TRUTH[estimate.name])) < 4 * estimate.sd
        assert estimate.verdict == "identified"
        assert estimate.low < estimate.value < estimate.high
    fit = by_search["ga"].fits["friction_force"]
    assert fit.share == pytest.approx(0.01, rel=0.1)
    assert abs(fit.follows_itself) < 4 / np.sqrt(TIMES.size)
    assert by_search["ga"].doubts == ()


def test_intervals_are_those_of_a_parabola_where_the_misfit_is_one(by_search: dict[str, Identification]) -> None:
    """With little noise the profile is a parabola, and the 90 % interval 1.645 standard errors wide to each side."""
    for estimate in by_search["ga"].estimates:
        for end in (estimate.low, estimate.high):
            assert abs(end - estimate.value) == pytest.approx(1.645 * estimate.sd, rel=0.15)


def test_standard_errors_are_the_spread_over_repetitions() -> None:
    """Twenty repetitions of the same test: their spread is within a factor of the standard error that each states (99.9 %)."""
    identifications = [
        identify(
            exact(experiment(trial(TO_AND_FRO, seed=seed), nominal=TRUTH)),
            MODEL,
            ["F_C", "sigma0"],
            Settings(search="none", profiles=False),
        )
        for seed in range(20)
    ]
    for name in ("F_C", "sigma0"):
        spread, stated = np.std([one[name].value for one in identifications], ddof=1), np.mean([one[name].sd for one in identifications])
        assert 0.5 < spread / stated < 1.6


def test_huber_and_eq_9_do_not_follow_outliers() -> None:
    """Five per cent of the samples, off by ten times the noise's rms and more: least squares moves by several of the others' errors."""
    clean, rng = force(TO_AND_FRO), np.random.default_rng(2)
    hit = rng.random(clean.size) < 0.05
    rig = experiment(trial(TO_AND_FRO, measured=clean + np.where(hit, 5.0, 0.0)), nominal=TRUTH)
    off = {}
    for kind in ("least_squares", "huber", "relative"):
        identification = identify(rig, MODEL, ["F_C", "sigma0"], Settings(search="none", objective=kind, whiten=False))  # type: ignore[arg-type]
        off[kind] = abs(identification["F_C"].value - 9.0) / 9.0
        if kind != "least_squares":
            assert identification["F_C"].low < 9.0 * 1.01
            assert abs(identification["F_C"].value - 9.0) < 4 * identification["F_C"].sd + 0.02
    assert off["huber"] < 0.3 * off["least_squares"]
    assert off["relative"] < 0.3 * off["least_squares"]


def test_slow_noise_widens_the_intervals() -> None:
    """An autoregression of 0.9: least squares on its own samples would be far too certain; whitened or not, the truth is covered."""
    rng, clean = np.random.default_rng(4), force(TO_AND_FRO)
    slow = np.zeros(clean.size)
    for place in range(1, slow.size):
        slow[place] = 0.9 * slow[place - 1] + 0.1 * rng.standard_normal()
    rig = exact(experiment(trial(TO_AND_FRO, noise=0.0, measured=clean + slow), nominal=TRUTH))
    white = exact(experiment(trial(TO_AND_FRO, noise=0.0, measured=clean + np.std(slow) * rng.standard_normal(clean.size)), nominal=TRUTH))
    names = ["F_C", "sigma2"]
    whitened, plain, of_white = (
        identify(one, MODEL, names, Settings(search="none", whiten=whiten)) for one, whiten in ((rig, True), (rig, False), (white, True))
    )
    for identification in (whitened, plain):
        for name in names:
            assert abs(identification[name].value - float(TRUTH[name])) < 4 * identification[name].sd
    assert plain["F_C"].sd > 2 * of_white["F_C"].sd
    assert whitened["F_C"].sd < 1.1 * plain["F_C"].sd
    assert whitened.doubts
    assert "correlated" in whitened.doubts[0]


def test_sliding_one_way_does_not_tell_the_bristles() -> None:
    """Never a reversal, and stiff bristles that have settled by the second sample: sigma0 and sigma1 cancel. Presliding brings them back,
    which the advice says and a second experiment shows."""
    stiff: dict[str, float | str] = {**TRUTH, "sigma0": 1e7, "sigma1": 20.0, "F_S": 9.0}
    slip = SLIDING.copy()
    slip[0] = 0.0
    free, bounds = ["F_C", "sigma0", "sigma1", "sigma2"], {"sigma0": (3e6, 1e8), "sigma1": (1.0, 100.0)}
    sliding = trial(slip, values=stiff)
    identification = identify(experiment(sliding, nominal=stiff), MODEL, free, Settings(bounds=bounds, search="de", seed=1))
    for name in ("sigma0", "sigma1"):
        estimate = identification[name]
        assert estimate.verdict == "not identifiable", estimate
        assert "never reverses" in estimate.why
        assert "presliding" in estimate.advice
        assert estimate.profile is not None
        assert np.max(estimate.profile.rise) < estimate.profile.threshold  # flat, up to both bounds
    for name in ("F_C", "sigma2"):
        assert identification[name].verdict == "identified"
    way = 9.0 / 1e7
    strokes = 2 * way * 2 * np.pi * 5 * np.cos(2 * np.pi * 5 * TIMES)
    bent = trial(strokes, "c1", values=stiff, seed=2)
    again = identify(
        experiment(sliding, bent, nominal=stiff),
        MODEL,
        ["F_C", "sigma0", "sigma2"],
        Settings(bounds={"sigma0": (3e6, 1e8)}, search="de", seed=1),
    )
    assert all(estimate.verdict == "identified" for estimate in again.estimates)
    assert again["sigma0"].value == pytest.approx(1e7, rel=0.02)


def test_held_out_conditions_are_not_seen() -> None:
    """What is held out may be anything: the fit stays, and the error on it says so."""
    good, other = trial(TO_AND_FRO, "c0"), trial(0.5 * TO_AND_FRO, "c1", seed=2)
    wild = trial(0.5 * TO_AND_FRO, "c1", measured=3 * force(0.5 * TO_AND_FRO), seed=2)
    identifications = [
        identify(experiment(good, second, nominal=TRUTH), MODEL, ["F_C", "sigma0"], Settings(search="none", hold_out=("c1",)))
        for second in (other, wild)
    ]
    assert identifications[0]["F_C"].value == identifications[1]["F_C"].value
    assert identifications[0].held_out["friction_force"].relative_error < 0.011
    assert identifications[1].held_out["friction_force"].relative_error == pytest.approx(2 / 3, rel=0.05)
    with pytest.raises(ParameterError, match="F_C is named twice"):
        identify(experiment(good), MODEL, ["F_C", "F_C"])


def test_the_cost_of_a_set_does_not_depend_on_its_neighbours() -> None:
    from evat.identification.objective import Objective
    from evat.identification.space import space
    from evat.inference.prediction import Prediction

    rig = experiment(trial(TO_AND_FRO))
    aim = Objective(Prediction(MODEL, rig), space(MODEL, GUESS, (), FREE, {}), (), "least_squares", {})
    points = np.random.default_rng(0).random((17, len(FREE)))
    whole = aim.costs(points)
    assert np.array_equal(whole, np.concatenate([aim.costs(points[:5]), aim.costs(points[5:6]), aim.costs(points[6:])]))
    assert np.array_equal(whole, aim.costs(points[::-1])[::-1])
    assert TIMES[1] == STEP
