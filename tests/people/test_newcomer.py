"""Does somebody who has never seen this get from a folder of files to an answer: init, check, diagnose, with two edits at most?

The folders are those of `messy`. The newcomer types what the errors say and changes nothing else; the time is printed.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import messy
import numpy as np
import pytest
from command_line import typed
from evat.experiment.read import read_experiment
from evat.models.contact import ContactModel

MOST_EDITS = 2
MODEL = ContactModel()


@dataclass
class Newcomer:
    """Types commands, edits the document, and is timed."""

    folder: Path
    edits: int = 0
    errors: list[str] = field(default_factory=list)

    def types(self, *words: str) -> str:
        """What a command prints; "" where it is refused, and the complaint is kept."""
        status, printed, complaints = typed(*words)
        if status:
            self.errors.append(complaints)
            return ""
        return printed

    def edits_line(self, before: str, after: str) -> None:
        path = self.folder / "experiment.toml"
        text = path.read_text(encoding="utf-8")
        assert len(re.findall(before, text, re.MULTILINE)) == 1, text
        path.write_text(re.sub(before, after, text, flags=re.MULTILINE), encoding="utf-8")
        self.edits += 1
        assert self.edits <= MOST_EDITS


@pytest.fixture
def newcomer(tmp_path: Path) -> Iterator[Callable[[Callable[[Path], Path]], Newcomer]]:
    began, people = time.monotonic(), list[Newcomer]()

    def meets(make: Callable[[Path], Path]) -> Newcomer:
        people.append(Newcomer(make(tmp_path / make.__name__)))
        return people[-1]

    yield meets
    for each in people:
        print(f"\n{each.folder.name}: {time.monotonic() - began:.1f} s, {each.edits} edits, {len(each.errors)} errors on the way")


def as_simulated(folder: Path, made: messy.Experiment, *, speed: float, force: float) -> None:
    """The recordings in SI are those that the folder was made of, within these tolerances."""
    by_start = {float(trial.outputs["friction_force"] @ trial.inputs["slip_velocity"]): trial for trial in made.trials}
    read = read_experiment(folder, MODEL)
    assert len(read.trials) == len(made.trials)
    for trial in read.trials:
        work = float(trial.outputs["friction_force"] @ trial.inputs["slip_velocity"])
        nearest = min(by_start, key=lambda other: abs(other - work))
        truth = by_start.pop(nearest)
        np.testing.assert_allclose(trial.times, truth.times, atol=1e-5)
        np.testing.assert_allclose(trial.outputs["friction_force"], truth.outputs["friction_force"], atol=force)
        np.testing.assert_allclose(trial.inputs["slip_velocity"], truth.inputs["slip_velocity"], atol=speed)
    assert [list(read.conditions).count(name) for name in read.conditions] == [1, 1]


def test_ms_and_mm_in_the_names_of_columns_and_repeats_in_those_of_files(newcomer: Callable[..., Newcomer]) -> None:
    person = newcomer(messy.named_runs)
    said = person.types("experiment", "init", str(person.folder))
    assert "evat experiment check" in said
    person.edits_line(r"^title = .*$", 'title = "Belt rig, 50 and 80 N"')
    assert "4 trials of 960 rows in all; 2 conditions" in person.types("experiment", "check", str(person.folder))
    assert person.errors == []
    as_simulated(person.folder, messy.simulated(rate=40.0), speed=1e-6, force=1e-4)
    assert read_experiment(person.folder, MODEL).conditions == ("50N", "80N")


def test_an_axis_by_its_motors_angle_and_current(newcomer: Callable[..., Newcomer]) -> None:
    person = newcomer(messy.driven_axis)
    assert person.types("experiment", "init", str(person.folder)) == ""
    options = re.findall(r"--radius|--motor-constant", person.errors[0])
    assert options == ["--radius", "--motor-constant"], person.errors
    known = {"--radius": f"{1e3 * messy.RADIUS:g} mm", "--motor-constant": f"{messy.TORQUE_CONSTANT} N.m/A"}
    words = [word for option in options for word in (option, known[option])]
    assert person.types("experiment", "init", str(person.folder), *words)
    assert "2 conditions" in person.types("experiment", "check", str(person.folder))
    assert len(person.errors) == 1
    # The highest speed is 0.5 m/s; at its corners a derivative of samples is rounded by a step of it, 0.01 m/s.
    as_simulated(person.folder, messy.simulated(rate=200.0), speed=0.01, force=1e-4)


@pytest.mark.slow
def test_a_german_tribometer_down_to_the_cause(newcomer: Callable[..., Newcomer], tmp_path: Path) -> None:
    """The contact holds better one way than the other. To and fro alone does not tell that from a sensor whose zero is off, and the answer
    says so; it is neither noise nor mis-tuning nor a stranger."""
    person = newcomer(messy.german_rig)
    assert person.types("experiment", "init", str(person.folder))
    assert "4 trials of 480 rows in all; 2 conditions" in person.types("experiment", "check", str(person.folder))
    as_simulated(person.folder, messy.simulated(messy.ASYMMETRIC), speed=1e-6, force=1e-4)
    assert person.types("diagnose", str(person.folder), "--no-fmu", "--out", str(tmp_path / "answer"))
    assert person.errors == []
    answer = json.loads((tmp_path / "answer" / "diagnosis.json").read_text(encoding="utf-8"))
    assert answer["verdict"] in ("effect", "ambiguous")
    likely = {name for each in answer["candidates"] if each["probability"] > 0.3 for name in each["set"]}
    assert "direction_asymmetry" in likely
    assert likely <= {"direction_asymmetry", "sensor_offset"}
