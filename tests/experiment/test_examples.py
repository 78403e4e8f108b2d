"""Are the example folders what they say: fit to be used, small, the same for a seed, and telling of the truth they were made of?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.experiment.read import read_experiment, scan_experiment
from evat.model import ParameterError
from evat.models.contact import ContactModel
from evat.studies.examples import EXAMPLES, NOISE, RADIUS, RIG, write_example

MODEL = ContactModel()
MOST_BYTES = 200_000


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_passes_the_check_and_goes_by_its_seed(tmp_path: Path, name: str) -> None:
    files = contents(write_example(name, tmp_path / "a", 3))
    assert sum(map(len, files.values())) < MOST_BYTES
    assert files == contents(write_example(name, tmp_path / "b", 3))
    assert files != contents(write_example(name, tmp_path / "c", 4))
    scan_experiment(tmp_path / "a", MODEL)
    experiment = read_experiment(tmp_path / "a", MODEL)
    assert len(experiment.conditions) >= 2
    of_means = experiment.means.conditions if experiment.means is not None else ()
    repeats = [*(trial.condition for trial in experiment.trials), *of_means]
    assert all(repeats.count(condition) == 2 for condition in repeats)


def test_the_axis_is_the_rig_seen_from_its_motor(tmp_path: Path) -> None:
    """At the highest speed the force is Coulomb friction and what is viscous; the angle, differentiated, is the speed of the rim."""
    trials = read_experiment(write_example("axis", tmp_path / "axis"), MODEL).trials
    fast = max(trials, key=lambda trial: float(np.max(trial.inputs["slip_velocity"])))
    speed = fast.inputs["slip_velocity"]
    assert float(np.max(speed)) == pytest.approx(0.5, rel=0.02)
    sliding = speed > 0.3
    expected = float(RIG["F_C"]) + float(RIG["sigma2"]) * speed[sliding]
    np.testing.assert_allclose(fast.outputs["friction_force"][sliding], expected, atol=6 * NOISE * 8.0)
    assert RADIUS < 0.1


def test_an_example_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="rig, cut, averages, axis"):
        write_example("lathe", tmp_path / "a")
