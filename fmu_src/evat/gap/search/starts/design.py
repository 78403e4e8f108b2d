"""At which shapes and amplitudes is an effect tried?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from evat.constants import CONSTANTS
from evat.inference.parameters import Parameter, amplitude_parameter, amplitudes
from evat.model import Effect, FloatArray, Variable


@dataclass(frozen=True)
class Design:
    """What of an effect is tried, and where.

    strengths : the amplitudes that do something in these records; unknown : the other parameters; points : of these, in their prior
    standard deviations (G, s); spreads : how large each amplitude is at each point where it does what is plausible (G,); sine : places of
    a frequency and a phase, where these are what is unknown: then points are pairs in quadrature; phases : of each frequency, those that
    conditions or trials have by themselves.
    """

    effect: Effect
    strengths: tuple[Variable, ...]
    unknown: tuple[Parameter, ...]
    points: FloatArray
    spreads: Mapping[str, FloatArray]
    sine: tuple[int, int] | None
    phases: Sequence[Mapping[str, float]]

    def repeated(self, times: int) -> Design:
        """Each point so many times in a row."""
        spreads = {name: np.repeat(spread, times) for name, spread in self.spreads.items()}
        return replace(self, points=np.repeat(self.points, times, axis=0), spreads=spreads)

    def few(self, count: int) -> Design:
        """With so many of its points, from the first to the last."""
        kept = np.linspace(0, len(self.points) - 1, count).round().astype(int)
        spreads = {name: spread[kept] for name, spread in self.spreads.items()}
        return replace(self, points=self.points[kept], spreads=spreads)

    def one_of_two(self, points: FloatArray) -> Design:
        """With one point, at the best phase, in the place of each pair in quadrature."""
        return replace(self, points=points, spreads={name: spread[::2] for name, spread in self.spreads.items()})

    def parameters(self, row: int) -> tuple[Parameter, ...]:
        """Amplitudes and what else is unknown, with the priors at a point."""
        return (*(amplitude_parameter(own, float(self.spreads[own.name][row])) for own in self.strengths), *self.unknown)

    def fixed(self, row: int) -> Mapping[str, float]:
        return self.phases[row] if self.phases else {}

    def cost(self, row: int) -> float:
        """In log evidence, of the values that conditions or trials have by themselves."""
        return CONSTANTS.cost_of_own_value * len(set(self.phases[row].values())) if self.phases else 0.0


def neutral_values(effect: Effect) -> dict[str, float]:
    """Of its amplitudes: it does nothing there."""
    return {variable.name: variable.neutral for variable in amplitudes(effect)}


def points_over(unknown: Sequence[Parameter]) -> FloatArray:
    """Points (G, s) over the prior of the shapes, in its standard deviations. In the order of the first shape: neighbours run side by side,
    and a block takes as long as its slowest."""
    if not unknown:
        return np.zeros((1, 0))
    if len(unknown) == 1:
        reach = CONSTANTS.shape_range[0]
        return np.linspace(-reach, reach, CONSTANTS.shape_values)[:, None]
    reach = CONSTANTS.shape_range[1]
    points: FloatArray = qmc.Sobol(len(unknown), scramble=False).random(CONSTANTS.shape_points) * (2 * reach) - reach
    return points[np.argsort(points[:, 0])]
