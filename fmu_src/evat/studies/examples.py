"""What does a folder of measurements look like? Four small ones, simulated: a friction rig, a cut, averages, a driven axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from evat import parameter_sets
from evat.experiment import Experiment, Means, Nominal, Signal, Trial
from evat.experiment.document import CLOCK, FILE
from evat.experiment.write import new_folder, write_experiment
from evat.files.table import write_columns
from evat.model import FloatArray, ParameterError, nearest
from evat.models.simulate import simulate
from evat.native import kernel
from evat.studies.orthogonal import orthogonal

NOISE = 0.01  # of the root mean square
REPEATS = 2
RIG: Mapping[str, float | str] = {
    "friction_law": "lugre", "F_C": 8.0, "F_S": 9.5, "v_s": 0.01, "sigma0": 1e5, "sigma1": 30.0, "sigma2": 2.0,
}  # fmt: skip
CUT = "regularised/copper"
FORCES = ("principal_force", "feed_force")
SPEEDS = (0.1, 0.2, 0.4)  # m/s, of the cut
CYCLES, PER_CYCLE = 6, 50
RADIUS, TORQUE_CONSTANT = 0.02, 0.5  # m, N.m/A: of the axis

_AXIS = """\
format = 1
title = "Axis, simulated"
[nominal]
friction = "lugre"
kinematics = "external"
effects = []
initial_bristle = "relaxed"
[nominal.values]
F_C = 8.8
F_S = 10.0
v_s = 0.01
sigma0 = 1e5
sigma1 = 30.0
sigma2 = 2.0
[nominal.relative_sd]
F_C = 0.2
F_S = 0.2

[signals.time]
column = "t [ms]"
unit = "ms"
[signals.slip_velocity]
column = "angle [deg]"
unit = "deg"
role = "input"
from = "position"
radius = {radius}  # m, so that the slip velocity is that of the rim
[signals.friction_force]
column = "current [A]"
unit = "A"
role = "output"
scale = {scale}  # N/A: {constant} N.m/A at that radius
"""


def write_example(name: str, folder: Path, seed: int = 0) -> Path:
    """Write one of EXAMPLES into a new folder; the same seed gives the same files."""
    if name not in EXAMPLES:
        raise ParameterError(f"there is no example {name!r}; {nearest(name, EXAMPLES)}")
    return EXAMPLES[name](folder, seed)


def _rig(folder: Path, seed: int) -> Path:
    made = orthogonal(RIG, motion="reversal", repeats=REPEATS, speeds=[0.05, 0.5], rate=40.0, noise=NOISE, seed=seed, nominal_off=0.1)
    speed = Signal("slip_velocity", "v [mm/s]", "mm/s", "input")
    return write_experiment(replace(made, title="Friction rig, simulated", signals={**made.signals, speed.name: speed}), folder)


def _axis(folder: Path, seed: int) -> Path:
    made = orthogonal(RIG, motion="reversal", repeats=REPEATS, speeds=[0.05, 0.5], rate=100.0, noise=NOISE, seed=seed)
    lines = [_AXIS.format(radius=RADIUS, scale=TORQUE_CONSTANT / RADIUS, constant=TORQUE_CONSTANT)]
    with new_folder(folder) as new:
        for place, trial in enumerate(made.trials):
            speed, file = trial.inputs["slip_velocity"], f"{trial.condition.replace(' ', '')}_rep{1 + place % REPEATS}.csv"
            way = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(trial.times))])
            columns: dict[str, FloatArray] = {
                "t [ms]": 1e3 * trial.times,
                "angle [deg]": np.degrees(way / RADIUS),
                "current [A]": trial.outputs["friction_force"] * RADIUS / TORQUE_CONSTANT,
            }
            write_columns(columns, new / file)
            lines.append(f'[[trials]]\nfile = "{file}"\ncondition = "{trial.condition}"\n')
        (new / FILE).write_text("\n".join(lines), encoding="utf-8", newline="\n")
    return folder


def _cut(folder: Path, seed: int) -> Path:
    draw, trials = np.random.default_rng(seed), list[Trial]()
    for speed in SPEEDS[:2]:
        values, effects = _cutting()
        trace = simulate({**values, "cutting_speed": speed}, effects, cycles=CYCLES, samples_per_cycle=PER_CYCLE, outputs=FORCES)
        for repeat in range(REPEATS):
            outputs = {name: _noisy(trace[name], draw) for name in FORCES}
            name = f"vc{round(60 * speed)}"
            trials.append(Trial(f"{name}_rep{repeat + 1}.csv", name, {"cutting_speed": speed}, trace.times, {}, outputs))
    signals = {CLOCK: Signal(CLOCK, "t [us]", "us", None)}
    signals |= {name: Signal(name, f"{name} [N]", "N", "output") for name in FORCES}
    return write_experiment(_experiment("Elliptical vibration cutting, simulated", signals, tuple(trials), None), folder)


def _averages(folder: Path, seed: int) -> Path:
    draw, (values, effects) = np.random.default_rng(seed), _cutting()
    names = [f"mean_{name}" for name in FORCES]
    rows = [(speed, simulate({**values, "cutting_speed": speed}, effects, cycles=CYCLES, outputs=tuple(names))) for speed in SPEEDS]
    rows = [row for row in rows for _ in range(REPEATS)]
    outputs = {name: np.array([float(trace[name][-1]) * (1 + NOISE * draw.standard_normal()) for _, trace in rows]) for name in names}
    conditions = tuple(f"vc{round(60 * speed)}" for speed, _ in rows)
    means = Means("means.csv", conditions, {"cutting_speed": np.array([speed for speed, _ in rows])}, outputs, {})
    return write_experiment(_experiment("Mean forces, simulated", {}, (), means), folder)


def _cutting() -> tuple[dict[str, float | str], tuple[str, ...]]:
    known = parameter_sets.load(CUT)
    return dict(known.by_choice), tuple(known.effects)


def _experiment(title: str, signals: Mapping[str, Signal], trials: tuple[Trial, ...], means: Means | None) -> Experiment:
    """Its nominal model is the set, with the shear stress off by a tenth."""
    values, effects = _cutting()
    start = float(values.get("shear_stress", kernel.variable("shear_stress").start))
    believed = {"kinematics": "internal", **values, "shear_stress": 1.1 * start}
    believed.setdefault("friction_law", kernel.variable("friction_law").choices[int(kernel.variable("friction_law").start)])
    nominal = Nominal(believed, effects, {"shear_stress": 0.1}, parameters=CUT)
    return Experiment(Path(), title, "", nominal, signals, trials, means, "")


def _noisy(column: FloatArray, draw: np.random.Generator) -> FloatArray:
    return column + NOISE * float(np.sqrt(np.mean(column**2))) * draw.standard_normal(column.size)


EXAMPLES: dict[str, Callable[[Path, int], Path]] = {"rig": _rig, "cut": _cut, "averages": _averages, "axis": _axis}
