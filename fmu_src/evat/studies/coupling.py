"""What does a communication step between contact and machine cost in accuracy and in energy? A machine of one mass in each direction.

The partner is as simple as can be: the tool on mass, spring and damper along the cut and across it, moved exactly by a force that is held.
The contact is told the tool's motion at the start of a step, held or going on straight, and gives the force that the tool feels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import expm

from evat.model import FloatArray
from evat.native.kernel import Contact
from evat.systems.coupling import PowerBalance

Inputs = Literal["held", "straight"]
Force = Literal["instant", "mean"]
FINE = 2e-6  # s; the communication step that stands for the truth


@dataclass(frozen=True)
class Tool:
    """A tool on a spring, alike along the cut and across: mass [kg], natural frequency [Hz], damping ratio. A guess at a slim tool post."""

    mass: float = 2.0
    frequency: float = 200.0
    damping_ratio: float = 0.03

    @property
    def stiffness(self) -> float:
        return self.mass * (2 * np.pi * self.frequency) ** 2

    @property
    def damping(self) -> float:
        return 2 * self.damping_ratio * float(np.sqrt(self.stiffness * self.mass))

    def acceleration(self, state: FloatArray, force: FloatArray) -> FloatArray:
        """Of both directions: state (displacement, velocity) x (x, y), force on the tool [N]."""
        return np.asarray((force - self.damping * state[1] - self.stiffness * state[0]) / self.mass)

    def energy(self, state: FloatArray) -> float:
        return float(0.5 * self.mass * (state[1] ** 2).sum() + 0.5 * self.stiffness * (state[0] ** 2).sum())

    def propagator(self, step: float) -> tuple[FloatArray, FloatArray]:
        """A step under a held force: state -> M state + b force."""
        rates = np.array([[0, 1, 0], [-self.stiffness / self.mass, -self.damping / self.mass, 1 / self.mass], [0, 0, 0]])
        whole = expm(rates * step)
        return whole[:2, :2], whole[:2, 2]


@dataclass(frozen=True)
class CouplingRun:
    """What a coupled run gives at the communication points: times [s]; displacement [m] and mean force [N] in x and y, shape (n, 2); energy
    that the coupling has made up to there, and that the tool has taken [J]; the tool's energy [J]."""

    times: FloatArray
    displacement: FloatArray
    force: FloatArray
    made: FloatArray
    taken: FloatArray
    stored: FloatArray


def couple(
    step: float,
    end: float,
    *,
    averaging: str = "resolved",
    inputs: Inputs = "straight",
    force: Force = "mean",
    tool: Tool | None = None,
    values: Mapping[str, float | str] | None = None,
    on: Sequence[str] = (),
) -> CouplingRun:
    """Contact and tool in turns, from rest: the contact with what the tool does at the start of the step, then the tool with its force.

    inputs : what the contact is told: displacement and velocity as they stand, or going on straight (a derivative of the input in FMI 2).
    force : what the tool is told: the force at the end of the step, or its mean over the step.
    """
    tool = tool or Tool()
    contact = Contact({"kinematics": "combined", "averaging": averaging, **(values or {})}, on)
    contact.start()
    count = round(end / step)
    M, b = tool.propagator(step)
    state = np.zeros((2, 2))  # (displacement, velocity) x (x, y)
    names = ("tool_displacement_x", "tool_displacement_y", "tool_velocity_x", "tool_velocity_y")
    outputs = ("principal_impulse", "feed_impulse", "tool_force_x", "tool_force_y")
    impulse, acting = np.zeros(2), np.zeros(2)
    if averaging == "cycle" or force == "instant":  # else no mean is known yet
        acting = np.array([contact.get("tool_force_x"), contact.get("tool_force_y")])
    rows = np.zeros((count + 1, 7))
    for n in range(count):
        rates = np.concatenate((state[1], tool.acceleration(state, acting))) if inputs == "straight" else np.zeros(4)
        told = np.array([state.ravel(), state.ravel() + step * rates])
        outputs_at_end = contact.run(np.array([n, n + 1]) * step, dict(zip(names, told.T, strict=True)), outputs)[-1]
        gained, impulse = (outputs_at_end[:2] - impulse) / step, outputs_at_end[:2]
        acting = outputs_at_end[2:] if force == "instant" else np.array([-gained[0], gained[1]])
        told_velocity = told[:, 2:].mean(axis=0)
        after = M @ state + np.outer(b, acting)
        velocity = (after[0] - state[0]) / step
        state = after
        own = np.array([-gained[0], gained[1]])  # what the contact has exerted, whatever the tool was told of it
        bonds = [PowerBalance(own[k], told_velocity[k], acting[k], velocity[k]) for k in range(2)]
        rows[n + 1, :2], rows[n + 1, 2:4] = state[0], acting
        rows[n + 1, 4] = rows[n, 4] + sum(bond.residual(step) for bond in bonds)
        rows[n + 1, 5] = rows[n, 5] + sum(bond.taken(step) for bond in bonds)
        rows[n + 1, 6] = tool.energy(state)
    return CouplingRun(np.arange(count + 1, dtype=np.float64) * step, rows[:, :2], rows[:, 2:4], rows[:, 4], rows[:, 5], rows[:, 6])


WAYS: Mapping[str, Mapping[str, str]] = {
    "force of an instant, motion held": {"inputs": "held", "force": "instant"},
    "mean force, motion held": {"inputs": "held"},
    "mean force, motion straight on": {"inputs": "straight"},
    "averaging = cycle, motion held": {"averaging": "cycle", "inputs": "held"},
    "averaging = cycle, motion straight on": {"averaging": "cycle", "inputs": "straight"},
}


@dataclass(frozen=True)
class Study:
    """By way of coupling, over the steps [s]: largest error of the displacement over its largest value; energy that the interface has made
    or lost, all steps but the first (which does not know the tool's acceleration) added up, over the most that the tool has held."""

    steps: Sequence[float]
    error: Mapping[str, FloatArray]
    made: Mapping[str, FloatArray]


def study(steps: Sequence[float], end: float = 0.02, values: Mapping[str, float | str] | None = None) -> Study:
    """Every way of coupling with every step, against steps of 2 us. The steps must be whole multiples of that."""
    values = {"cutting_speed": 0.3, "feed": 2e-5, **(values or {})}
    fine = couple(FINE, end, values=values)
    error: dict[str, FloatArray] = {}
    made: dict[str, FloatArray] = {}
    for way, how in WAYS.items():
        runs = [couple(step, end, values=values, **how) for step in steps]  # type: ignore[arg-type]
        every = [round(step / FINE) for step in steps]
        largest = np.abs(fine.displacement).max()
        error[way] = (
            np.array([np.abs(run.displacement - fine.displacement[::n]).max() for run, n in zip(runs, every, strict=True)]) / largest
        )
        made[way] = np.array([np.abs(np.diff(run.made[1:])).sum() for run in runs]) / fine.stored.max()
    return Study(steps, error, made)
