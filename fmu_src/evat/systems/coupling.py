"""Does an interface between two simulators make energy, and how long may the next communication step be?

Two sides exchange a force for a velocity. In a step each computes with what the other has said, held or extrapolated, and that is not what
the other does meanwhile: the power that one gives differs from the power that the other takes. The difference over a step is energy from
nowhere, known without a second run of the step, and a measure of the coupling's error. Sadjina, Kyllingstad, Skjong and Pedersen 2017,
Energy conservation and power bonds in co-simulations; the control of the step: Gustafsson, Lundh and Soderlind 1988.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from evat.model import ParameterError

SAFETY = 0.9
SHRINK, GROW = 0.2, 2.0  # how far a step may change at once


@dataclass(frozen=True)
class PowerBalance:
    """One direction of an interface over one step: mean force [N] and mean velocity [m/s] as one side had them, and as the other had.

    How force and velocity go together within the step is left out, a term of the square of the step. Signs: the force that the first
    exerts on the second, the velocity of the point that they share. Torque and angular velocity do as well.
    """

    force: float
    velocity: float
    other_force: float
    other_velocity: float

    def given(self, step: float) -> float:
        """Energy that the first side gave in a step of so many seconds [J]."""
        return step * self.force * self.velocity

    def taken(self, step: float) -> float:
        """Energy that the other side took [J]."""
        return step * self.other_force * self.other_velocity

    def residual(self, step: float) -> float:
        """Energy that the coupling has made: what was taken beyond what was given [J]."""
        return self.taken(step) - self.given(step)


@dataclass(frozen=True)
class StepAdvice:
    """What the energy of a step says: its residual [J], how far that is from the tolerance (1: just right), the next step [s]."""

    residual: float
    error: float
    next_step: float

    @property
    def accept(self) -> bool:
        """Was the step good enough? Who cannot go back goes on with the shorter step all the same."""
        return self.error <= 1


def advise(
    step: float,
    bonds: Sequence[PowerBalance],
    *,
    stored: float,
    tolerance: float = 1e-3,
    order: int = 1,
    error_before: float = 1.0,
    shortest: float = 0.0,
    longest: float = math.inf,
) -> StepAdvice:
    """The next communication step from the power balance of this one.

    Parameters
    ----------
    step : the step that was made [s].
    bonds : every direction of the interface, over that step.
    stored : energy that the residual is weighed against, such as the kinetic and elastic energy of the machine at its usual amplitude [J].
    tolerance : residual allowed in a step, as a share of `stored` and of what crossed the interface.
    order : of the extrapolation of the inputs: 0 held, 1 straight.
    error_before : `error` of the step before, for a step that does not hunt.
    shortest, longest : bounds of the next step [s].
    """
    numbers = {"step": step, "stored": stored, "tolerance": tolerance, "error_before": error_before}
    for name, number in numbers.items():
        if not (number > 0 and math.isfinite(number)) and not (name == "stored" and number == 0):
            raise ParameterError(f"{name} = {number}: a finite number above 0 is needed.")
    if order < 0 or not 0 <= shortest <= longest:
        raise ParameterError(
            f"order = {order}, steps from {shortest} to {longest} s: order and bounds of at least 0 in rising order are needed."
        )
    residual = sum(bond.residual(step) for bond in bonds)
    crossed = sum(max(abs(bond.given(step)), abs(bond.taken(step))) for bond in bonds)
    worst = sum(abs(bond.residual(step)) for bond in bonds)  # directions must not make up for each other
    if not math.isfinite(worst + crossed):
        raise ParameterError("a force or velocity at the interface is not a finite number.")
    allowed = tolerance * (stored + crossed)
    error = worst / allowed if allowed > 0 else 0.0  # nothing stored and nothing crossed: nothing made
    power = order + 2  # the residual of a step with inputs of this order grows with this power of it
    small = max(error, 1e-12)
    factor = SAFETY * small ** (-0.7 / power) * max(error_before, 1e-12) ** (0.4 / power)
    return StepAdvice(residual, error, min(max(step * min(max(factor, SHRINK), GROW), shortest), longest))
