"""Does a recording come back at the frequency at which its tool is said to vibrate?"""

from __future__ import annotations

from dataclasses import replace

import evat
import pytest
from evat.experiment import Experiment, ExperimentError
from evat.experiment.read import read_experiment
from evat.gap import CANNOT_TELL, diagnose_with
from evat.inference.cycles import other_frequency
from evat.inference.prediction import Prediction
from evat.models.contact import ContactModel
from evat.studies.examples import write_example

MODEL = ContactModel()


@pytest.fixture(scope="module")
def cut(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    return read_experiment(write_example("cut", tmp_path_factory.mktemp("cut") / "cut"), MODEL)


def run_by(experiment: Experiment, clock: float) -> Experiment:
    """The same, its clock too fast by that share."""
    return replace(experiment, trials=tuple(replace(trial, times=(1 + clock) * trial.times) for trial in experiment.trials))


def test_a_frequency_as_stated_is_none_other(cut: Experiment) -> None:
    assert other_frequency(Prediction(MODEL, cut)) is None
    assert other_frequency(Prediction(MODEL, run_by(cut, 1e-3))) is None


@pytest.mark.parametrize("clock", [0.06, -0.06])
def test_another_frequency_is_told(cut: Experiment, clock: float) -> None:
    """A record of a generator at 1167 Hz, declared as 1200 Hz, was "something unknown" after minutes of fits."""
    stated = 1 / MODEL.cycle_time({**Prediction(MODEL, cut).nominal, **cut.trials[0].values})
    other = other_frequency(Prediction(MODEL, run_by(cut, clock)))
    assert other is not None
    assert other.stated == pytest.approx(stated)
    assert other.measured == pytest.approx(stated / (1 + clock), rel=0.01)
    assert other.file in {trial.file for trial in cut.trials}


def test_nothing_is_fitted_to_it(cut: Experiment) -> None:
    wrong = run_by(cut, 0.06)
    answer, _ = diagnose_with(wrong, MODEL)
    assert answer.verdict == CANNOT_TELL
    assert "state the frequency as it was, or mend the clock" in answer.cannot_tell[0]
    with pytest.raises(ExperimentError, match="the force comes back at"):
        evat.identify(wrong, free=["shear_stress"])
