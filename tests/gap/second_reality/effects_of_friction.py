"""How may friction differ from what its owner believes? Effects that the library names, each in laws of other form than the library's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .base_laws import Contact, contact_age
from .drive import Array, Drive, relaxed, shifted
from .world import Effect, World

Draw = np.random.Generator
Maker = Callable[[World, Draw], Effect]
FORMS: dict[str, dict[str, Maker]] = {}


def form(name: str, how: str) -> Callable[[Maker], Maker]:
    """Enters a maker of an effect's form; forms count in the order of entry, those at odd places are kept back."""

    def enter(make: Maker) -> Maker:
        FORMS.setdefault(name, {})[how] = make
        return make

    return enter


def _ratio(c: Contact, world: World) -> Array:
    """Temperature proxy over its reference."""
    theta = c.drive.theta if c.drive.theta is not None else np.abs(c.drive.v)
    return theta / float(world.exact["theta_ref"])


def _both_levels(c: Contact, factor: Array) -> None:
    c.strength *= np.maximum(factor, 0.05)


# temperature


@form("thermal_softening", "arrhenius")
def _(world: World, rng: Draw) -> Effect:
    cold = float(rng.uniform(1.0, 3.0))

    def act(c: Contact, s: float) -> None:
        c.soft *= np.exp(s * (1 / (1 + _ratio(c, world) / cold) - 1))

    return Effect("thermal_softening", "arrhenius", 0.4, 6.0, contact=act)


@form("thermal_softening", "tabulated")
def _(world: World, rng: Draw) -> Effect:
    at = np.array([0.0, 0.5, 1.0, 1.6, 2.4, 4.0])
    loss = np.cumsum(np.concatenate([[0.0], rng.uniform(0.05, 1.0, 5)]))
    loss /= loss[-1]
    return Effect(
        "thermal_softening", "tabulated", 0.3, 0.95,
        contact=lambda c, s: c.soft.__imul__(1 - s * np.interp(_ratio(c, world), at, loss)),
    )  # fmt: skip


@form("thermal_damping", "linear")
def _(world: World, rng: Draw) -> Effect:
    return Effect(
        "thermal_damping", "linear", 0.5, 3.0, contact=lambda c, s: c.sigma1.__imul__(np.maximum(1 + s * (_ratio(c, world) - 1), 0.02))
    )


@form("thermal_damping", "exponential")
def _(world: World, rng: Draw) -> Effect:
    return Effect("thermal_damping", "exponential", 0.5, 3.0, contact=lambda c, s: c.sigma1.__imul__(np.exp(s * (_ratio(c, world) - 1))))


@form("thermal_viscosity", "hyperbola")
def _(world: World, rng: Draw) -> Effect:
    return Effect("thermal_viscosity", "hyperbola", 0.5, 15.0, contact=lambda c, s: c.sigma2.__imul__(1 / (1 + s * _ratio(c, world))))


@form("thermal_viscosity", "vogel")
def _(world: World, rng: Draw) -> Effect:
    bend = float(rng.uniform(0.2, 0.6))

    def act(c: Contact, s: float) -> None:
        r = _ratio(c, world)
        c.sigma2 *= np.exp(-s * r / (1 + bend * r))

    return Effect("thermal_viscosity", "vogel", 0.4, 10.0, contact=act)


def _late_heat(world: World, late: Callable[[Array, float, float], Array]) -> Callable[[World, Drive, float], Drive]:
    def act(world: World, d: Drive, s: float) -> Drive:
        assert d.theta is not None
        span = float(np.max(d.t))
        return replace(d, theta=late(d.theta, max(s * span, 1e-3 * d.h), d.h))

    return act


@form("proxy_lag", "second_order")
def _(world: World, rng: Draw) -> Effect:
    return Effect(
        "proxy_lag", "second_order", 0.05, 1.0,
        motion=_late_heat(world, lambda theta, T, h: relaxed(relaxed(theta, 2 / T, h), 2 / T, h)),
    )  # fmt: skip


@form("proxy_lag", "diffusion")
def _(world: World, rng: Draw) -> Effect:
    """Heat that soaks into a body: three times in a row of thirds, as of a half-order lag."""

    def late(theta: Array, T: float, h: float) -> Array:
        return (relaxed(theta, 3 / T, h) + relaxed(theta, 1 / T, h) + relaxed(theta, 0.33 / T, h)) / 3

    return Effect("proxy_lag", "diffusion", 0.05, 1.0, motion=_late_heat(world, late))


# speed and direction


@form("direction_asymmetry", "smooth")
def _(world: World, rng: Draw) -> Effect:
    over = float(rng.uniform(0.02, 0.2))
    return Effect(
        "direction_asymmetry", "smooth", 0.08, 0.7, both_ways=True,
        contact=lambda c, s: _both_levels(c, 1 + s * np.tanh(c.drive.v / (over * c.v_s))),
    )  # fmt: skip


@form("direction_asymmetry", "sliding_only")
def _(world: World, rng: Draw) -> Effect:
    """The level of sliding differs more than that of breaking away."""
    static = float(rng.uniform(0.3, 0.7))

    def act(c: Contact, s: float) -> None:
        way = np.sign(c.drive.v)
        c.F_C *= 1 + s * way
        c.F_S *= 1 + static * s * way

    return Effect("direction_asymmetry", "sliding_only", 0.08, 0.7, both_ways=True, contact=act)


@form("viscous_friction", "drag")
def _(world: World, rng: Draw) -> Effect:
    power, fast = float(rng.uniform(1.1, 1.4)), float(world.notes["fast"])
    unit = world.params["F_C"]
    return Effect(
        "viscous_friction", "drag", 0.2, 3.0,
        contact=lambda c, s: c.added.__iadd__(
            s * unit * np.sign(c.drive.v) * (np.abs(c.drive.v) / fast) ** power * (1 if c.drive.held is None else c.drive.held > 0)
        ),
    )  # fmt: skip


@form("viscous_friction", "eyring")
def _(world: World, rng: Draw) -> Effect:
    bend, fast, unit = float(rng.uniform(0.5, 1.5)), float(world.notes["fast"]), world.params["F_C"]
    return Effect(
        "viscous_friction", "eyring", 0.2, 3.0,
        contact=lambda c, s: c.added.__iadd__(
            s * unit * np.arcsinh(bend * c.drive.v / fast) / bend * (1 if c.drive.held is None else c.drive.held > 0)
        ),
    )  # fmt: skip


@form("stribeck", "hyperbola")
def _(world: World, rng: Draw) -> Effect:
    power, scale = float(rng.uniform(1.2, 2.2)), float(rng.uniform(0.7, 1.6))
    return Effect(
        "stribeck", "hyperbola", 0.2, 1.5,
        contact=lambda c, s: _both_levels(c, 1 + s / (1 + (np.abs(c.drive.v) / (scale * c.v_s)) ** power)),
    )  # fmt: skip


@form("stribeck", "exponential")
def _(world: World, rng: Draw) -> Effect:
    scale = float(rng.uniform(0.6, 1.5))
    return Effect(
        "stribeck", "exponential", 0.2, 1.5, contact=lambda c, s: _both_levels(c, 1 + s * np.exp(-np.abs(c.drive.v) / (scale * c.v_s)))
    )


# load


def _pressed(c: Contact, world: World) -> Array:
    """Load over its mean; of a cut the thickness of the chip over its mean in contact."""
    d = c.drive
    if d.load is not None:
        return d.load / 10.0
    assert d.thickness is not None
    h = np.maximum(d.thickness, 0.0)
    return np.asarray(h / (float(world.exact["feed"]) * 0.6))


@form("load_dependence", "adhesion_and_amontons")
def _(world: World, rng: Draw) -> Effect:
    return Effect(
        "load_dependence", "adhesion_and_amontons", 0.3, 1.0, contact=lambda c, s: _both_levels(c, 1 + s * (_pressed(c, world) - 1))
    )


@form("load_dependence", "saturating")
def _(world: World, rng: Draw) -> Effect:
    bend = float(rng.uniform(0.5, 1.5))

    def act(c: Contact, s: float) -> None:
        n = _pressed(c, world)
        _both_levels(c, (1 - s) + s * (1 + bend) * n / (1 + bend * n))

    return Effect("load_dependence", "saturating", 0.3, 1.0, contact=act)


# presliding, rest, state


def _part_plastic(plastic: Callable[[Array], Array]) -> Callable[[Contact, float], None]:
    """s: how far the bristles' yielding is from LuGre's towards elasto-plastic yielding."""

    def act(c: Contact, s: float) -> None:
        c.gate = lambda r: 1 - s * (1 - plastic(r))

    return act


@form("elasto_plastic", "cubic")
def _(world: World, rng: Draw) -> Effect:
    """Elastic up to a share of the steady deflection, then smoothly more plastic."""
    at = float(rng.uniform(0.2, 0.8))

    def plastic(r: Array) -> Array:
        u = np.clip((r - at) / (1 - at), 0.0, 1.0)
        return np.asarray(u * u * (3 - 2 * u))

    return Effect("elasto_plastic", "cubic", 0.3, 1.0, contact=_part_plastic(plastic))


@form("elasto_plastic", "abrupt")
def _(world: World, rng: Draw) -> Effect:
    at, width = float(rng.uniform(0.3, 0.9)), float(rng.uniform(0.05, 0.1))
    return Effect("elasto_plastic", "abrupt", 0.3, 1.0, contact=_part_plastic(lambda r: np.clip((r - at) / width, 0.0, 1.0)))


def _rested(c: Contact, world: World, slip: float) -> Array:
    """Age of the contact over the period of the motion."""
    d_c = slip * c.F_C / c.sigma0
    return np.maximum(contact_age(c.drive, d_c, 1e2), 0.0) / (200 * c.drive.every * c.drive.h)


@form("dwell_strengthening", "power")
def _(world: World, rng: Draw) -> Effect:
    power, slip = float(rng.uniform(0.2, 0.45)), float(rng.uniform(1.0, 4.0))

    def act(c: Contact, s: float) -> None:
        c.F_S *= 1 + s * _rested(c, world, slip) ** power

    return Effect("dwell_strengthening", "power", 0.3, 3.0, contact=act)


@form("dwell_strengthening", "saturating")
def _(world: World, rng: Draw) -> Effect:
    slip, half = float(rng.uniform(1.0, 4.0)), float(rng.uniform(0.3, 2.0))

    def act(c: Contact, s: float) -> None:
        age = _rested(c, world, slip)
        c.F_S *= 1 + s * age / (half + age)

    return Effect("dwell_strengthening", "saturating", 0.3, 3.0, contact=act)


@form("rate_and_state", "slip_law")
def _(world: World, rng: Draw) -> Effect:
    d_c, direct = float(rng.uniform(3.0, 30.0)), float(rng.uniform(0.3, 0.8))

    def act(c: Contact, s: float) -> None:
        length, fast = d_c * c.F_C / c.sigma0, float(world.notes["fast"])
        theta = contact_age(c.drive, length, 1e2, slip_law=True)
        speed = np.maximum(np.abs(c.drive.v), 1e-3 * fast)
        _both_levels(c, 1 + s * (direct * np.log(speed / fast) + np.log(np.clip(theta * fast / length, 1e-3, 1e3))))

    return Effect("rate_and_state", "slip_law", 0.05, 0.2, contact=act)


@form("rate_and_state", "two_lengths")
def _(world: World, rng: Draw) -> Effect:
    d_c, direct, apart = float(rng.uniform(3.0, 15.0)), float(rng.uniform(0.3, 0.8)), float(rng.uniform(3.0, 8.0))

    def act(c: Contact, s: float) -> None:
        length, fast = d_c * c.F_C / c.sigma0, float(world.notes["fast"])
        speed = np.maximum(np.abs(c.drive.v), 1e-3 * fast)
        ages = [np.log1p(contact_age(c.drive, q * length, 1e2) * fast / (q * length)) for q in (1.0, apart)]
        _both_levels(c, 1 + s * (direct * np.log(speed / fast) + 0.6 * ages[0] + 0.4 * ages[1]))

    return Effect("rate_and_state", "two_lengths", 0.05, 0.2, contact=act)


def _sliders(share: Array, reach: Array) -> Callable[[Contact, float], None]:
    """Elastic sliders beside the contact: each yields after its reach (in steady deflections)."""

    def act(c: Contact, s: float) -> None:
        def force(c: Contact) -> Array:
            moved = np.diff(c.drive.x, axis=0, prepend=c.drive.x[:1])
            unit, length = c.F_C[0], c.F_C[0] / c.sigma0[0]
            limit = s * share[:, None] * unit
            K = limit / (reach[:, None] * length)
            f, out = np.zeros_like(limit), np.zeros_like(c.drive.x)
            for k in range(out.shape[0]):
                f = np.clip(f + K * moved[k], -limit, limit)
                out[k] = f.sum(axis=0)
            return out

        c.elements.append(force)

    return act


@form("maxwell_slip", "exponential_reach")
def _(world: World, rng: Draw) -> Effect:
    reach = np.geomspace(1.0, float(rng.uniform(10, 40)), 6)
    return Effect("maxwell_slip", "exponential_reach", 0.2, 3.0, contact=_sliders(np.full(6, 1 / 6), reach))


@form("maxwell_slip", "iwan")
def _(world: World, rng: Draw) -> Effect:
    """Iwan's continuous distribution, in ten elements with a power of the reach."""
    reach = np.linspace(1.0, float(rng.uniform(8, 30)), 10)
    share = reach ** float(rng.uniform(-0.5, 0.5))
    return Effect("maxwell_slip", "iwan", 0.2, 3.0, contact=_sliders(share / share.sum(), reach))


# distance and place


@form("friction_wear", "root")
def _(world: World, rng: Draw) -> Effect:
    way = float(rng.choice([-1.0, 1.0]))

    def act(c: Contact, s: float) -> None:
        far = float(np.max(c.drive.distance))
        _both_levels(c, 1 + way * s * np.sqrt(c.drive.distance / far))

    return Effect("friction_wear", "root", 0.15, 0.8, contact=act)


@form("friction_wear", "run_in")
def _(world: World, rng: Draw) -> Effect:
    """A logistic change with the logarithm of the distance."""
    at, way = float(rng.uniform(0.1, 0.4)), float(rng.choice([-1.0, 1.0]))

    def act(c: Contact, s: float) -> None:
        u = c.drive.distance / float(np.max(c.drive.distance)) / at
        _both_levels(c, 1 + way * s * u**1.5 / (1 + u**1.5))

    return Effect("friction_wear", "run_in", 0.15, 0.8, contact=act)


def _span(world: World) -> float:
    return float(np.max(np.ptp(world.conditions.x, axis=0)))


@form("position_dependence", "additive_harmonics")
def _(world: World, rng: Draw) -> Effect:
    pitch, phases, second = _span(world) / float(rng.uniform(1.5, 6.0)), rng.uniform(0, 2 * np.pi, 2), float(rng.uniform(0.2, 0.6))
    unit = world.params["F_C"]

    def act(c: Contact, s: float) -> None:
        u = 2 * np.pi * c.drive.x / pitch
        c.added += s * unit * (np.sin(u + phases[0]) + second * np.sin(2 * u + phases[1]))

    return Effect("position_dependence", "additive_harmonics", 0.1, 1.5, contact=act)


@form("position_dependence", "ball_pass")
def _(world: World, rng: Draw) -> Effect:
    pitch, phase = _span(world) / float(rng.uniform(1.5, 6.0)), float(rng.uniform(0, 2 * np.pi))
    return Effect(
        "position_dependence",
        "ball_pass",
        0.1,
        0.8,
        contact=lambda c, s: _both_levels(c, 1 + s * np.sin(2 * np.pi * c.drive.x / pitch + phase)),
    )


# what the contact sees of the recorded motion


def played(x: Array, width: float) -> Array:
    """Where the far side of a play of that width stands."""
    y, half = np.empty_like(x), width / 2
    y[0] = x[0]
    for k in range(1, x.shape[0]):
        y[k] = np.clip(y[k - 1], x[k] - half, x[k] + half)
    return y


def _loose(soft: float) -> Callable[[World, Drive, float], Drive]:
    def act(world: World, d: Drive, s: float) -> Drive:
        width = s * _span(world)
        x = played(d.x, width)
        x = relaxed(x, float(world.notes["fast"]) / (soft * width + 1e-9 * _span(world)), d.h)
        return replace(d, x=x, v=d.v + np.gradient(x - d.x, d.h, axis=0))

    return act


@form("backlash", "hard")
def _(world: World, rng: Draw) -> Effect:
    return Effect("backlash", "hard", 0.02, 0.5, motion=_loose(0.1))


@form("backlash", "cushioned")
def _(world: World, rng: Draw) -> Effect:
    return Effect("backlash", "cushioned", 0.02, 0.5, motion=_loose(float(rng.uniform(0.5, 1.5))))


def _samples(d: Drive, s: float) -> float:
    return s * d.every


@form("input_delay", "pure")
def _(world: World, rng: Draw) -> Effect:
    """The record's velocity is late: the contact is ahead of it."""

    def act(world: World, d: Drive, s: float) -> Drive:
        return replace(d, v=shifted(d.v, -_samples(d, s)), x=shifted(d.x, -_samples(d, s)))

    return Effect("input_delay", "pure", 3.0, 25.0, least=2.0, motion=act)


@form("input_delay", "filtered")
def _(world: World, rng: Draw) -> Effect:
    """Late and smoothed: the contact is ahead, and sharper by what the filter takes (its inverse to first order)."""
    part = float(rng.uniform(0.2, 0.5))

    def act(world: World, d: Drive, s: float) -> Drive:
        v = shifted(d.v, -_samples(d, s) * (1 - part))
        v = v + part * s * d.every * d.h * np.gradient(v, d.h, axis=0)
        return replace(d, v=v, x=np.cumsum(v, axis=0) * d.h)

    return Effect("input_delay", "filtered", 3.0, 25.0, least=2.0, motion=act)
