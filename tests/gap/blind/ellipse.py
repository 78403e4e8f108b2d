"""How does an elliptically vibrating tool cut? Entry, exit and thickness over the surface that the cycle before has left, by looking it up.

The path is x = v_c t + a cos(w t + phase_x), y = b cos(w t + phase_y), x along the cut, y away from the surface, and may be disturbed:
other amplitudes, another phase, a shaken centre, a nominal surface that rises and falls. The surface that is left is the height at which
the tool has passed a place on its way forward in the cycle before, tabulated along that way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from law import normal_force
from radau import Array, settle
from scene import Scene, Signal, entries, fine_grid, nodes
from scipy import signal
from world import Cause, World

Draw = np.random.Generator
PHASE_X, PHASE_Y = -np.pi / 2, np.pi  # the bottom of the path at time 0
TABLE = 1501  # places along a way forward


def _nothing(t: Array) -> Array:
    return np.zeros_like(t)


def _one(t: Array) -> Array:
    return np.ones_like(t)


@dataclass(frozen=True)
class Path:
    """values: of the process, SI. grown_x, grown_y: scale of the amplitudes; d_x, d_y and rates: of the centre; raised: of the surface."""

    values: Mapping[str, float]
    phase_y: float = PHASE_Y
    grown_x: Signal = _one
    grown_y: Signal = _one
    d_x: Signal = _nothing
    d_y: Signal = _nothing
    rate_x: Signal = _nothing
    rate_y: Signal = _nothing
    raised: Signal = _nothing

    @property
    def omega(self) -> float:
        return 2 * np.pi * self.values["vibration_frequency"]

    def place(self, t: Array) -> tuple[Array, Array]:
        p, w = self.values, self.omega
        x = p["cutting_speed"] * t + p["amplitude_x"] * self.grown_x(t) * np.cos(w * t + PHASE_X) + self.d_x(t)
        y = p["amplitude_y"] * self.grown_y(t) * np.cos(w * t + self.phase_y) + self.d_y(t)
        return x, y

    def velocity(self, t: Array) -> tuple[Array, Array]:
        p, w = self.values, self.omega
        u_x = p["cutting_speed"] - w * p["amplitude_x"] * self.grown_x(t) * np.sin(w * t + PHASE_X) + self.rate_x(t)
        u_y = -w * p["amplitude_y"] * self.grown_y(t) * np.sin(w * t + self.phase_y) + self.rate_y(t)
        return u_x, u_y

    def approach(self, t: Array) -> Array:
        u_x, u_y = self.velocity(t)
        rake = self.values["rake_angle"]
        return np.asarray(u_x * np.cos(rake) + u_y * np.sin(rake))

    def surfaces(self, end: float) -> Callable[[Array], Array]:
        """Thickness at any times from 0 to `end`."""
        p, f, w = self.values, self.values["vibration_frequency"], self.omega
        nominal = p["feed"] - p["amplitude_y"]
        last = float(np.arccos(-min(p["cutting_speed"] / (p["amplitude_x"] * w), 1.0)))
        along = last * np.sin(np.linspace(-np.pi / 2, np.pi / 2, TABLE))
        count = int(np.ceil(end * f)) + 2
        ways = []
        for n in range(-1, count):
            t = (n + along / (2 * np.pi)) / f
            x, y = self.place(t)
            ways.append((np.maximum.accumulate(x), y))

        def thickness(t: Array) -> Array:
            x, y = self.place(t)
            top = nominal + self.raised(t)
            cycle = np.floor(f * t + 0.5).astype(int)
            for n in np.unique(cycle).tolist():
                here = np.flatnonzero(cycle == n)
                reach, height = ways[min(max(n, 0), len(ways) - 1)]
                left = np.interp(x[here], reach, height)
                top[here] = np.where(x[here] < reach[-1], np.minimum(top[here], left), top[here])
            return np.asarray(top - y)

        return thickness


def built(path: Path, times: Array, every: int, signals: Mapping[str, Signal], conditions: Mapping[str, float], theta: Signal | None,
          principle: str, source: str) -> EllipseScene:  # fmt: skip
    """The scene of a path. theta: the proxy where it is a signal; else source says what it is taken from."""
    p = path.values
    thickness = path.surfaces(float(times[-1]))

    def contact(t: Array) -> Array:
        return np.minimum(thickness(t), path.approach(t) * 1e-6)

    grid = fine_grid(times, every)
    at, on = entries(grid, contact)
    width, t = nodes(grid, at)
    flat = t.ravel()
    u_x, u_y = path.velocity(flat)
    h, approach, rake = thickness(flat), path.approach(flat), p["rake_angle"]
    v = approach * np.tan(p["chip_flow_shear_angle"] - rake) + u_x * np.sin(rake) - u_y * np.cos(rake)
    k = p["shear_stress"] * p["width"] * np.maximum(h, 0.0)
    given = theta(flat) if theta else np.full(flat.size, p["cutting_speed"]) if source == "cutting_speed" else np.abs(v)
    shape = t.shape
    return EllipseScene(
        times=times, every=every, width=width, t=t, v=v.reshape(shape), h=h.reshape(shape), theta=given.reshape(shape),
        load=normal_force(np.zeros(flat.size), k, rake, principle).reshape(shape), u_y=u_y.reshape(shape), approach=approach.reshape(shape),
        on=np.stack([on, on], axis=1), fresh=~np.isnan(at), values=dict(conditions), signals=dict(signals), path=path, theta_signal=theta,
        principle=principle, source=source,
    )  # fmt: skip


@dataclass(frozen=True)
class EllipseScene(Scene):
    """A scene that knows its path, and so can be walked again on another."""

    path: Path = Path({})
    theta_signal: Signal | None = None
    principle: str = ""
    source: str = ""

    def on_path(self, path: Path) -> EllipseScene:
        return built(path, self.times, self.every, self.signals, self.values, self.theta_signal, self.principle, self.source)


def _between(grid: Array, values: Array) -> Signal:
    return lambda t: np.interp(t, grid, values)


def _own(scene: Scene) -> EllipseScene:
    if not isinstance(scene, EllipseScene):
        raise TypeError("only an ellipse has a path")
    return scene


def ellipse_phase_error(world: World, rng: Draw) -> Cause:
    squeeze = float(rng.uniform(-0.15, 0.15))

    def tilt(_: World, scene: Scene, s: float) -> Scene:
        own = _own(scene)
        return own.on_path(replace(own.path, phase_y=own.path.phase_y + s, grown_y=lambda t: np.full_like(t, 1 + squeeze * abs(s))))

    return Cause("ellipse_phase_error", 0.08, 0.5, {"squeeze": squeeze}, both_ways=True, path=tilt)


def run_out(world: World, rng: Draw) -> Cause:
    span = max(float(scene.times[-1]) for scene in world.scenes)
    frequency, phase = float(rng.uniform(1.6, 5.0)) / span, float(rng.uniform(0, 2 * np.pi))
    second, unit = float(rng.uniform(0.05, 0.22)), min(_own(scene).path.values["feed"] for scene in world.scenes)

    def wobble(_: World, scene: Scene, s: float) -> Scene:
        def raised(t: Array) -> Array:
            turn = 2 * np.pi * frequency * t + phase
            return s * unit * (np.sin(turn) + second * np.sin(2 * turn + 0.7))

        own = _own(scene)
        return own.on_path(replace(own.path, raised=raised))

    return Cause("run_out", 0.1, 0.7, {"frequency": frequency, "phase": phase, "second": second, "unit": unit}, path=wobble)


def amplitude_loss(world: World, rng: Draw) -> Cause:
    unit = float(np.mean([np.mean(world.forces(scene, world.values, (), world.form)["principal_force"]) for scene in world.scenes]))
    slow, less = float(rng.uniform(2.0, 8.0)), float(rng.uniform(0.6, 1.0))

    def shrink(world: World, scene: Scene, s: float) -> Scene:
        own, now = _own(scene), _own(scene)
        T = slow / own.path.values["vibration_frequency"]
        for _ in range(5):
            force = world.forces(now, world.values, (), world.form)["principal_force"]
            if world.means:
                felt = np.full(force.size, world.mean(now, force))
            else:
                rate = np.full(now.t.shape, 1 / T)
                width = np.diff(now.grid, prepend=now.grid[0])
                felt = settle(width, rate, np.stack([force, force], axis=1) / T, 0.0)[:, 1]
            grown = 1 / (1 + s * felt / unit)
            now = own.on_path(replace(own.path, grown_y=_between(now.grid, grown), grown_x=_between(now.grid, 1 - less * (1 - grown))))
        return now

    return Cause("amplitude_loss", 0.1, 0.6, {"unit": unit, "slow": slow, "less": less}, path=shrink)


def holder_compliance(world: World, rng: Draw) -> Cause:
    span = min(float(scene.times[-1]) for scene in world.scenes)
    frequency = min(float(rng.uniform(1.0, 2.5)) / span, 4000.0)
    split, damping, lean = float(rng.uniform(1.0, 1.25)), float(rng.uniform(0.015, 0.08)), float(rng.uniform(0.5, 1.5))
    path = _own(world.scenes[0]).path.values
    unit = path["amplitude_y"] / (path["shear_stress"] * path["width"] * path["feed"])

    def give_way(world: World, scene: Scene, s: float) -> Scene:
        own, now = _own(scene), _own(scene)
        for _ in range(6):
            forces = world.forces(now, world.values, (), world.form)
            moved = []
            for force, softness, f in (
                (-forces["principal_force"], s * unit, frequency),
                (forces["feed_force"], s * unit * lean, frequency * split),
            ):
                w = 2 * np.pi * f
                b, a, _dt = signal.cont2discrete(([w * w], [1.0, 2 * damping * w, w * w]), now.fine, method="foh")
                q = softness * signal.lfilter(np.ravel(b), a, force)
                moved += [q, np.gradient(q, now.grid)]
            d_x, rate_x, d_y, rate_y = (_between(now.grid, q) for q in moved)
            now = own.on_path(replace(own.path, d_x=d_x, rate_x=rate_x, d_y=d_y, rate_y=rate_y))
        return now

    shape = {"frequency": frequency, "split": split, "damping": damping, "lean": lean, "unit": unit}
    most = min(1.0, 1.5e-7 / (unit * max(lean, 1.0)))  # softer ones would not hold a tool
    return Cause("holder_compliance", min(0.1, most), most, shape, path=give_way)


PATH = {make.__name__: make for make in (ellipse_phase_error, run_out, amplitude_loss, holder_compliance)}
