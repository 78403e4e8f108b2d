"""What would ideal sensors show? A case's contact in every lane of a drive, with and without the effects that make the gap."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .base_laws import Contact, Law, friction
from .cutting import chip_forces, chip_stress, cycle_weights, plough
from .drive import Array, Channels, Drive

LUGRE = ("F_C", "F_S", "v_s", "sigma0", "sigma1", "sigma2")


@dataclass(frozen=True)
class Effect:
    """One cause of a gap in one form; its strength is a number, 0 for none. motion: another drive; contact: acts on the law's fields;
    sensor: changes the channels on the fine grid. both_ways: the strength may be negative; least: below it the grid is too coarse."""

    name: str
    form: str
    typical: float
    most: float
    both_ways: bool = False
    least: float = 0.0
    motion: Callable[[World, Drive, float], Drive] | None = None
    contact: Callable[[Contact, float], None] | None = None
    sensor: Callable[[Channels, Drive, float], None] | None = None


Acting = Sequence[tuple[Effect, float]]


@dataclass(frozen=True)
class World:
    """params: the truth of the base law; exact: what the owner knows to the last digit; sd: how well the rest is known (relative).

    conditions: one lane for each. trial: lanes for trials as they are run, from the conditions' places, how each trial is off, and by which
    factor an input or a value of the condition differs from that condition's.
    """

    kind: str
    channels: tuple[str, ...]
    law: Law
    cut: Law
    params: Mapping[str, float]
    exact: Mapping[str, float | str]
    sd: Mapping[str, float]
    conditions: Drive
    trial: Callable[..., Drive]
    frequency: tuple[float, ...]
    inputs: tuple[str, ...] = ()
    per_trial: tuple[str, ...] = ()
    nominal_effects: tuple[str, ...] = ()
    means: bool = False
    notes: Mapping[str, float] = field(default_factory=dict)

    @property
    def free(self) -> list[str]:
        """The parameters that a refit moves."""
        return [name for name, value in self.params.items() if self.sd.get(name, 0.0) > 0 and value > 0]

    def respond(self, drive: Drive, params: Sequence[Mapping[str, float]], acting: Acting = (), law: Law | None = None,
                cut: Law | None = None) -> list[Channels]:  # fmt: skip
        """For each set of parameters the channels on the fine grid (rows, lanes)."""
        for effect, s in acting:
            if effect.motion:
                drive = effect.motion(self, drive, s)
        wide, law, cut = drive.tiled(len(params)), law or self.law, cut or self.cut
        c = self.opened(wide, [p for p in params for _ in range(drive.lanes)], cut)
        for effect, s in acting:
            if effect.contact:
                effect.contact(c, s)
        forces = self.forces(c, friction(c, law), cut)
        for effect, s in acting:
            if effect.sensor:
                effect.sensor(forces, wide, s)
        n = drive.lanes
        return [{name: fine[:, k * n : (k + 1) * n] for name, fine in forces.items()} for k in range(len(params))]

    def opened(self, d: Drive, lanes: Sequence[Mapping[str, float]], cut: Law) -> Contact:
        """The law's fields before any effect."""

        def full(name: str, other: float = 0.0) -> Array:
            return np.broadcast_to(np.array([p.get(name, other) for p in lanes]), d.v.shape).copy()

        one = np.ones(d.v.shape)
        c = Contact(
            d, full("F_C"), full("F_S"), full("v_s"), full("sigma0"), full("sigma1"), full("sigma2"), one.copy(), one.copy(), 0.0 * one
        )
        if "thermal_softening" in self.nominal_effects and d.theta is not None:
            ratio = d.theta / float(self.exact["theta_ref"])
            c.soft -= full("thermal_softening.k_Q") / c.sigma0 * ratio ** float(self.exact["thermal_softening.Q"])
        if d.thickness is not None:
            c.tau, c.edge_p, c.edge_f = chip_stress(d, full("shear_stress"), cut), 0.0 * one, 0.0 * one
        return c

    def forces(self, c: Contact, F: Array, cut: Law) -> Channels:
        d = c.drive
        if d.thickness is None:
            return {"friction_force": F}
        F, width = plough(c, F, cut, float(self.exact["width"])), float(self.exact["width"])
        assert c.tau is not None
        k = c.tau * width * np.maximum(d.thickness, 0.0) * (d.held > 0)
        by_channel = chip_forces(F, k, c, float(self.exact["rake_angle"]), str(self.exact["shear_angle_principle"]))
        return {("mean_" if self.means else "") + name: fine for name, fine in by_channel.items()}

    def samples(self, forces: Channels, drive: Drive) -> list[Channels]:
        """Of each lane what is recorded: samples, or the mean over the record."""
        if self.means:
            rows = slice(drive.first, -1)
            weights = cycle_weights(drive)[rows]
            means = {n: np.sum(forces[n][rows] * weights, axis=0) / weights.shape[0] for n in self.channels}
            return [{n: means[n][i : i + 1] for n in self.channels} for i in range(drive.lanes)]
        return [{n: drive.sampled(forces[n], i) for n in self.channels} for i in range(drive.lanes)]

    def clean(self, params: Mapping[str, float] | None = None, acting: Acting = (), law: Law | None = None, cut: Law | None = None,
              drive: Drive | None = None) -> list[Channels]:  # fmt: skip
        """Noise-free records of every condition, or of the lanes of a drive."""
        d = drive or self.conditions
        return self.samples(self.respond(d, [params or self.params], acting, law, cut)[0], d)
