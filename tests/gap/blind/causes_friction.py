"""What can be wrong with friction? Laws of temperature, direction, load, speed, rest and wear, in forms of the benchmark's own."""

from __future__ import annotations

import numpy as np
from law import Fields, Form, fall
from radau import Array, settle
from scene import Scene
from world import Cause, World

Draw = np.random.Generator


def _typical(world: World, what: str) -> float:
    return float(np.quantile(np.concatenate([np.abs(getattr(scene, what)[:, 1]) for scene in world.scenes]), 0.9)) or 1.0


def thermal_softening(world: World, rng: Draw) -> Cause:
    hot, power, kind = _typical(world, "theta"), float(rng.uniform(0.7, 2.2)), str(rng.choice(["sink", "decay", "knee"]))

    def soften(x: Fields, s: float) -> None:
        u = (x.theta / hot) ** power
        if kind == "sink":
            x.s0 = x.s0 / (1 + s * u)
        elif kind == "decay":
            x.s0 = x.s0 * np.exp(-s * u)
        else:
            x.s0 = x.s0 * (1 - s * u / (1 + 0.6 * u))

    return Cause("thermal_softening", 0.15, 0.6, {"hot": hot, "power": power, "kind": kind}, fields=soften)


def thermal_damping(world: World, rng: Draw) -> Cause:
    hot, kind = _typical(world, "theta"), str(rng.choice(["decay", "rise"]))

    def damp(x: Fields, s: float) -> None:
        u = x.theta / hot
        x.s1 = x.s1 * (np.exp(-s * u) if kind == "decay" else (1 + s * u) / (1 + 0.3 * u))

    return Cause("thermal_damping", 0.6, 3.0, {"hot": hot, "kind": kind}, fields=damp)


def thermal_viscosity(world: World, rng: Draw) -> Cause:
    hot, kind = _typical(world, "theta"), str(rng.choice(["hyperbola", "bend"]))

    def thin(x: Fields, s: float) -> None:
        u = x.theta / hot
        x.sigma2 = x.sigma2 * (1 / (1 + s * u**1.3) if kind == "hyperbola" else 1 - 0.9 * np.tanh(s * u))

    return Cause("thermal_viscosity", 0.5, 3.0, {"hot": hot, "kind": kind}, fields=thin)


def direction_asymmetry(world: World, rng: Draw) -> Cause:
    static, sharp = float(rng.uniform(0.6, 1.4)), float(rng.uniform(0.01, 0.05))

    def lean(x: Fields, s: float) -> None:
        back = (1 - np.tanh(x.scene.v / (sharp * x.v_s))) / 2
        x.F_C = x.F_C * (1 - s * back)
        x.F_S = x.F_S * (1 - s * static * back)

    return Cause("direction_asymmetry", 0.15, 0.6, {"static": static, "sharp": sharp}, both_ways=True, fields=lean)


def load_dependence(world: World, rng: Draw) -> Cause:
    middle = float(np.mean([np.mean(scene.load[:, 1][scene.on[:, 1]]) for scene in world.scenes]))
    adhesion, kind = float(rng.uniform(0.1, 0.6)), str(rng.choice(["adhesion", "saturating"]))

    def press(x: Fields, s: float) -> None:
        n = x.scene.load / middle
        share = 1 + s * (n - 1) if kind == "adhesion" else 1 + s * (1 + adhesion) * (n / (n + adhesion) - 1 / (1 + adhesion))
        x.F_C = x.F_C * np.maximum(share, 0.02)
        x.F_S = x.F_S * np.maximum(share, 0.02)

    return Cause("load_dependence", 0.4, 0.95, {"middle": middle, "adhesion": adhesion, "kind": kind}, fields=press)


def viscous_friction(world: World, rng: Draw) -> Cause:
    fast, power = _typical(world, "v"), float(rng.uniform(0.88, 1.15))

    def thicken(x: Fields, s: float) -> None:
        x.extra = x.extra + s * x.values["F_C"] * np.sign(x.scene.v) * (np.abs(x.scene.v) / fast) ** power

    return Cause("viscous_friction", 0.2, 1.0, {"fast": fast, "power": power}, fields=thicken)


def stribeck(world: World, rng: Draw) -> Cause:
    kind, exponent = str(rng.choice(["hyperbola", "power", "sech"])), float(rng.uniform(1.0, 1.7))
    speed = world.values["v_s"] * float(rng.uniform(0.6, 1.8))

    def raise_static(x: Fields, s: float) -> None:
        more = s * x.F_C * fall(Form(stribeck=kind, exponent=exponent), np.abs(x.scene.v) / speed)
        x.F_C = x.F_C + more
        x.F_S = x.F_S + more

    return Cause("stribeck", 0.3, 1.2, {"kind": kind, "exponent": exponent, "speed": speed}, fields=raise_static)


def elasto_plastic(world: World, rng: Draw) -> Cause:
    stuck, power = float(rng.uniform(0.35, 0.8)), float(rng.uniform(2.0, 5.0))

    def hold(x: Fields, s: float) -> None:
        def gate(z: float, v: float, steady: float) -> float:
            u = z / steady if v >= 0 else -z / steady
            if u <= 0:
                return 1 - s
            if u >= 1:
                return 1.0
            w = max((u - stuck) / (1 - stuck), 0.0)
            return 1 - s * (1 - w * w * (3 - 2 * w) if power < 3.5 else (1 - w) ** 1.5)

        x.z_gate = gate

    return Cause("elasto_plastic", 0.6, 1.0, {"stuck": stuck, "power": power}, fields=hold)


def _age(scene: Scene, renewal: float) -> Array:
    """Age of the contact [s]: time since the slip that renews it, fading over that distance."""
    return settle(scene.width, np.abs(scene.v) / renewal, np.where(scene.on, 1.0, 0.0), 0.0)


def dwell_strengthening(world: World, rng: Draw) -> Cause:
    renewal = world.values["F_C"] / world.values["sigma0"] * float(rng.uniform(0.5, 3.0))
    span = max(scene.times[-1] - scene.times[0] for scene in world.scenes)
    slow, power = float(span * rng.uniform(0.01, 0.05)), float(rng.uniform(0.35, 0.8))

    def strengthen(x: Fields, s: float) -> None:
        age = np.maximum(_age(x.scene, renewal), 0.0)
        x.F_S = x.F_S * (1 + s * 2 * age**power / (age**power + slow**power))

    return Cause("dwell_strengthening", 0.4, 2.5, {"renewal": renewal, "slow": slow, "power": power}, fields=strengthen)


def friction_wear(world: World, rng: Draw) -> Cause:
    far, kind, power = (
        max(float(scene.distance[-1, 1]) for scene in world.scenes),
        str(rng.choice(["power", "hyperbola"])),
        rng.uniform(0.6, 1.0),
    )

    def drift(x: Fields, s: float) -> None:
        u = x.scene.distance / far
        share = 1 + s * (u ** float(power) if kind == "power" else 1.5 * u / (u + 0.5))
        x.F_C = x.F_C * np.maximum(share, 0.05)
        x.F_S = x.F_S * np.maximum(share, 0.05)

    return Cause("friction_wear", 0.2, 0.8, {"far": far, "kind": kind, "power": float(power)}, both_ways=True, fields=drift)


def proxy_lag(world: World, rng: Draw) -> Cause:
    span = min(scene.times[-1] - scene.times[0] for scene in world.scenes)
    second = float(rng.uniform(0.1, 0.5))

    def lag(x: Fields, s: float) -> None:
        first, scene = s * span, x.scene
        late = settle(scene.width, np.full(scene.t.shape, 1 / first), x.theta / first, 0.0)
        T = second * first
        x.theta = np.maximum(settle(scene.width, np.full(scene.t.shape, 1 / T), late / T, 0.0), 0.0)

    return Cause("proxy_lag", 0.1, 0.5, {"second": second, "span": span}, temperature=lag)


FRICTION = {
    make.__name__: make
    for make in (
        thermal_softening, thermal_damping, thermal_viscosity, direction_asymmetry, load_dependence, viscous_friction, stribeck,
        elasto_plastic, dwell_strengthening, friction_wear, proxy_lag,
    )
}  # fmt: skip
