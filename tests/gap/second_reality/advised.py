"""Does the advised next experiment name the cause? Carries it out in the same reality, and a random one beside it.

    python tests/gap/second_reality advised CASES --labels LABELS --answers ANSWERS --out OUT --jobs 2

Of cases that were answered `ambiguous`: the same experiment with two recordings of one more condition, as advised and as drawn by lot from
what could have been advised, is written to OUT/advised/NNN and OUT/random/NNN and diagnosed again.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from answers import read_answer
from statistics_of_scores import Figure, share_of

from . import folder, run_diagnosis
from .draw import NotDrawn, Plan, draw_case, with_another_condition
from .scores import exact

WAYS = ("advised", "random")
FACTORS = (0.25, 0.5, 2.0, 4.0)
AMBIENT = 293.15  # K, of every rig here


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("cases", type=Path)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--answers", type=Path, required=True, help="what `run` wrote about the cases")
    parser.add_argument("--out", type=Path, required=True, help="folder of the longer experiments and the answers to them")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time, each on one core")


def recorded(case: Path) -> dict[str, dict[str, float]]:
    """What was recorded at each condition: its inputs (rms) and values, SI."""
    from evat.experiment.read import read_experiment
    from evat.models.contact import ContactModel

    experiment, at = read_experiment(case, ContactModel(1)), dict[str, dict[str, float]]()
    for trial in experiment.trials:
        inputs = {name: float(np.sqrt(np.mean(column**2))) for name, column in trial.inputs.items()}
        at.setdefault(trial.condition, {**inputs, **trial.values})
    if experiment.means is not None:
        for row, condition in enumerate(experiment.means.conditions):
            at.setdefault(condition, {name: float(column[row]) for name, column in experiment.means.values.items()})
    return at


def place_of(condition: str) -> int:
    """`cond3` of records and `test 3` of means are of place 2."""
    return int(condition.removeprefix("cond").removeprefix("test ")) - 1


def by_lot(at: Mapping[str, Mapping[str, float]], rng: np.random.Generator) -> tuple[str, dict[str, float]]:
    """One of the conditions, and by how much one of what could be set there differs."""
    condition = str(rng.choice(sorted(at)))
    return condition, {str(rng.choice(sorted(at[condition]))): float(rng.choice(FACTORS))}


def factors_of(advice: Mapping[str, float], now: Mapping[str, float]) -> dict[str, float]:
    """By how much what is to be set differs from what was recorded."""
    factors = {}
    for name, value in advice.items():
        zero = AMBIENT if name == "contact_temperature" else 0.0
        factor = (value - zero) / (now[name] - zero)
        factors[name] = min(FACTORS, key=lambda one: abs(math.log(max(factor, 1e-3) / one)))  # of an rms, which rounding has moved
    return factors


def write(case: str, label: Mapping[str, Any], place: int, factors: Mapping[str, float], to: Path) -> None:
    """The longer experiment; NotDrawn where that condition cannot be run."""
    plan = Plan(**{**label["plan"], "effects": tuple(label["plan"]["effects"])})
    seed, split = [int(number) for number in label["seed"]], str(label["split"])
    longer = with_another_condition(draw_case(plan, split, seed), plan, split, seed, place, factors)
    folder.write(to / case, longer, np.random.default_rng([*seed[:-1], 2]))


def ambiguous(labels: Mapping[str, Any], answers: Path) -> list[tuple[str, dict[str, Any]]]:
    """Cases whose answer was `ambiguous` and that had an advice, with it."""
    chosen = []
    for name, label in sorted(labels.items()):
        file = answers / name / "diagnosis.json"
        said = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
        if said.get("verdict") == "ambiguous" and said["next_experiment"] and label["truth"] != "unknown":
            chosen.append((name, said["next_experiment"]))
    return chosen


def named(labels: Mapping[str, Any], answers: Path, cases: list[str]) -> Figure:
    """In how many of them the truth is what is named, and nothing else."""
    return share_of([exact(labels[name], read_answer(answers / name / "diagnosis.json")) for name in cases])


def run(given: argparse.Namespace) -> int:
    labels = json.loads((given.labels / "labels.json").read_text(encoding="utf-8"))["cases"]
    chosen, done = ambiguous(labels, given.answers), list[str]()
    for number, (name, advice) in enumerate(chosen):
        at = recorded(given.cases / name)
        told = advice["condition"]
        changes = {"advised": (told, factors_of(advice["values"], at[told])), "random": by_lot(at, np.random.default_rng([7, number]))}
        try:
            for way, (condition, factors) in changes.items():
                if not (given.out / way / name / "experiment.toml").is_file():
                    write(name, labels[name], place_of(condition), factors, given.out / way)
            done.append(name)
        except NotDrawn as reason:
            sys.stdout.write(f"{name}: {advice['values']} is not run: {reason}\n")
    if not done:
        raise SystemExit(f"{given.answers}: no answer there is ambiguous and has an advice.")
    for way in WAYS:
        run_diagnosis.run(
            argparse.Namespace(
                cases=given.out / way, answers=given.out / f"{way} answers", jobs=given.jobs, limit=run_diagnosis.LIMIT, again=False
            )
        )
    sys.stdout.write(f"{len(chosen)} ambiguous answers with an advice, {len(done)} carried out; the truth is named\n")
    for way, answers in (("before", given.answers), *((way, given.out / f"{way} answers") for way in WAYS)):
        sys.stdout.write(f"  {way:8}  {Figure.text(named(labels, answers, done).as_json())}\n")
    return 0
