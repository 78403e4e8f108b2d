"""What can be wrong with the cut itself? Size effect, flow stress, a rounded and a worn edge, damping on the flank, in other forms."""

from __future__ import annotations

import numpy as np
from law import Fields
from world import Cause, World

Draw = np.random.Generator


def _thickness(world: World, quantile: float = 0.5) -> float:
    return float(np.quantile(np.concatenate([scene.h[:, 1][scene.on[:, 1]] for scene in world.scenes]), quantile))


def size_effect(world: World, rng: Draw) -> Cause:
    thin, kind = _thickness(world) * float(rng.uniform(0.5, 2.0)), str(rng.choice(["log", "root"]))

    def harden(x: Fields, s: float) -> None:
        h = np.maximum(x.scene.h, 1e-3 * thin)
        x.tau_s = x.tau_s * (1 + s * np.log1p(thin / h) if kind == "log" else (1 + thin / h) ** s)

    return Cause("size_effect", 0.2, 0.8, {"thin": thin, "kind": kind}, fields=harden)


def flow_stress_softening(world: World, rng: Draw) -> Cause:
    hot = float(np.quantile(np.concatenate([scene.theta[:, 1] for scene in world.scenes]), 0.9)) or 1.0
    power, kind = float(rng.uniform(0.7, 1.6)), str(rng.choice(["decay", "hyperbola"]))

    def soften(x: Fields, s: float) -> None:
        u = (x.theta / hot) ** power
        x.tau_s = x.tau_s * (np.exp(-s * u) if kind == "decay" else 1 / (1 + s * u))

    return Cause("flow_stress_softening", 0.2, 0.8, {"hot": hot, "power": power, "kind": kind}, fields=soften)


def edge_force(world: World, rng: Draw) -> Cause:
    thin, lean = _thickness(world, 0.1) * float(rng.uniform(0.02, 0.15)), float(rng.uniform(0.4, 1.6))
    unit = world.values["shear_stress"] * _thickness(world) * world.values["width"]

    def plough(x: Fields, s: float) -> None:
        hold = np.maximum(x.scene.h, 0.0) / (np.maximum(x.scene.h, 0.0) + thin)
        x.edge_f = x.edge_f + s * unit * hold
        x.edge_p = x.edge_p + s * unit * lean * hold

    return Cause("edge_force", 0.1, 0.8, {"thin": thin, "lean": lean, "unit": unit}, fields=plough)


def flank_wear(world: World, rng: Draw) -> Cause:
    far, power, lean = (
        max(float(scene.distance[-1, 1]) for scene in world.scenes),
        float(rng.uniform(0.75, 1.15)),
        float(rng.uniform(0.1, 0.5)),
    )
    unit = world.values["shear_stress"] * _thickness(world) * world.values["width"]

    def rub(x: Fields, s: float) -> None:
        u = (x.scene.distance / far) ** power
        x.edge_f = x.edge_f + s * unit * u
        x.edge_p = x.edge_p + s * unit * lean * u

    most = min(1.0, 8e6 * far * world.values["width"] / unit)  # a land cannot carry more
    return Cause("flank_wear", min(0.15, most), most, {"far": far, "power": power, "lean": lean, "unit": unit}, fields=rub)


def process_damping(world: World, rng: Draw) -> Cause:
    power, fast = float(rng.uniform(0.85, 1.25)), max(float(np.max(-scene.u_y)) for scene in world.scenes)
    unit = world.values["shear_stress"] * _thickness(world) * world.values["width"]

    def press(x: Fields, s: float) -> None:
        x.edge_f = x.edge_f + s * unit * (np.maximum(-x.scene.u_y, 0.0) / fast) ** power

    return Cause("process_damping", 0.3, 2.0, {"power": power, "fast": fast, "unit": unit}, fields=press)


CUT = {make.__name__: make for make in (size_effect, flow_stress_softening, edge_force, flank_wear, process_damping)}
