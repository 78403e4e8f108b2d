"""How do the tests of the effects ask? With a force that is known, by its line in a spectrum, and with a host's own integrator."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import pi

import numpy as np
from evat import kernel
from evat.kernel import Contact
from scipy.integrate import solve_ivp

Values = Mapping[str, float | str]

FREQUENCY, AMPLITUDE = 20e3, 5e-6  # Hz, m
PERIOD, FASTEST = 1 / FREQUENCY, 2 * pi * FREQUENCY * AMPLITUDE  # s, m/s
OUTSIDE: Values = {"kinematics": "external", "relative_tolerance": 1e-8}
# One newton for each m/s: Coulomb friction at the smallest that is allowed, 1e-6 N, and viscous friction beside it.
VISCOUS: Values = {"friction_law": "lugre", "F_C": 1e-6, "F_S": 1e-6, "sigma1": 0.0, "sigma2": 1.0}
# A friction force that knows nothing of speed.
CONSTANT: Values = {"friction_law": "coulomb", "F_C": 9.0}


def begun(values: Values, on: Sequence[str] = (), time: float = 0.0) -> Contact:
    contact = Contact({"relative_tolerance": 1e-8, **values}, on)
    contact.start(time)
    return contact


def read(contact: Contact, *names: str) -> np.ndarray:
    return np.array([contact.get(name) for name in names])


def course(contact: Contact, times: np.ndarray, *names: str) -> np.ndarray:
    """The variables at each of the times, shape (names, times), inputs held."""
    return contact.run(times, {}, names).T


def follow(times: np.ndarray, inputs: Mapping[str, np.ndarray], values: Values, on: Sequence[str], *names: str) -> np.ndarray:
    """The variables along inputs from outside, linear between the samples; shape (names, times)."""
    first = {name: float(column[0]) for name, column in inputs.items()}
    return begun({**OUTSIDE, **values, **first}, on, float(times[0])).run(times, inputs, names).T


def line(frequency: float, times: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Complex amplitude c of c e^(i 2 pi f t) in evenly sampled whole periods of the signal."""
    return np.asarray(2 * np.mean(signal * np.exp(-2j * pi * frequency * times), axis=-1))


def events(contact: Contact, duration: float, *names: str) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    """Time of each contact event within `duration`, and the variables before and after it."""
    end = contact.time + duration
    while (left := end - contact.time) > 1e-12 * duration:
        went = contact.advance(left, stop_at_events=True)
        before = read(contact, *names)
        contact.event()
        if went < left:
            yield contact.time, before, read(contact, *names)


def put(contact: Contact, time: float, names: Sequence[str], states: np.ndarray) -> None:
    contact.time = time
    for name, value in zip(names, states, strict=True):
        contact.set(name, float(value))


def exchange(contact: Contact, duration: float, rtol: float, on: Sequence[str], step: float = PERIOD / 100) -> None:
    """Model exchange by Radau: the contact's derivatives between its events, the states of the effects `on` among them."""
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
        found = solve_ivp(rates, (contact.time, stop), y, "Radau", rtol=rtol, atol=rtol * 1e-4, events=watched, max_step=step)
        assert found.success
        past = 1e-12 * PERIOD if found.status == 1 else 0  # a host stops just past a crossing, never just before it
        t, y = found.t[-1], found.y[:, -1]
        put(contact, t + past, states, (y + past * rates(t, y)) * scale)
        contact.event()
    raise AssertionError("more events than a few cycles can have")
