"""Which friction laws rule in the second reality? Each integrated here, over all trials at once.

LuGre: Canudas de Wit et al. 1995, as the nominal model has it, and with other forms of its parts; generalised Maxwell slip: Al-Bender,
Lampaert and Swevers 2005; Leuven: Swevers et al. 2000 with the Maxwell hysteresis of Lampaert et al. 2002; a regularised Coulomb law whose
friction lags: Hess and Soom 1990; rate and state: Dieterich 1979, Ruina 1983, on bristles that carry its strength.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from .drive import Array, Drive, relaxed

Gate = Callable[[Array], Array]  # of r = z sgn(v) / (steady deflection): how fast bristles yield, 1 for LuGre
DAMPING = 0.4  # |v| sigma1 stays below this share of the strength, as the nominal model's dissipative damping does


@dataclass
class Contact:
    """What effects may act upon before the law is integrated; every array (rows, lanes). soft: factor on the bristles' force alone."""

    drive: Drive
    F_C: Array
    F_S: Array
    v_s: Array
    sigma0: Array
    sigma1: Array
    sigma2: Array
    soft: Array
    strength: Array  # factor on the steady friction of any law
    added: Array  # friction force beside the law's
    tau: Array | None = None  # shear stress
    edge_p: Array | None = None
    edge_f: Array | None = None
    gate: Gate | None = None
    elements: list[Callable[[Contact], Array]] = field(default_factory=list)  # forces in parallel, integrated beside the law


@dataclass(frozen=True)
class Law:
    """A base law and the numbers of its form. `share` of it acts beside 1 - share of LuGre: contacts in parallel."""

    name: str
    form: Mapping[str, float] = field(default_factory=dict)
    share: float = 1.0


def friction(c: Contact, law: Law) -> Array:
    """Friction force of the contact (rows, lanes)."""
    force = LAWS[law.name](c, law.form)
    if law.share < 1 and law.name != "lugre":
        force = law.share * force + (1 - law.share) * lugre(c, {})
    for element in c.elements:
        force = force + element(c)
    force = force + c.added
    return force if c.drive.held is None else force * (c.drive.held > 0)


def strength(c: Contact, form: Mapping[str, float] | None = None) -> Array:
    """Steady friction without its viscous part."""
    form = form or {}
    r = np.abs(c.drive.v) / c.v_s
    fall = 1 / (1 + r ** form["hyperbola"]) if "hyperbola" in form else np.exp(-(r ** form.get("stribeck", 2.0)))
    return (c.F_C + (c.F_S - c.F_C) * fall) * c.strength


def bristles(c: Contact, g: Array, gate: Gate | None = None) -> Array:
    """sigma0 z + sigma1 dz/dt of dz/dt = v - gate sigma0 |v| z / g, by exponentials over steps in which v and the rate run straight."""
    d = c.drive
    rate = c.sigma0 * np.abs(d.v) / g
    span = np.full_like(rate, d.h) if d.held is None else d.h * d.held
    area, moved = np.zeros_like(rate), np.zeros_like(rate)
    area[1:], moved[1:] = span[1:] * (rate[1:] + rate[:-1]) / 2, span[1:] * (d.v[1:] + d.v[:-1]) / 2
    z = np.zeros_like(rate)
    if gate is None and c.gate is None:
        kept = np.exp(-area)
        gained = moved * np.where(area > 1e-8, -np.expm1(-area) / np.maximum(area, 1e-300), 1 - area / 2)
        if d.held is not None:
            kept = kept * (d.held >= 1)  # let go at separation
            gained = gained * (d.held > 0)
        for k in range(1, z.shape[0]):
            z[k] = kept[k] * z[k - 1] + gained[k]
        yielding = rate
    else:
        z, yielding = _gated(c, area, moved, rate, g, gate)
    sliding = d.v - yielding * z
    damping = np.minimum(c.sigma1, DAMPING * g * c.soft / np.maximum(np.abs(d.v), 1e-300))
    force = c.sigma0 * c.soft * z + damping * sliding
    return force if d.held is None else force * (d.held > 0)


def _gated(c: Contact, area: Array, moved: Array, rate: Array, g: Array, gate: Gate | None) -> tuple[Array, Array]:
    """Yielding that depends on the deflection: a step with the gate at its start, and again with that at its middle."""
    both = [one for one in (gate, c.gate) if one is not None]
    most, way = g / c.sigma0, np.sign(c.drive.v)
    held = np.ones_like(rate) if c.drive.held is None else c.drive.held

    def yielding(r: Array) -> Array:
        stiffness = both[0](r)
        for more in both[1:]:
            stiffness = stiffness * more(r)
        return np.minimum(np.maximum(stiffness, 0.0), 20.0)

    per_z = way / most

    def at(z: Array, k: int) -> Array:
        return yielding(z * per_z[k])

    z = np.zeros_like(rate)
    for k in range(1, z.shape[0]):
        old = z[k - 1] * (held[k] >= 1)
        middle = old + 0.5 * (moved[k] - area[k] * at(old, k) * old)
        a = area[k] * at(np.minimum(np.maximum(middle, -1.2 * most[k]), 1.2 * most[k]), k)
        z[k] = old * np.exp(-a) + moved[k] * np.where(a > 1e-8, -np.expm1(-a) / np.maximum(a, 1e-300), 1 - a / 2)
    z *= held > 0
    return z, rate * yielding(z * per_z)


def _viscous(c: Contact, form: Mapping[str, float]) -> Array:
    v, power = c.drive.v, form.get("viscous", 1.0)
    if power == 1.0:
        return c.sigma2 * v
    most = np.max(np.abs(v))
    return c.sigma2 * np.sign(v) * np.abs(v / most) ** power * most


def lugre(c: Contact, form: Mapping[str, float]) -> Array:
    """form: stribeck (exponent) or hyperbola, viscous (exponent), presliding (power of Dahl's approach)."""
    p = form.get("presliding", 1.0)
    gate: Gate | None = None if p == 1.0 else lambda r: np.maximum(np.abs(r), 1e-6) ** (p - 1)
    return bristles(c, strength(c, form), gate) + _viscous(c, form)


def _maxwell(count: int, spread: float) -> tuple[Array, Array]:
    """Shares of the strength and of the stiffness of elements that yield one after the other."""
    strong = np.linspace(1.0, 1.0 + spread, count)
    stiff = np.geomspace(1.0, 1.0 / (1 + 3 * spread), count)
    return strong / strong.sum(), stiff / stiff.sum()


def generalised_maxwell_slip(c: Contact, form: Mapping[str, float]) -> Array:
    """form: count, spread, attraction (distance over which a slipping element reaches its strength, in steady deflections)."""
    share, stiff = _maxwell(int(form["count"]), form["spread"])
    d, s = c.drive, strength(c)
    moved = np.zeros_like(s)
    moved[1:] = d.h * (d.v[1:] + d.v[:-1]) / 2
    if d.held is not None:
        moved *= d.held
    way = np.sign(d.v)
    f = np.zeros((share.size, d.lanes))
    slipping = np.zeros_like(f, dtype=bool)
    force = np.zeros_like(s)
    for k in range(1, s.shape[0]):
        slipping &= way[k] == way[k - 1]
        limit = share[:, None] * s[k]
        tried = f + stiff[:, None] * c.sigma0[k] * moved[k]
        over = tried * way[k] > limit
        kept = np.exp(-np.abs(moved[k]) * c.sigma0[k] / (form["attraction"] * s[k]))
        f = np.where(slipping, way[k] * limit + (f - way[k] * limit) * kept, np.where(over, way[k] * limit, tried))
        slipping |= over
        if d.held is not None:
            f = f * (d.held[k] > 0)
            slipping &= d.held[k] > 0
        force[k] = f.sum(axis=0)
    return force * c.soft + _viscous(c, {})


def leuven(c: Contact, form: Mapping[str, float]) -> Array:
    """form: count, spread, power n of the transition. dz/dt = v (1 - sgn(r) |r|^n), r = F_h(z)/s(v), F_h a Maxwell hysteresis in z."""
    share, stiff = _maxwell(int(form["count"]), form["spread"])
    d, s, n = c.drive, strength(c), form["power"]
    weight = np.max(s, axis=0) * share[:, None] * 1.02
    moved = np.zeros_like(s)
    moved[1:] = d.h * (d.v[1:] + d.v[:-1]) / 2
    if d.held is not None:
        moved *= d.held
    f, force, rate = np.zeros((share.size, d.lanes)), np.zeros_like(s), np.zeros_like(s)
    for k in range(1, s.shape[0]):
        K = stiff[:, None] * c.sigma0[k]
        total = f.sum(axis=0)
        r = np.clip(total * np.sign(moved[k]) / s[k], -3.0, 3.0)
        free = np.sum(K * (np.abs(f) < weight * 0.999), axis=0)
        bend = 1 + np.abs(moved[k]) * n * np.abs(r) ** (n - 1) * free / s[k]  # linearly implicit: stiff at speed
        dz = moved[k] * (1 - np.sign(r) * np.abs(r) ** n) / bend
        f = np.clip(f + K * dz, -weight, weight)
        if d.held is not None:
            f = f * (d.held[k] > 0)
        force[k], rate[k] = f.sum(axis=0), dz / d.h
    damping = np.minimum(c.sigma1, DAMPING * s * c.soft / np.maximum(np.abs(d.v), 1e-300))
    friction = force * c.soft + damping * rate
    return (friction if d.held is None else friction * (d.held > 0)) + _viscous(c, {})


def lagged_coulomb(c: Contact, form: Mapping[str, float]) -> Array:
    """form: lag (of the time in which the fastest motion crosses the presliding distance), sharp (of v_s), quick (by acceleration).

    A curve over velocity that is smooth at zero, followed late, and the less late the more the motion is accelerated.
    """
    d, s = c.drive, strength(c, {"hyperbola": 2.0})
    v = d.v
    smooth = 2 / np.pi * np.arctan(v / (form["sharp"] * c.v_s)) * s
    acceleration = np.abs(np.gradient(v, d.h, axis=0))
    usual = np.sqrt(np.mean(acceleration**2, axis=0)) + 1e-300
    time = form["lag"] * c.F_C / c.sigma0 / np.max(np.abs(v))
    rate = (1 + form["quick"] * acceleration / usual) / time
    force = relaxed(smooth, rate, d.h) * c.soft
    return (force if d.held is None else force * (d.held > 0)) + _viscous(c, {})


def contact_age(drive: Drive, d_c: Array | float, steady: float = 1e3, *, slip_law: bool = False) -> Array:
    """theta of Dieterich's ageing law d theta/dt = 1 - |v| theta/d_c, or of Ruina's slip law; before the record as at its first speed."""
    speed = np.abs(drive.v)
    if slip_law:
        target = np.log(d_c / np.maximum(speed, np.max(speed) / steady))
        return np.exp(relaxed(target, np.maximum(speed, 1e-300) / d_c, drive.h))
    theta = np.empty_like(speed)
    theta[0] = np.broadcast_to(d_c, speed.shape)[0] / np.maximum(speed[0], np.max(speed) / steady)
    area = np.zeros_like(speed)
    area[1:] = drive.h * (speed[1:] + speed[:-1]) / 2 / np.broadcast_to(d_c, speed.shape)[1:]
    kept = np.exp(-area)
    grown = drive.h * np.where(area > 1e-8, -np.expm1(-area) / np.maximum(area, 1e-300), 1 - area / 2)
    for k in range(1, speed.shape[0]):
        theta[k] = theta[k - 1] * kept[k] + grown[k]
    return theta


def rate_and_state(c: Contact, form: Mapping[str, float]) -> Array:
    """form: direct (a over b), d_c (in steady deflections), fast (V_0 in v_s). b is set by F_S/F_C.

    Strength F_C (1 + a ln(1 + |v|/V_1) + b ln(1 + V_0 theta/d_c)), V_1 a hundredth of v_s: the logarithms are cut off where they end.
    """
    d, d_c, V_0 = c.drive, form["d_c"] * c.F_C / c.sigma0, form["fast"] * c.v_s
    b = np.maximum(c.F_S / c.F_C - 1, 0.02) / np.log(1 + 10 * form["fast"])
    theta = contact_age(d, d_c)
    level = 1 + form["direct"] * b * np.log1p(np.abs(d.v) / (0.01 * c.v_s)) + b * np.log1p(V_0 * theta / d_c)
    return bristles(c, c.F_C * level * c.strength) + _viscous(c, {})


LAWS: dict[str, Callable[[Contact, Mapping[str, float]], Array]] = {
    "lugre": lugre, "lugre_variant": lugre, "lugre_presliding": lugre, "generalised_maxwell_slip": generalised_maxwell_slip,
    "leuven": leuven, "lagged_coulomb": lagged_coulomb, "rate_and_state": rate_and_state,
}  # fmt: skip


def drawn_form(name: str, rng: np.random.Generator) -> dict[str, float]:
    """The numbers of a law's form, within what is published."""
    u = rng.uniform
    if name == "lugre_variant":  # Bo and Pavelescu 1982: exponents of 0.5 to 1; Tustin 1; hyperbolas: Armstrong-Helouvry et al. 1994
        fall = [{"stribeck": u(0.6, 1.3)}, {"hyperbola": u(1.0, 2.0)}, {"stribeck": u(2.6, 4.0)}][int(rng.integers(3))]
        return {**fall, "viscous": u(0.6, 1.4)}
    if name == "lugre_presliding":  # Dahl 1976: 0.5 to 2
        return {"presliding": float(rng.choice([u(1.5, 2.2), u(0.55, 0.8)])), "stribeck": u(1.0, 2.0)}
    if name == "generalised_maxwell_slip":
        return {"count": int(rng.integers(4, 9)), "spread": u(1.0, 4.0), "attraction": u(0.05, 0.5)}
    if name == "leuven":
        return {"count": int(rng.integers(4, 9)), "spread": u(1.0, 4.0), "power": u(1.0, 2.5)}
    if name == "lagged_coulomb":
        return {"lag": u(0.5, 3.0), "sharp": u(0.1, 0.4), "quick": u(0.2, 2.0)}
    if name == "rate_and_state":
        return {"direct": u(0.3, 0.9), "d_c": u(1.5, 8.0), "fast": u(1.0, 5.0)}
    return {}
