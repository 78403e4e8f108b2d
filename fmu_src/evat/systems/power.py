"""Does the coupling invent energy? The power balance at every bond, and the step that would keep it small.

A force F goes one way through a bond, a velocity v the other. Over a step the side that shows F has seen another v than the other side has
shown, and the other way round; what the two sides take to have passed differs by the energy that the coupling has made or lost.
Sadjina et al. 2017, Energy conservation and power bonds in co-simulations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evat.model import FloatArray
from evat.systems.model import Port, System

ALLOWED = 0.01  # share of the energy that passes


@dataclass(slots=True)
class _Bond:
    name: str
    force: int
    velocity: int
    received: tuple[float, float] = (0.0, 0.0)  # velocity that the force's side received at the end, force that the other side received
    sent: tuple[float, float] = (0.0, 0.0)  # force and velocity that both sent at the end
    passed: float = 0.0
    made: float = 0.0
    moved: float = 0.0


def _work(force: tuple[float, float], velocity: tuple[float, float]) -> float:
    """Over a step of 1 s in which both are linear."""
    (f_0, f_1), (v_0, v_1) = force, velocity
    return (2 * f_0 * v_0 + f_0 * v_1 + f_1 * v_0 + 2 * f_1 * v_1) / 6


class Power:
    """Keeps the balance while a system runs."""

    def __init__(self, system: System, signals: Mapping[Port, int]) -> None:
        self._bonds = [_Bond(".".join(bond.force), signals[bond.force], signals[bond.velocity]) for bond in system.bonds]
        self._sides: list[tuple[_Bond, str, str, int | None, int | None]] = []
        for bond, kept in zip(system.bonds, self._bonds, strict=True):
            inputs = {name: [at for to, at in system.connections.items() if to[0] == name] for name in system.components}
            force_side, velocity_side = bond.force[0], bond.velocity[0]
            sees_v, sees_f = inputs[force_side], inputs[velocity_side]
            place_v = sees_v.index(bond.velocity) if bond.velocity in sees_v else None
            place_f = sees_f.index(bond.force) if bond.force in sees_f else None
            self._sides.append((kept, force_side, velocity_side, place_v, place_f))
        self._start = np.zeros(len(signals))

    def open(self, signals: FloatArray) -> None:
        """A step begins at these signals."""
        if self._bonds:
            self._start = signals.copy()

    def moved(self, member: str, ahead: FloatArray, signals: FloatArray) -> None:
        """A member has moved: what it saw at the end of the step, and what it shows there."""
        for bond, force_side, velocity_side, place_v, place_f in self._sides:
            if member == force_side:
                seen = float(ahead[place_v]) if place_v is not None else float(signals[bond.velocity])
                bond.received, bond.sent = (seen, bond.received[1]), (float(signals[bond.force]), bond.sent[1])
            if member == velocity_side:
                seen = float(ahead[place_f]) if place_f is not None else float(signals[bond.force])
                bond.received, bond.sent = (bond.received[0], seen), (bond.sent[0], float(signals[bond.velocity]))

    def close(self, step: float) -> None:
        """The step is over."""
        for bond in self._bonds:
            f_0, v_0 = float(self._start[bond.force]), float(self._start[bond.velocity])
            one = _work((f_0, bond.sent[0]), (v_0, bond.received[0])) * step
            other = _work((f_0, bond.received[1]), (v_0, bond.sent[1])) * step
            bond.made += other - one
            bond.moved += abs(other - one)
            bond.passed += abs(other)

    def shares(self) -> dict[str, tuple[float, float, float]]:
        """For each bond: energy that passed [J], energy that the coupling made [J], and the sum of what each step made or lost [J]."""
        return {bond.name: (bond.passed, bond.made, bond.moved) for bond in self._bonds}

    def advice(self, step: float, order: int) -> tuple[str, ...]:
        """One line for each bond: the balance, and what step would keep it within what is allowed.

        order : of the coupling, 2 with inputs that are continued along their slope, 1 with constant ones.
        """
        lines = []
        for name, (passed, made, moved) in self.shares().items():
            share = moved / passed if passed > 0 else 0.0
            text = (
                f"power at {name}: {passed:.3g} J passed, the coupling made {made:.2g} J ({100 * share:.2g} % of it counted step by step)"
            )
            if share > ALLOWED:
                text += f"; take steps of {step * (ALLOWED / share) ** (1 / order):.2g} s to stay below {100 * ALLOWED:g} %"
            lines.append(text)
        return tuple(lines)
