"""What work does a periodic slip do against friction, and how much of it do the bristles store?"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi

import numpy as np
from driving import OUTSIDE, slide

EFFECTS = ("thermal_softening", "thermal_damping")
TOLERANCE = 1e-8
ROUNDING = (10 * TOLERANCE) ** 0.6  # of the work that goes to and fro: what the steps may leave unexplained
SAMPLES, CYCLES = 96, 4


class Cycles:
    """A periodic slip velocity v(angle): work of each cycle, energy taken and energy stored at each sample, and what rounds them."""

    def __init__(self, v: Callable[[float], float], frequency: float, values: Mapping[str, float | str], on: tuple[str, ...]) -> None:
        turns = np.arange(SAMPLES * CYCLES + 1) / SAMPLES
        self.speed = np.array([v(2 * pi * turn) for turn in turns])
        names = ("dissipated_energy", "friction_force", "bristle_deflection", "theta_used")
        values = {**OUTSIDE, "relative_tolerance": TOLERANCE, **values}
        self.energy, self.F, self.z, theta = slide(turns / frequency, self.speed, values, *names, on=on).T
        self.work = np.diff(self.energy[::SAMPLES])
        self.to_and_fro = float(np.abs(self.F * self.speed).mean() * CYCLES / frequency)
        self.s0 = np.full(theta.shape, float(values["sigma0"]))
        if EFFECTS[0] in on:
            self.s0 -= values["thermal_softening.k_Q"] * (theta / values["theta_ref"]) ** values["thermal_softening.Q"]
        self.s0 = np.maximum(self.s0, 1e-3 * values["sigma0"])
        self.stored = 0.5 * self.s0 * self.z**2
        self.slack = ROUNDING * (self.to_and_fro + self.stored.max())
