"""Does the coupling invent energy? The power balance at every bond, and the step that would keep it small.

A force F goes one way through a bond, a velocity v the other. Over a step the side that shows F has seen another v than the other side has
shown, and the other way round; what the two sides take to have passed differs by the energy that the coupling has made or lost.
Sadjina et al. 2017, Energy conservation and power bonds in co-simulations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

ALLOWED = 0.01  # share of the energy that passes


@dataclass(frozen=True, slots=True)
class Power:
    """The balance of a run, kept in its steps (fmu_src/coupling/coupling.c)."""

    bonds: Mapping[str, tuple[float, float, float]]

    def shares(self) -> Mapping[str, tuple[float, float, float]]:
        """For each bond: energy that passed [J], energy that the coupling made [J], and the sum of what each step made or lost [J]."""
        return self.bonds

    def advice(self, step: float, order: int) -> tuple[str, ...]:
        """One line for each bond: the balance, and what step would keep it within what is allowed.

        order : of the coupling, 2 with inputs that are continued along their slope, 1 with constant ones.
        """
        lines = []
        for name, (passed, made, moved) in self.shares().items():
            share = moved / passed if passed > 0 else 0.0
            text = (
                f"energy through {name}: {passed:.3g} J, of which the coupling made {made:.2g} J (step by step {100 * share:.3g} % of it)"
            )
            if share > ALLOWED:
                text += f"; take steps of {step * (ALLOWED / share) ** (1 / order):.2g} s to stay below {100 * ALLOWED:g} %"
            lines.append(text)
        return tuple(lines)
