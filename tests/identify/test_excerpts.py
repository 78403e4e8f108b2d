"""Does a search over excerpts of a long record end where one over all of it does, and when does it look at the whole?"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat import identify
from evat.experiment import Experiment, Nominal, Trial
from evat.identification import run as of_run
from evat.identification.searching.excerpts import EXCERPTS, FEWEST, LEAD_IN, LOOKED_AT, excerpts
from evat.identification.settings import Settings
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel

TRUTH: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 300.0, "sigma2": 40.0, "v_s": 1e-2,
}  # fmt: skip
GUESS = {**TRUTH, "F_C": 5.0, "F_S": 14.0, "sigma2": 10.0}
FREE = ("F_C", "F_S", "sigma2")


def recorded(sizes: dict[str, int], on: tuple[str, ...] = (), truth: dict[str, float | str] = TRUTH) -> Experiment:
    """To and fro at 2 ms, 2 % noise, ten times as fast in the last tenth of each trial; each trial a little faster than before."""
    model, luck, trials = ContactModel(), np.random.default_rng(3), []
    for file, count in sizes.items():
        times = np.arange(count) * 2e-3
        slip = (0.02 + 0.001 * len(trials)) * np.sin(2 * np.pi * times) * np.where(times > 0.9 * times[-1], 10, 1)
        force = model.simulate(Run(times, {"slip_velocity": slip}, ("friction_force",)), on, truth)["friction_force"]
        noisy = force + 0.02 * np.sqrt(np.mean(force**2)) * luck.standard_normal(count)
        trials.append(Trial(file, file, {}, times, {"slip_velocity": slip}, {"friction_force": noisy}))
    return Experiment(Path(), "rig", "", Nominal(GUESS, on, {}), {}, tuple(trials), None, "")


LONG = recorded({"a.csv": 60_000})


def test_excerpts_come_from_start_to_end_and_follow_what_was_before_them() -> None:
    (whole,), some = LONG.trials, excerpts(LONG, ContactModel(), ())
    assert some is not None
    assert len(some.trials) == EXCERPTS
    assert sum(part.times.size for part in some.trials) == LOOKED_AT
    assert some.trials[0].times[0] == whole.times[0]
    assert some.trials[-1].times[-1] == whole.times[-1]
    assert len({part.file for part in some.trials}) == EXCERPTS
    for part in some.trials:
        begin = int(np.searchsorted(whole.times, part.times[0]))
        at = slice(begin, begin + part.times.size)
        assert part.times.tolist() == whole.times[at].tolist()
        assert part.outputs["friction_force"].tolist() == whole.outputs["friction_force"][at].tolist()
        assert (part.lead_in is None) == (begin == 0)
        if part.lead_in is not None:
            assert part.lead_in.inputs["slip_velocity"].tolist() == whole.inputs["slip_velocity"][begin - LEAD_IN : begin].tolist()


def test_a_model_runs_through_them_as_through_the_whole() -> None:
    """Bristles and a filter stand where they would."""
    model, on = ContactModel(), ("sensor_lowpass",)
    values: dict[str, float | str] = {**TRUTH, "sensor_lowpass.time_constant": 5e-3}
    some = excerpts(LONG, model, on)
    assert some is not None
    everything = Prediction(model, LONG).one(values, on)
    parts = Prediction(model, some)
    calculated = parts.one(values, on)
    for segment in parts.segments:
        begin = int(np.searchsorted(LONG.trials[0].times, some.trials[segment.trial].times[0]))
        own = calculated[segment.at]
        assert own == pytest.approx(everything[begin : begin + own.size], abs=1e-3)


def test_short_and_many_trials_keep_their_share() -> None:
    some = excerpts(recorded({"a.csv": 50_000, "b.csv": 4_000, "c.csv": 50_000}), ContactModel(), ())
    assert some is not None
    sizes = {file: sum(part.times.size for part in some.trials if part.file.startswith(file)) for file in ("a.csv", "b.csv", "c.csv")}
    assert sizes == {"a.csv": 8_000, "b.csv": 4_000, "c.csv": 8_000}
    many = excerpts(recorded({f"{n}.csv": 1_500 for n in range(60)}), ContactModel(), ())
    assert many is not None
    assert [part.times.size for part in many.trials] == 60 * [FEWEST]


@pytest.mark.parametrize(
    ("experiment", "on"),
    [
        (replace(LONG, trials=(LONG.trials[0].head(30_000),)), ()),
        (LONG, ("friction_wear",)),
        (replace(LONG, nominal=Nominal(GUESS, ("sensor_drift",), {})), ()),
        (replace(LONG, nominal=Nominal({"kinematics": "internal"}, (), {})), ()),
    ],
    ids=["short", "by the way slid", "by the time", "vibrating"],
)
def test_it_looks_at_the_whole(experiment: Experiment, on: tuple[str, ...]) -> None:
    assert excerpts(experiment, ContactModel(), on) is None


def test_the_identified_values_are_those_of_a_search_over_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Viscous friction shows in the last tenth alone."""
    settings = Settings(search="ga", population=24, generations=15, seed=2, profiles=False)
    numbers: list[int] = []
    simulate = Prediction.many

    def counted(self: Prediction, values: object, on: object) -> FloatArray:
        rows: FloatArray = simulate(self, values, on)  # type: ignore[arg-type]
        numbers.append(rows.size)
        return rows

    monkeypatch.setattr(Prediction, "many", counted)
    by_excerpts = identify(LONG, ContactModel(), FREE, settings)
    looked_at = sum(numbers)
    numbers.clear()
    monkeypatch.setattr(of_run, "excerpts", lambda *_: None)
    by_all = identify(LONG, ContactModel(), FREE, settings)
    assert looked_at < 0.45 * sum(numbers)
    assert by_excerpts.searched_points == LOOKED_AT
    assert "excerpts of 20000 data points" in by_excerpts.summary()
    assert "excerpts" not in by_all.summary()
    for name in FREE:
        assert by_excerpts[name].value == pytest.approx(by_all[name].value, abs=0.01 * by_all[name].sd)
        assert by_excerpts[name].value == pytest.approx(float(TRUTH[name]), abs=4 * by_all[name].sd)
