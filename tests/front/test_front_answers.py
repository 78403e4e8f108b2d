"""Do the answers of the front door need no model object, take units, and fit a notebook: summaries, ArviZ, Sobol's indices?"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import evat
import numpy as np
import pytest
from evat.notebook.summaries import FitRow, summary

QUICK = evat.Settings(search="none", bounds={"F_C": ("1 N", "0.03 kN")}, profiles=False)  # type: ignore[dict-item]  # units are allowed


@pytest.fixture(scope="module")
def made() -> evat.experiment.Experiment:  # type: ignore[name-defined]
    truth = {"friction_law": "coulomb", "F_C": "8 N"}
    return evat.orthogonal(truth, motion="reversal", repeats=2, speeds=[0.1, 0.5], rate=100.0, seed=1)


@pytest.fixture(scope="module")
def identified(made: evat.experiment.Experiment) -> evat.Identification:  # type: ignore[name-defined]
    return evat.identify(made, settings=QUICK)


def test_what_is_uncertain_is_identified_without_a_model_object(identified: evat.Identification) -> None:
    assert list(identified) == ["F_C"]  # of which the experiment says how well it is known
    assert identified["F_C"].bounds == (1.0, 30.0)
    assert identified["F_C"].value == pytest.approx(8.0, rel=1e-2)
    assert "F_C" in identified
    assert "sigma0" not in identified


def test_one_name_need_not_be_in_a_list(made: evat.experiment.Experiment, identified: evat.Identification) -> None:  # type: ignore[name-defined]
    assert evat.identify(made, free="F_C", settings=QUICK)["F_C"].value == identified["F_C"].value


@pytest.mark.parametrize("answer", [evat.identify, evat.diagnose])
def test_names_in_the_place_of_the_model_are_told(answer: Callable[..., object], made: evat.experiment.Experiment) -> None:  # type: ignore[name-defined]
    with pytest.raises(evat.ParameterError, match=r"model = \['F_C'\]: this is no model; .*free=\['F_C'\]"):
        answer(made, ["F_C"])


def test_a_run_takes_lists() -> None:
    run = evat.Run([0, 1e-3], {"slip_velocity": [0.1, 0.1]}, "friction_force")  # type: ignore[arg-type, dict-item]
    values = {"kinematics": "external", "friction_law": "coulomb", "F_C": 3.0}
    assert evat.ContactModel().simulate(run, (), values)["friction_force"] == pytest.approx(3.0)
    assert evat.run_many(run, values)["friction_force"].shape == (1, 2)


def test_an_experiment_that_is_sure_of_all_says_what_to_name(made: evat.experiment.Experiment) -> None:  # type: ignore[name-defined]
    from dataclasses import replace

    with pytest.raises(evat.ParameterError, match=r"relative_sd.*free=\['F_C'\]"):
        evat.identify(replace(made, nominal=replace(made.nominal, relative_sd={})))


def test_a_folder_is_read(made: evat.experiment.Experiment, tmp_path: Path, identified: evat.Identification) -> None:  # type: ignore[name-defined]
    folder = evat.write_experiment(made, tmp_path / "rig")
    again = evat.identify(folder, free=["F_C"], settings=QUICK)
    assert again["F_C"].value == pytest.approx(identified["F_C"].value, rel=1e-6)  # a CSV has digits enough
    assert evat.read_experiment(folder).conditions == made.conditions


def test_the_summary_reads_as_of_lmfit(identified: evat.Identification) -> None:
    text = str(identified)
    assert text.startswith("[[Fit]]\n    experiment")
    assert f"\n[[Variables]]\n    F_C: {identified['F_C'].value:.5g} N +/- " in text
    assert "identified" in repr(identified)
    assert identified.to_pandas().loc["F_C", "value"] == identified["F_C"].value
    with pytest.raises(evat.ParameterError, match="no profiles"):
        identified.plot()


def test_correlations_are_told_the_strongest_first() -> None:
    row = FitRow("a", "1 N", "0.1 N", "0.8 N to 1.2 N", "2 N", "weak")
    told = summary({"method": "x"}, [row], {("a", "b"): 0.2, ("a", "c"): -0.9, ("b", "c"): 0.05}, ["look here"])
    assert told.index("C(a, c) = -0.9000") < told.index("C(a, b) = +0.2000")
    assert "C(b, c)" not in told
    assert told.endswith("[[Doubts]]\n    look here")


def test_arviz_gets_the_estimates_and_their_errors(identified: evat.Identification) -> None:
    pytest.importorskip("arviz_base")
    tree = identified.to_arviz(draws=2000, chains=2)
    drawn, estimate = tree["posterior"]["F_C"], identified["F_C"]
    assert drawn.shape == (2, 2000)
    assert drawn.attrs["units"] == "N"
    assert float(drawn.mean()) == pytest.approx(estimate.value, abs=4 * estimate.sd / np.sqrt(4000))
    assert float(drawn.std()) == pytest.approx(estimate.sd, rel=0.1)  # 4000 draws: 1.1 % is one sd of it
    assert float(tree["prior"]["F_C"].min()) >= 1.0
    assert tree["observed_data"]["friction_force"].size == sum(trial.times.size for trial in identified.experiment.trials)
    assert "normal about the optimum" in tree.attrs["approximation"]


@pytest.mark.parametrize(("package", "ask"), [("arviz_base", "to_arviz"), ("SALib", "sobol")])
def test_what_is_not_installed_is_told(package: str, ask: str, identified: evat.Identification, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [package, *(name for name in sys.modules if name.startswith(f"{package}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    run = evat.Run(np.array([0.0, 0.1]), {"slip_velocity": np.full(2, 0.1)}, ("friction_force",))
    asks = {"to_arviz": identified.to_arviz, "sobol": lambda: evat.sobol(run, {"kinematics": "external"}, {"F_C": (1.0, 2.0)}, samples=2)}
    with pytest.raises(evat.EvatError, match=r"not installed here: pip install 'evat\[notebook\]'"):
        asks[ask]()


def test_indices_of_a_sum_are_the_shares_of_its_variance() -> None:
    """At steady slip far above v_s, F = F_C + sigma2 v: of two even spreads each has its width squared."""
    pytest.importorskip("SALib")
    times = np.linspace(0, 0.05, 6)
    run = evat.Run(times, {"slip_velocity": np.full(6, 0.5)}, ("friction_force",))
    held = {"kinematics": "external", "friction_law": "lugre", "F_S": "10 N", "v_s": "1 mm/s"}
    indices = evat.sobol(
        run, held, {"F_C": ("5 N", "6 N"), "sigma2": (1.0, 2.0), "ambient_temperature": (280.0, 300.0)}, of="last", samples=512
    )
    shares = np.array([1.0, 0.5**2, 0.0]) / 1.25
    assert indices["friction_force"] == pytest.approx(shares, abs=0.03)  # of 512 base points
    assert indices.first["friction_force"] == pytest.approx(shares, abs=0.06)
    assert indices.runs == 5 * 512
    assert indices.bounds["F_C"] == (5.0, 6.0)
    data = indices.to_xarray()
    assert float(data["total"].sel(output="friction_force", parameter="F_C")) == indices["friction_force"][0]
    (axis,) = indices.plot().axes
    assert [text.get_text() for text in axis.get_yticklabels()] == ["F_C", "sigma2", "ambient_temperature"]


@pytest.mark.parametrize("of", ["mean", "rms"])
def test_indices_of_a_mean_are_those_of_its_time(of: Literal["mean", "rms"], monkeypatch: pytest.MonkeyPatch) -> None:
    """99 of 101 samples are in the first hundredth of the time, at a slip that feels F_S alone; the rest of it is viscous."""
    pytest.importorskip("SALib")
    times = np.concatenate([np.linspace(0, 0.01, 100), [1.0]])
    slip = np.interp(times, [0, 0.0099, 0.01, 1.0], [0.001, 0.001, 1.0, 1.0])
    run = evat.Run(times, {"slip_velocity": slip}, ("friction_force",))
    held, bounds = {"kinematics": "external", "friction_law": "lugre"}, {"F_S": (5.0, 40.0), "sigma2": (0.0, 10.0)}
    told: list[float] = []
    indices = evat.sobol(run, held, bounds, of=of, samples=64, progress=told.append)
    assert indices["friction_force"] == pytest.approx([0.0, 1.0], abs=0.01)
    assert told[-1] == 1
    monkeypatch.setattr("evat.studies.sobol.NUMBERS_AT_ONCE", 1000)
    parts = evat.sobol(run, held, bounds, of=of, samples=64, progress=told.append)
    assert parts["friction_force"].tolist() == indices["friction_force"].tolist()


@pytest.mark.parametrize("of", ["mean", "rms", "last"])
def test_of_one_sample_the_mean_is_what_it_is(of: Literal["mean", "rms", "last"]) -> None:
    pytest.importorskip("SALib")
    run = evat.Run(np.zeros(1), {"slip_velocity": np.full(1, 0.1)}, ("friction_force",))
    held = {"kinematics": "external", "friction_law": "coulomb"}
    indices = evat.sobol(run, held, {"F_C": (5.0, 10.0), "v_s": (0.01, 0.02)}, of=of, samples=64)
    assert indices["friction_force"] == pytest.approx([1.0, 0.0], abs=0.01)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"parameters": {"F_D": (1.0, 2.0)}}, "did you mean F_"),
        ({"parameters": {"F_C": (2.0, 1.0)}}, "first must be below"),
        ({"parameters": {"friction_law": (0.0, 1.0)}}, "is no number"),
        ({"parameters": {}}, "parameters are empty"),
        ({"samples": 100}, "power of 2"),
        ({"of": "median"}, "allowed are mean, rms"),
    ],
)
def test_what_makes_no_sense_is_refused(more: dict[str, object], said: str) -> None:
    run = evat.Run(np.array([0.0, 0.1]), {"slip_velocity": np.full(2, 0.1)}, ("friction_force",))
    asked: dict[str, object] = {"parameters": {"F_C": (1.0, 2.0)}, **more}
    with pytest.raises(evat.ParameterError, match=said):
        evat.sobol(run, {"kinematics": "external"}, **asked)  # type: ignore[arg-type]


def test_every_number_takes_a_unit_in_python() -> None:
    typed = evat.simulate(cutting_speed="20 m/min", feed="50 um", cycles=1, samples_per_cycle=20)
    bare = evat.simulate({"cutting_speed": 20 / 60, "feed": 50e-6}, cycles=1, samples_per_cycle=20)
    assert np.array_equal(typed["principal_force"], bare["principal_force"])
    assert typed.made_by["values"] == {"cutting_speed": 20 / 60, "feed": 50e-6}
    contact = evat.Contact({"F_C": "0.003 kN", "kinematics": "external", "friction_law": "coulomb"})
    contact.start()
    contact.set("slip_velocity", "10 cm/s")
    contact.advance(1e-4)
    assert contact.get("friction_force") == pytest.approx(3.0, rel=1e-12)
    with pytest.raises(evat.ParameterError, match="does not measure what m/s measures"):
        evat.simulate(cutting_speed="20 N")
    with pytest.raises(evat.ParameterError, match="did you mean cutting_speed"):
        evat.simulate(cuting_speed=1.0)
