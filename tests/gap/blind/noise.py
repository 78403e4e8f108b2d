"""What does a real sensor add? Coloured noise within a trial, and from trial to trial another gain, another zero, another delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from radau import Array
from scipy import signal
from world import Channels, World

Draw = np.random.Generator


@dataclass(frozen=True)
class Noise:
    """rms: per channel [N]; poles: of the autoregression; jitter: standard deviations between trials (gain 1, zero N, delay s);
    tail: degrees of freedom of Student's t, 0 for a normal law; outliers: share of samples that are far off."""

    rms: dict[str, float]
    poles: tuple[float, float]
    jitter: dict[str, float]
    tail: float = 0.0
    outliers: float = 0.0

    @property
    def memory(self) -> float:
        """Sum of the autocorrelations at lags 1, 2, ..."""
        return float(np.sum(self._correlation(400)[1:]))

    def _correlation(self, count: int) -> Array:
        impulse = signal.lfilter([1.0], self.polynomial, np.r_[1.0, np.zeros(2000)])
        full = np.correlate(impulse, impulse, "full")[impulse.size - 1 :]
        correlation: Array = full[:count] / full[0]
        return correlation

    @property
    def polynomial(self) -> list[float]:
        a, b = self.poles
        return [1.0, -(a + b), a * b]

    def draw(self, rng: Draw, count: int) -> Array:
        """`count` samples of rms 1, settled."""
        lead = 300
        white = (
            rng.standard_t(self.tail, count + lead) / np.sqrt(self.tail / (self.tail - 2))
            if self.tail
            else rng.standard_normal(count + lead)
        )
        impulse = signal.lfilter([1.0], self.polynomial, np.r_[1.0, np.zeros(2000)])
        coloured: Array = signal.lfilter([1.0], self.polynomial, white)[lead:] / np.sqrt(np.sum(impulse**2))
        if self.outliers:
            hit = rng.random(count) < self.outliers
            coloured = coloured + hit * rng.choice([-1, 1], count) * rng.uniform(5, 12, count)
        return coloured

    def spoil(self, rng: Draw, times: Array, clean: Channels) -> Channels:
        """One trial as it is recorded."""
        late = float(rng.normal(0, self.jitter["delay"]))
        recorded = {}
        for name, force in clean.items():
            gain, zero = 1 + float(rng.normal(0, self.jitter["gain"])), float(rng.normal(0, self.jitter[f"zero {name}"]))
            moved = np.interp(times - late, times, force) if times.size == force.size and times.size > 1 else force
            recorded[name] = gain * moved + zero + self.rms[name] * self.draw(rng, force.size)
        return recorded


def usual(rng: Draw, world: World, forces: list[Channels], rms: dict[str, float]) -> Noise:
    """Colour, and scatter between trials that is a share of the noise."""
    jitter = {}
    force = {name: np.concatenate([part[name] for part in forces]) for name in world.channels}
    ratio = min(rms[name] / max(float(np.sqrt(np.mean(force[name] ** 2))), 1e-12) for name in world.channels)
    jitter["gain"] = float(ratio * rng.uniform(0.05, 0.4))
    for name in world.channels:
        jitter[f"zero {name}"] = float(rms[name] * rng.uniform(0.03, 0.3))
    delays = []
    for scene, part in zip(world.scenes, forces, strict=True):
        for name in world.channels:
            if part[name].size > 2:
                slope = float(np.sqrt(np.mean(np.gradient(part[name], scene.times) ** 2)))
                delays.append(rms[name] / max(slope, 1e-300))
    jitter["delay"] = float(min(delays) * rng.uniform(0.02, 0.3)) if delays else 0.0
    a = float(rng.uniform(0.0, 0.75))
    b = float(rng.uniform(-0.3, 0.5))
    tail = float(rng.choice([0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 3.0]))
    outliers = float(rng.choice([0.0] * 12 + [0.005, 0.02]))
    return Noise(rms, (a, b), jitter, tail, outliers)
