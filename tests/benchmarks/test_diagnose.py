"""How long does a diagnosis take? On one core, in runs of the whole record: what every method must do a few hundred times."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evat.experiment import Experiment, Nominal, Trial
from evat.gap import diagnose
from evat.inference.prediction import Prediction
from evat.model import Run
from evat.models.contact import ContactModel
from report import Summary

MODEL = ContactModel(threads=1)
RIG: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 100.0, "sigma2": 100.0,
    "v_s": 0.01,
    "proxy_source": "proxy_speed",  # the recorded one: by its own speed a film that thins is hardly told from less of it
}  # fmt: skip
ELLIPSE: dict[str, float | str] = {
    "kinematics": "internal", "friction_law": "lugre", "F_C": 5.0, "F_S": 6.0, "sigma0": 5e6, "sigma1": 0.1, "sigma2": 0.5, "v_s": 0.1,
    "shear_stress": 5e8, "width": 1e-3, "feed": 5e-6,
}  # fmt: skip
WANTED = "median 10 s, 95 of 100 in 30 s"


def _rig(place: int) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, float], tuple[str, ...]]:
    times = np.arange(1300) * 1e-3
    slip = 0.012 * (1 + place) * np.sin(2 * np.pi * 5 * times + place) + 0.01 * (place % 2)
    return times, {"slip_velocity": slip, "proxy_speed": 0.1 + 0.05 * np.sin(times)}, {}, ("friction_force",)


def _ellipse(place: int) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, float], tuple[str, ...]]:
    return np.arange(1500) / (20e3 * 60), {}, {"cutting_speed": 0.1 + 0.1 * place}, ("principal_force", "feed_force")


CASES = {
    "a rig, thermal viscosity": (RIG, _rig, "thermal_viscosity", {"thermal_viscosity.beta": 0.1}),
    "an ellipse, leaning friction": (ELLIPSE, _ellipse, "direction_asymmetry", {"direction_asymmetry.a": 0.2}),
}


def experiment(values: dict[str, float | str], motion: Any, on: str, more: dict[str, float]) -> Experiment:
    """Four conditions, three repeats, 2 % noise."""
    draw, trials = np.random.default_rng(1), list[Trial]()
    for place in range(4):
        times, inputs, own, outputs = motion(place)
        shown = MODEL.simulate(Run(times, inputs, outputs), [on], {**values, **more, **own})
        for repeat in range(3):
            noisy = {name: shown[name] + 0.02 * np.std(shown[name]) * draw.standard_normal(times.size) for name in outputs}
            trials.append(Trial(f"{place}{repeat}", f"c{place}", own, times, inputs, noisy))
    return Experiment(Path(), "case", "", Nominal(values, (), {}), {}, tuple(trials), None, "")


@pytest.mark.benchmark(group="diagnosis")
@pytest.mark.parametrize("name", list(CASES))
def test_diagnose(benchmark: Any, summary: Summary, name: str) -> None:
    """Limit: arithmetic of the runs; the sums over what they give take about as long again."""
    case = experiment(*CASES[name])
    prediction = Prediction(MODEL, case)
    values = {"F_C": np.linspace(0.9, 1.1, 8) * float(case.nominal.values["F_C"])}
    prediction.many(values)
    started = time.process_time()
    for _ in range(5):
        prediction.many(values)
    run = (time.process_time() - started) / 5
    started = time.process_time()
    answer = benchmark.pedantic(lambda: diagnose(replace(case), MODEL), rounds=1)
    seconds = time.process_time() - started
    assert CASES[name][2] in [effect.name for effect in answer.effects]
    samples = sum(trial.times.size for trial in case.trials)
    summary.add(f"diagnosing {name}, {samples} samples", f"{seconds:.1f} s, as {seconds / run:.0f} runs of 8 value sets", wanted=WANTED)
