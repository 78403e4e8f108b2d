"""What happens on rigs that no effect of the library is? Kinds of unknown, each as forces beside those of the contact, trial by trial."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .drive import Array, Channels

Draw = np.random.Generator


@dataclass(frozen=True)
class Seen:
    """What one trial goes through, at its samples. place: of its condition, of so many; values: of the condition; unit: rms of a force."""

    t: Array
    v: Array
    x: Array
    forces: Channels
    place: int
    places: int
    values: dict[str, float]
    unit: dict[str, float]
    travel: float
    fast: float
    frequency: float


Unknown = Callable[[Draw, Seen, float], Channels]  # the trial's numbers, the trial, the strength: what comes beside the forces
KINDS: dict[str, tuple[tuple[str, ...], bool, Callable[[Draw], Unknown]]] = {}  # name: worlds, whether kept, maker


def kind(worlds: str, *, kept: bool) -> Callable[[Callable[[Draw], Unknown]], Callable[[Draw], Unknown]]:
    def enter(make: Callable[[Draw], Unknown]) -> Callable[[Draw], Unknown]:
        KINDS[make.__name__] = (tuple(worlds.split()), kept, make)
        return make

    return enter


def _all(seen: Seen, shape: Array, s: float) -> Channels:
    """The same shape on all channels, by their sizes."""
    return {name: s * unit * shape for name, unit in seen.unit.items()}


def _way(seen: Seen) -> Array:
    return np.asarray(np.tanh(seen.v / (0.02 * seen.fast)))


@kind("rig axis", kept=False)
def deposit_sawtooth(rng: Draw) -> Unknown:
    """A built-up layer grows with the slip and tears off: irregular saw teeth, nowhere the same in two trials."""
    length = float(rng.uniform(0.08, 0.3))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        slid = np.cumsum(np.abs(np.diff(seen.x, prepend=seen.x[0])))
        ends = np.cumsum(length * seen.travel * rng.uniform(0.4, 1.8, 4000))
        ends = ends[: int(np.searchsorted(ends, slid[-1])) + 1]
        begins = np.concatenate([[0.0], ends])
        k = np.searchsorted(ends, slid, side="right")
        top = rng.uniform(0.5, 1.3, begins.size)
        tooth = (slid - begins[k]) / np.diff(np.concatenate([begins, [begins[-1] + length * seen.travel]]))[k] * top[k]
        return _all(seen, tooth * _way(seen), s)

    return act


@kind("rig axis", kept=False)
def adhesion_spikes(rng: Draw) -> Unknown:
    """Short spikes at random instants, the more the slower the slip."""
    often, wide = float(rng.uniform(0.004, 0.015)), float(rng.uniform(2, 6))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        slow = np.exp(-np.abs(seen.v) / (0.3 * seen.fast))
        hit = (rng.random(seen.t.size) < often * slow / max(float(np.mean(slow)), 1e-3)) * rng.exponential(1.0, seen.t.size)
        tail = np.exp(-np.arange(int(8 * wide)) / wide)
        return _all(seen, np.convolve(hit, tail)[: seen.t.size] * np.sign(seen.v), 3 * s)

    return act


@kind("rig axis", kept=False)
def table_jump(rng: Draw) -> Unknown:
    """The level of the force jumps once within some trials, up or down, at no repeatable time, and stays."""
    share = float(rng.uniform(0.5, 0.9))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        at, jump = rng.uniform(0.15, 0.85) * seen.t[-1], rng.choice([-1, 1]) * rng.uniform(0.6, 1.4) * (rng.random() < share)
        return _all(seen, jump * (seen.t > at), 1.5 * s)

    return act


@kind("rig axis", kept=False)
def wandering_level(rng: Draw) -> Unknown:
    """Starved lubrication: the friction level wanders by itself, in no two trials alike."""
    turns = float(rng.uniform(2, 6))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        knots = np.cumsum(rng.standard_normal(int(4 * turns))) / np.sqrt(turns)
        level = np.interp(np.linspace(0, 1, seen.t.size), np.linspace(0, 1, knots.size), knots - knots.mean())
        return _all(seen, level * _way(seen), s)

    return act


@kind("rig axis ellipse", kept=False)
def chatter_burst(rng: Draw) -> Unknown:
    """Bursts of a vibration whose frequency glides while it grows and dies."""
    cycles, glide = float(rng.uniform(9, 25)), float(rng.uniform(0.05, 0.3))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        u = (seen.t - seen.t[0]) / (seen.t[-1] - seen.t[0])
        shape = np.zeros_like(u)
        for _ in range(int(rng.integers(1, 4))):
            at, wide, ph = rng.uniform(0.1, 0.9), rng.uniform(0.05, 0.2), rng.uniform(0, 2 * np.pi)
            shape += np.exp(-(((u - at) / wide) ** 2)) * np.sin(2 * np.pi * cycles * (u + glide * (u - at) ** 2 / wide) + ph)
        return _all(seen, shape, 2 * s)

    return act


@kind("ellipse", kept=False)
def serration(rng: Draw) -> Unknown:
    """Segments of the chip: teeth in the force while it cuts, at a frequency by the speed and with phases of their own each time."""
    per_cycle = float(rng.uniform(6, 14))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        name = next(iter(seen.forces))
        cutting = np.abs(seen.forces[name]) > 0.05 * np.max(np.abs(seen.forces[name]))
        begins = np.cumsum(np.diff(cutting.astype(int), prepend=0) == 1)
        phases = rng.uniform(0, 2 * np.pi, int(begins.max()) + 1)
        rate = per_cycle * seen.frequency * (0.6 + 0.4 * seen.values.get("cutting_speed", 1.0) / seen.fast)
        tooth = np.mod(rate * seen.t + phases[begins] / (2 * np.pi), 1.0) - 0.5
        return {n: s * 3 * unit * tooth * cutting * (1.0 if k == 0 else 0.5) for k, (n, unit) in enumerate(seen.unit.items())}

    return act


@kind("means", kept=False)
def speed_resonance(rng: Draw) -> Unknown:
    """A narrow band of cutting speeds in which the machine resonates and forces rise."""
    at, wide = float(rng.uniform(0.25, 0.7)), float(rng.uniform(0.03, 0.08))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        u = seen.values["cutting_speed"] / seen.fast
        return _all(seen, np.array([1 / (1 + ((u - at * 0.6) / wide) ** 2)]), 2 * s)

    return act


@kind("means", kept=False)
def batch_difference(rng: Draw) -> Unknown:
    """Some conditions were cut in another bar of the material."""
    which = rng.random(100) < 0.4

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        return {name: s * 1.5 * float(which[seen.place]) * force for name, force in seen.forces.items()}

    return act


@kind("rig axis", kept=True)
def acceleration_force(rng: Draw) -> Unknown:
    """A film that is squeezed: a force by the acceleration, against closing more than against opening."""
    lean = float(rng.uniform(0.2, 0.8))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        a = np.gradient(seen.v, seen.t)
        a = a / (np.sqrt(np.mean(a**2)) + 1e-300)
        return _all(seen, a + lean * np.abs(a), s)

    return act


@kind("rig axis", kept=True)
def end_stop(rng: Draw) -> Unknown:
    """A wiper or stop near the end of the travel pushes back, by the square of how far it is pressed."""
    from_, way = float(rng.uniform(0.6, 0.85)), float(rng.choice([-1.0, 1.0]))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        middle = 0.5 * (seen.x.max() + seen.x.min())
        u = way * (seen.x - middle) / (0.5 * np.ptp(seen.x) + 1e-300)
        return _all(seen, way * np.maximum(u - from_, 0.0) ** 2 / (1 - from_) ** 2, 3 * s)

    return act


@kind("rig axis", kept=True)
def two_branches(rng: Draw) -> Unknown:
    """Friction jumps down above one speed and comes back only below another: two states of the film."""
    up, down = float(rng.uniform(0.5, 0.7)), float(rng.uniform(0.15, 0.35))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        speed, low, on = np.abs(seen.v) / np.max(np.abs(seen.v)), np.zeros(seen.v.size), False
        for k, u in enumerate(speed.tolist()):
            on = u > up if not on else u > down
            low[k] = float(on)
        return _all(seen, -low * _way(seen), 2 * s)

    return act


@kind("rig axis ellipse", kept=True)
def clipped_amplifier(rng: Draw) -> Unknown:
    """The amplifier gives in softly above a level, in one direction only."""
    way = float(rng.choice([-1.0, 1.0]))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        out = {}
        for name, force in seen.forces.items():
            side = way * force
            if not np.any(side > 0):
                side = -side
            limit = np.max(np.abs(force)) * max(1 - s, 0.05)
            over = np.maximum(side - limit, 0.0)
            out[name] = np.sign(force) * -over * (0.8 * over / (over + 0.1 * limit))
        return out

    return act


@kind("rig axis", kept=True)
def inclusions(rng: Draw) -> Unknown:
    """Hard spots in the track: narrow bumps at a few places, met in both directions and in all trials, each by another height."""
    at, wide = rng.uniform(0.05, 0.95, 4), float(rng.uniform(0.015, 0.04))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        u = np.mod(seen.x / seen.travel, 1.0)
        shape = sum(h * np.exp(-(((u - q) / wide) ** 2)) for q, h in zip(at, rng.uniform(0.5, 1.5, 4), strict=True))
        return _all(seen, np.asarray(shape) * _way(seen), 3 * s)

    return act


@kind("rig axis ellipse", kept=True)
def rattle(rng: Draw) -> Unknown:
    """Something loose is hit at random instants and rings out."""
    ring, fade = float(rng.uniform(8, 20)), float(rng.uniform(10, 30))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        hits = (rng.random(seen.t.size) < 8.0 / seen.t.size) * rng.uniform(0.4, 1.6, seen.t.size) * rng.choice([-1, 1], seen.t.size)
        k = np.arange(int(6 * fade))
        return _all(seen, np.convolve(hits, np.exp(-k / fade) * np.sin(2 * np.pi * k / ring))[: seen.t.size], 5 * s)

    return act


@kind("ellipse", kept=True)
def period_doubling(rng: Draw) -> Unknown:
    """Every other cycle cuts more, which of the two is left to chance."""

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        cycle = np.floor(seen.frequency * seen.t + 0.5).astype(int)
        way = np.where((cycle + int(rng.integers(2))) % 2 == 0, 1.0, -1.0)
        return {name: s * way * force for name, force in seen.forces.items()}

    return act


@kind("rig axis", kept=True)
def belt_resonance(rng: Draw) -> Unknown:
    """A belt's teeth excite its own vibration: a line by the speed, large only where it meets the belt's frequency."""
    teeth, at, wide = float(rng.uniform(12, 30)), float(rng.uniform(0.3, 0.7)), float(rng.uniform(0.06, 0.15))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        u = np.abs(seen.v) / seen.fast
        met = 1 / (1 + ((u - at) / wide) ** 2)
        return _all(seen, met * np.sin(2 * np.pi * teeth * seen.x / seen.travel + rng.uniform(0, 2 * np.pi)), 2 * s)

    return act


@kind("means", kept=True)
def feed_speed_bump(rng: Draw) -> Unknown:
    """A built-up edge that lives only at middle speeds: forces fall there and come back, more in the feed direction."""
    at, wide = float(rng.uniform(0.15, 0.35)), float(rng.uniform(0.08, 0.15))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        u = seen.values["cutting_speed"] / seen.fast
        dip = -float(np.exp(-(((u - at) / wide) ** 2)))
        return {name: np.array([s * (1.0 if k else 0.4) * unit * 1.5 * dip]) for k, (name, unit) in enumerate(seen.unit.items())}

    return act


@kind("means", kept=True)
def day_drift(rng: Draw) -> Unknown:
    """The order of the tests counts: forces swing through the day."""
    turns, phase = float(rng.uniform(0.7, 1.6)), float(rng.uniform(0, 2 * np.pi))

    def act(rng: Draw, seen: Seen, s: float) -> Channels:
        u = float(np.sin(2 * np.pi * turns * seen.place / seen.places + phase))
        return {name: s * u * force for name, force in seen.forces.items()}

    return act
