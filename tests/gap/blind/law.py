"""Which force does the benchmark's contact answer with? Bristles, shear plane and both angle principles, in the right and in wrong forms.

The right form is the law that the nominal model has (Canudas de Wit et al. 1995; Merchant 1945). A wrong form differs in what a user of the
model would not know: how the Stribeck curve falls, how sharply contact begins, how bristles yield.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from radau import Array, linear, marched
from scene import Flags, Scene

Values = Mapping[str, float]
Gate = Callable[[float, float, float], float]  # of deflection, slip velocity and steady deflection


@dataclass(frozen=True)
class Form:
    """The base law's form. stribeck: fall of the static force over x = |v|/v_s, blended with the right one; soft_contact [m]: thickness
    over which the bristles get hold of the chip; soft_reversal: share of v_s below which the yielding is slower than |v|."""

    right: bool = True
    stribeck: str = "gauss"
    exponent: float = 2.0
    blend: float = 1.0
    soft_contact: float = 0.0
    soft_reversal: float = 0.0

    def scaled(self, share: float) -> Form:
        """The same form, nearer to the right one (share < 1) or further from it."""
        return replace(self, blend=share * self.blend, soft_contact=share * self.soft_contact, soft_reversal=share * self.soft_reversal)


def fall(form: Form, x: Array) -> Array:
    """Share of F_S - F_C that is left at x = |v|/v_s."""
    gauss = np.exp(-x * x)
    return gauss if form.stribeck == "gauss" else gauss + form.blend * (_other_fall(form, x) - gauss)


def _other_fall(form: Form, x: Array) -> Array:
    if form.stribeck == "power":
        return np.exp(-(x**form.exponent))
    if form.stribeck == "hyperbola":
        return 1 / (1 + x**form.exponent)
    if form.stribeck == "sech":
        return 1 / np.cosh(np.minimum(form.exponent * x, 300.0))
    raise ValueError(form.stribeck)


@dataclass
class Fields:
    """What effects may act upon, each of the shape of Scene.v. extra: friction force beside the bristles'; edge: forces in feed and
    principal direction; z_gate: how the yielding depends on the deflection, None for a law that is linear in it."""

    scene: Scene
    values: dict[str, float]
    F_C: Array
    F_S: Array
    v_s: Array
    P: Array
    s0: Array
    s1: Array
    sigma2: Array
    tau_s: Array
    extra: Array
    edge_f: Array
    edge_p: Array
    theta: Array
    z_gate: Gate | None = None


def open_fields(scene: Scene, p: Values) -> Fields:
    """The base law's fields in this scene."""

    def full(value: float) -> Array:
        return np.full(scene.v.shape, value)

    return Fields(
        scene, dict(p), full(p["F_C"]), full(p["F_S"]), full(p["v_s"]), full(p["sigma0"]), full(p["sigma0"]), full(p["sigma1"]),
        full(p["sigma2"]), full(p.get("shear_stress", 0.0)), full(0.0), full(0.0), full(0.0), scene.theta.copy(),
    )  # fmt: skip


def friction(x: Fields, form: Form) -> Array:
    """Friction force on the fine grid."""
    scene = x.scene
    speed = np.abs(scene.v)
    g = x.F_C + (x.F_S - x.F_C) * fall(form, speed / x.v_s)
    yielding = speed
    if form.soft_reversal:
        yielding = speed * np.tanh(speed / (form.soft_reversal * x.v_s))
    rate = x.P * yielding / g
    off = ~scene.on[:, 1]
    z = linear(scene.width, rate, scene.v, scene.fresh, off)[:, 1] if x.z_gate is None else _gated(x, x.z_gate, rate, g, off)
    return _force(x, form, z, rate, g)


def _force(x: Fields, form: Form, z: Array, rate: Array, g: Array) -> Array:
    scene, v = x.scene, x.scene.v[:, 1]
    a = rate[:, 1]
    if x.z_gate is not None:
        steady = g[:, 1] / x.P[:, 1]
        a = a * np.array([x.z_gate(z_k, v_k, s_k) for z_k, v_k, s_k in zip(z.tolist(), v.tolist(), steady.tolist(), strict=True)])
    dz = v - a * z
    s1 = np.minimum(x.s1[:, 1], 0.4 * g[:, 1] / x.P[:, 1] * x.s0[:, 1] / np.maximum(np.abs(v), 1e-300))
    F = x.s0[:, 1] * z + s1 * dz + x.sigma2[:, 1] * v + x.extra[:, 1]
    if form.soft_contact:
        F = F * -np.expm1(-np.maximum(scene.h[:, 1], 0.0) / form.soft_contact)
    return np.where(scene.on[:, 1], F, 0.0)


def _gated(x: Fields, gate: Gate, rate: Array, g: Array, off: Flags) -> Array:
    scene = x.scene
    before = np.concatenate([[0], np.arange(scene.v.shape[0] - 1)])

    def both_ends(a: Array) -> tuple[list[float], list[float]]:
        start = np.where(scene.fresh, a[:, 0], a[before, 1])
        return start.tolist(), (a[:, 1] - start).tolist()

    v_0, dv = both_ends(scene.v)
    a_0, da = both_ends(rate)
    s_0, ds = both_ends(g / x.P)

    def slope(k: int, share: float, z: float) -> float:
        v = v_0[k] + share * dv[k]
        return v - (a_0[k] + share * da[k]) * gate(z, v, s_0[k] + share * ds[k]) * z

    most = (6 * np.maximum(rate[:, 1], rate[before, 1])).tolist()
    return marched(scene.width.tolist(), scene.fresh.tolist(), off.tolist(), slope, most)


def normal_force(F: Array, k: Array, rake: float, principle: str) -> Array:
    """Normal force on the rake from friction F and shear load k: resultant and angles of physics section 4, by their cosines."""
    c, s = np.cos(rake), np.sin(rake)
    if principle == "maximum_shear_stress":
        return np.asarray(np.maximum((2 * k + F * (c - s)) / (c + s), 0.0))
    return np.asarray(np.maximum((2 * np.sqrt(np.maximum(k * (k + F * c), 0.0)) - (2 * k + F * c) * s) / (c * c), 0.0))


def chip_forces(x: Fields, F: Array, principle: str) -> dict[str, Array]:
    """All three forces on the fine grid."""
    scene, p = x.scene, x.values
    on, rake = scene.on[:, 1], p.get("rake_angle", 0.0)
    k = np.where(on, x.tau_s[:, 1] * p["width"] * np.maximum(scene.h[:, 1], 0.0), 0.0)
    N = normal_force(F, k, rake, principle)
    principal = N * np.cos(rake) + F * np.sin(rake) + on * x.edge_p[:, 1]
    feed = F * np.cos(rake) - N * np.sin(rake) + on * x.edge_f[:, 1]
    return {"friction_force": F, "principal_force": principal, "feed_force": feed}
