"""What does a Jacobian of eight parameters cost beside one run, and how near do its differences come to the slopes?"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from evat.constants import CONSTANTS
from evat.model import FloatArray, Run
from evat.native.batch import run_many
from evat.native.kernel import Contact
from report import Summary
from timing import least

SAMPLES = 4000
ON = ("direction_asymmetry", "load_dependence")
PARAMETERS = {
    "sigma0": 2.5e5, "sigma1": 60.0, "sigma2": 5.0, "F_C": 8.0, "F_S": 9.5, "v_s": 0.05,
    "direction_asymmetry.a": 0.1, "load_dependence.n": 0.8,
}  # fmt: skip
PHASE: FloatArray = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
MOTIONS = {  # slip speed [m/s] and the time of all samples [s]
    "5 slow strokes": (0.02 * np.sin(5 * PHASE), 0.5),
    "50 cycles of 20 kHz": (0.3 * np.cos(50 * PHASE), 50 / 20e3),
}


def record(motion: str) -> Run:
    slip, duration = MOTIONS[motion]
    return Run(duration * PHASE / (2 * np.pi), {"slip_velocity": slip, "normal_load": 12 + 3 * np.sin(3 * PHASE)}, ("friction_force",))


def differences(run: Run, tolerance: float, share: float, *, both_sides: bool) -> FloatArray:
    """Slopes of the friction force (8, samples), times the parameters, by differences between runs beside each other."""
    point = np.array(list(PARAMETERS.values()))
    up = point + np.diag(share * point)
    table = np.vstack([up, point - np.diag(share * point)]) if both_sides else np.vstack([point, up])
    lanes: dict[str, float | str | FloatArray] = {name: table[:, place] for place, name in enumerate(PARAMETERS)}
    rows = run_many(run, {"kinematics": "external", "relative_tolerance": tolerance, **lanes}, ON, threads=1).rows["friction_force"]
    return (rows[:8] - rows[8:]) / (2 * share) if both_sides else (rows[1:] - rows[0]) / share


@pytest.mark.benchmark(timer=time.process_time, group="batch")
@pytest.mark.parametrize("motion", list(MOTIONS))
def test_a_jacobian_of_eight_parameters(benchmark: Any, summary: Summary, motion: str) -> None:
    """Nine sets in lanes: a block of eight and one of one."""
    run = record(motion)

    def alone() -> None:
        contact = Contact({"kinematics": "external", "relative_tolerance": 1e-5, **PARAMETERS}, ON)
        contact.start()
        contact.run(run.times, run.inputs, run.outputs)

    def jacobian() -> FloatArray:
        return differences(run, 1e-5, CONSTANTS.derivative_step, both_sides=False)

    seconds = least({"alone": alone, "jacobian": jacobian}, rounds=7)
    benchmark.pedantic(jacobian, rounds=3)
    exact = differences(run, 1e-9, 1e-4, both_sides=True)
    scale = np.max(np.abs(exact), axis=1)
    off = np.sqrt(np.mean((jacobian() - exact) ** 2, axis=1)) / scale
    ratio = seconds["jacobian"] / seconds["alone"]
    benchmark.extra_info.update(ratio=ratio, off=off.tolist())
    summary.add(
        f"a Jacobian of eight parameters, {motion}",
        f"{ratio:.1f} runs; slopes off by {off.max():.1e} (rms, of the largest)",
        wanted="3 runs, 1e-6",
        limit="9 sets in 2 blocks of lanes",
    )
