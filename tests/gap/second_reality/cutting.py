"""How does an elliptically vibrating tool cut in the second reality? Path, chip, and the forces of an ideal or a real edge.

Ideal: Merchant's thin shear plane with either principle for its angle. Real: a ploughing edge (Waldorf 1999: forces that rise with the
thickness until the edge radius is filled), a shear zone (Oxley 1989: stress by strain rate and heat, both of the thickness), and an entry
that takes some thickness before the chip carries (smooth_entry).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .drive import Array, Channels, Drive

if TYPE_CHECKING:
    from .base_laws import Contact, Law

PHASE_X, PHASE_Y = -np.pi / 2, np.pi  # the bottom of the path at time 0
TABLE = 4001


@dataclass(frozen=True)
class Path:
    """x = v_c t + a sin(w t), y = -b cos(w t + delta), and what disturbs them. surface: rise of the nominal surface over time [m]."""

    cutting_speed: float
    feed: float
    amplitude_x: float
    amplitude_y: float
    frequency: float
    rake: float
    flow: float
    begin: float
    cycles: float
    per: int
    delta: float = 0.0
    grown_x: float = 1.0
    grown_y: float = 1.0
    third: float = 0.0
    believed_y: float = 0.0

    def place(self, t: Array) -> tuple[Array, Array]:
        w = 2 * np.pi * self.frequency
        b = self.amplitude_y * self.grown_y
        y = -b * np.cos(w * t + self.delta) + self.third * self.amplitude_y * np.cos(3 * w * t)
        return self.cutting_speed * t + self.amplitude_x * self.grown_x * np.sin(w * t), y

    def velocity(self, t: Array) -> tuple[Array, Array]:
        w = 2 * np.pi * self.frequency
        b = self.amplitude_y * self.grown_y
        u_y = w * b * np.sin(w * t + self.delta) - 3 * w * self.third * self.amplitude_y * np.sin(3 * w * t)
        return self.cutting_speed + w * self.amplitude_x * self.grown_x * np.cos(w * t), u_y

    def thickness(self, t: Array) -> Array:
        """Over the nominal surface or what the cycle before has left, whichever is lower."""
        f, w = self.frequency, 2 * np.pi * self.frequency
        x, y = self.place(t)
        top = np.full_like(t, self.feed - self.amplitude_y)
        ratio = min(self.cutting_speed / (self.amplitude_x * self.grown_x * w), 1.0)
        end = np.arccos(-ratio)
        way = end * np.sin(np.linspace(-np.pi / 2, np.pi / 2, TABLE)) / w
        reach, height = self.place(way)
        reach = np.maximum.accumulate(reach)
        local = x - self.cutting_speed * np.floor(f * t + 0.5) / f + self.cutting_speed / f
        left = np.interp(local, reach, height)
        return np.asarray(np.where(local < reach[-1], np.minimum(top, left), top) - y)


def drive_of(paths: list[Path], every: int, values: tuple[dict[str, float], ...], theta: Array | None = None) -> Drive:
    """The lanes of these paths, each with one cycle before its record begins. theta: one proxy for each lane."""
    h = 1 / (paths[0].frequency * paths[0].per * every)
    first = paths[0].per * every
    count = np.array([round(p.cycles * p.per) + 1 for p in paths])
    rows = first + int(np.max(count) - 1) * every + 1
    t = np.stack([p.begin + (np.arange(rows) - first) * h for p in paths], axis=1)
    v, x, thick, approach, u_y = (np.empty_like(t) for _ in range(5))
    for lane, p in enumerate(paths):
        u_x, u_y[:, lane] = p.velocity(t[:, lane])
        thick[:, lane] = p.thickness(t[:, lane])
        approach[:, lane] = u_x * np.cos(p.rake) + u_y[:, lane] * np.sin(p.rake)
        v[:, lane] = approach[:, lane] * np.tan(p.flow - p.rake) + u_x * np.sin(p.rake) - u_y[:, lane] * np.cos(p.rake)
        x[:, lane] = np.cumsum(v[:, lane]) * h
    given = None if theta is None else np.broadcast_to(theta, t.shape).copy()
    return Drive(
        h, t, v, x, first, every, count, theta=given, thickness=thick, approach=approach, u_y=u_y, held=held_of(thick, approach),
        values=values, path=tuple(paths),
    )  # fmt: skip


def held_of(thickness: Array, approach: Array) -> Array:
    """Share of the step before each row in which there is contact, 0 where there is none at the row."""
    now, share = (thickness > 0) & (approach > 0), np.ones_like(thickness)
    for gate in (thickness, approach):
        entered = np.zeros_like(now)
        entered[1:] = (gate[1:] > 0) & (gate[:-1] <= 0)
        part = np.ones_like(gate)
        part[1:] = gate[1:] / np.where(entered[1:], gate[1:] - gate[:-1], 1.0)
        share = np.where(entered, np.minimum(share, np.clip(part, 1e-6, 1 - 1e-9)), share)
    return share * now


def cycle_weights(drive: Drive) -> Array:
    """Share of a step for which each row's force stands in a mean; of steps in which contact begins or ends, the part in contact."""
    held = np.asarray(drive.held)
    on, leaving = held > 0, np.ones_like(held)
    for gate in (np.asarray(drive.thickness), np.asarray(drive.approach)):
        past = gate[1:] <= 0
        left = np.where(past, gate[:-1] / np.where(past, gate[:-1] - gate[1:], 1.0), 1.0)
        leaving[:-1] = np.minimum(leaving[:-1], np.clip(left, 0.0, 1.0))
    before, behind = np.zeros_like(held), np.zeros_like(held)
    before[1:] = np.where(on[:-1], 0.5, held[1:])
    behind[:-1] = np.where(on[1:], 0.5, leaving[:-1])
    return np.asarray((before + behind) * on)


def walked(drive: Drive, **changed: float | Array) -> Drive:
    """The same lanes on disturbed paths; a change is one number for all lanes or one for each."""
    paths = [
        replace(p, **{name: float(np.broadcast_to(value, drive.lanes)[lane]) for name, value in changed.items()})
        for lane, p in enumerate(drive.path)
    ]
    drive_along = drive_of(paths, drive.every, tuple(dict(v) for v in drive.values))
    return replace(drive_along, theta=drive.theta, load=drive.load)


def chip_stress(d: Drive, tau: Array, cut: Law) -> Array:
    """Shear stress of the chip."""
    h = np.maximum(d.thickness, 0.0) if d.thickness is not None else np.zeros_like(tau)
    if cut.name == "smooth_entry":
        return tau * -np.expm1(-h / max(cut.share * cut.form["onset"], 1e-12))
    if cut.name == "shear_zone":
        typical, speed = cut.form["typical_h"], np.abs(d.approach) + 1e-9
        rate = np.clip(speed / cut.form["speed"] / np.maximum(h / typical, 0.02), 1e-3, 1e3)
        heat = np.sqrt(np.clip(speed / cut.form["speed"] * h / typical, 0.0, 25.0))
        return tau * (1 + cut.share * cut.form["rate"] * np.log(rate)) / (1 + cut.share * cut.form["heat"] * heat)
    return tau


def plough(c: Contact, F: Array, cut: Law, width: float) -> Array:
    """What a round edge adds, into the contact's edge forces; and how an entry that is not sharp takes friction away."""
    d = c.drive
    assert d.thickness is not None
    h = np.maximum(d.thickness, 0.0)
    if cut.name == "ploughing" and c.edge_p is not None and c.edge_f is not None and d.held is not None:
        rise = -np.expm1(-h / cut.form["radius"]) * (d.held > 0) * cut.share * width
        c.edge_p += cut.form["principal"] * rise
        c.edge_f += cut.form["feed"] * rise
    if cut.name == "smooth_entry":
        return F * -np.expm1(-h / max(cut.share * cut.form["onset"], 1e-12))
    return F


def normal_force(F: Array, k: Array, rake: float, principle: str) -> Array:
    """Normal force on the rake by the resultant's angle; never a pull."""
    if principle == "maximum_shear_stress":
        s = np.pi / 4 + rake
        return np.maximum((np.sqrt(2) * k + F * np.cos(s)) / np.sin(s), 0.0)
    c, s = np.cos(rake), np.sin(rake)
    return np.maximum((2 * np.sqrt(np.maximum(k * (k + F * c), 0.0)) - (2 * k + F * c) * s) / c**2, 0.0)


def chip_forces(F: Array, k: Array, c: Contact, rake: float, principle: str) -> Channels:
    N = normal_force(F, k, rake, principle)
    edge_p = 0.0 if c.edge_p is None else c.edge_p
    edge_f = 0.0 if c.edge_f is None else c.edge_f
    return {
        "principal_force": N * np.cos(rake) + F * np.sin(rake) + edge_p,
        "feed_force": F * np.cos(rake) - N * np.sin(rake) + edge_f,
    }


def drawn_cut(name: str, rng: np.random.Generator, shear: float, width: float, feed: float, speed: float) -> dict[str, float]:
    """The numbers of an edge. shear: force of the shear plane at `feed` [N]."""
    u = rng.uniform
    if name == "ploughing":
        return {"radius": feed * u(0.1, 0.6), "principal": shear / width * u(0.05, 0.2), "feed": shear / width * u(0.1, 0.4)}
    if name == "shear_zone":
        return {"rate": u(0.02, 0.06), "heat": u(0.05, 0.25), "typical_h": feed, "speed": speed}
    if name == "smooth_entry":
        return {"onset": feed * u(0.03, 0.15)}
    return {}
