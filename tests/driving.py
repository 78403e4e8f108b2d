"""How do the tests of laws and effects drive a contact? An ellipse or an outside drive, the events on the way, the state as numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import pi

import numpy as np
from evat.native.kernel import Contact
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Values = Mapping[str, float | str]

FREQUENCY, AMPLITUDE = 20e3, 5e-6  # Hz, m
OMEGA, PERIOD = 2 * pi * FREQUENCY, 1 / FREQUENCY
ELLIPSE: Values = {"vibration_frequency": FREQUENCY, "amplitude_x": AMPLITUDE, "amplitude_y": AMPLITUDE, "relative_tolerance": 1e-8}
OUTSIDE: Values = {"kinematics": "external", "uncut_thickness": 1e-4, "relative_tolerance": 1e-8}


def at_speed_ratio(r: float, **values: float | str) -> dict[str, float | str]:
    """A 90 degree ellipse at the speed ratio r = v_c/(a w), under a nominal surface far above."""
    return {**ELLIPSE, "cutting_speed": r * AMPLITUDE * OMEGA, "feed": 1e-2, **values}


def started(values: Values, on: tuple[str, ...] = (), time: float = 0.0) -> Contact:
    contact = Contact(values, on)
    contact.start(time)
    return contact


def read(contact: Contact, *names: str) -> np.ndarray:
    return np.array([contact.get(name) for name in names])


def events(contact: Contact, duration: float, *names: str) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    """Time of each contact event within `duration`, and the variables before and after it."""
    end = contact.time + duration
    while (left := end - contact.time) > 1e-12 * duration:
        went = contact.advance(left, stop_at_events=True)
        before = read(contact, *names)
        contact.event()
        if went < left:
            yield contact.time, before, read(contact, *names)


def at_angle(angle: float, values: Values, *names: str) -> np.ndarray:
    """Variables at the angle w t of a fresh contact, no step taken."""
    return read(started(values, time=angle / OMEGA), *names)


def slide(times: np.ndarray, speed: np.ndarray, values: Values, *names: str, on: tuple[str, ...] = ()) -> np.ndarray:
    """Variables along a slip velocity given at times, linear in between."""
    contact = started({**OUTSIDE, **values, "slip_velocity": float(speed[0])}, on, float(times[0]))
    return contact.run(times, {"slip_velocity": speed}, names)


def cycle_by_runge_kutta(values: Mapping[str, float], r: float, phi: float, angles: np.ndarray) -> np.ndarray:
    """Bristle deflection, friction impulse and energy of plain LuGre at the angles of one cut, written anew and integrated at 1e-13.

    The cut lasts from entry to exit of a 90 degree ellipse under a high nominal surface, from bristles at rest; no damping.
    """
    P, F_C, F_S, v_s, sigma2 = (values[name] for name in ("sigma0", "F_C", "F_S", "v_s", "sigma2"))
    entry = brentq(lambda angle: r * (pi + angle) + np.sin(angle), -pi * (1 - 1e-6 * r), -1e-6, xtol=1e-15)

    def rates(psi: float, y: np.ndarray) -> list[float]:
        v = AMPLITUDE * OMEGA * ((r + np.cos(psi)) * np.tan(phi) - np.sin(psi))
        g = F_C + (F_S - F_C) * np.exp(-((v / v_s) ** 2))
        F = P * y[0] + sigma2 * v
        return [(v - P * abs(v) / g * y[0]) / OMEGA, F / OMEGA, F * v / OMEGA]

    rows, y = [], np.zeros(3)
    stops = sorted({entry, float(phi + np.arcsin(r * np.sin(phi))), *angles})  # |v| has its kink where the slip reverses
    for start, stop in pairwise(stops):
        y = solve_ivp(rates, (start, stop), y, "DOP853", rtol=1e-13, atol=[1e-24, 1e-18, 1e-18], max_step=1e-2).y[:, -1]
        if stop in angles:
            rows.append(y)
    return np.array(rows)
