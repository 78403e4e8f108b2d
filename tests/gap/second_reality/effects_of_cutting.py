"""How may a cut differ from what its owner believes? Effects that the library names, in laws of other form than the library's."""

from __future__ import annotations

import numpy as np

from .base_laws import Contact
from .cutting import walked
from .drive import Array, Drive
from .effects_of_friction import Draw, form
from .world import Effect, World


def _thick(c: Contact, world: World) -> Array:
    """Thickness over the nominal feed, not below a hundredth."""
    assert c.drive.thickness is not None
    return np.maximum(c.drive.thickness / float(world.exact["feed"]), 0.01)


def _stressed(c: Contact, factor: Array) -> None:
    assert c.tau is not None
    c.tau *= np.maximum(factor, 0.02)


def _edge(c: Contact, principal: Array | float, feed: Array | float) -> None:
    on = np.asarray(c.drive.held) > 0
    c.edge_p += principal * on
    c.edge_f += feed * on


@form("size_effect", "strain_gradient")
def _(world: World, rng: Draw) -> Effect:
    """Joshi and Melkote 2004: sqrt(1 + length/h)."""
    return Effect("size_effect", "strain_gradient", 0.3, 20.0, contact=lambda c, s: _stressed(c, np.sqrt(1 + s / _thick(c, world))))


@form("size_effect", "logarithm")
def _(world: World, rng: Draw) -> Effect:
    return Effect("size_effect", "logarithm", 0.15, 3.0, contact=lambda c, s: _stressed(c, 1 + s * np.log1p(0.6 / _thick(c, world))))


def _heat(world: World, d: Drive) -> Array:
    """Temperature proxy over its reference."""
    theta = d.theta if d.theta is not None else np.abs(d.v)
    return np.asarray(theta / float(world.exact["theta_ref"]))


@form("flow_stress_softening", "zerilli_armstrong")
def _(world: World, rng: Draw) -> Effect:
    return Effect(
        "flow_stress_softening", "zerilli_armstrong", 0.15, 2.0, contact=lambda c, s: _stressed(c, np.exp(-s * _heat(world, c.drive)))
    )


@form("flow_stress_softening", "logistic")
def _(world: World, rng: Draw) -> Effect:
    at, wide = float(rng.uniform(0.6, 1.4)), float(rng.uniform(0.4, 0.9))
    return Effect(
        "flow_stress_softening", "logistic", 0.3, 0.95,
        contact=lambda c, s: _stressed(c, 1 - s / (1 + np.exp(-(_heat(world, c.drive) - at) / wide))),
    )  # fmt: skip


@form("edge_force", "filling")
def _(world: World, rng: Draw) -> Effect:
    """The edge is loaded fully once some of the thickness is there."""
    full, lean, unit = float(rng.uniform(0.02, 0.08)), float(rng.uniform(0.2, 0.8)), float(world.notes["shear"])

    def act(c: Contact, s: float) -> None:
        rise = -np.expm1(-_thick(c, world) / full)
        _edge(c, lean * s * unit * rise, s * unit * rise)

    return Effect("edge_force", "filling", 0.1, 1.5, contact=act)


@form("edge_force", "with_speed")
def _(world: World, rng: Draw) -> Effect:
    """A wear land whose friction falls a little with speed."""
    lean, fall, unit = float(rng.uniform(0.2, 0.8)), float(rng.uniform(0.05, 0.2)), float(world.notes["shear"])

    def act(c: Contact, s: float) -> None:
        assert c.drive.approach is not None
        u = np.abs(c.drive.approach) / float(world.notes["fast"])
        _edge(c, lean * s * unit * (1 - fall * u / (1 + u)), s * unit)

    return Effect("edge_force", "with_speed", 0.1, 1.5, contact=act)


def _into(c: Contact, world: World) -> Array:
    assert c.drive.u_y is not None
    return np.maximum(-c.drive.u_y, 0.0) / float(world.notes["fast"])


@form("process_damping", "by_slope")
def _(world: World, rng: Draw) -> Effect:
    """Wu 1989: by the volume that the flank displaces, so by the slope of the path, which ends at the clearance."""
    unit, most = float(world.notes["shear"]), float(rng.uniform(1.0, 2.5))

    def act(c: Contact, s: float) -> None:
        assert c.drive.approach is not None
        slope = _into(c, world) * float(world.notes["fast"]) / np.maximum(c.drive.approach, 1e-3 * float(world.notes["fast"]))
        _edge(c, 0.2 * s * unit * most * np.tanh(slope / most), s * unit * most * np.tanh(slope / most))

    return Effect("process_damping", "by_slope", 0.1, 3.0, contact=act)


@form("process_damping", "quadratic")
def _(world: World, rng: Draw) -> Effect:
    unit = float(world.notes["shear"])
    return Effect(
        "process_damping", "quadratic", 0.2, 6.0,
        contact=lambda c, s: _edge(c, 0.0, s * unit * _into(c, world) * (0.3 + 0.7 * _into(c, world))),
    )  # fmt: skip


@form("minimum_chip_thickness", "smooth")
def _(world: World, rng: Draw) -> Effect:
    """Below a thickness (share of the feed) nothing is sheared, and an elastic indentation pushes."""
    push, unit = float(rng.uniform(0.2, 0.6)), float(world.notes["shear"])

    def act(c: Contact, s: float) -> None:
        h = _thick(c, world)
        cut = 1 / (1 + np.exp(-(h - s) / (0.15 * s + 1e-9)))
        _stressed(c, cut)
        _edge(c, 0.3 * push * unit * np.minimum(h, s), push * unit * np.minimum(h, s))

    return Effect("minimum_chip_thickness", "smooth", 0.1, 0.7, contact=act)


@form("minimum_chip_thickness", "abrupt")
def _(world: World, rng: Draw) -> Effect:
    push, unit = float(rng.uniform(0.3, 0.9)), float(world.notes["shear"])

    def act(c: Contact, s: float) -> None:
        h = _thick(c, world)
        below = h < s
        _stressed(c, np.where(below, 0.1, 1.0))
        _edge(c, 0.0, push * unit * np.where(below, h, 0.3 * s))

    return Effect("minimum_chip_thickness", "abrupt", 0.1, 0.7, contact=act)


@form("ellipse_phase_error", "with_smaller_amplitude")
def _(world: World, rng: Draw) -> Effect:
    less = float(rng.uniform(0.0, 0.15))
    return Effect(
        "ellipse_phase_error", "with_smaller_amplitude", 0.08, 0.6, both_ways=True,
        motion=lambda world, d, s: walked(d, delta=s, grown_y=1 - less * abs(s)),
    )  # fmt: skip


@form("ellipse_phase_error", "with_third_harmonic")
def _(world: World, rng: Draw) -> Effect:
    third = float(rng.uniform(-0.08, 0.08))
    return Effect(
        "ellipse_phase_error",
        "with_third_harmonic",
        0.08,
        0.6,
        both_ways=True,
        motion=lambda world, d, s: walked(d, delta=s, third=third * s),
    )


def _felt(world: World, d: Drive) -> Array:
    """Mean principal force of each lane."""
    forces = world.respond(d, [world.params])[0]
    name = next(n for n in forces if n.endswith("principal_force"))
    return np.asarray(np.mean(forces[name][d.first :], axis=0))


def _loaded(d: Drive, world: World, s: float, law: str, less: float) -> Drive:
    now, unit = d, max(float(np.mean(_felt(world, d))), 1e-9)
    for _ in range(3):
        load = np.maximum(_felt(world, now), 0.0) / unit
        grown = 1 / (1 + s * load) if law == "hyperbola" else 1 - s * np.minimum(load, 0.9 / s) ** 1.5 / (1 + s * load)
        grown = np.maximum(grown, 0.3)
        now = walked(d, grown_y=grown, grown_x=1 - less * (1 - grown))
    return now


@form("amplitude_loss", "hyperbola")
def _(world: World, rng: Draw) -> Effect:
    less = float(rng.uniform(0.7, 1.0))
    return Effect("amplitude_loss", "hyperbola", 0.08, 0.5, motion=lambda world, d, s: _loaded(d, world, s, "hyperbola", less))


@form("amplitude_loss", "progressive")
def _(world: World, rng: Draw) -> Effect:
    less = float(rng.uniform(0.7, 1.0))
    return Effect("amplitude_loss", "progressive", 0.08, 0.5, motion=lambda world, d, s: _loaded(d, world, s, "progressive", less))


@form("sticking_limit", "smooth")
def _(world: World, rng: Draw) -> Effect:
    """Friction cannot exceed what the chip's root can carry (Zorev 1963), approached smoothly; s = 1: at the usual shear force."""
    sharp, unit = float(rng.uniform(2.0, 5.0)), float(world.notes["shear"])

    def act(c: Contact, s: float) -> None:
        limit = unit / max(s, 1e-9) * np.minimum(_thick(c, world) + 0.3, 3.0)
        full = np.maximum(c.F_C, 1e-12) * c.strength
        c.strength *= (1 + (full / limit) ** sharp) ** (-1 / sharp)

    return Effect("sticking_limit", "smooth", 0.5, 20.0, contact=act)


@form("sticking_limit", "with_length")
def _(world: World, rng: Draw) -> Effect:
    """The length of contact grows with the square root of the thickness."""
    unit = float(world.notes["shear"])

    def act(c: Contact, s: float) -> None:
        limit = unit / max(s, 1e-9) * np.sqrt(_thick(c, world))
        c.strength *= np.minimum(1.0, limit / (c.F_C * c.strength))

    return Effect("sticking_limit", "with_length", 0.5, 20.0, contact=act)
