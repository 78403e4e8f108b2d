"""Is it told where a recording goes on otherwise than its first samples, of which alone a diagnosis looks at each effect?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.gap import diagnose_with
from evat.gap.report import headline
from evat.gap.report.html_report import page
from evat.model import FloatArray, Run, Variable
from lxml import html
from toy import Toy, measured

LATE = np.where(np.arange(400) < 300, 0.0, 0.6 * np.sin(np.arange(400.0)))  # the last quarter of each recording


@pytest.mark.parametrize("extra", [None, LATE])
def test_what_follows_is_compared_at_least(extra: np.ndarray | None) -> None:
    """ "100 % of the gap closed, use the recalibrated values", while the last 15 % of each recording was 14 times the noise off."""
    made = measured(extra=extra)
    with CONSTANTS.replaced(diagnosed_samples=1000):  # 250 of each
        answer, comparison = diagnose_with(made, Toy())
        whole, _ = diagnose_with(made, Toy(), whole=True)
    top = headline(answer, comparison)
    assert not whole.later
    assert not any("were looked at" in line for line in whole.cannot_tell)
    assert answer.verdict == "no_gap"
    if extra is None:
        assert not answer.later
        assert (top.tone, top.first) == ("good", ())
        return
    trial = made.trials[0]
    later = np.concatenate([t.outputs["F"][250:] - 10.0 * t.inputs["x"][250:] for t in made.trials])
    assert trial.times.size == 400
    assert f"F {np.sqrt(np.mean(later**2)):.2g}"[:5] in answer.later
    assert answer.later in answer.cannot_tell
    assert top.tone == "attention"
    assert top.first == (f"{answer.later[:1].upper()}{answer.later[1:]}.",)
    assert "only the first 250 samples of each trial were looked at, and those that follow leave more" in answer.later
    assert top.next.startswith("diagnose again with --whole")
    assert whole.verdict != "no_gap"
    body = html.fromstring(page(answer, comparison, None, "it was not asked for"))
    listed = [item.text_content() for item in body.iter("li")]
    assert "only the first 250 samples of each trial were looked at; --whole takes all" in listed


def test_a_shape_of_the_law_is_run_as_it_was_fitted() -> None:
    """It was held where it is linearised: samples that the fit follows as well "leave more, 0.37 N where it was 0.23"."""

    class Curved(Toy):
        variables = (*Toy.variables, Variable("p", "1", 1.0, 0.1, 5.0, "exponent", "toy", neutral=1.0))

        def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
            x = values["x"]
            return super().formula(times, {**values, "x": np.sign(x) * np.abs(x) ** values["p"]}, on)

    made, draw, trials = measured(conditions=6), np.random.default_rng(7), []
    for trial in made.trials:
        x = trial.inputs["x"] * np.where(trial.times < 2.5, 1.0, 1.7)
        force = Curved().simulate_many(Run(trial.times, {"x": x}, ("F",)), [], {"k": 10.0, "p": 1.2})["F"][0]
        trials.append(replace(trial, inputs={"x": x}, outputs={"F": force + 0.1 * draw.normal(size=x.size)}))
    with CONSTANTS.replaced(diagnosed_samples=1500):  # 250 of each
        answer, comparison = diagnose_with(replace(made, trials=tuple(trials)), Curved())
    assert abs(comparison.recalibrated.values["p"] - 1.2) < 0.05
    assert any(each.parameter.name == "p" for each in comparison.prediction.linearised)
    assert not answer.later


def test_a_shape_of_the_law_is_run_at_the_reference_at_which_it_was_fitted() -> None:
    """It was run at the reference's start value: the first samples, too, were off, and 0.5 N more in the later ones were told nowhere."""

    class Curved(Toy):
        variables = (
            *Toy.variables,
            Variable("p", "1", 1.0, 0.1, 5.0, "exponent", "toy", neutral=1.0),
            Variable("x_ref", "m", 5.0, 1e-3, 10.0, "way at which k is told", "toy", reference=True),
        )

        def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
            x = values["x"]
            return super().formula(times, {**values, "x": x * np.abs(x / values["x_ref"]) ** (values["p"] - 1)}, on)

    made, draw, trials = measured(conditions=6), np.random.default_rng(7), []
    for trial in made.trials:
        x = trial.inputs["x"]
        force = Curved().simulate_many(Run(trial.times, {"x": x}, ("F",)), [], {"k": 10.0, "p": 1.2, "x_ref": 0.4})["F"][0]
        force = force + np.where(trial.times < 2.5, 0.0, 0.5) + 0.1 * draw.normal(size=x.size)
        trials.append(replace(trial, outputs={"F": force}))
    with CONSTANTS.replaced(diagnosed_samples=1500):  # 250 of each
        answer, comparison = diagnose_with(replace(made, trials=tuple(trials)), Curved())
    assert comparison.recalibrated.values["p"] == pytest.approx(1.2, abs=0.05)
    assert comparison.prediction.nominal["x_ref"] != Curved.variables[-1].start
    assert " leave more: F 0.5" in answer.later
    assert " N rms where it was 0.1" in answer.later


def test_what_does_not_run_beyond_what_was_looked_at_is_told() -> None:
    """A model that is no number where the way is long, in the second half of each recording; trials that were not cut are not compared."""

    class Ends(Toy):
        def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
            force = super().formula(times, values, on)["F"]
            return {"F": np.where(times > 3.0, np.nan, force)}

    made = measured()
    short = replace(made.trials[0], file="short.csv", condition="short").head(100)
    with CONSTANTS.replaced(diagnosed_samples=1000):
        answer, _ = diagnose_with(made, Ends())
        beside, _ = diagnose_with(replace(made, trials=(*made.trials, short)), Toy())
    assert answer.later == "only the first samples of each trial were looked at, and beyond them the model does not run with these values"
    assert not beside.later
