"""How does a host take a contact through model exchange? By a solver of its own, event by event."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from driving import PERIOD, read
from evat.native import kernel
from evat.native.kernel import Contact
from scipy.integrate import solve_ivp


def put(contact: Contact, time: float, names: Sequence[str], states: np.ndarray) -> None:
    contact.time = time
    for name, value in zip(names, states, strict=True):
        contact.set(name, float(value))


def exchange(contact: Contact, duration: float, rtol: float, on: Sequence[str] = (), step: float = PERIOD / 100) -> None:
    """What a host does: integrate the derivatives by Radau between events, act on each, stop where an averaging window ends.

    The states are those of the contact and of the effects `on`."""
    end = contact.time + duration
    states = [name for name in kernel.states() if "." not in name or name.partition(".")[0] in on]
    rate_of = {variable.derivative_of: variable.name for variable in kernel.variables()}
    scale = np.array([kernel.variable(name).nominal for name in states])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        put(contact, t, states, y * scale)
        contact.evaluate()
        return np.asarray(read(contact, *(rate_of[name] for name in states)) / scale)

    def crossing(place: int) -> Callable[[float, np.ndarray], float]:
        def indicator(t: float, y: np.ndarray) -> float:
            put(contact, t, states, y * scale)
            return float(contact.indicators()[place])

        indicator.terminal = True  # type: ignore[attr-defined]
        return indicator

    watched = [crossing(place) for place in range(len(contact.indicators()))]
    for _ in range(500):
        if contact.time >= end - 1e-12 * duration:
            return
        y, stop = read(contact, *states) / scale, min(end, contact.next_event())
        solution = solve_ivp(rates, (contact.time, stop), y, "LSODA", rtol=rtol, atol=rtol * 1e-4, events=watched, max_step=step)
        assert solution.success
        past = 1e-12 * PERIOD if solution.status == 1 else 0  # a host stops just past a crossing, never just before it
        t, y = solution.t[-1], solution.y[:, -1]
        put(contact, t + past, states, (y + past * rates(t, y)) * scale)
        contact.event()
    raise AssertionError("more events than a few cycles can have")
