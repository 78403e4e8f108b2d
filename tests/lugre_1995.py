"""What did LuGre show in 1995, in numbers? The plants around the friction and what is read off their motion.

Canudas de Wit, Olsson, Astrom and Lischinsky, A New Model for Control of Systems with Friction, IEEE Transactions on Automatic Control
40 (1995), sections IV and V. The reference numbers are Radau's at a relative tolerance of 1e-8, printed to four digits. The kernel and
every FMU are held to this one list. A door gives `friction(t, v, z) -> (F, dz/dt)`, or steps through the plant by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi

import numpy as np
from scipy.integrate import solve_ivp

# The forces are those of a block on a table: the contact never opens, and the damping is the published one.
DRIVEN_FROM_OUTSIDE: Mapping[str, str | float] = {
    "kinematics": "external",
    "uncut_thickness": 1e-4,
    "friction_law": "lugre",
    "damping_mode": "as_published",
}

PRESLIDING = 4.481e-5  # m
BREAK_AWAY = {0.1: 1.485, 1: 1.432, 2: 1.394, 5: 1.313, 10: 1.220, 20: 1.099, 30: 1.025, 40: 1.004, 50: 1.008}  # N/s: N
LAG = {1: (1.1816, 1.1872), 10: (1.1610, 1.2150), 25: (1.1379, 1.2454)}  # rad/s: N falling, N rising through 1 mm/s
STICK_SLIP = {"period": 6.363, "v_max": 0.370, "F_max": 1.477}  # s, m/s, N
HUNTING = {"lowest": 0.936, "highest": 1.064, "period": 24.44}  # m, m, s

# Half a unit of the last digit printed; the break-away forces were rounded twice (1.02448 to 1.0245 to 1.025).
TOLERANCE = {"presliding": 5e-9, "break_away": 5.5e-4, "lag": 5e-5, "ms": 5e-4, "hunting_period": 1e-2}

Friction = Callable[[float, float, float], tuple[float, float]]


@dataclass(frozen=True)
class Plant:
    """y' = rates(t, y, F) with the position y[0] [m], where there is a state; the body slips at velocity(t, y) [m/s]."""

    start: Sequence[float]
    rates: Callable[[float, Sequence[float], float], Sequence[float]]
    velocity: Callable[[float, Sequence[float]], float]
    times: np.ndarray  # where the motion is looked at [s]


@dataclass(frozen=True)
class Motion:
    t: np.ndarray
    x: np.ndarray
    v: np.ndarray
    F: np.ndarray


def pushed_mass(push: Callable[[float, float], float], times: np.ndarray) -> Plant:
    """1 kg under push(t, x) and friction."""
    return Plant((0, 0), lambda t, y, F: (y[1], push(t, y[0]) - F), lambda t, y: y[1], times)


def presliding_plant() -> Plant:
    """95 % of the break-away force, reached in 5 s: a ramp that gives the printed number (one of 2 s rounds to it too)."""
    return pushed_mass(lambda t, x: 0.285 * t, np.linspace(0, 5, 501))


def break_away_plant(rate: float) -> Plant:
    return pushed_mass(lambda t, x: rate * t, np.linspace(0, 2 / rate, 8001))


def lag_plant(w: float) -> Plant:
    """Two cycles for the bristles to forget their start, then the two passages through 1 mm/s, where cos(w t) = -1/2."""

    def velocity(t: float, y: Sequence[float]) -> float:
        return 1e-3 * (1.5 + cos(w * t))

    return Plant((), lambda t, y, F: (), velocity, np.array([0, 4 * pi + 2 * pi / 3, 4 * pi + 4 * pi / 3]) / w)


def stick_slip_plant(stop: float = 28) -> Plant:
    """Pulled at 0.1 m/s by a spring of 2 N/m."""
    return pushed_mass(lambda t, x: 2 * (0.1 * t - x), np.linspace(0, stop, round(2000 * stop) + 1))


def servo_plant(stop: float = 125) -> Plant:
    """1 kg sent to x = 1 m by PID: Kp 3, Ki 4 on the error, Kv 6 on the velocity."""
    return Plant(
        (0, 0, 0),
        lambda t, y, F: (y[1], -6 * y[1] - 3 * (y[0] - 1) - 4 * y[2] - F, y[0] - 1),
        lambda t, y: y[1],
        np.linspace(0, stop, round(200 * stop) + 1),
    )


def follow(plant: Plant, friction: Friction) -> Motion:
    """The motion by LSODA at 1e-9, the bristle one of its states: what a host of a Model Exchange FMU does."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        F, dz = friction(t, plant.velocity(t, y), y[-1])
        return [*plant.rates(t, y, F), dz]

    scales = [1e-4] * len(plant.start) + [1e-6]
    solution = solve_ivp(rates, (0, plant.times[-1]), (*plant.start, 0), "LSODA", plant.times, rtol=1e-9, atol=np.multiply(scales, 1e-9))
    assert solution.success, solution.message
    v = np.array([plant.velocity(t, y) for t, y in zip(solution.t, solution.y.T, strict=True)])
    F = np.array([friction(t, speed, z)[0] for t, speed, z in zip(solution.t, v, solution.y[-1], strict=True)])
    return Motion(solution.t, solution.y[0] if plant.start else np.full(v.shape, np.nan), v, F)


def crossings(t: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Times at which the signal rises through 0."""
    i = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    return t[i] - signal[i] * (t[i + 1] - t[i]) / (signal[i + 1] - signal[i])


def presliding(motion: Motion) -> float:
    return float(motion.x[-1])


def break_away(motion: Motion) -> float:
    """The first local maximum of the friction force; later it rises again by viscosity."""
    F = motion.F
    return float(F[1:-1][(F[1:-1] > F[:-2]) & (F[1:-1] >= F[2:])][0])


def lag(motion: Motion) -> tuple[float, float]:
    return float(motion.F[1]), float(motion.F[2])


def stick_slip(motion: Motion) -> dict[str, float]:
    slips = crossings(motion.t, motion.v - 0.05)
    later = motion.t > slips[0] - 1
    return {"period": float(np.diff(slips).mean()), "v_max": float(motion.v[later].max()), "F_max": float(motion.F[later].max())}


def hunting(motion: Motion) -> dict[str, float]:
    """Once the first swings, which are longer and shorter, have died out."""
    late = motion.t > 70
    t, x = motion.t[late], motion.x[late]
    return {"lowest": float(x.min()), "highest": float(x.max()), "period": float(np.diff(crossings(t, x - 1)).mean())}
