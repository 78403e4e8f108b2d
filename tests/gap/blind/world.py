"""What would ideal sensors and real ones show in every condition of a case? A case's contact, with and without the causes of a gap."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from law import Fields, Form, Values, chip_forces, friction, open_fields
from radau import Array
from scene import Scene
from scipy.integrate import trapezoid

Channels = dict[str, Array]


@dataclass(frozen=True)
class Cause:
    """One cause of a gap. Its strength is one number, 0 for none. `least` and `most` bound it; both_ways: it may also be negative.

    Exactly one of the four acts: path makes another scene, temperature and fields act upon the law's fields, sensor on the channels
    (on the fine grid).
    """

    name: str
    typical: float
    most: float
    shape: Mapping[str, float | str] = field(default_factory=dict)
    both_ways: bool = False
    least: float = 0.0
    path: Callable[[World, Scene, float], Scene] | None = None
    temperature: Callable[[Fields, float], None] | None = None
    fields: Callable[[Fields, float], None] | None = None
    sensor: Callable[[Channels, Scene, float], None] | None = None


Acting = Sequence[tuple[Cause, float]]


@dataclass(frozen=True)
class World:
    """values: the truth of the base law's parameters; nominal_effects: what the nominal model has already, with its values."""

    kind: str
    scenes: tuple[Scene, ...]
    channels: tuple[str, ...]
    values: Values
    form: Form
    principle: str = "maximum_shear_stress"
    nominal_effects: tuple[str, ...] = ()
    means: bool = False
    excitation: tuple[float, ...] = ()  # [Hz] per condition, 0: none

    def respond(self, values: Values | None = None, causes: Acting = (), form: Form | None = None) -> list[Channels]:
        """Noise-free samples of each channel in each condition."""
        return [self.respond_in(scene, values or self.values, causes, form or self.form) for scene in self.scenes]

    def respond_in(self, scene: Scene, values: Values, causes: Acting, form: Form) -> Channels:
        for cause, strength in causes:
            if cause.path:
                scene = cause.path(replace(self, values=values, form=form), scene, strength)
        forces = self.forces(scene, values, causes, form)
        for cause, strength in causes:
            if cause.sensor:
                cause.sensor(forces, scene, strength)
        if self.means:
            return {name: np.array([self.mean(scene, forces[name.removeprefix("mean_")])]) for name in self.channels}
        return {name: scene.sampled(forces[name]) for name in self.channels}

    def forces(self, scene: Scene, values: Values, causes: Acting, form: Form) -> Channels:
        """The contact's own forces on the fine grid."""
        x = open_fields(scene, {**values, **scene.values})
        for stage in ("temperature", "fields"):
            for cause, strength in causes:
                act = getattr(cause, stage)
                if act:
                    act(x, strength)
            if stage == "temperature" and "thermal_softening" in self.nominal_effects:
                loss = values["thermal_softening.k_Q"] * (x.theta / values["theta_ref"]) ** values["thermal_softening.Q"]
                x.s0 = np.maximum(x.s0 - loss, 1e-3 * x.s0)
        F = friction(x, form)
        if "shear_stress" in values:
            return chip_forces(x, F, self.principle)
        return {"friction_force": F}

    @staticmethod
    def mean(scene: Scene, force: Array) -> float:
        """Over the last full vibration cycle of the scene."""
        return float(trapezoid(force, scene.grid) / (scene.grid[-1] - scene.grid[0]))
